"""The film of the chapter: what a frame shows, and that one path jumps and the other does not."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from robot_perception.chapters.loop_closing import building, films


@pytest.fixture(scope="module")
def unnamed():
    return building.built("nothing")


def test_readings_stand_where_the_robot_believed_to_be_at_their_steps(unnamed):
    """All lie within the scanner's reach of that place."""
    assert len(unnamed.steps) == len(unnamed.readings)
    away = np.linalg.norm(unnamed.readings - unnamed.history.poses[unnamed.steps, :2], axis=1)
    assert 0 < away.min() < away.max() < 1.05 * building.Config().scanner.max_range


def test_a_frame_shows_what_was_known_by_then(unnamed):
    _, ax = plt.subplots()
    films.grown(ax, unnamed, 100, "names unknown")
    lengths = [len(line.get_xdata()) for line in ax.lines]
    assert lengths.count(101) == 2  # both paths
    assert np.count_nonzero(unnamed.steps <= 100) in lengths
    plt.close()


def test_only_with_names_the_position_jumps(unnamed):
    moved = np.diff(unnamed.history.poses[:, :2] - unnamed.drive.poses[:, :2], axis=0)
    assert np.linalg.norm(moved, axis=1).max() < 0.2 * films.jump()
