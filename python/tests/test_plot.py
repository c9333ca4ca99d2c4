"""Figures: what is in them, what their axes say, and what is refused. Nothing is shown: the backend is Agg."""

import io
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.image
import matplotlib.pyplot
import numpy
import pytest
from matplotlib.collections import EllipseCollection, QuadMesh

from conftest import floor, from_above
from lightmesh import Image, LightMesh, Material, Scene, metrics, plot, units


@pytest.fixture(autouse=True)
def _closed() -> Iterator[None]:
    yield
    matplotlib.pyplot.close("all")


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A box on a floor, and a lamp."""
    scene = floor()
    scene.add_sphere([0.5, 0.5, 0], 0.5, material=Material(specular=0.0))
    scene.add_point_light([0, 2, 0], 100.0)
    return scene


@pytest.fixture(scope="module")
def image(scene: Scene) -> Image:
    return scene.render(camera=from_above(), size=(12, 8), spp=1, method="standard")


@pytest.fixture(scope="module")
def mesh(scene: Scene) -> LightMesh:
    mesh = LightMesh(scene, spacing=0.25, indirect_spacing=0.5, gather_rays=16, bounces=1)
    mesh.irradiance(numpy.random.default_rng(1).uniform([-1.5, 0.2, -1.5], [1.5, 0.8, 1.5], (60, 3)), [0, 1, 0])
    return mesh


@pytest.mark.parametrize("exposure", ["auto", -5.5])
def test_a_picture_is_the_png(image: Image, exposure: Any, tmp_path: Path) -> None:
    image.save(tmp_path / "a.png", exposure=exposure)
    expected = matplotlib.image.imread(tmp_path / "a.png")
    ax = plot.picture(image, exposure=exposure)
    assert numpy.array_equal(ax.images[0].get_array(), expected)
    assert not ax.axison


def test_a_picture_needs_a_tone_map(image: Image) -> None:
    with pytest.raises(TypeError, match=r"lightmesh\.Image"):
        plot.picture(numpy.asarray(image))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="exposure"):
        plot.picture(image, exposure="bright")  # type: ignore[arg-type]
    assert matplotlib.pyplot.get_fignums() == []


def test_an_error_map_has_sign_scale_and_numbers(image: Image) -> None:
    reference = numpy.asarray(image)
    ax = plot.error_map(1.2 * reference, image)
    shown = ax.images[0]
    lit = reference[..., 0] > 0
    assert numpy.asarray(shown.get_array())[lit] == pytest.approx(0.2, abs=1e-5)
    assert shown.get_clim() == pytest.approx((-0.2, 0.2))
    assert ax.get_title() == f"relRMSE {100 * metrics.relrmse(1.2 * reference, image):.3g}%, bias +20%"
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("column (pixels)", "row (pixels)")
    assert shown.colorbar is not None and shown.colorbar.ax.get_ylabel() == "relative error of luminance (%)"


def test_an_error_map_of_arrays_and_images_is_the_same(image: Image) -> None:
    darker = 0.5 * numpy.asarray(image)
    a, b = plot.error_map(darker, image, limit=0.1), plot.error_map(darker, numpy.asarray(image), limit=0.1)
    assert numpy.array_equal(a.images[0].get_array(), b.images[0].get_array())
    assert a.images[0].get_clim() == (-0.1, 0.1)
    assert a.images[0].colorbar is not None and a.images[0].colorbar.extend == "both"


def test_black_has_errors_that_end() -> None:
    """A hundredth of the mean stands in for what is darker."""
    reference = numpy.ones((4, 5, 3))
    reference[0, 0] = 0
    shown = numpy.asarray(plot.error_map(reference + 0.01, reference).images[0].get_array())
    assert shown[0, 0] == pytest.approx(0.01 / (0.01 * 0.95))
    assert shown[1, 1] == pytest.approx(0.01)


def test_pictures_that_are_alike_have_no_error(image: Image) -> None:
    ax = plot.error_map(image, image)
    assert not numpy.asarray(ax.images[0].get_array()).any()
    ax.figure.savefig(io.BytesIO())


def test_a_slice_has_the_illuminance_of_the_points(mesh: LightMesh) -> None:
    at = float(mesh.points[mesh.valid][0, 1])
    ax = plot.slice_of_mesh(mesh, "y", at=at, limits=(1e-3, 1e3))
    near = numpy.abs(mesh.points[:, 1] - at) <= mesh.spacing / 2 * (1 + 1e-4)
    dots = next(one for one in ax.collections if isinstance(one, EllipseCollection))
    valid = near & mesh.valid
    assert numpy.asarray(dots.get_offsets()) == pytest.approx(mesh.points[valid][:, [0, 2]])
    expected = numpy.maximum(units.luminance(mesh.values[valid][:, 2, 0]), 1e-3)
    assert numpy.asarray(dots.get_array()) == pytest.approx(expected)
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_aspect()) == ("x (m)", "z (m)", 1)
    assert ax.yaxis_inverted() and f"{near.sum()} points" in ax.get_title()
    assert dots.colorbar is not None and dots.colorbar.ax.get_ylabel() == "direct illuminance, facing +y (lx)"


@pytest.mark.parametrize(("axis", "labels"), [("x", ("z (m)", "y (m)")), ("z", ("x (m)", "y (m)"))])
def test_slices_across_other_axes(mesh: LightMesh, axis: Any, labels: tuple[str, str]) -> None:
    ax = plot.slice_of_mesh(mesh, axis, at=0.0, light="indirect", facing="-x", thickness=1.0)
    assert (ax.get_xlabel(), ax.get_ylabel()) == labels and not ax.yaxis_inverted()
    ax.figure.savefig(io.BytesIO())


def test_invalid_points_are_crosses() -> None:
    """The middle of a solid is no place for light."""
    scene = floor()
    scene.add_sphere([0, 1, 0], 0.9, material=Material(specular=0.0))
    scene.add_point_light([0, 3, 0], 100.0)
    mesh = LightMesh(scene, spacing=0.25, bounces=0)
    mesh.fill(region=[[-1, 0.5, -1], [1, 1.5, 1]])
    ax = plot.slice_of_mesh(mesh, "y", at=1.0)
    invalid = (~mesh.valid) & (numpy.abs(mesh.points[:, 1] - 1) <= mesh.spacing / 2 * (1 + 1e-4))
    crosses = [one for one in ax.collections if not isinstance(one, EllipseCollection)]
    assert invalid.any() and len(numpy.asarray(crosses[0].get_offsets())) == invalid.sum()
    legend = ax.get_legend()
    assert legend is not None and legend.get_texts()[0].get_text() == f"{invalid.sum()} invalid: in solids or on surfaces"


def test_a_slice_says_where_points_are(mesh: LightMesh, scene: Scene) -> None:
    with pytest.raises(ValueError, match=r"no points at y = 90 m, but from y = "):
        plot.slice_of_mesh(mesh, "y", at=90)
    with pytest.raises(ValueError, match="none at all"):
        plot.slice_of_mesh(LightMesh(scene), "y", at=0)
    with pytest.raises(ValueError, match=r"facing: expected one of \+x"):
        plot.slice_of_mesh(mesh, "y", at=0.5, facing="up")  # type: ignore[arg-type]


def test_a_cloud_has_all_points_in_equal_axes(mesh: LightMesh) -> None:
    ax = plot.point_cloud(mesh)
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels[0] == f"level 0, 0.25 m: {mesh.valid.sum()}"
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()) == ("x (m)", "z (m)", "y (m)")
    assert ax.get_aspect() == "equal" and f"{len(mesh.points)} points" in ax.get_title()
    x, y, z = ax.collections[0]._offsets3d
    assert numpy.asarray(numpy.ma.getdata(numpy.ma.stack([x, z, y], axis=1))) == pytest.approx(mesh.points[mesh.valid])


def test_a_cloud_of_many_points_is_drawn_by_lot(mesh: LightMesh) -> None:
    some = plot.point_cloud(mesh, most=50)
    assert "50 of them drawn" in some.get_title()
    assert sum(len(one._offsets3d[0]) for one in some.collections) == 50
    with pytest.raises(ValueError, match="no points"):
        plot.point_cloud(LightMesh(mesh.scene))


def test_names_stand_at_lines() -> None:
    series = {"mesh": ([1, 2, 4], [0.1, 0.05, 0.03]), "path": ([1, 4, 16], [0.4, 0.2, 0.1]), "hybrid": (0.5, 0.01)}
    ax = plot.convergence(series)
    assert {text.get_text() for text in ax.texts} == {"mesh", "path", "hybrid", "slope −1/2"}
    assert ax.get_legend() is None
    boxes = [text.get_window_extent() for text in ax.texts]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time (s)", "relRMSE (%)")
    assert list(ax.lines[1].get_xdata()) == [1, 4, 16]
    x, y = numpy.asarray(ax.lines[-1].get_data(), float)
    assert numpy.diff(numpy.log(y)) / numpy.diff(numpy.log(x)) == pytest.approx(-0.5)


def test_a_legend_where_names_find_no_room() -> None:
    series = {f"a method with a long name, number {i}": ([1.0, 2.0], [0.1, 0.1001]) for i in range(40)}
    ax = plot.convergence(series, against="samples", slope=False)
    legend = ax.get_legend()
    assert legend is not None and len(legend.get_texts()) == 40 and not ax.texts
    assert ax.get_xlabel() == "samples per pixel"


def test_convergence_takes_what_has_logarithms() -> None:
    with pytest.raises(ValueError, match="'a' has efforts or errors that are not positive"):
        plot.convergence({"a": ([1, 2], [0.1, 0.0])})
    with pytest.raises(ValueError, match="'b' has efforts of the shape"):
        plot.convergence({"b": ([1, 2], [0.1])})
    with pytest.raises(ValueError, match="there is none"):
        plot.convergence({})


def test_isolines_have_their_lux() -> None:
    x, y = numpy.linspace(0, 6, 25), numpy.linspace(0, 4, 17)
    lux = 100 + 50 * x + 0 * y[:, None]
    lux[0, 0] = numpy.nan
    ax = plot.illuminance(x, y, lux, levels=[150, 250])
    assert sorted({text.get_text() for text in ax.texts}) == ["150 lx", "250 lx"]
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_aspect()) == ("x (m)", "y (m)", 1)
    assert "= 250 lx" in ax.get_title() and "= 100 lx" in ax.get_title() and "$U_0$ = 0.40" in ax.get_title()
    colours = next(one for one in ax.collections if isinstance(one, QuadMesh))
    assert colours.colorbar is not None and colours.colorbar.ax.get_ylabel() == "illuminance (lx)"
    ax.figure.savefig(io.BytesIO())


def test_isolines_are_chosen_and_shapes_checked() -> None:
    x, y = numpy.linspace(0, 6, 25), numpy.linspace(0, 4, 17)
    assert len(plot.illuminance(x, y, 200 + x + 0 * y[:, None]).texts) > 2
    # Without any where all is alike.
    assert not plot.illuminance(x, y, numpy.full((17, 25), 300.0)).texts
    with pytest.raises(ValueError, match=r"lux: expected the shape \(17, 25\)"):
        plot.illuminance(x, y, numpy.ones((25, 17)))


def test_axes_are_those_given(image: Image, mesh: LightMesh) -> None:
    _, axes = matplotlib.pyplot.subplots(2, 2)
    given = list(axes.flat)
    assert plot.picture(image, ax=given[0]) is given[0]
    assert plot.error_map(image, image, ax=given[1]) is given[1]
    assert plot.convergence({"a": (1, 1)}, ax=given[2]) is given[2]
    assert plot.slice_of_mesh(mesh, "y", at=0.5, ax=given[3]) is given[3]
    assert matplotlib.pyplot.get_fignums() == [1]


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)


def test_the_package_does_without_matplotlib() -> None:
    done = run("import sys, lightmesh; assert 'matplotlib' not in sys.modules")
    assert done.returncode == 0, done.stderr


def test_without_matplotlib_it_says_what_to_install() -> None:
    done = run("import sys; sys.modules['matplotlib'] = None\nfrom lightmesh import plot")
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == (
        "ImportError: lightmesh.plot draws with matplotlib, which is not installed: pip install 'lightmesh[plot]'"
    )
