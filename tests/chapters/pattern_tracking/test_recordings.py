"""What is computed from photographs, by law; and what the page says of them."""

import cv2
import numpy as np
import pytest

from robot_perception.chapters.pattern_tracking import recognising, recordings
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


# Recognition


def test_a_place_is_carried_by_what_the_world_tells():
    below = recognising.camera("varied", 300)
    here, there = np.array([0.5, -0.3, 0.2]), np.array([0.7, -0.1, 2.0])
    corner = np.array([[0.9, 0.1]])
    seen, expected = below.points_seen(here, corner)[0], below.points_seen(there, corner)[0]
    np.testing.assert_allclose(recognising.carried(below, here, there, seen), expected, atol=1e-6)


def test_a_pattern_is_found_where_it_was_chosen():
    below, rng = recognising.camera("varied", 301), np.random.default_rng(0)
    image = below.image(np.array([0.3, 0.4, 0.0]))
    chosen = recognising.chosen(image)
    assert chosen
    for pattern, place in chosen:
        contours, vectors, match = recognising.looked_for(pattern, image, place, rng)
        assert contours
        assert vectors
        assert match > 0.9


def test_nothing_is_found_in_a_blank_picture():
    below, rng = recognising.camera("varied", 301), np.random.default_rng(0)
    pattern, place = recognising.chosen(below.image(np.array([0.3, 0.4, 0.0])))[0]
    blank = np.full(SHAPE, 128, np.uint8)
    assert recognising.looked_for(pattern, blank, place, rng) == (False, False, -1.0)


@pytest.mark.parametrize(
    ("place", "held"), [((45, 45), True), ((44, 100), False), ((274, 194), True), ((275, 9), False)]
)
def test_a_whole_window_is_inside_however_it_is_turned(place, held):
    assert recognising.inside(np.array(place, dtype=float), SHAPE) == held
