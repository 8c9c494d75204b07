"""The film shows the drive of the explorers, no landmark before it is known, and opens well."""

import numpy as np
import pytest

from robot_perception.book import visual_slam as slam
from robot_perception.chapters.visual_slam import films
from tests.chapters.visual_slam.drives import begun
from tests.unchecked import unchecked


@pytest.fixture(scope="module")
def drive():
    """The beginning of the drive, as it is shown."""
    with pytest.MonkeyPatch.context() as patch:
        shown = slam.pictures()[: len(begun().poses) // slam.EVERY]
        patch.setattr(slam, "seen_in", begun)
        patch.setattr(slam, "pictures", lambda: shown)
        with unchecked():
            yield slam.clock.__wrapped__(), slam.shown.__wrapped__(slam.PLAYED)


def test_the_film_ends_as_the_drive_that_is_shown_does(drive):
    clock, drive = drive
    np.testing.assert_array_equal(clock.wheels, drive.odometry)
    for moment in clock.moments:
        frame = moment.frame
        np.testing.assert_array_equal(moment.particles, drive.poses[frame])
        lines = slam.paths(drive, frame).swapaxes(0, 1)
        assert (moment.path == lines).all(axis=(1, 2)).any()
        assert (clock.seen.frames[moment.used] == frame).all()
    counts = [len(moment.landmarks) for moment in clock.moments]
    assert counts == sorted(counts)
    assert 0 == counts[0] < counts[-1] <= len(drive.founders)


def test_the_film_opens_where_the_filter_gains_most(drive):
    clock, _ = drive
    off = []
    for moment in clock.moments:
        ends = np.stack([clock.wheels[moment.frame], moment.path[-1]])
        off.append(np.hypot(*(ends - clock.seen.poses[moment.frame])[:, :2].T))
    assert clock.errors() == pytest.approx(np.array(off))
    assert clock.poster() == int(np.argmax([wheels - filtered for wheels, filtered in off]))


def test_two_labels_of_errors_never_overlap(drive):
    for fig in films.frames(drive[0]):
        texts = [text for ax in fig.axes for text in ax.texts]
        low, high = sorted(text.get_position()[1] for text in texts)
        assert high - low >= films.LINE - 1e-9
