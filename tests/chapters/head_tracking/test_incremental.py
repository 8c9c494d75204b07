"""Work of incremental histograms: equality, and pixels counted as enumeration gives them."""

import numpy as np

from robot_perception.appearance import head_ellipse
from robot_perception.appearance.head_ellipse import Ellipse
from robot_perception.chapters.head_tracking import incremental

CONFIG = incremental.Config((5, 20), 1)


def test_what_the_tracker_carries_is_the_full_count_but_not_as_printed():
    for search, expected in ((incremental.run, True), (incremental.as_printed, False)):
        same = search(CONFIG, rng=np.random.default_rng(0))
        assert len(same) == 2
        assert (same == expected).all()


def test_the_claim_is_about_the_trackers_own_count(monkeypatch):
    def lazy(index, left, top, across, down, most, common):
        common[:] = 0

    monkeypatch.setattr(head_ellipse, "_slide", lazy)
    same = incremental.run(CONFIG, rng=np.random.default_rng(0))
    found = incremental.carried.compute(same)
    assert incremental.carried.verdict(found) == "refuted"


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


def test_summing_eq_28_costs_its_cells_at_every_candidate():
    plain, cells = incremental.additions(20, 8), 818
    assert incremental.additions(20, 8, cells) == tuple(n + 17**2 * cells for n in plain)
    one = incremental.savings((20,), 0.0)[0]
    pixels = Ellipse(0, 0, 20).pixels
    summed = (pixels + cells) / (pixels / one + cells)
    assert np.isclose(incremental.savings((20,), 0.0, cells)[0], summed)
    assert 2.4 < summed < 2.6
