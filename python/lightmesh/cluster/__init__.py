"""Pictures and light meshes by many machines, on a Ray cluster.

>>> from lightmesh import Scene, cluster
>>> scene = Scene.load("room.glb")
>>> image = cluster.render(scene, address="auto", size=(3840, 2160), spp=256)
>>> for frame, image in cluster.render_frames(scene, scene.cameras, mesh=None, job="frames.job"):
...     image.save(f"frame.{frame:04}.exr")

A picture is the one that `Scene.render` makes, bit for bit, whatever the number of workers and whichever of them die.
docs/scaling.md says how work is cut, what travels and where more machines bring nothing.
"""

from lightmesh.cluster.errors import ClusterError, JobInUseError, JobMismatchError, RayMissingError
from lightmesh.cluster.api import bake, render, render_frames

__all__ = [
    "ClusterError",
    "JobInUseError",
    "JobMismatchError",
    "RayMissingError",
    "bake",
    "render",
    "render_frames",
]
