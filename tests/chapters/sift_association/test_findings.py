"""What the chapter tells a reader to find, in every state of its explorers."""

from itertools import pairwise, product

import numpy as np
import pytest

from robot_perception.chapters.sift_association import explorers, hero, table1
from robot_perception.chapters.sift_association import figures as draw
from robot_perception.teaching.explore import MOST_STATES
from robot_perception.teaching.figures import figure
from tests.chapters.findings import limits, presets_that_show_the_default, states

SETS = [
    (explorers.VIEW_PRESETS, explorers.VIEW_CONTROLS),
    (explorers.PAIR_PRESETS, explorers.PAIR_CONTROLS),
    (explorers.TABLE_PRESETS, explorers.TABLE_CONTROLS),
]


@pytest.mark.parametrize(("presets", "controls"), SETS)
def test_no_preset_shows_the_default_and_there_are_not_too_many_states(presets, controls):
    assert not presets_that_show_the_default(presets, controls)
    assert np.prod([len(c.values) for c in controls.values()]) <= MOST_STATES


def test_all_lines_between_the_two_rooms_are_wrong():
    rooms = hero.doors()
    assert len(rooms.here) > 50
    assert not rooms.right.any()


# A viewpoint


@pytest.mark.parametrize("picture", explorers.PICTURES.values())
def test_farther_aside_fewer_are_found_and_their_descriptors_have_moved_farther(picture):
    found = [explorers.view(picture, angle) for angle in explorers.ANGLES]
    count = [len(one.pixels) for one in found]
    median = [np.median(one.distances) for one in found]
    # from step to step noise may turn a step round, over 15° nothing does
    assert all(a > b for a, b in zip(count, count[3:], strict=False))
    assert all(a < b for a, b in zip(median, median[3:], strict=False))


# The aloe


def test_two_rows_leave_the_most_right_matches_and_without_ratio_the_largest_share():
    """A ratio has fewer rivals to judge by in two rows, and refuses less."""
    values = {name: c.values for name, c in explorers.PAIR_CONTROLS.items()}
    for threshold, ratio in product(values["threshold"], values["ratio"]):
        found = [explorers.chosen(rows, threshold, ratio) for rows in values["rows"]]
        assert found[0].right.sum() >= max(one.right.sum() for one in found)
        if ratio == 1:
            assert found[0].share >= max(one.share for one in found)


def test_a_lower_threshold_is_hardly_ever_worse_than_a_higher_one():
    values = {name: c.values for name, c in explorers.PAIR_CONTROLS.items()}
    for rows, ratio in product(values["rows"], values["ratio"]):
        shares = [explorers.chosen(rows, limit, ratio).share for limit in values["threshold"]]
        assert all(a >= b - 0.002 for a, b in pairwise(shares))


# Table 1


TRACKS = ("", table1.STRAIGHT)


def test_raw_variances_win_on_their_own_frames_and_lose_on_all_others():
    for p, where, track in product(table1.TRACKED, table1.TESTS, TRACKS):
        right = explorers.rates(where, track)
        raw, euclid = (right[name, f"p = {p}"].estimate for name in (table1.RAW, table1.EUCLID))
        assert (raw > euclid) == (where == "trained"), (p, where, track)


def test_raw_variances_lose_the_more_the_fewer_frames_they_come_from():
    for where, track in product(("again", "aside"), TRACKS):
        right = explorers.rates(where, track)
        lost = [
            right[table1.EUCLID, f"p = {p}"].estimate - right[table1.RAW, f"p = {p}"].estimate
            for p in table1.TRACKED
        ]
        assert all(a > b for a, b in pairwise(lost)), (where, track)


def test_pooled_variances_never_lose_much():
    for p, where, track in product(table1.TRACKED, table1.TESTS, TRACKS):
        right = explorers.rates(where, track)
        pooled, euclid = (right[name, f"p = {p}"].estimate for name in ("pooled", table1.EUCLID))
        assert pooled > euclid - 1


def test_axes_of_table_1_stay():
    _, axes = figure(2, 1)
    seen = set()
    for state in list(states(explorers.TABLE_CONTROLS))[::7]:
        where = state["where"], state["track"]
        tables = explorers.rates(*where), explorers.confusions(*where)
        draw.table_state(axes, state["p"], state["model"], *tables)
        seen.add(tuple(limits(ax) for ax in axes))
    assert len(seen) == 1
