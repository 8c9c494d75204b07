"""A robot for tests: every part there is, and small; and what it has learned in two pictures."""

import cv2
import numpy as np

from data_synth.ceiling import CeilingCamera, Mount, make_ceiling
from robot_perception.arms.tracker import ArmTracker
from robot_perception.cameras import Pinhole, StereoRig
from robot_perception.ceiling.mapping import Mapper
from robot_perception.chapters.tutor_following.scene import hands
from robot_perception.companion.robot import CompanionRobot
from robot_perception.day.robot import DayRobot, DayState, Reading
from robot_perception.people.robot import ServiceRobot
from robot_perception.people.skin import SkinModel, SkinTracker
from robot_perception.slam.planar.motions import Odometry
from robot_perception.slam.visual import Options, VisualSlam

MOUNT = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0.8], [0, 0, 0, 1]])


def machine(**others) -> DayRobot:
    """Return a robot with cameras of 320 × 240 px and a laser of 181 beams."""
    camera = Pinhole((386.0, 386.0), (159.5, 119.5), (320, 240))
    skin = SkinTracker((31.5, 31.5), 18.0, (64, 64), SkinModel(np.zeros((4, 4))))
    parts = {
        "cameras": StereoRig(camera, 0.12),
        "mount": MOUNT,
        "angles": np.deg2rad(np.arange(-90.0, 91.0)),
        "ring": np.linspace(-np.pi, np.pi, 16, endpoint=False),
        "radius": 0.25,
        "mapper": Mapper(0.0125, (159.5, 119.5)),
        "guide": ServiceRobot("guide"),
        "skin": skin,
        "companion": CompanionRobot(lambda grey, box: None, hands()),
        "arms": ArmTracker(camera),
    }
    return DayRobot(**parts | others)


def led(robot: DayRobot) -> DayState:
    """Return what a robot knows before it is switched off that was led for a few centimetres."""
    rng = np.random.default_rng(1)
    noise = cv2.GaussianBlur(rng.standard_normal((240, 330)), (0, 0), 2.0)
    grey = np.rint(128 + 60 * noise / noise.std()).clip(0, 255).astype(np.uint8)
    pair = np.ascontiguousarray(grey[:, :320]), np.ascontiguousarray(grey[:, 10:])
    above = CeilingCamera(make_ceiling("varied", rng=rng, side=6.0), Mount())
    state = robot.start()
    for k in range(2):
        step = Odometry(np.array([0.05, 0.0, 0.0]), 1e-6 * np.eye(3))
        for sensor, value in (
            ("wheels", step),
            ("pair", pair),
            ("overhead", above.image(np.array([0.05 * k, 0.0, 0.0]))),
            ("teacher", (f"door {k}", np.array([0.0, 1.0]))),
            ("teacher", ("post", np.zeros(2))),
        ):
            state, _ = robot.step(state, Reading(0.1 * k, sensor, value), rng=rng)
    return state


def learner() -> DayRobot:
    """Return a robot that makes landmarks of what it sees once."""
    return machine(slam=VisualSlam(MOUNT, Options(particles=2, stable=0)))
