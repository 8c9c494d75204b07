"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

from itertools import product

import pytest

from robot_perception.book import visual_slam as slam
from robot_perception.chapters.visual_slam import recordings


@pytest.mark.parametrize("explorer", [slam.built, slam.play, slam.space])
def test_no_two_ends_say_the_same(explorer):
    ends = {name: (c.values[0], c.values[-1]) for name, c in explorer.controls.items()}
    words = {
        explorer.described(**dict(zip(ends, values, strict=True)))
        for values in product(*ends.values())
    }
    assert len(words) == 2 ** len(ends)


def test_the_timeline_ends_with_the_drive():
    assert slam.MOMENTS[-1] == slam.FRAMES - 1


def test_after_a_frame_about_two_particles_of_fifty_count():
    """As the bet says, and that a frame has about a dozen points."""
    drive = slam.shown(slam.PLAYED)
    weighed = drive.observed > 0
    assert 1.5 < drive.effective[weighed].mean() < 2.5
    assert 10 < drive.observed.mean() < 15


def test_particles_share_their_maps_unless_they_are_never_resampled():
    """The memory of a landmark: nine numbers for each version; of plain arrays twelve."""
    table = slam.memory_table()
    few, many, never = (
        [table[row, column] for column in table.columns]
        for row in ("M = 10", "M = 100", "M = 50, never resampled")
    )
    assert many[2] < 5 * few[2]
    assert many[1] < 0.05 * 100
    assert never[1] > 0.95 * 50
    drive = slam.shown(100)
    held = len(drive.places) * (many[1] * 9 * 8 + drive.maps.table.itemsize * 100)
    assert many[2] * 1e6 == pytest.approx(held)
    assert slam.plain(drive) == drive.maps.means.nbytes + drive.maps.covs.nbytes
    assert many[3] * 1e6 == pytest.approx(slam.plain(drive))


def test_in_the_bend_that_is_shown_the_filter_is_worse_than_the_wheels():
    errors = recordings.TURN.read().result.errors
    assert errors[100][0] > errors[0][0]
    assert errors[100].mean() < errors[0].mean()


def test_the_step_by_hand_leaves_few_of_five():
    five = slam.glimpse(300)
    assert len(five.poses) == 5
    assert (five.poses == five.poses[0]).all()
    assert five.means.shape == (1, 5, 3)
