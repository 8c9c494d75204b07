"""The exercises of the chapter."""

import numpy as np
import pytest

from robot_perception import walls
from robot_perception.book.walls import EXERCISES, common, share_extracted, twelve_scans
from tests.chapters.exercises import assert_judged, assert_told


def test_so_many_distances_are_measured_on_a_line_that_splits_in_its_middle():
    x = np.linspace(0.0, 1.0, 1025)  # a parabola is farthest from its chords in their middle
    assert EXERCISES["walls-1"].answer == walls.count_distances(np.c_[x, x**2], 1e-9)


@pytest.mark.parametrize(
    ("key", "right", "wrong"),
    [
        ("walls-1", 9217, 1024 * 1023 // 2),
        ("walls-2", [[0, 0], [15, 0.1], [10, 0]], [[0, 0], [5, 0.1], [10, 0]]),
        ("walls-3", 0.5, 0.05),
    ],
)
def test_exercises_know_right_from_wrong(key, right, wrong):
    assert EXERCISES[key].judge(right)[0] == "right"
    assert EXERCISES[key].judge(wrong)[0] == "wrong"
    assert EXERCISES[key].judge(...)[0] == "not yet"
    if EXERCISES[key].mistakes:  # with the hint for this very mistake
        assert EXERCISES[key].judge(wrong)[1].startswith("Not quite: ")


def least(aside):
    near = np.pad(np.abs(aside), 1)
    return np.min([near[:-2], near[1:-1], near[2:]], axis=0)


def median(aside):
    near = np.pad(np.abs(aside), 1)
    return np.median([near[:-2], near[1:-1], near[2:]], axis=0)


def test_a_measure_that_asks_the_neighbours_beats_the_fewest_chords():
    parts = [(walls.simplify_fewest(chain, 0.03), parts) for chain, parts in twelve_scans()]
    fewest = np.concatenate([common(own, kept) > 0.5 for kept, own in parts]).mean()
    shares = [share_extracted(far) for far in (np.abs, median, least)]
    assert np.round([shares[0], fewest, *shares[1:]], 2).tolist() == [0.44, 0.81, 0.91, 0.97]


def test_measures_are_judged_by_what_they_extract_and_not_by_being_small():
    exercise = EXERCISES["walls-far"]
    assert_judged(exercise, least)
    assert exercise.judge(median)[0] == "right"
    assert_told(exercise, np.abs, "neighbours")
    assert_told(exercise, lambda aside: 0.3 * np.abs(aside), "three readings in a row")
