"""A robot on a rail that measures its distance to a few posts.

Written with positions and noises only: no matrix, no filter, nothing shared with the library.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from data_synth._checks import deviations, generator, instance, number, reals, whole

Shape = Literal["sine", "there and back", "straight", "at rest"]
"""Kind of motion that the robot is told."""


def planned_path(shape: Shape, steps: int, *, start: float, reach: float) -> np.ndarray:
    """Return the positions that the robot is told to visit.

    Parameters
    ----------
    shape
        ``"sine"`` swings to both sides of the start and returns; ``"there and back"`` goes out and
        returns on one side; ``"straight"`` goes out and stays out; ``"at rest"`` stands still.
    steps
        Number of moves, at least 1.
    start
        First position, m.
    reach
        Greatest distance from the start, m.

    Returns
    -------
    (steps + 1,)

    Raises
    ------
    ValueError
        If the shape is unknown or there is no move.
    """
    whole("steps", steps, 1, 10**7)
    number("start", start)
    number("reach", reach)
    time = np.linspace(0.0, 1.0, steps + 1)
    offsets = {
        "sine": np.sin(2 * np.pi * time),
        "there and back": (1 - np.cos(2 * np.pi * time)) / 2,
        "straight": time,
        "at rest": 0 * time,
    }
    if not isinstance(shape, str) or shape not in offsets:
        raise ValueError(f"shape must be one of {', '.join(get_args(Shape))}, got {shape!r}")
    return start + reach * offsets[shape]


@dataclass(frozen=True, eq=False, slots=True)
class RailRuns:
    """Truth and measurements of each run.

    Parameters
    ----------
    positions : (runs, steps + 1)
        True positions, m.
    landmarks : (n,)
        True positions of the posts, m.
    commands : (steps,)
        Displacements that the robot was told to make, m.
    measurements : (runs, steps + 1, n)
        Measured distances to the posts, positive ahead, m.
    motion_deviation : (steps,)
        Standard deviation of each displacement, m.
    measurement_deviation : (steps + 1, n)
        Standard deviation of each measurement, m.
    """

    positions: np.ndarray
    landmarks: np.ndarray
    commands: np.ndarray
    measurements: np.ndarray
    motion_deviation: np.ndarray
    measurement_deviation: np.ndarray

    @property
    def measurement_errors(self) -> np.ndarray:
        """Measured minus true distances, (runs, steps + 1, n), m."""
        return self.measurements - (self.landmarks - self.positions[:, :, None])


def simulate_rail(
    plan: np.ndarray,
    landmarks: np.ndarray,
    runs: int,
    *,
    start_deviation: float,
    motion_deviation: np.ndarray | float,
    measurement_deviation: np.ndarray | float,
    rng: np.random.Generator,
) -> RailRuns:
    """Drive the robot along a plan, many times.

    Each run has its own generator, so a run is the same however many are made.

    Parameters
    ----------
    plan : (steps + 1,)
        Positions that the robot is told to visit, m. It believes that it starts at the first.
    landmarks : (n,)
        Positions of the posts, m.
    runs
        Number of runs, at least 1.
    start_deviation
        Standard deviation of the true start about the first planned position, m.
    motion_deviation : number or (steps,)
        Standard deviation of each displacement, m.
    measurement_deviation : number or (steps + 1, n)
        Standard deviation of each measured distance, m.
    rng
        Generator from which each run's own is spawned.

    Raises
    ------
    ValueError
        If there is no run, move or post, or a deviation is negative.
    """
    plan, landmarks = reals("plan", plan), reals("landmarks", landmarks)
    whole("runs", runs, 0, 10**7)
    generator(rng)
    if plan.ndim != 1 or plan.size < 2:
        raise ValueError(f"plan must be (steps + 1,) with a step at least, got {plan.shape}")
    if landmarks.ndim != 1 or landmarks.size < 1 or runs < 1:
        raise ValueError(
            f"runs and landmarks: need a run and a landmark, got {runs} and {landmarks.shape}"
        )
    for name, value in (("plan", plan), ("landmarks", landmarks)):
        if not np.isfinite(value).all():
            raise ValueError(f"{name} must be finite, got {value}")
    steps, n = plan.size - 1, landmarks.size
    start_deviation = deviations("start_deviation", start_deviation, ())
    slip = deviations("motion_deviation", motion_deviation, (steps,))
    blur = deviations("measurement_deviation", measurement_deviation, (steps + 1, n))
    noise = np.stack([g.standard_normal(1 + steps + (steps + 1) * n) for g in rng.spawn(runs)])
    begin = plan[0] + start_deviation * noise[:, :1]
    moves = np.diff(plan) + slip * noise[:, 1 : steps + 1]
    positions = np.cumsum(np.hstack([begin, moves]), axis=1)
    errors = blur * noise[:, steps + 1 :].reshape(runs, steps + 1, n)
    measurements = (landmarks[None, None, :] - positions[:, :, None]) + errors
    return RailRuns(positions, landmarks, np.diff(plan), measurements, slip, blur)


def measure_anchor(
    runs: RailRuns, position: float, deviation: np.ndarray | float, *, rng: np.random.Generator
) -> np.ndarray:
    """Let the robot measure its distance to one more post after each move.

    Parameters
    ----------
    runs
        What happened.
    position
        Where the post stands, m.
    deviation : number or (steps,)
        Standard deviation of each measurement, m.
    rng
        Generator from which each run's own is spawned.

    Returns
    -------
    (runs, steps)
        Distances, positive ahead, m.

    Raises
    ------
    ValueError
        If a deviation is negative or not finite.
    """
    instance("runs", runs, RailRuns)
    number("position", position)
    return position - runs.positions[:, 1:] + _reference_noise(runs, deviation, rng)


def watch_vehicle(
    runs: RailRuns, position: float, deviation: np.ndarray | float, *, rng: np.random.Generator
) -> np.ndarray:
    """Let a camera beside the rail measure where the robot is after each move.

    Parameters, returns and errors are those of :func:`measure_anchor`; ``position`` is that of the
    camera, and the same generator makes the same errors.
    """
    instance("runs", runs, RailRuns)
    number("position", position)
    return runs.positions[:, 1:] - position + _reference_noise(runs, deviation, rng)


def _reference_noise(
    runs: RailRuns, deviation: np.ndarray | float, rng: np.random.Generator
) -> np.ndarray:
    count, steps = len(runs.positions), runs.commands.size
    deviation = deviations("deviation", deviation, (steps,))
    generator(rng)
    return deviation * np.stack([g.standard_normal(steps) for g in rng.spawn(count)])
