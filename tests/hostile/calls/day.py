"""Valid calls of `day`."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from robot_perception.ceiling.visual_memory import KeyRules
from robot_perception.day import memory, robot
from robot_perception.slam.planar.motions import Odometry
from robot_perception.walls.wall_map import WallMap
from tests.day.machine import learner, led
from tests.hostile.sweep import call

ROBOT = learner()
WAY = np.column_stack([np.linspace(0, 2, 21), np.zeros(21), np.zeros(21)])
SEEN = tuple({"a": np.array([100.0 + k, 80, 0, 1])} for k in range(21))
NOTHING = SimpleNamespace()
PLACES = {"door": np.array([1.0, 0.5])}
KEPT = memory.Memory(NOTHING, WallMap.empty(), WAY, SEEN, {}, NOTHING, np.zeros(3), PLACES)
STEP = Odometry(np.array([0.1, 0.0, 0.0]), 1e-4 * np.eye(3))
STATE = led(ROBOT)
LEARNED, _ = ROBOT.step(
    STATE, robot.Reading(1.0, "teacher", "switch off"), rng=np.random.default_rng(0)
)
AT_HOME = replace(LEARNED, memory=KEPT)


def rng():
    return np.random.default_rng(4)


CALLS = {
    memory.Memory.nearest: lambda: call(KEPT, np.array([1.0, 0.1, 0.1]), 0.5),
    memory.Memory.passes: lambda: call(KEPT, "door", 1.5),
    memory.Memory.route: lambda: call(KEPT, 2, 12, KeyRules(common=1)),
    memory.remember: lambda: call(STATE.lesson, STATE.maps, STATE.above, STATE.walls),
    robot.Reading: lambda: call(1.0, "laser", np.ones(181)),
    robot.DayRobot: lambda: call(
        ROBOT.cameras, ROBOT.mount, ROBOT.angles, ROBOT.ring, ROBOT.radius, ROBOT.mapper,
        ROBOT.guide, ROBOT.skin, ROBOT.companion, ROBOT.arms, ROBOT.slam, ROBOT.localiser,
        ROBOT.keys, ROBOT.servo, {"ceiling": "hall", "guide": "post"}, 3, 40, 10,
        frozenset({"arms"}),
    ),
    robot.DayRobot.start: lambda: call(ROBOT),
    robot.DayRobot.step: lambda: call(
        ROBOT, STATE, robot.Reading(1.0, "wheels", STEP), rng=rng()
    ),
    robot.DayRobot.carried: lambda: call(ROBOT, LEARNED, rng=rng()),
    robot.DayRobot.put: lambda: call(ROBOT, AT_HOME, "return", np.array([1.0, 0.1, 0.1]), "door"),
    robot.DayRobot.route: lambda: call(ROBOT, replace(LEARNED, end=0)),
}  # fmt: skip
INNER = {robot.clear_of, robot.pointed_at}
"""Functions that the robot calls at each step, with what it has made or checked."""
