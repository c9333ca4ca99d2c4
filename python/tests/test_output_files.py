"""Files that Python writes: whole or not at all, and never over the scene's own."""

import json
import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from lightmesh import Error, LightMesh, OptionError, Scene
from lightmesh.farm import main

SMALL = {"size": (24, 16), "spp": 1, "bounces": 0}
needs_links = pytest.mark.skipif(sys.platform == "win32", reason="links need rights on Windows")


@pytest.fixture
def place(scenes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scene, in which the test runs; the scene names an image that is not there yet."""
    shutil.copy(scenes / "triangle.glb", tmp_path / "scene.glb")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_files_of_a_scene_are_known(place: Path) -> None:
    assert Scene.load("scene.glb").files == [place / "scene.glb"]
    assert Scene().files == []
    assert Scene.from_bytes(Scene.load("scene.glb").to_bytes()).files == []


@needs_links
def test_a_picture_and_a_mesh_do_not_replace_the_scene(place: Path) -> None:
    scene = Scene.load("scene.glb")
    before = (place / "scene.glb").read_bytes()
    os.link("scene.glb", "hard.png")
    os.symlink("scene.glb", "soft.exr")
    image, mesh = scene.render(**SMALL), LightMesh(scene, bounces=0)
    for path in ["hard.png", "soft.exr"]:
        with pytest.raises(OptionError, match="scene.glb; name another file"):
            image.save(path)
    for path in ["scene.glb", "soft.exr", place / "scene.glb"]:
        with pytest.raises(OptionError, match="scene.glb; name another file"):
            mesh.save(path)
    assert (place / "scene.glb").read_bytes() == before
    assert sorted(os.listdir()) == ["hard.png", "scene.glb", "soft.exr"]
    # A mesh may go on in its own file.
    mesh.save("a.mesh")
    LightMesh.load("a.mesh", scene).save("a.mesh")


@needs_links
def test_links_and_devices(place: Path) -> None:
    image = Scene.load("scene.glb").render(**SMALL)
    os.symlink("real.png", "link.png")
    os.symlink("/dev/null", "null.png")
    image.save("link.png")
    image.save("null.png")
    assert os.path.islink("link.png") and os.path.islink("null.png") and not os.path.islink("real.png")
    assert Path("real.png").read_bytes()[:4] == b"\x89PNG"


def test_threads_that_save_one_file_are_told_or_write_it_whole(place: Path) -> None:
    image = Scene.load("scene.glb").render(size=(200, 200), spp=1, bounces=0)
    image.save("expected.png")
    messages: list[str] = []

    def save() -> None:
        for _ in range(10):
            try:
                image.save("a.png")
            except Error as error:
                messages.append(str(error))

    threads = [threading.Thread(target=save) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert Path("a.png").read_bytes() == Path("expected.png").read_bytes()
    assert len(messages) < 80 and all("another program is writing it" in message for message in messages)
    assert sorted(os.listdir()) == ["a.png", "expected.png", "scene.glb"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_a_pipe_is_not_a_scene(place: Path) -> None:
    os.mkfifo("pipe.glb")
    code = "import lightmesh\ntry: lightmesh.Scene.load('pipe.glb')\nexcept OSError as error: print(error)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert "pipe.glb" in done.stdout and "not a file" in done.stdout


def test_the_farm_refuses_what_the_program_refuses(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cameras = [{"eye": [0, 0, 3], "target": [0, 0, 0]}, {"eye": [0, 1, 3], "target": [0, 0, 0]}]
    Path("cameras.json").write_text(json.dumps(cameras))
    os.link("scene.glb", "hard.png")
    os.link("scene.glb", "frame.0001.png")
    before = {name: Path(name).read_bytes() for name in os.listdir()}
    for arguments, message in [
        (["render", "-o", "hard.png"], "--output: hard.png would replace the scene scene.glb"),
        (["render", "-o", "a.png", "--stats", "scene.glb"], "--stats: scene.glb would replace the scene scene.glb"),
        (["render", "-o", "a.png", "-o", "./a.png"], "a.png is named twice as an output"),
        (["render", "-o", "a.png", "-o", "../" + place.name + "/a.png"], "it is the same file as a.png"),
        (["bake", "-o", "scene.glb"], "--output: scene.glb would replace the scene scene.glb"),
        (["frames", "-o", "frame.####.png", "--cameras", "cameras.json"], "frame.0001.png would replace a file of the"),
        (["frames", "-o", "f.#.png", "--cameras", "cameras.json", "--stats", "cameras.json"], "would replace the cameras"),
    ]:
        assert main([arguments[0], "scene.glb", *arguments[1:], "--here"]) == 2, arguments
        assert message in capsys.readouterr().err
        assert {name: Path(name).read_bytes() for name in os.listdir()} == before
