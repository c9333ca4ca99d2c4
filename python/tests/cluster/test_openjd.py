"""The templates for other farms, run by the reference command of Open Job Description."""

import base64
import json
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy
import pytest

from cluster.conftest import assert_same
from lightmesh import Image, Scene

TEMPLATES = Path(__file__).parents[3] / "farm" / "openjd"
OPENJD = Path(sys.executable).parent / "openjd"
pytestmark = pytest.mark.skipif(not OPENJD.exists(), reason="needs openjd: pip install openjd-cli")


@pytest.fixture
def two_cameras(tmp_path: Path) -> Path:
    """A lit square that two cameras look at."""
    corners = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    data = b"".join(struct.pack("<3f", *corner) for corner in corners) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    camera = {"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "aspectRatio": 1}}
    light = {"type": "point", "intensity": 10}
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [light]}},
        "buffers": [{"byteLength": len(data), "uri": "data:;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "cameras": [camera, camera],
        "nodes": [
            {"mesh": 0},
            {"camera": 0, "translation": [0, 0, 3]},
            {"camera": 1, "translation": [0.5, 0, 4]},
            {"translation": [0, 0, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "scenes": [{"nodes": [0, 1, 2, 3]}],
        "scene": 0,
    }
    # Templates are text: what they are given must not become commands
    folder = tmp_path / "it's a $(folder)"
    folder.mkdir()
    file = folder / "square.gltf"
    file.write_text(json.dumps(document))
    return file


def openjd(*words: object) -> str:
    done = subprocess.run([OPENJD, *map(str, words)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def parameters(**values: object) -> list[str]:
    return [word for name, value in values.items() for word in ("-p", f"{name}={value}")]


@pytest.fixture
def program() -> str:
    """The script of the package."""
    beside = Path(sys.executable).parent / "lightmesh"
    found = str(beside) if beside.exists() else shutil.which("lightmesh")
    if found is None:
        pytest.skip("needs the program lightmesh")
    return found


@pytest.mark.parametrize("template", ["frames.yaml", "bake_render.yaml"])
def test_templates_are_valid(template: str) -> None:
    assert "passes validation checks" in openjd("check", TEMPLATES / template)


def test_frames(two_cameras: Path, program: str) -> None:
    output = two_cameras.parent / "frames"
    given = parameters(SceneFile=two_cameras, OutputFolder=output, Cameras="0-1", Size="32x24", Program=program)
    openjd("run", TEMPLATES / "frames.yaml", *given, "-p", "Options=--spp 1 --bounces 1")
    first, second = (numpy.asarray(Image.open(output / f"frame.{camera}.exr")) for camera in range(2))
    assert first.shape == (24, 32, 3)
    assert not numpy.array_equal(first, second)


def test_a_mesh_and_frames_with_it(two_cameras: Path, program: str) -> None:
    output = two_cameras.parent / "baked"
    given = parameters(SceneFile=two_cameras, OutputFolder=output, Cameras="0-1", Size="32x24", Program=program)
    step = ("--step", "Frames", "--run-dependencies")
    openjd("run", TEMPLATES / "bake_render.yaml", *given, "-p", "Options=--spp 1 --bounces 1", *step)
    scene = Scene.load(two_cameras)
    for camera in range(2):
        frame = Image.open(output / f"frame.{camera}.exr")
        assert_same(frame, scene.render(camera=camera, size=(32, 24), spp=1, bounces=1))
    assert (output / "light.lightmesh").exists()
