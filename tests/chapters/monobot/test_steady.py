"""The two parts of a landmark's gain."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.chapters.monobot import rail, steady
from robot_perception.chapters.monobot.rail import FIG3, FIG4


@pytest.mark.parametrize("base", [FIG3, FIG4], ids=["fig3", "fig4"])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_own_gain_is_what_tells_a_landmark_from_the_others(base, n):
    """Equal landmarks: every gain is one number on the diagonal and another beside it."""
    base = replace(base, steps=20)
    gains = rail.covariances(replace(base, landmarks=n)).gains[0, :, 1:]
    beside = gains[:, 0, -1] if n > 1 else 0.0
    diagonal = gains[:, 0, 0] - beside
    common, own = steady.gain_curves((n,), base)[n]
    scale = gains.max()
    np.testing.assert_allclose(common, diagonal + n * beside, atol=1e-12 * scale)
    np.testing.assert_allclose(own, (1 - 1 / n) * diagonal, atol=1e-12 * scale)
