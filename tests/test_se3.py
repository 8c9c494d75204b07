"""Rigid motions of space against matrices and the matrix exponential."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.linalg import expm

from robot_perception import geometry
from robot_perception.geometry import se3
from tests.unchecked import unchecked

TWISTS = hnp.arrays(float, 6, elements=st.floats(-1.5, 1.5))
POSES = hnp.arrays(float, 3, elements=st.floats(-50, 50))
POINTS = np.array([[0.0, 0, 0], [1, 2, 3], [-4, 0.5, 2]])
SEEDS = st.integers(0, 2**31)


def generator(twist):
    """Return the matrix whose exponential the motion is."""
    x, y, z = twist[3:]
    G = np.zeros((4, 4))
    G[:3, :3], G[:3, 3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]], twist[:3]
    return G


@given(TWISTS)
def test_exponential_is_that_of_the_matrix_and_logarithm_leads_back(twist):
    pose = se3.exp(twist)
    np.testing.assert_allclose(pose, expm(generator(twist)), rtol=0, atol=1e-13)
    np.testing.assert_allclose(se3.log(pose), twist, rtol=0, atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 0.9999e-4, 1.0001e-4, 1e-3, 1.0, 3.0])
@pytest.mark.parametrize("below_half_a_turn", [False, True])
def test_exponential_of_every_size(angle, below_half_a_turn):
    axis = np.array([2.0, -1, 2]) / 3
    angle = np.pi - angle if below_half_a_turn else angle
    twist = np.array([0.3, -2.0, 1.0, *(angle * axis)])
    pose = se3.exp(twist)
    np.testing.assert_allclose(pose, expm(generator(twist)), rtol=0, atol=1e-14)
    np.testing.assert_allclose(se3.exp(se3.log(pose)), pose, rtol=0, atol=1e-13)
    if angle < np.pi:
        np.testing.assert_allclose(se3.log(pose), twist, rtol=0, atol=1e-12)


@given(SEEDS)
def test_motions_are_those_of_matrices_in_batches(seed):
    rng = np.random.default_rng(seed)
    batch, one = se3.exp(rng.uniform(-1.5, 1.5, (2, 4, 6))), se3.exp(rng.uniform(-1.5, 1.5, 6))
    near = {"rtol": 0, "atol": 1e-12}
    np.testing.assert_allclose(se3.compose(batch, one), batch @ one, **near)
    np.testing.assert_allclose(se3.inverse(batch), np.linalg.inv(batch), **near)
    np.testing.assert_allclose(se3.between(one, batch), np.linalg.inv(one) @ batch, **near)
    np.testing.assert_allclose(se3.log(batch)[1, 2], se3.log(batch[1, 2]), **near)
    homogeneous = np.column_stack([POINTS, np.ones(3)])
    moved = se3.act(batch, POINTS)
    np.testing.assert_allclose(moved, (homogeneous @ batch.mT)[..., :3], **near)
    np.testing.assert_allclose(se3.act(one, moved), se3.act(one @ batch, POINTS), **near)


@given(SEEDS)
def test_what_is_fixed_to_a_body_moves_with_it(seed):
    """A camera that is carried from one pose to another; and back by the inverse of the mount."""
    rng = np.random.default_rng(seed)
    before, mount, motions = se3.exp(rng.uniform(-1.5, 1.5, (3, 5, 6)))
    carried = np.linalg.inv(before @ mount) @ (before @ motions @ mount)
    ours = se3.conjugated(motions, mount[0])
    np.testing.assert_allclose(se3.conjugated(motions, mount), carried, rtol=0, atol=1e-12)
    np.testing.assert_allclose(ours[0], carried[0], rtol=0, atol=1e-12)
    back = se3.conjugated(ours, se3.inverse(mount[0]))
    np.testing.assert_allclose(back, motions, rtol=0, atol=1e-12)


@given(POSES, POSES)
def test_the_plane_lies_in_space(first, second):
    ours = se3.compose(se3.from_se2(first, 1.5), se3.from_se2(second))
    np.testing.assert_allclose(ours, se3.from_se2(geometry.compose(first, second), 1.5), atol=1e-11)
    flat = geometry.act(first, POINTS[:, :2])
    space = se3.act(se3.from_se2(first, 1.5), POINTS)
    np.testing.assert_allclose(space, np.column_stack([flat, POINTS[:, 2] + 1.5]), atol=1e-11)
    assert se3.from_se2(np.stack([first, second])).shape == (2, 4, 4)


def test_six_digits_of_a_rotation_are_enough():
    rough = np.round(se3.exp(np.array([1.0, 2, 3, 0.4, -0.5, 0.6])), 6)
    assert se3.checked("pose", rough) is rough


EYE = np.eye(4)
SHEAR, MIRROR, FAR = EYE.copy(), np.diag([1.0, 1, -1, 1]), EYE.copy()
SHEAR[0, 1], FAR[3, 0] = 2e-5, 1e-3


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: se3.inverse(np.eye(3)), r"pose must be \(…, 4, 4\), got \(3, 3\)"),
        (lambda: se3.inverse(SHEAR), "pose must hold rotations, but RᵀR differs from 1 by 2e-05"),
        (lambda: se3.log(np.stack([EYE, MIRROR])), "rotations, but there is a reflection"),
        (lambda: se3.compose(FAR, EYE), r"first must have the last row \(0, 0, 0, 1\)"),
        (lambda: se3.between(EYE, FAR), r"second must have the last row \(0, 0, 0, 1\)"),
        (lambda: se3.conjugated(FAR, EYE), r"motion must have the last row \(0, 0, 0, 1\)"),
        (lambda: se3.conjugated(EYE, FAR), r"mount must have the last row \(0, 0, 0, 1\)"),
        (lambda: se3.act(EYE, np.ones(3)), r"points must be \(…, n, 3\), got \(3,\)"),
        (lambda: se3.act(np.stack([EYE] * 2), np.ones((3, 4, 3))), "leading axes must broadcast"),
        (lambda: se3.exp(np.full(6, np.nan)), "twist must be finite, got 6 of 6"),
        (lambda: se3.from_se2(np.zeros(3), np.inf), "height must be finite, got inf"),
    ],
)
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        build()
