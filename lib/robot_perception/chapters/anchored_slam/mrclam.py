"""Five robots against motion capture: the UTIAS recordings, nine data sets of one room.

The book's is data set 6, whose files are pinned in the registry of recordings; :func:`robots`
computes any other that a reader has. What the filter is told of a robot's wheels and camera is
estimated from the other four robots, for whom motion capture is taken to be known; the robot's own
motion capture only starts it and judges it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception.checks import whole
from robot_perception.datasets import DatasetMissing, UnknownDataset, read_mrclam
from robot_perception.datasets.entries import DATA_VARIABLE
from robot_perception.datasets.mrclam import MrclamRobot, SurveyedLandmarks
from robot_perception.evaluation.consistency import normalised_squared
from robot_perception.evaluation.intervals import mean
from robot_perception.evaluation.sweep import sweep
from robot_perception.evaluation.trajectories import absolute_error
from robot_perception.gating import chi_squared_quantile
from robot_perception.geometry import wrap_angle
from robot_perception.slam import planar
from robot_perception.slam.planar import Association, History, MapBelief, RangeBearing
from robot_perception.slam.planar.calibration import (
    GAP,
    Calibration,
    calibrate,
    is_right,
    make_steps,
    pooled,
    sighting_errors,
)
from robot_perception.teaching.recordings import Read, Recording
from robot_perception.teaching.tables import Table

DELAYS = np.arange(0.0, 0.51, 0.05)
"""Delays of the wheels that are tried, s."""
START = np.diag([0.001, 0.001, 0.005]) ** 2
"""Covariance of the start pose, from motion capture; ours."""
LEVEL = 0.9999
"""Probability that a right sighting passes the gate of its barcode, if the filter is right."""
PATIENCE = 5
"""Sightings of one post that a gate that gives in rejects in a row at most."""
SAMPLES = 160
"""Times of each drive at which paths and errors are kept."""
ANCHORS = ("no anchor", "one anchor", "two anchors")
METHODS = {
    "white": "barcodes, errors taken as fresh",
    "lasting": "barcodes, errors that last",
    "ungated": "the same without a gate",
    "patient": "the same with a gate that gives in",
    "first": "errors that last, first estimates",
    "unbiased": "errors that last, less the bias",
    "nearest": "nearest neighbour",
    "joint": "joint compatibility",
}
COLUMNS = {
    "no (m)": "error with no, one and two anchors, root mean square over the drive",
    "one (m)": "",
    "two (m)": "",
    "no, inside": "share of the poses in their 95 % region",
    "one, inside": "",
    "two, inside": "",
}


@dataclass(frozen=True, eq=False, slots=True)
class Drive:
    """What the filter gets of one robot, a step for each image, and what it is judged by.

    Of the start and of the images: times (s on the log's clock), and poses by motion capture, NaN
    where not covered. ``rows`` are the sightings in the steps, by their place in the log.
    """

    steps: tuple[planar.Step, ...]
    rows: Int[np.ndarray, " sightings"]
    times: Float[np.ndarray, " moments"]
    truth: Float[np.ndarray, "moments 3"]
    covered: Bool[np.ndarray, " moments"]


@dataclass(frozen=True, eq=False, slots=True)
class Judged:
    """A run beside motion capture: the NEES of the covered poses, and one number of each score."""

    history: History
    nees: Float[np.ndarray, " covered"]
    scores: Mapping[str, float]


@dataclass(frozen=True, eq=False, slots=True)
class Scores:
    """What one method makes of the drive of each robot without anchor, with one and two.

    Error over the covered poses as it stands and after alignment (m), share ``inside`` the 95 %
    region of the covariance, NIS over its degrees of freedom. The gate ``rejected`` sightings, of
    which motion capture says that so many were ``right``: the barcode can be the one that was read.
    The ``longest`` stretch is of sightings in a row, all rejected.
    """

    ate: Float[np.ndarray, "robots anchors"]
    ate_aligned: Float[np.ndarray, "robots anchors"]
    inside: Float[np.ndarray, "robots anchors"]
    nis: Float[np.ndarray, "robots anchors"]
    rejected: Int[np.ndarray, "robots anchors"]
    right: Int[np.ndarray, "robots anchors"]
    longest: Int[np.ndarray, "robots anchors"]

    @property
    def cells(self) -> Float[np.ndarray, "robots 6"]:
        """What stands in a table under `COLUMNS`."""
        return np.hstack([self.ate, self.inside])


@dataclass(frozen=True, eq=False, slots=True)
class Robot:
    """One robot: its sensors, and its drive by ``lasting`` at some covered times, s from its start.

    ``dead`` is the path by the wheels alone. ``errors`` and their deviations ``sigmas`` are of
    position (m) and heading (rad). ``marks`` is the map in the order of the survey, an anchor where
    it is known to be, NaN where never seen; ``anchors`` are the places of the two. ``unknown``
    sightings are of no post. ``own`` is the mean square of the errors of the robot's own right
    sightings over the variance that the filter is told of one, ``inflation`` that of lasting
    errors; both are pairs, of range and bearing.
    """

    sensors: Calibration
    unknown: int
    own: Float[np.ndarray, "2"]
    inflation: Float[np.ndarray, "2"]
    times: Float[np.ndarray, " times"]
    truth: Float[np.ndarray, "times 2"]
    dead: Float[np.ndarray, "times 2"]
    paths: Float[np.ndarray, "anchors times 2"]
    errors: Float[np.ndarray, "anchors times 2"]
    sigmas: Float[np.ndarray, "anchors times 2"]
    nees: Float[np.ndarray, "anchors times"]
    marks: Float[np.ndarray, "anchors landmarks 2"]
    mark_covs: Float[np.ndarray, "anchors landmarks 2 2"]
    anchors: Float[np.ndarray, "2 2"]


@dataclass(frozen=True, eq=False, slots=True)
class Robots:
    """The robots by number, the error of each by its wheels alone (m), and those by `METHODS`."""

    landmarks: Float[np.ndarray, "landmarks 2"]
    robots: Mapping[int, Robot]
    dead: Float[np.ndarray, " robots"]
    errors: Mapping[str, Scores]

    def sensor_table(self) -> Table:
        """Return what motion capture says of each robot's wheels and camera."""
        columns = {
            "delay (s)": "from command to motion",
            "speed": "true over logged",
            "turn": "true over logged",
            "drag (m/rad)": "way lost in turning",
            "bias (m)": "of the range",
            "σ (m)": "of the range",
            "ρ": "correlation of range errors two seconds apart",
            "bias (°)": "of the bearing",
            "σ (°)": "of the bearing",
            "wrong": "barcodes read as another post's",
            "other": "barcodes of no post",
        }
        rows = {}
        for number, robot in self.robots.items():
            s = robot.sensors
            camera = (s.bias[0], s.sigma[0], s.persistence[0], *np.rad2deg([s.bias[1], s.sigma[1]]))
            rows[str(number)] = (s.delay, *s.scale, s.drag, *camera, s.misread, robot.unknown)
        return Table(rows, columns, corner="robot")

    def robot_table(self) -> Table:
        """Return errors and consistency of the robots by ``lasting``."""
        cells = np.column_stack([self.dead, self.errors["lasting"].cells])
        names = [*map(str, self.robots), "mean"]
        rows = dict(zip(names, [*cells.tolist(), cells.mean(axis=0).tolist()], strict=True))
        columns = {"wheels (m)": "error of the wheels alone"} | COLUMNS
        return Table(rows, columns, METHODS["lasting"], "robot")

    def method_table(self) -> Table:
        """Return the mean over the robots of errors and consistency, by method."""
        means = {m: errors.cells.mean(axis=0).tolist() for m, errors in self.errors.items()}
        rows = {words: means[method] for method, words in METHODS.items()}
        return Table(rows, COLUMNS, "mean of the robots", "method")

    def anchor_table(self) -> Table:
        """Return the error by anchors, and how far what they change carries beyond these robots."""
        ate = self.errors["lasting"].ate
        change = ate - ate[:, :1]
        rows = {
            name: (
                mean(ate[:, k], "m"),
                mean(change[:, k], "m") if k else "–",
                f"{np.count_nonzero(change[:, k] < 0)} of {len(ate)}" if k else "–",
            )
            for k, name in enumerate(ANCHORS)
        }
        columns = {
            "error (m)": "root mean square over the drive, mean of the robots",
            "change (m)": "against no anchor, mean of the robots' differences",
            "better": "robots whose error is smaller than without an anchor",
        }
        about = f"95 % Student interval over {len(ate)} robots of one data set"
        return Table(rows, columns, about, "anchors")

    def gate_table(self) -> Table:
        """Return what the gate rejects without an anchor, and the error with and without it."""
        gate, patient, none = (self.errors[m] for m in ("lasting", "patient", "ungated"))
        columns = {
            "rejected": f"sightings outside a gate of {LEVEL:.2%}",
            "right": "of these, those whose barcode can be the one read",
            "longest": "sightings in a row, all rejected",
            "longest, gives in": f"the same with a gate that rejects {PATIENCE} of a post in a row",
            "gate (m)": "error with the gate, root mean square over the drive",
            "gives in (m)": "with the gate that gives in",
            "none (m)": "without a gate",
        }
        counts = (gate.rejected, gate.right, gate.longest, patient.longest)
        parts = (*counts, gate.ate, patient.ate, none.ate)
        cells = zip(*(part[:, 0].tolist() for part in parts), strict=True)
        rows = dict(zip(map(str, self.robots), cells, strict=True))
        return Table(rows, columns, ANCHORS[0], "robot")

    def innovation_table(self) -> Table:
        """Return why innovations are smaller than the filter expects, mean of the robots."""
        robots = self.robots.values()
        own = {
            "white": np.mean([robot.own for robot in robots]),
            "lasting": np.mean([robot.own / robot.inflation for robot in robots]),
        }
        rows = {METHODS[m]: (own[m], self.errors[m].nis[:, 0].mean()) for m in own}
        columns = {
            "sightings": "their squared errors by motion capture, over the variance told",
            "NIS": "squared innovations over the variance expected, no anchor; 1 if right",
        }
        return Table(rows, columns, "mean of the robots, and of range and bearing", "noise told")


def measure_sensors(robot: MrclamRobot, landmarks: SurveyedLandmarks) -> Calibration:
    """Compare the wheels and the camera of a robot with motion capture."""
    wheels, seen, places = robot.commands, robot.landmarks, _places(landmarks)
    log = wheels.times, wheels.velocities, seen.times, seen.subjects, seen.values
    return calibrate(*log, places=places, truth=robot.truth, delays=DELAYS)


def camera_errors(
    robot: MrclamRobot, landmarks: SurveyedLandmarks
) -> Float[np.ndarray, "sightings 2"]:
    """Return the errors of ranges (m) and bearings (rad) by motion capture, NaN where it is not."""
    seen, places = robot.landmarks, _places(landmarks)
    return sighting_errors(seen.times, seen.subjects, seen.values, places=places, truth=robot.truth)


def _places(landmarks: SurveyedLandmarks) -> dict[int, np.ndarray]:
    return dict(zip(landmarks.ids.tolist(), landmarks.positions, strict=True))


def make_drive(robot: MrclamRobot, sensors: Calibration, *, pause: float = 0.0) -> Drive:
    """Return the steps of a robot, one for each image at least ``pause`` seconds after the last.

    The drive lasts from the first command to the last, each moved by the delay of the wheels, but
    begins no sooner than motion capture.
    """
    seen, logged = robot.landmarks, robot.commands
    begun = logged.times + sensors.delay >= robot.truth.times[0]
    log = logged.times[begun], logged.velocities[begun], seen.times, seen.subjects, seen.values
    steps, merged = make_steps(sensors, *log, pause=pause)
    places = np.concatenate([np.arange(rows.start, rows.stop) for rows in merged.rows])
    return Drive(steps, places, merged.times, *robot.truth.at(merged.times, longest_gap=GAP))


def choose_anchors(drive: Drive, landmarks: SurveyedLandmarks) -> list[dict[int, np.ndarray]]:
    """Return no anchor; the landmark seen first, as in the paper; and that and the one farthest."""
    places = _places(landmarks)
    first = int(drive.steps[0].observations.ids[0])
    far = max(places, key=lambda name: float(np.hypot(*(places[name] - places[first]))))
    return [{name: places[name] for name in names} for names in ((), (first,), (first, far))]


def judge(history: History, drive: Drive, right: Bool[np.ndarray, " sightings"]) -> Judged:
    """Compare a run with motion capture, which says which sightings are right."""
    seen = drive.covered[1:]
    poses, truth = history.poses[seen], drive.truth[1:][seen]
    errors = poses - truth
    errors[:, 2] = wrap_angle(errors[:, 2])
    nees = normalised_squared(errors, history.pose_covs[seen])
    rejected = np.concatenate(history.used) == -1
    edges = np.flatnonzero(np.diff(rejected, prepend=False, append=False))
    scores = {
        "ate": absolute_error(poses, truth, aligned=False),
        "ate_aligned": absolute_error(poses, truth, aligned=True),
        "inside": float(np.mean(nees <= chi_squared_quantile(0.95, 3))),
        "nis": float(history.nis.sum() / history.dof.sum()),
        "rejected": int(rejected.sum()),
        "right": int((rejected & right[drive.rows]).sum()),
        "longest": int((edges[1::2] - edges[::2]).max(initial=0)),
    }
    return Judged(history, nees, scores)


def run_robot(
    robot: MrclamRobot, landmarks: SurveyedLandmarks, own: Calibration, told: Calibration
) -> tuple[Drive, dict[str, list[Judged]]]:
    """Run the filter over a drive by each of the `METHODS`, with no, one and two anchors.

    The filter is told of other sensors than the robot's own, which say what is right. Lasting
    errors are told as noise multiplied by `Calibration.inflation`; without barcodes there is one
    image a second. Known barcodes pass a gate, for the camera takes one landmark for another now
    and then.
    """
    drive, sparse = make_drive(robot, told), make_drive(robot, told, pause=1.0)
    nameless = (replace(s, observations=s.observations.anonymous()) for s in sparse.steps)
    sparse = replace(sparse, steps=tuple(nameless))
    many = np.diag(told.sigma**2 * told.inflation)
    fresh, lasting = RangeBearing(np.diag(told.sigma**2)), RangeBearing(many)
    known, patient = (Association("known", LEVEL, patience=most) for most in (None, PATIENCE))
    ways = {
        "white": (drive, fresh, known, "latest"),
        "lasting": (drive, lasting, known, "latest"),
        "ungated": (drive, lasting, Association("known"), "latest"),
        "patient": (drive, lasting, patient, "latest"),
        "first": (drive, lasting, known, "first"),
        "unbiased": (drive, RangeBearing(many, float(own.bias[0])), known, "latest"),
        "nearest": (sparse, fresh, "gated", "latest"),
        "joint": (sparse, fresh, "joint", "latest"),
    }
    start, chosen = MapBelief.start(drive.truth[0], START), choose_anchors(drive, landmarks)
    right = is_right(camera_errors(robot, landmarks), own.bias)
    found = {}
    for method, (way, sensor, *how) in ways.items():
        settings = [planar.Settings(sensor, anchors, *how) for anchors in chosen]
        runs = (planar.run_filter(start, way.steps, s) for s in settings)
        found[method] = [judge(run, way, right) for run in runs]
    return drive, found


def study(folder: Path) -> Robots:
    """Run all robots, each with the sensors of the others."""
    data = read_mrclam(folder)
    sensors = {n: measure_sensors(robot, data.landmarks) for n, robot in data.robots.items()}
    one = partial(_robot, landmarks=data.landmarks, sensors=sensors)
    runs = sweep(one, data.robots.items(), rng=np.random.default_rng(0), desc="robots")
    robots, dead, scores = zip(*runs, strict=True)
    robots, errors = dict(zip(data.robots, robots, strict=True)), {}
    for method in METHODS:
        runs = [one[method] for one in scores]
        parts = (np.array([[run[f.name] for run in one] for one in runs]) for f in fields(Scores))
        errors[method] = Scores(*parts)
    return Robots(data.landmarks.positions, robots, np.array(dead), errors)


def _robot(
    item: tuple[int, MrclamRobot],
    *,
    landmarks: SurveyedLandmarks,
    sensors: Mapping[int, Calibration],
    rng: np.random.Generator,
) -> tuple[Robot, float, dict[str, list[Mapping[str, float]]]]:
    """Return a robot, the error of its wheels, and its scores by method and number of anchors."""
    number, robot = item
    own, told = sensors[number], pooled(s for n, s in sensors.items() if n != number)
    drive, found = run_robot(robot, landmarks, own, told)
    wrong = camera_errors(robot, landmarks)
    wrong = wrong[is_right(wrong, own.bias)]
    seen = np.flatnonzero(drive.covered[1:])
    kept = np.linspace(0, len(seen) - 1, SAMPLES).astype(int)
    rows, truth = seen[kept], drive.truth[1:][seen[kept]]
    dead = planar.dead_reckoning(drive.truth[0], (step.motion for step in drive.steps))
    runs, chosen = found["lasting"], choose_anchors(drive, landmarks)
    poses = np.array([run.history.poses[rows] for run in runs])
    covs = np.array([run.history.pose_covs[rows] for run in runs])
    apart = poses - truth
    spread = np.sqrt(np.trace(covs[..., :2, :2], axis1=-2, axis2=-1))
    maps = [_map(r.history.belief, a, landmarks) for r, a in zip(runs, chosen, strict=True)]
    shown = Robot(
        own,
        sum(robot.unknown.values()),
        (wrong**2).mean(axis=0) / told.sigma**2,
        told.inflation,
        drive.times[1:][rows] - drive.times[0],
        truth[:, :2],
        dead[1:][rows, :2],
        poses[..., :2],
        np.stack([np.hypot(apart[..., 0], apart[..., 1]), wrap_angle(apart[..., 2])], axis=-1),
        np.stack([spread, np.sqrt(covs[..., 2, 2])], axis=-1),
        np.array([run.nees[kept] for run in runs]),
        *(np.array(part) for part in zip(*maps, strict=True)),
        np.array(list(chosen[-1].values())),
    )
    off = absolute_error(dead[drive.covered], drive.truth[drive.covered], aligned=False)
    return shown, off, {method: [run.scores for run in runs] for method, runs in found.items()}


def _map(
    belief: MapBelief, anchors: Mapping[int, np.ndarray], landmarks: SurveyedLandmarks
) -> tuple[np.ndarray, np.ndarray]:
    """Return landmarks and covariances, NaN if never seen; anchors stand where they are known."""
    points, covs = (np.full((len(landmarks.ids), *shape), np.nan) for shape in ((2,), (2, 2)))
    mapped, known = (np.searchsorted(landmarks.ids, ids) for ids in (belief.ids, list(anchors)))
    points[mapped], covs[mapped] = belief.landmarks, belief.landmark_covs
    points[known], covs[known] = landmarks.positions[known], 0.0
    return points, covs


UTIAS = Recording("utias_mrclam_6", study, Robots, store="anchored-utias")
"""The book's data set; its result is stored."""


def robots(data_set: int = 6) -> Read[Robots]:
    """Return the study of one of the nine data sets of the collection.

    Data set 6 is computed from the recording or read from storage, any other from the reader's
    files: ``utias_mrclam_7`` in the directory that ``ROBOT_PERCEPTION_DATA`` names holds the files
    of ``MRCLAM_Dataset7``, plain or gzip. The message of `DatasetMissing` says how to get it.
    """
    whole("data_set", data_set, 1, 9)
    name = f"utias_mrclam_{data_set}"
    if name == UTIAS.dataset:
        return UTIAS.read()
    try:
        return Recording(name, study, Robots, store=name).read()
    except (UnknownDataset, FileNotFoundError) as error:
        raise DatasetMissing(
            f"{name} is not on this computer: put the files of MRCLAM_Dataset{data_set} into a "
            f"folder {name} of the directory that {DATA_VARIABLE} names "
            f"(asrl.utias.utoronto.ca/datasets/mrclam has them); only {UTIAS.dataset} is stored"
        ) from error
