"""Figures of pictures, meshes and illuminance, drawn with matplotlib (``pip install 'lightmesh[plot]'``).

>>> from lightmesh import plot
>>> plot.picture(image).figure.savefig("room.png")

Every function draws into the axes ``ax`` that it is given, or into those of a new figure, which a notebook shows by itself, and
returns them. Nothing is shown or saved. Lengths are metres, illuminance is lux, weighted by the eye as units.luminance does, and
the colours can be told apart by people who do not see red or green.
"""

import importlib.util

if importlib.util.find_spec("matplotlib") is None:
    raise ImportError(
        "lightmesh.plot draws with matplotlib, which is not installed: pip install 'lightmesh[plot]'", name="matplotlib"
    )

from lightmesh.plot._charts import convergence, illuminance
from lightmesh.plot._meshes import point_cloud, slice_of_mesh
from lightmesh.plot._pictures import error_map, picture

__all__ = ["convergence", "error_map", "illuminance", "picture", "point_cloud", "slice_of_mesh"]
