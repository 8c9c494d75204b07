"""Reports of a robot's wheels on its way: each step with an error of its own.

Errors grow like a random walk, with the root of the distance, so that the length of the steps does
not matter. Written with positions only: no matrix, no filter, nothing shared with the library.
"""

from dataclasses import dataclass

import numpy as np

from data_synth._checks import generator, instance, number, reals


@dataclass(frozen=True, slots=True)
class Slip:
    """Slip of the wheels; all values are ours.

    Parameters
    ----------
    along, across
        Deviation in the robot's own directions for each root of a metre driven, m.
    bend
        Deviation of the heading for each root of a metre driven, rad.
    turn
        Deviation of the heading for each root of a radian turned, rad.
    """

    along: float
    across: float
    bend: float
    turn: float

    def __post_init__(self) -> None:
        for name in ("along", "across", "bend", "turn"):
            number(name, getattr(self, name), 0.0)


SMALL = Slip(along=0.01, across=0.005, bend=np.deg2rad(0.5), turn=np.deg2rad(1.0))
LARGE = Slip(along=0.05, across=0.025, bend=np.deg2rad(3.0), turn=np.deg2rad(3.0))


@dataclass(frozen=True, eq=False, slots=True)
class Odometry:
    """Steps as the wheels report them.

    Parameters
    ----------
    increments : (steps, 3)
        Forward, leftward and turned, in the frame of the pose before the step, m and rad.
    deviations : (steps, 3)
        Standard deviations of their independent errors, m and rad.
    """

    increments: np.ndarray
    deviations: np.ndarray


def true_increments(poses: np.ndarray) -> np.ndarray:
    """Return the steps of a path (poses, 3) in the frame of the pose before each, m and rad."""
    poses = reals("poses", poses)
    if poses.ndim != 2 or poses.shape[1] != 3 or len(poses) < 2:
        raise ValueError(f"poses must be (steps + 1, 3) with a step at least, got {poses.shape}")
    if not np.isfinite(poses).all():
        raise ValueError(f"poses must be finite, {(~np.isfinite(poses)).sum()} entries are not")
    east, north = np.diff(poses[:, 0]), np.diff(poses[:, 1])
    cos, sin = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
    turn = (np.diff(poses[:, 2]) + np.pi) % (2 * np.pi) - np.pi
    return np.stack([cos * east + sin * north, cos * north - sin * east, turn], axis=-1)


def roll(poses: np.ndarray, slip: Slip, *, rng: np.random.Generator) -> Odometry:
    """Return what the wheels report of a path.

    Parameters
    ----------
    poses : (steps + 1, 3)
        The true path, m and rad.
    slip
        How wrong the wheels are.
    rng
        Source of noise.

    Raises
    ------
    ValueError
        If the path is not (steps + 1, 3), has no step or is not finite.
    """
    steps = true_increments(poses)
    instance("slip", slip, Slip)
    generator(rng)
    distance, turned = np.hypot(steps[:, 0], steps[:, 1]), np.abs(steps[:, 2])
    deviations = np.stack(
        [
            slip.along * np.sqrt(distance),
            slip.across * np.sqrt(distance),
            np.sqrt(slip.bend**2 * distance + slip.turn**2 * turned),
        ],
        axis=-1,
    )
    return Odometry(steps + deviations * rng.standard_normal(steps.shape), deviations)
