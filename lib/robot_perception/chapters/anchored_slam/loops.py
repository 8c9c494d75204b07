"""What the studies of Fig. 7 share: the ways to run the filter round a loop, and what came of it.

The paper is Andrade-Cetto, "Perception Issues in Mobile Robotics", section 2.2, text to eqs (24) to
(27).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int

from data_synth.wheels import LARGE, SMALL, Slip, roll
from data_synth.wheels import Odometry as WheelReport
from robot_perception.evaluation.consistency import (
    Coverage,
    coverage,
    normalised_squared,
)
from robot_perception.evaluation.trajectories import absolute_error
from robot_perception.geometry import wrap_angle
from robot_perception.slam.planar import (
    CartesianSensor,
    History,
    MapBelief,
    Observations,
    Odometry,
    PositionFix,
    Settings,
    Step,
    Truth,
    run_filter,
)
from robot_perception.teaching.claims import Interval

SLIPS: Mapping[str, Slip] = {"small": SMALL, "large": LARGE}
STARTS = {"exact": (0.0, 0.0, 0.0), "uncertain": (0.1, 0.1, np.deg2rad(3.0))}
"""Deviations of the true start about the believed one, m, m, rad; both are ours."""


@dataclass(frozen=True, slots=True)
class Variant:
    """One way to run the filter.

    Parameters
    ----------
    anchored
        The place of the first observed landmark in the world is known, eqs (24) and (25); of
        several in the first scan, that of the nearest.
    external
        Something outside measures the position now and then, eqs (26) and (27).
    linearisation
        Where the Jacobians are taken; ``"true"`` is the ideal that nobody has.
    limit
        Landmarks revised more often than this leave the state; the paper: 50.
    retirement
        What becomes of them: frozen, as in the paper, or still counted with their uncertainty.
    """

    anchored: bool = False
    external: bool = False
    linearisation: Literal["latest", "first", "true"] = "latest"
    limit: int | None = None
    retirement: Literal["freeze", "consider"] = "freeze"


VARIANTS: Mapping[str, Variant] = {
    "plain": Variant(),
    "anchored": Variant(anchored=True),
    "external": Variant(external=True),
    "first estimates": Variant(linearisation="first"),
    "anchored, first estimates": Variant(anchored=True, linearisation="first"),
    "true Jacobians": Variant(linearisation="true"),
    "rule at 50": Variant(limit=50),
    "considered at 50": Variant(limit=50, retirement="consider"),
    "rule at 15": Variant(limit=15),
    "anchored, rule at 15": Variant(anchored=True, limit=15),
    "considered at 15": Variant(limit=15, retirement="consider"),
}
"""By name. How soon a landmark is revised 50 times depends on the distance between scans, which the
paper does not tell. Between scans every 20 cm no landmark of the building is seen so often; a limit
of 15 is there what 50 is between scans every 6 cm, one each fifth of a second at 0.3 m/s."""


@dataclass(frozen=True, slots=True)
class Case:
    """A variant under one set of circumstances.

    Parameters
    ----------
    variant
        Name of the variant.
    noise
        How wrong the wheels are: ``"small"`` or ``"large"``.
    association
        How observations find their landmarks: nearest within a gate, jointly, or by the truth.
    start
        Whether the start is known exactly.
    """

    variant: str = "plain"
    noise: str = "large"
    association: Literal["gated", "joint", "known"] = "gated"
    start: Literal["exact", "uncertain"] = "exact"


@dataclass(frozen=True, eq=False, slots=True)
class Runs:
    """What came out of one case, over all seeds.

    Parameters
    ----------
    errors : (seeds, steps, 3)
        Estimated minus true pose, m, m, rad.
    nees : (seeds, steps - 1)
        Normalised squared error of the pose; not of the first, which may be exact.
    false, twice : (seeds,)
        Observations used for a wrong landmark, and landmarks put into the map again.
    map_error, map_shape : (seeds,)
        Root mean square error of the landmarks, m: as they stand, and after the best rigid motion.
    states : (seeds,)
        Mean square of the size of the state, which is what a step costs.
    retired : (seeds,)
        Landmarks taken out of the state.
    """

    errors: Float[np.ndarray, "seeds steps 3"]
    nees: Float[np.ndarray, "seeds later"]
    false: Int[np.ndarray, " seeds"]
    twice: Int[np.ndarray, " seeds"]
    map_error: Float[np.ndarray, " seeds"]
    map_shape: Float[np.ndarray, " seeds"]
    states: Float[np.ndarray, " seeds"]
    retired: Int[np.ndarray, " seeds"]

    def distance(self, step: int = -1) -> Float[np.ndarray, " seeds"]:
        """Return the errors of the position at a step, m."""
        return np.hypot(self.errors[:, step, 0], self.errors[:, step, 1])

    def heading(self, step: int = -1) -> Float[np.ndarray, " seeds"]:
        """Return the sizes of the errors of the heading at a step, °."""
        return np.rad2deg(np.abs(self.errors[:, step, 2]))

    @property
    def coverage(self) -> Coverage:
        """The NEES beside what chance allows."""
        return coverage(self.nees, 3, independent=len(self.nees))


@dataclass(frozen=True, eq=False, slots=True)
class Chance:
    """The chance of one run, beside that of its scans.

    Parameters
    ----------
    start : (3,)
        Error of the start in deviations.
    wheels
        What the wheels report, by level of noise.
    fixes : (steps, 2)
        Errors of the measured positions, m.
    """

    start: Float[np.ndarray, "3"]
    wheels: Mapping[str, WheelReport]
    fixes: Float[np.ndarray, "steps 2"]


def draw_chance(
    poses: np.ndarray,
    slips: Mapping[str, Slip],
    fix_sigma: float,
    streams: Sequence[np.random.Generator],
) -> Chance:
    start, wheels, fixes = streams
    seed = wheels.integers(2**63)  # the same chance at every level of noise
    reports = {name: roll(poses, s, rng=np.random.default_rng(seed)) for name, s in slips.items()}
    errors = fix_sigma * fixes.standard_normal((len(poses), 2))
    return Chance(start.standard_normal(3), reports, errors)


@runtime_checkable
class Outside(Protocol):
    """What a study says of the sensor that watches from outside: steps between fixes, and m."""

    @property
    def fix_every(self) -> int:
        """Steps between measured positions."""

    @property
    def fix_sigma(self) -> float:
        """Their deviation in each coordinate, m."""


def filter_case(
    outside: Outside,
    case: Case,
    landmarks: Float[np.ndarray, "n 2"],
    poses: Float[np.ndarray, "steps 3"],
    sightings: Sequence[Observations],
    chance: Chance,
    anchors: Sequence[int] | None = None,
    keep: Sequence[int] = (),
) -> History:
    """Run the filter of one case on what one run saw.

    Parameters
    ----------
    outside
        The study: how often and how well the position is measured from outside.
    case
        The case.
    landmarks
        True places, m: for the anchor, and for the ideal filter.
    poses
        The true path.
    sightings
        What was found in each scan, and of which true landmark it is.
    chance
        The chance of this run.
    anchors
        Which landmarks an anchored variant knows; the first observed one if not given.
    keep
        Steps after which the whole belief is kept.
    """
    variant, deviation = VARIANTS[case.variant], np.array(STARTS[case.start])
    if anchors is None:
        anchors = [first_observed(sightings)]
    known = {i: landmarks[i] for i in anchors} if variant.anchored else {}
    linearisation = variant.linearisation
    if linearisation == "true":
        linearisation = Truth(np.vstack([poses[:1], poses]), dict(enumerate(landmarks)))
    settings = Settings(
        CartesianSensor(np.eye(2)),
        anchors=known,
        association=case.association,
        linearisation=linearisation,
        revision_limit=variant.limit,
        retirement=variant.retirement,
        keep=keep,
    )
    start = MapBelief.start(poses[0] + deviation * chance.start, np.diag(deviation**2))
    wheels = chance.wheels[case.noise]
    steps = []
    for k, seen in enumerate(sightings):
        names = seen.ids
        if case.association != "known":  # only the anchor is shown, once
            names = np.where((k == 0) & np.isin(names, list(known)), names, -1)
        motion, fixes = None, ()
        if k > 0:
            motion = Odometry(wheels.increments[k - 1], np.diag(wheels.deviations[k - 1] ** 2))
        if variant.external and k % outside.fix_every == 0:
            place = poses[k, :2] + chance.fixes[k]
            fixes = (PositionFix(place, outside.fix_sigma**2 * np.eye(2)),)
        steps.append(Step(motion, seen.named(names), fixes))
    return run_filter(start, steps, settings)


def account(
    history: History, poses: np.ndarray, sightings: Sequence[Observations], landmarks: np.ndarray
) -> tuple:
    """Compare a run with the truth; the order is that of the fields of :class:`Runs`."""
    errors = history.poses - poses
    errors[:, 2] = wrap_angle(errors[:, 2])
    owner, false = {}, 0
    for seen, used in zip(sightings, history.used, strict=True):
        for truth, name in zip(seen.ids.tolist(), used.tolist(), strict=True):
            if name >= 0 and truth >= 0:
                false += owner.setdefault(name, truth) != truth
    places = dict(zip(history.belief.ids.tolist(), history.belief.landmarks, strict=True))
    places |= history.frozen
    names = [name for name in places if name in owner]
    estimate = np.array([places[name] for name in names])
    truth = landmarks[[owner[name] for name in names]]
    return (
        errors,
        normalised_squared(errors[1:], history.pose_covs[1:]),
        false,
        len(owner) - len(set(owner.values())),
        absolute_error(estimate, truth, False),
        absolute_error(estimate, truth, True),
        float(np.mean((3.0 + 2.0 * history.sizes) ** 2)),
        history.counts.retired,
    )


def stack(rows: Sequence[tuple]) -> Runs:
    return Runs(*(np.array(column) for column in zip(*rows, strict=True)))


def first_observed(sightings: Sequence[Observations]) -> int:
    """Return the first landmark that was seen; of several at once, the nearest."""
    seen = next(s for s in sightings if (s.ids >= 0).any())
    away = np.where(seen.ids >= 0, np.hypot(*seen.values.T), np.inf)
    return int(seen.ids[away.argmin()])


def mean_of(samples: np.ndarray, unit: str = "m") -> Interval:
    """Return a mean over runs with its bootstrap interval, for errors far from normal."""
    return _bootstrapped(samples, np.mean, unit)


def median_of(samples: np.ndarray, unit: str = "") -> Interval:
    """Return a median over runs with its bootstrap interval."""
    return _bootstrapped(samples, np.median, unit)


def _bootstrapped(samples: np.ndarray, statistic: Callable[..., Any], unit: str) -> Interval:
    picks = np.random.default_rng(0).integers(len(samples), size=(4000, len(samples)))
    low, high = np.quantile(statistic(samples[picks], axis=1), [0.025, 0.975])
    value = float(statistic(samples))
    about = f"{statistic.__name__}, 95 % bootstrap over {len(samples)} runs"
    return Interval(value, min(float(low), value), max(float(high), value), unit, about)


def ratio_of(
    above: np.ndarray, below: np.ndarray, rng: np.random.Generator, about: str
) -> Interval:
    """Return the ratio of two means over the same runs, with its bootstrap interval."""
    picks = rng.integers(len(above), size=(4000, len(above)))
    ratios = above[picks].mean(axis=1) / below[picks].mean(axis=1)
    value = float(above.mean() / below.mean())
    low, high = np.quantile(ratios, [0.025, 0.975])
    about = f"{about}, 95 % bootstrap over {len(above)} runs"
    return Interval(value, min(float(low), value), max(float(high), value), "", about)
