"""What the chapter tells a reader to find, in every state of its explorers."""

from itertools import product

import pytest

from robot_perception.chapters.visual_slam import explorers, frontend, recordings
from robot_perception.chapters.visual_slam.explorers import COUNTS, MAP, MOMENTS, PLAY, SPACE
from tests.chapters.findings import ExplorerTests
from tests.unchecked import unchecked


@pytest.fixture(autouse=True, scope="module")
def computed():
    """All drives, computed once, without the checks of shapes."""
    with unchecked():
        for count in COUNTS:
            explorers.measured(count)


class TestExplorers(ExplorerTests):
    explorers = (MAP, PLAY, SPACE)


@pytest.mark.parametrize("explorer", [MAP, PLAY, SPACE])
def test_no_two_ends_say_the_same(explorer):
    ends = {name: (c.values[0], c.values[-1]) for name, c in explorer.controls.items()}
    words = {
        explorer.described(**dict(zip(ends, values, strict=True)))
        for values in product(*ends.values())
    }
    assert len(words) == 2 ** len(ends)


def test_ten_guesses_bring_the_walls_back_and_a_hundred_hardly_more():
    (one, torn), (ten, _), *_ = found = MAP.found()
    for error, topology in found[1:]:
        assert ten / 2 < error < one / 3
        assert topology.inside > 0.95 > torn.inside
        assert topology.right
    assert not torn.right


def test_resampled_all_descend_from_one_and_never_resampled_all_live_and_one_counts():
    for rule in PLAY.controls["rule"].values:
        for kin, effective in PLAY.found(rule=rule)[1:]:  # "after the first"
            assert kin == (explorers.PLAYED if rule == "never" else 1)
            assert rule != "never" or effective < 2


def test_the_timeline_ends_with_the_drive():
    assert MOMENTS[-1] == frontend.FRAMES - 1


def test_after_a_frame_about_two_particles_of_fifty_count():
    """As the bet says, and that a frame has about a dozen points."""
    drive = explorers.driven(explorers.PLAYED)
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
    for count in SPACE.controls["count"].values:
        plane, height = SPACE.found(count=count, turn=0)[0]
        assert height < 0.05
        assert (plane > 0.6) == (count == 1)


def test_in_the_bend_that_is_shown_the_filter_is_worse_than_the_wheels():
    errors = recordings.TURN.read().result.errors
    assert errors[100][0] > errors[0][0]
    assert errors[100].mean() < errors[0].mean()
