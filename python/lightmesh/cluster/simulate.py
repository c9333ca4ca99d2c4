"""How long a job would take on other clusters: its plan, with the times and sizes that were measured, event by event.

    python -m lightmesh.cluster.simulate JOB_FOLDER --nodes 1,10,100,1000

What is simulated: one process that hands tasks out, one after the other; a network card at each node, through which
bytes pass one after the other; workers that do one task at a time, and set themselves up before their first one; the
barriers. Not simulated: nodes of different speed, failures, and other traffic.
"""

import argparse
import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lightmesh.cluster.partition import TASKS_PER_WORKER
from lightmesh.cluster.trace import Stage, Trace

#: Tasks for each worker that are on their way at a time, as `ray_backend.IN_FLIGHT`.
IN_FLIGHT = 4


@dataclass(frozen=True)
class Machines:
    """What the job runs on."""

    nodes: int
    """One worker each."""
    bytes_per_second: float = 1.25e9
    """Of each node's network card, in and out: 10 Gbit/s."""
    latency_seconds: float = 2e-4
    """Of a message."""
    driver_seconds: float = 1.7e-3
    """Of the process that hands tasks out, for each of them and for keeping its result: docs/scaling.md."""
    tasks_per_worker: int = TASKS_PER_WORKER
    """Into how many a stage is cut for each worker."""
    is_tree: bool = False
    """Whether nodes pass on what is shared, so that it takes log2(nodes + 1) steps; else the first node sends it to
    each."""


@dataclass(frozen=True)
class Prediction:
    """What comes of it."""

    nodes: int
    seconds: float
    work_seconds: float
    """Of all tasks alone."""
    driver_seconds: float
    """How long the process that hands out was busy."""
    shared_seconds: float
    """How long the sharing lasted, in sum."""
    setup_seconds: float
    """Of each worker."""

    @property
    def efficiency(self) -> float:
        """Which part of the workers' time goes into tasks."""
        return self.work_seconds / (self.seconds * self.nodes)


def predict(trace: Trace, machines: Machines, times: float = 1.0) -> Prediction:
    """The job with so many times the waves (a larger picture, more frames of the same place) on these machines."""
    clock, work, busy, sharing, setup = 0.0, 0.0, 0.0, 0.0, 0.0
    shared = trace.scene_bytes
    for stage in trace.stages:
        clock += stage.between_seconds
        busy += stage.between_seconds
        arrivals = _share(shared, machines)
        sharing += max(arrivals)
        of_waves = times if stage.name in ("demand", "render") else 1.0
        ended, worked, driver = _run(stage, [clock + arrival for arrival in arrivals], clock, machines, of_waves)
        clock, work, busy, setup = ended, work + worked, busy + driver, setup + stage.setup_seconds
        shared = stage.shared_bytes
    return Prediction(machines.nodes, clock, work, busy, sharing, setup)


def _share(size: float, machines: Machines) -> list[float]:
    """When each node has something that the first one has at 0."""
    step = size / machines.bytes_per_second
    if size == 0.0:
        return [0.0] * machines.nodes
    steps = (node.bit_length() if machines.is_tree else node for node in range(1, machines.nodes + 1))
    return [machines.latency_seconds + step * count for count in steps]


def _run(
    stage: Stage, ready: Sequence[float], clock: float, machines: Machines, times: float
) -> tuple[float, float, float]:
    """When a stage has ended that begins at `clock`, seconds of its tasks, and of the process that hands them out.

    ready: when each node has what it needs.
    """
    count = int(min(machines.tasks_per_worker * machines.nodes, stage.pieces * times))
    seconds, sizes = stage.cut(max(1, count), times)
    free = [at + stage.setup_seconds for at in ready]
    driver = card = clock
    waiting = iter(zip(seconds, sizes, strict=True))
    running: list[tuple[float, int, float]] = []

    def hand_out(node: int) -> None:
        nonlocal driver
        task = next(waiting, None)
        if task is not None:
            driver += machines.driver_seconds
            free[node] = max(free[node], driver + machines.latency_seconds) + task[0]
            heapq.heappush(running, (free[node], node, task[1]))

    for _ in range(IN_FLIGHT):
        for node in range(machines.nodes):
            hand_out(node)
    ended = clock
    while running:
        done, node, size = heapq.heappop(running)
        # Its result passes the card of the first node
        card = max(card, done + machines.latency_seconds) + size / machines.bytes_per_second
        driver = max(driver, card)
        ended = max(ended, driver)
        hand_out(node)
    return ended, float(seconds.sum()), machines.driver_seconds * len(seconds)


def main() -> None:
    """Prints a table."""
    parser = argparse.ArgumentParser(prog="python -m lightmesh.cluster.simulate", description=__doc__.split("\n")[0])
    parser.add_argument("folder", metavar="JOB_FOLDER", type=Path, help="of a farm with --keep-job")
    parser.add_argument("--nodes", default="1,2,10,100,1000", help="how many, separated by commas")
    parser.add_argument("--times", type=float, default=1.0, help="so many times the waves")
    parser.add_argument(
        "--bandwidth", type=float, default=Machines.bytes_per_second, help="of each node, bytes a second"
    )
    parser.add_argument("--latency", type=float, default=Machines.latency_seconds, help="of a message, seconds")
    parser.add_argument("--driver", type=float, default=Machines.driver_seconds, help="for each task, seconds")
    parser.add_argument("--tasks-per-worker", type=int, default=TASKS_PER_WORKER, help="of each stage")
    parser.add_argument("--tree", action="store_true", help="nodes pass on what is shared")
    parser.add_argument(
        "--processor",
        action="store_true",
        help="tasks take their processor time: for workers of one thread on a machine that was busy otherwise",
    )
    parser.add_argument(
        "--fixed", type=float, default=0.0, help="of a gather or bounce task, however small, seconds (default: 0)"
    )
    args = parser.parse_args()
    trace = Trace.read(args.folder, args.processor, args.fixed)
    print("nodes | seconds | efficiency | handing out | sharing | setting up")
    for nodes in map(int, args.nodes.split(",")):
        machines = Machines(nodes, args.bandwidth, args.latency, args.driver, args.tasks_per_worker, args.tree)
        found = predict(trace, machines, args.times)
        print(
            f"{nodes:5} | {found.seconds:7.2f} | {found.efficiency:9.1%} | {found.driver_seconds:9.2f} s"
            f" | {found.shared_seconds:5.2f} s | {found.setup_seconds:8.2f} s"
        )


if __name__ == "__main__":
    main()
