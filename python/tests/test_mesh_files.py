"""Light meshes in files."""

import json
import struct
from pathlib import Path

import numpy
import pytest

import lightmesh
from conftest import floor
from lightmesh import LightMesh, Scene

OPTIONS = {"spacing": "1/20", "indirect_spacing": "1/10", "bounces": 2, "gather_rays": 32, "seed": 5}
PICTURE = {"size": (40, 40), "spp": 1}


@pytest.mark.parametrize("method", ["mesh", "paper", "hybrid", "unbiased"])
def test_a_mesh_from_a_file_renders_the_same_picture(cornell: Scene, scenes: Path, tmp_path: Path, method: str) -> None:
    path = tmp_path / "a.safetensors"
    mesh = LightMesh(cornell, cameras=[None], method=method, **OPTIONS)
    image = cornell.render(mesh=mesh, **PICTURE)
    mesh.save(path)
    # As if in another process: the file knows the settings.
    scene = Scene.load(scenes / "cornell.glb")
    loaded = LightMesh.load(path, scene)
    assert loaded.stats["direct"]["points_used"] == mesh.stats["direct"]["points_used"] > 0
    again = scene.render(mesh=loaded, **PICTURE)
    assert numpy.array_equal(image, again)
    # Points that were only probed are not in the file.
    found, expected = again.stats["mesh"], image.stats["mesh"]
    for part in ("direct", "indirect"):
        assert found[part].pop("bytes") <= expected[part].pop("bytes")
    assert again.stats["method"] == method and found == expected
    if method != "unbiased":
        assert image.stats["rays"]["gather"] > again.stats["rays"]["gather"] == 0
    # Equal meshes are equal files.
    loaded.save(tmp_path / "b.safetensors")
    assert path.read_bytes() == (tmp_path / "b.safetensors").read_bytes()
    assert {file.name for file in tmp_path.iterdir()} == {"a.safetensors", "b.safetensors"}


def test_a_mesh_goes_on_with_fewer_bounces(cornell: Scene, tmp_path: Path) -> None:
    path = tmp_path / "a.safetensors"
    mesh = LightMesh(cornell, **OPTIONS)
    cornell.render(mesh=mesh, **PICTURE)
    mesh.save(path)
    fewer = LightMesh.load(path, cornell, bounces=1)
    image = cornell.render(mesh=fewer, **PICTURE)
    assert numpy.array_equal(image, cornell.render(method="mesh", **{**OPTIONS, **PICTURE, "bounces": 1}))
    assert (fewer.indirect_values[fewer.indirect_valid] <= mesh.indirect_values[mesh.indirect_valid] + 1e-6).all()


def test_other_programs_read_what_the_arrays_say(cornell: Scene, tmp_path: Path) -> None:
    path = tmp_path / "a.safetensors"
    mesh = LightMesh(cornell, **OPTIONS)
    mesh.fill([[0, 0.2, 0], [0.1, 0.3, -0.1]])
    mesh.save(path)
    data = path.read_bytes()
    (length,) = struct.unpack_from("<Q", data)
    header = json.loads(data[8 : 8 + length])
    settings = json.loads(header["__metadata__"]["settings"])
    assert settings["spacing"] == "1/20" and settings["seed"] == 5 and header["__metadata__"]["method"] == "mesh"

    def array(name: str) -> "numpy.ndarray[tuple[int, ...], numpy.dtype[numpy.float32]]":
        begin, end = header[name]["data_offsets"]
        values = numpy.frombuffer(data[8 + length :][begin:end], "<f4")
        return values.reshape(header[name]["shape"])

    for part, values in [("direct", array("direct.six_axis")), ("indirect", array("indirect.values")[-1])]:
        points, valid, known = (
            getattr(mesh, name if part == "direct" else f"indirect_{name}") for name in ("points", "valid", "values")
        )
        assert numpy.array_equal(points[valid], array(f"{part}.positions"))
        assert numpy.array_equal(points[~valid], array(f"{part}.invalid_positions"))
        assert numpy.array_equal(known[valid], values)


def test_what_does_not_belong_together_is_refused(cornell: Scene, scenes: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.safetensors"
    LightMesh(cornell, **OPTIONS).save(path)
    with pytest.raises(lightmesh.SceneError, match="a.safetensors: was made for another scene"):
        LightMesh.load(path, Scene.load(scenes / "room_5.glb"))
    for name, value in {"spacing": "1/21", "method": "paper", "seed": 6, "error": 0.1}.items():
        with pytest.raises(lightmesh.OptionError, match="a.safetensors: the mesh was made with .*, and the options ask for"):
            LightMesh.load(path, cornell, **{name: value})
    with pytest.raises(lightmesh.OptionError, match="made with bounces 2, and the options ask for 3"):
        LightMesh.load(path, cornell, bounces=3)
    with pytest.raises(lightmesh.OptionError, match="standard and path have no mesh"):
        LightMesh.load(path, cornell, method="path")
    with pytest.raises(TypeError, match="unexpected keyword argument 'speed'"):
        LightMesh.load(path, cornell, speed=1)  # type: ignore[call-arg]
    with pytest.raises(lightmesh.MemoryLimitError):
        LightMesh.load(path, cornell, max_memory=100)


def test_files_that_are_none_are_refused(cornell: Scene, tmp_path: Path) -> None:
    path = tmp_path / "a.safetensors"
    mesh = LightMesh(cornell, **OPTIONS)
    mesh.fill([[0, 0.2, 0]])
    with pytest.raises(FileNotFoundError):
        LightMesh.load(path, cornell)
    for place in (tmp_path / "no" / "a.safetensors", tmp_path):
        with pytest.raises(OSError):
            mesh.save(place)
    mesh.save(path)
    data = path.read_bytes()
    for damaged, what in [
        (b"", "0 bytes"),
        (data[:-1], "cut off"),
        (data[:-1] + bytes([data[-1] ^ 1]), "damaged"),
        (data.replace(b'\\"bounces\\":2', b'\\"bounces\\":x'), "other settings|bounces"),
        (data.replace(b'\\"seed\\":5', b'\\"seed\\":-'), "other settings"),
        (data.replace(b'\\"1/20\\"', b'\\"1/-2\\"'), "a.safetensors: settings: spacing"),
    ]:
        assert damaged != data
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match=what):
            LightMesh.load(path, cornell)


def test_an_environment_that_is_a_file_has_to_be_named(tmp_path: Path) -> None:
    scene, path, sky = floor(), tmp_path / "a.safetensors", tmp_path / "sky.exr"
    environment = Scene()
    environment.add_sphere([0, 0, 0], 1)
    environment.render(size=(8, 4), spp=1, environment=(1, 2, 3)).save(sky)
    coloured = LightMesh(scene, environment=(1, 2, 3), bounces=0)
    coloured.save(path)
    assert LightMesh.load(path, scene).stats == coloured.stats
    LightMesh(scene, environment=sky, bounces=0).save(path)
    with pytest.raises(lightmesh.SceneError, match="another scene.*sky.exr: say so with environment="):
        LightMesh.load(path, scene)
    LightMesh.load(path, scene, environment=sky)


class Stop(Exception):
    pass


def test_saving_is_heard_of_and_may_be_ended(cornell: Scene, tmp_path: Path) -> None:
    mesh = LightMesh(cornell, spacing="1/60", bounces=0)
    mesh.fill(region=cornell.bounds)
    reports: list[tuple[str, int, int, int]] = []
    mesh.save(tmp_path / "a.safetensors", progress=lambda *report: reports.append(report))
    stage, done, total, rays = reports[-1]
    assert stage == "save" and done == total > 10_000_000 and rays == 0
    assert total == pytest.approx((tmp_path / "a.safetensors").stat().st_size, abs=10_000)
