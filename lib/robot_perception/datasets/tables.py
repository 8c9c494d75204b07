"""One's own tables: columns by name, and the readings of a laser, a line a scan."""

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.checks import instance, instances, number
from robot_perception.datasets import limits as sensible
from robot_perception.datasets.logs import (
    CorruptLog,
    Lines,
    are_numbers,
    as_path,
    in_seconds,
    to_numbers,
)
from studies.files import reading

FARTHEST = 1e6
"""A reading beyond it is no distance, m, unless it is one of those that mean "no return"."""
NOTHING = (float(np.finfo(np.float32).max), float(np.finfo(float).max))
TIME = "time_s"
LARGEST_WHOLE = 2.0**63 - 1024  # the last number below what 64 bits hold
WHOLE = re.compile(rb"[+-]?[0-9]+\Z")
FORMULA = re.compile(r"'*[=+\-@]")
"""A text that a spreadsheet would compute, but for a ``'`` that is written before it."""


class Rows(NamedTuple):
    """Columns of a table, and from which lines they are.

    Parameters
    ----------
    path
        The file.
    columns
        By name, each (rows,).
    numbers
        The line of each row.
    """

    path: Path
    columns: dict[str, np.ndarray]
    numbers: list[int]

    def check(self, bad: Bool[np.ndarray, " rows"], reason: Callable[[int], str]) -> None:
        """Raise ``CorruptLog`` at the line of the first bad row; the reason is a function of it."""
        if bad.any():
            row = int(np.argmax(bad))
            raise CorruptLog(f"{self.path}, line {self.numbers[row]}: {reason(row)}")

    def check_order(self, name: str, what: str, *, rising: bool = False) -> None:
        """Raise ``CorruptLog`` where a column falls, or does not rise.

        Parameters
        ----------
        name
            Of the column.
        what
            What its numbers are.
        rising
            Whether each must be above the one before.
        """
        values = self.columns[name]
        steps = np.diff(values)
        must = f"{what} must {'rise' if rising else 'not fall'}, got"
        self.check(
            np.append(False, steps <= 0 if rising else steps < 0),
            lambda k: f"{must} {values[k - 1]:.15g} before {values[k]:.15g}",
        )

    def check_positive(self, name: str, where: Bool[np.ndarray, " rows"] | bool = True) -> None:
        """Raise ``CorruptLog`` where numbers of a column should be positive and are not."""
        values = self.columns[name]
        bad = (values <= 0) & where
        self.check(bad, lambda k: f"{name} must be positive, got {values[k]:g}")


def read_columns(
    path: str | Path,
    limits: Mapping[str, float],
    *,
    optional: Collection[str] = (),
    integers: Collection[str] = (),
    texts: Collection[str] = (),
    time_unit: str = "s",
) -> dict[str, np.ndarray]:
    """Read columns of a CSV file, plain or gzip, by the names in its first line.

    Cells are parted by semicolons, tabs, commas or blanks, as in the first line, and may be quoted;
    between semicolons or tabs numbers may have decimal commas. Columns of other names are left out;
    empty lines and lines that begin with ``#`` are comments, of which one before the first row may
    hold the names.

    Parameters
    ----------
    path
        The file.
    limits : name -> largest magnitude
        The columns to read. A number beyond its limit is taken for one in another unit.
    optional
        Which of them the file may lack.
    integers
        Which of them hold whole numbers.
    texts
        Further columns to read, which hold words. The ``'`` that keeps a spreadsheet from computing
        a text such as ``'=1`` is left out, and so are blanks at its ends.
    time_unit
        What the column ``time_s`` counts time in: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``.

    Returns
    -------
    dict
        By name, those of the columns that the file has, each (rows,), times in s; those of words
        last.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, lacks a column or names it twice, or has no row; at the
        first line that has too few or too many cells, or a number that is not finite, not whole or
        beyond its limit; if the times of ``time_s`` are in another unit.
    FileNotFoundError
        If there is no such file.
    """
    how = {"optional": optional, "integers": integers, "texts": texts, "time_unit": time_unit}
    return read_rows(path, limits, **how).columns


def read_rows(
    path: str | Path,
    limits: Mapping[str, float],
    *,
    optional: Collection[str] = (),
    integers: Collection[str] = (),
    texts: Collection[str] = (),
    time_unit: str = "s",
) -> Rows:
    """Read columns as `read_columns` does, and from which lines they are."""
    for name, limit in instance("limits", limits, Mapping).items():
        number(f"limits[{name!r}]", limit, finite=False)
    optional, integers = instances("optional", optional, str), instances("integers", integers, str)
    texts, ticks = instances("texts", texts, str), sensible.per_second(time_unit)
    lines = Lines(path)
    header, rows = _header(lines, {*limits, *texts} - {*optional})
    missing = [name for name in limits if name not in header and name not in optional]
    missing += [f"of texts {name}" for name in texts if name not in header and name not in optional]
    if missing:
        found = ", ".join(header) or "nothing"
        raise lines.error(f"no column {' and no column '.join(missing)}; there is {found}")
    wanted = [name for name in limits if name in header]
    words = [name for name in texts if name in header]
    twice = [name for name in (*wanted, *words) if header.count(name) > 1]
    if twice:
        raise lines.error(f"column {twice[0]} is there twice")
    places = [header.index(name) for name in wanted]
    whole = np.array([name in integers for name in wanted])
    bounds = np.array([limits[name] for name in wanted])
    bounds = np.where(whole, np.minimum(bounds, LARGEST_WHOLE), bounds)
    scales = np.array([ticks if name == TIME else 1 for name in wanted])
    table, told, exact = [], {name: [] for name in words}, {name: [] for name in integers}
    numbers = []
    for row in rows:
        lines.expect(row, len(header))
        cells = lines.points([row[place] for place in places])
        values = np.array([_number(cell) for cell in cells])
        good = (np.abs(values / scales) <= bounds) & np.isfinite(values)
        good &= ~whole | (values == np.round(values))
        if not good.all():
            k = int(np.argmin(good))
            cell = row[places[k]].decode()
            raise lines.error(f"{wanted[k]} is {cell!r}, {_reason(values[k], bounds[k])}")
        for name in words:
            told[name].append(_unguarded(row[header.index(name)].decode()))
            if not told[name][-1]:
                raise lines.error(f"{name} is empty")
        for name, cell, value, is_whole in zip(wanted, cells, values, whole, strict=True):
            if is_whole:
                exact[name].append(int(cell) if WHOLE.match(cell) else int(value))
        table.append(values)
        numbers.append(lines.number)
    lines.kept["row"] = len(table)
    lines.need("row")
    columns = dict(zip(wanted, np.array(table).T, strict=True))
    columns |= {name: np.array(exact[name], np.int64) for name in integers if name in columns}
    if TIME in columns:
        seconds = in_seconds(lines.path, columns[TIME], time_unit)
        columns[TIME] = seconds if ticks > 1 else columns[TIME]
    columns |= {name: np.array(values) for name, values in told.items()}
    return Rows(lines.path, columns, numbers)


def read_ranges(path: str | Path, *, max_range: float) -> Float[np.ndarray, "scans beams"]:
    """Read the readings of a laser from a NumPy array, or from CSV with a line for each scan.

    Parameters
    ----------
    path
        The file, ``.npy`` or CSV without names of columns, plain or gzip; numbers in m, ``inf``
        where the beam came back from nothing, ``nan`` where the reading is void.
    max_range
        Readings of at least this many metres mean "no return" and become ``inf``.

    Returns
    -------
    (scans, beams)
        m.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged; at the first line that holds no number, or more or fewer
        than the first.
    ValueError
        If an array is not (scans, beams), or no reading is below ``max_range``.
    FileNotFoundError
        If there is no such file.
    """
    path = as_path(path)
    max_range = number("max_range", max_range, finite=False)
    if not max_range > 0:
        raise ValueError(f"max_range must be positive, got {max_range}")
    if path.suffix == ".npy":
        with reading(path, "no array of numbers", CorruptLog):
            stored = np.load(path, allow_pickle=False)
            ranges = np.asarray(stored, dtype=float)
            _check_readings(stored)
    else:
        lines, rows = Lines(path), []
        for row in lines.rows():
            lines.expect(row, len(rows[0]) if rows else _width(row))
            cells = lines.points(row)
            if not are_numbers(cells):
                k = next(k for k, cell in enumerate(cells) if not are_numbers([cell]))
                told = f"{cells[k].decode()!r} in column {k + 1}"
                raise lines.error(f"a value is not a number: {told}")
            rows.append(to_numbers(cells))
        lines.kept["scan"] = len(rows)
        lines.need("scan")
        ranges = np.array(rows)
    if ranges.ndim != 2 or not ranges.size:
        raise ValueError(f"{path}: ranges must be (scans, beams), got {ranges.shape}")
    if not (ranges < max_range).any():
        raise ValueError(f"{path}: no reading is below {max_range:g} m; are they in metres?")
    return np.where(ranges >= max_range, np.inf, ranges)


def _check_readings(stored: np.ndarray) -> None:
    """Raise unless all numbers are such as a laser gives: distances, infinity, and the one NaN.

    Of a byte that fell over, this is what can be seen.
    """
    if stored.dtype.kind != "f":
        return
    void = stored[np.isnan(stored)]
    usual = np.abs(np.full_like(void, np.nan)).tobytes()
    far = np.isfinite(stored) & (np.abs(stored) > FARTHEST) & ~np.isin(np.abs(stored), NOTHING)
    if np.abs(void).tobytes() != usual:
        raise ValueError("a reading is no distance in metres, but another NaN than NumPy's")
    if far.any():
        place = np.argwhere(far)[0]
        told = ", ".join(str(k + 1) for k in place)
        raise ValueError(f"reading {told} is {stored[tuple(place)]:g}, no distance in metres")


def _header(lines: Lines, needed: set[str]) -> tuple[list[str], Iterator[list[bytes]]]:
    """Return the names of columns and the rows after them.

    The names are in the first row, or in a comment before it that has all that are needed.
    """
    rows = lines.rows()
    first = next(rows, [])
    header = _names(first)
    if not needed <= set(header):
        for cells in lines.headings():
            if needed <= set(_names(cells)):
                return _names(cells), chain([first] if first else [], rows)
    return header, rows


def _names(cells: list[bytes]) -> list[str]:
    return [_unguarded(cell.decode()) for cell in cells[: _width(cells)]]


def _width(cells: list[bytes]) -> int:
    """Return how many cells there are before the empty ones at the end."""
    return max((place for place, cell in enumerate(cells, start=1) if cell), default=0)


def _unguarded(text: str) -> str:
    return text[1:] if text.startswith("'") and FORMULA.match(text) else text


def _number(cell: bytes) -> float:
    """Return a cell as a number, NaN if it is none."""
    return float(to_numbers([cell])[0]) if are_numbers([cell]) else np.nan


def _reason(value: float, bound: float) -> str:
    if not np.isfinite(value):
        return "not a finite number"
    return f"beyond {bound:g}: is the unit right?" if abs(value) > bound else "not a whole number"
