"""A car among 151 trees: the Victoria Park recording, with known associations, no anchor needed.

The covariances are those of the file: a centimetre and two milliradians per step of half a metre,
0.63 m for each tree. The drive begins at the origin, which is exact by definition.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path
from time import perf_counter

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.datasets import LandmarkGraph, read_fixes, read_landmark_graph, read_vehicle
from robot_perception.datasets.victoria import Fixes, VehicleLog
from robot_perception.evaluation.trajectories import absolute_error, align
from robot_perception.experiments.anchored_slam.mrclam import dead_reckoning
from robot_perception.geometry import transform
from robot_perception.slam.planar import (
    CartesianSensor,
    History,
    MapBelief,
    Odometry,
    Scan,
    Settings,
    Step,
    run_filter,
)
from robot_perception.teaching.recordings import Recording

AXLES, TRACK = 2.83, 0.76
"""Distance of the axles, and of the encoder's wheel from the middle of the car, m."""
BUMPER = 3.78
"""How far the laser is ahead of the rear axle, m: 2.83 + 0.95."""
FASTEST = 10.0
"""Speed in m/s from which two fixes are taken for a jump; the car's encoders say 6.6 at most."""
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
            Scan(graph.landmarks[i:j], graph.values[i:j], graph.value_covs[i:j]),
        )
        for motion, cov, i, j in zip(graph.motions, graph.motion_covs, low, high, strict=True)
    ]


def run_drive(steps: Iterable[Step]) -> History:
    """Run the plain filter from an exact start; every scan brings its own noise."""
    return run_filter(
        MapBelief.start(np.zeros(3), np.zeros((3, 3))), steps, Settings(CartesianSensor(np.eye(2)))
    )


def step_times(steps: list[Step], runs: int = 3) -> Float[np.ndarray, " steps"]:
    """Return how long each step took, s: the least of several runs.

    The filter asks for a step when it is done with the one before.
    """
    times = np.empty((runs, len(steps)))
    for run in range(runs):
        asked: list[float] = []
        run_drive(_asked(steps, asked))
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
        In the frame of the fixes: ``path``, ``dead``, ``fixes`` (thinned), ``trees``,
        ``tree_covs`` (m²). ``ate`` and ``typical`` (root mean square and median distance from the
        fixes after alignment, m), ``ate_laser`` (of the laser's place), ``ate_dead``; counts
        ``steps``, ``sightings``, ``landmarks``, ``fix_count``, ``jumped``, ``length`` (m), ``nis``
        (over its degrees of freedom). ``sizes`` and, for steps that saw a tree and that saw none,
        ``microseconds`` (median, two rows), ``exponent`` (of the first row against size).
    """
    graph = read_landmark_graph(folder / "victoria_park_graph.txt.gz")
    car, fixes = read_vehicle(folder / "aa3_dr.mat"), read_fixes(folder / "aa3_gpsx.mat")
    steps = make_steps(graph)
    history = run_drive(steps)
    start = np.zeros((1, 3))
    poses, dead = np.concatenate([start, history.poses]), dead_reckoning(np.zeros(3), steps)
    there, covered = positions_at_fixes(poses, graph, car, fixes)
    jumped = jumps(fixes)
    good = covered & ~jumped
    truth, there = fixes.positions[good], there[good]
    frame = align(there, truth)
    apart = transform(frame, there[:, :2]) - truth
    laser = there[:, :2] + BUMPER * np.stack([np.cos(there[:, 2]), np.sin(there[:, 2])], axis=1)
    by_wheels = positions_at_fixes(dead, graph, car, fixes)[0][good]
    sizes, microseconds = _times_by_size(steps, history)
    turn = np.array([[np.cos(frame[2]), -np.sin(frame[2])], [np.sin(frame[2]), np.cos(frame[2])]])
    trees = history.belief.landmarks
    slots = 3 + 2 * np.arange(len(trees))[:, None] + np.arange(2)
    covs = history.belief.cov[slots[:, :, None], slots[:, None, :]]
    thin = slice(None, None, len(poses) // DRAWN)
    return {
        "path": np.round(transform(frame, poses[thin, :2]), 1),
        "dead": np.round(transform(align(by_wheels, truth), dead[thin, :2]), 1),
        "fixes": np.round(truth[:: len(truth) // DRAWN], 1),
        "trees": np.round(transform(frame, trees), 2),
        "tree_covs": turn @ covs @ turn.T,
        "ate": float(np.sqrt(np.mean(np.sum(apart**2, axis=1)))),
        "typical": float(np.median(np.hypot(*apart.T))),
        "ate_laser": absolute_error(laser, truth, aligned=True),
        "ate_dead": absolute_error(by_wheels, truth, aligned=True),
        "steps": len(steps),
        "sightings": len(graph.values),
        "landmarks": len(trees),
        "fix_count": int(good.sum()),
        "jumped": int(np.count_nonzero(jumped & covered)),
        "length": float(np.hypot(*graph.motions[:, :2].T).sum()),
        "nis": float(history.nis.sum() / history.dof.sum()),
        "sizes": sizes,
        "microseconds": microseconds,
        "exponent": float(np.polyfit(np.log(sizes), np.log(microseconds[0]), 1)[0]),
    }


def _times_by_size(steps: list[Step], history: History) -> tuple[np.ndarray, np.ndarray]:
    """Return mean map sizes, and median times in µs of steps that saw a tree and that saw none."""
    times, saw = 1e6 * step_times(steps), np.array([step.scan.ids.size > 0 for step in steps])
    place = np.digitize(history.sizes, SIZES)
    bins = np.unique(place)
    sizes = np.array([history.sizes[place == i].mean() for i in bins])
    medians = [[np.median(times[(place == i) & which]) for i in bins] for which in (saw, ~saw)]
    return np.round(sizes, 1), np.round(medians, 1)


VICTORIA = Recording("victoria_park", study, store="anchored-victoria")
