"""What is computed from real pictures, and what the page says of it."""

import numpy as np

from robot_perception.chapters.tutor_following import recordings


def test_the_real_open_hand_is_found_upright_and_not_when_tilted_far():
    stored = recordings.PHOTOGRAPHS.read().result
    assert len(stored.gestures) == 14
    assert stored.found[0] > 0.8 * recordings.ROOMS
    assert (np.diff(stored.found) < 0).all()
    assert stored.taken.sum() < 0.1 * recordings.ROOMS * 14


def test_four_patches_hold_the_head_in_more_pictures_than_one_and_fixed_ones_in_fewer():
    stored = recordings.GIRL.read().result
    near = dict(zip(stored.trackers, stored.near.mean(axis=1), strict=True))
    assert near["four, adapting"] > near["one patch, adapting"] + 0.2
    assert near["four, adapting"] > near["four, fixed"]
    assert near["four, gated"] > near["four, adapting"]


def test_a_black_picture_is_no_hand():
    assert recordings._found(np.zeros((224, 224, 3), np.uint8), 0.0) == 0
