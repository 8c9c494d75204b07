"""Work of incremental histograms: equality, and pixels counted as enumeration gives them."""

import numpy as np

from robot_perception.appearance.head_ellipse import Ellipse
from robot_perception.chapters.head_tracking import incremental


def test_both_ways_give_the_same_scores_and_the_incremental_one_touches_fewer_pixels():
    config = incremental.Config((5, 20), repeats=1)
    found = incremental.run(config, rng=np.random.default_rng(0))
    assert not found.differ.any()
    ratios = found.full / found.incremental
    assert 1 < ratios[0] < 5 < ratios[1]
    assert (found.full_s > 0).all()


def test_additions_are_those_of_the_masks():
    size, half_width, radius = (60, 60), 6, 2
    before, u = Ellipse(28, 28, half_width).mask(size), 28
    steps = before.sum()
    for row in range(2 * radius + 1):
        for column in range(2 * radius + 1):
            if row or column:
                u += 0 if column == 0 else 1 - 2 * (row % 2)
                now = Ellipse(u, 28 + row, half_width).mask(size)
                steps += (now != before).sum()
                before = now
    assert incremental.additions(half_width, radius) == (25 * before.sum(), steps)
