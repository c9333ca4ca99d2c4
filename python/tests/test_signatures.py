"""Names, defaults and types: of the command line, of the signatures and of the stubs."""

import ast
import inspect
import os
import subprocess
import sys
from pathlib import Path

import pytest

import lightmesh
from conftest import REPOSITORY
from lightmesh import LightMesh, OptionError, Scene
from lightmesh._native import _options

#: What Python has beside the options.
OWN = {"self", "camera", "cameras", "denoise", "mesh", "progress"}


def defaults(function: object) -> dict[str, object]:
    parameters = inspect.signature(function).parameters  # type: ignore[arg-type]
    keywords = (p for p in parameters.values() if p.kind is inspect.Parameter.KEYWORD_ONLY)
    return {p.name: p.default for p in keywords}


def same(python: object, rust: str | None) -> bool:
    """Whether a default of Python is that text of the table."""
    if python is None or rust is None or isinstance(python, str):
        return python == rust
    return isinstance(python, bool) is False and float(str(python)) == float(rust)


def test_signatures_have_the_options_and_defaults_of_the_table() -> None:
    table = {option["name"]: option["default"] for option in _options()}
    render, mesh = defaults(Scene.render), defaults(LightMesh)
    assert set(render) == set(table) | (OWN - {"self", "cameras"})
    assert set(mesh) == set(table) | {"cameras"}
    meters = defaults(Scene.irradiance)
    assert set(render) - set(meters) == {
        "camera", "denoise", "size", "aov", "cutoff", "time_limit", "most_spp", "quality", "error", "refine", "lod_distance"
    }  # fmt: skip
    # The mesh itself, where no picture is to have an error.
    assert mesh.pop("method") == meters.pop("method") == "mesh"
    for chosen in (render, mesh, meters):
        assert chosen.pop("denoise", False) is False
        for name, default in chosen.items():
            assert same(default, table.get(name)), (name, default, table.get(name))
    # A loaded mesh has the options of its file.
    of_load = defaults(LightMesh.load)
    assert set(of_load) == set(table)
    for name, default in of_load.items():
        assert default is None or same(default, table[name]), name
    assert defaults(Scene.load)["max_memory"] == table["max_memory"]


def test_every_option_can_be_given_its_own_default(cornell: Scene) -> None:
    options = {name: value for name, value in defaults(Scene.render).items() if value is not None}
    image = cornell.render(**{**options, "size": (4, 4), "spp": 1})
    assert image.stats["method"] == "auto"


#: The annotation of each kind of option, where it has a value.
TYPES = {
    "int": {"int"},
    "float": {"float"},
    "word": {"_Method", "_Quality", "_Weight", "_PaperScale"},
    "words": {"str | Sequence[str]"},
    "size": {"_Size"},
    "number or text": {"float | str", "int | str", "float"},
    "text": {"str", "_Environment"},
}


def test_stubs_have_the_signatures_and_the_types_of_the_table() -> None:
    """Those of `python -m mypy.stubtest`, without mypy: names and defaults of the long ones; and their types."""
    types = {option["name"]: TYPES[option["type"]] for option in _options()}
    text = Path(lightmesh.__file__).with_name("_native.pyi").read_text()
    classes = {node.name: node for node in ast.parse(text).body if isinstance(node, ast.ClassDef)}
    functions = [
        ("Scene", "render", Scene.render),
        ("Scene", "irradiance", Scene.irradiance),
        ("LightMesh", "__new__", LightMesh),
        ("LightMesh", "load", LightMesh.load),
    ]
    for name, function, thing in functions:
        stub = next(n for n in classes[name].body if isinstance(n, ast.FunctionDef) and n.name == function)
        found = {
            argument.arg: ast.literal_eval(default)
            for argument, default in zip(stub.args.kwonlyargs, stub.args.kw_defaults, strict=True)
            if default is not None
        }
        assert list(found.items()) == list(defaults(thing).items()), function
        for argument in stub.args.kwonlyargs:
            assert argument.annotation is not None
            annotation = ast.unparse(argument.annotation).removesuffix(" | None")
            assert argument.arg in OWN or annotation in types[argument.arg], (function, argument.arg, annotation)


def test_words_of_the_stubs_are_those_of_the_table(cornell: Scene) -> None:
    text = Path(lightmesh.__file__).with_name("_native.pyi").read_text()
    for alias, option in [("_Method", "method"), ("_Quality", "quality"), ("_Weight", "weight"), ("_PaperScale", "paper_scale")]:
        literal = text.split(f"{alias}: TypeAlias = Literal[")[1].split("]")[0]
        words = [word.strip().strip('"') for word in literal.split(",")]
        with pytest.raises(OptionError) as caught:
            cornell.render(**{option: "no such"})
        said = str(caught.value)
        assert all(word in said for word in words if word != "exact"), said


def test_everything_public_is_documented() -> None:
    for name in lightmesh.__all__:
        thing = getattr(lightmesh, name)
        if name.startswith("_"):
            continue
        assert thing.__doc__, name
        members = {name: getattr(thing, name) for name in getattr(thing, "__all__", vars(thing))}
        for member, value in members.items():
            if not member.startswith("_") and (callable(value) or inspect.isgetsetdescriptor(value)):
                assert value.__doc__, f"{name}.{member}"


USER = '''
from pathlib import Path

import numpy

import lightmesh
from lightmesh import Camera, Image, LightMesh, Material, Scene


def picture(path: Path) -> Image:
    scene = Scene.load(path, units="blender", max_memory=2**30)
    made = Scene()
    steel = made.add_material(Material(metallic=1.0, roughness=0.1))
    made.add_mesh(numpy.zeros((3, 3), numpy.float32), [[0, 1, 2]], material=steel, transform=numpy.eye(4))
    made.add_point_light((0, 1, 0), 100.0)
    made.set_environment(numpy.ones((2, 4, 3)), strength=2)
    camera = Camera.look_at((0, 1, 2), (0, 0, 0), yfov=0.7)
    mesh = LightMesh(scene, spacing="1/80", error=None)

    def report(stage: str, done: int, total: int, rays: int) -> None:
        print(stage, done / total, rays)

    image = scene.render(camera=camera, size=(10, 10), mesh=mesh, progress=report, aov=["depth"])
    scene.render(camera=0, size="10x10", environment=path, spacing=0.1, progress=True)
    light: float = numpy.asarray(image).mean().item()
    far: float = image.aovs["depth"].max().item()
    points: int = mesh.stats["direct"]["points_used"]
    mesh.fill(region=scene.bounds, progress=report)
    direct, indirect, stats = mesh.measure(mesh.points[mesh.valid], (0, 1, 0))
    lux = mesh.irradiance([[0, 1, 0]], [0, 1, 0]) - scene.irradiance([[0, 1, 0]], [0, 1, 0], method="path", spp=64)
    print((direct + indirect - lux).mean().item(), stats["rays"], mesh.values[..., 0, :].sum(), mesh.indirect_spacing)
    mesh.save(path.with_suffix(".safetensors"))
    LightMesh.load(path.with_suffix(".safetensors"), scene, bounces=1)
    print(light, far, points, image.stats["seconds"], scene.bounds[0][1], scene.lights[0].color)
    image.save(path.with_suffix(".png"), exposure=-3.5)
    if lightmesh.metrics.relrmse(image, numpy.zeros((10, 10, 3))) > 0.1:
        raise lightmesh.SceneError("far off")
    return image
'''


def test_a_users_program_is_typed(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    good, bad = tmp_path / "good.py", tmp_path / "bad.py"
    good.write_text(USER)
    bad.write_text(USER.replace('units="blender"', 'units="feet"').replace("camera=0", "camera=[]").replace("size=(10, 10)", "size=10"))

    def mypy(path: Path) -> subprocess.CompletedProcess[str]:
        line = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), str(path)]
        # mypy finds an installed package by itself.
        package = Path(lightmesh.__file__).parents[1]
        environment = {} if package.name == "site-packages" else {"MYPYPATH": str(package)}
        return subprocess.run(
            line, capture_output=True, text=True, cwd=tmp_path, check=False, env={**os.environ, **environment}
        )

    fine = mypy(good)
    assert fine.returncode == 0, fine.stdout + fine.stderr
    assert mypy(bad).stdout.count("error:") == 3


def test_the_readmes_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    readme = (REPOSITORY / "README.md").read_text()
    example = readme.split("```python\n")[1].split("```")[0]
    small = example.replace("size=(600, 400), spp=16", "size=(30, 20), spp=1, bounces=0").replace("scenes/", f"{REPOSITORY}/scenes/")
    assert small.count("bounces=0") == 1
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(small, names)
    assert names["light"].shape == (20, 30, 3)  # type: ignore[attr-defined]
    assert {path.name for path in tmp_path.iterdir()} == {"room.png", "room.exr"}
