"""The exercises of the chapter."""

import pytest

from robot_perception import walls
from robot_perception.book.walls import EXERCISES, worst_case


def test_so_many_distances_are_measured_on_the_worst_line():
    assert EXERCISES["walls-1"].answer == walls.count_distances(worst_case(1000), 0.1)


@pytest.mark.parametrize(
    ("key", "right", "wrong"),
    [
        ("walls-1", 999 * 998 // 2, 1000 * 999 // 2),
        ("walls-2", [[0, 0], [15, 0.1], [10, 0]], [[0, 0], [5, 0.1], [10, 0]]),
        ("walls-3", 0.5, 0.05),
        ("walls-4", "only if the pose stood still", "yes"),
    ],
)
def test_exercises_know_right_from_wrong(key, right, wrong):
    assert EXERCISES[key].judge(right)[0] == "right"
    assert EXERCISES[key].judge(wrong)[0] == "wrong"
    assert EXERCISES[key].judge(...)[0] == "not yet"
    if EXERCISES[key].mistakes:  # with the hint for this very mistake
        assert EXERCISES[key].judge(wrong)[1].startswith("Not quite: ")
