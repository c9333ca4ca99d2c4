"""Photometric units, and how watts of other programs become them.

A point light of luminous flux F (lumen) that shines alike in every direction has the intensity F / 4π (candela); at the distance r
a surface that faces it gets the illuminance I / r² (lux), and if it is Lambert with the albedo a, it has the luminance
a E / π (cd/m²).
"""

import math
from typing import Any

import numpy
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "LUMEN_PER_WATT",
    "LUMINANCE_WEIGHTS",
    "candela_from_lumen",
    "candela_from_lux",
    "candela_from_watt",
    "lumen_from_candela",
    "luminance",
    "lux_from_candela",
]

#: Lumen per watt by which Blender's exporter multiplies lamps; ``units="blender"`` takes it back.
LUMEN_PER_WATT = 683.0

#: Weights of linear Rec. 709 RGB in the luminance.
LUMINANCE_WEIGHTS = (0.2126, 0.7152, 0.0722)


def luminance(rgb: ArrayLike) -> Any:
    """The luminance of linear Rec. 709 RGB, (..., 3), in the same unit: cd/m² of a picture. An array of the shape (...)."""
    values: NDArray[Any] = numpy.asarray(rgb)
    if values.ndim == 0 or values.shape[-1] != 3:
        raise ValueError(f"rgb: expected the shape (..., 3), not {values.shape}")
    return values @ numpy.asarray(LUMINANCE_WEIGHTS, dtype=numpy.result_type(values, numpy.float32))


def candela_from_lumen(flux: float) -> float:
    """The intensity (cd) of a point light of this luminous flux (lm) that shines alike in every direction."""
    return flux / (4.0 * math.pi)


def lumen_from_candela(intensity: float) -> float:
    """The luminous flux (lm) of a point light of this intensity (cd) in every direction."""
    return intensity * 4.0 * math.pi


def lux_from_candela(intensity: float, distance: float) -> float:
    """The illuminance (lx) that a point light of this intensity (cd) gives a surface that faces it, at a distance in metres."""
    return intensity / (distance * distance)


def candela_from_lux(illuminance: float, distance: float) -> float:
    """The intensity (cd) of a point light that gives this illuminance (lx) at a distance in metres."""
    return illuminance * distance * distance


def candela_from_watt(power: float) -> float:
    """The intensity (cd) that Blender's exporter writes for a point light of this power (W): 683 lm/W into every direction."""
    return candela_from_lumen(LUMEN_PER_WATT * power)
