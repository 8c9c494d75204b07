"""Sprites laid over a canvas, the camera, and rooms: by areas, places and moments."""

import numpy as np
import pytest

from data_synth.companion.canvas import lay, photograph, room

CARD = np.ones((40, 20, 4), dtype=np.float32) * np.array([0.8, 0.4, 0.2, 1.0], dtype=np.float32)


def black(rows=120, columns=160):
    return np.zeros((rows, columns, 3), dtype=np.float32)


@pytest.mark.parametrize("height", [12.0, 40.0, 65.5])
@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 2])
def test_a_sprite_covers_its_area_round_its_middle(height, angle):
    cover = lay(black(), CARD, (70.3, 55.8), height, angle=angle)
    assert cover.sum() == pytest.approx(height * height / 2, rel=0.12)
    rows, columns = np.indices(cover.shape)
    middle = [(cover * at).sum() / cover.sum() for at in (columns, rows)]
    np.testing.assert_allclose(middle, [70.3, 55.8], atol=0.3)


def test_it_turns_clockwise_as_seen():
    marked = CARD.copy()
    marked[:8] = [1.0, 1.0, 1.0, 1.0]  # its top
    canvas = black()
    lay(canvas, marked, (80, 60), 40, angle=np.pi / 2)
    bright = canvas.min(axis=-1) > 0.9
    assert np.nonzero(bright)[1].mean() > 90  # the top goes to the right


def test_what_is_transparent_lets_the_ground_through_and_light_falls_on_the_sprite_alone():
    half = CARD.copy()
    half[..., 3] = 0.5
    canvas = np.full((60, 60, 3), 0.6, dtype=np.float32)
    lay(canvas, half, (30, 30), 40, light=0.5)
    np.testing.assert_allclose(canvas[30, 30], 0.5 * 0.6 + 0.25 * CARD[0, 0, :3], atol=1e-5)
    assert canvas[2, 2, 0] == np.float32(0.6)


def test_outside_the_canvas_nothing_is_laid():
    canvas = black()
    assert not lay(canvas, CARD, (500, 60), 40).any()
    assert not canvas.any()
    part = lay(canvas, CARD, (0, 60), 40)
    assert 0.35 < part.sum() / 800 < 0.65


def test_a_photograph_has_the_noise_and_the_curve_it_should():
    light = np.full((200, 200, 3), 0.25, dtype=np.float32)
    image = photograph(light, rng=np.random.default_rng(0), softness=0.0)
    back = (image / 255.0) ** 2.2
    assert back.mean() == pytest.approx(0.25, abs=0.002)
    assert back.std() == pytest.approx(np.sqrt(0.008**2 + 0.0004 * 0.25), rel=0.05)
    soft = photograph(np.eye(64, dtype=np.float32)[..., None].repeat(3, axis=-1),
                      rng=np.random.default_rng(0), softness=2.0)  # fmt: skip
    assert soft.max() < 200


def test_rooms_differ_and_have_more_edges_with_more_things():
    plain, full = (room((120, 160), rng=np.random.default_rng(1), clutter=n) for n in (0, 30))
    assert plain.shape == (120, 160, 3)
    assert 0 < plain.min() < full.max() <= 1
    edges = [np.abs(np.diff(image.mean(axis=-1), axis=1)) > 0.1 for image in (plain, full)]
    assert edges[1].sum() > edges[0].sum() + 200
