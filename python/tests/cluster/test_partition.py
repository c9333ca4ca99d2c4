"""Work is cut into tasks without losing any."""

import numpy

from lightmesh.cluster.partition import count_points, cut_bricks, cut_waves


def test_waves_are_cut_into_ranges_of_one_frame() -> None:
    assert cut_waves([4], 2) == [(0, 0, 2), (0, 2, 4)]
    # No more tasks than waves
    assert cut_waves([2], 40) == [(0, 0, 1), (0, 1, 2)]
    # No more than a frame in one task
    assert cut_waves([3, 3, 3], 1) == [(0, 0, 3), (1, 0, 3), (2, 0, 3)]


def test_every_wave_is_in_one_range() -> None:
    frames = [1, 7, 100, 33]
    for tasks in (1, 5, 20, 1000):
        ranges = cut_waves(frames, tasks)
        waves = [(frame, wave) for frame, first, last in ranges for wave in range(first, last)]
        assert waves == [(frame, wave) for frame, count in enumerate(frames) for wave in range(count)]
        # Each frame is cut on its own: half a task more or less for each
        assert len(ranges) <= max(tasks, len(frames)) * 1.5 + len(frames)


def test_groups_of_bricks_have_about_as_many_points_each() -> None:
    random = numpy.random.default_rng(1)
    bricks = numpy.zeros((1000, 10), numpy.uint64)
    bricks[:, 1] = numpy.arange(1000)
    # 0 to 64 points each
    bricks[:, 2] = random.integers(0, 1 << 63, 1000, dtype=numpy.uint64) & random.integers(
        0, 1 << 63, 1000, dtype=numpy.uint64
    )
    groups = cut_bricks(bricks, 40)
    assert numpy.array_equal(numpy.concatenate(groups), bricks)
    counts = [count_points(group) for group in groups]
    assert len(groups) == 40
    # A group ends at a brick: a brick more or less
    assert max(counts) - min(counts) <= 2 * 64


def test_a_brick_is_never_cut() -> None:
    bricks = numpy.full((3, 10), numpy.uint64(0xFFFF_FFFF_FFFF_FFFF))
    assert [len(group) for group in cut_bricks(bricks, 40)] == [1, 1, 1]
    assert cut_bricks(bricks[:0], 40) == []
