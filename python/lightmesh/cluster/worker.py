"""A worker process: runs tasks of one job, and keeps what earlier tasks have left.

The scene, the light mesh as far as it is filled and gathered points are kept from task to task. All of it can be made
again, so that a task may run in any process and again after a process has died.
"""

import os
import resource
import sys
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeAlias

from lightmesh._native import Gathering, Level, PictureJob, __version__
from lightmesh.cluster.errors import ClusterError
from lightmesh.cluster.job import Job, Pictures
from lightmesh.cluster.task import Array, Outcome, Result, Shared, Task, size_of

Fetch: TypeAlias = Callable[[Shared], Any]


def execute(job: Shared, task: Task, fetch: Fetch, node: str) -> Outcome:
    """Runs a task in this process. fetch: returns a shared value."""
    global _process
    started, processor = time.perf_counter(), time.process_time()
    if _process is None or _process.id != job.id:
        # Give the memory of another job back before this one's is taken
        _process = None
        _process = _Process(job, fetch)
    else:
        _process.begin(fetch)
    process = _process
    result = process.do(task)
    return Outcome(
        result,
        node,
        os.getpid(),
        seconds=time.perf_counter() - started,
        processor_seconds=time.process_time() - processor,
        setup_seconds=process.setup_seconds,
        fetch_seconds=process.fetch_seconds,
        bytes_in=process.bytes_in,
        bytes_out=size_of(result),
        peak_bytes=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024),
    )


def forget() -> None:
    """Gives the memory of the last job back."""
    global _process
    _process = None


@dataclass
class _Group:
    """Points of the indirect mesh that are gathered for together."""

    gathering: Gathering
    bytes: int
    levels: int = 0
    """How many of its reflections are known."""


class _Process:
    """The state of a job in this process."""

    def __init__(self, job: Shared, fetch: Fetch) -> None:
        self.id = job.id
        self._seen: set[str] = set()
        self.begin(fetch)
        with self._setting_up():
            description: Job = self._fetch(job)
            if description.version != __version__:
                raise ClusterError(f"a worker has lightmesh {__version__}, the job is of {description.version}")
            self._pictures = Pictures(description)
        self._gather_bytes = description.gather_bytes
        self._prepared: PictureJob | None = None
        self._absorbed: set[str] = set()
        self._groups: OrderedDict[str, _Group] = OrderedDict()
        self._last_level: tuple[str, Level] | None = None

    def begin(self, fetch: Fetch) -> None:
        """Resets the counters before a task."""
        self._fetch_shared = fetch
        self.setup_seconds = self.fetch_seconds = 0.0
        self.bytes_in = 0

    def do(self, task: Task) -> Result:
        """Runs a task."""
        functions: dict[str, Callable[..., Result]] = {
            "demand": self._demand,
            "gather": self._gather,
            "fill": self._fill,
            "bounce": self._bounce,
            "waves": self._waves,
            "outlines": self._outlines,
        }
        return functions[task.kind](task, *task.arguments)

    def _demand(self, task: Task, frame: int, first: int, last: int) -> Result:
        direct, indirect = self._ready(task, self._pictures.sketch(frame)).demand(first, last)
        return {"direct": direct, "indirect": indirect}

    def _gather(self, task: Task, name: str, bricks: Array) -> Result:
        direct, indirect = self._group(self._ready(task), name, bricks).gathering.wanted()
        return {"direct": direct, "indirect": indirect}

    def _fill(self, task: Task, bricks: Array) -> Result:
        return {"contents": self._ready(task).fill_direct(bricks)}

    def _bounce(self, task: Task, name: str, bricks: Array, k: int, is_last: bool) -> Result:
        """T_k of a group; with the last one, the contents of the mesh there."""
        picture = self._ready(task)
        # Do what a group lacks that has been given up, or was in another process
        with self._setting_up():
            group = self._group(picture, name, bricks)
            for level in range(group.levels, k):
                self._reflect(group, task, level)
        points, values = self._reflect(group, task, k)
        result = {"points": points, "values": values}
        if is_last:
            result["contents"] = group.gathering.contents()
            del self._groups[name]
        return result

    def _reflect(self, group: _Group, task: Task, k: int) -> tuple[Array, Array]:
        """T_k of a group, of which T_{k-1} is known."""
        below = None
        if k == 0:
            group.gathering.light()
            group.bytes = group.gathering.bytes
        else:
            below = self._level(task.shared[k - 1])
        points, values = group.gathering.bounce(k, below)
        group.levels = max(group.levels, k + 1)
        return points, values

    def _level(self, shared: Shared) -> Level:
        """What arrives at all points after some reflections. Groups of a process ask for the same in a row."""
        if self._last_level is None or self._last_level[0] != shared.id:
            arrays = self._fetch(shared)
            self._last_level = shared.id, Level(arrays["points"], arrays["values"])
        return self._last_level[1]

    def _waves(self, task: Task, frame: int, first: int, last: int) -> Result:
        return self._ready(task, self._pictures[frame]).render(first, last)

    def _outlines(self, task: Task, frame: int, first: int, last: int) -> Result:
        return self._ready(task, self._pictures[frame]).render(first, last, outlines=self._fetch(task.shared[0]))

    def _ready(self, task: Task, picture: PictureJob | None = None) -> PictureJob:
        """A picture, or any where it does not matter, with all that is known of the mesh."""
        with self._setting_up():
            picture = picture or self._pictures.any()
            if picture is not self._prepared:
                picture.prepare()
                self._prepared = picture
            for contents in task.contents:
                if contents.id not in self._absorbed:
                    for part in self._fetch(contents):
                        picture.absorb(part)
                    self._absorbed.add(contents.id)
        return picture

    def _group(self, picture: PictureJob, name: str, bricks: Array) -> _Group:
        """Gathers for points, unless this process has. Gives others up where that takes too much memory."""
        group = self._groups.get(name)
        if group is None:
            gathering = picture.gather(bricks)
            group = self._groups[name] = _Group(gathering, gathering.bytes)
        self._groups.move_to_end(name)
        while len(self._groups) > 1 and sum(each.bytes for each in self._groups.values()) > self._gather_bytes:
            self._groups.popitem(last=False)
        return group

    @contextmanager
    def _setting_up(self) -> Iterator[None]:
        """Counts time as setup instead of as the task's own."""
        started, fetched = time.perf_counter(), self.fetch_seconds
        yield
        self.setup_seconds += time.perf_counter() - started - (self.fetch_seconds - fetched)

    def _fetch(self, shared: Shared) -> Any:
        """Fetches something shared. The first time, when it may come from another node, its time and bytes are counted."""
        started = time.perf_counter()
        value = self._fetch_shared(shared)
        if shared.id not in self._seen:
            self._seen.add(shared.id)
            self.bytes_in += shared.bytes
            self.fetch_seconds += time.perf_counter() - started
        return value


_process: _Process | None = None
