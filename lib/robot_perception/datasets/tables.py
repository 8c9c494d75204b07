"""One's own tables: columns by name, and the readings of a laser, a line a scan."""

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Float

from robot_perception.checks import instance, instances, number
from robot_perception.datasets.logs import CorruptLog, Lines, as_path, to_numbers
from robot_perception.files import reading

FARTHEST = 1e6
"""A reading beyond it is no distance, m, unless it is one of those that mean "no return"."""
NOTHING = (float(np.finfo(np.float32).max), float(np.finfo(float).max))


def read_columns(
    path: str | Path,
    limits: Mapping[str, float],
    *,
    optional: Collection[str] = (),
    integers: Collection[str] = (),
    texts: Collection[str] = (),
) -> dict[str, np.ndarray]:
    """Read columns of a CSV file, plain or gzip, by the names in its first line.

    Columns of other names are left out; empty lines and lines that begin with ``#`` are comments.

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
        Further columns to read, which hold words.

    Returns
    -------
    dict
        By name, those of the columns that the file has, each (rows,); those of words last.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, lacks a column or names it twice, or has no row; at the
        first line that has too few or too many cells, or a number that is not finite, not whole or
        beyond its limit.
    FileNotFoundError
        If there is no such file.
    """
    for name, limit in instance("limits", limits, Mapping).items():
        number(f"limits[{name!r}]", limit, finite=False)
    optional, integers = instances("optional", optional, str), instances("integers", integers, str)
    texts = instances("texts", texts, str)
    lines = Lines(path)
    rows = _cells(lines)
    header = [name.decode("utf-8-sig") for name in next(rows, [])]
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
    bounds = np.array([limits[name] for name in wanted])
    whole = np.array([name in integers for name in wanted])
    table, told = [], {name: [] for name in words}
    for row in rows:
        lines.expect(row, len(header))
        values = np.array([_number(row[place]) for place in places])
        good = (np.abs(values) <= bounds) & np.isfinite(values)
        good &= ~whole | (values == np.round(values))
        if not good.all():
            k = int(np.argmin(good))
            cell = row[places[k]].decode()
            raise lines.error(f"{wanted[k]} is {cell!r}, {_reason(values[k], bounds[k])}")
        for name in words:
            told[name].append(row[header.index(name)].decode("utf-8", "replace"))
            if not told[name][-1]:
                raise lines.error(f"{name} is empty")
        table.append(values)
    lines.kept["row"] = len(table)
    lines.need("row")
    columns = dict(zip(wanted, np.array(table).T, strict=True))
    return {
        name: values.astype(np.int64) if name in integers else values
        for name, values in columns.items()
    } | {name: np.array(values) for name, values in told.items()}


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
    if not number("max_range", max_range, finite=False) > 0:
        raise ValueError(f"max_range must be positive, got {max_range}")
    if path.suffix == ".npy":
        with reading(path, "no array of numbers", CorruptLog):
            stored = np.load(path, allow_pickle=False)
            ranges = np.asarray(stored, dtype=float)
            _check_readings(stored)
    else:
        lines, rows = Lines(path), []
        for row in _cells(lines):
            lines.expect(row, len(rows[0]) if rows else len(row))
            try:
                rows.append(to_numbers(row))
            except ValueError:
                raise lines.error("a value is not a number") from None
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
    far = np.abs(stored[np.isfinite(stored) & (np.abs(stored) > FARTHEST)])
    if np.abs(void).tobytes() != usual or not np.isin(far, NOTHING).all():
        raise ValueError("a reading is no distance in metres")


def _cells(lines: Lines) -> Iterator[list[bytes]]:
    """Yield the cells of each line of a CSV file."""
    for words in lines.words():
        yield [cell.strip() for cell in b" ".join(words).split(b",")]


def _number(cell: bytes) -> float:
    """Return a cell as a number, NaN if it is none."""
    try:
        return float(to_numbers([cell])[0])
    except ValueError:
        return np.nan


def _reason(value: float, bound: float) -> str:
    if not np.isfinite(value):
        return "not a finite number"
    return f"beyond {bound:g}: is the unit right?" if abs(value) > bound else "not a whole number"
