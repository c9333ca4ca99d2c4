"""Processes that are forked, and threads, at work with one scene or one mesh."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from pathlib import Path

import numpy
import pytest

from conftest import floor, from_above, light_of
from lightmesh import Camera, Error, Image, LightMesh, OptionError, Scene, metrics

SMALL = {"size": (48, 32), "spp": 1, "bounces": 1, "gather_rays": 16}
#: Seconds for busy machines: what hangs, hangs for ever.
PATIENCE = 60

forks = pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks")


def lit() -> Scene:
    scene = floor()
    scene.add_point_light((0, 1, 0), 100.0)
    return scene


def in_child(work: Callable[[], object]) -> object:
    """What `work` returns in a forked process, or its exception."""
    theirs: Connection
    ours, theirs = multiprocessing.Pipe(duplex=False)
    child = os.fork()
    if child == 0:
        try:
            theirs.send(work())
        except BaseException as error:
            theirs.send(error)
        finally:
            os._exit(0)
    theirs.close()
    try:
        assert ours.poll(PATIENCE), "the forked process hangs"
        return ours.recv()
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


@forks
def test_a_forked_process_renders_the_same_picture(tmp_path: Path) -> None:
    scene, camera = lit(), from_above()
    options = {"camera": camera, **SMALL}
    picture = light_of(scene.render(**options))

    def work() -> list[object]:
        mesh = LightMesh(scene, bounces=1, gather_rays=16)
        image = scene.render(**options)
        image.save(tmp_path / "a.png")
        image.save(tmp_path / "a.exr")
        mesh.fill([[0, 0, 0]])
        compared = metrics.compare(image, picture)["flip"]
        lux = scene.irradiance([[0, 0, 0]], (0, 1, 0))
        with_two = light_of(scene.render(threads=2, **options))
        reread = Image.open(tmp_path / "a.exr")
        return [light_of(image), with_two, light_of(reread), compared, lux, len(mesh.points), image._repr_png_()[:4]]

    for _ in range(2):
        done = in_child(work)
        assert isinstance(done, list), done
        for light in done[:3]:
            assert numpy.array_equal(light, picture)
        assert done[3] == 0
        assert numpy.array_equal(done[4], scene.irradiance([[0, 0, 0]], (0, 1, 0)))
        assert done[5] > 0 and done[6] == b"\x89PNG"
    # The parent goes on as before.
    assert numpy.array_equal(light_of(scene.render(**options)), picture)


@forks
def test_forks_of_forks_and_their_threads_render() -> None:
    scene, camera = lit(), from_above()
    picture = light_of(scene.render(camera=camera, **SMALL))

    def work() -> object:
        light_of(scene.render(camera=camera, **SMALL))
        with ThreadPoolExecutor(4) as pool:
            pictures = [pool.submit(scene.render, camera=camera, **SMALL) for _ in range(4)]
            assert all(numpy.array_equal(light_of(one.result(PATIENCE)), picture) for one in pictures)
        return in_child(lambda: light_of(scene.render(camera=camera, **SMALL)))

    assert numpy.array_equal(in_child(work), picture)


def render_one(place: float) -> numpy.ndarray:
    return light_of(lit().render(camera=Camera.look_at([place, 4, 0], [0, 0, 0], yfov=0.3), **SMALL))


@forks
def test_multiprocessing_by_fork_renders() -> None:
    places = [0.0, 0.5, 1.0, 1.5]
    expected = [render_one(place) for place in places]
    with multiprocessing.get_context("fork").Pool(2) as pool:
        pictures = pool.map_async(render_one, places).get(PATIENCE)
    assert all(numpy.array_equal(a, b) for a, b in zip(pictures, expected, strict=True))


@forks
def test_a_mesh_in_use_at_the_fork_is_an_error_in_the_child() -> None:
    scene = lit()
    mesh = LightMesh(scene, bounces=0)
    begun, ended = threading.Event(), threading.Event()

    def stop_when_told(*_: object) -> None:
        begun.set()
        if ended.is_set():
            raise InterruptedError

    def work() -> None:
        with pytest.raises(InterruptedError):
            scene.render(camera=from_above(), size=(2000, 2000), spp=4096, mesh=mesh, progress=stop_when_told)

    thread = threading.Thread(target=work)
    thread.start()
    assert begun.wait(PATIENCE)
    try:
        error = in_child(lambda: mesh.fill([[0, 0, 0]]))
        assert isinstance(error, Error) and "another thread works with it" in str(error)
        # The scene itself is free.
        picture = in_child(lambda: light_of(scene.render(camera=from_above(), **SMALL)))
    finally:
        ended.set()
        thread.join(PATIENCE)
    assert not thread.is_alive()
    assert numpy.array_equal(picture, light_of(scene.render(camera=from_above(), **SMALL)))


def test_eight_threads_render_one_scene() -> None:
    """Also one that is not yet made ready for rays, by whichever thread is first."""
    expected = light_of(lit().render(camera=from_above(), **SMALL))
    scene = lit()
    with ThreadPoolExecutor(8) as pool:
        pictures = [pool.submit(scene.render, camera=from_above(), **SMALL) for _ in range(16)]
        for one in pictures:
            assert numpy.array_equal(light_of(one.result(PATIENCE)), expected)


def test_eight_threads_and_one_mesh_finish_or_say_that_it_is_in_use(tmp_path: Path) -> None:
    scene = lit()
    expected = light_of(scene.render(camera=from_above(), **SMALL))
    mesh = LightMesh(scene, bounces=1, gather_rays=16)
    alone = light_of(scene.render(camera=from_above(), mesh=mesh, **SMALL))
    barrier = threading.Barrier(8)

    def work(index: int) -> tuple[int, int]:
        done = refused = 0
        barrier.wait(PATIENCE)
        for turn in range(6):
            try:
                match (index + turn) % 6:
                    case 0:
                        mesh.fill(region=[[-1, 0, -1], [1, 0.5, 1]])
                    case 1:
                        mesh.irradiance([[0, 0, 0]], (0, 1, 0))
                    case 2:
                        assert len(mesh.points) == len(mesh.valid) or index >= 0
                    case 3:
                        mesh.save(tmp_path / f"{index}.mesh")
                    case 4:
                        repr(mesh)
                    case _:
                        picture = scene.render(camera=from_above(), mesh=mesh, **SMALL)
                        assert numpy.array_equal(light_of(picture), alone)
                done += 1
            except Error as error:
                assert "another thread works with it" in str(error)
                refused += 1
        return done, refused

    with ThreadPoolExecutor(8) as pool:
        counts = [one.result(PATIENCE) for one in [pool.submit(work, index) for index in range(8)]]
    assert sum(done + refused for done, refused in counts) == 48
    assert sum(done for done, _ in counts) >= 6
    # It is as good as new.
    assert numpy.array_equal(light_of(scene.render(camera=from_above(), mesh=mesh, **SMALL)), alone)
    assert alone.shape == expected.shape


def test_changes_of_a_scene_while_others_render() -> None:
    scene, camera = lit(), from_above()
    stop = threading.Event()

    def change() -> int:
        changes = 0
        while not stop.is_set():
            scene.add_point_light((0, 1, 0), 0.001)
            changes += 1
            time.sleep(0.001)
        return changes

    with ThreadPoolExecutor(8) as pool:
        changing = pool.submit(change)
        pictures = [pool.submit(scene.render, camera=camera, method="standard", **{**SMALL, "bounces": 0}) for _ in range(12)]
        try:
            assert all(light_of(one.result(PATIENCE)).max() > 0 for one in pictures)
        finally:
            stop.set()
        assert changing.result(PATIENCE) > 0
    assert len(scene.lights) > 1


INTERRUPTED = """
import sys, threading, lightmesh
scene = lightmesh.Scene.load(sys.argv[1])
mesh = lightmesh.LightMesh(scene, bounces=0)
done = []
def other():
    while len(done) < 3:
        done.append(scene.render(size=(64, 64), spp=4, method="path"))
def hold():
    try:
        mesh.fill(region=scene.bounds)
    except lightmesh.Error:
        pass
threads = [threading.Thread(target=other), threading.Thread(target=hold)]
for thread in threads:
    thread.start()
print("begun", flush=True)
try:
    scene.render(size=(800, 800), method="path", spp=65536)
except KeyboardInterrupt:
    for thread in threads:
        thread.join()
    scene.render(size=(8, 8), bounces=0, mesh=mesh)
    print("interrupted", len(done), flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals like these")
def test_ctrl_c_ends_the_main_thread_and_leaves_the_others(scenes: Path) -> None:
    command = [sys.executable, "-c", INTERRUPTED, str(scenes / "triangle.glb")]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "begun\n"
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    said, _ = child.communicate(timeout=PATIENCE)
    assert (child.returncode, said) == (0, "interrupted 3\n")


THREADS = """
import warnings, lightmesh
scene = lightmesh.Scene()
scene.add_sphere((0, 0, 0), 1.0)
scene.add_point_light((0, 3, 0), 100.0)
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    image = scene.render(size=(16, 16), spp=1)
    image.save("a.exr"); lightmesh.Image.open("a.exr")
    print(image.stats["threads"], {warning.category.__name__ for warning in caught}, flush=True)
"""


def test_a_huge_number_of_threads_is_cut_down(tmp_path: Path) -> None:
    most = max(64, 4 * (os.cpu_count() or 1))
    environment = {**os.environ, "RAYON_NUM_THREADS": "100000"}
    command = [sys.executable, "-c", THREADS]
    done = subprocess.run(
        command, env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE, check=True
    )
    count, categories = done.stdout.split(maxsplit=1)
    assert 1 <= int(count) <= most and categories == "{'RuntimeWarning'}\n"


def test_threads_are_a_number_that_a_machine_can_have() -> None:
    scene = lit()
    picture = light_of(scene.render(camera=from_above(), **SMALL))
    with pytest.raises(OptionError, match="threads"):
        scene.render(camera=from_above(), threads=10**6, **SMALL)
    if (os.cpu_count() or 1) < 1024:
        with pytest.warns(RuntimeWarning, match="work instead of 4096"):
            image = scene.render(camera=from_above(), threads=4096, **SMALL)
        assert image.stats["threads"] == max(64, 4 * len(os.sched_getaffinity(0)))
        assert numpy.array_equal(light_of(image), picture)
