"""What light meshes know, as arrays."""

import gc

import numpy
import pytest
from numpy.typing import NDArray

import lightmesh
from conftest import floor
from lightmesh import LightMesh, Material, Scene

#: As values have them.
SIDES = numpy.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], numpy.float32)


def ball() -> Scene:
    """A ball on a floor under a roof and two lamps."""
    scene = floor(0.6)
    scene.add_instance(0, [[1, 0, 0, 0], [0, -1, 0, 3], [0, 0, 1, 0], [0, 0, 0, 1]])
    scene.add_sphere([0, 0.7, 0], 0.7, material=Material(base_color=[0.8, 0.5, 0.2], specular=0))
    scene.add_point_light([1, 2.5, 0.3], [100, 50, 25])
    scene.add_point_light([-1.2, 2, -0.5], 60.0)
    return scene


def in_ball(points: NDArray[numpy.float32], more: float = 0.0) -> NDArray[numpy.bool_]:
    return numpy.linalg.norm(points - [0, 0.7, 0], axis=1) < 0.7 + more


@pytest.fixture(scope="module")
def scene() -> Scene:
    return ball()


@pytest.fixture(scope="module")
def mesh(scene: Scene) -> LightMesh:
    mesh = LightMesh(scene, spacing=0.2, indirect_spacing=0.4, bounces=2, gather_rays=1024)
    mesh.fill(region=([-2, 0, -2], [2, 3, 2]))
    return mesh


def test_the_sun_is_in_the_sum_with_the_lamps() -> None:
    def filled(scene: Scene) -> NDArray[numpy.float32]:
        mesh = LightMesh(scene, spacing=0.2, bounces=0)
        mesh.fill(region=([-2, 0, -2], [2, 3, 2]))
        order = numpy.lexsort(mesh.points.T)
        return mesh.values[order][mesh.valid[order]]

    sunny = ball()
    sunny.add_directional_light([0, -1, 0], 300.0)
    added = filled(sunny)[:, :, 1] - filled(ball())[:, :, 1]
    assert added[:, 2] == pytest.approx(300, rel=1e-3)
    assert numpy.abs(added[:, [0, 1, 3, 4, 5]]).max() < 0.01


def test_shapes_and_types(mesh: LightMesh) -> None:
    n = len(mesh.points)
    stats = mesh.stats
    assert n == stats["direct"]["points_used"] and n > 1000
    assert numpy.count_nonzero(~mesh.valid) == stats["direct"]["points_invalid"] > 0
    assert (mesh.points.shape, mesh.values.shape, mesh.valid.shape, mesh.levels.shape) == ((n, 3), (n, 6, 2, 3), (n,), (n,))
    m = len(mesh.indirect_points)
    assert m == stats["indirect"]["points_used"]
    assert (mesh.indirect_points.shape, mesh.indirect_values.shape) == ((m, 3), (m, 6, 3))
    assert (mesh.indirect_valid.shape, mesh.indirect_levels.shape) == ((m,), (m,))
    for array in (mesh.points, mesh.values, mesh.indirect_points, mesh.indirect_values):
        assert array.dtype == numpy.float32
    assert mesh.valid.dtype == numpy.bool_ and mesh.levels.dtype == numpy.uint8 and not mesh.levels.any()
    assert mesh.spacing == pytest.approx(0.2) and mesh.indirect_spacing == pytest.approx(0.4)
    # Neighbours are a spacing apart.
    assert numpy.diff(numpy.unique(mesh.points[:, 1].round(4))) == pytest.approx(0.2, abs=1e-3)


def test_arrays_cannot_be_written_to_and_are_views(mesh: LightMesh) -> None:
    for name in ("points", "values", "valid", "levels"):
        for array in (getattr(mesh, name), getattr(mesh, f"indirect_{name}")):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0
            with pytest.raises(ValueError, match="WRITEABLE"):
                array.flags.writeable = True
        assert numpy.shares_memory(getattr(mesh, name), getattr(mesh, name))


def test_arrays_keep_what_they_show(scene: Scene) -> None:
    mesh = LightMesh(scene, spacing=0.2, bounces=0)
    assert mesh.points.shape == (0, 3) and mesh.values.shape == (0, 6, 2, 3) and mesh.valid.shape == (0,)
    assert mesh.indirect_spacing is None
    assert mesh.indirect_points.shape == (0, 3) and mesh.indirect_values.shape == (0, 6, 3)
    mesh.fill([[1.5, 1, 1.5]])
    points, values = mesh.points, mesh.values
    before = points.copy(), values.copy()
    mesh.fill([[-1.5, 1, 1.5]])
    assert len(mesh.points) > len(points)
    del mesh
    gc.collect()
    assert numpy.array_equal(points, before[0]) and numpy.array_equal(values, before[1], equal_nan=True)


def test_points_in_solids_are_invalid_and_have_no_values(mesh: LightMesh) -> None:
    for points, valid, values in [
        (mesh.points, mesh.valid, mesh.values),
        (mesh.indirect_points, mesh.indirect_valid, mesh.indirect_values),
    ]:
        assert not valid[in_ball(points, -0.01)].any()
        open_air = ~in_ball(points, 0.05) & (numpy.abs(points - [0, 1.5, 0]) < [1.9, 1.4, 1.9]).all(axis=1)
        assert open_air.any() and valid[open_air].all()
        flat = values.reshape(len(points), -1)
        assert numpy.isnan(flat[~valid]).all() and numpy.isfinite(flat[valid]).all()


def test_direct_values_are_what_meters_there_read(scene: Scene, mesh: LightMesh) -> None:
    """On the six planes at each point in the open: exact light, and I cos θ / r² for what is unshadowed."""
    points = mesh.points
    chosen = mesh.valid & (numpy.abs(points - [0, 1.5, 0]) < [1.9, 1.4, 1.9]).all(axis=1)
    points, values = points[chosen], mesh.values[chosen]
    shadowed = 0
    for side, normal in enumerate(SIDES):
        exact = scene.irradiance(points, normal, method="standard")
        assert numpy.allclose(values[:, side, 0], exact, rtol=1e-4, atol=1e-4)
        unshadowed = numpy.zeros_like(exact)
        for light in scene.lights:
            assert light.position is not None
            away = numpy.array(light.position) - points
            r = numpy.linalg.norm(away, axis=1)
            unshadowed += numpy.array(light.color) * (numpy.maximum(away @ normal, 0) / r**3)[:, None]
        assert numpy.allclose(values[:, side, 1], unshadowed, rtol=1e-4, atol=1e-4)
        shadowed += numpy.count_nonzero(exact < 0.9 * unshadowed)
    assert shadowed > 100


def test_indirect_values_are_the_light_of_paths_less_the_direct(scene: Scene, mesh: LightMesh) -> None:
    """Within 5% in the mean of points in the open, side by side: the noise of paths is below 1%."""
    points = mesh.indirect_points
    chosen = mesh.indirect_valid & (numpy.abs(points - [0, 1.5, 0]) < [1.9, 1.2, 1.9]).all(axis=1)
    points, values = points[chosen], mesh.indirect_values[chosen]
    for side, normal in enumerate(SIDES):
        paths = scene.irradiance(points, normal, method="path", spp=256, bounces=2)
        indirect = paths - scene.irradiance(points, normal, method="standard")
        assert values[:, side].mean() == pytest.approx(indirect.mean(), rel=0.05)


def test_the_papers_mesh_has_one_value(scene: Scene) -> None:
    mesh = LightMesh(scene, method="paper", spacing=0.4, indirect_spacing=0.8, bounces=1, gather_rays=16)
    mesh.fill([[1.5, 1, 1.5]])
    n, m = len(mesh.points), len(mesh.indirect_points)
    assert mesh.values.shape == (n, 2, 3) and mesh.indirect_values.shape == (m, 3)
    valid = mesh.valid
    # Nothing is brighter than without shadows.
    assert (mesh.values[valid, 0] <= mesh.values[valid, 1]).all() and mesh.indirect_values[mesh.indirect_valid].max() > 0


@pytest.mark.parametrize("method", ["hybrid", "unbiased"])
def test_meshes_of_single_lights_have_no_irradiance(scene: Scene, method: str) -> None:
    mesh = LightMesh(scene, method=method, spacing=0.4, bounces=0)  # type: ignore[arg-type]
    mesh.fill([[1.5, 1, 1.5]])
    assert mesh.points.shape == (len(mesh.valid), 3) and mesh.valid.any()
    with pytest.raises(lightmesh.OptionError, match=r"which lights they see, and no irradiance; use irradiance\(\)"):
        _ = mesh.values


def test_refined_meshes_have_levels(scene: Scene) -> None:
    camera = lightmesh.Camera.look_at([1.5, 1.5, 1.9], [0, 0.3, 0])
    mesh = LightMesh(scene, spacing=0.4, bounces=0, refine=2)
    scene.render(camera=camera, size=(60, 40), spp=1, mesh=mesh)
    assert set(mesh.levels) >= {0, 1}
    assert numpy.count_nonzero(mesh.levels) == mesh.stats["direct"]["points_refined"]
