"""A real corridor: a straight stretch of the Intel Research Lab log as a monobot."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from scipy import stats

from robot_perception import datasets
from robot_perception.beliefs import Gaussian
from robot_perception.slam.monobot import MonobotRun, run_filter
from studies.stored.recordings import Recording

LOG = "intel_odom_and_corrected.log.gz"
SCANS = slice(72, 88)
"""A straight stretch that ends in front of a wall; our choice."""
START, MOTION, MEASUREMENT = 0.1, 0.05, 0.03
"""Deviations that we assume for it, m; odometry per step from the log's description."""


@dataclass(frozen=True, eq=False, slots=True)
class Corridor:
    """Moves by the wheels alone, distances to the end wall, and the way by corrected poses, m."""

    commands: Float[np.ndarray, "steps"]
    measurements: Float[np.ndarray, "measurements"]
    track: Float[np.ndarray, "measurements"]


def corridor(folder: Path) -> Corridor:
    """Return the stretch from the folder of the data set ``carmen_intel``.

    The beam that points along the corridor is picked with the heading of the corrected log, since a
    monobot has no heading.
    """
    log = datasets.read_carmen_log(folder / LOG)
    poses, wheels = log.poses[SCANS], log.odometry[SCANS]
    way = poses[-1, :2] - poses[0, :2]
    direction = np.arctan2(way[1], way[0])
    measurements = []
    for pose, ranges in zip(poses, log.ranges[SCANS], strict=True):
        turn = np.angle(np.exp(1j * (log.angles - direction + pose[2])))
        nearest = np.argsort(np.abs(turn))[:3]
        measurements.append(np.median(ranges[nearest]))
    along = (poses[:, :2] - poses[0, :2]) @ way / np.linalg.norm(way)
    commands = np.linalg.norm(np.diff(wheels[:, :2], axis=0), axis=1)
    return Corridor(commands, np.array(measurements), along)


CORRIDOR = Recording("carmen_intel", corridor, Corridor, store="monobot-corridor")


def filter_corridor(stretch: Corridor, *, origin: float) -> MonobotRun:
    """Filter the corridor, with the end wall as the one landmark, from a start at ``origin``, m."""
    return run_filter(
        Gaussian(np.array([origin]), np.array([[START**2]])),
        stretch.commands,
        stretch.measurements[None, :, None],
        motion_variance=MOTION**2,
        measurement_variance=MEASUREMENT**2,
    )


def compared(here: MonobotRun, there: MonobotRun) -> dict[str, float]:
    """Return how two maps of the corridor differ, and how the innovations of the first judge it.

    ``shift`` is the mean of the difference, m; ``wall`` and ``start`` are two deviations of the
    wall at the end and of the robot at the start, cm; ``share`` is the mean normalised squared
    innovation of ``count``, and ``percentile`` how often, in %, chance makes it as small.
    """
    squares = here.innovations[0, :, 0] ** 2 / here.innovation_covs[0, :, 0, 0]
    return {
        "shift": float((there.means - here.means).mean()),
        "wall": float(200 * here.deviations[0, -1, 1]),
        "start": float(200 * here.deviations[0, 0, 0]),
        "share": float(squares.mean()),
        "count": squares.size,
        "percentile": float(100 * stats.chi2.cdf(squares.sum(), squares.size)),
    }
