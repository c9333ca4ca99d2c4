"""What tests share: the repository, its scenes and a small one made of arrays."""

from pathlib import Path

import numpy
import pytest

import lightmesh
from lightmesh import Camera, Material, Scene

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def scenes() -> Path:
    """The folder of the repository's own scenes."""
    return REPOSITORY / "scenes"


@pytest.fixture
def cornell(scenes: Path) -> Scene:
    return Scene.load(scenes / "cornell.glb")


def floor(albedo: float = 0.5, size: float = 4.0) -> Scene:
    """A Lambert square at y = 0, its middle at the origin."""
    half = size / 2
    scene = Scene()
    scene.add_mesh(
        [[-half, 0, -half], [-half, 0, half], [half, 0, half], [half, 0, -half]],
        [[0, 1, 2], [0, 2, 3]],
        material=Material(base_color=albedo, specular=0.0),
    )
    return scene


def from_above(height: float = 4.0) -> Camera:
    """Looks straight down; the floor fills its picture."""
    return Camera.look_at([0, height, 0], [0, 0, 0], yfov=0.3)


def light_of(image: lightmesh.Image) -> numpy.ndarray:
    return numpy.asarray(image)
