"""Closed forms, for scenes that are made of arrays."""

import math

import numpy
import pytest

from conftest import floor, from_above
from lightmesh import Camera, LightMesh, Material, Scene, units


@pytest.mark.parametrize("method", ["standard", "path"])
def test_a_point_light_above_a_floor(method: str) -> None:
    """E = I cos θ / r², L = albedo E / π, at each pixel's own point of the floor."""
    scene = floor(albedo=0.5)
    scene.add_point_light([0, 2, 0], [100, 50, 0])
    image = scene.render(camera=from_above(), size=(9, 9), spp=1, bounces=0, method=method)
    # The pixels' middles on the floor: the camera's up is -z.
    extent = 4.0 * math.tan(0.15)
    at = (numpy.arange(9) + 0.5) / 4.5 - 1
    x, z = numpy.meshgrid(at * extent, at * extent)
    r2 = x * x + z * z + 4
    illuminance = 100 * (2 / numpy.sqrt(r2)) / r2
    expected = 0.5 / math.pi * illuminance[..., None] * [1, 0.5, 0]
    assert numpy.allclose(numpy.asarray(image), expected, rtol=1e-4)


def test_the_mesh_comes_to_the_same_where_nothing_is_hidden() -> None:
    scene = floor(albedo=0.5)
    scene.add_point_light([0, 2, 0], 100.0)
    image = scene.render(camera=from_above(), size="9x9", spp=1, bounces=0)
    assert numpy.asarray(image)[4, 4] == pytest.approx([0.5 / math.pi * units.lux_from_candela(100, 2)] * 3, rel=1e-4)


def test_a_directional_light_and_a_spot() -> None:
    """A spot's axis is as bright as a point light; a lux that arrives straight is a lux."""
    sun, spot = floor(), floor()
    sun.add_directional_light([0, -3, 0], 10.0)
    spot.add_spot_light([0, 2, 0], [0, -1, 0], 40.0, inner_cone_angle=0.1, outer_cone_angle=0.2)
    for scene in (sun, spot):
        image = scene.render(camera=from_above(), size=(33, 33), spp=1, method="standard")
        assert numpy.asarray(image)[16, 16] == pytest.approx([10 * 0.5 / math.pi] * 3, rel=1e-4)
    assert numpy.asarray(image)[0, 0] == pytest.approx([0.0] * 3)


def test_emission_is_seen_as_it_is() -> None:
    scene = floor()
    scene.add_sphere([0, 1, 0], 0.5, material=Material(emission=[3, 2, 1]))
    image = scene.render(camera=from_above(), size=(9, 9), spp=1, method="path")
    assert numpy.asarray(image)[4, 4] == pytest.approx([3, 2, 1])


def test_a_constant_environment_in_a_map_and_as_a_colour() -> None:
    """A floor that sees half of a sky of L has L albedo; its own colour is seen beside it."""
    for environment in (2.0, [2, 2, 2], numpy.full((2, 4, 3), 2.0)):
        scene = floor(albedo=0.5)
        scene.set_environment(environment, strength=3.0, rotation=40)
        camera = Camera.look_at([0, 1, 8], [0, 1, 0], yfov=0.8)
        light = numpy.asarray(scene.render(camera=camera, size=(9, 9), spp=64, bounces=0, method="path"))
        assert light[0, 4] == pytest.approx([6.0] * 3)
        below = numpy.asarray(scene.render(camera=from_above(), size=(5, 5), spp=256, bounces=0, method="path"))
        assert below.mean() == pytest.approx(3.0, rel=0.02)


def test_a_scene_without_light_gets_a_soft_environment() -> None:
    scene = floor()
    assert numpy.asarray(scene.render(camera=from_above(), size=(5, 5), spp=1)).mean() > 1
    assert any("soft environment" in warning for warning in scene.warnings)


def test_textures_multiply_the_colour() -> None:
    """sRGB 188 is linear 0.5029, a float is what it says."""
    camera = from_above()
    for texels, albedo in [(numpy.full((2, 2, 3), 188, numpy.uint8), 0.5029), (numpy.full((1, 1, 4), 0.25), 0.25)]:
        scene = Scene()
        corners = numpy.array([[-2, 0, -2], [-2, 0, 2], [2, 0, 2], [2, 0, -2]], numpy.float64)
        scene.add_mesh(
            corners,
            numpy.array([[0, 1, 2], [0, 2, 3]], numpy.uint64),
            uvs=[[0, 0], [0, 1], [1, 1], [1, 0]],
            material=Material(base_color=0.8, specular=0, base_color_texture=texels),
        )
        scene.add_directional_light([0, -1, 0], math.pi)
        light = numpy.asarray(scene.render(camera=camera, size=(4, 4), spp=1, method="standard"))
        assert light.mean() == pytest.approx(0.8 * albedo, rel=1e-3)


def test_instances_are_where_their_matrix_says() -> None:
    """The same square 1 m up and half as large, of which a picture from above sees the depth."""
    scene = floor(size=4)
    scene.add_instance(0, [[0.5, 0, 0, 0], [0, 1, 0, 1], [0, 0, 0.5, 0], [0, 0, 0, 1]])
    assert scene.triangle_count == 4
    assert scene.bounds == ((-2, 0, -2), (2, 1, 2))
    depth = scene.render(camera=from_above(), size=(3, 3), spp=1, aov="depth").aovs["depth"]
    assert depth.shape == (3, 3) and depth[1, 1] == pytest.approx(3.0)


def test_what_a_scene_says_of_itself() -> None:
    scene = floor()
    scene.add_point_light([0, 1, 0], [1, 2, 3], range=5)
    scene.add_spot_light([0, 1, 0], [0, -2, 0], 1)
    scene.add_directional_light([1, 0, 0], 2)
    assert scene.add_camera(Camera.look_at([0, 1, 2], [0, 0, 0], name="door")) == 0
    point, spot, sun = scene.lights
    assert (point.kind, point.position, point.direction) == ("point", (0, 1, 0), None)
    assert (point.color, point.range) == ((1, 2, 3), 5)
    assert (spot.kind, spot.direction, spot.range) == ("spot", (0, -1, 0), None)
    assert spot.cone_angles == pytest.approx((0, math.pi / 4))
    assert (sun.kind, sun.position, sun.color) == ("directional", None, (2, 2, 2))
    assert [camera.name for camera in scene.cameras] == ["door"]
    assert scene.light_sample_count == 3
    assert scene.cameras[0].eye == (0, 1, 2)


def test_a_change_is_seen_by_the_next_picture_and_ends_a_mesh() -> None:
    scene = floor()
    scene.add_point_light([0, 2, 0], 1.0)
    mesh = LightMesh(scene)
    options = {"camera": from_above(), "size": (3, 3), "spp": 1}
    first = numpy.asarray(scene.render(mesh=mesh, **options))
    scene.add_point_light([0, 2, 0], 1.0)
    assert numpy.asarray(scene.render(**options)) == pytest.approx(2 * first, rel=1e-3)
    with pytest.raises(ValueError, match="changed"):
        scene.render(mesh=mesh, **options)


def test_cameras_agree_however_they_are_made() -> None:
    scene = floor()
    scene.add_point_light([0, 1, 0], 1.0)
    made = Camera.look_at([0, 2, 3], [0, 0, 0], up=[0, 2, 0])
    z = numpy.array([0, 2, 3]) / math.sqrt(13)
    x = numpy.array([1, 0, 0])
    matrix = numpy.eye(4)
    matrix[:3, :3] = numpy.stack([x, numpy.cross(z, x), z], axis=1)
    matrix[:3, 3] = [0, 2, 3]
    pictures = [
        numpy.asarray(scene.render(camera=camera, size=(16, 9), spp=1, method="standard"))
        for camera in (made, Camera.look_at([0, 2, 3], [0, 0, 0]), Camera.from_matrix(matrix))
    ]
    assert pictures[0] == pytest.approx(pictures[1], rel=1e-4, abs=1e-6)
    assert pictures[0] == pytest.approx(pictures[2], rel=1e-3, abs=1e-5)
