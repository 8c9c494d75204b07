"""The film shows the drive of the explorers, no landmark before it is known, and opens well."""

import numpy as np

from robot_perception.book import visual_slam as slam
from robot_perception.chapters.visual_slam import films


def test_the_film_ends_as_the_drive_that_is_shown_does():
    clock, drive = slam.clock(), slam.shown(slam.PLAYED)
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


def test_the_film_opens_where_the_filter_gains_most():
    """By more than half a metre, and the map is well begun."""
    clock = slam.clock()
    wheels, filtered = clock.errors()[clock.poster()]
    assert wheels > filtered + 0.5
    assert clock.poster() > len(clock.moments) / 4


def test_two_labels_of_errors_never_overlap():
    for fig in films.frames(slam.clock()):
        texts = [text for ax in fig.axes for text in ax.texts]
        low, high = sorted(text.get_position()[1] for text in texts)
        assert high - low >= films.LINE - 1e-9
