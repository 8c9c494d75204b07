"""Paths in space against gtsam and SciPy, matrices by hand, and what must not matter."""

import gtsam
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from robot_perception.evaluation import trajectories
from robot_perception.evaluation.spatial import (
    Similarity,
    absolute_error,
    align,
    align_poses,
    associate,
    relative_error,
    relative_error_over,
)
from robot_perception.geometry import se3
from tests.unchecked import unchecked

SEEDS = st.integers(0, 2**31)


def paths(rng, k=30, noise=0.3):
    truth = np.cumsum(rng.normal(size=(k, 3)), axis=0)
    return truth + rng.normal(scale=noise, size=(k, 3)), truth


def poses(rng, k=12):
    """Return a path of poses and one that drifts away from it."""
    steps = rng.normal(scale=0.4, size=(k, 6))
    noise = rng.normal(scale=0.05, size=(k, 6))
    true, moved = [np.eye(4)], [np.eye(4)]
    for step, error in zip(steps, noise, strict=True):
        true.append(true[-1] @ se3.exp(step))
        moved.append(moved[-1] @ se3.exp(step + error))
    return np.array(moved), np.array(true)


@given(SEEDS)
@settings(max_examples=30)
def test_alignment_is_scipys_and_with_scale_gtsams(seed):
    estimate, truth = paths(np.random.default_rng(seed))
    rigid, similar = align(estimate, truth, scaled=False), align(estimate, truth, scaled=True)
    turn, _ = Rotation.align_vectors(truth - truth.mean(0), estimate - estimate.mean(0))
    np.testing.assert_allclose(rigid.motion[:3, :3], turn.as_matrix(), atol=1e-7)
    np.testing.assert_allclose(similar.motion[:3, :3], rigid.motion[:3, :3])
    assert rigid.scale == 1.0
    pairs = list(zip(truth, estimate, strict=True))
    theirs = gtsam.Similarity3.Align(pairs)
    np.testing.assert_allclose(similar.motion[:3, :3], theirs.rotation().matrix(), atol=1e-7)
    residual = truth - truth.mean(0), (estimate - estimate.mean(0)) @ turn.as_matrix().T
    scale = np.sum(residual[0] * residual[1]) / np.sum(residual[1] ** 2)  # least squares of c alone
    assert similar.scale == pytest.approx(scale)


@given(SEEDS)
@settings(max_examples=30)
def test_nothing_near_an_alignment_is_better(seed):
    rng = np.random.default_rng(seed)
    estimate, truth = paths(rng, noise=1.0)
    if seed % 2:
        estimate = estimate * [1, 1, -1]  # a mirrored path: the best fit would be a reflection
    for scaled in (False, True):
        best = align(estimate, truth, scaled)
        assert np.linalg.det(best.motion[:3, :3]) == pytest.approx(1)
        error = absolute_error(best.act(estimate), truth)
        for nudge in rng.normal(scale=1e-3, size=(8, 7)):
            stretch = 1 + nudge[6] * scaled
            moved = se3.act(se3.exp(nudge[:6]), stretch * best.act(estimate))
            assert absolute_error(moved, truth) > error - 1e-12


@given(SEEDS, st.floats(0.1, 10))
@settings(max_examples=30)
def test_a_similarity_is_found_again(seed, scale):
    rng = np.random.default_rng(seed)
    _, truth = paths(rng)
    if seed % 2:
        truth[:, 2] = 0  # a path in a plane is enough
    motion = se3.exp(rng.uniform(-1.5, 1.5, 6))
    moved = se3.act(motion, scale * truth)
    found = align(truth, moved, scaled=True)
    assert found.scale == pytest.approx(scale)
    np.testing.assert_allclose(found.motion, motion, atol=1e-8)
    np.testing.assert_allclose(found.act(truth), moved, atol=1e-8 * scale)
    rigid = align(truth, se3.act(motion, truth), scaled=False)
    np.testing.assert_allclose(rigid.motion, motion, atol=1e-8)


@given(SEEDS, st.floats(0.1, 10))
@settings(max_examples=30)
def test_moved_poses_stand_where_their_positions_are_moved_and_turn_alike(seed, scale):
    rng = np.random.default_rng(seed)
    path, _ = poses(rng)
    similarity = Similarity(scale, se3.exp(rng.uniform(-1, 1, 6)))
    moved = similarity.move(path)
    np.testing.assert_allclose(moved[:, :3, 3], similarity.act(path[:, :3, 3]), atol=1e-9)
    between, before = se3.between(moved[:-1], moved[1:]), se3.between(path[:-1], path[1:])
    np.testing.assert_allclose(between[:, :3, :3], before[:, :3, :3], atol=1e-9)
    np.testing.assert_allclose(between[:, :3, 3], scale * before[:, :3, 3], atol=1e-9)


def test_each_alignment_takes_away_what_it_may():
    rng = np.random.default_rng(2)
    _, truth = poses(rng)
    estimate = Similarity(0.5, se3.exp(rng.uniform(-1, 1, 6))).move(truth)
    left = {}
    for alignment in ("none", "se3", "sim3"):
        moved, similarity = align_poses(estimate, truth, alignment)
        left[alignment] = absolute_error(moved[:, :3, 3], truth[:, :3, 3])
        assert similarity.scale == pytest.approx(2.0 if alignment == "sim3" else 1.0)
    assert left["none"] > left["se3"] > left["sim3"]
    assert left["sim3"] == pytest.approx(0, abs=1e-9)


def test_poses_without_a_partner_in_time_are_left_out():
    estimate = np.array([0.0, 1.0, 2.0, 3.0])
    truth = np.array([-0.02, 0.51, 0.98, 1.5, 2.03])
    assert associate(estimate, truth, 0.025).tolist() == [[0, 0], [1, 2]]
    assert associate(truth, estimate, 0.025).tolist() == [[0, 0], [2, 1]]
    assert associate(estimate, truth[:0], 1.0).shape == (0, 2)


def test_absolute_error_by_hand():
    truth = np.zeros((4, 3))
    estimate = np.array([[1.0, 2, 2], [0, 0, 0], [0, 3, 4], [0, 0, 0]])
    assert absolute_error(estimate, truth) == pytest.approx(np.sqrt((9 + 25) / 4))


@given(SEEDS, st.integers(1, 12))
@settings(max_examples=30)
def test_relative_errors_are_those_of_matrices_wherever_the_paths_lie(seed, steps):
    rng = np.random.default_rng(seed)
    estimate, truth = poses(rng)
    errors = relative_error(estimate, truth, steps)
    assert len(errors.translation) == 13 - steps
    for i in range(13 - steps):
        p, q = (np.linalg.inv(path[i]) @ path[i + steps] for path in (estimate, truth))
        E = np.linalg.inv(q) @ p
        assert errors.translation[i] == pytest.approx(np.linalg.norm(E[:3, 3]), abs=1e-9)
        cos = np.clip((np.trace(E[:3, :3]) - 1) / 2, -1, 1)
        assert np.cos(errors.rotation[i]) == pytest.approx(cos, abs=1e-9)
        assert 0 <= errors.rotation[i] <= np.pi
    there, where = se3.exp(rng.uniform(-1, 1, (2, 6)))
    elsewhere = relative_error(there @ estimate, where @ truth, steps)
    np.testing.assert_allclose(elsewhere.translation, errors.translation, atol=1e-9)
    np.testing.assert_allclose(elsewhere.rotation, errors.rotation, atol=1e-7)


@given(SEEDS)
@settings(max_examples=30)
def test_on_a_plane_the_errors_are_the_planar_ones(seed):
    rng = np.random.default_rng(seed)
    truth = np.cumsum(rng.normal(size=(12, 3)), axis=0)
    estimate = truth + rng.normal(scale=0.2, size=(12, 3))
    lifted = se3.from_se2(estimate, 1.0), se3.from_se2(truth, 1.0)
    distance = 0.5 * np.sum(np.linalg.norm(np.diff(truth[:, :2], axis=0), axis=1))
    for flat, space in (
        (trajectories.relative_error(estimate, truth, 3), relative_error(*lifted, 3)),
        (
            trajectories.relative_error_over(estimate, truth, distance),
            relative_error_over(*lifted, distance),
        ),
    ):
        np.testing.assert_allclose(space.translation, flat.translation, atol=1e-9)
        np.testing.assert_allclose(space.rotation, np.abs(flat.rotation), atol=1e-7)
        assert space.translation_rms == pytest.approx(flat.translation_rms)


def test_pairs_are_a_distance_apart_in_space_too():
    steps = np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 1], [0, 3, 4], [1, 0, 0]])
    positions = np.cumsum(steps, axis=0)  # 0, 1, 2, 7, 8 m along the path
    assert trajectories.pairs_over(positions, 2.0).tolist() == [[0, 2], [1, 3], [2, 3]]
    assert trajectories.pairs_over(positions, 8.0).tolist() == [[0, 4]]


PATH = np.array([[0.0, 0, 0], [1, 2, 3], [4, 4, 1], [7, 5, 9]])
STILL = np.stack([np.eye(4)] * 4)
LINE = np.arange(4.0)[:, None] * [1, 2, 3]
TETRAHEDRON = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: align(PATH, PATH[:3], False), r"of one length, got \(4, 3\) and \(3, 3\)"),
        (lambda: align(PATH[:, :2], PATH[:, :2], False), r"two paths of positions \(k, 3\)"),
        (lambda: align(PATH[:0], PATH[:0], False), "not empty"),
        (lambda: align(PATH, PATH * np.nan, False), "truth must be finite, got 12 of 12"),
        (lambda: align(LINE, PATH, False), "do not determine a rotation: singular values"),
        (lambda: align(PATH, LINE + 1e6, True), "do not determine a rotation"),
        (lambda: align(PATH[:1], PATH[:1], True), "do not determine a rotation"),
        (lambda: align(TETRAHEDRON, -TETRAHEDRON, False), "do not determine a rotation"),
        (lambda: align(PATH, PATH, 1), "scaled must be True or False, got 1"),
        (lambda: align_poses(STILL, STILL, "se(3)"), "alignment must be one of 'none', 'se3', 'si"),
        (lambda: align_poses(STILL, STILL, "se3"), "do not determine a rotation"),
        (lambda: align_poses(PATH, PATH, "se3"), r"two paths of poses \(k, 4, 4\)"),
        (lambda: Similarity(2.0, np.eye(4)).move(2 * STILL), "poses must have the last row"),
        (lambda: associate(np.ones(2), np.arange(2), 0.1), "estimate must be times that rise"),
        (lambda: associate(np.arange(2), np.ones(2), 0.1), "truth must be times that rise"),
        (lambda: associate(np.arange(2), np.arange(2), -1), "most must not be negative, got -1"),
        (lambda: relative_error(PATH, PATH, 1), r"two paths of poses \(k, 4, 4\)"),
        (lambda: relative_error(2 * STILL, STILL, 1), "estimate must have the last row"),
        (lambda: relative_error(STILL, STILL, 4), "steps must be from 1 to 3, got 4"),
        (lambda: relative_error_over(STILL, STILL, 1.0), "distance must be from 0 to 0 m"),
        (lambda: trajectories.pairs_over(PATH, 99.0), "distance must be from 0 to .*, got 99"),
        (
            lambda: trajectories.pairs_over(PATH[:, :1], 1.0),
            r"positions must be \(k, 2\) or \(k, 3",
        ),
    ],
)
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises((ValueError, TypeError), match=message):
        build()
