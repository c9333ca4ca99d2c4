"""Closed forms of what the simulator computes."""

from dataclasses import replace

import pytest

from lightmesh.cluster.simulate import Machines, predict
from lightmesh.cluster.trace import Stage, Trace


def trace(tasks: int = 1000, **of_stage: float) -> Trace:
    """One stage of tasks of a second each."""
    stage = Stage("render", [1.0] * tasks, [1.0] * tasks, tasks, [0.0] * tasks)
    return Trace(0.0, [replace(stage, **of_stage)])


#: Nothing costs anything but tasks.
FREE = Machines(1, bytes_per_second=1e30, latency_seconds=0.0, driver_seconds=0.0)


@pytest.mark.parametrize("nodes", [1, 10, 50])
def test_tasks_alone_scale(nodes: int) -> None:
    found = predict(trace(), replace(FREE, nodes=nodes))
    assert found.seconds == pytest.approx(1000 / nodes)
    assert found.efficiency == pytest.approx(1)


def test_there_are_no_more_tasks_than_pieces() -> None:
    # 1000 waves for 600 nodes: some do two
    assert predict(trace(), replace(FREE, nodes=600)).seconds == pytest.approx(2)


def test_handing_out_is_a_bound() -> None:
    """10 ms for each of 1000 tasks, and a second for the last one to end."""
    found = predict(trace(), replace(FREE, nodes=1000, driver_seconds=0.01))
    assert found.seconds == pytest.approx(10 + 1)


def test_sharing_is_linear_in_nodes_or_their_logarithm() -> None:
    """1 GB at 1 GB/s before tasks that take no time."""
    shared = Trace(1e9, [replace(trace().stages[0], seconds=[0.0] * 1000)])
    machines = replace(FREE, nodes=100, bytes_per_second=1e9)
    assert predict(shared, machines).seconds == pytest.approx(100)
    # 2^7 - 1 >= 100
    assert predict(shared, replace(machines, is_tree=True)).seconds == pytest.approx(7)


def test_results_pass_one_card() -> None:
    found = predict(trace(bytes_out=[1e6] * 1000), replace(FREE, nodes=1000, bytes_per_second=1e8))
    assert found.seconds == pytest.approx(1 + 10)


def test_each_worker_sets_itself_up() -> None:
    found = predict(trace(setups={("a", 1): 3.0, ("b", 1): 5.0}), replace(FREE, nodes=10))
    assert found.seconds == pytest.approx(4 + 100)


def test_waves_can_be_multiplied() -> None:
    assert predict(trace(), replace(FREE, nodes=10), times=3.0).seconds == pytest.approx(300)
