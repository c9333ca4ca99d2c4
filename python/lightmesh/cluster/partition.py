"""Cuts work into tasks."""

from collections.abc import Sequence
from itertools import pairwise

import numpy

from lightmesh.cluster.task import Array

#: Tasks of a stage for each worker: so many that the last ones to end leave nobody idle for long.
TASKS_PER_WORKER = 20


def cut_waves(waves: Sequence[int], tasks: int) -> list[tuple[int, int, int]]:
    """Cuts frames with so many waves each into ranges of waves, about `tasks` in all: (frame, first, last), last
    excluded.

    A range is of one frame: where there are more frames than tasks, each is one range.
    """
    chunk = max(1, sum(waves) // max(1, tasks))
    ranges: list[tuple[int, int, int]] = []
    for frame, count in enumerate(waves):
        parts = max(1, round(count / chunk))
        bounds = [count * i // parts for i in range(parts + 1)]
        ranges.extend((frame, first, last) for first, last in pairwise(bounds) if first < last)
    return ranges


def cut_bricks(bricks: Array, tasks: int) -> list[Array]:
    """Cuts bricks into at most `tasks` groups of about as many points each. Bricks of a group are neighbours in order,
    and one brick is never cut.

    bricks: (N, 10), as `PictureJob.demand` has them.
    """
    if len(bricks) == 0:
        return []
    before = numpy.concatenate(([0], numpy.cumsum(_points(bricks))))
    targets = before[-1] * numpy.arange(1, tasks) / tasks
    bounds = numpy.unique(numpy.concatenate(([0], numpy.searchsorted(before, targets), [len(bricks)])))
    return [bricks[first:last] for first, last in pairwise(bounds)]


def count_points(bricks: Array) -> int:
    """Counts the points of all bricks."""
    return int(_points(bricks).sum())


def _points(bricks: Array) -> Array:
    """Counts the points of each brick."""
    words = numpy.ascontiguousarray(bricks[:, 2:])
    counts: Array = numpy.unpackbits(words.view(numpy.uint8), axis=1).sum(axis=1, dtype=numpy.int64)
    return counts
