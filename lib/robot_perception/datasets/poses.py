"""Rows of poses in space, by the names of their columns or by the format of their file."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.datasets import limits
from robot_perception.datasets.limits import Check
from robot_perception.datasets.logs import (
    SHORT,
    Lines,
    ReadReport,
    are_numbers,
    in_seconds,
    read_table,
)
from robot_perception.datasets.names import clock_unit

POSE = ("time_s", "x_m", "y_m", "heading_rad")
SPACE = ("time_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
EUROC = ("p_RS_R_x", "p_RS_R_y", "p_RS_R_z", "q_RS_w", "q_RS_x", "q_RS_y", "q_RS_z")
WORDS = {  # other names of the columns of SPACE, as TUM, EuRoC and exports of ROS have them
    "time_s": re.compile(r"%?(?:time|timestamp|stamp|t)(?:_(?P<unit>[mun]?s))?"),
    **{
        f"{axis}_m": re.compile(rf"(?:.*position[._]|pos_?|t_?|p_?|p_rs_r_)?{axis}(?:_m)?")
        for axis in "xyz"
    },
    **{f"q{axis}": re.compile(rf"(?:.*orientation[._]|quat_?|q_?|q_rs_){axis}") for axis in "xyzw"},
}
UNIT = re.compile(r"\s*[\[(]\s*(?P<unit>[mun]?s)?[^\])]*[\])]")
ORDERS = {  # of files without names
    "TUM": "time x y z qx qy qz qw",
    "EuRoC": "time in ns, x y z qw qx qy qz",
    "KITTI": "matrices of 3 × 4 by rows, without times",
}
SHORTEST = 1e3  # ns between two poses
EXACT = 1e-5  # what `geometry.se3` takes for a rotation
OFF_UNIT = 1e-3  # by which quaternions and rotations may be off, however they are rounded


class Layout(NamedTuple):
    """Columns of a file with poses.

    Parameters
    ----------
    kind
        As `track_format` has it.
    places
        Where the columns of ``SPACE`` are, if names tell.
    unit
        Of time, if names or the format tell it.
    headed
        Whether the names are the first row.
    """

    kind: str
    places: tuple[int, ...] | None = None
    unit: str | None = None
    headed: bool = False


class PoseRows(NamedTuple):
    """Poses in the order of a file.

    Parameters
    ----------
    times : (k,)
        s, rising.
    positions : (k, 3)
        m.
    quaternions : (k, 4)
        x, y, z, w, of unit length as far as they are written.
    report
        What became of every line.
    """

    times: Float[np.ndarray, " k"]
    positions: Float[np.ndarray, "k 3"]
    quaternions: Float[np.ndarray, "k 4"]
    report: ReadReport


def layout(path: str | Path) -> Layout:
    """Return what the columns of a trajectory are, by their names or else by its first row.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, or names some columns of a pose in space and not the
        others.
    FileNotFoundError
        If there is no such file.
    """
    lines = Lines(path)
    row = lines.points(next(lines.rows(), []))
    while row and not row[-1]:
        row.pop()
    if not row:
        lines.need("pose")
    bare = any(are_numbers([cell]) for cell in row)
    for cells in lines.headings() if bare else [row]:
        names = [text for cell in cells if (text := UNIT.sub("", cell.decode()).strip())]
        if {*POSE} <= {*names}:
            return Layout("plane")
        found = {name: place for name in SPACE if (place := _place(name, names)) is not None}
        if len(found) == len(SPACE):
            return _named(cells, names, found, headed=not bare)
        if not bare and any(name in found for name in SPACE[4:]):
            lost = " and no column ".join(name for name in SPACE if name not in found)
            raise lines.error(f"no column {lost}; there is {', '.join(names)}")
    if not bare:
        return Layout("plane")
    if len(row) == 12 or row == next(Lines(path).words()):
        return Layout("KITTI" if len(row) > 10 else "TUM")
    return Layout("EuRoC", unit="ns") if len(row) != 8 or _are_nanoseconds(path) else Layout("TUM")


def _named(cells: list[bytes], names: list[str], found: dict[str, int], *, headed: bool) -> Layout:
    """Return the layout of a file that names all columns of a pose in space."""
    places = tuple(found[name] for name in SPACE)
    if {*EUROC} <= {*names}:
        return Layout("EuRoC", places, "ns", headed)
    time = cells[places[0]].decode()
    told = UNIT.search(time) or WORDS["time_s"].fullmatch(time.lower())
    unit = told["unit"] if told and names[places[0]] != SPACE[0] else None
    kind = "space" if headed or {*SPACE} <= {*names} else "TUM"
    return Layout(kind, places, unit, headed)


def _place(name: str, names: list[str]) -> int | None:
    """Return where a column of ``SPACE`` is among names, nothing if it is not there."""
    if name in names:
        return names.index(name)
    fits = (place for place, text in enumerate(names) if WORDS[name].fullmatch(text.lower()))
    return next(fits, None)


def _are_nanoseconds(path: str | Path) -> bool:
    """Return whether the first column holds whole nanoseconds, as EuRoC has them."""
    lines = Lines(path)
    first = [cells[0] for cells in map(lines.points, lines.rows())]
    if not are_numbers(first):
        return True  # the reader names the line
    times = np.array(first, dtype=float)
    unit, steps = clock_unit(times.tolist()), np.diff(times)
    whole = bool((times == np.round(times)).all())
    apart = not steps.size or bool(np.median(steps) >= SHORTEST)
    return whole and apart and unit in (None, 10**9)


def read_poses(
    path: str | Path, found: Layout, time_unit: str, checks: Sequence[Check] = ()
) -> PoseRows:
    """Read poses with times.

    Parameters
    ----------
    path
        The file.
    found
        What its columns are.
    time_unit
        What it counts time in, where it does not tell that itself.
    checks
        Of rows t, x, y, z, qx, qy, qz, qw, beside those of every trajectory.

    Raises
    ------
    CorruptLog
        If the file is damaged or times are in another unit; at the first line that cannot be read,
        does not come after the one before, holds no rotation, or a place in another unit.
    """
    checks = UNIT_LENGTH, *checks, RISING, limits.far_places(1, 2, 3)
    if found.kind == "TUM" and found.places is None:
        rows, report = read_table(path, "pose", 8, checks)
    else:
        rows, report = _read_columns(path, found, checks)
    times = in_seconds(report.path, rows[:, 0], found.unit or time_unit)
    quaternions, remarks = rows[:, 4:], list(report.remarks)
    if found.places is None:
        remarks.append(f"{report.path.name}: no names of columns: read as {order(found.kind)}")
    off = np.abs(np.linalg.norm(quaternions, axis=1) - 1).max()
    if off > OFF_UNIT:
        quaternions = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
        told = f"quaternions are off unit length by up to {off:.1%}, and made unit"
        remarks.append(f"{report.path.name}: {told}")
    return PoseRows(times, rows[:, 1:4], quaternions, replace(report, remarks=tuple(remarks)))


def order(kind: str) -> str:
    """Return in words how the rows of a file without names are read."""
    return f"{kind}, {ORDERS[kind]}"


def _read_columns(
    path: str | Path, found: Layout, checks: Sequence[Check]
) -> tuple[Float[np.ndarray, "k 8"], ReadReport]:
    """Return rows t, x, y, z, qx, qy, qz, qw of a table that may have more columns."""
    places = found.places or (0, 1, 2, 3, 5, 6, 7, 4)
    lines, rows, numbers, width = Lines(path), [], [], 0
    for cells in lines.rows():
        if found.headed and lines.place == 1:
            width = len(cells)
            continue
        if len(cells) <= max(places):
            raise lines.error(SHORT)
        if found.headed and found.kind == "space":
            lines.expect(cells, width)
        rows.append(lines.numbers(lines.points([cells[place] for place in places])))
        numbers.append(lines.number)
    lines.kept["pose"] = len(rows)
    lines.need("pose")
    table = np.array(rows)
    checks = (NANOSECONDS, *checks) if found.kind == "EuRoC" else checks
    lines.check(table, numbers, *checks)
    return table, lines.report()


def headings(quaternions: Float[np.ndarray, "k 4"]) -> Float[np.ndarray, " k"]:
    """Return the headings, in rad, of unit quaternions qx qy qz qw."""
    qx, qy, qz, qw = quaternions.T
    return np.arctan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy**2 + qz**2))


def half_digit(values: np.ndarray) -> float:
    """Return half a unit of the last decimal of numbers with one to three; 0 of others."""
    for decimals in (1, 2, 3):
        if np.abs(values - np.round(values, decimals)).max(initial=0.0) < 1e-12:
            return 0.5 * 10.0**-decimals
    return 0.0


def are_no_rotations(rows: Float[np.ndarray, "k 12"]) -> Bool[np.ndarray, " k"]:
    """Return which matrices of 3 × 4, by rows, hold no rotation but for its rounding."""
    R = rows.reshape(-1, 3, 4)[:, :, :3]
    half = half_digit(R)
    far = np.abs(R.mT @ R - np.eye(3)).max(axis=(1, 2))
    most = max(OFF_UNIT, 2 * np.sqrt(3) * half + 3 * half**2)
    return (far > most) | (np.linalg.det(R) < 0)


def rigid(matrices: Float[np.ndarray, "k 3 4"]) -> Float[np.ndarray, "k 4 4"]:
    """Return matrices as rigid motions, with the nearest rotations where they are rounded."""
    poses = np.zeros((len(matrices), 4, 4))
    poses[:, :3], poses[:, 3, 3] = matrices, 1
    R = poses[:, :3, :3]
    rounded = np.abs(R.mT @ R - np.eye(3)).max(axis=(1, 2)) > EXACT
    U, _, V = np.linalg.svd(R[rounded])
    R[rounded] = U @ V
    return poses


def _are_off_unit(rows: Float[np.ndarray, "k columns"]) -> Bool[np.ndarray, " k"]:
    """Return which rows end in a quaternion that is not of unit length but for its rounding."""
    q = np.abs(rows[:, -4:])
    off = np.abs(np.linalg.norm(q, axis=1) - 1) > OFF_UNIT
    if off.any():
        half = half_digit(q)
        least, most = (np.linalg.norm(np.maximum(q + step, 0), axis=1) for step in (-half, half))
        off &= (least > 1) | (most < 1)
    return off


def _are_no_nanoseconds(rows: Float[np.ndarray, "k columns"]) -> Bool[np.ndarray, " k"]:
    t = rows[:, 0]
    step = np.diff(t, prepend=-np.inf)
    return (t != np.round(t)) | ((step > 0) & (step < SHORTEST))


RISING: Check = (
    "its time does not lie after that of the line before",
    lambda rows: np.diff(rows[:, 0], prepend=-np.inf) <= 0,
)
UNIT_LENGTH: Check = ("its quaternion qx qy qz qw is not of unit length", _are_off_unit)
NANOSECONDS: Check = ("its time is not in whole nanoseconds", _are_no_nanoseconds)
