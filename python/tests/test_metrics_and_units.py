"""Distances between pictures, and units."""

import math

import numpy
import pytest

from conftest import floor, from_above
from lightmesh import SceneError, metrics, units


def test_a_brighter_constant_has_its_factor_as_error_and_bias() -> None:
    b = numpy.full((8, 9, 3), 2.0)
    found = metrics.compare(1.1 * b, b)
    assert found["relrmse"] == pytest.approx(0.1) == metrics.relrmse(1.1 * b, b)
    assert (found["bias"], found["max"]) == (pytest.approx(0.1), pytest.approx(0.2))
    assert 0 < found["flip"] < 1 and found["flip"] == metrics.flip(1.1 * b, b)


def test_relrmse_is_its_formula() -> None:
    a, b = numpy.random.default_rng(1).uniform(0, 5, (2, 6, 7, 3)).astype(numpy.float32)
    expected = math.sqrt(((a.astype(float) - b) ** 2).mean()) / b.astype(float).mean()
    assert metrics.relrmse(a, b) == pytest.approx(expected)


def test_images_and_arrays_are_the_same_to_it() -> None:
    image = floor().render(camera=from_above(), size=(9, 9), spp=1)
    assert metrics.compare(image, numpy.asarray(image)) == {"relrmse": 0, "bias": 0, "max": 0, "flip": 0}


def test_sizes_must_match() -> None:
    with pytest.raises(SceneError, match="a is 2x3, b is 3x2"):
        metrics.relrmse(numpy.ones((3, 2, 3)), numpy.ones((2, 3, 3)))
    with pytest.raises(SceneError, match=r"b: expected the shape \(H, W, 3\)"):
        metrics.flip(numpy.ones((3, 2, 3)), numpy.ones((3, 2)))


def test_a_lumen_goes_round() -> None:
    """4π lm are 1 cd, which is 1 lx at 1 m and a quarter at 2 m."""
    assert units.candela_from_lumen(4 * math.pi) == pytest.approx(1)
    assert units.lumen_from_candela(units.candela_from_lumen(800)) == pytest.approx(800)
    assert (units.lux_from_candela(1, 1), units.lux_from_candela(1, 2)) == (1, 0.25)
    assert units.candela_from_lux(units.lux_from_candela(7, 3), 3) == pytest.approx(7)
    assert units.candela_from_watt(1) == pytest.approx(683 / (4 * math.pi))


def test_luminance_weighs_green_most() -> None:
    assert units.luminance([1, 1, 1]) == pytest.approx(1)
    assert units.luminance(numpy.eye(3)) == pytest.approx(units.LUMINANCE_WEIGHTS)
    assert units.luminance(numpy.ones((4, 5, 3), numpy.float32)).dtype == numpy.float32
    with pytest.raises(ValueError, match="rgb"):
        units.luminance([1, 2])
