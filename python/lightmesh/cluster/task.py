"""Tasks, their results, and the executors that run them."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeAlias

from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]
#: The result of a task: arrays, numbers and texts by name. Nobody changes them.
Result: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True)
class Shared:
    """Something that many tasks need, put where all workers reach it; once, and never changed."""

    id: str
    """Another one for each."""
    value: Any
    """As the executor keeps it: itself, or a reference."""
    bytes: int
    """Its size, where it has to travel."""


@dataclass(frozen=True)
class Task:
    """One piece of work: alone, in any order and as often as it likes, it brings the same."""

    kind: Literal["demand", "gather", "fill", "bounce", "waves", "outlines"]
    name: str
    """As people read it: "frame 3 waves 10-12"."""
    key: str
    """Its name in a job folder: tasks of a job that have the same key bring the same."""
    arguments: tuple[Any, ...]
    """Those of the worker's function of its kind."""
    units: int
    """How much it is: waves of samples, or mesh points."""
    pieces: int
    """Into how many tasks it could be cut: waves, or bricks."""
    contents: tuple[Shared, ...] = ()
    """The light mesh as far as it is filled, in the order in which it was. What is missing of it is filled by the task
    itself."""
    shared: tuple[Shared, ...] = ()
    """More for the worker's function, fetched only where it is used."""
    home: str | None = None
    """The node that has what the task would otherwise have to make again."""


@dataclass(frozen=True)
class Outcome:
    """The result of a task, and its cost."""

    result: Result
    node: str
    """Where it ran."""
    process: int
    """Process id there."""
    seconds: float
    """All that the worker did for it."""
    processor_seconds: float
    """Of all cores, which others on the machine do not change much."""
    setup_seconds: float
    """Of these, for what other tasks of the process share: the scene, the picture's preparation, taking over the mesh;
    and for gathered points that were gone."""
    fetch_seconds: float
    """Of these, until things that are shared were there."""
    bytes_in: int
    """What the worker fetched for it; not its arguments."""
    bytes_out: int
    """Of the result's arrays."""
    peak_bytes: int
    """The most memory that the process ever had."""


class Executor(Protocol):
    """Does tasks, somewhere."""

    @property
    def workers(self) -> int:
        """How many tasks it does at a time."""

    @property
    def threads(self) -> int | None:
        """Of each task; None: one for each core."""

    def share(self, value: Any, size: int) -> Shared:
        """Puts a value of so many bytes where all workers reach it."""

    def fetch(self, shared: Shared) -> Any:
        """The value."""

    def run(self, job: Shared, next_task: Callable[[], Task | None]) -> Iterator[tuple[Task, Outcome]]:
        """Does tasks of a job in any order and yields each when it is done. Asks for the next one when there is room,
        so that tasks may be added while results come; ends when there is none and all are done."""

    def close(self) -> None:
        """Gives up what has begun, and lets go of everything."""


def size_of(result: Result) -> int:
    """Bytes of the arrays."""
    return sum(int(getattr(value, "nbytes", 0)) for value in result.values())
