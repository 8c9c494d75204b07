"""A robot among people: what it takes in is the tracker's, what it does the behaviour's."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.geometry import se2
from robot_perception.people.aggregation import AggregationRules, Hypotheses
from robot_perception.people.behaviours import MOVES, STOP, Behaviours, Command, State
from robot_perception.people.detections import Detections, polar
from robot_perception.people.robot import (
    TASKS,
    RobotState,
    ServiceRobot,
    upcoming,
    velocity,
)
from robot_perception.people.tracker import PeopleState, PeopleTracker
from robot_perception.people.trajectories import StaticRules, Stays
from tests.people.test_aggregation import known
from tests.unchecked import unchecked

POSE = np.array([2.0, 0.0, 0.0])
ROUTE = np.c_[np.arange(100) / 10, np.zeros(100)]


def seen(time, *places):
    """Return a reading of the laser with people at (r, φ)."""
    r, phi = np.reshape(places, (-1, 2)).T
    return Detections(time, "laser", polar(r, phi, 0.05, 0.02))


def knows(some: Hypotheses, *, static=None, behaviour=None, pose=POSE):
    """Return what a robot knows of some hypotheses."""
    still = np.zeros(len(some), dtype=bool) if static is None else np.array(static)
    return RobotState(PeopleState(some, Stays.none(), pose), still, behaviour or State(), pose)


@pytest.mark.parametrize("task", TASKS)
def test_a_reading_is_the_trackers_and_a_command_the_behaviours(task):
    """Somebody comes from 3.5 m to a metre, stands there for four seconds, and is gone."""
    walks = PeopleTracker(AggregationRules(walk=0.8), StaticRules(spread=0.3, longest=2.0))
    robot = ServiceRobot(task, tracker=walks)
    state, tracked, before = robot.start(POSE), walks.start(POSE), State()
    said = set()
    for k in range(150):
        pose, time = POSE + 0.005 * k, 0.1 * k
        there = [(max(3.5 - 0.05 * k, 1.0), 0.1)] if k < 90 else []
        state, info = robot.step(state, seen(time, *there), pose)
        tracked, same = walks.step(tracked, seen(time, *there), pose)
        assert np.array_equal(state.hypotheses.mean, tracked.hypotheses.mean)
        assert np.array_equal(info.static, same.static)
        assert np.array_equal(state.static, same.static)
        assert (state.pose == pose).all()
        persons = tracked.hypotheses.select(robot.roles(state) >= MOVES)
        more = {"survey": (k == 80,)}.get(task, ())
        before, wanted = getattr(robot.behaviours, task)(before, persons, *more)
        after = se2.compose(pose, np.array([0.01, 0.0, 0.0]))
        state, command = robot.act(state, after, finished=k == 80)
        assert (state.behaviour, command) == (before, wanted)
        assert (state.pose == after).all()
        said.add(command.say)
    asks = {"come nearer", "take part", "thank you"} if task == "survey" else {"come back"}
    assert said == {"", *asks}


def test_before_the_first_reading_it_stands_and_knows_nobody():
    robot = ServiceRobot("guide")
    state, command = robot.act(robot.start(POSE), POSE + 1, ROUTE)
    assert command == STOP
    assert state.behaviour == State()
    assert (state.pose == POSE + 1).all()
    assert state.partner is None


def test_furniture_is_nobody_to_ask_but_a_partner_may_stand():
    robot, one = ServiceRobot("survey", Behaviours(close=1.5)), known((2.0, 0.0), time=5.0)
    for static, person, say in (
        ([False], -1, "come nearer"), ([True], -1, ""), ([True], 0, ""),
    ):  # fmt: skip
        phase = "inviting" if person == 0 else "waiting"
        state, command = robot.act(
            knows(one, static=static, behaviour=State(phase, person, 4.9, 4.0)), POSE
        )
        assert command.say == say
        assert (state.behaviour.seen == 5.0) == (person == 0 or not static[0])


def test_who_counts_is_said_by_the_rules_and_by_how_well_the_distance_is_known():
    cov = np.tile(np.diag([0.1, 0.01]), (2, 1, 1))
    cov[1, 0, 0] = 1.5**2
    two = known((1.0, 0.0), (2.0, 0.0), cov=cov, weight=0.6)
    for least, deviation, count in ((0.5, 1.2, 1), (0.5, 2.0, 2), (0.7, 2.0, 0)):
        tracker = PeopleTracker(AggregationRules(person=least))
        found = ServiceRobot("guide", tracker=tracker, known=deviation).roles(knows(two))
        assert (found >= MOVES).sum() == count


@pytest.mark.parametrize("turn", [0.0, 2.0])
def test_a_partner_is_known_by_a_place_in_the_world(turn):
    pose = np.array([1.0, -2.0, turn])
    two = known((2.0, 0.5), (3.0, -1.0))
    state = knows(two, behaviour=State("busy", 1, 0.0, 0.0), pose=pose)
    assert state.partner == pytest.approx(
        [1.0 + 3 * np.cos(turn - 1.0), -2.0 + 3 * np.sin(turn - 1.0)]
    )
    assert knows(two, behaviour=State("busy", 7, 0.0, 0.0), pose=pose).partner is None


@pytest.mark.parametrize("static", [False, True])
@pytest.mark.parametrize(("ahead", "blocked"), [(1.3, True), (3.0, False), (-2.0, False)])
@pytest.mark.parametrize("led", [False, True])
def test_a_path_is_blocked_by_others_on_its_next_metre_and_a_half(ahead, blocked, led, static):
    robot = ServiceRobot("guide")
    some = known((abs(ahead), 0.0 if ahead > 0 else np.pi), time=3.0)
    behaviour = State("busy", 0 if led else 8, 2.9, 1.0)
    state = knows(some, static=[static], behaviour=behaviour)
    assert robot.is_blocked(state, ROUTE) == (blocked and not led)
    _, command = robot.act(state, POSE, ROUTE)
    assert (command.say == "clear the path") == (blocked and not led)
    _, command = robot.act(state, POSE)  # who has no route is not in anybody's way
    assert command.say != "clear the path"


def test_a_route_is_blocked_within_its_width_and_so_many_points_ahead():
    state = knows(known((2.0, 0.3)))  # 0.59 m to the left
    assert not ServiceRobot("guide", ahead=25).is_blocked(state, ROUTE)
    assert ServiceRobot("guide", width=1.3, ahead=25).is_blocked(state, ROUTE)
    assert not ServiceRobot("guide", width=1.3).is_blocked(state, ROUTE)
    for left in (1, 0):  # at its end nobody is in the way
        assert not ServiceRobot("guide", width=9.0).is_blocked(state, ROUTE[:left])


def test_what_is_left_of_a_route_begins_at_its_nearest_point():
    found = upcoming(ROUTE, np.array([3.26, 1.0, 0.3]))
    assert (found == ROUTE[33:]).all()
    assert len(upcoming(ROUTE[:0], POSE)) == 0


@pytest.mark.parametrize(("left", "turn"), [(0.0, 0.4), (0.8, 1.0), (-0.8, -1.0), (0.8, -1.0)])
def test_who_drives_by_the_velocities_gets_to_the_end_of_a_bent_route(left, turn):
    s = np.arange(0, 80) / 10
    route, pose = np.c_[s, np.sin(s / 2)], np.array([0.0, left, turn])
    for _ in range(400):
        speed, rate = velocity(Command(speed=0.5), pose, route)
        assert 0 <= speed <= 0.5
        assert abs(rate) <= 1.0
        pose = se2.compose(pose, np.array([0.1 * speed, 0.0, 0.1 * rate]))
        if np.hypot(*(route[-1] - pose[:2])) < 0.3:
            break
    else:
        pytest.fail(f"ends at {pose}")


def turned(by):
    """Return a pose on the route, turned to the left."""
    return np.array([1.0, 0.0, by])


def test_how_it_turns_to_a_point_ahead():
    at, go = turned(0.0), Command(speed=0.5, turn_rate=0.3)
    for off in (0.0, 0.2, -0.2, 0.5):  # the point is 0.6 m further on
        speed, rate = velocity(go, turned(off), ROUTE)
        assert speed == pytest.approx(0.5 * (1 - abs(off) / 0.6))
        assert rate == pytest.approx(-1.5 * off)
    assert velocity(go, turned(2.0), ROUTE) == (0.0, -1.0)
    assert velocity(go, at, ROUTE[:0]) == (0.5, 0.3)
    assert velocity(Command(turn_rate=0.3), at, ROUTE) == (0.0, 0.3)
    speed, rate = velocity(go, np.array([0.0, 0.5, 0.0]), ROUTE, ahead=5)
    assert rate == -1.0
    assert velocity(go, np.array([0.0, 0.5, 0.0]), ROUTE, ahead=5, gain=0.1)[1] == pytest.approx(
        -0.1 * np.pi / 4
    )
    assert speed == 0.0


def test_one_truth_value_for_each_hypothesis():
    with pytest.raises(ValueError, match="static must be 2, one for each of people, got 1"):
        knows(known((1, 0), (2, 0)), static=[True])
    state = knows(known((1, 0)))
    with unchecked():
        assert replace(state, pose=[0, 1, 2]).pose.dtype == float
