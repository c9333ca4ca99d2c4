"""Irradiance at meters: closed forms in lux, the path tracer, and meshes that are filled ahead."""

import math
import os
import signal
import sys
import threading
import time
from pathlib import Path

import numpy
import pytest
from numpy.typing import NDArray

import lightmesh
from conftest import floor
from lightmesh import LightMesh, Material, Scene

#: Exact, from a mesh, and sampled.
METHODS = [("standard", 1), ("mesh", 1), ("path", 16384)]
LAMP = Material(base_color=0.0, specular=0.0, emission=100.0)


def roofed(albedo: float = 0.5) -> Scene:
    """A floor with a roof 4 m above it, so that meters between them are inside the scene's box."""
    scene = floor(albedo, size=6)
    scene.add_instance(0, [[1, 0, 0, 0], [0, -1, 0, 4], [0, 0, 1, 0], [0, 0, 0, 1]])
    return scene


def lambert(corners: NDArray[numpy.float64], at: NDArray[numpy.float64], normal: NDArray[numpy.float64]) -> float:
    """Irradiance from a polygon of radiance 1 that is all above the meter's plane: E = 1/2 sum Θ_i n·Γ_i, Θ_i the angle that edge i spans
    and Γ_i the unit normal of its plane with the meter (Lambert, Photometria, 1760)."""
    total = 0.0
    for a, b in zip(corners - at, numpy.roll(corners, -1, axis=0) - at, strict=True):
        across = numpy.cross(a, b)
        angle = math.atan2(float(numpy.linalg.norm(across)), float(a @ b))
        total += angle * float(normal @ across) / float(numpy.linalg.norm(across))
    return abs(total) / 2


@pytest.mark.parametrize("method", ["standard", "mesh", "path"])
def test_a_point_light(method: str) -> None:
    """E = I cos θ / r², at meters of every direction."""
    scene = roofed()
    lamp, intensity = numpy.array([0.3, 2.7, -0.2]), numpy.array([100.0, 50.0, 10.0])
    scene.add_point_light(lamp, intensity)
    random = numpy.random.default_rng(1)
    positions = random.uniform([-2, 0.1, -2], [2, 2, 2], (50, 3))
    normals = random.normal(size=(50, 3))
    to_lamp = lamp - positions
    r = numpy.linalg.norm(to_lamp, axis=1)
    cosine = numpy.sum(normals * to_lamp, axis=1) / r / numpy.linalg.norm(normals, axis=1)
    expected = intensity * (numpy.maximum(cosine, 0) / r**2)[:, None]
    found = scene.irradiance(positions, normals, method=method, bounces=0)  # type: ignore[arg-type]
    assert found.dtype == numpy.float32 and found.shape == (50, 3)
    assert numpy.allclose(found, expected, rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize(("method", "spp"), METHODS)
def test_a_sphere(method: str, spp: int) -> None:
    """E = π L (R/d)² on a plane that faces it, within 1%."""
    scene = roofed()
    scene.add_sphere([0, 2.2, 0], 0.3, material=LAMP)
    found = scene.irradiance(
        [[0, 0, 0], [0, 0.7, 0]], [0, 1, 0], method=method, spp=spp, bounces=0, light_samples=4096  # type: ignore[arg-type]
    )
    expected = [math.pi * 100 * (0.3 / d) ** 2 for d in (2.2, 1.5)]
    assert numpy.allclose(found, numpy.array(expected)[:, None], rtol=0.01)


@pytest.mark.parametrize(("method", "spp"), METHODS)
def test_a_rectangle_straight_above(method: str, spp: int) -> None:
    """E = π L F, F four times the configuration factor of a rectangle a x b at the height h that has a corner above the meter:
    1/2π (A/√(1+A²) atan(B/√(1+A²)) + B/√(1+B²) atan(A/√(1+B²))), A = a/h, B = b/h (Howell, A Catalog of Radiation Heat Transfer
    Configuration Factors, B-3). Within 1%."""
    scene = roofed()
    corners = [[-0.5, 2, -0.75], [0.5, 2, -0.75], [0.5, 2, 0.75], [-0.5, 2, 0.75]]
    scene.add_mesh(corners, [[0, 1, 2], [0, 2, 3]], material=LAMP)
    a, b = 0.5 / 2, 0.75 / 2
    u, v = math.sqrt(1 + a * a), math.sqrt(1 + b * b)
    factor = 4 * (a / u * math.atan(b / u) + b / v * math.atan(a / v)) / (2 * math.pi)
    assert factor * math.pi == pytest.approx(lambert(numpy.array(corners), numpy.zeros(3), numpy.array([0.0, 1, 0])))
    found = scene.irradiance([[0, 0, 0]], [0, 1, 0], method=method, spp=spp, bounces=0, light_samples=4096)  # type: ignore[arg-type]
    assert numpy.allclose(found, math.pi * 100 * factor, rtol=0.01)


@pytest.mark.parametrize(("method", "spp"), METHODS)
def test_a_mesh_that_shines(method: str, spp: int) -> None:
    """A tilted star of eighteen triangles about its middle, by Lambert's formula, within 1%, at meters beside it."""
    scene = roofed()
    angles = numpy.arange(18) * math.tau / 18
    radii = 0.4 + 0.1 * (numpy.arange(18) % 2)
    tilted = numpy.stack([radii * numpy.cos(angles), 0.3 * radii * numpy.sin(angles), radii * numpy.sin(angles)], axis=1)
    corners = tilted + [0, 2.2, 0]
    triangles = [[18, i, (i + 1) % 18] for i in range(18)]
    scene.add_mesh([*corners, [0, 2.2, 0]], triangles, material=LAMP)
    meters = numpy.array([[0.2, 0.5, -0.3], [0.9, 0.85, -0.7], [-1.5, 0.3, 0.2]])
    normal = numpy.array([0.2, 1, -0.1]) / math.sqrt(1.05)
    found = scene.irradiance(meters, normal, method=method, spp=spp, bounces=0, light_samples=4096)  # type: ignore[arg-type]
    expected = [100 * lambert(corners, at, normal) for at in meters]
    assert numpy.allclose(found, numpy.array(expected)[:, None], rtol=0.01)


@pytest.fixture(scope="module")
def room() -> Scene:
    return Scene.load(Path(__file__).parents[2] / "scenes" / "room_15.glb")


def work_plane(scene: Scene, columns: int) -> NDArray[numpy.float32]:
    """Places 0.85 m above the floor, over all of it but 0.1 m at the walls."""
    least, largest = scene.bounds
    x, z = (numpy.linspace(least[axis] + 0.1, largest[axis] - 0.1, columns, dtype=numpy.float32) for axis in (0, 2))
    grid = numpy.stack(numpy.meshgrid(x, [numpy.float32(least[1] + 0.85)], z), axis=-1)
    return grid.reshape(-1, 3)


def test_a_million_meters_and_the_path_tracer(room: Scene, capsys: pytest.CaptureFixture[str]) -> None:
    """A Z-test at 200 of a million meters, ten of each run of the path tracer having seeds of its own: their mean, and the standard error s
    of that. The mesh is allowed an error of its own of 5% of the plane's mean (README: 3.5% in this room for direct light). Then
    z = (mesh - path) / √(s² + (5% of the mean)²) has a mean square of 1 at most, but for chance: at most 1.3, three standard deviations
    of a mean of 200 squares of normal numbers."""
    positions = work_plane(room, 1000)
    mesh = LightMesh(room)
    begun = time.perf_counter()
    lux = mesh.irradiance(positions, [0, 1, 0])
    first = time.perf_counter() - begun
    begun = time.perf_counter()
    again = mesh.irradiance(positions, [0, 1, 0])
    second = time.perf_counter() - begun
    assert lux.shape == (1_000_000, 3) and numpy.isfinite(lux).all() and numpy.array_equal(lux, again)

    some = numpy.random.default_rng(7).choice(len(positions), 200, replace=False)
    path, error = repeated(room, positions[some], method="path", spp=64)
    z = (lux[some].mean(axis=1) - path) / numpy.sqrt(error**2 + (0.05 * path.mean()) ** 2)
    bias = lux[some].mean() / path.mean() - 1
    with capsys.disabled():
        print(
            f"\n1e6 meters: {first:.1f} s, again {second:.1f} s; mean z² {numpy.mean(z**2):.2f}, largest |z| {abs(z).max():.1f}, "
            f"bias {100 * bias:+.1f}%, noise of paths {100 * error.mean() / path.mean():.1f}%"
        )
    assert numpy.mean(z**2) <= 1.3
    assert abs(bias) < 0.05


def test_unbiased_meters_are_paths_in_the_mean(room: Scene) -> None:
    """A Z-test without allowance, whose mesh is coarse: means of ten runs of either, of 200 meters. z = (mesh - path) / √(s² + t²), s and t their standard
    errors, has the mean square 9/7 (of t with 18 degrees of freedom 9/8, with 9 9/7) and the mean 0: at most 1.6, and 3/√200."""
    positions = work_plane(room, 100)[numpy.random.default_rng(3).choice(10_000, 200, replace=False)]
    coarse = {"spacing": "1/20", "indirect_spacing": "1/10", "gather_rays": 32}
    # In furniture nothing is to be found.
    positions = positions[room.irradiance(positions, [0, 1, 0], method="standard").max(axis=1) > 0]
    path, s = repeated(room, positions, method="path", spp=64)
    mesh, t = repeated(room, positions, method="unbiased", rays=4, **coarse)
    z = (mesh - path) / numpy.sqrt(s**2 + t**2)
    assert numpy.mean(z**2) <= 1.6
    assert abs(z.mean()) <= 3 / math.sqrt(len(z)), z.mean()


def repeated(scene: Scene, positions: NDArray[numpy.float32], **options: object) -> list[NDArray[numpy.float64]]:
    """The mean over channels and ten seeds of what arrives from above, and its standard error."""
    runs = numpy.stack(
        [
            scene.irradiance(positions, [0, 1, 0], seed=seed, **options).mean(axis=1, dtype=numpy.float64)  # type: ignore[arg-type]
            for seed in range(10)
        ]
    )
    return [runs.mean(axis=0), runs.std(axis=0, ddof=1) / math.sqrt(10)]


def test_filling_ahead_leaves_no_rays_to_shoot() -> None:
    """In the open, where every meter finds points to read."""
    scene = roofed()
    scene.add_sphere([0, 1, 0], 0.5)
    scene.add_point_light([0.5, 3, 0.2], 100.0)
    options = {"bounces": 1, "gather_rays": 16}
    positions = numpy.random.default_rng(2).uniform([0.8, 0.5, 0.8], [1.6, 2, 1.6], (1000, 3))
    cold = LightMesh(scene, **options).measure(positions, [0, 1, 0])
    assert cold.stats["rays"]["shadow"] > 0 and cold.stats["rays"]["gather"] > 0

    # Everything that meters there read; everything in a box that goes a spacing beyond them.
    around, boxed = LightMesh(scene, **options), LightMesh(scene, **options)
    filled = around.fill(positions)
    assert filled["rays"]["shadow"] > 0 and filled["seconds"]["total"] > 0
    more = 1.01 * (boxed.indirect_spacing or 0)
    boxed.fill(region=(positions.min(axis=0) - more, positions.max(axis=0) + more))
    for warm in (around, boxed):
        measured = warm.measure(positions, [0, 1, 0])
        assert measured.stats["rays"]["shadow"] == measured.stats["rays"]["gather"] == 0
        assert measured.stats["fallbacks"] == {"direct": 0, "indirect": 0}
        assert numpy.array_equal(measured.irradiance, cold.irradiance)
        assert warm.fill(positions)["rays"] == {"primary": 0, "shadow": 0, "gather": 0, "secondary": 0}


def test_parts_are_the_whole_and_depend_on_the_place_alone(room: Scene) -> None:
    positions = work_plane(room, 20)
    mesh = LightMesh(room, bounces=1, gather_rays=16)
    direct, indirect, stats = measured = mesh.measure(positions, [0, 2, 0])
    assert stats["method"] == "mesh" and stats["mesh"]["direct"]["points_used"] > 0
    assert numpy.array_equal(measured.irradiance, direct + indirect)
    assert numpy.array_equal(measured.irradiance, mesh.irradiance(positions, numpy.tile([0.0, 1, 0], (400, 1))))
    assert numpy.array_equal(indirect, mesh.indirect(positions, [0, 1, 0]))
    # The direct mesh alone is asked for direct light.
    other = LightMesh(room, bounces=1, gather_rays=16, threads=1)
    assert numpy.array_equal(direct[::7], other.direct(positions[::7], [0, 1, 0]))
    assert len(other.indirect_points) == 0 and len(mesh.indirect_points) > 0
    options = {"bounces": 1, "gather_rays": 16}
    assert numpy.array_equal(measured.irradiance, room.irradiance(positions, [0, 1, 0], **options))
    assert numpy.array_equal(measured.irradiance, room.irradiance(positions, [0, 1, 0], mesh=other))
    # Results are the caller's to change.
    direct += 1
    assert mesh.irradiance(numpy.empty((0, 3)), [0, 1, 0]).shape == (0, 3)


@pytest.mark.parametrize("method", ["paper", "hybrid", "unbiased"])
def test_every_method_of_a_mesh_measures(method: str) -> None:
    scene = roofed()
    scene.add_point_light([0, 2, 0], 100.0)
    mesh = LightMesh(scene, method=method, bounces=0, rays=64)  # type: ignore[arg-type]
    assert mesh.irradiance([[0, 0, 0]], [0, 1, 0]) == pytest.approx(numpy.full((1, 3), 25.0), rel=0.02)


def test_what_cannot_be_measured_is_said(cornell: Scene) -> None:
    mesh = LightMesh(cornell)
    inside, up = [[0, 0.3, 0]], [0, 1, 0]
    for positions, normals, what in [
        ([0, 0.3, 0], up, "positions: expected the shape"),
        (inside, [[0, 1, 0], [0, 1, 0]], r"normals: expected the shape \(1, 3\) of positions or \(3,\), not \(2, 3\)"),
        (inside, [0, 1], "normals"),
        ([[0, math.nan, 0]], up, "meter 0: the position"),
        (inside, [0, 0, 0], "meter 0: the normal is zero"),
        (["here"], up, "positions: expected real numbers"),
    ]:
        with pytest.raises(lightmesh.SceneError, match=what):
            mesh.irradiance(positions, normals)
    for name, value in {"refine": 1, "lod_distance": 2.0, "time_limit": 1.0}.items():
        with pytest.raises(lightmesh.OptionError, match=name):
            LightMesh(cornell, **{name: value}).irradiance(inside, up)
        with pytest.raises(lightmesh.OptionError, match=name):
            cornell.irradiance(inside, up, **{name: value})
    for name in ("size", "aov", "cutoff", "camera", "speed"):
        with pytest.raises(TypeError, match=rf"irradiance\(\) got an unexpected keyword argument '{name}'"):
            cornell.irradiance(inside, up, **{name: 1})
    with pytest.raises(lightmesh.OptionError, match="was made with (method|spacing)"):
        cornell.irradiance(inside, up, mesh=mesh, spacing="1/10")
    with pytest.raises(lightmesh.MemoryLimitError):
        cornell.irradiance(numpy.zeros((1000, 3)), up, method="standard", max_memory=10_000)


def test_filling_takes_places_or_a_box(cornell: Scene) -> None:
    mesh = LightMesh(cornell, bounces=0)
    for arguments in ({}, {"points": [[0, 0, 0]], "region": cornell.bounds}):
        with pytest.raises(TypeError, match="either points or region"):
            mesh.fill(**arguments)  # type: ignore[arg-type]
    for region in ([[0, 0, 0]], [[0, 0, 0], [1, -1, 1]], [[0, 0, 0], [1, math.inf, 1]]):
        with pytest.raises(lightmesh.SceneError, match="region"):
            mesh.fill(region=region)
    with pytest.raises(lightmesh.SceneError, match="points: .* of index 1 is not finite"):
        mesh.fill([[0, 0, 0], [0, math.nan, 0]])
    assert mesh.fill([[50, 0, 0]])["mesh"]["direct"]["points_used"] == 0
    scene = floor()
    mesh = LightMesh(scene, bounces=0)
    scene.add_point_light([0, 1, 0], 1)
    for use in (lambda: mesh.fill([[0, 0, 0]]), lambda: mesh.irradiance([[0, 0, 0]], [0, 1, 0])):
        with pytest.raises(lightmesh.OptionError, match="the scene was changed"):
            use()


class Stop(Exception):
    pass


def test_callbacks_hear_of_it_and_may_end_it(cornell: Scene) -> None:
    mesh = LightMesh(cornell, bounces=1, gather_rays=64)
    reports: list[tuple[str, int, int, int]] = []
    positions = work_plane(cornell, 5) * [1, 0, 1] + [0, 0.3, 0]
    mesh.fill(positions, progress=lambda *report: reports.append(report))
    mesh.irradiance(positions, [0, 1, 0], progress=lambda *report: reports.append(report))
    assert {report[0] for report in reports} == {"fill", "measure"}
    assert reports[-1][1] == reports[-1][2] == 25

    def stop(stage: str, done: int, total: int, rays: int) -> None:
        # While somebody works with a mesh, others do not.
        with pytest.raises(lightmesh.Error, match="another thread works with it"):
            _ = mesh.stats
        with pytest.raises(lightmesh.Error, match="another thread works with it"):
            mesh.irradiance(positions, [0, 1, 0])
        raise Stop

    begun = time.monotonic()
    with pytest.raises(Stop):
        mesh.fill(region=cornell.bounds, progress=stop)
    assert time.monotonic() - begun < 10
    fresh = LightMesh(cornell, bounces=1, gather_rays=64)
    assert numpy.array_equal(mesh.irradiance(positions, [0, 1, 0]), fresh.irradiance(positions, [0, 1, 0]))


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals like these")
def test_ctrl_c_ends_it_soon(cornell: Scene) -> None:
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        cornell.irradiance(work_plane(cornell, 300) + [0, -0.6, 0], [0, 1, 0], method="path", spp=4096)
    assert time.monotonic() - begun < 10
