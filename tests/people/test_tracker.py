"""The whole tracker: a robot that drives, people in the world, and one cue after the other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.geometry import se2
from robot_perception.people.aggregation import AggregationRules, Aggregator
from robot_perception.people.detections import Detections, polar
from robot_perception.people.tracker import PeopleTracker
from robot_perception.people.trajectories import StaticRules
from robot_perception.people.verification import Verifier
from tests.people.test_aggregation import known

TRACKER = PeopleTracker(AggregationRules(walk=0.1), StaticRules(spread=0.3, longest=2.0))
VERIFIER = Verifier(0.15)
PEOPLE = np.array([[2.0, 1.0], [1.0, -2.0]])


def seen(time, pose):
    """Return the two people who stand in the world, as a robot at a pose sees them."""
    x, y = se2.act(se2.inverse(pose), PEOPLE).T
    return Detections(time, "laser", polar(np.hypot(x, y), np.arctan2(y, x), 0.05, 0.02))


@given(st.floats(-0.5, 0.5), st.floats(-1, 1))
def test_who_stands_still_is_one_hypothesis_and_static_while_the_robot_drives(speed, turn):
    pose, rolled = np.array([0.2, 0.1, 0.5]), np.array([0.1 * speed, 0.0, 0.1 * turn])
    state = TRACKER.start(pose)
    for k in range(30):
        state, info = TRACKER.step(state, seen(0.1 * k, pose), pose)
        assert (info.static == (0.1 * k > 2.0)).all()
        assert info.merged.matched.all() == (k > 0)
        pose = se2.compose(pose, rolled)
    there = se2.act(state.pose, state.hypotheses.points)
    assert there[np.argsort(-there[:, 0])] == pytest.approx(PEOPLE, abs=1e-6)


def test_a_constant_error_of_the_pose_changes_nothing_that_is_known_about_the_robot():
    """Only the way between two readings counts, so that wheels will do."""
    off, found = np.array([3.0, -1.0, 0.7]), []
    for start in (np.zeros(3), off):
        state = TRACKER.start(start)
        for k in range(5):
            pose = np.array([0.1 * k, 0.0, 0.05 * k])
            state, _ = TRACKER.step(state, seen(0.1 * k, pose), se2.compose(start, pose))
        found.append(state.hypotheses)
    assert found[0].mean == pytest.approx(found[1].mean)
    assert found[0].weight == pytest.approx(found[1].weight)


def test_without_motion_it_is_the_aggregation():
    pose, aggregator = np.ones(3), Aggregator(TRACKER.aggregation)
    state, found = TRACKER.start(pose), aggregator.start()
    for k in range(4):
        state, info = TRACKER.step(state, seen(0.1 * k, pose), pose)
        found, merged = aggregator.step(found, seen(0.1 * k, pose), np.zeros(3))
        assert np.array_equal(state.hypotheses.mean, found.mean)
        assert np.array_equal(info.merged.identities, merged.identities)


def test_who_was_verified_once_stays_so_and_who_is_gone_is_forgotten():
    three = known((2.0, 0.0), (2.0, 1.0), (2.0, np.pi - 0.05))
    verified, info = VERIFIER.step(VERIFIER.start(), three, np.array([0.1, 0.05 - np.pi]))
    assert info.chosen.tolist() == [True, False, True]
    assert verified == set(three.identity[[0, 2]].tolist())
    after, info = VERIFIER.step(verified, three.select(~info.chosen), np.zeros(0))
    assert (after, info.chosen.tolist()) == (frozenset(), [False])
    after, info = VERIFIER.step(verified, three, np.zeros(0))
    assert (after, info.chosen.tolist()) == (verified, [True, False, True])
