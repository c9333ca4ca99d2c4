"""Where a light mesh has points, and what they know."""

from typing import Any, Literal, NamedTuple

import numpy
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.colors import LogNorm
from matplotlib.patches import Rectangle
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from lightmesh import units
from lightmesh._native import LightMesh
from lightmesh.plot._axes import COLOURS, GREY, axes_3d_or_new, axes_or_new, colour_bar

#: In the order of LightMesh.values.
FACINGS = ("+x", "-x", "+y", "-y", "+z", "-z")

#: What goes right and what goes up where somebody looks along an axis: down for y, as on a plan, whose z grows downwards.
VIEWS = {"x": (2, 1), "y": (0, 2), "z": (0, 1)}

#: The last colour is at most this many times the illuminance of the first.
RANGE = 100


class _Points(NamedTuple):
    """One of the two meshes: (N, 3) metres, (N,) bool, (N,) level, and metres between points of level 0."""

    at: NDArray[numpy.float32]
    valid: NDArray[numpy.bool_]
    levels: NDArray[numpy.uint8]
    spacing: float


def slice_of_mesh(
    mesh: LightMesh,
    axis: Literal["x", "y", "z"] = "y",
    *,
    at: float,
    thickness: float | None = None,
    light: Literal["direct", "indirect"] = "direct",
    facing: Literal["+x", "-x", "+y", "-y", "+z", "-z"] = "+y",
    limits: tuple[float, float] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The points of a mesh near a plane, coloured by the illuminance there, lux on a scale of powers of ten; invalid ones are
    crosses. Points are as large as their distance from each other, so finer levels show. A line is the box of the scene.

    axis, at: the plane, across an axis at this coordinate (metres).
    thickness: of the slice, metres; None takes the spacing, so that there is one layer of points.
    light: "direct" or "indirect".
    facing: the direction in which the plane faces that gets the light: "+y" is the illuminance of a table.
    limits: the illuminances (lux) of the first and the last colour; None takes what lies between
    all but the darkest and the brightest fiftieth of the points, and a factor of 100 at most.

    The mesh's method must be "mesh", or there is no illuminance in its points (LightMesh.values). Without points in the slice it
    raises ValueError.
    """
    points = _points(mesh, light)
    normal = "xyz".index(axis)
    half = (points.spacing if thickness is None else thickness) / 2
    # A plane halfway between two layers gets both: rounding must not choose.
    near = numpy.abs(points.at[:, normal] - at) <= half * (1 + 1e-4)
    if not near.any():
        raise ValueError(f"at: the mesh has no points at {axis} = {at} m, {_where(points.at[:, normal], axis)}")
    right, up = VIEWS[axis]
    flat = points.at[near][:, [right, up]]
    valid = points.valid[near]
    lux = _lux(mesh, light, facing)[near][valid]
    low, high = limits or _limits(lux)

    ax = axes_or_new(ax, 7.0, 5.0)
    sizes = 0.85 * points.spacing / 2.0 ** points.levels[near][valid]
    dots = EllipseCollection(
        sizes, sizes, numpy.zeros_like(sizes), units="xy", offsets=flat[valid], offset_transform=ax.transData
    )
    # What is in the dark has no logarithm.
    dots.set(array=numpy.maximum(lux, low), cmap="inferno", norm=LogNorm(low, high, clip=True))
    ax.add_collection(dots)
    crosses, count = flat[~valid], int((~valid).sum())
    label = f"{count} invalid: in solids or on surfaces"
    ax.scatter(crosses[:, 0], crosses[:, 1], s=10, c=GREY, marker="x", linewidths=0.8, label=label)
    _outline(ax, mesh, right, up)
    ax.set(xlabel=f"{'xyz'[right]} (m)", ylabel=f"{'xyz'[up]} (m)", aspect="equal")
    if axis == "y":
        ax.yaxis.set_inverted(True)
    below, above = bool((lux < low).any()), bool((lux > high).any())
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}[below, above]
    bar = colour_bar(ax, dots, f"{light} illuminance, facing {facing} (lx)", extend)
    bar.ax.yaxis.set_major_locator(LogLocator(base=10, subs=(1, 1.5, 2, 3, 5, 7)))
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    bar.ax.yaxis.set_minor_formatter(NullFormatter())
    ax.set_title(f"{int(near.sum())} points of the {light} mesh at {axis} = {at:.4g} m")
    if count:
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), frameon=False)
    return ax


def point_cloud(
    mesh: LightMesh,
    *,
    light: Literal["direct", "indirect"] = "direct",
    most: int = 20_000,
    seed: int = 0,
    ax: Any = None,
) -> Any:
    """The points of a mesh in space: valid ones coloured by their level, invalid ones grey. Y is up, all axes have one scale.

    light: "direct" or "indirect".
    most: more points than these are drawn by lot, with this seed; the title says so.
    ax: an Axes3D, as figure.add_subplot(projection="3d") makes it; so is what is returned.
    """
    points = _points(mesh, light)
    total = len(points.at)
    if total == 0:
        raise ValueError("mesh: has no points yet; render with it, measure with it or fill it")
    drawn = numpy.sort(numpy.random.default_rng(seed).permutation(total)[:most])
    at, valid, levels = points.at[drawn], points.valid[drawn], points.levels[drawn]

    ax = axes_3d_or_new(ax)
    size = 5.0 if len(drawn) > 5000 else 10.0
    for level in numpy.unique(levels):
        here = valid & (levels == level)
        count = int((points.valid & (points.levels == level)).sum())
        spacing = points.spacing / 2.0 ** int(level)
        _scatter(ax, at[here], COLOURS[level % len(COLOURS)], size, f"level {level}, {spacing:.2g} m: {count}")
    _scatter(ax, at[~valid], GREY, size / 2, f"invalid: {int((~points.valid).sum())}")
    # z comes towards us, so that x, y and z stay right-handed.
    ax.yaxis.set_inverted(True)
    ax.set(xlabel="x (m)", ylabel="z (m)", zlabel="y (m)")
    ax.set_aspect("equal")
    some = f", {len(drawn)} of them drawn" if len(drawn) < total else ""
    ax.set_title(f"{total} points of the {light} mesh{some}")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, 0.03), ncols=3, frameon=False, markerscale=2)
    return ax


def _scatter(ax: Any, at: NDArray[Any], colour: str, size: float, label: str) -> None:
    if len(at):
        ax.scatter(at[:, 0], at[:, 2], at[:, 1], s=size, c=colour, label=label, linewidths=0, alpha=0.9)


def _points(mesh: LightMesh, light: str) -> _Points:
    if light == "direct":
        return _Points(mesh.points, mesh.valid, mesh.levels, mesh.spacing)
    if light == "indirect":
        # Without an indirect mesh there are no points either.
        spacing = mesh.indirect_spacing or 0.0
        return _Points(mesh.indirect_points, mesh.indirect_valid, mesh.indirect_levels, spacing)
    raise ValueError(f'light: expected "direct" or "indirect", not {light!r}')


def _lux(mesh: LightMesh, light: str, facing: str) -> NDArray[Any]:
    """(N,): the illuminance of a plane that faces this way at each point."""
    if facing not in FACINGS:
        raise ValueError(f"facing: expected one of {', '.join(FACINGS)}, not {facing!r}")
    face = FACINGS.index(facing)
    values: NDArray[Any] = mesh.values if light == "direct" else mesh.indirect_values
    if values.shape[1:] not in ((6, 2, 3), (6, 3)):
        raise ValueError('mesh: only points of method "mesh" know the illuminance of planes')
    of_face = values[:, face, 0] if light == "direct" else values[:, face]
    found: NDArray[Any] = units.luminance(of_face)
    return found


def _limits(lux: NDArray[Any]) -> tuple[float, float]:
    lit = lux[lux > 0]
    if not lit.size:
        return 1.0 / RANGE, 1.0
    low, high = numpy.quantile(lit, [0.02, 0.98])
    # One value alone has no scale.
    return float(max(low, high / RANGE) * 0.999), float(high)


def _outline(ax: Axes, mesh: LightMesh, right: int, up: int) -> None:
    """The scene's box, and a margin about it."""
    low, high = (numpy.asarray(corner) for corner in mesh.scene.bounds)
    size = high - low
    ax.add_patch(Rectangle((low[right], low[up]), size[right], size[up], fill=False, color=GREY, linewidth=0.8))
    margin = 0.03 * float(size.max())
    ax.set_xlim(low[right] - margin, high[right] + margin)
    ax.set_ylim(low[up] - margin, high[up] + margin)


def _where(along: NDArray[Any], axis: str) -> str:
    if not along.size:
        return "and none at all yet; render with it, measure with it or fill it"
    return f"but from {axis} = {float(along.min()):.4g} m to {float(along.max()):.4g} m"
