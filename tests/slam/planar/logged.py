"""A robot of the form of the recordings, whose wheels and camera err by a known process."""

import numpy as np

from robot_perception.datasets.mrclam import (
    Commands,
    MrclamRobot,
    Sightings,
    SurveyedLandmarks,
    Track,
)
from robot_perception.geometry import wrap_angle

LANDMARKS = SurveyedLandmarks(
    np.array([6, 7, 8, 9]),
    np.array([[4.0, 0], [0, 4], [-4, 0], [0, -4.0]]),
    np.full((4, 2), 1e-4),
)
DELAY, SCALE, DRAG = 0.2, np.array([0.9, 0.95]), 0.05
BIAS, SIGMA = np.array([0.05, -0.01]), (0.1, 0.02)


def make_robot(rng, *, seconds=400.0, persistence=0.0, bias=BIAS, wander=(0.0, 0.0)):
    """Drive a robot whose wheels are late and slow, and whose camera errs by a known process."""
    dt = 0.05
    times = 1000 + np.arange(0, seconds, dt)
    switches = rng.integers(0, 2, size=(len(times) // 40 + 1, 2))
    velocities = np.repeat(switches, 40, axis=0)[: len(times)] * [0.12, 0.8] + [0.03, -0.4]
    late = np.vstack([np.zeros((round(DELAY / dt), 2)), velocities])[: len(times)]
    true = late * SCALE
    true[:, 0] -= DRAG * np.abs(late[:, 1])
    moved = true * dt + rng.normal(size=late.shape) * np.array(wander) * np.sqrt(dt)
    pose, poses = np.zeros(3), [np.zeros(3)]
    for step in moved[:-1]:
        middle = pose[2] + step[1] / 2
        pose = pose + np.array([step[0] * np.cos(middle), step[0] * np.sin(middle), step[1]])
        poses.append(pose)
    poses = np.array(poses)
    images = np.arange(10, len(times), 8)  # one in 0.4 s
    factor = np.exp(-0.4 / (-2 / np.log(persistence))) if persistence else 0.0
    errors = np.zeros((len(images), 4, 2))
    fresh = rng.normal(size=errors.shape) * SIGMA
    errors[0] = fresh[0]
    for k in range(1, len(images)):
        errors[k] = factor * errors[k - 1] + np.sqrt(1 - factor**2) * fresh[k]
    x, y = np.moveaxis(LANDMARKS.positions - poses[images, None, :2], -1, 0)
    expected = np.stack([np.hypot(x, y), np.arctan2(y, x) - poses[images, None, 2]], axis=-1)
    values = expected + errors + bias
    values[..., 1] = wrap_angle(values[..., 1])
    seen = Sightings(
        np.repeat(times[images], 4), np.tile(LANDMARKS.ids, len(images)), values.reshape(-1, 2)
    )
    nobody = Sightings(np.empty(0), np.empty(0, dtype=int), np.empty((0, 2)))
    poses[:, 2] = wrap_angle(poses[:, 2])
    return MrclamRobot(Commands(times, velocities), seen, nobody, {}, Track(times, poses))
