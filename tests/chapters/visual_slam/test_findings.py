"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.visual_slam import explorers, recordings
from robot_perception.chapters.visual_slam import figures as draw
from robot_perception.chapters.visual_slam.resampling import RULES
from robot_perception.teaching.figures import figure
from tests.chapters.findings import limits, presets_that_show_the_default, states
from tests.unchecked import unchecked


@pytest.fixture(autouse=True, scope="module")
def computed():
    """All drives, computed once, without the checks of shapes."""
    with unchecked():
        explorers.driven(1)
        for count in explorers.COUNTS:
            explorers.measured(count)


@pytest.mark.parametrize(
    ("presets", "controls"),
    [
        (explorers.MAP_PRESETS, explorers.MAP_CONTROLS),
        (explorers.PLAY_PRESETS, explorers.PLAY_CONTROLS),
        (explorers.TURN_PRESETS, explorers.TURN_CONTROLS),
    ],
)
def test_no_preset_shows_the_default(presets, controls):
    assert not presets_that_show_the_default(presets, controls)


def test_ten_guesses_bring_the_walls_back_and_a_hundred_hardly_more():
    off = {count: explorers.measured(count) for count in explorers.COUNTS}
    for count in explorers.COUNTS[1:]:
        error, found = off[count]
        assert error < off[1][0] / 3
        assert error > off[10][0] / 2
        assert found.inside > 0.95 > off[1][1].inside
        assert found.right
    assert not off[1][1].right


def test_resampled_all_descend_from_one_and_never_resampled_all_live_and_one_counts():
    for state in states(explorers.PLAY_CONTROLS):
        rule, frame = state["rule"], state["at"]
        drive = explorers.driven(explorers.PLAY_COUNT, rule)
        alive = explorers.ancestors(drive, frame)
        assert alive[frame] == explorers.PLAY_COUNT
        if frame == explorers.MOMENTS[0]:
            continue  # "after the first"
        if rule == "never":
            assert (alive == explorers.PLAY_COUNT).all()
            assert drive.effective[frame] < 2
        else:
            assert alive[max(frame - 20, 0)] == 1, state


def test_the_timeline_ends_with_the_drive():
    assert explorers.MOMENTS[-1] == explorers.FILM.frames - 1


def test_after_a_frame_about_two_particles_of_fifty_count():
    """As the bet says, and that a frame has about a dozen points."""
    drive = explorers.driven(explorers.PLAY_COUNT)
    weighed = drive.observed > 0
    assert 1.5 < drive.effective[weighed].mean() < 2.5
    assert 10 < drive.observed.mean() < 15


def test_particles_share_their_maps_unless_they_are_never_resampled():
    """The memory of a landmark: nine numbers for each version; of plain arrays twelve."""
    table = explorers.memory_table()
    few, many, never = (
        [table[row, column] for column in table.columns]
        for row in ("M = 10", "M = 100", "M = 50, never resampled")
    )
    assert many[2] < 5 * few[2]
    assert many[1] < 0.05 * 100
    assert never[1] > 0.95 * 50
    drive = explorers.driven(100)
    held = len(drive.places) * (many[1] * 9 * 8 + drive.maps.table.itemsize * 100)
    assert many[2] * 1e6 == pytest.approx(held)
    assert explorers.plain(drive) == drive.maps.means.nbytes + drive.maps.covs.nbytes
    assert many[3] * 1e6 == pytest.approx(explorers.plain(drive))


def test_heights_are_right_with_any_number_and_places_are_not():
    for count in explorers.TURN_CONTROLS["count"].values:
        drive = explorers.driven(count)
        gaps = drive.means - drive.places
        assert np.median(np.abs(gaps[:, 2])) < 0.05
        assert (np.median(np.hypot(*gaps[:, :2].T)) > 0.6) == (count == 1)


def test_in_the_bend_that_is_shown_the_filter_is_worse_than_the_wheels():
    errors = recordings.TURN.read().result.errors
    assert errors[100][0] > errors[0][0]
    assert errors[100].mean() < errors[0].mean()


def test_axes_stay():
    _, ax = figure()
    seen = set()
    for count in explorers.COUNTS:
        draw.built(ax, explorers.driven(count))
        seen.add(limits(ax))
    assert len(seen) == 1
    seen = set()
    for state in states(explorers.TURN_CONTROLS):
        seen.add(limits(draw.in_space(ax, explorers.driven(state["count"]), state["turn"])))
    assert len(seen) == 1
    _, axes = figure(2, 1)
    ends = {
        tuple(map(limits, draw.particles(axes, explorers.driven(50, rule), frame)))
        for rule in RULES
        for frame in explorers.MOMENTS[:2]
    }
    assert len(ends) == 1


def test_each_state_says_what_it_shows():
    words = [explorers.describe_map(m) for m in explorers.COUNTS]
    words += [explorers.describe_play(**s) for s in states(explorers.PLAY_CONTROLS)]
    words += [explorers.describe_turn(**s) for s in states(explorers.TURN_CONTROLS)]
    assert len(set(words)) == len(words)
