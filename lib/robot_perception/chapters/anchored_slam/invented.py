"""Information that nobody sent: what filters with one anchor claim about the turn they cannot see.

The paper is Andrade-Cetto, "Perception Issues in Mobile Robotics", section 2.2, eqs (24) to (27).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from data_synth.posts import glimpse
from data_synth.wheels import SMALL, Slip, roll
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import wrap_angle
from robot_perception.slam import planar
from robot_perception.slam.observability import gauge_directions, information_along
from robot_perception.slam.planar import History, MapBelief, Step
from robot_perception.teaching.recorded import recorded
from robot_perception.teaching.tables import Table

Filter = Literal["plain", "first estimates", "ideal"]
FILTERS: tuple[Filter, ...] = ("plain", "first estimates", "ideal")
SEED = 21


@dataclass(frozen=True, slots=True)
class Config:
    """A robot that circles among posts, one or more of which stand at known places; all ours.

    Lengths are in m, angles in rad. The anchors, 1 or 2, are there besides the posts. The start
    errs in each coordinate and in the heading, a measurement in each coordinate of a post in the
    frame of the robot; posts ahead and within reach are seen. All filters get the same runs.
    """

    runs: int = 50
    steps: int = 150
    rounds: float = 2.0
    radius: float = 4.0
    posts: int = 10
    anchors: int = 1
    start_deviation: float = 0.5
    heading_deviation: float = np.deg2rad(10.0)
    measurement_deviation: float = 0.05
    reach: float = 6.0
    slip: Slip = SMALL
    filters: tuple[Filter, ...] = FILTERS


@dataclass(frozen=True, eq=False, slots=True)
class Drive:
    """One run: true path (m, m, rad), places (m, the anchors first), and what the filter gets."""

    path: Float[np.ndarray, "poses 3"]
    places: Float[np.ndarray, "posts 2"]
    steps: tuple[Step, ...]
    start: MapBelief


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What one filter claimed in all runs, and how wrong it was.

    The gains are the information about the turn of the world over that of the start: a filter that
    invents nothing stays at or below 1. Deviations (as stated) and errors are of the heading, rad.
    """

    gains: Float[np.ndarray, "runs beliefs"]
    deviations: Float[np.ndarray, "runs steps"]
    errors: Float[np.ndarray, "runs steps"]

    @property
    def nees(self) -> Float[np.ndarray, "steps"]:
        """Squared error of the heading over the stated variance, averaged over the runs."""
        return ((self.errors / self.deviations) ** 2).mean(axis=0)

    @property
    def rms(self) -> Float[np.ndarray, "steps"]:
        """Root mean square error of the heading, rad."""
        return np.sqrt((self.errors**2).mean(axis=0))

    @property
    def stated(self) -> Float[np.ndarray, "steps"]:
        """Root mean square of the stated deviation of the heading, rad."""
        return np.sqrt((self.deviations**2).mean(axis=0))

    @property
    def invented(self) -> Bool[np.ndarray, "runs"]:
        """Whether a run ever claims more than it started with (a millionth is rounding)."""
        return (self.gains > 1 + 1e-6).any(axis=1)


def run(config: Config, *, rng: np.random.Generator) -> dict[Filter, Result]:
    """Run the filters over the same runs; the results are by filter."""
    done = sweep(_one_run, [config] * config.runs, rng=rng, desc="circles")
    columns = zip(config.filters, zip(*done, strict=True), strict=True)
    return {kind: Result(*map(np.array, zip(*rows, strict=True))) for kind, rows in columns}


def _one_run(config: Config, *, rng: np.random.Generator) -> list[tuple[np.ndarray, ...]]:
    """Return the fields of `Result` for one run, by filter."""
    drive, rows = simulate(config, rng=rng), []
    for kind in config.filters:
        history = filter_drive(config, drive, kind)
        claimed = claimed_information(drive, history, kind)
        errors = wrap_angle(history.poses[:, 2] - drive.path[1:, 2])
        rows.append((claimed / claimed[0], np.sqrt(history.pose_covs[:, 2, 2]), errors))
    return rows


def simulate(config: Config, *, rng: np.random.Generator) -> Drive:
    """Return one run of a study."""
    angle = np.linspace(0.0, 2 * np.pi * config.rounds, config.steps + 1)
    path = np.stack([np.sin(angle), 1 - np.cos(angle), angle], axis=-1)
    path[:, :2] *= config.radius
    known = np.array([[1.5, -1.0], [-3.0, 9.0]])[: config.anchors]
    off = rng.choice([-1.0, 1.0], config.posts) * rng.uniform(0.8, 2.5, config.posts)
    round_ = rng.uniform(0, 2 * np.pi, config.posts)
    ring = np.stack([np.sin(round_), -np.cos(round_)], axis=-1)
    own = [0.0, config.radius] + (config.radius + off)[:, None] * ring
    places = np.vstack([known, own])
    wheels = roll(path, config.slip, rng=rng)
    seen = glimpse(places, path, sigma=config.measurement_deviation, reach=config.reach, rng=rng)
    deviations = np.array([config.start_deviation] * 2 + [config.heading_deviation])
    believed = path[0] + deviations * rng.standard_normal(3)
    steps = tuple(
        Step(planar.Odometry(increment, np.diag(deviation**2)), planar.Observations(*observed))
        for increment, deviation, observed in zip(
            wheels.increments, wheels.deviations, seen[1:], strict=True
        )
    )
    return Drive(path, places, steps, MapBelief.start(believed, np.diag(deviations**2)))


def filter_drive(config: Config, drive: Drive, kind: Filter) -> History:
    """Run one of the three filters over a run; it keeps its belief after every step."""
    truth = planar.Truth(drive.path, dict(enumerate(drive.places)))
    points = {"plain": "latest", "first estimates": "first", "ideal": truth}
    settings = planar.Settings(
        planar.CartesianSensor(config.measurement_deviation**2 * np.eye(2)),
        anchors=dict(enumerate(drive.places[: config.anchors])),
        linearisation=points[kind],
        keep=range(config.steps),
    )
    return planar.run_filter(drive.start, drive.steps, settings)


def claimed_information(
    drive: Drive, history: History, kind: Filter
) -> Float[np.ndarray, "beliefs"]:
    r"""Return the information that a filter claims about a turn of the world about the anchor.

    .. math:: I_k = N_k^\top P_k^{-1} N_k, \qquad
        N = \big(J (t - a),\, 1,\, J (p_1 - a), …\big)

    N is taken where the filter takes its Jacobians. If these points hang together, the next N is
    F N and H N = 0, so that :math:`I_k` can only fall: measurements add nothing, and noise of the
    wheels takes away. At the start and after each step, 1/rad².
    """
    points = [drive.path[0] if kind == "ideal" else drive.start.mean, *history.points.values()]
    beliefs = [drive.start, *history.kept.values()]
    turns = [gauge_directions(point, drive.places[0])["turn"] for point in points]
    claimed = map(information_along, turns, (belief.cov for belief in beliefs))
    return np.array(list(claimed))


@recorded("anchored-starts", (((1, 3, 10),),))
def start_table(degrees: tuple[float, ...]) -> Table:
    """Return what the plain filter invents, by how well its start heading is known (1σ, °)."""
    rows = {}
    for known in degrees:
        config = Config(heading_deviation=np.deg2rad(known), filters=("plain",))
        found = run(config, rng=np.random.default_rng(SEED))["plain"]  # the same noise for all
        rows[f"±{known:g}°"] = (float(np.median(found.gains[:, -1])), float(found.nees[-1]))
    columns = {
        "information": "about the turn, claimed over that of the start, median",
        "NEES of the heading": "squared error over stated variance, mean; 1 is right",
    }
    return Table(rows, columns, f"{Config().runs} runs each", "start heading")
