"""The command line, as a person types it."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy
import pytest

from cluster.conftest import assert_same
from lightmesh import Image, Scene
from lightmesh.farm import main

pytest.importorskip("ray", reason="needs Ray: pip install 'lightmesh[ray]'")

SMALL = ["--size", "96x64", "--spp", "1", "--bounces", "1", "--spacing", "1/32", "--gather-rays", "16"]
OPTIONS = {"size": "96x64", "spp": 1, "bounces": 1, "spacing": "1/32", "gather_rays": 16}


def farm(cluster: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "lightmesh", "farm", *map(str, arguments), "--address", cluster]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def test_a_picture(cluster: str, scene: Scene, scene_file: Path, tmp_path: Path) -> None:
    picture, stats = tmp_path / "picture.exr", tmp_path / "stats.json"
    done = farm(cluster, "render", scene_file, "-o", picture, "-o", tmp_path / "copy.png", "--stats", stats, *SMALL)
    assert (done.returncode, done.stdout) == (0, "")
    assert f"wrote {picture}\n" in done.stderr
    assert " workers, at most " in done.stderr
    assert_same(Image.open(picture), scene.render(**OPTIONS))
    assert {stage["stage"] for stage in json.loads(stats.read_text())["stages"]} >= {"demand", "render"}
    # Its job folder is gone
    assert sorted(file.name for file in tmp_path.iterdir()) == ["copy.png", "picture.exr", "stats.json"]


def test_frames(cluster: str, scene: Scene, scene_file: Path, tmp_path: Path) -> None:
    cameras = tmp_path / "cameras.json"
    cameras.write_text('[{"eye": [0, 0.3, 1], "target": [0, 0.3, 0]}, {"eye": [0, 0.2, 1], "target": [0, 0.3, 0]}]')
    done = farm(cluster, "frames", scene_file, "-o", tmp_path / "f.##.exr", "--cameras", cameras, "--quiet", *SMALL)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    first, second = (numpy.asarray(Image.open(tmp_path / f"f.{frame:02}.exr")) for frame in range(2))
    assert first.shape == second.shape
    assert not numpy.array_equal(first, second)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["render", "none.glb", "-o", "a.png"], "none.glb"),
        (["render", "SCENE", "-o", "a.png", "--spp", "0"], "spp: must be a whole number between 1 and 65536"),
        (["render", "SCENE", "-o", "a.tif"], "a.tif is neither .png nor .exr"),
        (["frames", "SCENE", "-o", "a.png"], "a.png has no # for the number of the frame"),
        (["render", "SCENE", "-o", "a.png", "--camera", "none"], "none"),
        (["render", "SCENE", "-o", "a.png", "--worker-memory", "much"], "'much' is no number of bytes"),
        (["paint", "SCENE"], "invalid choice"),
    ],
)
def test_bad_input_is_2(
    scene_file: Path, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(scene_file) if word == "SCENE" else word for word in arguments]) == 2
    said = capsys.readouterr()
    assert message in said.err
    assert said.out == ""


def test_ctrl_c_is_130_and_the_same_command_goes_on(cluster: str, scene_file: Path, tmp_path: Path) -> None:
    picture = tmp_path / "picture.exr"
    words = ["farm", "render", scene_file, "-o", picture, "--size", "512x512", "--spp", "32"]
    more = ["--address", cluster, "--spacing", "1/32", "--bounces", "1"]
    command = [sys.executable, "-m", "lightmesh", *map(str, words), *more]
    running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    folder = tmp_path / "picture.exr.job" / "waves"
    while not (folder.is_dir() and any(folder.glob("*.npz"))):
        assert running.poll() is None
        time.sleep(0.01)
    os.kill(running.pid, signal.SIGINT)
    _, said = running.communicate(timeout=20)
    assert (running.returncode, picture.exists()) == (130, False), said
    assert f"error: interrupted; the same command goes on from {picture}.job" in said
    assert subprocess.run(command, timeout=60, check=False).returncode == 0
    assert picture.exists()
