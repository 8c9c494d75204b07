"""Angles and rigid motions against complex numbers."""

import inspect

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.geometry import transform, wrap_angle


@given(st.floats(-1e3, 1e3))
def test_wrapped_angle_is_the_same_direction_in_range(angle):
    wrapped = wrap_angle(angle)
    assert -np.pi <= wrapped < np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-9)


def test_transform_is_rotation_then_translation_for_batches():
    rng = np.random.default_rng(0)
    poses, points = rng.normal(size=(4, 3)), rng.normal(size=(4, 5, 2))
    z = (points[..., 0] + 1j * points[..., 1]) * np.exp(1j * poses[:, 2, None])
    z += poses[:, 0, None] + 1j * poses[:, 1, None]
    np.testing.assert_allclose(transform(poses, points), np.stack([z.real, z.imag], -1))
    with pytest.raises(ValueError, match="need poses"):
        inspect.unwrap(transform)(poses[:, :2], points)
