"""Heads with faces: laws of the drawing, and a detector that knows nothing of it."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from data_synth.companion.canvas import lay, photograph, room
from data_synth.companion.faces import (
    FACE_BOX,
    PARTS,
    FaceIdentity,
    FaceView,
    face_sprite,
    make_identity,
)

DETECTOR = cv2.CascadeClassifier(cv2.data.haarcascades + "haarcascade_frontalface_default.xml")


def found(view, count=18, seed=5, tall=120):
    """Return which share of people a cascade finds, at its place and size, in cluttered rooms."""
    rng, hits = np.random.default_rng(seed), 0
    for k in range(count):
        canvas = room((200, 240), rng=rng)
        u, v = rng.uniform(80, 160), rng.uniform(80, 120)
        lay(canvas, face_sprite(make_identity(rng, tone=k % 6), view), (u, v), tall)
        grey = cv2.cvtColor(photograph(canvas, rng=rng), cv2.COLOR_RGB2GRAY)
        middle = np.array([u, v + (FACE_BOX[1] - 0.5) * tall])
        hits += any(
            np.hypot(*(np.array([x + w / 2, y + w / 2]) - middle)) < 0.12 * tall
            and 0.75 < w / (FACE_BOX[2] * tall) < 1.3
            for x, y, w, _ in DETECTOR.detectMultiScale(grey, 1.1, 4)
        )
    return hits / count


def test_a_detector_of_real_faces_finds_those_that_look_at_the_camera():
    assert found(FaceView()) >= 0.9
    assert found(FaceView(yaw=0.2, smile=0.5)) >= 0.85


def test_it_does_not_find_heads_that_look_away():
    assert found(FaceView(yaw=1.2)) <= 0.1
    assert found(FaceView(yaw=math.pi)) <= 0.1


@pytest.fixture(scope="module")
def person():
    return make_identity(np.random.default_rng(4), tone=2)


def brightness(sprite, columns):
    """Return how bright covered pixels of some columns are."""
    part = sprite[30:90, columns]
    return float((part[..., :3].mean(axis=-1) * part[..., 3]).sum() / part[..., 3].sum())


def test_a_lamp_lights_the_side_on_which_it_stands(person):
    left, right = slice(20, 46), slice(46, 72)
    for sign in (-1, 1):
        sprite = face_sprite(person, FaceView(azimuth=sign * 1.2, ambient=0.2))
        sides = brightness(sprite, left), brightness(sprite, right)
        assert (sides[1] > 1.3 * sides[0]) if sign > 0 else (sides[0] > 1.3 * sides[1])


def test_a_mirrored_lamp_on_a_head_from_the_front_mirrors_the_picture(person):
    one = face_sprite(person, FaceView(azimuth=0.7))
    other = face_sprite(person, FaceView(azimuth=-0.7))
    difference = np.abs(one - other[:, ::-1])[30:90, 25:67, :3]
    assert np.median(difference) < 0.01


def test_light_scales_what_comes_back_and_not_what_is_covered(person):
    one, half = face_sprite(person), face_sprite(person, FaceView(light=0.5))
    np.testing.assert_allclose(half[..., :3], one[..., :3] / 2, atol=1e-6)
    np.testing.assert_array_equal(half[..., 3], one[..., 3])


def test_the_eyes_turn_the_way_the_head_does(person):
    """They are the darkest of the middle rows, and go to the left as seen with a negative yaw."""
    rows = slice(50, 60)

    def eyes(yaw):
        sprite = face_sprite(replace(person, glasses=False), FaceView(yaw=yaw))
        dark = np.clip(0.1 - sprite[rows, 15:77, :3].mean(axis=-1), 0, None)
        return float((dark.sum(axis=0) * np.arange(15, 77)).sum() / dark.sum())

    assert eyes(-0.35) < eyes(0.0) - 3 < eyes(0.35) - 6


def test_from_behind_there_is_hair_where_the_face_was(person):
    back = face_sprite(replace(person, hair=(0.9, 0.0, 0.0)), FaceView(yaw=math.pi))
    middle = back[45:60, 35:57]
    assert (middle[..., 0] > 5 * middle[..., 1]).mean() > 0.9


def test_expressions_change_the_mouth_and_the_eyes_and_nothing_else(person):
    usual = face_sprite(person)
    for view, rows in (
        (FaceView(opened=1.0), slice(70, 96)),
        (FaceView(closed=1.0), slice(46, 64)),
    ):
        changed = np.abs(face_sprite(person, view) - usual).max(axis=-1) > 0.02
        assert changed[rows].sum() > 20
        assert changed.sum() - changed[rows].sum() < 0.2 * changed[rows].sum()


@pytest.mark.parametrize("part", PARTS)
def test_every_part_of_a_person_shows(person, part):
    k = PARTS.index(part)
    looks = []
    for value in (-2.0, 2.0):
        shape = list(person.shape)
        shape[k] = value
        looks.append(face_sprite(replace(person, shape=tuple(shape), glasses=False)))
    assert np.abs(looks[0] - looks[1]).max() > 0.05


def test_darker_tones_are_darker():
    means = []
    for tone in range(6):
        people = [make_identity(np.random.default_rng(seed), tone=tone) for seed in range(8)]
        means.append(np.mean([person.skin for person in people]))
        assert {person.tone for person in people} == {tone}
    assert (np.diff(means) < 0).all()


def test_size_and_cover_and_the_same_seed(person):
    for height in (48, 120, 160):
        sprite = face_sprite(person, height=height)
        assert sprite.shape == (height, round(height * 0.26 / 0.34), 4)
        assert sprite.dtype == np.float32
        assert sprite.min() >= 0
        assert sprite[..., 3].max() <= 1
        assert 0.35 < sprite[..., 3].mean() < 0.75
    again = make_identity(np.random.default_rng(4), tone=2)
    assert again == person
    np.testing.assert_array_equal(face_sprite(again), face_sprite(person))


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda who: FaceView(yaw=math.nan), "yaw must be"),
        (lambda who: FaceView(smile=1.5), "smile must be"),
        (lambda who: FaceView(light=-1.0), "light must be"),
        (lambda who: FaceIdentity((0.0,), who.skin, who.hair), "shape must be of 16 parts, got 1"),
        (lambda who: replace(who, shape=(9.0,) * 16), "shape must be"),
        (lambda who: replace(who, beard=2.0), "beard must be"),
        (lambda who: make_identity(np.random.default_rng(0), tone=6), "tone must be"),
        (lambda who: face_sprite(who, height=3), "height must be"),
    ],
)
def test_what_is_wrong_is_named(person, wrong, text):
    with pytest.raises(ValueError, match=text):
        wrong(person)
