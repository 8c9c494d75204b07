"""Times of pictures from a file that stands beside them."""

import re
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from robot_perception.datasets import limits
from robot_perception.datasets.logs import CorruptLog, Lines, are_numbers
from robot_perception.datasets.names import Numbering, clock_unit

TIMES = ("times.txt", "timestamps.txt", "times.csv", "timestamps.csv")
"""Names of files of which every line is the time of a picture."""
DAY = re.compile(rb"\d{4}-\d\d-\d\d")
OF_DAY = re.compile(rb"\d\d:\d\d:\d\d(\.\d{1,9})?")
LONG = 10.0  # s between two pictures: from here on whole numbers are asked for a smaller unit
NANOSECONDS = 10**9


class Stamps(NamedTuple):
    """Times that a file beside pictures gives.

    Parameters
    ----------
    path
        The file.
    times
        Of the pictures, s, rising; none where the file does not fit them.
    remark
        A sentence on what was read, or why it was not.
    """

    path: Path
    times: tuple[float, ...] | None
    remark: str


def times_beside(folder: Path, pictures: Numbering) -> Stamps | None:
    """Return the times of pictures by a file in their folder or beside it, if there is one.

    ``times.txt`` or ``timestamps.txt`` has a line for each picture: a number whose unit the numbers
    tell, seconds and nanoseconds, or a date and a time of day. Where there are more lines than
    pictures, the number of a picture is that of its line, from 0. A table that names the files,
    such as EuRoC's ``data.csv`` or the ``rgb.txt`` of TUM beside the folder ``rgb``, may be in any
    order.

    Parameters
    ----------
    folder
        Where the pictures are.
    pictures
        The pictures.
    """
    for name in (*TIMES, "data.csv", f"{folder.name}.txt", f"{folder.name}.csv"):
        for path in (folder / name, folder.parent / name):
            if not path.is_file():
                continue
            try:
                times, how = _times(path, pictures)
            except CorruptLog as error:
                if name in TIMES:
                    return Stamps(path, None, f"times beside the pictures are not used: {error}")
                continue
            return Stamps(path, times, f"times of the pictures are those of {name}, {how}")
    return None


def _times(path: Path, pictures: Numbering) -> tuple[tuple[float, ...], str]:
    """Return the time of each picture, s, and how the file has them, or raise ``CorruptLog``."""
    lines, names, cells, numbers = Lines(path), [], [], []
    for words in lines.rows():
        words = b" ".join(words).split()
        told = [word for word in words if _is_time(word)]
        if not told and not cells:  # names of columns
            continue
        if not told or (cells and len(told) != len(cells[0])):
            raise lines.error(f"no time, or more than in other lines: {b' '.join(words).decode()}")
        names.append([word.decode() for word in words if word not in told])
        cells.append(told)
        numbers.append(lines.number)
    rows = _rows(path, names, pictures)
    ticks, per_second, how = _ticks(path, [cells[row] for row in rows], pictures)
    for k, (one, other) in enumerate(pairwise(ticks)):
        if one >= other:
            raise lines.error("its time does not lie after that before", numbers[rows[k + 1]])
    return tuple(tick / per_second for tick in ticks), how


def _is_time(word: bytes) -> bool:
    return bool(are_numbers([word]) or DAY.fullmatch(word) or OF_DAY.fullmatch(word))


def _rows(path: Path, names: list[list[str]], pictures: Numbering) -> list[int]:
    """Return which row is that of each picture."""
    if any(names):
        by_name = {Path(one[-1]).name: row for row, one in enumerate(names) if one}
        lost = [picture.name for picture in pictures.paths if picture.name not in by_name]
        if lost:
            raise CorruptLog(f"{path}: {len(lost)} pictures have no time, the first is {lost[0]}")
        return [by_name[picture.name] for picture in pictures.paths]
    if len(names) == len(pictures.paths):
        return list(range(len(names)))
    if pictures.composed or len(names) <= pictures.numbers[-1]:
        raise CorruptLog(f"{path}: {len(names)} times for {len(pictures.paths)} pictures")
    return list(pictures.numbers)


def _ticks(
    path: Path, cells: list[list[bytes]], pictures: Numbering
) -> tuple[list[int] | list[float], int, str]:
    """Return numbers that are times, what a second holds of them, and how they were written."""
    if all(len(row) == 2 and DAY.fullmatch(row[0]) and OF_DAY.fullmatch(row[1]) for row in cells):
        stamps = [np.datetime64(b"T".join(row).decode(), "ns") for row in cells]
        return [int(stamp.astype(np.int64)) for stamp in stamps], NANOSECONDS, "by date"
    if not all(are_numbers(row) for row in cells):
        raise CorruptLog(f"{path}: a day or a time of day alone is no time")
    columns = [_numbers(column) for column in zip(*cells, strict=True)]
    if len(columns) == 2:
        first, second = columns
        if tuple(first) in (pictures.numbers, tuple(range(len(first)))):
            columns = [second]
        elif clock_unit(first) == 1 and all(0 <= part < NANOSECONDS for part in second):
            pairs = zip(first, second, strict=True)
            ticks = [NANOSECONDS * whole + part for whole, part in pairs]
            return ticks, NANOSECONDS, "in seconds and nanoseconds"
    if len(columns) != 1:
        raise CorruptLog(f"{path}: {len(columns)} numbers in a line, of which one should be a time")
    (ticks,) = columns
    unit = _unit(path, ticks)
    return ticks, limits.UNITS[unit], f"in {limits.NAMES[unit]}"


def _numbers(words: tuple[bytes, ...]) -> list[int] | list[float]:
    """Return words as numbers, whole ones exactly."""
    return [int(word) if word.isdigit() else float(word) for word in words]


def _unit(path: Path, ticks: list[int] | list[float]) -> str:
    """Return the unit in which numbers count time."""
    per_second = clock_unit(ticks)
    if per_second:
        return next(unit for unit, count in limits.UNITS.items() if count == per_second)
    times = np.array(ticks, dtype=float)
    step = np.median(np.diff(times)) if len(times) > 1 else 0.0
    fault = limits.time_fault(times, "s")
    unit = "s" if step <= LONG and not fault else limits.likely_unit(times)
    if not unit:
        raise CorruptLog(f"{path}: {fault}")
    return unit
