"""Films of faces and portraits: what is true of them, by pixels."""

from dataclasses import replace

import numpy as np
import pytest

from data_synth.companion.face_films import FaceScene, film_faces, portraits
from data_synth.companion.faces import make_identity

STILL = FaceScene(wander=0.0, glances=0.0)
PAIR = FaceScene(people=2, cross=True, glances=0.0)


def film(scene, frames=40, seed=0):
    return film_faces(np.random.default_rng(seed), frames, scene)


@pytest.fixture(scope="module")
def crossed():
    return film(PAIR, 80, 2)


def test_shapes_and_the_same_seed():
    one, other = film(FaceScene(people=2), 6, 1), film(FaceScene(people=2), 6, 1)
    assert one.frames.shape == (6, 240, 320, 3)
    assert one.frames.dtype == np.uint8
    assert one.boxes.shape == (6, 2, 4)
    assert one.yaw.shape == one.visible.shape == (6, 2)
    for name in ("frames", "boxes", "yaw", "visible", "light"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_boxes_are_squares_of_the_faces_own_size(crossed):
    np.testing.assert_array_equal(crossed.boxes[..., 2], crossed.boxes[..., 3])
    far, near = crossed.boxes[..., 2].mean(axis=0)
    assert far < near
    assert 35 < far < near < 90


def test_who_crosses_hides_the_one_behind_and_is_not_hidden(crossed):
    assert crossed.visible[:, 0].min() < 0.5
    assert crossed.visible[:, 1].min() > 0.95
    apart = np.abs(np.diff(crossed.boxes[..., 0], axis=1))[:, 0]
    hidden = crossed.visible[:, 0] < 0.6
    assert apart[hidden].max() < crossed.boxes[hidden, 1, 2].max()
    places = crossed.boxes[[0, -1]][..., 0]
    assert np.sign(places[0, 1] - places[0, 0]) == -np.sign(places[1, 1] - places[1, 0])


def test_skin_lies_in_the_box():
    """A person in colours that nothing else has."""
    who = replace(make_identity(np.random.default_rng(0), tone=0), skin=(0.9, 0.02, 0.02))
    seen = film_faces(np.random.default_rng(3), 10, FaceScene(glances=0.0), (who,))
    for frame, box in zip(seen.frames.astype(int), seen.boxes[:, 0], strict=True):
        red = frame[..., 0] - frame[..., 1:].max(axis=-1) > 90
        x, y, side, _ = np.rint(box).astype(int)
        assert red[y : y + side, x : x + side].mean() > 0.45


def test_glances_turn_the_head_and_are_as_long_as_they_may_be():
    away = np.abs(film(replace(STILL, glances=6.0, glance=8), 200).yaw[:, 0]) > 0.8
    edges = np.flatnonzero(np.diff(np.r_[0, away, 0]))
    lasting = edges[1::2] - edges[::2]
    assert len(lasting) >= 3
    assert lasting.max() <= 16  # two that meet
    assert not (np.abs(film(STILL, 200).yaw) > 0.6).any()


def test_jumps_are_further_than_any_step():
    def steps(scene):
        boxes = film(scene, 150).boxes[:, 0]
        middles = boxes[:, :2] + boxes[:, 2:] / 2
        return np.hypot(*np.diff(middles, axis=0).T)

    assert steps(FaceScene(glances=0.0)).max() < 12
    far = steps(FaceScene(glances=0.0, jumps=4.0))
    assert (far > 20).sum() >= 2


def test_light_changes_when_it_may():
    steady, changing = film(STILL, 60), film(replace(STILL, light="changing"), 60)
    np.testing.assert_array_equal(steady.light, 1.0)
    assert np.ptp(changing.light) > 0.2
    bright = changing.frames.mean(axis=(1, 2, 3))
    assert np.corrcoef(bright, changing.light)[0, 1] > 0.9


def test_portraits_of_a_person_vary_less_than_people():
    rng = np.random.default_rng(1)
    people = [make_identity(rng, tone=2) for _ in range(6)]
    faces = np.array([portraits(rng, who, 8, lamp=0.0, turn=0.0) for who in people]).astype(float)
    assert faces.shape == (6, 8, 112, 92)
    faces -= faces.mean(axis=(2, 3), keepdims=True)
    faces /= faces.std(axis=(2, 3), keepdims=True)
    mean = faces.mean(axis=1)
    within = ((faces - mean[:, None]) ** 2).mean()
    between = ((mean - mean.mean(axis=0)) ** 2).mean()
    assert 0.15 < between / within < 10


def test_a_lamp_that_wanders_makes_portraits_differ_more():
    who = make_identity(np.random.default_rng(2), tone=1)

    def spread(lamp):
        faces = portraits(np.random.default_rng(3), who, 12, lamp=lamp, turn=0.0, jitter=0.0)
        halves = faces[..., 46:].mean(axis=(1, 2)) / faces[..., :46].mean(axis=(1, 2))
        return np.log(halves).std()

    assert spread(0.8) > 2 * spread(0.0)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda: FaceScene(people=0), "people must be"),
        (lambda: FaceScene(light="dim"), "light must be one of steady, changing, got 'dim'"),
        (lambda: FaceScene(tall=(120.0, 90.0)), "tall must rise"),
        (lambda: FaceScene(jumps=-1.0), "jumps must be"),
        (lambda: film(STILL, 0), "frames must be"),
        (
            lambda: film_faces(
                np.random.default_rng(0), 2, PAIR, (make_identity(np.random.default_rng(0)),)
            ),
            "identities must be 2, as the people, got 1",
        ),
        (
            lambda: portraits(np.random.default_rng(0), make_identity(np.random.default_rng(0)), 0),
            "count",
        ),
        (
            lambda: portraits(
                np.random.default_rng(0), make_identity(np.random.default_rng(0)), 1, size=(4, 9)
            ),
            "size",
        ),
    ],
)
def test_what_is_wrong_is_named(wrong, text):
    with pytest.raises(ValueError, match=text):
        wrong()
