"""Light meshes: renders scenes lit by many lights, and keeps their light from picture to picture.

>>> import lightmesh
>>> scene = lightmesh.Scene.load("room.glb")
>>> image = scene.render(size=(1200, 800), spp=16, spacing="1/80")
>>> image.save("room.png")

Metres, candela, lux and cd/m² throughout; colours are linear RGB. Options have the names, defaults and meaning of the
command line.
"""

from lightmesh import metrics, units
from lightmesh._measured import Measured
from lightmesh._native import Camera, Image, Light, LightMesh, Material, Scene, __version__
from lightmesh.errors import Error, MemoryLimitError, OptionError, SceneError

__all__ = [
    "Camera",
    "Error",
    "Image",
    "Light",
    "LightMesh",
    "Material",
    "Measured",
    "MemoryLimitError",
    "OptionError",
    "Scene",
    "SceneError",
    "__version__",
    "metrics",
    "units",
]
