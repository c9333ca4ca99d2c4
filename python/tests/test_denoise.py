"""Pictures without noise, where Open Image Denoise is installed."""

from pathlib import Path

import numpy
import pytest

import lightmesh
from conftest import floor, from_above
from lightmesh import Error, Image, MemoryLimitError, OptionError, Scene

LAYERS = ["albedo", "normal", "direct", "indirect"]


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Noise in direct light: an environment."""
    scene = floor()
    scene.set_environment(50.0)
    return scene


@pytest.fixture(scope="module")
def noisy(scene: Scene) -> Image:
    return scene.render(camera=from_above(), size=(48, 32), spp=1, method="path", aov=LAYERS)


@pytest.fixture(scope="module")
def library(noisy: Image) -> None:
    try:
        noisy.denoise()
    except Error as error:
        if "was not found" not in str(error):
            raise
        pytest.skip(str(error))


def test_a_missing_library_is_said(scene: Scene, noisy: Image, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LIGHTMESH_OIDN", "/nonexistent")
    with pytest.raises(Error, match="/nonexistent.*pip install pyoidn"):
        noisy.denoise()
    with pytest.raises(Error, match="/nonexistent.*pip install pyoidn"):
        scene.render(camera=from_above(), size=(4, 4), method="path", denoise=True)


def test_what_cannot_be_denoised_is_said(scene: Scene, tmp_path: Path) -> None:
    plain = scene.render(camera=from_above(), size=(4, 4), spp=1, method="path", aov="normal")
    with pytest.raises(OptionError, match=r'"albedo", "direct", "indirect": render it with aov=\["albedo", "normal", '):
        plain.denoise()
    plain.save(tmp_path / "a.exr")
    with pytest.raises(OptionError, match="file has no layers"):
        Image.open(tmp_path / "a.exr").denoise()


def test_a_picture_without_noise_stays() -> None:
    scene = floor()
    scene.add_point_light([0, 2, 0.3], 100.0)
    image = scene.render(camera=from_above(), size=(4, 4), spp=1, method="standard")
    with pytest.warns(RuntimeWarning, match="standard of lights without a size have no noise"):
        same = image.denoise()
    assert numpy.array_equal(numpy.asarray(same), numpy.asarray(image)) and same.stats == image.stats


@pytest.mark.usefixtures("library")
def test_noise_goes_and_light_stays(scene: Scene, noisy: Image) -> None:
    before = numpy.array(noisy)
    clean = noisy.denoise(threads=1)
    assert numpy.array_equal(numpy.asarray(noisy), before)
    light = numpy.asarray(clean)
    assert numpy.isfinite(light).all() and light.min() >= 0
    assert light.std() < before.std() / 4 and light.mean() == pytest.approx(before.mean(), rel=0.03)
    assert clean.aovs.keys() == noisy.aovs.keys()
    assert clean.stats["denoiser"].startswith("Open Image Denoise 2") and clean.stats["seconds"]["denoise"] > 0
    assert noisy.stats["denoiser"] is None and noisy.stats["seconds"]["denoise"] == 0
    # The same in one call, without layers of its own.
    at_once = scene.render(camera=from_above(), size=(48, 32), spp=1, method="path", denoise=True)
    assert numpy.array_equal(numpy.asarray(at_once), light) and at_once.aovs == {}
    assert at_once.stats["denoiser"] == clean.stats["denoiser"]
    with pytest.raises(OptionError, match="has denoised this picture already"):
        clean.denoise()


@pytest.mark.usefixtures("library")
def test_memory_is_limited(scene: Scene) -> None:
    with pytest.raises(MemoryLimitError, match="denoising"):
        scene.render(camera=from_above(), size=(1000, 1000), method="path", denoise=True, max_memory="200MiB")


def test_the_cluster_has_no_such_option(scene: Scene) -> None:
    with pytest.raises(TypeError, match="denoise"):
        lightmesh._native.PictureJob(scene, denoise=True)
