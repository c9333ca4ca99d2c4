"""Time, memory and bytes of a job, task by task."""

import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from lightmesh.cluster.task import Outcome, Task


class Timings:
    """Seconds, bytes and nodes of the tasks of a job."""

    def __init__(self) -> None:
        self.tasks: list[dict[str, Any]] = []
        """One entry for each task, in the order in which they ended."""
        self.stage_seconds: list[tuple[str, float]] = []
        """The stages in their order, and how long each lasted."""
        self.shared_bytes: list[tuple[str, int]] = []
        """What was shared after a stage, for all workers."""
        self._started = self._ended = time.perf_counter()
        self._stage, self._barrier = "", 0

    @contextmanager
    def stage(self, stage: str) -> Iterator[dict[str, Any]]:
        """Counts the time of a stage that begins behind a barrier. Yields the log entry for its beginning."""
        started = time.perf_counter()
        self._stage, self._barrier = stage, self._barrier + 1
        # Since the last one nothing was done but here
        yield {"stage": stage, "barrier": self._barrier, "between_seconds": started - self._ended}
        self._ended = time.perf_counter()
        self.stage_seconds.append((stage, self._ended - started))

    def add(self, stage: str, task: Task, outcome: Outcome) -> dict[str, Any]:
        """Adds a task; returns its log entry."""
        entry = {
            "stage": stage,
            "barrier": self._barrier,
            "task": task.name,
            "units": task.units,
            "pieces": task.pieces,
            "node": outcome.node,
            "process": outcome.process,
            "ended": time.perf_counter() - self._started,
            "seconds": outcome.seconds,
            "processor_seconds": outcome.processor_seconds,
            "setup_seconds": outcome.setup_seconds,
            "fetch_seconds": outcome.fetch_seconds,
            "bytes_in": outcome.bytes_in,
            "bytes_out": outcome.bytes_out,
            "peak_bytes": outcome.peak_bytes,
        }
        self.tasks.append(entry)
        return entry

    def share(self, size: int) -> dict[str, Any]:
        """Adds something that was shared; returns its log entry."""
        self.shared_bytes.append((self._stage, size))
        return {"stage": self._stage, "barrier": self._barrier, "shared_bytes": size}

    def workers(self) -> list[dict[str, Any]]:
        """Sums up each worker process: its tasks, seconds and bytes, and the most memory that it had."""
        found: dict[tuple[str, int], dict[str, Any]] = {}
        for task in self.tasks:
            key = (task["node"], task["process"])
            worker = found.setdefault(key, defaultdict(float, node=key[0], process=key[1], tasks=0, peak_bytes=0))
            worker["tasks"] += 1
            worker["peak_bytes"] = max(worker["peak_bytes"], task["peak_bytes"])
            for name in ("seconds", "processor_seconds", "setup_seconds", "fetch_seconds", "bytes_in", "bytes_out"):
                worker[name] += task[name]
        return [dict(worker) for worker in found.values()]

    def summary(self) -> dict[str, Any]:
        """Sums up the job as `--stats` of a farm writes it: stages, workers, and shared bytes."""
        stages: dict[str, dict[str, Any]] = {}
        for stage, seconds in self.stage_seconds:
            entry = stages.setdefault(stage, {"stage": stage, "wall_seconds": 0.0, "tasks": 0, "task_seconds": 0.0})
            entry["wall_seconds"] += seconds
        for task in self.tasks:
            stages[task["stage"]]["tasks"] += 1
            stages[task["stage"]]["task_seconds"] += task["seconds"]
        return {
            "wall_seconds": time.perf_counter() - self._started,
            "stages": list(stages.values()),
            "workers": self.workers(),
            "shared_bytes": sum(size for _, size in self.shared_bytes),
        }
