"""Hands, open and not: laws of the drawing."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from data_synth.companion.hands import (
    GESTURES,
    HAND_BOX,
    HandPose,
    clutter_picture,
    hand_sprite,
    hand_window,
    make_hand,
)

RED = (0.9, 0.02, 0.02)


def skin(pose, height=150):
    """Return the pixels of a hand that are skin: nothing else is red."""
    sprite = hand_sprite(replace(pose, skin=RED, sleeve=(0.0, 0.3, 0.0)), height)
    return (sprite[..., 3] > 0.5) & (sprite[..., 0] > 4 * sprite[..., 1])


def fingers(pose):
    """Return how many pieces of skin a line across the fingers meets."""
    mask = skin(pose)
    rows = [np.flatnonzero(np.diff(np.r_[0, row, 0]) == 1).size for row in mask[12:62].astype(int)]
    return max(rows)


def test_gestures_have_as_many_fingers_as_they_show():
    counts = {gesture: fingers(HandPose(gesture)) for gesture in GESTURES}
    assert counts["open"] in (4, 5)
    assert counts["two"] == 2
    assert counts["point"] in (1, 2)  # the thumb
    assert counts["fist"] <= 1
    top = {gesture: np.flatnonzero(skin(HandPose(gesture)).any(axis=1))[0] for gesture in GESTURES}
    assert top["fist"] > top["open"] + 20


def test_the_box_holds_an_open_hand():
    rng = np.random.default_rng(0)
    for _ in range(8):
        mask = skin(make_hand(rng))
        rows, columns = np.nonzero(mask)
        side = HAND_BOX[2] * 150
        left, top = HAND_BOX[0] * mask.shape[1] - side / 2, HAND_BOX[1] * 150 - side / 2
        inside = (columns >= left) & (columns < left + side) & (rows >= top) & (rows < top + side)
        assert inside.mean() > 0.8
        assert mask.sum() > 0.25 * side**2


def test_a_mirrored_hand_is_the_other_one():
    one, other = skin(HandPose()), skin(HandPose(mirrored=True))
    assert (one != other[:, ::-1]).mean() < 0.02
    assert (one != other).mean() > 0.05


def test_spread_and_bent_fingers():
    wide = [np.ptp(np.nonzero(skin(HandPose(spread=s))[10:60])[1]) for s in (0.3, 1.6)]
    assert wide[1] > 1.3 * wide[0]
    high = [np.flatnonzero(skin(HandPose(bends=(b,) * 4)).any(axis=1))[0] for b in (0.0, 0.8)]
    assert high[1] > high[0] + 8


def test_windows_are_of_the_size_and_turn_with_the_tilt():
    pose = replace(make_hand(np.random.default_rng(1)), skin=(1.0, 1.0, 1.0))
    window = hand_window(np.random.default_rng(2), pose, size=48)
    assert window.shape == (48, 48)
    assert window.dtype == np.uint8
    turned = hand_window(np.random.default_rng(2), pose, tilt=np.pi / 2, size=48, jitter=0.0)
    upright = hand_window(np.random.default_rng(2), pose, size=48, jitter=0.0)
    straight = np.corrcoef(np.rot90(turned).ravel(), upright.ravel())[0, 1]
    crossed = np.corrcoef(turned.ravel(), upright.ravel())[0, 1]
    assert straight > 0.6
    assert straight > crossed + 0.2


def test_a_rooms_pictures_differ_and_have_the_size():
    rng = np.random.default_rng(3)
    one, other = clutter_picture(rng, (120, 160)), clutter_picture(rng, (120, 160))
    assert one.shape == (120, 160)
    assert np.abs(one.astype(int) - other).mean() > 5
    again = clutter_picture(np.random.default_rng(3), (120, 160))
    np.testing.assert_array_equal(one, again)


def test_people_stand_in_pictures_as_often_as_they_may():
    cascade = cv2.CascadeClassifier(cv2.data.haarcascades + "haarcascade_frontalface_default.xml")

    def faces(people):
        rng = np.random.default_rng(4)
        return sum(len(cascade.detectMultiScale(clutter_picture(rng, people=people), 1.1, 4)) > 0
                   for _ in range(8))  # fmt: skip

    assert faces(0.0) <= 1
    assert faces(1.0) >= 5


def test_light_falls_from_its_side():
    """Each finger is brighter on the side where the lamp stands."""
    sides = []
    for lamp in (-1.3, 1.3):
        sprite = hand_sprite(HandPose("point", lamp=lamp), 200)
        row = sprite[30:60]
        cover = row[..., 3] > 0.9
        columns = np.arange(row.shape[1])
        middle = (cover * columns).sum(axis=1) / np.maximum(cover.sum(axis=1), 1)
        bright = row[..., :3].mean(axis=-1)
        right = cover & (columns > middle[:, None])
        left = cover & (columns < middle[:, None])
        sides.append(bright[right].mean() / bright[left].mean())
    assert sides[0] < 0.97 < 1.03 < sides[1] or sides[1] < 0.97 < 1.03 < sides[0]
    assert (sides[1] > sides[0]) == (sides[1] > 1)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda: HandPose("wave"), "gesture must be"),
        (lambda: HandPose(bends=(2.0, 0, 0, 0)), "bends must be"),
        (lambda: HandPose(slim=9.0), "slim must be"),
        (lambda: make_hand(np.random.default_rng(0), tone=9), "tone must be"),
        (lambda: hand_sprite(height=1), "height must be"),
        (lambda: hand_window(np.random.default_rng(0), HandPose(), size=4), "size must be"),
        (lambda: clutter_picture(np.random.default_rng(0), (9, 9)), "size must be"),
    ],
)
def test_what_is_wrong_is_named(wrong, text):
    with pytest.raises(ValueError, match=text):
        wrong()
