"""Tasks on a Ray cluster.

Each task asks for all cores of a worker, so that a node runs one worker process at a time, with threads inside. Nodes
with twice the cores run two; nodes with less than half of the cores of the largest are left out. Ray repeats a task
whose process or node has died; an exception that a task raises ends the job.
"""

import importlib
import logging
import time
from collections.abc import Callable, Iterator
from typing import Any

from lightmesh.cluster import worker
from lightmesh.cluster.errors import ClusterError, RayMissingError
from lightmesh.cluster.task import Outcome, Shared, Task

try:
    # Not typed, and not there for all who check types
    ray: Any = importlib.import_module("ray")
    _errors: Any = importlib.import_module("ray.exceptions")
    _scheduling: Any = importlib.import_module("ray.util.scheduling_strategies")
except ImportError as _missing:
    raise RayMissingError from _missing

#: How often a task is begun again after its worker died.
RETRIES = 5

#: Tasks for each worker that are on their way at a time: one runs, the others wait for it.
IN_FLIGHT = 4

Execute = Callable[[Shared, Task, worker.Fetch, str], Outcome]


class RayExecutor:
    """Does tasks on the cluster that this process is connected to, or that it connects to for the time being."""

    def __init__(
        self,
        address: str | None = None,
        *,
        threads: int | None = None,
        memory: int | None = None,
        execute: Execute = worker.execute,
    ) -> None:
        """address: of the cluster's head; None: RAY_ADDRESS, a cluster that runs on this machine, or a new one of its
        cores alone.

        threads: of each worker; None: as many as the smallest node that takes part has cores. memory: bytes that Ray
        sets aside for each worker; None: none.
        """
        self._began = not ray.is_initialized()
        if self._began:
            ray.init(address=address, logging_level=logging.WARNING, log_to_driver=False)
        self.waited_seconds = 0.0
        """How long this process had nothing to do but wait."""
        self._memory = memory
        self._running: dict[Any, Task] = {}
        self.threads = threads or self._threads()
        if self.workers == 0:
            self.close()
            raise ClusterError(f"no node of the cluster has {self._needs()}: {self._nodes_in_words()}")
        options: dict[str, Any] = {"num_cpus": self.threads, "max_retries": RETRIES}
        if memory is not None:
            options["memory"] = memory

        def lightmesh_task(job: Shared, task: Task) -> Outcome:
            return execute(job, task, _fetch, ray.get_runtime_context().get_node_id())

        self._remote: Any = ray.remote(**options)(lightmesh_task)

    @property
    def workers(self) -> int:
        """How many tasks the nodes that are there now do at a time."""
        return sum(self._fit(node["Resources"]) for node in ray.nodes() if node["Alive"])

    def share(self, value: Any, size: int) -> Shared:
        """Puts it into the object store; nodes fetch it once each."""
        reference = ray.put(value)
        return Shared(reference.hex(), reference, size)

    def fetch(self, shared: Shared) -> Any:
        """Its arrays are those of the object store, which cannot be written to."""
        return _fetch(shared)

    def run(self, job: Shared, next_task: Callable[[], Task | None]) -> Iterator[tuple[Task, Outcome]]:
        """Keeps a few tasks for each worker on their way."""
        room = IN_FLIGHT * max(1, self.workers)
        while True:
            while len(self._running) < room and (task := next_task()) is not None:
                reference = self._remote.options(name=task.name, **_strategy(task)).remote(job, task)
                self._running[reference] = task
            if not self._running:
                return
            for reference in self._wait():
                task = self._running[reference]
                yield task, self._outcome(reference)

    def close(self) -> None:
        """Gives up what has begun, and leaves the cluster, if it has been connected to here."""
        for reference in self._running:
            ray.cancel(reference, force=False)
        self._running.clear()
        if self._began:
            ray.shutdown()

    def _wait(self) -> list[Any]:
        """Tasks that are done: one at least, and all that are by then, since asking takes the longer the more there
        are."""
        started = time.perf_counter()
        references = list(self._running)
        ray.wait(references, num_returns=1)
        done, _ = ray.wait(references, num_returns=len(references), timeout=0)
        self.waited_seconds += time.perf_counter() - started
        return list(done)

    def _outcome(self, reference: Any) -> Outcome:
        task = self._running.pop(reference)
        try:
            outcome: Outcome = ray.get(reference)
        except _errors.RayTaskError as error:
            raise (error.cause if isinstance(error.cause, Exception) else ClusterError(str(error))) from error
        except _errors.RayError as error:
            raise ClusterError(f"{task.name} failed: {error}") from error
        return outcome

    def _threads(self) -> int:
        cores = [int(node["Resources"].get("CPU", 0)) for node in ray.nodes() if node["Alive"]]
        most = max(cores, default=0)
        return min((count for count in cores if count > 0 and 2 * count >= most), default=1)

    def _fit(self, resources: dict[str, float]) -> int:
        by_cores = int(resources.get("CPU", 0)) // self.threads
        return by_cores if self._memory is None else min(by_cores, int(resources.get("memory", 0) // self._memory))

    def _needs(self) -> str:
        memory = "" if self._memory is None else f" and {self._memory} bytes of memory"
        return f"{self.threads} cores{memory} for a worker"

    def _nodes_in_words(self) -> str:
        nodes = [node["Resources"] for node in ray.nodes() if node["Alive"]]
        said = (f"{node.get('CPU', 0):.0f} cores and {node.get('memory', 0):.0f} bytes" for node in nodes)
        return ", ".join(said) or "there is none"


def _fetch(shared: Shared) -> Any:
    return ray.get(shared.value)


def _strategy(task: Task) -> dict[str, Any]:
    if task.home is None:
        return {}
    # Elsewhere, if that node is gone
    return {"scheduling_strategy": _scheduling.NodeAffinitySchedulingStrategy(task.home, soft=True)}
