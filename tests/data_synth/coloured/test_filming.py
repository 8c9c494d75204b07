"""The camera: grey values, noise, blur, and random functions of time."""

import numpy as np
import pytest

from data_synth.coloured import Camera, filming
from data_synth.coloured.sequences import HEIGHT, WIDTH

QUIET = Camera(0.0, 0.0, 0.0, 1, 0.0)


def even(level):
    return lambda time, moment: np.full((HEIGHT, WIDTH, 3), level, dtype=np.float32)


def film(camera, paint, count=1, seed=0):
    return filming.film(camera, paint, count, rng=np.random.default_rng(seed))


@pytest.mark.parametrize("level", [0.0, 0.001, 0.2, 1.0, 1.7])
def test_values_follow_the_gamma_and_end_at_full_light(level):
    images = film(QUIET, even(level))
    assert images.dtype == np.uint8
    assert images.shape == (1, HEIGHT, WIDTH, 3)
    assert (np.abs(images - 255 * min(level, 1.0) ** (1 / 2.2)) <= 1).all()


def test_linear_light_of_a_colour_is_what_gives_the_colour():
    colours = np.array([0.1, 0.5, 0.9])
    image = film(QUIET, lambda t, i: np.full((HEIGHT, WIDTH, 3), 1) * filming.linear(colours))
    assert np.abs(image[0, 0, 0] / 255 - colours).max() < 1 / 255


def test_noise_has_the_variance_of_read_and_photon_noise():
    camera = Camera(read_noise=0.02, photon_noise=0.001, blur=0.0, parts=1, softness=0.0)
    light = (film(camera, even(0.4)) / 255) ** 2.2
    assert light.mean() == pytest.approx(0.4, rel=0.01)
    assert light.std() == pytest.approx(np.sqrt(0.02**2 + 0.001 * 0.4), rel=0.03)


def test_noise_differs_from_frame_to_frame_and_is_the_same_for_the_same_seed():
    first, second = film(Camera(), even(0.3), 2)
    assert (first != second).mean() > 0.3
    np.testing.assert_array_equal(film(Camera(), even(0.3), 2), [first, second])


def test_the_lens_softens_an_edge():
    def edge(time, moment):
        return np.where(np.arange(WIDTH) < 160, 0.0, 1.0)[None, :, None] * np.ones((HEIGHT, 1, 3))

    sharp = film(QUIET, edge)[0, 100, :, 0]
    soft = film(Camera(0.0, 0.0, 0.0, 1, 1.5), edge)[0, 100, :, 0]
    assert set(np.unique(sharp)) == {0, 255}
    assert ((soft > 20) & (soft < 235)).sum() >= 3


def test_an_exposure_takes_the_mean_of_its_moments_about_the_middle():
    asked = []

    def clock(time, moment):
        asked.append((time, moment))
        return np.full((HEIGHT, WIDTH, 3), 0.1 * (moment + 1))

    image = film(Camera(0.0, 0.0, 0.6, 3, 0.0), clock, 2)
    np.testing.assert_allclose([t for t, _ in asked], [-0.2, 0, 0.2, 0.8, 1, 1.2], atol=1e-12)
    assert [i for _, i in asked] == [0, 1, 2] * 2
    assert (np.abs(image - 255 * 0.2 ** (1 / 2.2)) <= 1).all()


def test_waves_are_smooth_keep_to_their_reach_and_use_most_of_it():
    rng = np.random.default_rng(4)
    for _ in range(20):
        found = filming.wave(3.0, (20.0, 90.0), rng=rng)
        values = np.array([found(0.25 * k) for k in range(4000)])
        assert 1.8 < np.abs(values).max() <= 3.0
        assert np.abs(np.diff(values)).max() < 3.0 * 2 * np.pi / (20 * 0.85) * 0.25
