"""The UTIAS multi-robot recordings: wheels, barcodes seen by camera, and motion-capture truth."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception.datasets import limits
from robot_perception.datasets.commands import Commands
from robot_perception.datasets.limits import Check
from robot_perception.datasets.logs import (
    CorruptLog,
    ReadReport,
    as_path,
    in_seconds,
    read_table,
    repeats,
)
from robot_perception.datasets.tracks import Track

ROBOTS = (1, 2, 3, 4, 5)


@dataclass(frozen=True, eq=False, slots=True)
class SurveyedLandmarks:
    """Landmarks at positions measured by motion capture.

    Parameters
    ----------
    ids : (n,)
        Subject numbers, rising.
    positions : (n, 2)
        x, y in m.
    sigmas : (n, 2)
        Stated standard deviations of x and y, m.
    """

    ids: Int[np.ndarray, " n"]
    positions: Float[np.ndarray, "n 2"]
    sigmas: Float[np.ndarray, "n 2"]


@dataclass(frozen=True, eq=False, slots=True)
class Sightings:
    """Subjects seen by a robot's camera; several may share one image and its time.

    Parameters
    ----------
    times : (m,)
        s, never falling.
    subjects : (m,)
        Who was seen.
    values : (m, 2)
        Range in m and bearing in rad, counter-clockwise from straight ahead.
    """

    times: Float[np.ndarray, " m"]
    subjects: Int[np.ndarray, " m"]
    values: Float[np.ndarray, "m 2"]


@dataclass(frozen=True, eq=False, slots=True)
class MrclamRobot:
    """Log of one robot, and its true path.

    Parameters
    ----------
    commands
        Its wheels.
    landmarks
        Landmarks it saw.
    robots
        Other robots it saw.
    unknown
        How often each barcode that belongs to no subject was read; those sightings are left out.
    truth
        Its path by motion capture.
    """

    commands: Commands
    landmarks: Sightings
    robots: Sightings
    unknown: Mapping[int, int]
    truth: Track


@dataclass(frozen=True, eq=False, slots=True)
class Mrclam:
    """One data set of the UTIAS multi-robot collection.

    Parameters
    ----------
    landmarks
        Where the landmarks are.
    robots
        The robots by number.
    reports
        What became of every line of every file.
    """

    landmarks: SurveyedLandmarks
    robots: Mapping[int, MrclamRobot]
    reports: tuple[ReadReport, ...]


def read_mrclam(folder: str | Path, *, time_unit: str = "s") -> Mrclam:
    """Read a data set of the UTIAS multi-robot collection, its files plain or gzip.

    The files are ``Barcodes.dat`` (subject, barcode), ``Landmark_Groundtruth.dat`` (subject x y σx
    σy) and for each of five robots ``RobotN_Odometry.dat`` (time v ω), ``RobotN_Measurement.dat``
    (time barcode range bearing) and ``RobotN_Groundtruth.dat`` (time x y heading). Barcodes of no
    known subject are counted (``unknown``); they are misreadings of the camera, not bad lines.

    Parameters
    ----------
    folder
        Where the files are.
    time_unit
        What they count time in: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``.

    Raises
    ------
    CorruptLog
        If a file is empty, damaged or not what its name says; at the first line that cannot be
        read, goes back in time or has numbers in another unit.
    FileNotFoundError
        If a file is missing.

    References
    ----------
    Leung, Halpern, Barfoot and Liu, "The UTIAS multi-robot cooperative localization and mapping
    dataset", International Journal of Robotics Research 30(8), 2011, doi:10.1177/0278364911398404.
    """
    folder, reports = as_path(folder, "folder"), []
    limits.per_second(time_unit)

    def table(name: str, what: str, columns: int, checks: Sequence[Check]) -> np.ndarray:
        rows, report = read_table(folder / f"{name}.dat.gz", what, columns, checks)
        reports.append(report)
        return rows

    def timed(name: str, what: str, columns: int, checks: Sequence[Check]) -> np.ndarray:
        rows = table(name, what, columns, checks)
        rows[:, 0] = in_seconds(reports[-1].path, rows[:, 0], time_unit)
        return rows

    codes = table("Barcodes", "barcode", 2, BARCODES).astype(int)
    subjects = {barcode: subject for subject, barcode in codes.tolist()}
    survey = table("Landmark_Groundtruth", "landmark", 5, LANDMARKS)
    survey = survey[np.argsort(survey[:, 0])]
    landmarks = SurveyedLandmarks(survey[:, 0].astype(int), survey[:, 1:3], survey[:, 3:])
    lost = set(subjects.values()) - set(ROBOTS) - set(landmarks.ids.tolist())
    if lost:
        raise CorruptLog(f"{folder}: subjects {sorted(lost)} have a barcode and no position")
    robots = {}
    for number in ROBOTS:
        wheels = timed(f"Robot{number}_Odometry", "odometry", 3, COMMANDS)
        seen = timed(f"Robot{number}_Measurement", "measurement", 4, MEASUREMENTS)
        truth = timed(f"Robot{number}_Groundtruth", "pose", 4, TRUTH)
        who = np.array([subjects.get(int(barcode), 0) for barcode in seen[:, 1]])
        is_robot = np.isin(who, ROBOTS)
        robots[number] = MrclamRobot(
            Commands(wheels[:, 0], wheels[:, 1:]),
            *(
                Sightings(seen[chosen, 0], who[chosen], seen[chosen, 2:])
                for chosen in (~is_robot & (who > 0), is_robot)
            ),
            MappingProxyType(dict(sorted(Counter(seen[who == 0, 1].astype(int).tolist()).items()))),
            Track(truth[:, 0], truth[:, 1:]),
        )
    return Mrclam(landmarks, MappingProxyType(robots), tuple(reports))


def _is_no_count(values: np.ndarray) -> Bool[np.ndarray, " rows"]:
    return ((values < 1) | (values > 1e9) | (values != np.floor(values))).any(axis=1)


IN_ORDER = (
    "its time lies before that of an earlier line",
    lambda rows: rows[:, 0] < np.maximum.accumulate(rows[:, 0]),
)
BARCODES = (
    ("a subject or barcode is not a positive integer", _is_no_count),
    (
        "names a subject or barcode a second time",
        lambda rows: repeats(rows[:, :1]) | repeats(rows[:, 1:]),
    ),
)
LANDMARKS = (
    ("a subject or barcode is not a positive integer", lambda rows: _is_no_count(rows[:, :1])),
    ("names a subject or barcode a second time", lambda rows: repeats(rows[:, :1])),
    ("a standard deviation is negative", lambda rows: (rows[:, 3:] < 0).any(axis=1)),
    limits.far_places(1, 2),
)
COMMANDS = (IN_ORDER,)
MEASUREMENTS = (
    ("a subject or barcode is not a positive integer", lambda rows: _is_no_count(rows[:, 1:2])),
    ("a range is not positive", lambda rows: rows[:, 2] <= 0),
    IN_ORDER,
    ("sees a barcode a second time in one image", lambda rows: repeats(rows[:, :2])),
    limits.far_places(2),
    limits.wide_angles(3),
)
TRUTH = (
    IN_ORDER,
    ("has the time of an earlier line", lambda rows: repeats(rows[:, :1])),
    limits.far_places(1, 2),
    *limits.no_headings(3),
)
