"""Ctrl-C, callbacks and their exceptions."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import ModuleType

import numpy
import pytest

from lightmesh import LightMesh, Scene

RENDER = """
import sys, lightmesh
scene = lightmesh.Scene.load(sys.argv[1])
print("begun", flush=True)
try:
    scene.render(size=(800, 800), method="path", spp=4096)
except KeyboardInterrupt:
    # What was interrupted goes on as if nothing had been.
    scene.render(size=(8, 8), bounces=0)
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals like these")
def test_ctrl_c_ends_a_render_soon(scenes: Path) -> None:
    child = subprocess.Popen(
        [sys.executable, "-c", RENDER, str(scenes / "room_15.glb")], stdout=subprocess.PIPE, text=True
    )
    assert child.stdout is not None and child.stdout.readline() == "begun\n"
    time.sleep(0.5)
    sent = time.monotonic()
    os.kill(child.pid, signal.SIGINT)
    assert child.stdout.readline() == "interrupted\n"
    # Seconds for busy machines; the whole render would take many minutes.
    assert time.monotonic() - sent < 10
    assert child.wait(10) == 0


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals like these")
def test_ctrl_c_ends_the_program_with_130(scenes: Path, tmp_path: Path) -> None:
    preview = tmp_path / "preview.png"
    line = ["render", str(scenes / "room_15.glb"), "-o", str(tmp_path / "a.png"), "--preview", str(preview)]
    child = subprocess.Popen([sys.executable, "-m", "lightmesh", *line, "--method", "path", "--spp", "4096"])
    while not preview.exists():
        assert child.poll() is None
        time.sleep(0.02)
    os.kill(child.pid, signal.SIGINT)
    assert child.wait(10) == 130
    assert list(tmp_path.iterdir()) == [preview]


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals like these")
def test_ctrl_c_ends_what_cannot_be_told() -> None:
    """Making a scene of two million triangles ready goes on unheard; the caller does not wait for it."""
    n = 1000
    x, z = numpy.meshgrid(numpy.arange(n), numpy.arange(n))
    positions = numpy.stack([x, numpy.sin(x * 0.1) * numpy.cos(z * 0.1), z], axis=-1).reshape(-1, 3)
    corner = (numpy.arange(n - 1) * n)[:, None] + numpy.arange(n - 1)
    triangles = numpy.stack([corner, corner + n, corner + 1, corner + 1, corner + n, corner + n + 1], axis=-1)
    scene = Scene()
    scene.add_mesh(positions, triangles.reshape(-1, 3))
    timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        _ = scene.bounds
    assert time.monotonic() - begun < 5
    assert scene.triangle_count == 2 * (n - 1) ** 2


def test_a_callback_hears_of_every_stage(cornell: Scene) -> None:
    reports: list[tuple[str, int, int, int]] = []
    cornell.render(size=(200, 200), spp=4, bounces=1, progress=lambda *report: reports.append(report))
    stage, done, total, rays = reports[-1]
    assert stage in ("render", "outlines") and done == total and rays > 0
    assert all(done <= total for _, done, total, _ in reports)
    assert all(isinstance(number, int) for report in reports for number in report[1:])


class Stop(Exception):
    pass


def test_an_exception_of_the_callback_ends_the_render_and_comes_out(cornell: Scene) -> None:
    calls = 0

    def stop(stage: str, done: int, total: int, rays: int) -> None:
        nonlocal calls
        calls += 1
        raise Stop

    mesh = LightMesh(cornell, cameras=[None], size=(40, 40), bounces=1, gather_rays=128)
    options = {"size": (700, 700), "spp": 64, "mesh": mesh}
    begun = time.monotonic()
    with pytest.raises(Stop):
        cornell.render(progress=stop, **options)
    assert calls == 1 and time.monotonic() - begun < 10
    # The mesh is as good as new.
    small = {"method": "mesh", "size": (40, 40), "spp": 1, "bounces": 1, "gather_rays": 128}
    again = numpy.asarray(cornell.render(mesh=mesh, **small))
    assert numpy.array_equal(again, numpy.asarray(cornell.render(**small)))


def test_a_bar_needs_tqdm(cornell: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(ImportError, match=r"lightmesh\[progress\]"):
        cornell.render(size=(4, 4), bounces=0, progress=True)
    cornell.render(size=(4, 4), bounces=0, progress=False)


def test_a_bar_counts_each_stage(cornell: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    bars: list["FakeBar"] = []

    class FakeBar:
        def __init__(self, total: int, desc: str, **_: object) -> None:
            self.n, self.total, self.desc, self.closed = 0, total, desc, False
            bars.append(self)

        def set_postfix(self, *_: object, **__: object) -> None:
            pass

        def update(self, n: int) -> None:
            self.n += n

        def close(self) -> None:
            self.closed = True

    module = ModuleType("tqdm.auto")
    module.tqdm = FakeBar  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "tqdm", ModuleType("tqdm"))
    monkeypatch.setitem(sys.modules, "tqdm.auto", module)
    cornell.render(size=(50, 50), spp=1, bounces=0, progress=True)
    assert bars and all(bar.closed and bar.n == bar.total for bar in bars)


def test_other_threads_go_on(cornell: Scene) -> None:
    counted = 0
    done = threading.Event()

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    cornell.render(size=(100, 100), spp=16, method="path")
    done.set()
    thread.join()
    assert counted > 5
