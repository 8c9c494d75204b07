"""Trajectory errors against SciPy, a decomposition by hand, and what must not matter."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from robot_perception.evaluation.trajectories import (
    absolute_error,
    align,
    end_error,
    motion_errors,
    relative_error,
    relative_error_over,
    relative_poses,
)
from robot_perception.geometry import act, wrap_angle
from tests.unchecked import unchecked

SEEDS = st.integers(0, 2**31)
MOTIONS = hnp.arrays(float, 3, elements=st.floats(-50, 50))


def paths(seed, k=30, noise=0.3):
    rng = np.random.default_rng(seed)
    truth = np.cumsum(rng.normal(size=(k, 3)), axis=0)
    return truth + rng.normal(scale=noise, size=(k, 3)), truth


def moved(motion, poses):
    """Move a whole path as a rigid body."""
    return np.column_stack([act(motion, poses[:, :2]), poses[:, 2] + motion[2]])


def matrix(pose):
    x, y, phi = pose
    cos, sin = np.cos(phi), np.sin(phi)
    return np.array([[cos, -sin, x], [sin, cos, y], [0, 0, 1]])


@given(SEEDS)
@settings(max_examples=40)
def test_alignment_is_scipys(seed):
    estimate, truth = paths(seed)
    motion = align(estimate, truth)
    space = [np.pad(path[:, :2] - path[:, :2].mean(0), ((0, 0), (0, 1))) for path in paths(seed)]
    normal = [[0, 0, 1e3]]  # SciPy turns in space: hold the plane's normal
    turn, _ = Rotation.align_vectors(np.vstack([space[1], normal]), np.vstack([space[0], normal]))
    assert wrap_angle(motion[2] - turn.as_rotvec()[2]) == pytest.approx(0, abs=1e-8)


@given(SEEDS, st.booleans())
@settings(max_examples=40)
def test_alignment_is_umeyamas_decomposition_even_for_mirrored_paths(seed, mirror):
    """Eqs 38-42 written out, with S = diag(1, -1) where the best fit would be a reflection."""
    estimate, truth = paths(seed)
    p, q = estimate[:, :2] * ([1, -1] if mirror else [1, 1]), truth[:, :2]
    u, values, vt = np.linalg.svd((q - q.mean(0)).T @ (p - p.mean(0)))
    assume(values[0] - values[1] > 1e-6)
    turn = u @ np.diag([1, np.sign(np.linalg.det(u) * np.linalg.det(vt))]) @ vt
    motion = align(p, q)
    np.testing.assert_allclose(matrix(motion)[:2, :2], turn, atol=1e-8)
    np.testing.assert_allclose(motion[:2], q.mean(0) - turn @ p.mean(0), atol=1e-7)


@given(SEEDS, MOTIONS, MOTIONS)
def test_aligned_error_does_not_depend_on_where_the_paths_lie(seed, one, other):
    estimate, truth = paths(seed)
    error = absolute_error(estimate, truth, aligned=True)
    elsewhere = absolute_error(moved(one, estimate), moved(other, truth), aligned=True)
    assert elsewhere == pytest.approx(error, rel=1e-6)


@given(SEEDS, MOTIONS)
def test_alignment_finds_a_motion_again_and_never_adds_error(seed, motion):
    estimate, truth = paths(seed)
    found = align(truth, moved(motion, truth))
    np.testing.assert_allclose(matrix(found), matrix(motion), atol=1e-9)
    assert absolute_error(truth, moved(motion, truth), aligned=True) < 1e-9
    with_start = absolute_error(moved(motion, estimate), truth, aligned=False)
    assert absolute_error(estimate, truth, aligned=True) <= with_start + 1e-12


def test_absolute_error_by_hand():
    truth = np.array([[0.0, 0], [1, 0], [2, 0], [3, 0]])
    estimate = truth + np.array([[3.0, 4], [0, 0], [0, 0], [0, 5]])
    assert absolute_error(estimate, truth, aligned=False) == pytest.approx(np.sqrt(50 / 4))
    poses = np.column_stack([truth, np.full(4, 1.0)])  # headings do not matter
    assert absolute_error(estimate, poses, aligned=False) == pytest.approx(np.sqrt(50 / 4))


def test_alignment_keeps_the_scale():
    truth = np.array([[0.0, 0], [1, 0], [2, 0]])
    assert absolute_error(2 * truth, truth, aligned=True) == pytest.approx(np.sqrt(2 / 3))


def test_end_error_takes_the_short_way_round():
    truth = np.array([[0.0, 0, 0], [1, 1, np.pi - 0.1]])
    error = end_error(truth + np.array([[9.0, 9, 9], [3, 4, 0.2]]), truth)
    assert (error.position, error.heading) == pytest.approx((5.0, 0.2))
    around = end_error(truth * [1, 1, -1], truth)
    assert around.heading == pytest.approx(0.2)


@given(SEEDS, st.integers(1, 29))
@settings(max_examples=40)
def test_relative_errors_are_those_of_matrices(seed, steps):
    """Oracle: homogeneous matrices, inverted by NumPy."""
    estimate, truth = paths(seed)
    errors = relative_error(estimate, truth, steps)
    for i in range(len(truth) - steps):
        p, q = (
            np.linalg.inv(matrix(path[i])) @ matrix(path[i + steps]) for path in (estimate, truth)
        )
        e = np.linalg.inv(q) @ p
        assert errors.translation[i] == pytest.approx(np.hypot(*e[:2, 2]), abs=1e-9)
        apart = wrap_angle(errors.rotation[i] - np.arctan2(e[1, 0], e[0, 0]))
        assert apart == pytest.approx(0, abs=1e-9)
    assert errors.translation_rms == pytest.approx(np.sqrt(np.mean(errors.translation**2)))
    assert errors.rotation_rms == pytest.approx(np.sqrt(np.mean(errors.rotation**2)))


@given(SEEDS, MOTIONS, MOTIONS)
def test_relative_errors_do_not_depend_on_where_the_paths_lie(seed, one, other):
    estimate, truth = paths(seed)
    here = relative_error(estimate, truth, 3)
    there = relative_error(moved(one, estimate), moved(other, truth), 3)
    np.testing.assert_allclose(there.translation, here.translation, atol=1e-9)
    np.testing.assert_allclose(wrap_angle(there.rotation - here.rotation), 0, atol=1e-9)


def test_distance_is_measured_along_the_true_path():
    truth = np.zeros((6, 3))
    truth[:, 0] = [0, 1, 2, 1, 0, 1]  # there and back: 5 m in all
    estimate = truth + np.array([0.0, 0, 0, 0, 0.5, 0])[:, None] * [1, 0, 0]
    over = relative_error_over(estimate, truth, 4.0)
    np.testing.assert_allclose(over.translation, [0.5, 0])  # 0 -> 4 and 1 -> 5
    assert len(relative_error_over(estimate, truth, 5.0).translation) == 1
    assert len(relative_error_over(estimate, truth, 3.5).translation) == 2  # none shorter


def test_errors_of_verified_motions():
    errors = motion_errors(np.array([[3.0, 4, 3.1]]), np.array([[0.0, 0, -3.1]]))
    np.testing.assert_allclose(errors.translation, 5)
    np.testing.assert_allclose(errors.rotation, 6.2 - 2 * np.pi)


PATH = np.arange(12.0).reshape(4, 3)
HOLE = np.where(PATH == 4, np.nan, PATH)
TRIANGLE = np.stack([np.cos(2 * np.pi * np.arange(3) / 3), np.sin(2 * np.pi * np.arange(3) / 3)], 1)
MIRRORED = TRIANGLE * [1, -1] + 1e-13 * np.eye(3, 2)
STILL = 1e6 + np.spacing(1e6) * np.eye(3, 2)  # but for the last digit
SQUARE = np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: align(PATH, PATH[:3]), r"one length, got \(4, 3\) and \(3, 3\)"),
        (lambda: align(PATH[:, :1], PATH), r"two paths \(k, 2 or 3\)"),
        (lambda: align(PATH[0], PATH[0]), r"two paths \(k, 2 or 3\)"),
        (lambda: align(PATH[:0], PATH[:0]), "the paths are empty"),
        (lambda: align(HOLE, PATH), "estimate must be finite, got 1 of 12"),
        (lambda: absolute_error(PATH, HOLE, aligned=False), "truth must be finite, got 1 of 12"),
        (lambda: align(PATH[:1], PATH[:1]), "do not determine a rotation"),
        (lambda: align(np.full((4, 2), 7e6), PATH), "do not determine a rotation"),
        (lambda: align(np.full((3, 2), 0.1), PATH[:3]), "do not determine a rotation"),
        (lambda: align(STILL, TRIANGLE), "do not determine a rotation"),
        (lambda: align(MIRRORED, TRIANGLE), "do not determine a rotation"),
        (lambda: align(SQUARE, SQUARE * [1, -1]), "do not determine a rotation: spread 4 m²"),
        (lambda: end_error(PATH[:, :2], PATH[:, :2]), r"two paths \(k, 3\) of one length"),
        (lambda: relative_error(PATH, PATH, 4), "steps must be from 1 to 3, got 4"),
        (lambda: relative_error(PATH, PATH, 0), "steps must be from 1 to 3, got 0"),
        (lambda: relative_error_over(PATH, PATH, 20.0), "distance must be from 0 to 12.7279 m"),
        (lambda: relative_error_over(PATH, PATH, 0.0), "distance must be from 0 to"),
        (lambda: relative_poses(PATH, np.array([[0, 4]])), "pairs name poses 0 to 4 of 4"),
        (lambda: relative_error(PATH, PATH, 1.5), "steps must be a whole number, got 1.5"),
        (lambda: relative_poses(PATH, np.array([[-1, 2]])), "pairs name poses -1 to 2 of 4"),
        (lambda: relative_poses(PATH, np.array([1, 2])), r"pairs must be \(n, 2\)"),
        (lambda: motion_errors(PATH[:0], PATH[:0]), "the paths are empty"),
    ],
)
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        build()
