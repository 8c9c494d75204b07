"""The explorers round the posts: every end of every control, and the words for it."""

from itertools import product

import numpy as np
import pytest

from robot_perception.chapters.loop_closing import explorers, posts
from robot_perception.chapters.loop_closing import figures as draw
from robot_perception.teaching.explore import MOST_STATES, Explorer
from robot_perception.teaching.figures import figure
from robot_perception.teaching.figures.style import MEANING
from tests.unchecked import unchecked


@pytest.fixture(autouse=True, scope="module")
def computed():
    """All states, computed once, without the checks of shapes, which take most of the time."""
    with unchecked():
        explorers.growth(3.0, 90.0)
        explorers.nailed(0, 0)


def ends_of(controls):
    values = {name: (c.values[0], c.values[-1]) for name, c in controls.items()}
    return [dict(zip(values, chosen, strict=True)) for chosen in product(*values.values())]


def check_lines(axes):
    for ax in np.ravel(axes):
        assert ax.lines
        for line in ax.lines:
            y = np.asarray(line.get_ydata(), dtype=float)
            assert np.isfinite(y).any()


def test_explorer_of_noise_and_length():
    _, axes = figure(1, 2)
    for values in ends_of(explorers.GROWTH_CONTROLS):
        draw.growth(axes, explorers.growth(**values))
        check_lines(axes)
    quiet, loud = (explorers.growth(noise, 90.0) for noise in (0.3, 6.0))
    for name in explorers.GROWTH_FILTERS:
        assert loud[name].rms.max() > quiet[name].rms.max()
    short, long = (explorers.growth(3.0, length) for length in (30.0, 120.0))
    assert long["plain"].rms.max() > short["plain"].rms.max()
    assert len(long["plain"].rms) > 3 * len(short["plain"].rms)


def test_explorer_of_anchors():
    _, axes = figure(1, 2)
    for values in ends_of(explorers.ANCHOR_CONTROLS):
        state = explorers.nailed(**values)
        assert len(state.anchors) == values["count"]
        draw.nailed(axes, state)
        check_lines(axes)
    none, one, two = (explorers.nailed(count, 0) for count in (0, 1, 2))
    assert none.runs.rms.mean() > one.runs.rms.mean() > two.runs.rms.mean()
    assert two.runs.rms_heading[-1] < 0.7 * none.runs.rms_heading[-1]


def test_controls_are_names_that_an_explorer_can_have():
    for controls in (explorers.GROWTH_CONTROLS, explorers.ANCHOR_CONTROLS, explorers.PLAY_CONTROLS):
        assert not [name for name in controls if hasattr(Explorer, name)]
        assert np.prod([len(c.values) for c in controls.values()]) <= MOST_STATES


def test_explorer_of_the_ellipses():
    _, ax = figure()
    for values in ends_of(explorers.PLAY_CONTROLS):
        draw.moment(ax, explorers.play(values["variant"]), values["time"])
        check_lines(ax)
    played = explorers.play("plain")
    before, after = (played.history.kept[played.steps[i]] for i in (33, explorers.FRAMES - 1))
    assert np.trace(after.pose_cov[:2, :2]) < 0.1 * np.trace(before.pose_cov[:2, :2])
    assert len(after.landmarks) == len(played.drive.landmarks)


def test_every_variant_has_its_own_colour():
    assert len({draw.tint(name) for name in posts.JACOBIANS}) == len(posts.JACOBIANS)
    assert MEANING["rule"] not in map(draw.tint, posts.JACOBIANS)


def test_words_say_what_the_pictures_show():
    most = explorers.growth(0.3, 30.0)["external"].rms.max()
    assert f"external: at most {most:.2f} m" in explorers.describe_growth(0.3, 30.0)
    last = explorers.nailed(2, 15).runs.rms[-1]
    assert f"{last:.2f} m at the end" in explorers.describe_nailed(2, 15)
    number = len(explorers.play("plain").drive.landmarks)
    assert f"{number} landmarks" in explorers.describe_play("plain", explorers.FRAMES - 1)
