"""A car among 151 trees: the Victoria Park recording, with known associations.

The covariances are those of the file: a centimetre and two milliradians per step of half a metre,
0.63 m for each tree. The drive begins at the origin, exact by definition; the heading is observed
by nothing else. Beside the filter with Jacobians at the latest and at the first estimates stands
the batch optimum, for which all measurements are linearised anew until nothing moves.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.datasets import LandmarkGraph, read_fixes, read_landmark_graph, read_vehicle
from robot_perception.datasets.victoria import Fixes, VehicleLog
from robot_perception.evaluation.consistency import normalised_squared
from robot_perception.evaluation.trajectories import absolute_error, align
from robot_perception.geometry import act, rotation
from robot_perception.slam import planar
from robot_perception.slam.planar import History, Step
from robot_perception.teaching.recordings import Recording
from robot_perception.teaching.tables import Table

AXLES, TRACK = 2.83, 0.76
"""Distance of the axles, and of the encoder's wheel from the middle of the car, m."""
FASTEST = 10.0
"""Speed in m/s from which two fixes are taken for a jump; the car's encoders say 6.6 at most."""
LINEARISATIONS = ("latest", "first")
SENSOR = planar.CartesianSensor(np.eye(2))
"""The trees as points; each observation brings its own covariance."""
SIZES = np.arange(0, 161, 20)
"""Edges of the map sizes whose times per step are given."""
DRAWN = 500
"""Points of a path that are kept."""


@dataclass(frozen=True, eq=False, slots=True)
class Filtered:
    """The drive by one linearisation, in the frame of the fixes (m).

    ``ate`` is the distance of the rear axle from the fixes, root mean square after the best rigid
    motion of this path; ``nis`` is over its degrees of freedom. The trees are ``apart`` from those
    of the batch optimum (root mean square, m), have the ``stated`` deviation (the same), and the
    median of their ``squared`` distances over their stated covariances is 1.4 if the filter is
    right.
    """

    path: Float[np.ndarray, "points 2"]
    trees: Float[np.ndarray, "trees 2"]
    tree_covs: Float[np.ndarray, "trees 2 2"]
    ate: float
    nis: float
    apart: float
    stated: float
    squared: float


@dataclass(frozen=True, eq=False, slots=True)
class Park:
    """The drive by both `LINEARISATIONS`, in the frame into which the second path fits best.

    Of the batch optimum: its trees (m), its error as that of a filter, and its ``fit``, the sum of
    squares over its degrees of freedom, 1 if the file's covariances are right. ``ate_dead`` is the
    error of the wheels alone, m. The two maps are ``apart`` (root mean square, m), and the first
    must be ``turned`` (°) to fit the second. ``microseconds`` are the median times of steps that
    saw a tree and of steps that saw none, by the mean ``sizes`` of the map.
    """

    runs: Mapping[str, Filtered]
    trees: Float[np.ndarray, "trees 2"]
    ate: float
    fit: float
    fixes: Float[np.ndarray, "fixes 2"]
    ate_dead: float
    apart: float
    turned: float
    steps: int
    sightings: int
    length: float
    sizes: Float[np.ndarray, " sizes"]
    microseconds: Float[np.ndarray, "2 sizes"]

    def batch_table(self) -> Table:
        """Return the maps of both filters beside the batch optimum."""
        rows = {
            f"Jacobians at the {name} estimates": (run.apart, run.stated, run.squared, run.ate)
            for name, run in self.runs.items()
        }
        columns = {
            "apart (m)": "trees from those of the batch optimum, root mean square",
            "stated (m)": "deviation that the filter states for its trees, root mean square",
            "squared": "distance of a tree over its stated covariance, median; 1.4 if right",
            "fixes (m)": "path from the satellite fixes, root mean square after alignment",
        }
        about = f"the optimum itself is {self.ate:.1f} m from the fixes"
        return Table(rows, columns, about, "filter")


def make_steps(graph: LandmarkGraph) -> list[Step]:
    """Return the steps of the drive."""
    if graph.observers.size and graph.observers[0] == 0:  # no step has room for it
        raise ValueError("a landmark was seen before the first motion")
    poses = np.arange(1, len(graph.motions) + 1)
    low, high = (np.searchsorted(graph.observers, poses, side=side) for side in ("left", "right"))
    return [
        Step(
            planar.Odometry(motion, cov),
            planar.Observations(graph.landmarks[i:j], graph.values[i:j], graph.value_covs[i:j]),
        )
        for motion, cov, i, j in zip(graph.motions, graph.motion_covs, low, high, strict=True)
    ]


def run_drive(steps: Iterable[Step], linearisation: Literal["latest", "first"]) -> History:
    """Run the filter from an exact start; every scan brings its own noise."""
    settings = planar.Settings(SENSOR, linearisation=linearisation)
    start = planar.MapBelief.start(np.zeros(3), np.zeros((3, 3)))
    return planar.run_filter(start, steps, settings)


def step_times(steps: list[Step], runs: int = 3) -> Float[np.ndarray, " steps"]:
    """Return how long each step took, s: the least of several runs.

    The filter asks for a step when it is done with the one before.
    """
    asked = np.empty((runs, len(steps) + 1))

    def noted(row: np.ndarray) -> Iterator[Step]:
        for i, step in enumerate(steps):
            row[i] = perf_counter()
            yield step
        row[-1] = perf_counter()

    for row in asked:
        run_drive(noted(row), "latest")
    return np.diff(asked).min(axis=0)


def positions_at_fixes(
    poses: Float[np.ndarray, "poses 3"], graph: LandmarkGraph, car: VehicleLog, fixes: Fixes
) -> tuple[Float[np.ndarray, "fixes 3"], Bool[np.ndarray, " fixes"]]:
    """Return poses of the drive at the times of the satellite fixes, and which are covered.

    The graph has no times. But its motions were computed from the car's log, so that the way
    travelled, which both know, tells the time.
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
    return np.append(False, speed > FASTEST)


def study(folder: Path) -> Park:
    """Run the filter over the drive by both `LINEARISATIONS`."""
    graph = read_landmark_graph(folder / "victoria_park_graph.txt.gz")
    car, fixes = read_vehicle(folder / "aa3_dr.mat"), read_fixes(folder / "aa3_gpsx.mat")
    steps = make_steps(graph)
    runs = {name: run_drive(steps, name) for name in LINEARISATIONS}
    best = planar.smooth(steps, runs["first"], SENSOR)
    dead = planar.dead_reckoning(np.zeros(3), (step.motion for step in steps))
    good = positions_at_fixes(dead, graph, car, fixes)[1] & ~jumps(fixes)
    truth = fixes.positions[good]

    def there(path: np.ndarray) -> np.ndarray:
        return positions_at_fixes(path, graph, car, fixes)[0][good]

    frame = align(there(runs["first"].path), truth)
    turn, thin = rotation(frame[2]), slice(None, None, len(dead) // DRAWN)

    def beside_optimum(run: History) -> Filtered:
        trees, covs = run.belief.landmarks, run.belief.landmark_covs
        return Filtered(
            act(frame, run.path[thin, :2]),
            act(frame, trees),
            turn @ covs @ turn.T,
            absolute_error(there(run.path), truth, aligned=True),
            float(run.nis.sum() / run.dof.sum()),
            absolute_error(trees, best.landmarks, aligned=False),
            float(np.sqrt(np.trace(covs, axis1=1, axis2=2).mean())),
            float(np.median(normalised_squared(trees - best.landmarks, covs))),
        )

    maps = [run.belief.landmarks for run in runs.values()]
    return Park(
        {name: beside_optimum(run) for name, run in runs.items()},
        act(frame, best.landmarks),
        absolute_error(there(best.path), truth, aligned=True),
        best.squares / best.dof,
        truth[:: len(truth) // DRAWN],
        absolute_error(there(dead), truth, aligned=True),
        absolute_error(*maps, aligned=False),
        float(np.rad2deg(align(*maps)[2])),
        len(steps),
        len(graph.values),
        float(np.hypot(*graph.motions[:, :2].T).sum()),
        *_times_by_size(steps, runs["latest"]),
    )


def _times_by_size(steps: list[Step], history: History) -> tuple[np.ndarray, np.ndarray]:
    """Return mean map sizes, and median times in µs of steps that saw a tree and that saw none."""
    times, saw = 1e6 * step_times(steps), np.array([len(step.observations) > 0 for step in steps])
    place = np.digitize(history.sizes, SIZES)
    bins = np.unique(place)
    sizes = np.array([history.sizes[place == i].mean() for i in bins])
    medians = [[np.median(times[(place == i) & which]) for i in bins] for which in (saw, ~saw)]
    return sizes, np.array(medians)


VICTORIA = Recording("victoria_park", study, Park, store="anchored-victoria")
