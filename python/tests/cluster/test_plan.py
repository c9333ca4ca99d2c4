"""The plan of a job, without a cluster: the same tasks, one after the other in this process."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy
import pytest

from cluster.conftest import OPTIONS, assert_same
from lightmesh import Camera, LightMesh, OptionError, Scene
from lightmesh.cluster import JobMismatchError, bake, render, render_frames
from lightmesh.cluster.local import LocalExecutor
from lightmesh.cluster.task import Outcome, Shared, Task

METHODS = ["auto", "mesh", "hybrid", "unbiased", "paper", "standard", "path"]


@pytest.mark.parametrize("method", METHODS)
def test_a_picture_is_the_local_one(scene: Scene, method: str) -> None:
    options = OPTIONS | {"method": method, "spp": 4 if method == "mesh" else 1, "near_rays": 16}
    assert_same(render(scene, executor=LocalExecutor(2), **options), scene.render(**options))


@pytest.mark.parametrize(
    "more", [{"refine": 1}, {"lod_distance": 0.5}, {"error": 0.1}, {"light_radius": 0.03}, {"aov": "normal,depth"}]
)
def test_so_are_those_that_need_a_look_at_all_of_it(scene: Scene, more: dict[str, Any]) -> None:
    options = OPTIONS | {"spp": 2, "interpolation": "trilinear"} | more
    mine, theirs = render(scene, executor=LocalExecutor(2), **options), scene.render(**options)
    assert_same(mine, theirs)
    assert mine.aovs.keys() == theirs.aovs.keys()
    for name, layer in mine.aovs.items():
        assert numpy.array_equal(layer, theirs.aovs[name])


class Watching(LocalExecutor):
    """Remembers what tasks brought."""

    def __init__(self) -> None:
        super().__init__(2)
        self.done: list[tuple[Task, Outcome]] = []

    def run(self, job: Shared, next_task: Callable[[], Task | None]) -> Iterator[tuple[Task, Outcome]]:
        for done in super().run(job, next_task):
            self.done.append(done)
            yield done


def test_nothing_is_left_to_fill_when_waves_are_taken(scene: Scene) -> None:
    watching = Watching()
    image = render(scene, executor=watching, **OPTIONS)
    shot = image.stats["rays"]
    assert shot["gather"] == 0
    assert shot["primary"] == 320 * 256 * 4


def test_frames_share_a_mesh(scene: Scene) -> None:
    cameras = [None, Camera.look_at([0.1, 0.3, 0.8], [0, 0.25, 0]), Camera.look_at([-0.1, 0.3, 0.8], [0, 0.25, 0])]
    options = OPTIONS | {"spp": 1}
    watching = Watching()
    frames = dict(render_frames(scene, cameras, executor=watching, **options))
    assert sorted(frames) == [0, 1, 2]
    for frame, camera in enumerate(cameras):
        assert_same(frames[frame], scene.render(camera=camera, **options))
    assert "frame 2 waves 0-0" in {task.name for task, _ in watching.done}


def test_a_baked_mesh_has_all_that_its_cameras_read(scene: Scene) -> None:
    mesh = bake(scene, executor=LocalExecutor(2), **OPTIONS)
    image = scene.render(mesh=mesh, **OPTIONS)
    assert image.stats["rays"]["gather"] == 0
    assert_same(image, scene.render(**OPTIONS))
    with pytest.raises(OptionError, match="have no mesh"):
        bake(scene, executor=LocalExecutor(2), method="standard", size=(8, 8))


def test_a_region_is_filled_beside_what_cameras_read(scene: Scene) -> None:
    options = OPTIONS | {"bounces": 0}
    points = [
        bake(scene, executor=LocalExecutor(2), region=region, **options).stats["direct"]["points_used"]
        for region in (None, [[-0.2, 0.1, -0.2], [0.2, 0.5, 0.2]])
    ]
    # A box of 0.4 m with a point every 0.559 / 32 m
    assert points[0] < points[1] <= points[0] + 24**3


def test_a_mesh_is_used_and_filled(scene: Scene) -> None:
    mesh = LightMesh(scene, **OPTIONS)
    first = render(scene, executor=LocalExecutor(2), mesh=mesh, **OPTIONS)
    points = mesh.stats["direct"]["points_used"]
    assert points > 0
    assert_same(first, render(scene, executor=LocalExecutor(2), mesh=mesh, **OPTIONS))
    assert mesh.stats["direct"]["points_used"] == points


def test_gathered_points_that_do_not_fit_are_gathered_for_again(scene: Scene) -> None:
    image = render(scene, executor=LocalExecutor(2), gather_memory=1, **OPTIONS)
    assert_same(image, scene.render(**OPTIONS))


def test_what_is_done_is_not_done_again(scene: Scene, tmp_path: Path) -> None:
    first, second, third = Watching(), Watching(), Watching()
    job = tmp_path / "job"
    image = render(scene, executor=first, job=job, **OPTIONS)
    assert_same(render(scene, executor=second, job=job, **OPTIONS), image)
    assert second.done == []
    # What is lost is done again, and nothing else
    waves = sorted((job / "waves").iterdir())
    waves[0].unlink()
    assert_same(render(scene, executor=third, job=job, **OPTIONS), image)
    assert len(third.done) == 1
    with pytest.raises(JobMismatchError):
        render(scene, executor=LocalExecutor(2), job=job, **OPTIONS | {"seed": 1})


def test_progress_is_that_of_the_whole_job(scene: Scene) -> None:
    heard: list[tuple[str, int, int, int]] = []
    stats: dict[str, Any] = {}
    render(scene, executor=LocalExecutor(2), progress=lambda *said: heard.append(said), stats=stats, **OPTIONS)
    assert heard[0][0] == "demand"
    assert {stage for stage, *_ in heard} == {"demand", "gather", "fill", "bounce 0", "bounce 1", "bounce 2", "render"}
    assert [done for _, done, _, _ in heard] == sorted(done for _, done, _, _ in heard)
    stage, done, total, rays = heard[-1]
    assert (stage, done) == ("render", total)
    assert rays > 320 * 256 * 4
    assert sum(worker["tasks"] for worker in stats["workers"]) == total
    assert stats["workers"][0]["peak_bytes"] > 1 << 20


DRIVER = """
import os, signal, sys
from lightmesh import Scene
from lightmesh.cluster import render
from lightmesh.cluster.local import LocalExecutor

def end_at_the_third_wave(stage, done, total, rays):
    if stage == "render" and rays and total - done == 2:
        os.kill(os.getpid(), signal.SIGKILL)

render(Scene.load(sys.argv[1]), executor=LocalExecutor(2), job=sys.argv[2], progress=end_at_the_third_wave,
**eval(sys.argv[3]))
"""


def test_a_job_goes_on_after_its_process_was_killed(scene: Scene, scene_file: Path, tmp_path: Path) -> None:
    arguments = [str(scene_file), str(tmp_path / "job"), repr(OPTIONS)]
    killed = subprocess.run([sys.executable, "-c", DRIVER, *arguments], env=os.environ, timeout=60)
    assert killed.returncode == -signal.SIGKILL
    watching = Watching()
    # As it was loaded there
    image = render(scene, executor=watching, job=tmp_path / "job", **OPTIONS)
    assert_same(image, scene.render(**OPTIONS))
    assert [task.kind for task, _ in watching.done] == ["waves"] * 2
