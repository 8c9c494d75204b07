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
def test_with_30_degrees_more_fewer_are_found_and_their_descriptors_have_moved_farther(picture):
    found = [explorers.view(picture, angle) for angle in explorers.ANGLES]
    count = [len(one.pixels) for one in found]
    median = [np.median(one.distances) for one in found]
    assert explorers.ANGLES[6] - explorers.ANGLES[0] == 30
    assert all(a > b for a, b in zip(count, count[6:], strict=False))
    assert all(a < b for a, b in zip(median, median[6:], strict=False))


# The aloe

VALUES = {name: c.values for name, c in explorers.PAIR_CONTROLS.items()}


def test_up_to_a_threshold_of_200_two_rows_are_better_than_any_row():
    for threshold, ratio in product((100.0, 200.0), VALUES["ratio"]):
        two, free = (explorers.chosen(r, threshold, ratio).share for r in (2.0, explorers.ANY))
        assert two > free, (threshold, ratio)


def test_without_a_threshold_a_ratio_is_better_without_rows():
    for ratio in VALUES["ratio"]:
        two, free = (explorers.chosen(r, explorers.ANY, ratio).share for r in (2.0, explorers.ANY))
        assert (two < free) == (ratio < 1), ratio


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
