"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

from robot_perception.book import visual_slam as slam
from robot_perception.chapters.visual_slam import recordings


def test_the_timeline_ends_with_the_drive():
    assert slam.MOMENTS[-1] == slam.FRAMES - 1


def test_in_the_bend_that_is_shown_the_filter_is_worse_than_the_wheels():
    errors = recordings.TURN.read().result.errors
    assert errors[100][0] > errors[0][0]
    assert errors[100].mean() < errors[0].mean()
