"""Results in the formats that other tools read, each file whole or not there at all."""

import re
from collections.abc import Mapping, Sequence
from numbers import Integral
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int, UInt8

from robot_perception import checks
from robot_perception.datasets.logs import CONTROL_BYTES
from robot_perception.datasets.tables import FORMULA
from studies.files import destination, written

PLAIN = re.compile(r"[\w.:/-]+\Z")
"""A text that needs no quotes."""
POSE_DECIMALS, POINT_DECIMALS = 9, 6  # of s and m; of m and px


def write_columns(
    path: str | Path, columns: Mapping[str, Sequence | np.ndarray], *, overwrite: bool = False
) -> None:
    """Write columns as CSV, their names in the first line, as `read_columns` reads them.

    Numbers are written so that they read back as they are, whole ones of any length too. Texts that
    need it stand in quotes, with every line break as one line feed and without blanks at the ends.
    One that a spreadsheet would take for a formula, since it begins with ``=``, ``+``, ``-`` or
    ``@``, gets a ``'`` before it.

    Parameters
    ----------
    path
        The file, in a folder that exists.
    columns : name -> (rows,)
        Finite numbers, or texts.
    overwrite
        Whether the file may be there already.

    Raises
    ------
    ValueError
        If there is no column, they differ in length, a number is not finite, or a name or a text
        has a control character.
    FileNotFoundError
        If there is no such folder.
    FileExistsError
        If the file is there and must not be.
    """
    path = destination(path, overwrite=overwrite)
    if not checks.instance("columns", columns, Mapping):
        raise ValueError("columns must be one at least, got none")
    names = [_text("columns", name) for name in columns]
    cells = [_cells(name, values) for name, values in columns.items()]
    if len({len(column) for column in cells}) > 1:
        lengths = dict(zip(names, map(len, cells), strict=True))
        raise ValueError(f"columns must be of one length, got {lengths}")
    _write(path, [",".join(row) for row in (names, *zip(*cells, strict=True))])


def write_tum(
    path: str | Path,
    times: Float[np.ndarray, " k"],
    poses: Float[np.ndarray, "k 4 4"],
    *,
    overwrite: bool = False,
) -> None:
    """Write a trajectory as ``timestamp tx ty tz qx qy qz qw``, as `read_track` reads it.

    Parameters
    ----------
    path
        The file, in a folder that exists.
    times : (k,)
        s, rising.
    poses : (k, 4, 4)
        Of the robot in the world, m; `geometry.se3.from_se2` makes them of poses in the plane.
    overwrite
        Whether the file may be there already.

    Raises
    ------
    ValueError
        If the times do not rise, or there is not a rigid motion for each.
    FileNotFoundError
        If there is no such folder.
    FileExistsError
        If the file is there and must not be.
    """
    path = destination(path, overwrite=overwrite)
    from scipy.spatial.transform import Rotation

    times = checks.array("times", times, ("k",))
    if (np.diff(times) <= 0).any():
        raise ValueError("times must rise, got one that does not lie after the one before")
    poses = _poses(poses)
    checks.shaped("poses", poses, (len(times), 4, 4), f"times {times.shape}")
    turns = Rotation.from_matrix(poses[:, :3, :3]).as_quat() if len(poses) else np.zeros((0, 4))
    rows = np.column_stack([times, poses[:, :3, 3], turns])
    _write(path, [" ".join(f"{value:.{POSE_DECIMALS}f}" for value in row) for row in rows])


def write_kitti(
    path: str | Path, poses: Float[np.ndarray, "k 4 4"], *, overwrite: bool = False
) -> None:
    """Write poses of a camera as the KITTI benchmark does: 3 × 4 by rows, a line for each picture.

    Parameters
    ----------
    path
        The file, in a folder that exists.
    poses : (k, 4, 4)
        ``T_first_camera`` of the left camera in the frame that it had at the first picture, m: x to
        the right, y down, z ahead.
    overwrite
        Whether the file may be there already.

    Raises
    ------
    ValueError
        If a pose is no rigid motion.
    FileNotFoundError
        If there is no such folder.
    FileExistsError
        If the file is there and must not be.
    """
    path = destination(path, overwrite=overwrite)
    rows = _poses(poses)[:, :3].reshape(-1, 12)
    _write(path, [" ".join(f"{value:.{POSE_DECIMALS}f}" for value in row) for row in rows])


def write_ply(
    path: str | Path,
    points: Float[np.ndarray, "n 3"],
    colours: UInt8[np.ndarray, "n 3"] | None = None,
    *,
    overwrite: bool = False,
) -> None:
    """Write points as PLY, in text, as viewers of point clouds read it.

    Parameters
    ----------
    path
        The file, in a folder that exists.
    points : (n, 3)
        m.
    colours : (n, 3)
        Red, green and blue of each.
    overwrite
        Whether the file may be there already.

    Raises
    ------
    TypeError
        If the colours are no bytes.
    ValueError
        If points or colours are of another shape, or a number is not finite.
    FileNotFoundError
        If there is no such folder.
    FileExistsError
        If the file is there and must not be.
    """
    path = destination(path, overwrite=overwrite)
    points = checks.array("points", points, ("n", 3))
    header = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    header += [f"property double {axis}" for axis in "xyz"]
    rows = [" ".join(f"{value:.{POINT_DECIMALS}f}" for value in point) for point in points]
    if colours is not None:
        if not isinstance(colours, np.ndarray) or colours.dtype != np.uint8:
            raise TypeError(f"colours must be an array of bytes, got {checks.shown(colours)}")
        checks.shaped("colours", colours, points.shape, f"points {points.shape}")
        header += [f"property uchar {name}" for name in ("red", "green", "blue")]
        rows = [f"{row} {r} {g} {b}" for row, (r, g, b) in zip(rows, colours, strict=True)]
    _write(path, [*header, "end_header", *rows])


def write_mot(
    path: str | Path,
    frames: Int[np.ndarray, " n"],
    identities: Int[np.ndarray, " n"],
    *,
    boxes: Float[np.ndarray, "n 4"] | None = None,
    points: Float[np.ndarray, "n 3"] | None = None,
    confidences: Float[np.ndarray, " n"] | None = None,
    overwrite: bool = False,
) -> None:
    """Write tracks as the MOT challenge does, ``frame,id,left,top,`` ``width,height,conf,x,y,z``.

    The file counts columns and rows of pixels from 1. What is not given is -1, a confidence 1.
    Boxes and points have six decimals, confidences as many as they need. Without rows the file is
    empty.

    Parameters
    ----------
    path
        The file, in a folder that exists.
    frames : (n,)
        Number of the picture or reading of each row, counted from 1.
    identities : (n,)
        Of which track it is, counted from 1.
    boxes : (n, 4)
        Column and row of the first pixel inside, counted from 0, width and height, px.
    points : (n, 3)
        Places in the world, m.
    confidences : (n,)
        How sure it is.
    overwrite
        Whether the file may be there already.

    Raises
    ------
    ValueError
        If shapes disagree, a frame or an identity is below 1, a track is twice in a frame, or a
        number is not finite.
    FileNotFoundError
        If there is no such folder.
    FileExistsError
        If the file is there and must not be.
    """
    path = destination(path, overwrite=overwrite)
    frames = checks.integers("frames", frames, ("n",), 1)
    n, beside = len(frames), f"frames {frames.shape}"
    identities = checks.integers("identities", identities, (n,), 1, beside)
    if len(np.unique(pairs := np.stack([frames, identities], axis=1), axis=0)) < n:
        found, counts = np.unique(pairs, axis=0, return_counts=True)
        frame, identity = found[counts > 1][0].tolist()
        raise ValueError(f"identities must be once in a frame, got {identity} twice in {frame}")
    told = {"boxes": (boxes, 4), "points": (points, 3), "confidences": (confidences, 0)}
    parts = {
        name: np.full((n, size or 1), 1.0 if name == "confidences" else -1.0)
        if value is None
        else checks.array(name, value, (n, size) if size else (n,), beside).reshape(n, size or 1)
        for name, (value, size) in told.items()
    }
    if boxes is not None:
        parts["boxes"] = parts["boxes"] + [1, 1, 0, 0]
    order = np.lexsort([identities, frames])
    table = [frames, identities, *parts["boxes"].T, *parts["confidences"].T, *parts["points"].T]
    exact = (True, True, *[False] * 4, True, *[False] * 3)
    cells = [
        [_exact(value) if as_is else _decimal(value) for value in column[order].tolist()]
        for column, as_is in zip(table, exact, strict=True)
    ]
    _write(path, [",".join(row) for row in zip(*cells, strict=True)])


def _poses(poses: np.ndarray) -> np.ndarray:
    from robot_perception.geometry import se3

    checks.shaped("poses", checks.array("poses", poses, ("k", 4, 4)), ("k", 4, 4))
    return se3.checked("poses", poses)


def _cells(name: str, values: Sequence | np.ndarray) -> list[str]:
    what = f"columns[{name!r}]"
    if isinstance(values, list | tuple) and all(isinstance(value, str) for value in values):
        return [_text(what, value) for value in values]
    if isinstance(values, np.ndarray) and values.dtype.kind == "U":
        return [_text(what, value) for value in values.ravel().tolist()]
    numbers = checks.array(what, values, ("rows",))
    told = np.asarray(values).tolist()
    if told and all(isinstance(value, Integral) for value in told):
        return [str(int(value)) for value in told]
    return [_exact(value) for value in numbers.tolist()]


def _exact(value: float) -> str:
    """Return the shortest decimal number that is read as this one."""
    return repr(value).removesuffix(".0")


def _decimal(value: float) -> str:
    """Return a number to the last decimal of a point, without zeros at its end."""
    text = f"{value:.{POINT_DECIMALS}f}".rstrip("0").removesuffix(".")
    return "0" if text == "-0" else text


def _text(name: str, value: str) -> str:
    """Return a text as a cell of a table."""
    lines = checks.instance(name, value, str).replace("\r\n", "\n").replace("\r", "\n")
    text = lines.strip(" \t\n\v\f")
    if not _is_writable(text):
        raise ValueError(f"{name} must have texts without control characters, got {value!r}")
    text = f"'{text}" if FORMULA.match(text) else text
    return text if PLAIN.match(text) else '"' + text.replace('"', '""') + '"'


def _is_writable(text: str) -> bool:
    try:
        return not CONTROL_BYTES.search(text.encode())
    except UnicodeEncodeError:
        return False


def _write(path: Path, lines: list[str]) -> None:
    with written(path) as beside:
        beside.write_text("".join(f"{line}\n" for line in lines), "utf-8")
