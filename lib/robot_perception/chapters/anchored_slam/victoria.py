"""A car among 151 trees: the Victoria Park recording, with known associations.

The covariances are those of the file: a centimetre and two milliradians per step of half a metre,
0.63 m for each tree. The drive begins at the origin, which is exact by definition, so that there
is nothing to anchor; but the heading is observed by nothing else. The filter runs twice, with
Jacobians at the latest and at the first estimates.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path
from time import perf_counter
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.chapters.anchored_slam.mrclam import Found
from robot_perception.datasets import LandmarkGraph, read_fixes, read_landmark_graph, read_vehicle
from robot_perception.datasets.victoria import Fixes, VehicleLog
from robot_perception.evaluation.trajectories import absolute_error, align
from robot_perception.geometry import act, compose, rotation
from robot_perception.slam.planar import (
    CartesianSensor,
    History,
    MapBelief,
    Observations,
    Odometry,
    Settings,
    Step,
    dead_reckoning,
    run_filter,
)
from robot_perception.teaching.recordings import Recording

AXLES, TRACK = 2.83, 0.76
"""Distance of the axles, and of the encoder's wheel from the middle of the car, m."""
BUMPER = 3.78
"""How far the laser is ahead of the rear axle, m: 2.83 + 0.95."""
FASTEST = 10.0
"""Speed in m/s from which two fixes are taken for a jump; the car's encoders say 6.6 at most."""
LINEARISATIONS = ("latest", "first")
SIZES = np.arange(0, 161, 20)
"""Edges of the map sizes whose times per step are given."""
DRAWN = 500
"""Points of a path that are stored."""


def make_steps(graph: LandmarkGraph) -> list[Step]:
    """Return the steps of the drive.

    Raises
    ------
    ValueError
        If a landmark was seen before the first motion; no step has room for it.
    """
    if graph.observers.size and graph.observers[0] == 0:
        raise ValueError("a landmark was seen before the first motion")
    poses = np.arange(1, len(graph.motions) + 1)
    low, high = (np.searchsorted(graph.observers, poses, side=side) for side in ("left", "right"))
    return [
        Step(
            Odometry(motion, cov),
            Observations(graph.landmarks[i:j], graph.values[i:j], graph.value_covs[i:j]),
        )
        for motion, cov, i, j in zip(graph.motions, graph.motion_covs, low, high, strict=True)
    ]


def run_drive(steps: Iterable[Step], linearisation: Literal["latest", "first"]) -> History:
    """Run the filter from an exact start; every scan brings its own noise."""
    settings = Settings(CartesianSensor(np.eye(2)), linearisation=linearisation)
    return run_filter(MapBelief.start(np.zeros(3), np.zeros((3, 3))), steps, settings)


def step_times(steps: list[Step], runs: int = 3) -> Float[np.ndarray, " steps"]:
    """Return how long each step took, s: the least of several runs.

    The filter asks for a step when it is done with the one before.
    """
    times = np.empty((runs, len(steps)))
    for run in range(runs):
        asked: list[float] = []
        run_drive(_asked(steps, asked), "latest")
        times[run] = np.diff([*asked, perf_counter()])
    return times.min(axis=0)


def _asked(steps: list[Step], asked: list[float]) -> Iterator[Step]:
    """Yield the steps and note when each was asked for."""
    for step in steps:
        asked.append(perf_counter())
        yield step


def positions_at_fixes(
    poses: Float[np.ndarray, "poses 3"], graph: LandmarkGraph, car: VehicleLog, fixes: Fixes
) -> tuple[Float[np.ndarray, "fixes 3"], Bool[np.ndarray, " fixes"]]:
    """Return poses of the drive at the times of the satellite fixes, and which are covered.

    The graph has no times. But its motions were computed from the car's log, so that the way
    travelled, which both know, tells the time.

    Parameters
    ----------
    poses
        One for each pose of the graph.
    graph
        The drive.
    car
        The car's log.
    fixes
        Times and positions.
    """
    speed = car.speeds / (1 - np.tan(car.steerings) * TRACK / AXLES)  # in the middle of the axle
    logged = np.concatenate([[0], np.cumsum(np.abs(speed[:-1]) * np.diff(car.times))])
    driven = np.concatenate([[0], np.cumsum(np.hypot(*graph.motions[:, :2].T))])
    way = np.interp(fixes.times, car.times, logged)
    covered = (fixes.times >= car.times[0]) & (fixes.times <= car.times[-1]) & (way <= driven[-1])
    x, y, heading = poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2])
    return np.stack([np.interp(way, driven, part) for part in (x, y, heading)], axis=1), covered


def jumps(fixes: Fixes) -> Bool[np.ndarray, " fixes"]:
    """Tell which fixes begin with a jump that the car cannot have made."""
    speed = np.hypot(*np.diff(fixes.positions, axis=0).T) / np.diff(fixes.times)
    return np.concatenate([[False], speed > FASTEST])


def study(folder: Path) -> dict[str, np.ndarray | float]:
    """Run the filter over the drive, and return what the chapter shows of it.

    Returns
    -------
    dict
        Pairs of values are of the two `LINEARISATIONS`. In the frame of the fixes, into which the
        second filter's path was fitted, and the others with it: ``paths`` (2, …), ``dead``,
        ``fixes`` (thinned), ``trees`` (2, …), ``tree_covs`` (2, …, m²). ``ate``, ``ate_laser``
        (2,): root mean square distance from the fixes, each path aligned by itself, of the rear
        axle and of the laser's place, m; ``ate_dead``; ``nis`` (2,) over its degrees of freedom.
        ``apart``: root mean square distance of the two maps, m; ``turned``: by which angle the
        first must be turned to fit the second, °. Counts ``steps``, ``sightings``, ``landmarks``,
        ``fix_count``, ``jumped``, and ``length`` (m). ``sizes`` and, for steps that saw a tree and
        that saw none, ``microseconds`` (median, two rows), ``exponent`` (of the first row against
        size).
    """
    graph = read_landmark_graph(folder / "victoria_park_graph.txt.gz")
    car, fixes = read_vehicle(folder / "aa3_dr.mat"), read_fixes(folder / "aa3_gpsx.mat")
    steps = make_steps(graph)
    runs = [run_drive(steps, linearisation) for linearisation in LINEARISATIONS]
    paths = [run.path for run in runs]
    paths.append(dead_reckoning(np.zeros(3), (step.motion for step in steps)))
    jumped = jumps(fixes)
    covered = positions_at_fixes(paths[0], graph, car, fixes)[1]
    good = covered & ~jumped
    truth = fixes.positions[good]
    there = [positions_at_fixes(path, graph, car, fixes)[0][good] for path in paths]
    frame = align(there[1], truth)
    latest, first = (run.belief.landmarks for run in runs)
    sizes, microseconds = _times_by_size(steps, runs[0])
    thin = slice(None, None, len(paths[0]) // DRAWN)
    return {
        "paths": np.round([act(frame, path[thin, :2]) for path in paths[:2]], 1),
        "dead": np.round(act(frame, paths[2][thin, :2]), 1),
        "fixes": np.round(truth[:: len(truth) // DRAWN], 1),
        "trees": np.round([act(frame, latest), act(frame, first)], 2),
        "tree_covs": np.array([_tree_covs(run, frame[2]) for run in runs]),
        "ate": np.array([absolute_error(path, truth, aligned=True) for path in there[:2]]),
        "ate_laser": np.array(
            [absolute_error(_laser(path), truth, aligned=True) for path in there[:2]]
        ),
        "ate_dead": absolute_error(there[2], truth, aligned=True),
        "nis": np.array([run.nis.sum() / run.dof.sum() for run in runs]),
        "apart": absolute_error(latest, first, aligned=False),
        "turned": float(np.rad2deg(align(latest, first)[2])),
        "steps": len(steps),
        "sightings": len(graph.values),
        "landmarks": len(first),
        "fix_count": int(good.sum()),
        "jumped": int(np.count_nonzero(jumped & covered)),
        "length": float(np.hypot(*graph.motions[:, :2].T).sum()),
        "sizes": sizes,
        "microseconds": microseconds,
        "exponent": float(np.polyfit(np.log(sizes), np.log(microseconds[0]), 1)[0]),
    }


def _laser(poses: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "k 2"]:
    """Return where the laser is."""
    return compose(poses, np.array([BUMPER, 0.0, 0.0]))[:, :2]


def _tree_covs(history: History, angle: float) -> Float[np.ndarray, "n 2 2"]:
    """Return the covariances of the landmarks, turned by an angle."""
    return rotation(angle) @ history.belief.landmark_covs @ rotation(angle).T


def _times_by_size(steps: list[Step], history: History) -> tuple[np.ndarray, np.ndarray]:
    """Return mean map sizes, and median times in µs of steps that saw a tree and that saw none."""
    times, saw = 1e6 * step_times(steps), np.array([len(step.observations) > 0 for step in steps])
    place = np.digitize(history.sizes, SIZES)
    bins = np.unique(place)
    sizes = np.array([history.sizes[place == i].mean() for i in bins])
    medians = [[np.median(times[(place == i) & which]) for i in bins] for which in (saw, ~saw)]
    return np.round(sizes, 1), np.round(medians, 1)


VICTORIA = Recording("victoria_park", lambda at: Found(study(at)), Found, store="anchored-victoria")
