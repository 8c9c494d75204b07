"""The robot on the rail by the library's world and filter: what `anchored_slam` shares.

The notebook of this chapter has a world and a filter of its own, in sight; the tests compare them
with these, which stay until `anchored_slam` computes in its notebook, too. Step 0 is the first
measurement, which puts the landmarks into the map; every later step first moves, then measures.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from data_synth.monobot import RailRuns, Shape, planned_path, simulate_rail
from robot_perception.beliefs import Gaussian
from robot_perception.evaluation import intervals
from robot_perception.evaluation.intervals import Interval
from robot_perception.kalman import Motion, Sensor, fisher_information
from robot_perception.slam.monobot import (
    MonobotRun,
    Reference,
    motion,
    run_filter,
    run_referenced,
    sensor_matrix,
)

PAPER = "perception-issues"
COUNTS = (1, 2, 5, 10, 20, 50)
"""Numbers of landmarks of Fig. 3; the caption says "various sizes", these are ours."""
Kind = Literal["none", "anchor", "external sensor"]
SIGNS: dict[Kind, Literal[-1, 1]] = {"anchor": -1, "external sensor": 1}
"""The first entry of the reference's row: eq. (20) and eq. (23)."""
ORIGIN = 0.0
"""Where anchor and sensor stand, m: the anchor by the caption of Fig. 5."""
DECIMALS = 12
"""Of numbers near zero; further ones are rounding and differ by processor."""


@dataclass(frozen=True, slots=True)
class Config:
    """One study of a monobot; noises are standard deviations, lengths in m.

    Independent runs of so many moves (100 in the caption of Fig. 4); landmarks, which all stand in
    one place (1 m in its text); where the robot believes that it starts (−1 m in its text); the
    commanded path, in Fig. 4 a sinusoid that returns, whose reach is ours. Noise of the true start
    about the believed one (1 in Fig. 3, ours in Fig. 4); of a move and of a measurement, each a
    constant part and a share of the commanded or planned distance.

    A reference is read after each move, as well as the landmark, or with a constant deviation and a
    share of the planned distance to it; the filter believes it ``misplaced`` by so much.
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
    reference: Kind = "none"
    reference_deviation: float | None = None
    reference_share: float = 0.0
    misplaced: float = 0.0

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
        return np.tile((self.measurement_deviation + share)[:, None], self.landmarks)

    @property
    def reference_deviations(self) -> Float[np.ndarray, "steps"]:
        """Standard deviation of the reference after each move, m."""
        if self.reference_deviation is None:
            return self.measurement_deviations[1:, 0]
        return self.reference_deviation + self.reference_share * np.abs(self.plan[1:] - ORIGIN)

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
    def positions(self) -> Float[np.ndarray, "runs measurements"]:
        """True positions of the vehicle, m."""
        return self.world.positions

    @property
    def measurements(self) -> Float[np.ndarray, "runs measurements n"]:
        """Measured distances to the landmarks, m."""
        return self.world.measurements

    @property
    def means(self) -> Float[np.ndarray, "runs measurements states"]:
        """Estimates, vehicle first, m."""
        return self.filtered.means

    @property
    def landmarks_at(self) -> float:
        """Where all landmarks stand, m."""
        return self.config.landmarks_at

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


def refilter(config: Config, world: RailRuns, values: np.ndarray | None = None) -> MonobotRun:
    """Filter a world with the noise that ``config`` believes in, which need not be the true one.

    ``values`` are what a reference measured, if there is one.
    """
    return _filtered(config, world.commands, world.measurements, values)


def covariances(config: Config) -> MonobotRun:
    """Return the covariances and gains of a study, which need no data (all of it is zero)."""
    nothing = np.zeros(config.steps)
    measurements = np.zeros((1, config.steps + 1, config.landmarks))
    return _filtered(config, nothing, measurements, nothing[None])


def sensor(config: Config) -> Float[np.ndarray, "m states"]:
    """Return the measurement matrix after each move; a reference has a row before the others."""
    if config.reference == "none":
        return sensor_matrix(config.landmarks)
    return Reference(SIGNS[config.reference], np.zeros((1, 1)), 0.0).matrix(config.landmarks)


def system(config: Config) -> tuple[list[Motion], list[Sensor]]:
    """Return the moves, and what is measured after each."""
    matrix, noises = sensor(config), config.measurement_deviations[1:] ** 2
    if config.reference != "none":
        noises = np.insert(noises, 0, config.reference_deviations**2, axis=1)
    moves = [motion(0.0, float(s) ** 2, config.landmarks) for s in config.motion_deviations]
    return moves, [Sensor(matrix, np.diag(noise)) for noise in noises]


def total_information(config: Config) -> Float[np.ndarray, "steps states states"]:
    """Return the total Fisher information of eq. (14) after each step, 1/m²."""
    return fisher_information(sensor(config), covariances(config).innovation_covs[0])


def _filtered(
    config: Config, commands: np.ndarray, measurements: np.ndarray, values: np.ndarray | None
) -> MonobotRun:
    given = config.belief, commands, measurements
    noises = {
        "motion_variance": config.motion_deviations**2,
        "measurement_variance": config.measurement_deviations**2,
    }
    if config.reference == "none":
        return run_filter(*given, **noises)
    variance, believed = config.reference_deviations**2, ORIGIN + config.misplaced
    reference = Reference(SIGNS[config.reference], values, variance, believed)
    return run_referenced(*given, reference, **noises)


@dataclass(frozen=True, eq=False, slots=True)
class Ends:
    """Errors of the first landmark in all runs, the first and the last, m."""

    config: Config
    first: Float[np.ndarray, "runs"]
    last: Float[np.ndarray, "runs"]

    @property
    def explained(self) -> Interval:
        """Share of the variance of the last error that the first one explains."""
        return intervals.explained(self.first.round(DECIMALS), self.last.round(DECIMALS))


def ends(result: Result) -> Ends:
    """Keep the ends of a study: its errors take a hundred times the place."""
    first, last = (result.landmark_errors[:, k, 0].copy() for k in (0, -1))
    return Ends(result.config, first, last)


def remaining_share(sample: Ends) -> Interval:
    """Return the measured mean square of the last error over the stated variance of the first."""
    first = covariances(sample.config).deviations[0, 0, 1]
    root = intervals.root_mean_square(sample.last / first)
    return Interval(root.estimate**2, root.low**2, root.high**2, "", root.about)
