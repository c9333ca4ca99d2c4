from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypedDict, final

import numpy
from numpy.typing import ArrayLike, DTypeLike, NDArray

from lightmesh._measured import Measured

__all__ = [
    "Camera",
    "Gathering",
    "Image",
    "Level",
    "Light",
    "LightMesh",
    "Material",
    "PictureJob",
    "Scene",
    "__version__",
    "_compare",
    "_options",
    "_run_program",
    "_write_file",
    "join_bricks",
    "subtract_bricks",
]

__version__: str

_Path: TypeAlias = str | PathLike[str]
_Point: TypeAlias = tuple[float, float, float]
_Size: TypeAlias = str | Sequence[int]
_Environment: TypeAlias = _Path | ArrayLike
_Method: TypeAlias = Literal["auto", "mesh", "paper", "standard", "exact", "hybrid", "unbiased", "path"]
_Quality: TypeAlias = Literal["preview", "normal", "final"]
_Weight: TypeAlias = Literal["constant", "gaussian", "inverse", "cosine"]
_PaperScale: TypeAlias = Literal["visibility", "constant"]
_Progress: TypeAlias = bool | Callable[[str, int, int, int], object]
_Floats: TypeAlias = NDArray[numpy.float32]
_Report: TypeAlias = Callable[[str, int, int, int], object]
_Bricks: TypeAlias = NDArray[numpy.uint64]
_Outlines: TypeAlias = tuple[NDArray[numpy.uint8], int]

class _Option(TypedDict):
    name: str
    default: str | None
    type: str
    help: str
    methods: list[str]
    old_name: str | None

class _Portion(TypedDict):
    first: int
    last: int
    values: NDArray[numpy.float32]
    seen: NDArray[numpy.uint8]
    stats: str

class _MeshStats(TypedDict):
    spacing_m: float
    points_used: int
    points_refined: int
    points_total: int
    points_invalid: int
    bytes: int

class _MeshesStats(TypedDict):
    direct: _MeshStats
    indirect: _MeshStats

@final
class Camera:
    @staticmethod
    def look_at(
        eye: ArrayLike,
        target: ArrayLike,
        *,
        yfov: float = 0.8,
        up: ArrayLike | None = None,
        aspect: float | None = None,
        name: str = "",
    ) -> Camera: ...
    @staticmethod
    def from_matrix(
        world_from_camera: ArrayLike, *, yfov: float = 0.8, aspect: float | None = None, name: str = ""
    ) -> Camera: ...
    @staticmethod
    def orthographic(world_from_camera: ArrayLike, *, xmag: float, ymag: float, name: str = "") -> Camera: ...
    @property
    def name(self) -> str: ...
    @property
    def eye(self) -> _Point: ...
    @property
    def yfov(self) -> float | None: ...
    @property
    def aspect(self) -> float: ...

@final
class Light:
    @property
    def kind(self) -> Literal["point", "spot", "directional"]: ...
    @property
    def position(self) -> _Point | None: ...
    @property
    def direction(self) -> _Point | None: ...
    @property
    def color(self) -> _Point: ...
    @property
    def range(self) -> float | None: ...
    @property
    def cone_angles(self) -> tuple[float, float] | None: ...

@final
class Material:
    def __new__(
        cls,
        *,
        base_color: ArrayLike = 1.0,
        metallic: float = 0.0,
        roughness: float = 1.0,
        emission: ArrayLike = 0.0,
        specular: float = 1.0,
        specular_color: ArrayLike = 1.0,
        ior: float = 1.5,
        transmission: float = 0.0,
        alpha: float = 1.0,
        alpha_mode: Literal["opaque", "mask", "blend"] = "opaque",
        alpha_cutoff: float = 0.5,
        double_sided: bool = False,
        unlit: bool = False,
        base_color_texture: ArrayLike | None = None,
        metallic_roughness_texture: ArrayLike | None = None,
        emission_texture: ArrayLike | None = None,
        normal_texture: ArrayLike | None = None,
        normal_scale: float = 1.0,
        name: str = "",
    ) -> Material: ...
    @property
    def name(self) -> str: ...

@final
class Scene:
    def __new__(cls) -> Scene: ...
    @staticmethod
    def load(
        path: _Path,
        *,
        units: Literal["gltf", "blender"] = "gltf",
        allow_outside: bool = False,
        max_memory: int | str | None = None,
        scene: str | int | None = None,
    ) -> Scene: ...
    def to_bytes(self) -> bytes: ...
    @staticmethod
    def from_bytes(data: bytes) -> Scene: ...
    def __reduce__(self) -> tuple[Callable[[bytes], Scene], tuple[bytes]]: ...
    def add_material(self, material: Material) -> int: ...
    def add_mesh(
        self,
        positions: ArrayLike,
        triangles: ArrayLike,
        *,
        normals: ArrayLike | None = None,
        uvs: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        transform: ArrayLike | None = None,
        material: Material | int | None = None,
        name: str = "",
    ) -> int: ...
    def add_instance(self, mesh: int, transform: ArrayLike) -> None: ...
    def add_sphere(self, center: ArrayLike, radius: float, *, material: Material | int | None = None) -> None: ...
    def add_point_light(self, position: ArrayLike, intensity: ArrayLike, *, range: float | None = None) -> None: ...
    def add_spot_light(
        self,
        position: ArrayLike,
        direction: ArrayLike,
        intensity: ArrayLike,
        *,
        inner_cone_angle: float = 0.0,
        outer_cone_angle: float = 0.7853981633974483,
        range: float | None = None,
    ) -> None: ...
    def add_directional_light(self, direction: ArrayLike, illuminance: ArrayLike) -> None: ...
    def add_camera(self, camera: Camera) -> int: ...
    def set_environment(
        self, environment: ArrayLike | None, *, strength: float = 1.0, rotation: float = 0.0
    ) -> None: ...
    @property
    def files(self) -> list[Path]: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def lights(self) -> list[Light]: ...
    @property
    def cameras(self) -> list[Camera]: ...
    @property
    def bounds(self) -> tuple[_Point, _Point]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def light_sample_count(self) -> int: ...
    def render(
        self,
        *,
        camera: Camera | str | int | None = None,
        size: _Size | None = None,
        method: _Method | None = None,
        quality: _Quality | None = None,
        spp: int | None = None,
        most_spp: int | None = None,
        time_limit: float | None = None,
        bounces: int = 3,
        error: float | None = None,
        depth: int = 8,
        cutoff: float = 0.001,
        falloff: str = "r2",
        light_error: float = 0.01,
        seed: int = 0,
        environment: _Environment | None = None,
        environment_strength: float = 1.0,
        environment_rotation: float = 0.0,
        light_samples: int = 64,
        light_radius: float = 0.0,
        spacing: float | str = "auto",
        indirect_spacing: float | str = "auto",
        gather_rays: int | None = None,
        near_rays: int | None = None,
        refine: int | None = None,
        lod_distance: float | None = None,
        rays: int = 4,
        interpolation: str = "auto",
        weight: _Weight = "constant",
        field_falloff: str = "r2",
        paper_scale: _PaperScale = "visibility",
        aov: str | Sequence[str] | None = None,
        threads: int | None = None,
        max_memory: int | str | None = None,
        mesh: LightMesh | None = None,
        progress: _Progress | None = None,
        denoise: bool = False,
    ) -> Image: ...
    def irradiance(
        self,
        positions: ArrayLike,
        normals: ArrayLike,
        *,
        method: _Method = "mesh",
        spp: int | None = None,
        bounces: int = 3,
        depth: int = 8,
        falloff: str = "r2",
        light_error: float = 0.01,
        seed: int = 0,
        environment: _Environment | None = None,
        environment_strength: float = 1.0,
        environment_rotation: float = 0.0,
        light_samples: int = 64,
        light_radius: float = 0.0,
        spacing: float | str = "auto",
        indirect_spacing: float | str = "auto",
        gather_rays: int | None = None,
        near_rays: int | None = None,
        rays: int = 4,
        interpolation: str = "auto",
        weight: _Weight = "constant",
        field_falloff: str = "r2",
        paper_scale: _PaperScale = "visibility",
        threads: int | None = None,
        max_memory: int | str | None = None,
        mesh: LightMesh | None = None,
        progress: _Progress | None = None,
    ) -> _Floats: ...

@final
class LightMesh:
    def __new__(
        cls,
        scene: Scene,
        *,
        cameras: Sequence[Camera | str | int | None] | None = None,
        size: _Size | None = None,
        method: _Method = "mesh",
        quality: _Quality | None = None,
        spp: int | None = None,
        most_spp: int | None = None,
        time_limit: float | None = None,
        bounces: int = 3,
        error: float | None = None,
        depth: int = 8,
        cutoff: float = 0.001,
        falloff: str = "r2",
        light_error: float = 0.01,
        seed: int = 0,
        environment: _Environment | None = None,
        environment_strength: float = 1.0,
        environment_rotation: float = 0.0,
        light_samples: int = 64,
        light_radius: float = 0.0,
        spacing: float | str = "auto",
        indirect_spacing: float | str = "auto",
        gather_rays: int | None = None,
        near_rays: int | None = None,
        refine: int | None = None,
        lod_distance: float | None = None,
        rays: int = 4,
        interpolation: str = "auto",
        weight: _Weight = "constant",
        field_falloff: str = "r2",
        paper_scale: _PaperScale = "visibility",
        aov: str | Sequence[str] | None = None,
        threads: int | None = None,
        max_memory: int | str | None = None,
    ) -> LightMesh: ...
    @staticmethod
    def load(
        path: _Path,
        scene: Scene,
        *,
        size: _Size | None = None,
        method: _Method | None = None,
        quality: _Quality | None = None,
        spp: int | None = None,
        most_spp: int | None = None,
        time_limit: float | None = None,
        bounces: int | None = None,
        error: float | None = None,
        depth: int | None = None,
        cutoff: float = 0.001,
        falloff: str | None = None,
        light_error: float | None = None,
        seed: int | None = None,
        environment: _Environment | None = None,
        environment_strength: float | None = None,
        environment_rotation: float | None = None,
        light_samples: int | None = None,
        light_radius: float | None = None,
        spacing: float | str | None = None,
        indirect_spacing: float | str | None = None,
        gather_rays: int | None = None,
        near_rays: int | None = None,
        refine: int | None = None,
        lod_distance: float | None = None,
        rays: int | None = None,
        interpolation: str | None = None,
        weight: _Weight | None = None,
        field_falloff: str | None = None,
        paper_scale: _PaperScale | None = None,
        aov: str | Sequence[str] | None = None,
        threads: int | None = None,
        max_memory: int | str | None = None,
    ) -> LightMesh: ...
    def save(self, path: _Path, *, progress: _Progress | None = None) -> None: ...
    def fill(
        self,
        points: ArrayLike | None = None,
        *,
        region: ArrayLike | None = None,
        progress: _Progress | None = None,
    ) -> dict[str, Any]: ...
    def irradiance(
        self, positions: ArrayLike, normals: ArrayLike, *, progress: _Progress | None = None
    ) -> _Floats: ...
    def direct(
        self, positions: ArrayLike, normals: ArrayLike, *, progress: _Progress | None = None
    ) -> _Floats: ...
    def indirect(
        self, positions: ArrayLike, normals: ArrayLike, *, progress: _Progress | None = None
    ) -> _Floats: ...
    def measure(
        self, positions: ArrayLike, normals: ArrayLike, *, progress: _Progress | None = None
    ) -> Measured: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def stats(self) -> _MeshesStats: ...
    @property
    def spacing(self) -> float: ...
    @property
    def indirect_spacing(self) -> float | None: ...
    @property
    def points(self) -> _Floats: ...
    @property
    def values(self) -> _Floats: ...
    @property
    def valid(self) -> NDArray[numpy.bool_]: ...
    @property
    def levels(self) -> NDArray[numpy.uint8]: ...
    @property
    def indirect_points(self) -> _Floats: ...
    @property
    def indirect_values(self) -> _Floats: ...
    @property
    def indirect_valid(self) -> NDArray[numpy.bool_]: ...
    @property
    def indirect_levels(self) -> NDArray[numpy.uint8]: ...

@final
class Image:
    @staticmethod
    def open(path: _Path) -> Image: ...
    @property
    def shape(self) -> tuple[int, int, int]: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def aovs(self) -> dict[str, NDArray[numpy.float32]]: ...
    @property
    def stats(self) -> dict[str, Any]: ...
    @property
    def exposure(self) -> float: ...
    def denoise(self, *, threads: int | None = None) -> Image: ...
    def save(self, path: _Path, *, exposure: float | Literal["auto"] = "auto", half: bool = False) -> None: ...
    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]: ...
    def _repr_png_(self) -> bytes: ...

@final
class PictureJob:
    def __new__(
        cls,
        scene: Scene,
        *,
        camera: Camera | str | int | None = None,
        mesh: LightMesh | None = None,
        **options: Any,
    ) -> PictureJob: ...
    @property
    def wave_count(self) -> int: ...
    @property
    def level_count(self) -> int: ...
    @property
    def has_indirect(self) -> bool: ...
    @property
    def bounces(self) -> int: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def options_json(self) -> str: ...
    @property
    def fingerprint(self) -> str: ...
    def prepare(self, *, progress: _Report | None = None) -> dict[str, Any]: ...
    def demand(
        self, first: int, last: int, *, outlines: _Outlines | None = None, progress: _Report | None = None
    ) -> tuple[_Bricks, _Bricks]: ...
    def fill_direct(self, bricks: _Bricks, *, progress: _Report | None = None) -> NDArray[numpy.uint8]: ...
    def absorb(self, contents: NDArray[numpy.uint8]) -> None: ...
    def gather(self, bricks: _Bricks, *, progress: _Report | None = None) -> Gathering: ...
    def render(
        self, first: int, last: int, *, outlines: _Outlines | None = None, progress: _Report | None = None
    ) -> _Portion: ...
    def outlines(self, portions: Sequence[Mapping[str, Any]]) -> _Outlines | None: ...
    def assemble(
        self,
        portions: Sequence[Mapping[str, Any]],
        outlines: _Outlines | None = None,
        outline_portions: Sequence[Mapping[str, Any]] = (),
    ) -> Image: ...

@final
class Level:
    def __new__(cls, points: NDArray[numpy.uint32], values: NDArray[numpy.float32]) -> Level: ...
    def __len__(self) -> int: ...

@final
class Gathering:
    def wanted(self) -> tuple[_Bricks, _Bricks]: ...
    def light(self, *, progress: _Report | None = None) -> None: ...
    def bounce(
        self, k: int, below: Level | None = None
    ) -> tuple[NDArray[numpy.uint32], NDArray[numpy.float32]]: ...
    def contents(self) -> NDArray[numpy.uint8]: ...
    @property
    def bytes(self) -> int: ...
    def __len__(self) -> int: ...

def join_bricks(bricks: Sequence[_Bricks]) -> _Bricks: ...
def subtract_bricks(bricks: _Bricks, others: _Bricks) -> _Bricks: ...
def _compare(
    a: Image | ArrayLike, b: Image | ArrayLike, *, linear: bool = False
) -> tuple[float, float, float, float | None]: ...
def _options() -> list[_Option]: ...
def _run_program(arguments: Sequence[str]) -> int: ...
def _write_file(path: _Path, data: bytes) -> None: ...
