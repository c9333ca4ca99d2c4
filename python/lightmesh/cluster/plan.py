"""The order of the tasks of a job, from its frames to its light mesh and its pictures. An executor runs them.

For each level of the meshes (there is one, unless they are refined):

1. demand: which mesh points the samples of some waves read, those of a picture with one sample per pixel;
2. gather: rays from some points of the indirect mesh, and which points of both meshes their hits read. Those that are
   new are gathered for in their turn, until there are none;
3. fill: some points of the direct mesh;
4. bounce k: what arrives at some points of the indirect mesh after k reflections, of which it needs what arrives at
   all of them after k - 1; so there is a barrier before each.

Then the pictures: waves of samples and, once a frame has all of them, those of the pixels on outlines of lamps. What
comes before is for speed alone: what the mesh lacks is filled by whoever reads it, and is the same.
"""

import hashlib
import json
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy

from lightmesh._native import Image, LightMesh, join_bricks, subtract_bricks
from lightmesh.cluster.partition import count_points, cut_bricks, cut_waves
from lightmesh.cluster.job_store import JobStore
from lightmesh.cluster.job import Pictures
from lightmesh.cluster.timings import Timings
from lightmesh.cluster.task import Array, Executor, Result, Shared, Task, size_of
from lightmesh.errors import OptionError

#: stage, tasks that are done, tasks that are known so far, rays of finished waves.
Report = Callable[[str, int, int, int], object]


@dataclass
class _Group:
    """Points of the indirect mesh that are gathered for together."""

    name: str
    label: str
    bricks: Array
    home: str | None = None

    @property
    def points(self) -> int:
        """How many there are."""
        return count_points(self.bricks)


class Plan:
    """A job that is being done."""

    def __init__(
        self,
        pictures: Pictures,
        job: Shared,
        executor: Executor,
        *,
        tasks_per_stage: int,
        folder: JobStore | None = None,
        report: Report | None = None,
    ) -> None:
        """pictures, job: of the same job, here and for the workers."""
        self.timings = Timings()
        self._pictures, self._job, self._executor = pictures, job, executor
        self._tasks_per_stage, self._folder = tasks_per_stage, folder
        self._report = report or (lambda stage, done, total, rays: None)
        self._waves = [pictures[frame].wave_count for frame in range(len(pictures))]
        # What is known of the mesh
        self._contents: list[Shared] = []
        self._direct, self._indirect = join_bricks([]), join_bricks([])
        self._levels: list[list[Result]] = []
        self._done, self._total, self._rays = 0, 0, 0

    def fill(self) -> None:
        """Fills the mesh for all frames."""
        picture = self._pictures.any()
        if not self._pictures.job.has_mesh:
            return
        self._levels = [[] for _ in range(picture.bounces + 1)]
        for level in range(picture.level_count):
            direct, indirect = self._demand(level)
            groups: list[_Group] = []
            if picture.has_indirect:
                groups, more = self._gather(indirect)
                direct = join_bricks([direct, more])
            self._fill_direct(direct)
            self._bounce(groups)

    def absorb(self) -> None:
        """Adds everything that workers have filled to the mesh of this process."""
        for contents in self._contents:
            for part in self._executor.fetch(contents):
                self._pictures.any().absorb(part)

    @property
    def mesh(self) -> LightMesh:
        """The mesh of this process."""
        mesh = self._pictures.mesh
        if mesh is None:
            raise OptionError("method: standard and path have no mesh")
        return mesh

    def pictures(self) -> Iterator[tuple[int, Image]]:
        """The frames, each as soon as it is done."""
        queue = deque(self._wave_task("waves", *part) for part in cut_waves(self._waves, self._tasks_per_stage))
        missing = dict(enumerate(self._waves))
        portions: dict[int, list[Result]] = {frame: [] for frame in missing}
        outlines: dict[int, tuple[Any, list[Result]]] = {}
        for task, result, _ in self._finish("render", queue):
            frame, first, last = task.arguments
            missing[frame] -= last - first
            if task.kind == "outlines":
                outlines[frame][1].append(result)
            else:
                portions[frame].append(result)
                if missing[frame] == 0 and (found := self._pictures[frame].outlines(portions[frame])) is not None:
                    # Take the pixels on outlines of lamps again
                    outlines[frame] = found, []
                    seen, missing[frame] = found
                    shared = (self._share(found, seen.nbytes),)
                    parts = cut_waves([missing[frame]], self._tasks_per_stage)
                    more = [self._wave_task("outlines", frame, a, b, shared) for _, a, b in parts]
                    self._total += len(more)
                    queue.extendleft(reversed(more))
            if missing[frame] == 0:
                again, anew = outlines.pop(frame, (None, []))
                picture = self._pictures[frame]
                yield frame, picture.assemble(portions.pop(frame), outlines=again, outline_portions=anew)

    def _wave_task(self, kind: Any, frame: int, first: int, last: int, shared: tuple[Shared, ...] = ()) -> Task:
        name = f"frame {frame} {kind} {first}-{last - 1}"
        key, count = f"{kind}-{frame}-{first}-{last}", last - first
        return Task(kind, name, key, (frame, first, last), count, count, tuple(self._contents), shared)

    def _demand(self, level: int) -> tuple[Array, Array]:
        contents = tuple(self._contents)
        sketches = [self._pictures.sketch(frame).wave_count for frame in range(len(self._pictures))]
        tasks = [
            Task(
                "demand",
                f"frame {frame} demand of waves {first}-{last - 1}",
                f"demand-{level}-{frame}-{first}-{last}",
                (frame, first, last),
                last - first,
                last - first,
                contents,
            )
            for frame, first, last in cut_waves(sketches, self._tasks_per_stage)
        ]
        results = [result for _, result, _ in self._finish("demand", deque(tasks))]
        direct, indirect = (join_bricks([result[mesh] for result in results]) for mesh in ("direct", "indirect"))
        return direct, indirect

    def _gather(self, wanted: Array) -> tuple[list[_Group], Array]:
        """Gathers for points and for those that they want in their turn; the groups, and what they want of the direct
        mesh."""
        groups: list[_Group] = []
        direct: list[Array] = []
        new = subtract_bricks(wanted, self._indirect)
        while len(new):
            self._indirect = join_bricks([self._indirect, new])
            more = {name: _Group(name, label, part) for name, label, part in self._cut(new)}
            tasks = [
                Task(
                    "gather",
                    f"gather {group.label}",
                    f"gather-{group.name}",
                    (group.name, group.bricks),
                    group.points,
                    len(group.bricks),
                )
                for group in more.values()
            ]
            indirect: list[Array] = []
            for task, result, node in self._finish("gather", deque(tasks)):
                more[task.arguments[0]].home = node
                direct.append(result["direct"])
                indirect.append(result["indirect"])
            groups += more.values()
            new = subtract_bricks(join_bricks(indirect), self._indirect)
        return groups, join_bricks(direct)

    def _fill_direct(self, wanted: Array) -> None:
        new = subtract_bricks(wanted, self._direct)
        self._direct = join_bricks([self._direct, new])
        contents = tuple(self._contents)
        tasks = [
            Task("fill", f"fill {label}", f"fill-{name}", (part,), count_points(part), len(part), contents)
            for name, label, part in self._cut(new)
        ]
        self._add_contents([result["contents"] for _, result, _ in self._finish("fill", deque(tasks))])

    def _bounce(self, groups: Sequence[_Group]) -> None:
        if not groups:
            return
        contents = tuple(self._contents)
        below: list[Shared] = []
        filled: list[Array] = []
        # Groups of one node shall not stand in a row: all nodes begin at once
        ordered = _in_turn(groups)
        for k in range(len(self._levels)):
            is_last = k + 1 == len(self._levels)
            tasks = [
                Task(
                    "bounce",
                    f"bounce {k} {group.label}",
                    f"bounce-{k}-{group.name}",
                    (group.name, group.bricks, k, is_last),
                    group.points,
                    len(group.bricks),
                    contents,
                    tuple(below),
                    group.home,
                )
                for group in ordered
            ]
            for _, result, _ in self._finish(f"bounce {k}", deque(tasks)):
                self._levels[k].append({"points": result["points"], "values": result["values"]})
                if is_last:
                    filled.append(result["contents"])
            if not is_last:
                level = _join_level(self._levels[k])
                below.append(self._share(level, size_of(level)))
        self._add_contents(filled)

    def _add_contents(self, parts: list[Array]) -> None:
        """Shares filled points with all workers."""
        if parts:
            self._contents.append(self._share(parts, sum(part.nbytes for part in parts)))

    def _share(self, value: Any, size: int) -> Shared:
        note = self.timings.share(size)
        if self._folder is not None:
            self._folder.note(note)
        return self._executor.share(value, size)

    def _cut(self, bricks: Array) -> Iterator[tuple[str, str, Array]]:
        """Cuts bricks into groups. Yields for each a unique name, a label for people, and its bricks."""
        for part in cut_bricks(bricks, self._tasks_per_stage):
            name = hashlib.sha256(part.tobytes()).hexdigest()[:20]
            first, last = (int(word) & 0xFFFFFFFF for word in (part[0, 0], part[-1, 0]))
            yield name, f"bricks {first}-{last}", part

    def _finish(self, stage: str, queue: deque[Task]) -> Iterator[tuple[Task, Result, str | None]]:
        """Runs the tasks of a queue, to which more may be added meanwhile. Yields each with its result and its node.

        A task whose result the job folder has is not run again."""
        self._total += len(queue)
        folder = self._folder
        found: deque[Task] = deque()

        def next_task() -> Task | None:
            while queue:
                task = queue.popleft()
                if folder is None or not folder.has(task):
                    return task
                found.append(task)
            return None

        def stored() -> Iterator[tuple[Task, Result, str | None]]:
            while folder is not None and found:
                task = found.popleft()
                result = folder.read(task)
                if result is None:
                    queue.append(task)
                else:
                    self._count(stage, result)
                    yield task, result, None

        self._report(stage, self._done, self._total, self._rays)
        with self.timings.stage(stage) as beginning:
            if folder is not None:
                folder.note(beginning)
            while queue:
                for task, outcome in self._executor.run(self._job, next_task):
                    entry = self.timings.add(stage, task, outcome)
                    if folder is not None:
                        folder.write(task, outcome.result)
                        folder.note(entry)
                    self._count(stage, outcome.result)
                    yield task, outcome.result, outcome.node
                    yield from stored()
                yield from stored()

    def _count(self, stage: str, result: Result) -> None:
        self._done += 1
        if "stats" in result:
            self._rays += sum(json.loads(result["stats"])["rays"].values())
        self._report(stage, self._done, self._total, self._rays)


def _in_turn(groups: Sequence[_Group]) -> list[_Group]:
    """Sorts groups so that their homes take turns."""
    turns: dict[str | None, int] = {}
    keyed = []
    for group in groups:
        turn = turns[group.home] = turns.get(group.home, -1) + 1
        keyed.append((turn, group))
    return [group for _, group in sorted(keyed, key=lambda pair: pair[0])]


def _join_level(parts: Sequence[Result]) -> Result:
    """Joins T_k of all groups. A group whose points are all inside solids has no values, in another shape."""
    some = [part for part in parts if len(part["points"])] or parts[:1]
    return {name: numpy.concatenate([part[name] for part in some]) for name in ("points", "values")}
