"""Trajectories in space: poses of a camera or a robot, read from the formats of benchmarks.

SciPy's rotations are imported where poses are made: the other readers do without them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks
from robot_perception.datasets.logs import (
    FINITE,
    SHORT,
    Check,
    CorruptLog,
    Lines,
    read_table,
    to_numbers,
)
from robot_perception.datasets.tables import read_columns
from robot_perception.datasets.tracks import QUATERNION, RISING, neighbours, read_track

SPACE = ("time_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
EUROC = (b"p_RS_R_x", b"p_RS_R_y", b"p_RS_R_z", b"q_RS_w", b"q_RS_x", b"q_RS_y", b"q_RS_z")
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

    Raises
    ------
    ValueError
        If a pose is no rigid motion, there is not a time for each, or the times do not rise.
    """

    times: Float[np.ndarray, " k"] | None
    poses: Float[np.ndarray, "k 4 4"]

    def __post_init__(self) -> None:
        from robot_perception.geometry import se3

        poses = checks.reals("poses", self.poses)
        checks.shaped("poses", poses, ("k", 4, 4))
        object.__setattr__(self, "poses", se3.checked("poses", poses))
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


def track_format(path: str | Path) -> str:
    """Return the format of a trajectory, told by its first line of data.

    Returns
    -------
    str
        ``"TUM"`` (up to 10 words without commas), ``"KITTI"`` (more) or ``"EuRoC"`` (CSV without
        names of columns, or with EuRoC's); of other CSV ``"space"`` if it has quaternions, else
        ``"plane"``, which `read_track` reads.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged.
    FileNotFoundError
        If there is no such file.
    """
    lines = Lines(path)
    words = next(lines.words(), [])
    if not words:
        lines.need("pose")
    cells = _cells(words)
    if len(cells) == 1:
        return "KITTI" if len(words) > 10 else "TUM"
    names = [cell.split(b" ")[0] for cell in cells]
    if _are_numbers(cells) or tuple(names[1:8]) == EUROC:
        return "EuRoC"
    return "space" if b"qw" in names else "plane"


def read_space_track(path: str | Path) -> SpaceTrack:
    """Read a trajectory in space, plain or gzip; `track_format` tells its format.

    * TUM: ``timestamp tx ty tz qx qy qz qw``, s and m;
    * KITTI: a matrix of 3 × 4 by rows, without times;
    * EuRoC: CSV of ``timestamp, x, y, z, qw, qx, qy, qz`` and what may follow, the times in whole
      nanoseconds, with or without names of columns;
    * CSV with the columns ``time_s, x_m, y_m, z_m, qx, qy, qz, qw``, others are left out;
    * CSV as `read_track` reads it lies in the plane z = 0.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, lacks a column, or is of another format; at the first line
        that cannot be read, does not come after the one before, or holds no rotation.
    FileNotFoundError
        If there is no such file.
    """
    return READERS[track_format(path)](path)


def _read_tum(path: str | Path) -> SpaceTrack:
    rows, _ = read_table(path, "pose", 8, (QUATERNION[0], RISING))
    return SpaceTrack(rows[:, 0], _poses(rows[:, 1:4], rows[:, 4:]))


def _read_kitti(path: str | Path) -> SpaceTrack:
    from scipy.spatial.transform import Rotation

    rows, _ = read_table(path, "pose", 12, (ROTATION,))
    matrices = rows.reshape(-1, 3, 4)
    nearest = Rotation.from_matrix(matrices[:, :, :3]).as_quat()
    return SpaceTrack(None, _poses(matrices[:, :, 3], nearest))


def _read_euroc(path: str | Path) -> SpaceTrack:
    lines, rows, places = Lines(path), [], []
    for words in lines.words():
        cells = _cells(words)
        if lines.place == 1 and not _are_numbers(cells):
            continue
        if len(cells) < 8:
            raise lines.error(SHORT)
        rows.append(lines.numbers(cells[:8]))
        places.append(lines.number)
    lines.kept["pose"] = len(rows)
    lines.need("pose")
    table = np.array(rows)
    table = np.column_stack([table[:, :4], np.roll(table[:, 4:], -1, axis=1)])
    for reason, is_bad in (NANOSECONDS, QUATERNION[0], RISING):
        if (bad := is_bad(table)).any():
            raise lines.error(reason, places[int(np.argmax(bad))])
    return SpaceTrack(table[:, 0] / 1e9, _poses(table[:, 1:4], table[:, 4:]))


def _read_columns(path: str | Path) -> SpaceTrack:
    columns = read_columns(path, dict.fromkeys(SPACE, np.inf))
    table = np.column_stack([columns[name] for name in SPACE])
    for reason, is_bad in (FINITE, QUATERNION[0], RISING):
        if (bad := is_bad(table)).any():
            raise CorruptLog(f"{path}, row {np.argmax(bad) + 1}: {reason}")
    return SpaceTrack(table[:, 0], _poses(table[:, 1:4], table[:, 4:]))


def _read_plane(path: str | Path) -> SpaceTrack:
    from robot_perception.geometry import se3

    track = read_track(path)
    return SpaceTrack(track.times, se3.from_se2(track.poses))


READERS: dict[str, Callable[[str | Path], SpaceTrack]] = {
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


def _cells(words: list[bytes]) -> list[bytes]:
    """Return what stands between the commas of a line; one at its end is let pass."""
    cells = [cell.strip() for cell in b" ".join(words).split(b",")]
    return cells[:-1] if len(cells) > 1 and not cells[-1] else cells


def _are_numbers(cells: list[bytes]) -> bool:
    try:
        to_numbers(cells)
    except ValueError:
        return False
    return True


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
