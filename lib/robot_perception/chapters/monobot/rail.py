"""The robot on the rail, its world and its filter: Figs 3 and 4.

Step 0 is the first measurement, which puts the landmarks into the map; every later step first
moves, then measures.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from data_synth.monobot import RailRuns, Shape, planned_path, simulate_rail
from robot_perception.beliefs import Gaussian
from robot_perception.evaluation import intervals
from robot_perception.evaluation.intervals import Interval, exact
from robot_perception.kalman import fisher_information
from robot_perception.slam.monobot import (
    MonobotRun,
    Reference,
    Settled,
    run_filter,
    run_referenced,
    sensor_matrix,
    settled,
)

PAPER = "perception-issues"
COUNTS = (1, 2, 5, 10, 20, 50)
"""Numbers of landmarks of Fig. 3; the caption says "various sizes", these are ours."""
GOLDEN = (1 + 5**0.5) / 2
DECIMALS = 12
"""What is recorded of numbers near zero: further ones are rounding and differ by processor."""


@dataclass(frozen=True, slots=True)
class Config:
    """One study of a monobot; noises are standard deviations.

    Parameters
    ----------
    runs, steps
        Independent runs, and moves in each; 100 moves stand in the caption of Fig. 4.
    landmarks, landmarks_at
        Number of landmarks, and where all of them stand, m; 1 m stands in the text of Fig. 4.
    start
        Where the robot believes that it starts, m; −1 m stands in the text of Fig. 4.
    shape, reach
        The commanded path. Fig. 4 says a sinusoid that returns; its reach, m, is ours.
    start_deviation
        Of the true start about the believed one, m; 1 in Fig. 3, ours in Fig. 4.
    motion_deviation, motion_share
        Of a move: constant part, m, and share of the commanded distance.
    measurement_deviation, measurement_share
        Of a measurement: constant part, m, and share of the planned distance.
    first_measurement_factor
        Factor on the deviation of the first measurement, which puts the landmarks into the map.
    """

    runs: int = 100
    steps: int = 100
    landmarks: int = 1
    landmarks_at: float = 1.0
    start: float = -1.0
    shape: Shape = "sine"
    reach: float = 1.0
    start_deviation: float = 1.0
    motion_deviation: float = 1.0
    motion_share: float = 0.0
    measurement_deviation: float = 1.0
    measurement_share: float = 0.0
    first_measurement_factor: float = 1.0

    @property
    def plan(self) -> Float[np.ndarray, "measurements"]:
        """Commanded positions, m."""
        return planned_path(self.shape, self.steps, start=self.start, reach=self.reach)

    @property
    def motion_deviations(self) -> Float[np.ndarray, "steps"]:
        """Standard deviation of each move, m."""
        return self.motion_deviation + self.motion_share * np.abs(np.diff(self.plan))

    @property
    def measurement_deviations(self) -> Float[np.ndarray, "measurements n"]:
        """Standard deviation of each measurement, m."""
        share = self.measurement_share * np.abs(self.landmarks_at - self.plan)
        deviation = self.measurement_deviation + share
        deviation[0] *= self.first_measurement_factor
        return np.tile(deviation[:, None], self.landmarks)

    @property
    def belief(self) -> Gaussian:
        """The robot's belief in its start."""
        return Gaussian(np.array([self.start]), np.array([[self.start_deviation**2]]))


FIG3 = Config()
"""P0 = V = W = 1 m², as printed in the caption of Fig. 3."""
FIG4 = Config(
    start_deviation=0.1,
    motion_deviation=0.0,
    motion_share=0.5,
    measurement_deviation=0.0,
    measurement_share=0.05,
)
"""Noise in proportion to command and distance, as in Fig. 4; the three factors are ours."""


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Truth and measurements of a study, and what the filter made of them.

    A reference (eqs 20 and 23) adds an innovation before those of the landmarks.
    """

    config: Config
    world: RailRuns
    filtered: MonobotRun

    @property
    def vehicle_errors(self) -> Float[np.ndarray, "runs measurements"]:
        """Estimate minus truth of the vehicle, m."""
        return self.filtered.means[..., 0] - self.world.positions

    @property
    def landmark_errors(self) -> Float[np.ndarray, "runs measurements n"]:
        """Estimate minus truth of each landmark, m."""
        return self.filtered.means[..., 1:] - self.world.landmarks

    @property
    def first_errors(self) -> Float[np.ndarray, "runs n"]:
        """Landmark errors after the first measurement, m."""
        return self.landmark_errors[:, 0]

    @property
    def last_errors(self) -> Float[np.ndarray, "runs n"]:
        """Landmark errors after the last measurement, m."""
        return self.landmark_errors[:, -1]

    @property
    def deviations(self) -> Float[np.ndarray, "measurements states"]:
        """Standard deviations that the filter states in every run, vehicle first, m."""
        return self.filtered.deviations[0]

    @property
    def gains(self) -> Float[np.ndarray, "steps 2"]:
        """Gains of the vehicle and of the first landmark on that landmark's innovation."""
        return self.filtered.gains[0, :, :2, -self.config.landmarks]

    @property
    def explained(self) -> Interval:
        """Share of the variance of the last error that the first one explains, first landmark.

        Where one of the two does not vary there is nothing to explain, and the share is 0.
        """
        first, last = (e[:, 0].round(DECIMALS) for e in (self.first_errors, self.last_errors))
        if not (np.ptp(first) and np.ptp(last)):
            return exact(0.0, about="an error that does not vary")
        return intervals.explained(first, last)


def simulate(config: Config, *, rng: np.random.Generator) -> RailRuns:
    """Return the world of a study: truth and measurements; each run spawns its own generator."""
    return simulate_rail(
        config.plan,
        np.full(config.landmarks, config.landmarks_at),
        config.runs,
        start_deviation=config.start_deviation,
        motion_deviation=config.motion_deviations,
        measurement_deviation=config.measurement_deviations,
        rng=rng,
    )


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Simulate a study and filter it."""
    world = simulate(config, rng=rng)
    return Result(config, world, refilter(config, world))


def run_anchored(config: Config, *, rng: np.random.Generator) -> Result:
    """Simulate a study with an anchor at the origin, eq. (20), that is seen as the landmark is."""
    world, noise = simulate(config, rng=rng), config.measurement_deviations[1:, 0]
    distances = noise * rng.standard_normal((config.runs, config.steps)) - world.positions[:, 1:]
    run = run_referenced(
        config.belief,
        world.commands,
        world.measurements,
        Reference(-1, distances, noise**2),
        motion_variance=config.motion_deviations**2,
        measurement_variance=config.measurement_deviations**2,
    )
    return Result(config, world, run)


def refilter(config: Config, world: RailRuns) -> MonobotRun:
    """Filter a world with the noise that ``config`` believes in, which need not be the true one."""
    return _filtered(config, world.commands, world.measurements)


def covariances(config: Config) -> MonobotRun:
    """Return the covariances and gains of a study, which need no data (all of it is zero)."""
    measurements = np.zeros((1, config.steps + 1, config.landmarks))
    return _filtered(config, np.zeros(config.steps), measurements)


def total_information(config: Config) -> Float[np.ndarray, "steps states states"]:
    """Return the total Fisher information of eq. (14) after each step, 1/m²."""
    innovation_covs = covariances(config).innovation_covs[0]
    return fisher_information(sensor_matrix(config.landmarks), innovation_covs)


def limit(landmarks: int) -> Settled:
    """Return where the filter of Fig. 3 settles, in closed form at P0 = V = W = 1 m²."""
    return settled(landmarks, start_variance=1, motion_variance=1, measurement_variance=1)


def _filtered(config: Config, commands: np.ndarray, measurements: np.ndarray) -> MonobotRun:
    return run_filter(
        config.belief,
        commands,
        measurements,
        motion_variance=config.motion_deviations**2,
        measurement_variance=config.measurement_deviations**2,
    )
