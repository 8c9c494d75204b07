"""The film of the chapter: what a frame shows, and that one path jumps and the other does not."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from robot_perception.book import loop_closing as loop
from robot_perception.chapters.loop_closing import films


@pytest.fixture(scope="module")
def unnamed():
    return loop.built("nothing")


def jumps(built):
    """Return how far the error of the position moves from step to step, m."""
    return np.linalg.norm(np.diff(built.path[:, :2] - built.truth[:, :2], axis=0), axis=1)


def test_readings_stand_where_the_robot_believed_to_be_at_their_steps(unnamed):
    """All lie within the scanner's reach of that place."""
    assert len(unnamed.steps) == len(unnamed.readings)
    away = np.linalg.norm(unnamed.readings - unnamed.path[unnamed.steps, :2], axis=1)
    assert 0 < away.min() < away.max() < 1.05 * loop.SCANNER.max_range


def test_a_frame_shows_what_was_known_by_then(unnamed):
    _, ax = plt.subplots()
    films.grown(ax, unnamed, 100, "names unknown")
    lengths = [len(line.get_xdata()) for line in ax.lines]
    assert lengths.count(101) == 2  # both paths
    assert np.count_nonzero(unnamed.steps <= 100) in lengths
    plt.close()


def test_only_with_names_the_position_jumps(unnamed):
    assert jumps(unnamed).max() < 0.2 * jumps(loop.built("the names")).max()


def test_the_poster_shows_a_loop_that_names_have_closed_and_one_that_is_open(unnamed):
    named = loop.built("the names")
    shown = films.steps_of(named)[-1]
    off = [np.hypot(*(one.path - one.truth)[shown, :2]) for one in (named, unnamed)]
    assert off == [named.off, unnamed.off]
    assert off[0] < 0.2
    assert off[1] > 2
