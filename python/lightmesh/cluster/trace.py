"""The cost of a job as its folder recorded it, cut for other numbers of workers."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy

from lightmesh.cluster.task import Array


@dataclass
class Stage:
    """One stage between two barriers."""

    name: str
    units: list[float] = field(default_factory=list)
    """Of each task, in the order in which they ended."""
    seconds: list[float] = field(default_factory=list)
    """Of each task, without what other tasks of its process share."""
    pieces: int = 0
    """More tasks than that there cannot be."""
    bytes_out: list[float] = field(default_factory=list)
    """Of each task's result."""
    setups: dict[tuple[str, int], float] = field(default_factory=dict)
    """By worker process: seconds for the scene and for taking over the mesh."""
    between_seconds: float = 0.0
    """Since the stage before, of the process that hands tasks out."""
    shared_bytes: float = 0.0
    """What all workers get when the stage has ended."""
    fixed_seconds: float = 0.0
    """Of a task, however small."""

    @property
    def setup_seconds(self) -> float:
        """Of each worker, in the mean."""
        return float(numpy.mean(list(self.setups.values()))) if self.setups else 0.0

    def cut(self, tasks: int, times: float = 1.0) -> tuple[Array, Array]:
        """Seconds and bytes of so many tasks of the same size, of a stage with so many times the units.

        A part of a task takes its part of the task's time, so tasks that are uneven stay so.
        """
        bounds = numpy.concatenate(([0.0], numpy.cumsum(self.units)))
        at = numpy.linspace(0.0, bounds[-1], tasks + 1)
        own = numpy.maximum(numpy.asarray(self.seconds) - self.fixed_seconds, 0.0)

        def parts(values: Sequence[float] | Array) -> Array:
            return numpy.diff(numpy.interp(at, bounds, numpy.concatenate(([0.0], numpy.cumsum(values))))) * times

        return parts(own) + self.fixed_seconds, parts(self.bytes_out)


@dataclass
class Trace:
    """A job."""

    scene_bytes: float
    """What a worker gets before its first task."""
    stages: list[Stage]

    @staticmethod
    def read(folder: Path, by_processor: bool = False, fixed_seconds: float = 0.0) -> "Trace":
        """Reads a job folder. The job must have been done in one go.

        by_processor: take processor time for the tasks' time, where workers had one thread each on a machine that was
        busy otherwise.
        fixed_seconds: of a gather or bounce task, however small: what grows with the mesh and not with the task.
        """
        stages: list[Stage] = []
        scene_bytes = 0.0
        for line in (folder / "tasks.jsonl").read_text(encoding="utf-8").splitlines():
            entry = json.loads(line)
            if "between_seconds" in entry:
                stages.append(Stage(entry["stage"], between_seconds=entry["between_seconds"]))
                if stages[-1].name.startswith(("gather", "bounce")):
                    stages[-1].fixed_seconds = fixed_seconds
                continue
            stage = stages[-1]
            if "shared_bytes" in entry:
                stage.shared_bytes += entry["shared_bytes"]
                continue
            process = (entry["node"], entry["process"])
            stage.units.append(entry["units"])
            stage.pieces += entry["pieces"]
            seconds = entry["processor_seconds"] if by_processor else entry["seconds"]
            shared = entry["setup_seconds"] + entry["fetch_seconds"]
            share = min(1.0, shared / entry["seconds"]) if entry["seconds"] else 0.0
            stage.seconds.append(seconds * (1.0 - share))
            stage.bytes_out.append(entry["bytes_out"])
            stage.setups[process] = stage.setups.get(process, 0.0) + seconds * share
            scene_bytes = scene_bytes or entry["bytes_in"]
        return Trace(scene_bytes, stages)
