"""Names at lines instead of a legend."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy
from matplotlib.axes import Axes
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

#: Where a name stands beside a point: alignments, and offsets in points.
PLACES: tuple[tuple[str, str, float, float], ...] = (
    ("left", "center", 8, 0),
    ("left", "bottom", 4, 5),
    ("left", "top", 4, -5),
    ("center", "bottom", 0, 8),
    ("center", "top", 0, -8),
    ("right", "bottom", -4, 5),
    ("right", "top", -4, -5),
    ("right", "center", -8, 0),
)


class Labelled(NamedTuple):
    """A line: its name, its colour, its points (N, 2)."""

    name: str
    colour: str
    points: NDArray[Any]


def label_directly(ax: Axes, lines: Sequence[Labelled], others: Sequence[NDArray[Any]] = ()) -> bool:
    """Puts each name at one of its line's points, the last ones first, over no line and no other name. False, and nothing is
    changed, where one finds no room.

    others: lines without names, (N, 2) each, that names keep clear of too.
    """
    # Of the whole, where the axes are in a subfigure.
    ax.figure.canvas.figure.draw_without_rendering()
    inside = ax.get_window_extent()
    taken = [_pieces(ax, points) for points in (*(line.points for line in lines), *others)]
    boxes: list[Bbox] = [text.get_window_extent() for text in ax.texts]
    placed: list[Annotation] = []
    for line in lines:
        found = None
        for text in _tries(ax, line):
            box = text.get_window_extent().padded(1.5)
            free = (
                inside.x0 <= box.x0
                and box.x1 <= inside.x1
                and inside.y0 <= box.y0
                and box.y1 <= inside.y1
                and not any(box.overlaps(other) for other in boxes)
                and not any(_meets(box, pieces) for pieces in taken)
            )
            if free:
                found = text
                boxes.append(box)
                break
            text.remove()
        if found is None:
            for text in placed:
                text.remove()
            return False
        placed.append(found)
    return True


def _tries(ax: Axes, line: Labelled) -> Iterator[Annotation]:
    for at in line.points[::-1]:
        for ha, va, right, up in PLACES:
            yield ax.annotate(
                line.name,
                (float(at[0]), float(at[1])),
                xytext=(right, up),
                textcoords="offset points",
                color=line.colour,
                fontsize=9.5,
                ha=ha,
                va=va,
            )


def _pieces(ax: Axes, points: NDArray[Any]) -> NDArray[Any]:
    """Places on a line on the screen, close together: (N, 2)."""
    corners = ax.transData.transform(points)
    steps = [numpy.linspace(a, b, max(2, int(numpy.hypot(*(b - a)) / 3))) for a, b in zip(corners, corners[1:], strict=False)]
    return numpy.concatenate([corners, *steps])


def _meets(box: Bbox, pieces: NDArray[Any]) -> bool:
    inside = (pieces >= [box.x0 - 2, box.y0 - 2]) & (pieces <= [box.x1 + 2, box.y1 + 2])
    return bool(inside.all(axis=1).any())
