"""What all figures share: new axes, colours and scales."""

import math
from typing import Any

import matplotlib.pyplot
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

#: Of lines and points, after M. Okabe and K. Ito, Color Universal Design (2008), without yellow, which is too pale for lines.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

#: Of lines and markers that stand back.
GREY = "#767676"


def axes_or_new(ax: Axes | None, width: float = 6.0, height: float = 4.5) -> Axes:
    """The axes, or those of a new figure, width x height inches. It is pyplot's, so that notebooks show it."""
    return _new(width, height).add_subplot() if ax is None else ax


def axes_3d_or_new(ax: Any, width: float = 6.5, height: float = 5.0) -> Any:
    """The same with three dimensions: an Axes3D, which matplotlib has no types for."""
    return _new(width, height).add_subplot(projection="3d") if ax is None else ax


def _new(width: float, height: float) -> Figure:
    return matplotlib.pyplot.figure(figsize=(width, height), layout="constrained")


def colour_bar(ax: Axes, shown: ScalarMappable, label: str, extend: str = "neither", **options: Any) -> Any:
    """A bar beside the axes, as high as they are, that says what colours mean."""
    beside = ax.inset_axes((1.03, 0.0, 0.035, 1.0))
    return ax.figure.colorbar(shown, cax=beside, label=label, extend=extend, **options)


def round_up(value: float) -> float:
    """The least of 1, 2, 5, 10, 20, ... times a power of ten that is not below a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    # What comes of float32 may be a little above a step.
    return next(step * power for step in (1, 2, 5, 10) if value <= step * power * (1 + 1e-5))
