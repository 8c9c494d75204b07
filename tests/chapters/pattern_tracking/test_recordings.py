"""What is computed from photographs, by law; and what the page says of them."""

import cv2
import numpy as np

from robot_perception.chapters.pattern_tracking import recordings
from robot_perception.chapters.pattern_tracking.recordings import carried, similarity, tracked
from tests.ceiling.pictures import cluttered

SHAPE = (240, 320)


def test_a_similarity_carries_its_turn_and_its_scale():
    move = np.array([12.0, -7.0, 0.4, 0.25])
    H = similarity(move, SHAPE)
    middle = (np.array(SHAPE[::-1]) - 1) / 2
    np.testing.assert_allclose(carried(middle, H), [*(middle + move[:2]), 0.4, 1.25], atol=1e-9)
    away = carried(middle + np.array([30, 0]), H)[:2] - middle - move[:2]
    np.testing.assert_allclose(away, 30 * 1.25 * np.array([np.cos(0.4), np.sin(0.4)]), atol=1e-9)


def test_the_scale_of_a_place_is_that_of_areas():
    H = np.diag([2.0, 0.5, 1.0])
    np.testing.assert_allclose(carried(np.array([5.0, 9.0]), H), [10, 4.5, 0, 1], atol=1e-9)


def film(count):
    image = cluttered(4)
    moves = [similarity(k * np.array([2.0, 1.0, 0.02, 0.0]), image.shape) for k in range(1, count)]
    pictures = [cv2.warpPerspective(image, H, image.shape[::-1]) for H in moves]
    return image, pictures, moves


def test_patterns_of_a_picture_that_moves_slowly_are_held():
    image, pictures, moves = film(6)
    found = tracked(image, pictures, moves)
    assert len(found.places) >= 2
    assert found.off.shape == (5, len(found.places))
    assert found.held.mean() > 0.6
    assert found.row()[1] == found.held.sum()


def test_patterns_that_leave_the_picture_are_not_chosen():
    image = film(1)[0]
    gone = [similarity(np.array([500.0, 0, 0, 0]), image.shape)] * 3
    assert not recordings._stays(np.array([160.0, 120.0]), gone, image.shape)
    still = [np.eye(3)] * 3
    assert recordings._stays(np.array([160.0, 120.0]), still, image.shape)
    assert not recordings._stays(np.array([39.0, 120.0]), still, image.shape)


def test_the_page_says_what_is_stored_of_the_photographs():
    found = recordings.PHOTOGRAPHS.read().result
    assert found.aloe.held.all()
    assert not found.wall.held.all()
    warped = found.wall.off[: 2 * recordings.STEPS // 3]
    assert np.median(warped[-1]) < recordings.NEAR
    assert recordings.PER_STEP < 1
