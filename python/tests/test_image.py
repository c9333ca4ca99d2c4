"""Pictures as arrays and files."""

import io
import struct
import zlib
from pathlib import Path

import numpy
import pytest

from conftest import floor, from_above
from lightmesh import Error, Image, OptionError, Scene


@pytest.fixture(scope="module")
def image() -> Image:
    scene = floor()
    scene.add_point_light([0, 2, 0.3], [100, 60, 30])
    return scene.render(camera=from_above(), size=(7, 5), spp=1, method="standard", aov="albedo,depth")


def test_an_array_is_a_view(image: Image) -> None:
    a, b = numpy.asarray(image), numpy.asarray(image)
    assert (a.shape, a.dtype, a.flags.c_contiguous) == ((5, 7, 3), numpy.float32, True)
    assert image.shape == a.shape and (image.width, image.height) == (7, 5)
    assert numpy.shares_memory(a, b) and a.base is not None
    with pytest.raises(ValueError, match="read-only"):
        a[0, 0, 0] = 1
    copy = numpy.array(image)
    copy[:] = 0
    assert a.max() > 0
    assert numpy.asarray(image, dtype=numpy.float64).dtype == numpy.float64
    with pytest.raises(ValueError, match="copy"):
        image.__array__(numpy.float64, copy=False)


def test_an_array_outlives_its_image() -> None:
    light = numpy.asarray(floor().render(camera=from_above(), size=(64, 64), spp=1, aov="depth"))
    depth = floor().render(camera=from_above(), size=(64, 64), spp=1, aov="depth").aovs["depth"]
    assert light.min() > 0 and depth == pytest.approx(4.0)


def test_layers_have_their_names_and_shapes(image: Image) -> None:
    assert {name: layer.shape for name, layer in image.aovs.items()} == {"albedo": (5, 7, 3), "depth": (5, 7)}
    assert image.aovs["albedo"] == pytest.approx(0.5)


def test_a_notebook_gets_a_png(image: Image) -> None:
    width, height, pixels = decode(image._repr_png_())
    assert (width, height) == (7, 5)
    # The light falls off from where it is brightest.
    assert pixels.shape == (5, 7, 3) and pixels[2, 3, 0] > pixels[2, 3, 2] > 0


def test_files_hold_the_picture(image: Image, tmp_path: Path) -> None:
    image.save(tmp_path / "a.exr")
    image.save(str(tmp_path / "half.exr"), half=True)
    again = Image.open(tmp_path / "a.exr")
    assert numpy.array_equal(numpy.asarray(again), numpy.asarray(image))
    assert numpy.asarray(Image.open(tmp_path / "half.exr")) == pytest.approx(numpy.asarray(image), rel=1e-3)
    image.save(tmp_path / "auto.png")
    image.save(tmp_path / "same.png", exposure=image.exposure)
    image.save(tmp_path / "dark.png", exposure=-12)
    assert (tmp_path / "auto.png").read_bytes() == (tmp_path / "same.png").read_bytes() == image._repr_png_()
    assert numpy.asarray(Image.open(tmp_path / "dark.png")).mean() < numpy.asarray(Image.open(tmp_path / "auto.png")).mean()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.exr", "auto.png", "dark.png", "half.exr", "same.png"]
    with pytest.raises(OptionError, match=r"\.png or \.exr"):
        image.save(tmp_path / "a.jpg")
    with pytest.raises(OptionError, match="exposure"):
        image.save(tmp_path / "a.png", exposure="bright")


def test_what_was_read_has_no_camera(image: Image, tmp_path: Path) -> None:
    image.save(tmp_path / "a.exr")
    again = Image.open(tmp_path / "a.exr")
    assert (again.stats, again.aovs) == ({}, {})
    again.save(tmp_path / "a.png")
    with pytest.raises(Error, match="no camera"):
        again.save(tmp_path / "b.exr")


def test_the_exposure_is_that_of_the_command_line(image: Image) -> None:
    """A white surface in the light comes to 0.42. Here 50 cd/m² come from all sides."""
    scene = floor()
    scene.set_environment(50.0)
    flat = scene.render(camera=from_above(), size=(4, 4), spp=256, bounces=0, method="path")
    assert flat.exposure == pytest.approx(numpy.log2(0.42 / 50.0), abs=0.1)


def test_stats_are_a_copy(cornell: Scene) -> None:
    image = cornell.render(size=(8, 8), spp=1, bounces=0)
    image.stats["method"] = "mine"
    assert image.stats["method"] == "auto"
    assert image.stats["image"] == {"width": 8, "height": 8, "spp": 1}


def decode(png: bytes) -> tuple[int, int, numpy.ndarray]:
    """An 8-bit RGB PNG without interlacing, after its specification."""
    stream = io.BytesIO(png)
    assert stream.read(8) == b"\x89PNG\r\n\x1a\n"
    data, width, height = b"", 0, 0
    while head := stream.read(8):
        length, kind = struct.unpack(">I4s", head)
        body = stream.read(length)
        assert struct.unpack(">I", stream.read(4))[0] == zlib.crc32(kind + body)
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
            assert (depth, colour, interlace) == (8, 2, 0)
        elif kind == b"IDAT":
            data += body
    rows = numpy.frombuffer(zlib.decompress(data), numpy.uint8).reshape(height, 1 + 3 * width)
    pixels = numpy.zeros((height, width, 3), int)
    for y in range(height):
        above = pixels[y - 1] if y else numpy.zeros((width, 3), int)
        for x in range(width):
            left = pixels[y, x - 1] if x else numpy.zeros(3, int)
            corner = above[x - 1] if x else numpy.zeros(3, int)
            p = left + above[x] - corner
            distance = numpy.abs(numpy.stack([p - left, p - above[x], p - corner]))
            paeth = numpy.where(distance.argmin(0) == 0, left, numpy.where(distance.argmin(0) == 1, above[x], corner))
            prediction = [0 * left, left, above[x], (left + above[x]) // 2, paeth][rows[y, 0]]
            pixels[y, x] = (rows[y, 1 + 3 * x : 4 + 3 * x] + prediction) % 256
    return width, height, pixels
