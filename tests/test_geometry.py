"""Angles and rigid motions against complex numbers, homogeneous matrices and the group's laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from robot_perception.geometry import act, between, compose, inverse, rotation, wrap_angle
from robot_perception.slam.planar.kernels import wrapped as compiled_wrap
from tests.unchecked import unchecked

FLOATS = st.floats(-50, 50)
POSES = hnp.arrays(float, 3, elements=FLOATS)
BATCHES = hnp.arrays(float, st.sampled_from([(3,), (4, 3), (2, 4, 3)]), elements=FLOATS)
JUST_BELOW = [np.nextafter(k * np.pi, -np.inf) for k in (-3, -1, 1, 3)]


@given(st.one_of(st.floats(-1e3, 1e3), st.sampled_from(JUST_BELOW)))
def test_wrapped_angle_is_the_same_direction_in_range(angle):
    wrapped = wrap_angle(angle)
    assert -np.pi <= wrapped < np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-9)
    assert compiled_wrap(angle) == wrapped == wrap_angle(np.array([0.0, angle]))[1]


@given(st.floats(-np.pi, np.pi, exclude_max=True))
def test_an_angle_in_range_stays_as_it_is(angle):
    assert wrap_angle(angle) == angle


@pytest.mark.parametrize("turns", [1, -3, 1000])
def test_both_sides_of_an_odd_multiple_of_pi(turns):
    for angle in (np.nextafter(turns * np.pi, towards) for towards in (-np.inf, np.inf)):
        assert -np.pi <= wrap_angle(angle) < np.pi
    with pytest.raises(ValueError, match="angle must be finite"):
        wrap_angle(np.array([0.0, turns * np.inf]))


def matrix(pose):
    """Return homogeneous matrices, from complex numbers."""
    turn = np.exp(1j * pose[..., 2])
    T = np.zeros((*pose.shape[:-1], 3, 3))
    T[..., 0, 0] = T[..., 1, 1] = turn.real
    T[..., 1, 0], T[..., 0, 1], T[..., 2, 2] = turn.imag, -turn.imag, 1
    T[..., :2, 2] = pose[..., :2]
    return T


def assert_same(pose, wanted):
    np.testing.assert_allclose(matrix(pose), wanted, rtol=0, atol=1e-11)
    assert ((pose[..., 2] >= -np.pi) & (pose[..., 2] < np.pi)).all()


@given(BATCHES, POSES)
def test_motions_are_those_of_homogeneous_matrices(batch, one):
    T, U = matrix(batch), matrix(one)
    assert_same(compose(batch, one), T @ U)
    assert_same(compose(one, batch), U @ T)
    assert_same(inverse(batch), np.linalg.inv(T))
    assert_same(between(one, batch), np.linalg.inv(U) @ T)
    np.testing.assert_allclose(rotation(batch[..., 2]), T[..., :2, :2], rtol=0, atol=1e-15)


@given(POSES, POSES, POSES)
def test_the_laws_of_a_group(a, b, c):
    none = np.zeros(3)
    assert_same(compose(compose(a, b), c), matrix(compose(a, compose(b, c))))
    assert_same(compose(a, none), matrix(a))
    assert_same(compose(none, a), matrix(a))
    assert_same(compose(a, inverse(a)), np.eye(3))
    assert_same(compose(a, between(a, b)), matrix(b))
    assert_same(inverse(inverse(a)), matrix(a))


@given(BATCHES, POSES, hnp.arrays(float, (5, 2), elements=FLOATS))
def test_acting_twice_is_acting_once_with_both(batch, one, points):
    moved = act(batch, points)
    assert moved.shape == (*batch.shape[:-1], 5, 2)
    z = (points[:, 0] + 1j * points[:, 1]) * np.exp(1j * batch[..., 2, None])
    z += batch[..., 0, None] + 1j * batch[..., 1, None]
    np.testing.assert_allclose(moved, np.stack([z.real, z.imag], -1), rtol=0, atol=1e-11)
    np.testing.assert_allclose(act(one, moved), act(compose(one, batch), points), atol=1e-11)
    np.testing.assert_allclose(act(inverse(batch), moved), points + 0 * moved, rtol=0, atol=1e-11)


@pytest.mark.parametrize("call", [compose, between, act, lambda a, b: inverse(a)])
def test_wrong_shapes_are_named(call):
    with unchecked(), pytest.raises(ValueError, match=r"\(4, 2\)"):
        call(np.zeros((4, 2)), np.zeros((4, 2)))
