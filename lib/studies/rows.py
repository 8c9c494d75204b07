"""Rows of a study: one for each trial and each thing that the trial tells apart, by name.

A column is the replicate (a film, a person, a seed), a factor that the study varies, or a measure.
Values, intervals and tables are expressions over rows, the same on a page, in the ledger and in a
test; which kind of number carries which interval is decided in `studies.intervals`.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import Any

import numpy as np
import pandas as pd

from studies import intervals
from studies.intervals import Interval
from studies.tables import Cell, Table

Levels = tuple[str, Any, Any]
"""A factor and two of its levels: the first is compared with the second."""
Say = Callable[["Rows"], Cell] | tuple[Any, ...]
"""Expression over rows in a cell of a table: a function, or a method of `Rows` and its measures."""


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Rows:
    """Rows of a study.

    Parameters
    ----------
    table
        A column each for replicate, factors and measures.
    replicate
        Name of the column of replicates.
    fixed
        Other parameters that the trials had.
    note
        One sentence that says where the rows come from.
    """

    table: pd.DataFrame
    replicate: str
    fixed: Mapping[str, Any]
    note: str = ""

    def __len__(self) -> int:
        return len(self.table)

    def __repr__(self) -> str:
        return f"{self.table}\n{self.note}"

    def _repr_html_(self) -> str:
        """Return the table as pandas shows it, and where it comes from."""
        return f"{self.table._repr_html_()}<p>{escape(self.note)}</p>"

    def where(self, **levels: Any) -> "Rows":
        """Return the rows in which factors have some levels; of several, give a tuple.

        Raises
        ------
        KeyError
            If there is no such column.
        ValueError
            If no row has one of the levels, or no row all that are asked for together.
        """
        table = self.table
        for name, level in levels.items():
            there = self.levels(name)
            wanted = list(level) if isinstance(level, tuple | list | range) else [level]
            missing = [one for one in wanted if one not in there]
            table = table[table[name].isin(wanted)]
            if missing or not len(table):
                asked = ", ".join(map(repr, missing)) if missing else repr(level)
                raise ValueError(f"no row has {name} {asked}; there are {there}")
        return replace(self, table=table)

    def of(self, measure: str, **levels: Any) -> np.ndarray:
        """Return the values of a measure, in the order of the rows, where factors have levels."""
        return self.where(**levels)._column(measure).to_numpy()

    def levels(self, factor: str) -> tuple[Any, ...]:
        """Return the levels of a factor, in the order in which they come."""
        return tuple(self._column(factor).unique().tolist())

    def per(self, *names: str) -> "Rows":
        """Return the means of all measures for each replicate, or for each of the columns named."""
        keys = list(names or (self.replicate,))
        groups = self.table.groupby(keys, sort=False, dropna=False)
        first = self.table.drop_duplicates(keys)[keys]  # the index of groups has NaN for None
        means = groups.mean(numeric_only=True)
        return replace(self, table=first.reset_index(drop=True).join(means.reset_index(drop=True)))

    def mean(self, measure: str, unit: str = "", **levels: Any) -> Interval:
        """Return the mean of a measure with its bootstrap interval over the rows.

        Where something is so in all rows or in none, a bootstrap has no width: it is their rate.
        """
        values = self._numbers(measure, levels)
        if not unit and self._column(measure).dtype == bool and np.ptp(values) == 0:
            return self.rate(measure, **levels)
        return intervals.bootstrap_mean(values, unit)

    def rate(self, measure: str, **levels: Any) -> Interval:
        """Return the share of the rows in which something is so, with its Wilson interval."""
        values = self._numbers(measure, levels)
        return intervals.proportion(int(values.sum()), values.size)

    def spread(self, measure: str, unit: str = "", **levels: Any) -> Interval:
        """Return the median of a measure and the central range that holds 95 % of the rows."""
        return intervals.spread(self._numbers(measure, levels), unit)

    def median(self, measure: str, **levels: Any) -> float:
        """Return the median of a measure."""
        return float(np.median(self._numbers(measure, levels)))

    def largest(self, measure: str, **levels: Any) -> float:
        """Return the largest value of a measure."""
        return float(self._numbers(measure, levels).max())

    def share(self, part: str, whole: str, **levels: Any) -> Interval:
        """Return the sum of one measure over that of another, with its bootstrap interval."""
        return intervals.bootstrap_ratio(self._numbers(part, levels), self._numbers(whole, levels))

    def ratio(self, measure: str, over: Levels, **levels: Any) -> Interval:
        """Return the ratio of the means at two levels of a factor, paired by replicate."""
        return intervals.bootstrap_ratio(*self._pairs(measure, over, levels))

    def difference(self, measure: str, over: Levels, unit: str = "", **levels: Any) -> Interval:
        """Return the mean difference between two levels of a factor, paired by replicate."""
        above, below = self._pairs(measure, over, levels)
        return intervals.bootstrap_mean(above - below, unit)

    def by(
        self,
        factor: str,
        columns: Mapping[str, Say],
        words: Mapping[str, str] | None = None,
        about: str = "",
        corner: str | None = None,
    ) -> Table:
        """Return a table with a row for each level of a factor.

        Parameters
        ----------
        factor
            What the rows of the table are.
        columns
            By the name of the column, what it says of the rows at a level: a function of them, or
            a method and its measures, such as ``("rate", "found")``.
        words
            What each column is, in words.
        about, corner
            As for `Table`; the corner is the factor's name by default.
        """
        said = words or {}
        cells = {
            f"{level}": [value_of(say, self.where(**{factor: level})) for say in columns.values()]
            for level in self.levels(factor)
        }
        heads = {name: said.get(name, "") for name in columns}
        return Table(cells, heads, about, factor if corner is None else corner)

    def cross(
        self,
        rows: str,
        columns: str,
        say: Say,
        about: str = "",
        named: Callable[[Any], str] = str,
    ) -> Table:
        """Return a table of two factors: what is said of the rows at each pair of levels."""
        cells = {
            f"{one}": [
                value_of(say, self.where(**{rows: one, columns: other}))
                for other in self.levels(columns)
            ]
            for one in self.levels(rows)
        }
        return Table(cells, {named(level): "" for level in self.levels(columns)}, about, rows)

    def _column(self, name: str) -> pd.Series:
        if name not in self.table:
            raise KeyError(f"no column {name!r}; there are {', '.join(self.table)}")
        return self.table[name]

    def _numbers(self, measure: str, levels: Mapping[str, Any]) -> np.ndarray:
        return self.of(measure, **levels).astype(float)

    def _pairs(
        self, measure: str, over: Levels, levels: Mapping[str, Any]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return a measure at two levels, whose rows belong to the same replicates one by one."""
        factor, *ends = over
        parts = [self.where(**levels, **{factor: level}) for level in ends]
        first, last = (part.of(self.replicate) for part in parts)
        if not np.array_equal(first, last):
            raise ValueError(f"{measure} at {ends[0]!r} and {ends[1]!r} is not of the same trials")
        return parts[0]._numbers(measure, {}), parts[1]._numbers(measure, {})


def value_of(say: Say, rows: Rows) -> Cell:
    """Return what a function, or a method and its measures, says of rows."""
    if callable(say):
        return say(rows)
    method, *measures = say
    return getattr(rows, method)(*measures)


def framed(parts: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """Return what trials have found as one table: a row each, or as many as their arrays are long.

    Raises
    ------
    ValueError
        If a number is not finite, or trials have not the same columns.
    """
    frames = [pd.DataFrame(_columns(part)) for part in parts]
    names = list(frames[0].columns)
    for frame in frames:
        if list(frame.columns) != names:
            raise ValueError(f"trials must give the same: {names}, and {list(frame.columns)}")
    table = pd.concat(frames, ignore_index=True)
    for name in table.select_dtypes("number"):
        if not np.isfinite(table[name].to_numpy(dtype=float)).all():
            raise ValueError(f"{name} must be finite in every row")
    return table


def _columns(part: Mapping[str, Any]) -> dict[str, Sequence[Any] | np.ndarray]:
    sizes = {np.size(value) for value in part.values() if np.ndim(value)}
    size = max(sizes, default=1)
    if len(sizes) > 1:
        raise ValueError(f"the arrays of a trial must be of one length, got {sorted(sizes)}")
    return {
        name: np.asarray(value) if np.ndim(value) else np.repeat(np.asarray(value), size)
        for name, value in part.items()
    }
