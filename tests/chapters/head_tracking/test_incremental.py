"""Work of incremental histograms: equality, and pixels counted as enumeration gives them."""

import numpy as np
import pytest

from robot_perception.appearance.head_ellipse import Ellipse
from robot_perception.chapters.head_tracking import incremental


@pytest.mark.parametrize("printed", [False, True])
def test_what_is_carried_is_the_full_count_but_not_as_printed(printed):
    config = incremental.Config((5, 20), 40, printed=printed)
    same = incremental.run(config, rng=np.random.default_rng(0))
    assert same.shape == (2, 40)
    assert (same == (not printed)).all()


def test_a_step_aside_changes_two_pixels_a_row():
    rows = 2 * int(1.2 * 20) + 1
    expected = Ellipse(0, 0, 20).pixels / (2 * rows)
    assert incremental.savings((20,), 0.0)[0] == expected


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
