"""The gauge study: exact ranks, and worlds really moved."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from robot_perception.chapters.anchored_slam import gauge
from robot_perception.chapters.anchored_slam.gauge import AT_REST, DIRECTIONS, READINGS, SETS
from robot_perception.slam.observability import analyse, fixed_point_matrix, trajectory_matrix

# Ranks -------------------------------------------------------------------------------------------


def numeric_rank(name, reading, moving):
    """Return the rank by floating point, in the world of the explorer with one landmark."""
    used = gauge.sensors(name, gauge.PLACES)
    poses = gauge.PATH if moving else gauge.PATH * [0, 0, 1] + [1, 2, 0]
    states = np.hstack([poses, np.tile(gauge.LANDMARKS[0], (len(poses), 1))])
    if reading == "one point":
        increment = np.array([0.8, -0.1, 0.2]) * [moving, moving, 1]
        return analyse(fixed_point_matrix(used, states[0], increment)).rank
    return analyse(trajectory_matrix(used, states)).rank


@pytest.mark.parametrize("moving", [True, False])
def test_exact_ranks_equal_those_of_floating_point(moving):
    table = gauge.ranks(moving=moving)
    assert set(table) == set(product(SETS, READINGS))
    assert all(reading.proven for reading in table.values())
    for (name, reading), entry in table.items():
        assert entry.rank == numeric_rank(name, reading, moving), (name, reading)


def test_table_says_what_the_ranks_say():
    table = gauge.rank_table()
    assert table.corner == "rank of 5"
    for name, reading in product(SETS, READINGS):
        assert table[name, reading] == gauge.ranks(moving=True)[name, reading].rank
    assert table["one anchor", "unseen"] == "turn about the anchor"
    assert gauge.rank_table(moving=False)["position sensor", "unseen"] == "turn about the robot"


# Moved worlds ------------------------------------------------------------------------------------

UNSEEN = {
    "plain": set(DIRECTIONS),
    "one anchor": {"turn about the anchor"},
    AT_REST: {"turn about the robot"},
}


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("sensing", [*SETS, AT_REST])
def test_residuals_vanish_exactly_along_what_is_unseen(sensing, direction):
    for amount in (-2, -1, 1, 2):
        residual = gauge.move_world(sensing, direction, amount).residual
        if direction in UNSEEN.get(sensing, set()):
            assert residual < 1e-12
        else:
            assert residual > 0.1


def test_what_is_unseen_is_what_the_exact_analysis_names():
    for name, moving in (*product(SETS, (True,)), ("position sensor", False)):
        named = gauge.ranks(moving=moving)[name, "nonlinear"].unseen
        seen = UNSEEN.get(name if moving else AT_REST, set())
        assert set(named) <= seen
        assert bool(named) == bool(seen)


@given(st.sampled_from([*SETS, AT_REST]), st.sampled_from(DIRECTIONS), st.floats(-3, 3, width=32))
@settings(max_examples=60)
def test_moving_keeps_all_distances_and_the_gap_is_the_residual(sensing, direction, amount):
    world = gauge.move_world(sensing, direction, amount)
    before = np.vstack([world.poses[:, :2], world.landmarks])
    after = np.vstack([world.moved_poses[:, :2], world.moved_landmarks])
    np.testing.assert_allclose(pdist(before), pdist(after), atol=1e-12)
    gaps = np.linalg.norm(world.misses - world.anchors, axis=-1)
    shifts = np.linalg.norm((world.moved_poses - world.poses)[: len(world.fixes), :2], axis=-1)
    largest = max(gaps.max(initial=0.0), shifts.max(initial=0.0))
    assert world.metres == pytest.approx(largest, abs=1e-12)
