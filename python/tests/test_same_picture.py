"""The same picture, bit for bit: as the command line's, and whatever the threads."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy
import pytest

from lightmesh import Image, LightMesh, Scene

#: Options of Python, and the same as arguments.
CASES: list[tuple[str, dict[str, Any], list[str]]] = [
    ("cornell.glb", {"size": (80, 50), "spp": 2}, ["--size", "80x50", "--spp", "2"]),
    (
        "cornell.glb",
        {"size": "48x48", "spp": 1, "spacing": "1/40", "light_radius": 0.05, "light_samples": 9, "aov": ["normal", "depth"]},
        "--size 48x48 --spp 1 --spacing 1/40 --light-radius 0.05 --light-samples 9 --aov normal,depth".split(),
    ),
    (
        "cornell.glb",
        {"size": (32, 32), "method": "path", "spp": 4, "environment": (1, 0.5, 0.25), "environment_strength": 3},
        "--size 32x32 --method path --spp 4 --environment 1,0.5,0.25 --environment-strength 3".split(),
    ),
    (
        "room_15.glb",
        {"size": (40, 30), "method": "paper", "bounces": 1, "interpolation": "sphere:2", "weight": "gaussian", "spacing": 0.5,
         "indirect_spacing": 1, "gather_rays": 32},
        "--size 40x30 --method paper --bounces 1 --interpolation sphere:2 --weight gaussian --spacing 0.5 --indirect-spacing 1 "
        "--gather-rays 32".split(),
    ),
    ("triangle.glb", {"spp": 1, "size": (60, 40)}, ["--spp", "1", "--size", "60x40"]),
]


def run_program(*arguments: str) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-m", "lightmesh", *arguments]
    return subprocess.run(line, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]}-{case[1].get('method', 'mesh')}")
def test_a_picture_is_that_of_the_command_line(
    scenes: Path, tmp_path: Path, case: tuple[str, dict[str, Any], list[str]]
) -> None:
    name, options, arguments = case
    exr, png, stats = (str(tmp_path / name) for name in ("a.exr", "a.png", "a.json"))
    path = str(scenes / name)
    done = run_program("render", path, "-o", exr, "-o", png, "--stats", stats, *arguments)
    assert done.returncode == 0, done.stderr

    image = Scene.load(path).render(**options)
    theirs = Image.open(exr)
    assert numpy.array_equal(numpy.asarray(image), numpy.asarray(theirs))
    # A PNG says nothing of the time, but all of the settings: the files are the same.
    image.save(tmp_path / "b.png")
    assert (tmp_path / "b.png").read_bytes() == Path(png).read_bytes()

    # The same statistics but for what was measured.
    expected = json.loads(Path(stats).read_text())
    found = image.stats
    assert found.keys() == expected.keys()
    assert found["seconds"].keys() == expected["seconds"].keys()
    for measured in ("seconds", "peak_memory_bytes"):
        del found[measured], expected[measured]
    assert found == expected


def test_threads_and_warm_meshes_change_nothing(scenes: Path) -> None:
    scene = Scene.load(scenes / "room_15.glb")
    options: dict[str, Any] = {"method": "auto", "size": (64, 48), "spp": 2, "spacing": "1/40", "bounces": 1, "gather_rays": 32}
    pictures = [numpy.asarray(scene.render(threads=threads, **options)) for threads in (None, 1, 2, 5)]
    mesh = LightMesh(scene, cameras=[None], **options)
    cold = scene.render(mesh=mesh)
    warm = scene.render(mesh=mesh, progress=lambda *report: None)
    pictures += [numpy.asarray(cold), numpy.asarray(warm)]
    assert all(numpy.array_equal(picture, pictures[0]) for picture in pictures)
    assert warm.stats["seconds"]["fill_direct"] == 0
    assert mesh.stats == warm.stats["mesh"]
    assert mesh.stats["direct"]["points_used"] > 0
    assert mesh.scene is scene


def test_threads_are_those_of_the_call(scenes: Path) -> None:
    scene = Scene.load(scenes / "triangle.glb")
    assert scene.render(size=(8, 8), threads=3).stats["threads"] == 3


def test_the_program_has_its_exit_codes() -> None:
    assert run_program("render", "no.glb", "-o", "no.png").returncode == 2
    version = run_program("--version")
    assert (version.returncode, version.stdout.split()[0]) == (0, "lightmesh")
