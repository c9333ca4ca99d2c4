"""Jobs on three raylets on the loopback, two of which work."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from cluster.conftest import OPTIONS, assert_same
from lightmesh import OptionError, Scene
from lightmesh.cluster import ClusterError, bake, render, worker
from lightmesh.cluster.task import Outcome, Shared, Task

ray = pytest.importorskip("ray", reason="needs Ray: pip install 'lightmesh[ray]'")


@pytest.fixture(autouse=True)
def connected(cluster: str) -> Iterator[None]:
    ray.init(address=cluster, log_to_driver=False, logging_level="ERROR")
    yield
    ray.shutdown()


@pytest.mark.parametrize("method", ["mesh", "hybrid", "unbiased", "standard"])
def test_a_picture_is_the_local_one(scene: Scene, method: str) -> None:
    options = OPTIONS | {"method": method, "spp": 2}
    stats: dict[str, Any] = {}
    assert_same(render(scene, stats=stats, **options), scene.render(**options))
    # One process on each node; one alone may have done all before the other has started
    assert len(stats["workers"]) == len({at["node"] for at in stats["workers"]}) <= 2
    assert all(at["peak_bytes"] > 0 and at["bytes_in"] > 0 for at in stats["workers"])


def test_a_baked_mesh_is_the_local_one(scene: Scene) -> None:
    mesh = bake(scene, **OPTIONS)
    image = scene.render(mesh=mesh, **OPTIONS)
    assert image.stats["rays"]["gather"] == 0
    assert_same(image, scene.render(**OPTIONS))


@pytest.mark.parametrize("kind", ["gather", "bounce", "waves"])
def test_a_killed_worker_costs_its_task_only(scene: Scene, tmp_path: Path, kind: str) -> None:
    from lightmesh.cluster.ray_backend import RayExecutor

    began = tmp_path / "began"
    began.mkdir()

    def die_once(job: Shared, task: Task, fetch: worker.Fetch, node: str) -> Outcome:
        """Notes that a task begins; one that is not the first of the kind is the end of its process, once."""
        (began / f"{task.key} {os.getpid()} {len(list(began.iterdir()))}").touch()
        if len(list(began.glob(f"{kind}-*"))) > 1:
            # Of two that begin at once, one makes the file
            with suppress(FileExistsError):
                (tmp_path / "died").touch(exist_ok=False)
                os.kill(os.getpid(), signal.SIGKILL)
        return worker.execute(job, task, fetch, node)

    image = render(scene, executor=RayExecutor(execute=die_once), **OPTIONS)
    assert_same(image, scene.render(**OPTIONS))
    tries = [name.name.split(" ")[0] for name in began.iterdir()]
    assert (tmp_path / "died").exists()
    assert len(tries) == len(set(tries)) + 1


def test_what_a_task_raises_is_raised_here(scene: Scene) -> None:
    from lightmesh.cluster.ray_backend import RayExecutor

    def refuse(job: Shared, task: Task, fetch: worker.Fetch, node: str) -> Outcome:
        raise OptionError("no")

    with pytest.raises(OptionError, match="no"):
        render(scene, executor=RayExecutor(execute=refuse), **OPTIONS)


def test_a_cluster_without_a_node_that_is_large_enough_is_refused(scene: Scene) -> None:
    with pytest.raises(ClusterError, match="no node of the cluster has 64 cores for a worker: "):
        render(scene, threads=64, **OPTIONS)
    with pytest.raises(ClusterError, match="1 cores and 1125899906842624 bytes of memory"):
        render(scene, memory=1 << 50, **OPTIONS)


def test_ctrl_c_gives_up_what_has_begun_and_leaves_a_job_that_goes_on(scene: Scene, tmp_path: Path) -> None:
    def press(stage: str, done: int, total: int, rays: int) -> None:
        if rays:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        render(scene, job=tmp_path / "job", progress=press, **OPTIONS)
    stats: dict[str, Any] = {}
    assert_same(render(scene, job=tmp_path / "job", stats=stats, **OPTIONS), scene.render(**OPTIONS))
    assert {stage["stage"]: stage["tasks"] for stage in stats["stages"]}["fill"] == 0


DRIVER = """
import os, signal, sys
import ray
from lightmesh import Scene
from lightmesh.cluster import render

ray.init(address=sys.argv[1], log_to_driver=False, logging_level="ERROR")

def end(stage, done, total, rays):
    if rays:
        os.kill(os.getpid(), signal.SIGKILL)

render(Scene.load(sys.argv[2]), job=sys.argv[3], progress=end, **eval(sys.argv[4]))
"""


def test_a_job_goes_on_after_its_driver_was_killed(
    scene: Scene, scene_file: Path, tmp_path: Path, cluster: str
) -> None:
    job = tmp_path / "job"
    arguments = [cluster, str(scene_file), str(job), repr(OPTIONS)]
    killed = subprocess.run([sys.executable, "-c", DRIVER, *arguments], timeout=60)
    assert killed.returncode == -signal.SIGKILL
    done = len(list((job / "waves").glob("*.npz")))
    assert 0 < done < 5
    stats: dict[str, Any] = {}
    assert_same(render(scene, job=job, stats=stats, **OPTIONS), scene.render(**OPTIONS))
    tasks = {stage["stage"]: stage["tasks"] for stage in stats["stages"]}
    # Not one brick, and not the waves that were there
    assert tasks.pop("render") == 5 - done
    assert set(tasks.values()) == {0}
