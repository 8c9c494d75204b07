"""Corners and poles of a real building: the Intel Research Lab with its raw odometry.

The robot turned by 18° on average between two scans, which are 180 beams of one degree. What a scan
calls a corner depends on choices; so the study makes several of each and shows all results. For
comparison every choice is run a second time with the associations told by the corrected poses.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from robot_perception.chapters.anchored_slam.mrclam import Found
from robot_perception.datasets import LaserLog, Relations, read_carmen_log, read_relations
from robot_perception.evaluation.trajectories import (
    RelativeErrors,
    absolute_error,
    motion_errors,
    relative_poses,
)
from robot_perception.geometry import act, wrap_angle
from robot_perception.slam.planar import (
    Association,
    CartesianSensor,
    MapBelief,
    Observations,
    Odometry,
    Settings,
    Step,
    dead_reckoning,
    run_filter,
)
from robot_perception.teaching.recordings import Recording
from robot_perception.walls.corners import LandmarkReport, LandmarkRules, find_landmarks
from robot_perception.walls.segments import Extraction, RangeNoise

RULES = (
    LandmarkRules(),
    LandmarkRules(Extraction(RangeNoise(0.02), tolerance=0.06, least_length=0.4), edge=0.02),
)
"""Those of the synthetic building, and the noise that chapter 1 measured in this one; ours."""
KINDS = (("concave", "convex", "pole"), ("concave", "convex"))
FACTORS = (1.0, 4.0)
"""On the covariances of corners and poles."""
ASSOCIATIONS = ("gated", "joint")
FLOOR = 0.01**2 * np.eye(2)
"""Added to the covariances, m²: readings are in steps of a centimetre."""
SAME = 0.3
"""Corners are told to be the same within this distance in the frame of the corrected poses, m."""
NEAR = 10
"""Relations between scans that are fewer apart than this are steps, the others loops."""
DRAWN = 450


@dataclass(frozen=True, eq=False, slots=True)
class Wheels:
    """Raw odometry after what a constant calibration can do for it.

    Parameters
    ----------
    increments : (steps, 3)
        Motions from scan to scan, m, m, rad.
    noise : (3, 3)
        Covariance of what is left.
    drift
        Heading error per metre that was taken off, rad/m.
    offset : (2,)
        Translation error per step that was taken off, m.
    """

    increments: Float[np.ndarray, "steps 3"]
    noise: Float[np.ndarray, "3 3"]
    drift: float
    offset: Float[np.ndarray, "2"]


def calibrate(log: LaserLog) -> Wheels:
    """Fit a heading drift per metre and a constant offset to the corrected poses."""
    pairs = _pairs(np.arange(len(log.times)))
    raw = relative_poses(log.odometry, pairs)
    errors = relative_poses(log.poses, pairs) - raw
    errors[:, 2] = wrap_angle(errors[:, 2])
    length = np.hypot(*raw[:, :2].T)
    drift = float(length @ errors[:, 2] / (length @ length))
    offset = errors[:, :2].mean(axis=0)
    change = np.column_stack([np.broadcast_to(offset, (len(raw), 2)), drift * length])
    return Wheels(raw + change, np.diag((errors - change).var(axis=0)), drift, offset)


def _pairs(rows: Int[np.ndarray, " k"]) -> Int[np.ndarray, "pairs 2"]:
    return np.stack([rows[:-1], rows[1:]], axis=1)


def run_scans(
    start: Float[np.ndarray, "3"],
    wheels: Wheels,
    seen: Sequence[Observations],
    ids: Sequence[Int[np.ndarray, " _"]],
    settings: Settings,
    factor: float,
) -> Float[np.ndarray, "scans 3"]:
    """Return the poses of the filter, one for each scan; the first is given."""
    steps = [
        Step(
            Odometry(increment, wheels.noise),
            Observations(names, marks.values, factor * marks.covs + FLOOR),
        )
        for increment, marks, names in zip(wheels.increments, seen[1:], ids[1:], strict=True)
    ]
    return run_filter(MapBelief.start(start, np.zeros((3, 3))), steps, settings).path


def tell(
    poses: Float[np.ndarray, "scans 3"], seen: Sequence[Observations]
) -> list[Int[np.ndarray, " _"]]:
    """Name landmarks by where they are in the frame of given poses; a scan sees each name once."""
    places, counts = np.empty((0, 2)), np.empty(0)
    names = []
    for pose, marks in zip(poses, seen, strict=True):
        mine = np.empty(0, dtype=int)
        for point in act(pose, marks.values):
            apart = np.hypot(*(places - point).T)
            apart[mine] = np.inf
            near = int(apart.argmin()) if apart.size and apart.min() <= SAME else len(places)
            if near == len(places):
                places, counts = np.vstack([places, point]), np.append(counts, 0)
            counts[near] += 1
            places[near] += (point - places[near]) / counts[near]
            mine = np.append(mine, near)
        names.append(mine)
    return names


def blind(seen: Sequence[Observations]) -> list[Int[np.ndarray, " _"]]:
    """Leave all landmarks without names."""
    return [np.full(len(marks), -1) for marks in seen]


def only(marks: Observations, report: LandmarkReport, kinds: Sequence[str]) -> Observations:
    """Return the landmarks of some kinds."""
    return marks[np.isin(report.kinds, kinds)]


def study(folder: Path) -> dict[str, np.ndarray | float]:
    """Run all choices, and return what the chapter shows of them.

    Returns
    -------
    dict
        Errors of relative poses, rows of (translation m, rotation °) root mean square: of
        ``odometry``, ``calibrated``, ``corrected`` (kinds of relation, 2), ``blind`` and ``told``
        (choices, kinds of relation, 2); the first kind is steps, the second loops. Intervals
        ``*_low``, ``*_high`` of the first three. ``blind_ate``, ``told_ate``, ``calibrated_ate``
        against the corrected path after alignment, m. Counts ``relations`` (2,), ``scans``,
        ``marks`` (per scan, by rules), ``empty`` (share of scans, by rules). ``drift`` (°/m),
        ``offset`` (m), ``noise`` (sd: m, m, °). Paths ``way``, ``dead``, ``blind_way`` (first
        choice), ``told_way``; ``spots`` (landmarks seen, by corrected poses).
    """
    log = read_carmen_log(folder / "intel_odom_and_corrected.log.gz")
    relations = read_relations(folder / "intel.relations.gz")
    wheels, start = calibrate(log), log.poses[0]
    dead = dead_reckoning(start, (Odometry(i, wheels.noise) for i in wheels.increments))
    score = _scorer(log, relations)
    found = [[find_landmarks(r, log.angles, rules) for r in log.ranges] for rules in RULES]
    runs = {"blind": [], "told": []}
    for seen, kinds in product(found, KINDS):
        chosen = [only(*marks, kinds) for marks in seen]
        ways = [("blind", blind(chosen), association) for association in ASSOCIATIONS]
        ways.append(("told", tell(log.poses, chosen), Association("known", 0.9999)))
        for factor, (name, names, association) in product(FACTORS, ways):
            settings = Settings(CartesianSensor(np.eye(2)), association=association)
            runs[name].append(run_scans(start, wheels, chosen, names, settings, factor))
    near = np.abs(np.diff(relations.match(log.times)[1], axis=1))[:, 0] < NEAR
    thin = slice(None, None, len(log.times) // DRAWN)
    spots = [act(p, m.values) for p, (m, _) in zip(log.poses, found[0], strict=True)]
    singles = {"odometry": log.odometry, "calibrated": dead, "corrected": log.poses}
    return {
        **_with_intervals({name: score(poses) for name, poses in singles.items()}),
        **{name: np.array([_table(score(p))[0] for p in paths]) for name, paths in runs.items()},
        **{
            f"{name}_ate": np.array([absolute_error(p, log.poses, aligned=True) for p in paths])
            for name, paths in (*runs.items(), ("calibrated", [dead]))
        },
        "relations": np.array([near.sum(), (~near).sum()]),
        "scans": len(log.times),
        "marks": np.array([np.mean([len(m) for m, _ in seen]) for seen in found]),
        "empty": np.array([np.mean([len(m) == 0 for m, _ in seen]) for seen in found]),
        "drift": float(np.rad2deg(wheels.drift)),
        "offset": wheels.offset,
        "noise": np.sqrt(np.diag(wheels.noise)) * [1, 1, np.rad2deg(1)],
        "way": np.round(log.poses[thin, :2], 2),
        "dead": np.round(dead[thin, :2], 2),
        "blind_way": np.round(runs["blind"][0][thin, :2], 2),
        "told_way": np.round(runs["told"][0][thin, :2], 2),
        "spots": np.round(np.concatenate(spots), 2),
    }


Score = Callable[[np.ndarray], tuple[RelativeErrors, RelativeErrors]]


def _scorer(log: LaserLog, relations: Relations) -> Score:
    """Return a function of poses that gives the errors of steps and of loops."""
    rows, scans = relations.match(log.times)
    true = relations.planar[rows]
    near = np.abs(scans[:, 1] - scans[:, 0]) < NEAR

    def score(poses: np.ndarray) -> tuple[RelativeErrors, RelativeErrors]:
        found = relative_poses(poses, scans)
        return motion_errors(found[near], true[near]), motion_errors(found[~near], true[~near])

    return score


def _table(
    errors: tuple[RelativeErrors, RelativeErrors],
) -> tuple[Float[np.ndarray, "2 2"], Float[np.ndarray, "2 2"], Float[np.ndarray, "2 2"]]:
    """Return root mean squares (m, °) of steps and loops, and their 95 % intervals.

    The interval is that of the mean square, ± 1.96 standard errors, as if relations were
    independent; several loops share a stretch of the way, so that theirs is too narrow.
    """
    values, low, high = np.empty((3, 2, 2))
    for kind, error in enumerate(errors):
        for column, part in enumerate((error.translation, np.rad2deg(error.rotation))):
            mean, spread = np.mean(part**2), 1.96 * np.std(part**2, ddof=1) / np.sqrt(len(part))
            values[kind, column] = np.sqrt(mean)
            low[kind, column] = np.sqrt(max(mean - spread, 0.0))
            high[kind, column] = np.sqrt(mean + spread)
    return values, low, high


def _with_intervals(
    scores: Mapping[str, tuple[RelativeErrors, RelativeErrors]],
) -> dict[str, np.ndarray]:
    tables = {name: _table(errors) for name, errors in scores.items()}
    return {
        f"{name}{end}": part
        for name, parts in tables.items()
        for end, part in zip(("", "_low", "_high"), parts, strict=True)
    }


def relation_table(found: Mapping[str, np.ndarray | float]) -> str:
    """Return the errors of relative poses, of steps and of loops."""
    head = (
        "                              steps            loops\n"
        "                              m       °        m       °"
    )
    rows = []
    for name in ("odometry", "calibrated", "corrected"):
        rows.append(f"{name:22s} {_cells(found[name])}")
    for name, words in (("blind", "filter, blind"), ("told", "filter, told")):
        for word, part in (("best", np.min), ("median", np.median), ("worst", np.max)):
            rows.append(f"{words + ', ' + word:22s} {_cells(part(found[name], axis=0))}")
    return "\n".join([head, *rows])


def _cells(table: np.ndarray) -> str:
    (near_m, near_deg), (far_m, far_deg) = table
    return f"{near_m:8.2f}{near_deg:8.1f} {far_m:8.1f}{far_deg:8.0f}"


INTEL = Recording("carmen_intel", lambda at: Found(study(at)), Found, store="anchored-intel")
