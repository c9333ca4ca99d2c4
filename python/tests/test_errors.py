"""Whatever is given, the answer is a precise exception."""

from pathlib import Path
from typing import Any

import numpy
import pytest

import lightmesh
from conftest import floor, from_above
from lightmesh import Camera, Image, LightMesh, Material, MemoryLimitError, OptionError, Scene, SceneError

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize(
    ("positions", "triangles", "options", "message"),
    [
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], {}, r"positions: expected the shape \(n, 3\), not \(3, 2\)"),
        ([1, 2, 3], [[0, 1, 2]], {}, r"positions: expected the shape \(n, 3\), not \(3,\)"),
        (["a", "b", "c"], [[0, 1, 2]], {}, "positions: expected real numbers"),
        (numpy.zeros((3, 3), complex), [[0, 1, 2]], {}, "positions: expected real numbers, not complex128"),
        (TRIANGLE, [[0, 1, 2.0]], {}, "triangles: expected whole numbers, not float64"),
        (TRIANGLE, [[0, 1, -2]], {}, "triangles: index -2"),
        (TRIANGLE, [[0, 1, 2**32]], {}, "triangles: index 4294967296"),
        (TRIANGLE, numpy.array([[0, 1, 2**64 - 1]], numpy.uint64), {}, "triangles: index 18446744073709551615"),
        (TRIANGLE, [0, 1, 2], {}, r"triangles: expected the shape \(n, 3\)"),
        (TRIANGLE, [[0, 1, 2]], {"transform": numpy.eye(3)}, r"transform: expected the shape \(4, 4\)"),
        (TRIANGLE, [[0, 1, 2]], {"transform": numpy.ones((4, 4))}, "transform: must be finite, and its last row"),
        (TRIANGLE, [[0, 1, 2]], {"material": 3}, "material: there is no 3; the scene has 0"),
        (TRIANGLE, [[0, 1, 2]], {"colors": [1, 1, 1]}, r"colors: expected the shape \(n, 3\) or \(n, 4\), not \(3,\)"),
        (TRIANGLE, [[0, 1, 2]], {"colors": 1}, r"colors: expected the shape"),
        (TRIANGLE, [[0, 1, 2]], {"uvs": [[0, 0, 0]] * 3}, r"uvs: expected the shape \(n, 2\)"),
    ],
)
def test_arrays_that_are_no_mesh_are_refused_at_once(
    positions: Any, triangles: Any, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(SceneError, match=message):
        Scene().add_mesh(positions, triangles, **options)


@pytest.mark.parametrize(
    ("positions", "triangles", "options", "message"),
    [
        (TRIANGLE, [[0, 1, 3]], {}, "index 3 is out of range"),
        ([[0, 0, float("nan")], *TRIANGLE[1:]], [[0, 1, 2]], {}, "position 0 is not finite"),
        (TRIANGLE, [[0, 1, 2]], {"normals": [[0, 0, 1]]}, "length"),
        (TRIANGLE, [[0, 1, 2]], {"material": Material(base_color=2)}, r"outside \[0, 1\]"),
        (TRIANGLE, [[0, 1, 2]], {"material": Material(emission=-1)}, "emission"),
    ],
)
def test_what_the_scene_is_checked_for_is_said_when_it_is_used(
    positions: Any, triangles: Any, options: dict[str, Any], message: str
) -> None:
    scene = Scene()
    scene.add_mesh(positions, triangles, **options)
    for _ in range(2):
        with pytest.raises(SceneError, match=message):
            scene.render(size=(4, 4))


def test_arrays_may_lie_in_memory_as_they_like() -> None:
    """Other types, strides and byte orders are converted."""
    corners = numpy.array(TRIANGLE, ">f8")[::-1].T.copy().T
    corners.setflags(write=False)
    scene = Scene()
    scene.add_mesh(corners, numpy.array([[0, 1, 2]], numpy.int16)[:, ::-1])
    assert scene.bounds == ((0, 0, 0), (1, 1, 0))


def test_scenes_without_surfaces() -> None:
    with pytest.raises(SceneError, match="no surfaces"):
        Scene().render(size=(4, 4))
    with pytest.raises(SceneError, match="no surfaces"):
        _ = Scene().bounds


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"spp": 0}, "spp: must be between 1 and 65536, not 0"),
        ({"spp": 2.5}, "spp: must be a whole number between 1 and 65536, not 2.5"),
        ({"spp": -1}, "spp: must be a whole number between 1 and 65536, not -1"),
        ({"spacing": "2/80"}, "spacing: must be metres above 0, 1/K of the scene's longest edge, or auto, not \"2/80\""),
        ({"spacing": -1}, "spacing"),
        ({"spacing": float("nan")}, "spacing"),
        ({"method": "magic"}, "method: must be one of auto, mesh, paper, standard, hybrid, unbiased or path, not \"magic\""),
        ({"method": "unbias"}, "did you mean \"unbiased\""),
        ({"size": (0, 4)}, 'size: must be .*, not "0x4"'),
        ({"size": "big"}, 'size: must be .*, not "big"'),
        ({"size": (-1, 4)}, 'not "-1x4"'),
        ({"interpolation": "sphere:99"}, "interpolation"),
        ({"error": -1}, "error: must be above 0"),
        ({"error": 0.1, "method": "path"}, "error: is kept to by the methods auto and mesh alone"),
        ({"aov": ["albedo", "smell"]}, 'aov: must be among albedo, .*, not "smell"'),
        ({"aov": "points", "method": "path"}, "aov: points"),
        ({"environment": "sky.png"}, "environment"),
        ({"environment": numpy.zeros((2, 4, 3))}, "Scene.set_environment"),
        ({"threads": 0}, "threads"),
        ({"max_memory": "much"}, "max_memory"),
        ({"camera": "nobody"}, "camera: there is no \"nobody\"; the scene has"),
        ({"camera": 7}, "camera: there is no \"7\""),
    ],
)
def test_options_are_refused_by_their_python_names(options: dict[str, Any], message: str) -> None:
    scene = floor()
    scene.add_camera(Camera.look_at([0, 1, 2], [0, 0, 0], name="door"))
    with pytest.raises(OptionError, match=message) as caught:
        scene.render(**{"size": (4, 4), "spp": 1, **options})
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, lightmesh.Error)
    assert "--" not in str(caught.value)


@pytest.mark.parametrize(
    "options",
    [{"camera": 1.5j}, {"speed": 1}, {"units": "gltf"}, {"output": "a.png"}, {"spp": True}, {"spp": [1]}, {"size": 3j}, {"progress": 3}, {"mesh": 1}],
)
def test_what_is_no_option_is_a_type_error(options: dict[str, Any]) -> None:
    with pytest.raises(TypeError):
        floor().render(**options)


def test_what_was_meant_is_said() -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'spaceing'; did you mean 'spacing'"):
        floor().render(spaceing="1/80")
    with pytest.raises(TypeError, match="did you mean 'camera'"):
        floor().render(camra=0)
    with pytest.raises(TypeError, match="argument 'colour'$"):
        floor().render(colour=1)
    with pytest.raises(TypeError, match="spp: must be a whole number, not list"):
        floor().render(spp=[1])


def test_sizes_are_tuples_lists_and_text() -> None:
    for size in [(6, 4), [6, 4], "6x4", numpy.array([6, 4])]:
        assert floor().render(camera=from_above(), size=size, spp=1).shape == (4, 6, 3)


def test_an_old_name_still_works_and_says_the_new_one() -> None:
    options: dict[str, Any] = {"camera": from_above(), "size": (4, 4), "spp": 1}
    with pytest.warns(DeprecationWarning, match="'graded' is now called 'lod_distance'"):
        old = floor().render(graded=2.0, **options)
    assert numpy.array_equal(old, floor().render(lod_distance=2.0, **options))
    assert floor().render(method="exact", **options).stats["method"] == "standard"


def test_memory_has_a_limit(scenes: Path) -> None:
    with pytest.raises(MemoryLimitError, match="raise max_memory") as caught:
        floor().render(size=(4000, 4000), max_memory="10MB")
    assert isinstance(caught.value, MemoryError)
    with pytest.raises(MemoryLimitError, match="raise max_memory"):
        Scene.load(scenes / "room_15.glb", max_memory=1000)


def test_files_raise_pythons_own(tmp_path: Path, scenes: Path) -> None:
    missing = tmp_path / "no.glb"
    with pytest.raises(FileNotFoundError) as caught:
        Scene.load(missing)
    assert caught.value.filename == str(missing)
    with pytest.raises(IsADirectoryError):
        floor().render(camera=from_above(), size=(2, 2)).save(_folder(tmp_path / "a.png"))
    with pytest.raises(FileNotFoundError):
        floor().render(camera=from_above(), size=(2, 2)).save(tmp_path / "no" / "a.png")
    with pytest.raises(FileNotFoundError):
        floor().render(environment=tmp_path / "no.hdr", size=(2, 2))
    with pytest.raises(FileNotFoundError):
        Image.open(tmp_path / "no.exr")
    damaged = tmp_path / "damaged.glb"
    damaged.write_bytes((scenes / "triangle.glb").read_bytes()[:40])
    with pytest.raises(SceneError, match="damaged.glb"):
        Scene.load(damaged)
    text = tmp_path / "scene.txt"
    text.write_text("no scene")
    with pytest.raises(SceneError, match="txt"):
        Scene.load(text)
    for options in ({"units": "feet"}, {"max_memory": "0"}, {"scene": "no such"}):
        with pytest.raises(OptionError):
            Scene.load(scenes / "triangle.glb", **options)


def _folder(path: Path) -> Path:
    path.mkdir()
    return path


@pytest.mark.parametrize(
    "make",
    [
        lambda: Camera.look_at([0, 0, 0], [0, 0, 0]),
        lambda: Camera.look_at([0, 0], [0, 0, 0]),
        lambda: Camera.look_at([0, 1, 0], [0, 0, 0], up=[0, 1, 0]),
        lambda: Camera.look_at([0, 1, 0], [0, 0, 0], yfov=4),
        lambda: Camera.look_at([0, 1, float("inf")], [0, 0, 0]),
        lambda: Camera.look_at([0, 1, 0], [0, 0, 0], aspect=0),
        lambda: Camera.from_matrix(numpy.full((4, 4), numpy.nan)),
        lambda: Camera.orthographic(numpy.eye(4), xmag=0, ymag=1),
        lambda: Material(alpha_mode="glass"),
        lambda: Material(base_color=[1, 2]),
        lambda: Material(base_color_texture=numpy.zeros((2, 2), numpy.uint8)),
        lambda: Material(base_color_texture=numpy.zeros((2, 2, 3), numpy.int32)),
        lambda: Material(emission_texture=numpy.full((1, 1, 3), numpy.inf)),
        lambda: Scene().add_instance(0, numpy.eye(4)),
        lambda: Scene().add_spot_light([0, 0, 0], [0, 0, 0], 1),
        lambda: Scene().set_environment([1, 2, 3, 4]),
    ],
)
def test_values_that_nothing_can_have(make: Any) -> None:
    with pytest.raises(SceneError):
        make()


def test_meshes_serve_their_scene_and_options(cornell: Scene) -> None:
    mesh = LightMesh(cornell, spacing="1/20", bounces=0)
    for scene, options, message in [
        (floor(), {}, "another scene"),
        (cornell, {"spacing": "1/30"}, "the mesh was made with spacing 1/20, and the options ask for 1/30"),
        (cornell, {"light_radius": 0.1}, "light_radius"),
    ]:
        with pytest.raises(OptionError, match=message):
            scene.render(mesh=mesh, size=(4, 4), **options)
    with pytest.raises(OptionError, match="have no mesh"):
        LightMesh(cornell, method="path")
    with pytest.raises(TypeError):
        LightMesh(cornell, progress=True)
    with pytest.raises(TypeError):
        LightMesh("cornell.glb")
    for material in (-1, "red"):
        with pytest.raises(TypeError, match="must be a Material"):
            Scene().add_sphere([0, 0, 0], 1, material=material)
