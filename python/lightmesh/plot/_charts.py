"""Error against effort, and illuminance on a plane."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy
from matplotlib.axes import Axes
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from numpy.typing import ArrayLike, NDArray

from lightmesh.plot._axes import COLOURS, GREY, axes_or_new, colour_bar
from lightmesh.plot._labels import Labelled, label_directly

MARKERS = ("o", "s", "^", "D", "v", "P", "X")

#: Steps of illuminance, lux, as EN 12464-1 recommends them (each is about 1.5 times the one before).
STEPS_LX = (5, 7.5, 10, 15, 20, 30, 50, 75, 100, 150, 200, 300, 500, 750, 1000, 1500, 2000, 3000, 5000, 7500, 10000)


def convergence(
    series: Mapping[str, tuple[ArrayLike, ArrayLike]],
    *,
    against: Literal["seconds", "samples"] = "seconds",
    slope: bool = True,
    ax: Axes | None = None,
) -> Axes:
    """Error against effort, both on scales of powers of ten, one line for each method, through its points in the order given.

    series: by name the efforts and the errors, as long as each other and positive; errors as relrmse gives them (0.1 is 10%).
    against: what the effort is: "seconds", or "samples" per pixel.
    slope: whether to draw a line of the slope -1/2, with which the noise of random samples falls.

    Names stand at their lines where all of them find room, and in a legend where they do not. Write into the axes and set their
    limits afterwards, if need be, but size the figure before: the room is that of the figure as it is.
    """
    checked = {name: _checked(name, *values) for name, values in series.items()}
    if not checked:
        raise ValueError("series: there is none")
    ax = axes_or_new(ax, 7.0, 5.0)
    ax.set(xscale="log", yscale="log")
    drawn = []
    for index, (name, (effort, error)) in enumerate(checked.items()):
        colour, marker = COLOURS[index % len(COLOURS)], MARKERS[index % len(MARKERS)]
        ax.plot(effort, error, color=colour, marker=marker, markersize=5, linewidth=1.5, label=name)
        drawn.append(Labelled(name, colour, numpy.stack([effort, error], axis=1)))

    efforts = numpy.concatenate([effort for effort, _ in checked.values()])
    errors = numpy.concatenate([error for _, error in checked.values()])
    _widen(ax, efforts, errors)
    slopes = [_slope(ax)] if slope else []
    _percent_and_plain(ax)
    ax.set_xlabel("time (s)" if against == "seconds" else "samples per pixel")
    ax.set_ylabel("relRMSE (%)")
    ax.grid(which="major", color="#dddddd", linewidth=0.6)
    ax.set_axisbelow(True)
    # A name across the grey line is better than a legend, one that is clear of it better still.
    if not (label_directly(ax, drawn, slopes) or label_directly(ax, drawn)):
        ax.legend()
    return ax


def illuminance(
    plane_x: ArrayLike,
    plane_y: ArrayLike,
    lux: ArrayLike,
    *,
    levels: ArrayLike | None = None,
    limits: tuple[float, float] | None = None,
    labels: tuple[str, str] = ("x (m)", "y (m)"),
    ax: Axes | None = None,
) -> Axes:
    """Illuminance on a plane: false colours, and lines of equal illuminance with their lux. The title has the average, the least
    and the uniformity U0, the least over the average, of the values given.

    plane_x, plane_y: where the values are, metres, (W,) and (H,), at least two each.
    lux: (H, W), lux, one row for each plane_y; NaN where nothing is to be measured, as inside of furniture.
    levels: of the lines, lux; None takes the steps of EN 12464-1, or evenly spaced ones where fewer than four of these are met.
    limits: illuminances of the first and the last colour, lux, for figures that are compared; None takes those of the values.
    labels: of the axes, with their unit.
    """
    across, along, values = (numpy.asarray(given, numpy.float64) for given in (plane_x, plane_y, lux))
    if across.ndim != 1 or along.ndim != 1 or min(across.size, along.size) < 2:
        raise ValueError(f"plane_x, plane_y: expected (W,) and (H,), 2 or more, not {across.shape} and {along.shape}")
    if values.shape != (along.size, across.size):
        raise ValueError(f"lux: expected the shape {(along.size, across.size)}, (H, W), not {values.shape}")
    known = numpy.ma.masked_invalid(values)
    if known.count() == 0:
        raise ValueError("lux: there is no finite value")
    least, mean, most = float(known.min()), float(known.mean()), float(known.max())
    low, high = limits or (least, most)

    ax = axes_or_new(ax, 7.0, 5.0)
    colours = ax.pcolormesh(across, along, known, shading="gouraud", cmap="viridis", vmin=low, vmax=high)
    colour_bar(ax, colours, "illuminance (lx)")
    at = _isolines(least, most) if levels is None else numpy.sort(numpy.asarray(levels, numpy.float64))
    at = at[(at > least) & (at < most)]
    if at.size:
        lines = ax.contour(across, along, known, levels=at, colors="white", linewidths=1.1)
        lines.set_path_effects([Stroke(linewidth=2.2, foreground="#222222"), Normal()])
        # Gaps in the lines would be of another size than the names once the figure is laid out.
        for text in ax.clabel(lines, fmt="%g lx", fontsize=8.5, inline=False):
            text.set_bbox({"boxstyle": "round,pad=0.15", "facecolor": "#222222", "edgecolor": "none", "alpha": 0.8})
    ax.set(xlabel=labels[0], ylabel=labels[1], aspect="equal")
    uniformity = f", $U_0$ = {least / mean:.2f}" if mean > 0 else ""
    ax.set_title(f"$E_{{av}}$ = {mean:.0f} lx, $E_{{min}}$ = {least:.0f} lx{uniformity}")
    return ax


def _isolines(least: float, most: float) -> NDArray[Any]:
    steps = numpy.asarray(STEPS_LX, numpy.float64)
    met = steps[(steps > least) & (steps < most)]
    return met if met.size >= 4 else numpy.asarray(MaxNLocator(6).tick_values(least, most))


def _checked(name: str, effort: ArrayLike, error: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
    efforts, errors = numpy.atleast_1d(numpy.asarray(effort, float)), numpy.atleast_1d(numpy.asarray(error, float))
    if efforts.ndim != 1 or efforts.shape != errors.shape or not efforts.size:
        raise ValueError(f"series: {name!r} has efforts of the shape {efforts.shape} and errors of {errors.shape}")
    if not (numpy.isfinite(efforts).all() and numpy.isfinite(errors).all() and min(efforts.min(), errors.min()) > 0):
        raise ValueError(f"series: {name!r} has efforts or errors that are not positive, which have no logarithm")
    return efforts, errors


def _widen(ax: Axes, efforts: NDArray[Any], errors: NDArray[Any]) -> None:
    """Leaves room for names about the lines."""
    ax.set_xlim(efforts.min() / 1.8, efforts.max() * 2.5)
    ax.set_ylim(errors.min() / 1.5, errors.max() * 1.6)


def _slope(ax: Axes) -> NDArray[Any]:
    """A line through the middle of what is seen, as long as it stays inside; returns points of it, (N, 2)."""
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    middle_x, middle_y = (left * right) ** 0.5, (bottom * top) ** 0.5
    at = numpy.geomspace(left, right, 200)
    line = middle_y * (at / middle_x) ** -0.5
    seen = (line > bottom) & (line < top)
    ax.plot(at[seen], line[seen], color=GREY, linestyle=(0, (4, 3)), linewidth=1.0, zorder=1)
    ax.annotate(
        "slope \N{MINUS SIGN}1/2",
        (at[seen][8], line[seen][8]),
        xytext=(6, 0),
        textcoords="offset points",
        color=GREY,
        fontsize=9,
        va="bottom",
    )
    return numpy.stack([at[seen], line[seen]], axis=1)


def _percent_and_plain(ax: Axes) -> None:
    """Ticks as 0.5, 1, 2, 5, 10, ...: in percent for errors."""
    for axis, factor in ((ax.xaxis, 1.0), (ax.yaxis, 100.0)):
        axis.set_major_formatter(FuncFormatter(lambda value, _, factor=factor: f"{factor * value:.6g}"))
        low, high = axis.get_view_interval()
        if high / low < 300:
            axis.set_major_locator(LogLocator(base=10, subs=(1, 2, 5)))
        axis.set_minor_formatter(NullFormatter())
