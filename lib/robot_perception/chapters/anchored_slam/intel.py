"""Corners and poles of a real building: the Intel Research Lab with its raw odometry.

The robot turned by 18° on average between two scans, which are 180 beams of one degree. What a scan
calls a corner depends on choices; so the study makes several of each and shows all results. For
comparison every choice is run a second time with the associations told by the corrected poses.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from jaxtyping import Float

from robot_perception.datasets import Relations, read_carmen_log, read_relations
from robot_perception.evaluation import intervals
from robot_perception.evaluation.sweep import sweep
from robot_perception.evaluation.trajectories import motion_errors, relative_poses
from robot_perception.geometry import act
from robot_perception.observations import Observations
from robot_perception.slam import planar
from robot_perception.slam.planar.calibration import calibrate_odometry, name_landmarks
from robot_perception.teaching.recordings import Recording
from robot_perception.teaching.tables import Table
from robot_perception.walls.corners import LandmarkRules, find_landmarks
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
SINGLES = ("odometry", "calibrated", "corrected")
DRAWN = 450


@dataclass(frozen=True, eq=False, slots=True)
class Building:
    """What the filter makes of the building, by path or group of paths.

    ``errors`` of relative poses (root mean square) are by path, kind of relation (steps, loops) and
    unit (m, °): of ``odometry``, ``calibrated`` and ``corrected`` (one path each), ``blind`` and
    ``told`` (a path for each choice of rules, kinds, factor and association). ``ends`` of the 95 %
    intervals are of single paths. ``empty`` is the share of the scans without a landmark, by rules.
    ``ways`` are places of some scans, the first of a group, and ``spots`` the landmarks seen, by
    the corrected poses (m).
    """

    errors: Mapping[str, Float[np.ndarray, "paths 2 2"]]
    ends: Mapping[str, Float[np.ndarray, "2 2 2"]]
    empty: Float[np.ndarray, " rules"]
    ways: Mapping[str, Float[np.ndarray, "places 2"]]
    spots: Float[np.ndarray, "spots 2"]

    def relation_table(self) -> Table:
        """Return the errors of relative poses, of steps and of loops."""
        rows = {name: errors[0] for name, errors in self.errors.items() if name in self.ends}
        for name, kind in product(("blind", "told"), ("best", "median", "worst")):
            part = {"best": np.min, "median": np.median, "worst": np.max}[kind]
            rows[f"filter, {name}, {kind}"] = part(self.errors[name], axis=0)
        columns = {
            "step (m)": "between neighbouring scans",
            "step (°)": "",
            "loop (m)": "between scans on both sides of a loop",
            "loop (°)": "",
        }
        cells = {name: errors.ravel().tolist() for name, errors in rows.items()}
        return Table(cells, columns, "root mean square errors of relative poses", "estimate")


def run_scans(
    item: tuple[Sequence[Observations], planar.Association, float],
    *,
    start: Float[np.ndarray, "3"],
    motions: Sequence[planar.Odometry],
    rng: np.random.Generator,
) -> Float[np.ndarray, "scans 3"]:
    """Return the poses of the filter, one for each scan; the first is given, nothing is drawn."""
    seen, association, factor = item
    steps = [
        planar.Step(motion, Observations(marks.ids, marks.values, factor * marks.covs + FLOOR))
        for motion, marks in zip(motions, seen[1:], strict=True)
    ]
    settings = planar.Settings(planar.CartesianSensor(np.eye(2)), association=association)
    return planar.run_filter(planar.MapBelief.start(start, np.zeros((3, 3))), steps, settings).path


def study(folder: Path) -> Building:
    """Run all choices: blind by both `ASSOCIATIONS`, and told which landmark is which."""
    log = read_carmen_log(folder / "intel_odom_and_corrected.log.gz")
    relations = read_relations(folder / "intel.relations.gz")
    motions, start = calibrate_odometry(log.odometry, log.poses), log.poses[0]
    found = [[find_landmarks(r, log.angles, rules) for r in log.ranges] for rules in RULES]
    items, names = [], []
    for seen, kinds, factor in product(found, KINDS, FACTORS):
        blind = [marks[np.isin(report.kinds, kinds)] for marks, report in seen]
        told = [
            m.named(ids)
            for m, ids in zip(blind, name_landmarks(log.poses, blind, SAME), strict=True)
        ]
        items += [(blind, planar.Association(how), factor) for how in ASSOCIATIONS]
        items.append((told, planar.Association("known", 0.9999), factor))
        names += ["blind"] * len(ASSOCIATIONS) + ["told"]
    task, rng = partial(run_scans, start=start, motions=motions), np.random.default_rng(0)
    singles = (log.odometry, planar.dead_reckoning(start, motions), log.poses)
    paths = {name: [path] for name, path in zip(SINGLES, singles, strict=True)}
    paths |= {"blind": [], "told": []}
    for name, path in zip(names, sweep(task, items, rng=rng, desc="building"), strict=True):
        paths[name].append(path)
    scores = {name: np.array([score(p, relations, log.times) for p in each])
              for name, each in paths.items()}  # fmt: skip
    thin = slice(None, None, len(log.times) // DRAWN)
    spots = [act(p, m.values) for p, (m, _) in zip(log.poses, found[0], strict=True)]
    return Building(
        {name: values[:, 0] for name, values in scores.items()},
        {name: scores[name][0, 1:] for name in SINGLES},
        np.array([np.mean([len(m) == 0 for m, _ in seen]) for seen in found]),
        {name: each[0][thin, :2] for name, each in paths.items() if name != "odometry"},
        np.concatenate(spots),
    )


def score(
    poses: Float[np.ndarray, "scans 3"], relations: Relations, times: Float[np.ndarray, " scans"]
) -> Float[np.ndarray, "3 2 2"]:
    """Return the errors (m, °) of steps and of loops, and the ends of their intervals."""
    rows, scans = relations.match(times)
    near = np.abs(scans[:, 1] - scans[:, 0]) < NEAR
    errors = [
        motion_errors(relative_poses(poses, scans[kind]), relations.planar[rows[kind]])
        for kind in (near, ~near)
    ]
    parts = [[root_mean_square(e.translation), root_mean_square(np.rad2deg(e.rotation))]
             for e in errors]  # fmt: skip
    return np.moveaxis(parts, -1, 0)


def root_mean_square(values: Float[np.ndarray, " n"]) -> Float[np.ndarray, "3"]:
    """Return the root mean square and the ends of its 95 % interval, that of the mean square.

    It takes relations as independent; several loops share a stretch of the way, so that theirs is
    too narrow.
    """
    found = intervals.mean(values**2)
    return np.sqrt(np.maximum([found.estimate, found.low, found.high], 0.0))


INTEL = Recording("carmen_intel", study, Building, store="anchored-intel")
