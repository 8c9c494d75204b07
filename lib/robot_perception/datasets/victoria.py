"""Victoria Park: a car among trees, as a chain of motions and sightings, and satellite fixes."""

import subprocess
import sys
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from robot_perception.datasets import limits
from robot_perception.datasets.logs import CorruptLog, Lines, ReadReport, as_path, in_seconds
from studies.files import reading

MOTION, SIGHTING = b"ODOMETRY", b"LANDMARK"
MATLAB_SECONDS = 60.0


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
    """Log of the car's encoders.

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


def read_landmark_graph(path: str | Path) -> LandmarkGraph:
    """Read a chain of motions and sightings of known landmarks, plain or gzip.

    Lines are ``ODOMETRY i j dx dy dtheta`` with the upper triangle ``xx xy xt yy yt tt`` of a
    covariance, and ``LANDMARK pose landmark dx dy`` with ``xx xy yy``. That these are covariances
    and not, as in other graph files, their inverses follows from their size: taken as an inverse,
    1e-4 would let a step of half a metre be wrong by 100 m.

    Raises
    ------
    CorruptLog
        If the file is empty, damaged or holds no motion; at the first line that is bad, breaks the
        chain, repeats another or has numbers in another unit.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    Guivant and Nebot, "Optimization of the simultaneous localization and map-building algorithm for
    real-time implementation", IEEE Transactions on Robotics and Automation 17(3), 2001.
    """
    lines = Lines(path)
    poses: dict[int, int] = {}  # id -> row, in the order of the chain
    steps: list[tuple[int, Float[np.ndarray, " 9"]]] = []  # with their line numbers
    seen: dict[tuple[int, int], tuple[int, Float[np.ndarray, " 5"]]] = {}
    for words in lines.of(MOTION, SIGHTING):
        lines.expect(words, 12 if words[0] == MOTION else 8)
        first, second = lines.integer(words, 1), lines.integer(words, 2)
        values = lines.numbers(words[3:])
        if words[0] == SIGHTING:
            if (first, second) in seen:
                raise lines.error("repeats a sighting of one landmark from one pose")
            seen[first, second] = lines.number, values
            continue
        poses = poses or {first: 0}
        if poses.get(first) != len(poses) - 1:
            raise lines.error("does not begin at the pose where the motion before it ended")
        if second in poses:
            raise lines.error("repeats a pose")
        poses[second] = len(poses)
        steps.append((lines.number, values))
    for (pose, _), (number, _) in seen.items():
        if pose not in poses:  # only now: sightings may stand before their poses
            raise lines.error("its pose is not among those the motions lead to", number)
    order = sorted(seen, key=lambda key: poses[key[0]])  # stable: one pose's keep their order
    motions, motion_covs = _split(lines, steps, 3, limits.far_places(0, 1), limits.wide_angles(2))
    seen_from = [seen[key] for key in order]
    values, value_covs = _split(lines, seen_from, 2, limits.far_places(0, 1))
    return LandmarkGraph(
        motions,
        motion_covs,
        np.array([poses[pose] for pose, _ in order], dtype=int),
        np.array([landmark for _, landmark in order], dtype=int),
        values,
        value_covs,
        lines.report(),
    )


def _split(
    lines: Lines, numbered: list[tuple[int, np.ndarray]], n: int, *checks: limits.Check
) -> tuple[Float[np.ndarray, "m n"], Float[np.ndarray, "m n n"]]:
    """Return vectors, and covariances from their upper triangles, row by row."""
    rows, cols = np.triu_indices(n)
    table = np.array([values for _, values in numbered]).reshape(-1, n + len(rows))
    covs = np.zeros((len(table), n, n))
    covs[:, rows, cols] = covs[:, cols, rows] = table[:, n:]
    bad = np.linalg.eigvalsh(covs)[:, 0] <= 0
    indefinite = "its matrix is not positive definite", lambda _: bad
    lines.check(table, [number for number, _ in numbered], indefinite, *checks)
    return table[:, :n], covs


def read_vehicle(path: str | Path, *, time_unit: str = "ms") -> VehicleLog:
    """Read the car's speed and steering from a MATLAB file.

    Parameters
    ----------
    path
        File with the arrays ``time``, ``speed`` (m/s) and ``steering`` (rad).
    time_unit
        What it counts time in: ``"s"``, ``"ms"`` as the car did, ``"us"`` or ``"ns"``.

    Raises
    ------
    CorruptLog
        If it cannot be read, an array is missing, of another length or not finite, time does not
        rise, or times or angles are in another unit.
    FileNotFoundError
        If there is no such file.
    """
    time, speed, steering = _columns(path, time_unit, "time", "speed", "steering")
    if (np.abs(steering) > limits.TURN).any():
        raise CorruptLog(f"{path}: steering is beyond a full turn: are these radians?")
    return VehicleLog(time, speed, steering)


def read_fixes(path: str | Path, *, time_unit: str = "ms") -> Fixes:
    """Read the satellite fixes from a MATLAB file.

    Parameters
    ----------
    path
        File with the arrays ``timeGps``, ``Lo_m`` and ``La_m`` (m east and north).
    time_unit
        As for `read_vehicle`.

    Raises
    ------
    CorruptLog
        As `read_vehicle`.
    FileNotFoundError
        If there is no such file.
    """
    time, east, north = _columns(path, time_unit, "timeGps", "Lo_m", "La_m")
    positions = np.stack([east, north], axis=1)
    if (np.abs(positions) > limits.FARTHEST).any():
        raise CorruptLog(f"{path}: a fix lies beyond {limits.FARTHEST:g} m: are these metres?")
    return Fixes(time, positions)


READ_MATLAB = """
import sys, numpy, scipy.io
content = scipy.io.loadmat(sys.argv[1], variable_names=sys.argv[2:])
found = {name: numpy.asarray(content[name]).ravel() for name in sys.argv[2:]}
for name, array in found.items():
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name} holds no real numbers but {array.dtype}")
    found[name] = array.astype(float)
numpy.savez(sys.stdout.buffer, **found)
"""


def _columns(path: str | Path, time_unit: str, *names: str) -> list[Float[np.ndarray, " k"]]:
    """Return arrays of a MATLAB file, the first of which are times, which must rise, in s.

    Another process reads the file, since a damaged one can end the interpreter inside SciPy. What
    lies in the current folder is no module of that process.
    """
    path = as_path(path)
    limits.per_second(time_unit)
    path.open("rb").close()  # raises if there is none
    command = [sys.executable, "-P", "-c", READ_MATLAB, str(path), *names]
    try:
        done = subprocess.run(command, capture_output=True, timeout=MATLAB_SECONDS)
    except subprocess.TimeoutExpired as error:
        raise CorruptLog(f"{path}: cannot be read in {MATLAB_SECONDS} s") from error
    if done.returncode:
        cause = done.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        cause = cause or f"the reading process ended with {done.returncode}"
        raise CorruptLog(f"{path}: not a MATLAB file with {', '.join(names)} ({cause})")
    with (
        reading(path, f"not a MATLAB file with {', '.join(names)}", CorruptLog),
        np.load(BytesIO(done.stdout)) as found,
    ):
        columns = [found[name] for name in names]
    sizes = {column.size for column in columns}
    if len(sizes) != 1 or not columns[0].size:
        raise CorruptLog(f"{path}: {', '.join(names)} have {sorted(sizes)} values")
    for name, column in zip(names, columns, strict=True):
        bad = np.flatnonzero(~np.isfinite(column))
        if bad.size:
            raise CorruptLog(f"{path}: {name} is NaN or infinite at row {bad[0] + 1}")
    falls = np.flatnonzero(np.diff(columns[0]) <= 0)
    if falls.size:
        raise CorruptLog(f"{path}: {names[0]} does not rise after row {falls[0] + 1}")
    return [in_seconds(path, columns[0], time_unit), *columns[1:]]
