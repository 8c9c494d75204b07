"""Trajectories in space: poses of a camera or a robot, read from the formats of benchmarks.

SciPy's rotations are imported where poses are made: the other readers do without them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks
from robot_perception.datasets import limits
from robot_perception.datasets.bag_motion import read_bag_motion
from robot_perception.datasets.bags import Topics, check_topic, is_bag
from robot_perception.datasets.limits import Check
from robot_perception.datasets.logs import (
    FINITE,
    SHORT,
    CorruptLog,
    Lines,
    ReadReport,
    are_numbers,
    in_seconds,
    read_table,
)
from robot_perception.datasets.tables import read_columns
from robot_perception.datasets.tracks import POSE, RISING, UNIT_LENGTH, neighbours, read_track

SPACE = ("time_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
EUROC = ("p_RS_R_x", "p_RS_R_y", "p_RS_R_z", "q_RS_w", "q_RS_x", "q_RS_y", "q_RS_z")
LARGEST = {"time_s": np.inf} | dict.fromkeys(SPACE[1:4], limits.FARTHEST)
LARGEST |= dict.fromkeys(SPACE[4:], 1.001)
SHORTEST = 1e3  # ns between two poses


@dataclass(frozen=True, eq=False, slots=True)
class SpaceTrack:
    """Poses in space, estimated or by motion capture.

    Parameters
    ----------
    times : (k,)
        s, rising; nothing where the file has none.
    poses : (k, 4, 4)
        Rigid motions ``T_world_body``, m.
    report
        What became of all messages, if they come from a ROS bag.

    Raises
    ------
    ValueError
        If a pose is no rigid motion, there is not a time for each, or the times do not rise.
    """

    times: Float[np.ndarray, " k"] | None
    poses: Float[np.ndarray, "k 4 4"]
    report: ReadReport | None = None

    def __post_init__(self) -> None:
        from robot_perception.geometry import se3

        poses = checks.reals("poses", self.poses)
        checks.shaped("poses", poses, ("k", 4, 4))
        object.__setattr__(self, "poses", se3.checked("poses", poses))
        if self.report is not None:
            checks.instance("report", self.report, ReadReport)
        if self.times is None:
            return
        times = checks.array("times", self.times, (len(poses),), beside="these poses")
        if (np.diff(times) <= 0).any():
            raise ValueError("times must rise, got one that does not lie after the one before")
        object.__setattr__(self, "times", times)

    def __len__(self) -> int:
        return len(self.poses)

    def at(
        self, times: Float[np.ndarray, " m"], *, longest_gap: float
    ) -> tuple[Float[np.ndarray, "m 4 4"], Bool[np.ndarray, " m"]]:
        r"""Return the poses at given times.

        .. math::
            p = (1 - s)\, p_1 + s\, p_2, \qquad R = R_1 \exp\left(s \log(R_1^\top R_2)\right)

        Parameters
        ----------
        times : (m,)
            s, in any order.
        longest_gap
            A gap between two poses that is longer than this, in s, is not bridged.

        Returns
        -------
        poses : (m, 4, 4)
            NaN where not covered: nothing is extrapolated.
        covered : (m,)
            Whether a time lies on the track and in no longer gap.

        Raises
        ------
        ValueError
            If a time is not finite, the gap is not positive, or the track has no times.
        """
        from robot_perception.geometry import se3

        times = checks.array("times", times, ("m",))
        if self.times is None or not len(self):
            raise ValueError("times can be asked of a track with poses and times, got one without")
        before, after, share, covered = neighbours(self.times, times, longest_gap)
        first, last = self.poses[before], self.poses[after]
        turn = np.zeros((len(times), 6))
        turn[:, 3:] = share[:, None] * se3.log(se3.between(first, last))[:, 3:]
        poses = se3.compose(first, se3.exp(turn))
        poses[:, :3, 3] += share[:, None] * (last - first)[:, :3, 3]
        poses[~covered] = np.nan
        return poses, covered


def track_format(path: str | Path, *, topic: Topics = None) -> str:
    """Return the format of a trajectory, told by its first row and the names of its columns.

    Parameters
    ----------
    path
        The file.
    topic
        Of a ROS bag, where several would do.

    Returns
    -------
    str
        Without names ``"KITTI"`` (12 numbers a line), ``"TUM"`` (others between blanks) or
        ``"EuRoC"`` (others between commas); ``"EuRoC"`` by its names, ``"space"`` where there are
        ``time_s`` and quaternions, else ``"plane"``, which `read_track` reads. A bag is ``"plane"``
        if its poses have no heights and no tilts, else ``"space"``.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged.
    FileNotFoundError
        If there is no such file.
    """
    topic = check_topic(topic)
    if is_bag(path):
        return "plane" if read_bag_motion(path, topic).is_flat() else "space"
    lines = Lines(path)
    row = lines.points(next(lines.rows(), []))
    if not row:
        lines.need("pose")
    blanks = row == next(Lines(path).words())
    bare = any(are_numbers([cell]) for cell in row)
    tables = [_names(cells) for cells in (lines.headings() if bare else [row])]
    for names in tables:
        if names[1:8] == EUROC:
            return "EuRoC"
        if {*SPACE} <= {*names} or {*POSE} <= {*names}:
            return "plane" if {*POSE} <= {*names} else "space"
    if blanks or len(row) == 12:
        return "KITTI" if len(row) > 10 else "TUM"
    if bare:
        return "TUM" if any(len(names) >= 8 for names in tables) else "EuRoC"
    return "space" if "qw" in tables[0] else "plane"


def read_space_track(path: str | Path, *, time_unit: str = "s", topic: Topics = None) -> SpaceTrack:
    """Read a trajectory in space, plain or gzip or from a ROS bag; `track_format` tells its format.

    * TUM: ``timestamp tx ty tz qx qy qz qw``, m;
    * KITTI: a matrix of 3 × 4 by rows, m, without times;
    * EuRoC: CSV of ``timestamp, x, y, z, qw, qx, qy, qz`` and what may follow, with or without
      names of columns, the times always in whole nanoseconds;
    * CSV with the columns ``time_s, x_m, y_m, z_m, qx, qy, qz, qw``, others are left out;
    * CSV as `read_track` reads it lies in the plane z = 0.

    Parameters
    ----------
    path
        The file.
    time_unit
        What it counts time in, but for EuRoC: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``. Bags tell.
    topic
        Of a bag, where several would do.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, lacks a column, or times are in another unit; at the first
        line that cannot be read, does not come after the one before, holds no rotation, or a place
        in another unit.
    FileNotFoundError
        If there is no such file.
    """
    limits.per_second(time_unit)
    topic = check_topic(topic)
    if is_bag(path):
        motion = read_bag_motion(path, topic)
        return SpaceTrack(motion.times, motion.poses, motion.report)
    return READERS[track_format(path)](path, time_unit)


def _read_tum(path: str | Path, time_unit: str) -> SpaceTrack:
    rows, report = read_table(path, "pose", 8, (UNIT_LENGTH, RISING, limits.far_places(1, 2, 3)))
    times = in_seconds(report.path, rows[:, 0], time_unit)
    return SpaceTrack(times, _poses(rows[:, 1:4], rows[:, 4:]))


def _read_kitti(path: str | Path, time_unit: str) -> SpaceTrack:
    from scipy.spatial.transform import Rotation

    rows, _ = read_table(path, "pose", 12, (ROTATION, limits.far_places(3, 7, 11)))
    matrices = rows.reshape(-1, 3, 4)
    nearest = Rotation.from_matrix(matrices[:, :, :3]).as_quat()
    return SpaceTrack(None, _poses(matrices[:, :, 3], nearest))


def _read_euroc(path: str | Path, time_unit: str) -> SpaceTrack:
    lines, rows, places = Lines(path), [], []
    for cells in lines.rows():
        if lines.place == 1 and _names(cells)[1:8] == EUROC:
            continue
        if len(cells) < 8:
            raise lines.error(SHORT)
        rows.append(lines.numbers(lines.points(cells[:8])))
        places.append(lines.number)
    lines.kept["pose"] = len(rows)
    lines.need("pose")
    table = np.array(rows)
    table = np.column_stack([table[:, :4], np.roll(table[:, 4:], -1, axis=1)])
    lines.check(table, places, NANOSECONDS, UNIT_LENGTH, RISING, limits.far_places(1, 2, 3))
    times = in_seconds(lines.path, table[:, 0], "ns")
    return SpaceTrack(times, _poses(table[:, 1:4], table[:, 4:]))


def _read_columns(path: str | Path, time_unit: str) -> SpaceTrack:
    columns = read_columns(path, LARGEST, time_unit=time_unit)
    table = np.column_stack([columns[name] for name in SPACE])
    for reason, is_bad in (FINITE, UNIT_LENGTH, RISING):
        if (bad := is_bad(table)).any():
            raise CorruptLog(f"{path}, row {np.argmax(bad) + 1}: {reason}")
    return SpaceTrack(table[:, 0], _poses(table[:, 1:4], table[:, 4:]))


def _read_plane(path: str | Path, time_unit: str) -> SpaceTrack:
    from robot_perception.geometry import se3

    track = read_track(path, time_unit=time_unit)
    return SpaceTrack(track.times, se3.from_se2(track.poses))


READERS: dict[str, Callable[[str | Path, str], SpaceTrack]] = {
    "TUM": _read_tum,
    "KITTI": _read_kitti,
    "EuRoC": _read_euroc,
    "space": _read_columns,
    "plane": _read_plane,
}


def _poses(
    positions: Float[np.ndarray, "k 3"], quaternions: Float[np.ndarray, "k 4"]
) -> Float[np.ndarray, "k 4 4"]:
    """Return rigid motions of positions and quaternions x, y, z, w."""
    from scipy.spatial.transform import Rotation

    poses = np.zeros((len(positions), 4, 4))
    poses[:, :3, :3] = Rotation.from_quat(quaternions).as_matrix()
    poses[:, :3, 3], poses[:, 3, 3] = positions, 1
    return poses


def _names(cells: list[bytes]) -> tuple[str, ...]:
    """Return names of columns without the units that follow them."""
    return tuple(cell.decode().partition(" ")[0] for cell in cells)


def _is_no_rotation(rows: np.ndarray) -> np.ndarray:
    R = rows.reshape(-1, 3, 4)[:, :, :3]
    far = np.abs(R.mT @ R - np.eye(3)).max(axis=(1, 2)) > 1e-3
    return far | (np.linalg.det(R) < 0)


ROTATION: Check = ("its matrix of 3 × 3 is no rotation", _is_no_rotation)


def _are_no_nanoseconds(rows: np.ndarray) -> np.ndarray:
    t = rows[:, 0]
    step = np.diff(t, prepend=-np.inf)
    return (t != np.round(t)) | ((step > 0) & (step < SHORTEST))


NANOSECONDS: Check = ("its time is not in whole nanoseconds", _are_no_nanoseconds)
