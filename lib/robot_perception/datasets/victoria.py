"""Victoria Park: a car among trees, as a chain of motions and sightings, and satellite fixes."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from scipy.io import loadmat

from robot_perception.datasets import logs
from robot_perception.datasets.logs import CorruptLog, ReadReport, Tally

MOTION, SIGHTING = b"ODOMETRY", b"LANDMARK"
MOTION_LENGTH = 12  # keyword i j dx dy dtheta and the upper triangle xx xy xt yy yt tt
SIGHTING_LENGTH = 8  # keyword pose landmark dx dy and the upper triangle xx xy yy

BAD_ID = "an id is not an integer"
BROKEN_CHAIN = "does not begin at the pose where the motion before it ended"
NO_COVARIANCE = "its matrix is not positive definite"
REPEATED = "repeats a pose, or a sighting of one landmark from one pose"
LOST_POSE = "its pose is not among those the motions lead to"


@dataclass(frozen=True, eq=False, slots=True)
class LandmarkGraph:
    """A drive as a chain of motions, with landmarks seen on the way.

    Parameters
    ----------
    motions : (steps, 3)
        Pose (x, y, φ) after each step seen from the pose before it, m and rad; step i leads from
        pose i to pose i + 1.
    motion_covs : (steps, 3, 3)
        Their covariances, as the file has them.
    observers : (sightings,)
        Pose (0 to steps) each sighting was made from, never falling.
    landmarks : (sightings,)
        The landmark's number in the file.
    values : (sightings, 2)
        Its position in the robot's frame, m.
    value_covs : (sightings, 2, 2)
        Their covariances, as the file has them.
    report
        What became of every line of the file.
    """

    motions: Float[np.ndarray, "steps 3"]
    motion_covs: Float[np.ndarray, "steps 3 3"]
    observers: Int[np.ndarray, " sightings"]
    landmarks: Int[np.ndarray, " sightings"]
    values: Float[np.ndarray, "sightings 2"]
    value_covs: Float[np.ndarray, "sightings 2 2"]
    report: ReadReport


@dataclass(frozen=True, eq=False, slots=True)
class VehicleLog:
    """What the car's encoders say.

    Parameters
    ----------
    times : (k,)
        s.
    speeds : (k,)
        Of the left rear wheel, m/s.
    steerings : (k,)
        Angle of the front wheels, rad.
    """

    times: Float[np.ndarray, " k"]
    speeds: Float[np.ndarray, " k"]
    steerings: Float[np.ndarray, " k"]


@dataclass(frozen=True, eq=False, slots=True)
class Fixes:
    """Positions by satellite; the receiver failed now and then, and some fixes jump.

    Parameters
    ----------
    times : (k,)
        s, on the clock of `VehicleLog`.
    positions : (k, 2)
        East and north, m.
    """

    times: Float[np.ndarray, " k"]
    positions: Float[np.ndarray, "k 2"]


@dataclass(slots=True)
class _Builder:
    """What has been read so far."""

    tally: Tally
    poses: dict[int, int] = field(default_factory=dict)  # id -> row, in the order of the chain
    motions: list[Float[np.ndarray, "9"]] = field(default_factory=list)
    sightings: list[tuple[int, int, int, Float[np.ndarray, "5"]]] = field(default_factory=list)

    def add_motion(self, tokens: list[bytes]) -> str | None:
        parsed = _parse(tokens, MOTION_LENGTH)
        if isinstance(parsed, str):
            return parsed
        start, end, values = parsed
        if not self.poses:
            self.poses[start] = 0
        if self.poses.get(start) != len(self.poses) - 1:
            return BROKEN_CHAIN
        if end in self.poses:
            return REPEATED
        if not _positive_definite(values[3:], 3):
            return NO_COVARIANCE
        self.poses[end] = len(self.poses)
        self.motions.append(values)
        return None

    def add_sighting(self, line: int, tokens: list[bytes]) -> str | None:
        parsed = _parse(tokens, SIGHTING_LENGTH)
        if isinstance(parsed, str):
            return parsed
        pose, landmark, values = parsed
        if not _positive_definite(values[2:], 2):
            return NO_COVARIANCE
        self.sightings.append((line, pose, landmark, values))
        return None

    def seen(self) -> list[tuple[int, int, Float[np.ndarray, "5"]]]:
        """Count the sightings, which may stand before their poses, and return those that hold."""
        kept: dict[tuple[int, int], np.ndarray] = {}
        for line, pose, landmark, values in self.sightings:
            row = self.poses.get(pose)
            if row is None:
                self.tally.skip(line, LOST_POSE)
            elif (row, landmark) in kept:
                self.tally.skip(line, REPEATED)
            else:
                self.tally.kept[SIGHTING.decode()] += 1
                kept[row, landmark] = values
        rows = [(row, landmark, values) for (row, landmark), values in kept.items()]
        return sorted(rows, key=lambda item: item[0])  # stable: one pose's keep their order


def read_landmark_graph(
    path: str | Path, *, strict: bool = True, allow_truncated: bool = False
) -> LandmarkGraph:
    """Read a chain of motions and sightings of known landmarks, plain or gzip.

    Lines are ``ODOMETRY i j dx dy dtheta`` with the upper triangle ``xx xy xt yy yt tt`` of a
    covariance, and ``LANDMARK pose landmark dx dy`` with ``xx xy yy``. That these are covariances
    and not, as in other graph files, their inverses follows from their size: taken as an inverse,
    1e-4 would let a step of half a metre be wrong by 100 m.

    Parameters
    ----------
    path
        The file.
    strict
        Raise at the first line that cannot be read; else it is left out, counted and reported.
    allow_truncated
        Accept a damaged gzip file and return what stands complete before the damage.

    Returns
    -------
    LandmarkGraph

    Raises
    ------
    CorruptLog
        If the file is empty, damaged or holds no motion, or (``strict``) a line is bad, breaks the
        chain or repeats another; the message names file and line.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    Guivant and Nebot, "Optimization of the simultaneous localization and map-building algorithm for
    real-time implementation", IEEE Transactions on Robotics and Automation 17(3), 2001.
    """
    recording = logs.read_recording(path)
    tally = Tally(recording.path, strict)
    builder = _Builder(tally)
    for number, tokens in logs.keyword_lines(recording, tally, frozenset({MOTION, SIGHTING})):
        if tokens[0] == MOTION:
            problem = builder.add_motion(tokens)
            tally.kept[MOTION.decode()] += problem is None
        else:
            problem = builder.add_sighting(number, tokens)
        if problem is not None:
            tally.skip(number, problem)
    seen = builder.seen()
    report = logs.close(recording, tally, allow_truncated=allow_truncated, what=MOTION.decode())
    motions = np.array(builder.motions)
    values = np.array([row[2] for row in seen]).reshape(-1, 5)
    return LandmarkGraph(
        motions[:, :3],
        _square(motions[:, 3:], 3),
        np.array([row[0] for row in seen], dtype=int),
        np.array([row[1] for row in seen], dtype=int),
        values[:, :2],
        _square(values[:, 2:], 2),
        report,
    )


def read_vehicle(path: str | Path) -> VehicleLog:
    """Read the car's speed and steering from a MATLAB file.

    Parameters
    ----------
    path
        File with the arrays ``time`` (ms), ``speed`` (m/s) and ``steering`` (rad).

    Raises
    ------
    CorruptLog
        If it cannot be read, an array is missing, of another length or not finite, or time does
        not rise.
    FileNotFoundError
        If there is no such file.
    """
    time, speed, steering = _columns(path, ("time", "speed", "steering"))
    return VehicleLog(time / 1e3, speed, steering)


def read_fixes(path: str | Path) -> Fixes:
    """Read the satellite fixes from a MATLAB file.

    Parameters
    ----------
    path
        File with the arrays ``timeGps`` (ms), ``Lo_m`` and ``La_m`` (m east and north).

    Raises
    ------
    CorruptLog
        As `read_vehicle`.
    FileNotFoundError
        If there is no such file.
    """
    time, east, north = _columns(path, ("timeGps", "Lo_m", "La_m"))
    return Fixes(time / 1e3, np.stack([east, north], axis=1))


def _columns(path: str | Path, names: Sequence[str]) -> list[Float[np.ndarray, " k"]]:
    """Return arrays of a MATLAB file, the first of which must rise."""
    path = Path(path)
    text = BytesIO(path.read_bytes())
    try:
        content = loadmat(text)
    except Exception as error:  # SciPy raises whatever the damage led it to
        raise CorruptLog(f"{path}: not a MATLAB file that can be read ({error})") from error
    missing = [name for name in names if name not in content]
    if missing:
        raise CorruptLog(f"{path}: it has no {', '.join(missing)}")
    columns = [np.asarray(content[name], dtype=float).ravel() for name in names]
    sizes = {column.size for column in columns}
    if len(sizes) != 1 or not columns[0].size:
        raise CorruptLog(f"{path}: {', '.join(names)} have {sorted(sizes)} values")
    for name, column in zip(names, columns, strict=True):
        if not np.isfinite(column).all():
            raise CorruptLog(f"{path}: {name} is NaN or infinite at row {_first(column)}")
    falls = np.flatnonzero(np.diff(columns[0]) <= 0)
    if falls.size:
        raise CorruptLog(f"{path}: {names[0]} does not rise after row {falls[0] + 1}")
    return columns


def _first(column: np.ndarray) -> int:
    """Return the number, from 1, of the first row that is not finite."""
    return int(np.flatnonzero(~np.isfinite(column))[0]) + 1


def _parse(tokens: list[bytes], length: int) -> tuple[int, int, np.ndarray] | str:
    """Return the two ids and the values of a line, or the reason why it is not read."""
    problem = logs.wrong_length(tokens, length)
    if problem:
        return problem
    if not (tokens[1].isdigit() and tokens[2].isdigit() and max(map(len, tokens[1:3])) <= 18):
        return BAD_ID
    values = logs.numbers(tokens[3:])
    if values is None:
        return logs.NOT_NUMBERS
    if not np.isfinite(values).all():
        return logs.NOT_FINITE
    return int(tokens[1]), int(tokens[2]), values


def _square(triangles: Float[np.ndarray, "m t"], n: int) -> Float[np.ndarray, "m n n"]:
    """Return symmetric matrices from their upper triangles, row by row."""
    full = np.zeros((len(triangles), n, n))
    rows, cols = np.triu_indices(n)
    full[:, rows, cols] = full[:, cols, rows] = triangles
    return full


def _positive_definite(triangle: Float[np.ndarray, " t"], n: int) -> bool:
    return bool(np.linalg.eigvalsh(_square(triangle[None], n))[0, 0] > 0)
