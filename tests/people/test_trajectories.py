"""Ways of hypotheses in the world, and what never moves."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.geometry import se2
from robot_perception.people.aggregation import Hypotheses
from robot_perception.people.trajectories import (
    StaticRules,
    Stays,
    Trajectory,
    trajectories,
    watch,
)
from tests.people.test_aggregation import known
from tests.unchecked import unchecked

RULES = StaticRules(spread=0.4, longest=5.0)


def at(time, pose, ids, *places):
    """Return hypotheses at places in the world about a robot at a pose."""
    x, y = se2.act(se2.inverse(pose), np.array(places, dtype=float).reshape(-1, 2)).T
    some = known(*np.stack([np.hypot(x, y), np.arctan2(y, x)], axis=-1), time=time)
    return replace(some, identity=np.array(ids, dtype=np.int64), following=100)


def test_trajectories_are_in_the_world_and_by_identity():
    poses = np.array([[0.1 * k, 0.2, 0.3 * k] for k in range(10)])
    history = [
        at(float(k), pose, [3, 5][: 1 + (k > 4)], *[(2, 1 + 0.1 * k), (-1, 3)][: 1 + (k > 4)])
        for k, pose in enumerate(poses)
    ]
    first, second = trajectories(history, poses)
    assert (first.identity, second.identity) == (3, 5)
    np.testing.assert_allclose(first.times, np.arange(10.0))
    np.testing.assert_allclose(first.points, [[2, 1 + 0.1 * k] for k in range(10)], atol=1e-12)
    np.testing.assert_allclose(second.times, np.arange(5.0, 10))
    np.testing.assert_allclose(second.points, 5 * [[-1, 3]], atol=1e-12)
    assert isinstance(first, Trajectory)
    assert trajectories([], np.zeros((0, 3))) == ()


def test_what_stays_in_a_disc_for_too_long_is_static_also_for_a_robot_that_drives():
    """One stays, one walks slowly, one sways inside the disc, one steps out of it at 4 s."""
    stays = Stays.none()
    for k in range(101):
        t = 0.1 * k
        pose = np.array([0.3 * t, 0.1 * t, 0.5 * t])
        places = [(4, 0), (0.2 * t, 5), (4 + 0.3 * np.sin(5 * t), 3), (0, -3 - 0.5 * (t > 4))]
        stays, static = watch(stays, at(t, pose, [0, 1, 2, 3], *places), pose, RULES)
        late = t > 5.05
        if abs(t - 5) > 0.06 and abs(t - 9.1) > 0.06:
            assert static.tolist() == [late, False, late, t > 9.1]
    np.testing.assert_allclose(stays.place[0], [4, 0], atol=1e-12)
    assert stays.since[0] == 0


def test_who_has_gone_is_forgotten_and_who_comes_begins_anew():
    pose = np.zeros(3)
    stays, _ = watch(Stays.none(), at(0.0, pose, [1, 4], (1, 1), (2, 2)), pose, RULES)
    stays, _ = watch(stays, at(3.0, pose, [4, 7], (2, 2), (1, 1)), pose, RULES)
    assert stays.identity.tolist() == [4, 7]
    assert stays.since.tolist() == [0.0, 3.0]
    stays, static = watch(stays, Hypotheses.none(), pose, RULES)
    assert stays.identity.size == static.size == 0


BAD = [
    (lambda: trajectories([known((1, 0))], np.zeros((2, 3))), "poses must be"),
    (lambda: StaticRules(spread=0.0), "spread must be positive"),
    (lambda: StaticRules(longest=-1.0), "longest must be positive"),
    (lambda: Stays(np.array([2, 1]), np.zeros((2, 2)), np.zeros(2)), "identity must rise"),
    (lambda: watch(Stays.none(), known((1, 0)), np.zeros(2), RULES), "pose must be"),
]


@pytest.mark.parametrize(("wrong", "message"), BAD)
def test_bad_input_is_named(wrong, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        wrong()
