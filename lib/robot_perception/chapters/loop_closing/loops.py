"""What the studies of Fig. 7 share: the ways to run the filter round a loop, and what came of it.

The paper is Andrade-Cetto, "Perception Issues in Mobile Robotics", section 2.2, text to eqs (24) to
(27).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from data_synth import wheels
from data_synth.wheels import LARGE, SMALL, Slip
from robot_perception.evaluation.consistency import Coverage, coverage, normalised_squared
from robot_perception.evaluation.trajectories import absolute_error
from robot_perception.geometry import wrap_angle
from robot_perception.observations import Observations
from robot_perception.slam import planar
from robot_perception.slam.planar import History, PositionFix

SLIPS: Mapping[str, Slip] = {"small": SMALL, "large": LARGE}
STARTS = {
    "exact": (0.0, 0.0, 0.0),
    "shifted": (0.1, 0.1, 0.0),
    "uncertain": (0.1, 0.1, np.deg2rad(3.0)),
    "displaced": (1.0, 1.0, 0.0),
}
"""Deviations of the true start about the believed one, m, m, rad; all are ours."""


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
    "ideal": Variant(linearisation="true"),
    "rule at 50": Variant(limit=50),
    "considered at 50": Variant(limit=50, retirement="consider"),
    "anchored, rule at 15": Variant(anchored=True, limit=15),
}
"""By name. How soon a landmark is revised 50 times depends on the distance between scans, which the
paper does not tell. With a scan every 20 cm hardly a landmark of the building is seen so often; a
limit of 15 is there what 50 is with a scan every 6 cm, one each fifth of a second at 0.3 m/s."""


@dataclass(frozen=True, slots=True)
class Case:
    """A variant, by name, under one set of circumstances.

    The noise says how wrong the wheels are, the association how observations find their landmarks
    (nearest within a gate, jointly, or by the truth), the start whether it is known exactly, but
    for its place, roughly, or to a metre only.
    """

    variant: str = "plain"
    noise: str = "large"
    association: Literal["gated", "joint", "known"] = "gated"
    start: Literal["exact", "shifted", "uncertain", "displaced"] = "exact"

    @property
    def circumstances(self) -> str:
        """All but the variant, in words."""
        return f"{self.noise} noise, {self.association}, {self.start} start"


@dataclass(frozen=True, slots=True)
class Fixes:
    """A sensor that watches from outside: steps between its fixes, and their deviation, m."""

    every: int
    sigma: float


@dataclass(frozen=True, eq=False, slots=True)
class Drive:
    """One run as all cases share it: true places and path, what was seen, and the noise drawn.

    Parameters
    ----------
    seen
        After each step, by true landmark (-1 for none), in the robot's frame, m.
    start
        Error of the believed start in deviations.
    wheels, fixes
        What they report, by level of noise, and positions measured from outside, by step.
    """

    landmarks: Float[np.ndarray, "n 2"]
    poses: Float[np.ndarray, "steps 3"]
    seen: Sequence[Observations]
    start: Float[np.ndarray, "3"]
    wheels: Mapping[str, wheels.Odometry]
    fixes: Mapping[int, PositionFix]


def draw_drive(
    landmarks: Float[np.ndarray, "n 2"],
    poses: Float[np.ndarray, "steps 3"],
    seen: Sequence[Observations],
    slips: Mapping[str, Slip],
    fixes: Fixes,
    streams: Sequence[np.random.Generator],
) -> Drive:
    """Draw the noise of start, wheels and fixes, each by a stream; the rest is given."""
    start, seeds, outside = streams
    seed = seeds.integers(2**63)  # the same chance at every level of noise
    reports = {
        name: wheels.roll(poses, slip, rng=np.random.default_rng(seed))
        for name, slip in slips.items()
    }
    places = poses[:, :2] + fixes.sigma * outside.standard_normal((len(poses), 2))
    cov = fixes.sigma**2 * np.eye(2)
    at = {k: PositionFix(places[k], cov) for k in range(0, len(poses), fixes.every)}
    return Drive(landmarks, poses, seen, start.standard_normal(3), reports, at)


def filter_drive(
    case: Case, drive: Drive, *, anchors: Sequence[int] | None = None, keep: Sequence[int] = ()
) -> History:
    """Run the filter of one case over one run; an anchored one knows the landmarks named.

    If none are named, it knows the first observed one. The whole belief is kept after the steps
    ``keep``.
    """
    variant, deviation = VARIANTS[case.variant], np.array(STARTS[case.start])
    known, poses = {}, drive.poses
    if variant.anchored:
        anchors = [first_observed(drive.seen)] if anchors is None else anchors
        known = {i: drive.landmarks[i] for i in anchors}
    linearisation = variant.linearisation
    if linearisation == "true":
        truth = dict(enumerate(drive.landmarks))
        linearisation = planar.Truth(np.vstack([poses[:1], poses]), truth)
    settings = planar.Settings(
        planar.CartesianSensor(np.eye(2)),
        anchors=known,
        association=case.association,
        linearisation=linearisation,
        revision_limit=variant.limit,
        retirement=variant.retirement,
        keep=keep,
    )
    start = planar.MapBelief.start(poses[0] + deviation * drive.start, np.diag(deviation**2))
    report, motion, steps = drive.wheels[case.noise], None, []
    for k, seen in enumerate(drive.seen):
        if case.association != "known":  # only the anchor is shown, once
            names = np.where((k == 0) & np.isin(seen.ids, list(known)), seen.ids, -1)
            seen = seen.named(names)
        if k > 0:
            motion = planar.Odometry(
                report.increments[k - 1], np.diag(report.deviations[k - 1] ** 2)
            )
        fixes = (drive.fixes[k],) if variant.external and k in drive.fixes else ()
        steps.append(planar.Step(motion, seen, fixes))
    return planar.run_filter(start, steps, settings)


def first_observed(seen: Sequence[Observations]) -> int:
    """Return the first landmark that was seen; of several at once, the nearest."""
    first = next(one for one in seen if (one.ids >= 0).any())
    away = np.where(first.ids >= 0, np.hypot(first.values[:, 0], first.values[:, 1]), np.inf)
    return int(first.ids[away.argmin()])


@dataclass(frozen=True, eq=False, slots=True)
class Runs:
    """What came out of one case, over all runs.

    Parameters
    ----------
    errors, nees
        Estimated minus true pose, m, m, rad, and its normalised square after the first step.
    false, twice
        Observations used for a wrong landmark, and landmarks put into the map again.
    map_error, map_shape
        Root mean square error of the landmarks, m: as they stand, and after the best rigid motion.
    states, retired
        Mean square size of the state, which is what a step costs, and landmarks taken out of it.
    stated
        Deviations of position (m) and heading (rad) as the filter states them, root mean square
        along the path.
    """

    errors: Float[np.ndarray, "runs steps 3"]
    nees: Float[np.ndarray, "runs later"]
    false: Int[np.ndarray, " runs"]
    twice: Int[np.ndarray, " runs"]
    map_error: Float[np.ndarray, " runs"]
    map_shape: Float[np.ndarray, " runs"]
    states: Float[np.ndarray, " runs"]
    retired: Int[np.ndarray, " runs"]
    stated: Float[np.ndarray, "runs 2"]

    def distance(self, step: int = -1) -> Float[np.ndarray, " runs"]:
        """Return the errors of the position at a step, m."""
        return np.hypot(self.errors[:, step, 0], self.errors[:, step, 1])

    def heading(self, step: int = -1) -> Float[np.ndarray, " runs"]:
        """Return the sizes of the errors of the heading at a step, °."""
        return np.rad2deg(np.abs(self.errors[:, step, 2]))

    @property
    def rms(self) -> Float[np.ndarray, " steps"]:
        """Root mean square error of the position over the runs, m."""
        return np.sqrt((self.errors[..., :2] ** 2).sum(axis=-1).mean(axis=0))

    @property
    def rms_heading(self) -> Float[np.ndarray, " steps"]:
        """Root mean square error of the heading over the runs, °."""
        return np.rad2deg(np.sqrt((self.errors[..., 2] ** 2).mean(axis=0)))

    @property
    def path_error(self) -> Float[np.ndarray, " runs"]:
        """Root mean square error of the position along the path, by run, m."""
        return np.sqrt((self.errors[..., :2] ** 2).sum(axis=-1).mean(axis=1))

    @property
    def mean_nees(self) -> Float[np.ndarray, " runs"]:
        """NEES averaged along the path, by run."""
        return self.nees.mean(axis=1)

    @property
    def coverage(self) -> Coverage:
        """The NEES beside what chance allows."""
        return coverage(self.nees, 3, independent=len(self.nees))


def account(history: History, drive: Drive) -> tuple:
    """Compare a run with the truth; the order is that of the fields of :class:`Runs`."""
    errors = history.poses - drive.poses
    errors[:, 2] = wrap_angle(errors[:, 2])
    owner, false = {}, 0
    for seen, used in zip(drive.seen, history.used, strict=True):
        for truth, name in zip(seen.ids.tolist(), used.tolist(), strict=True):
            if name >= 0 and truth >= 0:
                false += owner.setdefault(name, truth) != truth
    places = dict(zip(history.belief.ids.tolist(), history.belief.landmarks, strict=True))
    places |= history.frozen
    names = [name for name in places if name in owner]
    estimate = np.array([places[name] for name in names])
    truth = drive.landmarks[[owner[name] for name in names]]
    variances = np.diagonal(history.pose_covs, axis1=1, axis2=2).mean(axis=0)
    return (
        errors,
        normalised_squared(errors[1:], history.pose_covs[1:]),
        false,
        len(owner) - len(set(owner.values())),
        absolute_error(estimate, truth, False),
        absolute_error(estimate, truth, True),
        float(np.mean((3.0 + 2.0 * history.sizes) ** 2)),
        history.counts.retired,
        np.sqrt([variances[:2].sum(), variances[2]]),
    )


def stack(rows: Sequence[tuple]) -> Runs:
    """Return what came out of several runs from their accounts."""
    return Runs(*(np.array(column) for column in zip(*rows, strict=True)))
