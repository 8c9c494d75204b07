"""One loop for all sensors: wheels, tasks, and the place at which somebody points."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest

from robot_perception.arms.body_model import BodyModel
from robot_perception.beliefs import Gaussian
from robot_perception.cameras import Pinhole
from robot_perception.ceiling.mapping import MapRules
from robot_perception.companion.robot import CompanionRobot
from robot_perception.day import robot as day
from robot_perception.day.memory import Memory
from robot_perception.day.robot import DayInfo, DayState, Reading, clear_of, pointed_at
from robot_perception.fusion import covariance_intersection
from robot_perception.geometry import se2
from robot_perception.slam.planar.motions import Odometry, dead_reckoning
from robot_perception.walls.wall_map import WallMap
from tests.day.machine import machine

STEP = Odometry(np.array([0.1, 0.01, 0.05]), np.diag([1e-4, 1e-5, 1e-5]))


@pytest.fixture(scope="module")
def robot():
    return machine()


def rng():
    return np.random.default_rng(0)


def test_wheels_alone_reckon_as_the_library_does(robot):
    state = robot.start()
    for k in range(20):
        state, info = robot.step(state, Reading(k * 0.1, "wheels", STEP), rng=rng())
        assert info.command == (0.0, 0.0)
    expected = dead_reckoning(np.zeros(3), [STEP] * 20)[-1]
    np.testing.assert_allclose(state.pose.mean, expected, atol=1e-12)
    np.testing.assert_allclose(state.moved.increment, expected, atol=1e-12)
    assert np.linalg.eigvalsh(state.pose.cov).min() > 0


def test_two_motions_as_one_have_the_noise_of_both():
    """Against 20 000 draws of both; a doubt in the first heading is one of the second place."""
    first = Odometry(np.array([0.5, 0.1, 0.8]), np.diag([1e-4, 2e-4, 4e-4]))
    then = Odometry(np.array([1.0, 0.0, -0.3]), np.diag([3e-4, 1e-4, 2e-4]))
    source, both = rng(), day._chained(first, then)
    draws = [source.multivariate_normal(one.increment, one.noise, 20_000) for one in (first, then)]
    np.testing.assert_allclose(both.increment, se2.compose(first.increment, then.increment))
    np.testing.assert_allclose(both.noise, np.cov(se2.compose(*draws).T), atol=3e-5)


def test_a_reading_that_is_older_is_refused_and_one_that_is_not_asked_for_passes(robot):
    state = replace(robot.start(), task="wait", time=5.0, command=(0.1, 0.0))
    with pytest.raises(ValueError, match=r"reading must not be older than 5\.0 s, got 4\.0"):
        robot.step(state, Reading(4.0, "laser", np.ones(181)), rng=rng())
    after, info = robot.step(state, Reading(6.0, "laser", np.ones(181)), rng=rng())
    assert after.time == 6.0
    assert after.task == "wait"
    assert info.command == (0.1, 0.0)
    with pytest.raises(ValueError, match="sensor must be one of"):
        Reading(0.0, "nose", 1)


def test_it_turns_until_it_looks_there_and_then_waits_for_the_tutor(robot):
    state = replace(robot.start(), task="turn", heading=0.0, then="attend",
                    pose=Gaussian(np.array([1.0, 2.0, 2.0]), 1e-4 * np.eye(3)))  # fmt: skip
    for k in range(100):
        turn = Odometry(np.array([0.0, 0.0, 0.1 * state.command[1]]), 1e-9 * np.eye(3))
        state, _ = robot.step(state, Reading(k * 0.1, "wheels", turn), rng=rng())
        if state.task != "turn":
            break
        assert state.command[1] < 0  # the shorter way
    assert state.task == "attend"
    assert abs(state.pose.mean[2]) < np.deg2rad(4.0)
    assert state.companion.name == "wait"


def test_poses_by_two_systems_are_joined_by_intersection_or_not_at_all(robot):
    a = Gaussian(np.array([1.0, 2.0, 3.1]), np.diag([0.2, 0.3, 0.1]))
    b = Gaussian(np.array([1.1, 2.2, -3.1]), np.diag([0.01, 0.02, 0.01]))
    omega = np.linalg.det(a.cov) / (np.linalg.det(a.cov) + np.linalg.det(b.cov))
    both = covariance_intersection(a, b, omega, angles=(2,))
    np.testing.assert_allclose(robot._joined(a, b).mean, both.mean)
    alone = replace(robot, without=frozenset({"intersection"}))
    assert alone._joined(a, b) is b


def test_a_system_that_there_is_not_cannot_be_left_out(robot):
    with pytest.raises(ValueError, match="without must be one of 'stereo'"):
        replace(robot, without=frozenset({"smell"}))


def test_it_is_not_switched_on_before_it_has_learned(robot):
    with pytest.raises(ValueError, match="state must have a memory"):
        robot.carried(DayState(), rng=rng())


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.0])
@pytest.mark.parametrize("door", ["left", "right", "near"])
def test_the_place_is_that_in_the_direction_of_the_arm(heading, door):
    """An arm that hangs down tells nothing; the other one points from the shoulder."""
    pose = np.array([2.0, 1.0, heading])
    places = {"left": np.array([3.0, 2.5]), "right": np.array([2.5, -3.0]),
              "near": np.array([0.2, 0.3])}  # fmt: skip
    there = {name: se2.act(pose, at[None])[0] for name, at in places.items()}
    shoulders = np.array([[-0.2, -0.1, 2.0], [0.2, -0.1, 2.0]])  # right, down, ahead
    joints = np.repeat(shoulders[:, None], 4, axis=1)
    joints[0, :, 1] += [0, 0.3, 0.5, 0.6]
    ahead, left = places[door]
    way = np.array([-left, 0.3, ahead]) - shoulders[1]
    joints[1] += np.array([0, 0.3, 0.5, 0.6])[:, None] * way / np.linalg.norm(way)
    assert pointed_at(joints, pose, there) == door
    with pytest.raises(ValueError, match="places must be one at least"):
        pointed_at(joints, pose, {})


def test_joints_of_the_arms_model_are_what_it_takes():
    camera = Pinhole((386.0, 386.0), (159.5, 119.5), (320, 240))
    model = BodyModel.from_face(np.array([140.0, 60.0, 32.0, 32.0]), camera)
    pose = np.array([1.6, 0.1, 0.6, 0.06, 0.24, 0.05, 1.2, 0.25])  # one arm goes sideways
    joints = model.joints(pose[None])[0]
    outwards = np.sign(joints[0, 2, 0] - joints[0, 0, 0])
    places = {"this side": np.array([2.0, -3.0 * outwards]), "that": np.array([2.0, 3 * outwards])}
    assert pointed_at(joints, np.zeros(3), places) == "this side"


BACK = np.array([[0.1 * x, 0.0, 0.0] for x in range(41)]
                + [[0.1 * x, 0.4, np.pi] for x in range(40, -1, -1)])  # fmt: skip
SEEN = tuple({"a": np.array([100.0 + 0.5 * k, 80.0, 0.0, 1.0])} for k in range(82))


def knowing(robot, sightings=SEEN):
    """Return what a robot knows that was led along a corridor and back, past two doors."""
    places = {"door 1": np.array([0.5, 1.0]), "hall": np.array([4.0, 0.2]),
              "post": np.array([0.3, 0.4])}  # fmt: skip
    nothing = SimpleNamespace()
    kept = Memory(nothing, WallMap.empty(), BACK, sightings, {}, nothing, np.zeros(3), places)
    return replace(robot.start(), memory=kept, task="wait")


@pytest.fixture
def no_view(monkeypatch):
    """Navigators without a ceiling: their route is all that is asked."""
    monkeypatch.setattr(
        day, "Navigator", lambda route, *rest, **words: SimpleNamespace(route=route)
    )


def test_who_is_put_somewhere_knows_where_it_is_and_what_to_do(robot, no_view):
    state = replace(knowing(robot), pictures=9, halted=4, scan=np.ones(181))
    for task in ("guide", "attend", "watch"):
        after, _ = robot.put(state, task, np.array([1.0, 0.1, 0.2]), "hall")
        assert after.task == task
        np.testing.assert_array_equal(after.pose.mean, [1.0, 0.1, 0.2])
        assert (after.pictures, after.halted, after.scan) == (0, 0, None)
        assert after.memory is state.memory
    guiding, _ = robot.put(state, "guide", np.array([3.9, 0.3, 2.0]), "hall")
    assert guiding.end in (39, 40, 41, 42)
    assert robot.route(guiding)[-1] == pytest.approx([0.3, 0.4], abs=0.1)
    with pytest.raises(ValueError, match="task must be one of 'ceiling', 'guide'"):
        robot.put(state, "learn", np.zeros(3))
    with pytest.raises(ValueError, match="state must have a memory"):
        robot.put(robot.start(), "watch", np.zeros(3))


def test_the_shorter_way_is_taken_and_first_it_turns_into_it(robot, no_view):
    """From 1.5 m the door at 0.5 m is behind: the way back passes it sooner."""
    state, info = robot.put(knowing(robot), "ceiling", np.array([1.5, 0.2, 0.1]), "door 1")
    assert (state.task, state.then, info.say) == ("turn", "ceiling", "to door 1")
    assert state.heading == np.pi
    assert BACK[state.end] == pytest.approx([0.5, 0.4, np.pi])
    for k in range(100):
        turn = Odometry(np.array([0.0, 0.0, 0.1 * state.command[1]]), 1e-9 * np.eye(3))
        state, _ = robot.step(state, Reading(k * 0.1, "wheels", turn), rng=rng())
        if state.task != "turn":
            break
    assert state.task == "ceiling"
    ahead, _ = robot.put(knowing(robot), "return", np.array([0.1, 0.0, 0.1]), "door 1")
    assert (ahead.task, ahead.end) == ("return", 5)


def test_one_pattern_leads_where_the_ceiling_is_bare_and_the_wheels_where_it_shows_none(
    robot, no_view
):
    there = np.array([0.1, 0.0, 0.1])
    state, _ = robot.put(knowing(robot), "return", there, "door 1")
    assert len(state.navigator.route) >= 2  # though two patterns are wanted
    other = tuple({("a" if k % 82 < 3 else "b"): one["a"]} for k, one in enumerate(SEEN))
    state, info = robot.put(knowing(robot, other), "return", there, "door 1")
    assert (state.task, info.say, state.navigator) == ("return", "to door 1", None)
    state, info = robot.step(state, LOOK, rng=rng())
    assert info.command[0] > 0.1
    there = replace(state, pose=Gaussian(BACK[5], state.pose.cov), navigator=None)
    end, info = robot.step(there, LOOK, rng=rng())
    assert (end.task, info.say) == ("wait", "here")


LOOK = Reading(0.1, "overhead", np.zeros((4, 4), np.uint8))


@dataclass(frozen=True)
class View:
    """What looks at the ceiling: it notes how it is asked, and says what it is told to say."""

    says: SimpleNamespace
    rules: MapRules = field(default_factory=MapRules)
    asked: list = field(default_factory=list)

    def step(self, replay, image, *, rng):
        self.asked.append((self.rules.search, replay.pose))
        seen = SimpleNamespace(key=1, pose=np.array([1.0, 0.5, np.pi]))
        return seen, self.says


def test_the_ceiling_corrects_the_pose_of_a_guide(robot, monkeypatch):
    """The picture says that it is half a metre from where the wheels say; they meet between."""
    view = View(SimpleNamespace(sightings={"a": 1}, status="driving"))
    monkeypatch.setattr(day, "Navigator", lambda *rest, **words: view)
    state, _ = robot.put(knowing(robot), "guide", np.array([1.0, 0.0, np.pi]), "hall")
    wide = replace(state, pose=Gaussian(state.pose.mean, np.diag([0.3, 0.3, 0.1]) ** 2))
    after, _ = robot.step(wide, LOOK, rng=rng())
    assert 0.4 < after.pose.mean[1] < 0.5
    blind = replace(robot, without=frozenset({"ceiling"}))
    assert blind.step(wide, LOOK, rng=rng())[0].pose is wide.pose


def test_patterns_are_looked_for_where_the_pose_says_they_are_first_in_a_wide_circle(
    robot, monkeypatch
):
    view = View(SimpleNamespace(sightings={"a": 1}, status="driving", command=(0.2, 0.1)))
    monkeypatch.setattr(day, "Navigator", lambda *rest, **words: view)
    there = np.array([0.1, 0.0, 0.1])
    state, _ = robot.put(knowing(robot), "return", there, "door 1")
    state, info = robot.step(state, LOOK, rng=rng())
    assert info.command == (0.2, 0.1)
    (wide, pose), (usual, seen) = view.asked
    np.testing.assert_allclose(se2.compose(state.memory.onto, pose), there, atol=1e-12)
    assert wide * robot.mapper.scale == pytest.approx(1.25)
    assert usual == MapRules().search
    assert seen is not pose
    robot.step(state, LOOK, rng=rng())
    assert len(view.asked) == 3  # it has begun


def test_where_the_ceiling_is_lost_it_goes_on_by_the_wheels_and_looks_farther_on(
    robot, monkeypatch
):
    lost, routes = View(SimpleNamespace(sightings={}, status="lost", command=(0.0, 0.0))), []

    def navigator(route, *rest, **words):
        routes.append(route)
        return lost

    monkeypatch.setattr(day, "Navigator", navigator)
    state, _ = robot.put(knowing(robot), "return", np.array([1.5, 0.0, 0.1]), "hall")
    after, info = robot.step(state, LOOK, rng=rng())
    assert (after.task, after.replay) == ("return", None)
    assert info.command[0] > 0.1
    assert len(routes) == 2
    replace(robot, ahead=0).step(state, LOOK, rng=rng())
    farther, here = (route[0].sightings["a"][0] for route in routes[1:])
    assert farther - here == pytest.approx(5.0)  # ten pictures, half a pixel each


def test_it_looks_at_arms_a_second_after_it_has_stopped_though_the_hand_is_down(robot):
    names = iter(["follow", "halt", *["idle"] * 20])

    def step(self, state, image, *, rng):
        return SimpleNamespace(name=next(names)), SimpleNamespace(command=(0.0, 0.0))

    state = replace(knowing(robot), task="attend", companion=SimpleNamespace(name="follow"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(CompanionRobot, "step", step)
        for k in range(11):
            assert state.task == "attend", k
            state, _ = robot.step(state, Reading(k, "ahead", np.zeros((4, 4, 3), np.uint8)),
                                  rng=rng())  # fmt: skip
    assert state.task == "watch"


def test_nothing_is_said_where_nothing_is_to_be_said():
    assert DayInfo().say == ""
    assert DayState().task == "learn"


BEAMS = np.deg2rad(np.arange(-90.0, 91.0))


def scan(x, y):
    """Return a scan of a post at a place, and of nothing else."""
    found = np.full(len(BEAMS), np.inf)
    found[np.abs(BEAMS - np.arctan2(y, x)).argmin()] = np.hypot(x, y)
    return found


def test_it_turns_away_from_what_stands_in_its_way_the_nearer_the_more():
    free = (0.4, 0.1)
    assert clear_of(free, scan(0.5, 0.6), BEAMS) == free  # beside
    assert clear_of(free, scan(1.2, 0.1), BEAMS) == free  # far
    assert clear_of((0.0, 0.1), scan(0.3, 0.1), BEAMS) == (0.0, 0.1)  # it stands
    near, nearer = (clear_of(free, scan(x, 0.2), BEAMS) for x in (0.6, 0.3))
    assert near[0] == nearer[0] == 0.2
    assert nearer[1] < near[1] < 0.1  # to the right of what is on the left
    right = clear_of((0.4, 0.0), scan(0.5, -0.2), BEAMS)
    left = clear_of((0.4, 0.0), scan(0.5, 0.2), BEAMS)
    assert right[1] == pytest.approx(-left[1], abs=1e-12)
    assert right[1] > 0
