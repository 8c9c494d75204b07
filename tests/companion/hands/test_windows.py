"""Windows for the training: where they are cut, how they are drawn, and that the hard ones pass."""

import cv2
import numpy as np
import pytest

from robot_perception.companion.hands.cascade import Goals, train
from robot_perception.companion.hands.features import SIZE, feature_pool
from robot_perception.companion.hands.windows import hard_windows, random_window, window_at
from tests.companion.hands.test_cascade import bars, noise
from tests.unchecked import unchecked

RNG = np.random.default_rng
PICTURE = RNG(0).integers(0, 256, (90, 120), dtype=np.uint8)


def test_a_window_is_the_mean_over_its_pixels():
    found = window_at(PICTURE, np.array([30.0, 12.0, 48.0, 48.0]))
    wanted = PICTURE[12:60, 30:78].reshape(SIZE, 2, SIZE, 2).mean(axis=(1, 3))
    np.testing.assert_allclose(found, wanted, atol=0.51)
    np.testing.assert_array_equal(found, window_at(PICTURE, np.array([30.4, 11.6, 48.3, 99.0])))


def test_random_windows_lie_anywhere_and_their_size_is_even_in_its_logarithm():
    """A picture of coordinates tells where its windows were cut."""
    rows, columns = np.mgrid[:96, :200].astype(np.uint8)
    sides, lows = [], []
    for k in range(800):
        across, down = (random_window(image, rng=RNG(k)).astype(float) for image in (columns, rows))
        for image in (across, down):
            assert np.ptp(image) < 96
        side = 1 + np.ptp(across) * SIZE / (SIZE - 1)
        sides.append(side)
        lows.append([(across.min() + 0.5) / 200, (down.min() + 0.5) / 96])
    low, high = np.log(SIZE), np.log(96)
    assert np.mean(np.log(sides)) == pytest.approx((low + high) / 2, abs=0.06)
    lows = np.array(lows)
    assert lows.min() < 0.02
    assert lows[:, 0].max() > 0.8, "also at the right of a wide picture"


@pytest.fixture(scope="module")
def cascade():
    """A cascade that knows bars from noise, and keeps some of the noise."""
    goals = Goals(stages=2, most=3)
    pool = feature_pool(RNG(1), 60)
    return train(bars(RNG(2), 60), lambda _, count: noise(RNG(3), count), pool, count=80,
                 goals=goals)[0]  # fmt: skip


def room(rng, hidden):
    """Return a picture of noise with some windows of bars hidden in it."""
    image = cv2.resize(rng.integers(0, 256, (12, 16)).astype(np.uint8), (160, 120))
    for k, one in enumerate(hidden):
        image[8 + 60 * (k % 2) :, 8 + 50 * (k // 2) :][:SIZE, :SIZE] = one
    return image


def test_hard_windows_pass_and_half_of_them_are_of_those_that_are_given(cascade):
    given = np.concatenate([bars(RNG(4), 30), noise(RNG(5), 30)])
    pictures = [room(RNG(k), bars(RNG(10 + k), 4)) for k in range(4)]
    found = hard_windows(cascade, 20, pictures=pictures, windows=given, rng=RNG(6))
    stages = len(cascade.stages)
    assert (cascade.passed(found) == stages).all()
    taken = {one.tobytes() for one in given}
    assert sum(one.tobytes() in taken for one in found) == 10
    assert 10 < len(found) <= 20
    first = given[cascade.passed(given) == stages][:10]
    np.testing.assert_array_equal(found[-10:], first)


def test_few_that_pass_leave_the_rest_to_the_pictures(cascade):
    given = bars(RNG(4), 2)
    pictures = [room(RNG(k), bars(RNG(10 + k), 4)) for k in range(4)]
    found = hard_windows(cascade, 20, pictures=pictures, windows=given, rng=RNG(6))
    assert len(found) > 10
    none = hard_windows(cascade, 20, pictures=pictures, windows=given[:0], rng=RNG(6))
    assert (cascade.passed(none) == len(cascade.stages)).all()
    flat = [np.full((60, 60), 90, np.uint8)]
    np.testing.assert_array_equal(
        hard_windows(cascade, 20, pictures=flat, windows=given, rng=RNG(6)), given
    )


def test_without_a_cascade_half_are_drawn_and_half_are_given():
    given = noise(RNG(5), 30)
    found = hard_windows(None, 21, pictures=[PICTURE, PICTURE.T.copy()], windows=given, rng=RNG(6))
    taken = {one.tobytes() for one in given}
    assert [one.tobytes() in taken for one in found] == [False] * 10 + [True] * 11
    assert len({one.tobytes() for one in found}) == 21


def test_the_same_draws_give_the_same_windows(cascade):
    pictures = [room(RNG(k), bars(RNG(10 + k), 4)) for k in range(3)]
    for so_far in (None, cascade):
        one, two, other = (
            hard_windows(so_far, 12, pictures=pictures, windows=noise(RNG(5), 9), rng=RNG(seed))
            for seed in (1, 1, 2)
        )
        np.testing.assert_array_equal(one, two)
        assert one.shape != other.shape or (one != other).any()


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda: window_at(PICTURE, np.array([500.0, 5, 30, 30])), "box must reach into"),
        (lambda: random_window(PICTURE[:20], rng=RNG(0)), "image must be of 24 px at least"),
        (lambda: hard_windows(None, 9, pictures=[], windows=noise(RNG(0), 2), rng=RNG(0)),
         "pictures must not be empty"),
        (lambda: hard_windows(None, 0, pictures=[PICTURE], windows=noise(RNG(0), 2), rng=RNG(0)),
         "count must be"),
    ],
)  # fmt: skip
def test_what_gives_no_window_is_named(make, problem):
    with unchecked(), pytest.raises(ValueError, match=problem):
        make()
