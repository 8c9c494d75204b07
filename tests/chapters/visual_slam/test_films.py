"""The film shows the drive of the explorers, and no landmark before it is known."""

import numpy as np

from robot_perception.chapters.visual_slam import explorers, films, frontend


def test_the_film_ends_as_the_drive_that_is_shown_does():
    wheels, found = films.moments()
    drive = explorers.driven(explorers.PLAYED)
    np.testing.assert_array_equal(wheels, drive.odometry)
    for frame, moment in zip(films.SHOWN, found, strict=True):
        np.testing.assert_array_equal(moment.particles, drive.poses[frame])
        heaviest = (moment.path == drive.paths(frame).swapaxes(0, 1)).all(axis=(1, 2))
        assert heaviest.any()
        assert (frontend.seen().frames[moment.used] == frame).all()
    counts = [len(moment.landmarks) for moment in found]
    assert counts == sorted(counts)
    assert 0 == counts[0] < counts[-1] <= len(drive.founders)


def test_two_labels_of_errors_never_overlap():
    for fig in films.frames():
        texts = [text for ax in fig.axes for text in ax.texts]
        low, high = sorted(text.get_position()[1] for text in texts)
        assert high - low >= films.LINE - 1e-9
