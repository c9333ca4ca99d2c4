"""What meters read."""

from typing import Any, NamedTuple

import numpy
from numpy.typing import NDArray


class Measured(NamedTuple):
    """What LightMesh.measure returns: direct, indirect, stats."""

    direct: NDArray[numpy.float32]
    """(N, 3), lux per channel: what comes straight from lights."""
    indirect: NDArray[numpy.float32]
    """(N, 3), lux per channel: what surfaces have reflected."""
    stats: dict[str, Any]
    """What it took: seconds, rays, the state of the mesh and others, with the keys of --stats."""

    @property
    def irradiance(self) -> NDArray[numpy.float32]:
        """Both together: (N, 3), lux per channel."""
        return self.direct + self.indirect
