"""Tasks one after the other in this process: the same plan without a cluster."""

import os
from collections.abc import Callable, Iterator
from typing import Any

from lightmesh.cluster import worker
from lightmesh.cluster.task import Outcome, Shared, Task


class LocalExecutor:
    """Does tasks in this process."""

    def __init__(self, workers: int = 1, threads: int | None = None) -> None:
        """workers: how many the work is cut for; one does it. threads: of it; None: one for each core."""
        self.workers, self.threads = workers, threads
        self._shared = 0

    def share(self, value: Any, size: int) -> Shared:
        """Nothing has to travel."""
        self._shared += 1
        return Shared(f"local-{os.getpid()}-{id(self)}-{self._shared}", value, size)

    def fetch(self, shared: Shared) -> Any:
        """The value itself."""
        return shared.value

    def run(self, job: Shared, next_task: Callable[[], Task | None]) -> Iterator[tuple[Task, Outcome]]:
        """One after the other."""
        while (task := next_task()) is not None:
            yield task, worker.execute(job, task, self.fetch, node="here")

    def close(self) -> None:
        """Lets go of the scene."""
        worker.forget()
