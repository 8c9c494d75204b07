"""Tables of results: one type for the evidence of a claim and for what a chapter shows."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from explorables.media import Shown, html_table
from studies.intervals import Interval

Cell = Interval | float | str | None
"""Contents of a cell: a number with its interval, a bare one, a word, or nothing."""


@dataclass(frozen=True, slots=True)
class Table:
    """Numbers with their intervals by row and column.

    Parameters
    ----------
    rows
        Cells in the order of the columns, by name of the row.
    columns
        What each column is, in words, by its name; the name carries the unit, as in "end (m)".
    about
        What is beside the numbers, for instance "mean and 95 % bootstrap interval over 50 runs".
    corner
        What the rows are.

    Raises
    ------
    ValueError
        If a row has more or fewer cells than there are columns, there is no column, or a number is
        not finite.
    TypeError
        If a cell is no interval, number, text or ``None``.
    """

    rows: Mapping[str, Sequence[Cell]]
    columns: Mapping[str, str]
    about: str = ""
    corner: str = ""

    def __post_init__(self) -> None:
        if not self.columns:
            raise ValueError("columns must not be empty: a table needs a column")
        rows = {name: tuple(map(_checked, cells)) for name, cells in self.rows.items()}
        for name, cells in rows.items():
            if len(cells) != len(self.columns):
                raise ValueError(
                    f"row {name!r} has {len(cells)} cells for {len(self.columns)} columns"
                )
        object.__setattr__(self, "rows", rows)
        object.__setattr__(self, "columns", dict(self.columns))

    def __getitem__(self, place: tuple[str, str]) -> Cell:
        """Return the cell of a row and a column.

        Raises
        ------
        KeyError
            If the table has no such row or column; it names those it has.
        """
        row, column = place
        if row not in self.rows:
            raise KeyError(f"no row {row!r}; there are {', '.join(self.rows)}")
        if column not in self.columns:
            raise KeyError(f"no column {column!r}; there are {', '.join(self.columns)}")
        return self.rows[row][list(self.columns).index(column)]

    def pick(
        self, rows: Sequence[str] | None = None, columns: Sequence[str] | None = None
    ) -> "Table":
        """Return the table of some rows and columns, in the order given.

        Raises
        ------
        KeyError
            If the table has no such row or column.
        """
        rows = self.rows if rows is None else rows
        columns = self.columns if columns is None else columns
        cells = {row: [self[row, column] for column in columns] for row in rows}
        return Table(cells, {c: self.columns[c] for c in columns}, self.about, self.corner)

    def to_plain(self) -> dict[str, Any]:
        """Return the table in plain types that JSON can hold; an interval is a list of three."""
        return {
            "corner": self.corner,
            "about": self.about,
            "columns": dict(self.columns),
            "rows": {
                name: [[c.estimate, c.low, c.high] if isinstance(c, Interval) else c for c in cells]
                for name, cells in self.rows.items()
            },
        }

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Table":
        """Return the table of :meth:`to_plain`; its intervals take their meaning from `about`."""
        missing = {"rows", "columns", "about", "corner"} - plain.keys()
        if missing:
            raise ValueError(f"plain is no table: it lacks {', '.join(sorted(missing))}")
        rows = {
            name: [Interval(*c, "", plain["about"]) if isinstance(c, list) else c for c in cells]
            for name, cells in plain["rows"].items()
        }
        return cls(rows, plain["columns"], plain["about"], plain["corner"])

    def show(self, digits: int = 2, bold: Collection[str | tuple[str, str]] = ()) -> Shown:
        """Return the table for a page, and as text for a terminal and for comparison.

        Parameters
        ----------
        digits
            Significant digits of the numbers.
        bold
            What a reader should compare: names of rows or columns, or pairs (row, column).
        """
        return Shown({"text/html": self._html(digits, bold), "text/plain": self.text(digits)})

    def text(self, digits: int = 2) -> str:
        """Return the table as aligned text."""
        lines = [[self.corner, *self.columns]]
        lines += [[name, *(_shown(c, digits) for c in cells)] for name, cells in self.rows.items()]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        return "\n".join(
            "  ".join(
                [line[0].ljust(widths[0])]
                + [cell.rjust(w) for cell, w in zip(line[1:], widths[1:], strict=True)]
            ).rstrip()
            for line in lines
        )

    def _html(self, digits: int, bold: Collection[str | tuple[str, str]]) -> str:
        kinds = {
            name: ' class="rp-text"' if _of_words(row[place] for row in self.rows.values()) else ""
            for place, name in enumerate(self.columns)
        }
        head = "".join(f'<th scope="col"{kinds[c]}>{escape(c)}</th>' for c in self.columns)
        body = ""
        for name, cells in self.rows.items():
            shown = ""
            for column, cell in zip(self.columns, cells, strict=True):
                value, ends = escape(_shown(cell, digits)), ""
                if not isinstance(cell, str):
                    value = value.replace("-", "−")
                if isinstance(cell, Interval):
                    value, _, ends = value.partition(" [")
                strong = {name, column, (name, column)} & set(bold)
                shown += f'<td data-name="{escape(column)}"{kinds[column]}>'
                shown += f"<strong>{value}</strong>" if strong else value
                shown += f" <small>[{ends}</small></td>" if ends else "</td>"
            body += f'<tr><th scope="row">{escape(name)}</th>{shown}</tr>'
        words = "; ".join(
            f"<i>{escape(name)}</i>: {escape(what)}" for name, what in self.columns.items() if what
        )
        about = escape(self.about[:1].upper() + self.about[1:])
        caption = ". ".join(part for part in (about, words) if part)
        words_only = any(isinstance(c, str) for cells in self.rows.values() for c in cells)
        kind = "rp-results rp-words" if words_only else "rp-results"
        label = self.about or self.corner or "Results"
        head = f'<th scope="col">{escape(self.corner)}</th>{head}'
        below = f'<p class="rp-defined">{caption}.</p>' if caption else ""
        return html_table(label, kind, head, body) + below


def _of_words(column: Iterable[Cell]) -> bool:
    """Tell whether a column holds texts and no number: it stands flush left."""
    cells = [cell for cell in column if cell is not None]
    return bool(cells) and all(isinstance(cell, str) for cell in cells)


def _checked(cell: object) -> Cell:
    if cell is None or isinstance(cell, Interval | str):
        return cell
    if isinstance(cell, bool) or not hasattr(cell, "__float__"):
        raise TypeError(f"a cell is an interval, a number, text or None, got {cell!r}")
    if not math.isfinite(cell):
        raise ValueError(f"a number in a table must be finite, got {cell}")
    return int(cell) if float(cell).is_integer() else float(cell)


_MOST = 6  # significant digits of the ends of an interval


def _shown(cell: Cell, digits: int) -> str:
    """Return a cell as text: counts whole, other numbers with so many significant digits.

    A number has more of them where it would stand outside its own interval.

    Examples
    --------
    >>> _shown(Interval(1.0, 0.9984, 1.0, ""), 2)
    '1.0 [0.998, 1.00]'
    >>> _shown(Interval(0.9968, 0.9951, 0.9984, ""), 2)
    '0.997 [0.995, 0.998]'
    """
    if cell is None:
        return "–"
    if isinstance(cell, str):
        return cell
    if isinstance(cell, Interval):
        if cell.low == cell.high:
            return _rounded(cell.estimate, digits)
        low, high = (_rounded(end, digits) for end in (cell.low, cell.high))
        more = digits
        while low == high and more < _MOST:  # "1.0 [1.0, 1.0]" would hide that it has a width
            more += 1
            low, high = (_rounded(end, more) for end in (cell.low, cell.high))
        texts = [_rounded(cell.estimate, one) for one in range(digits, more + 1)]
        inside = (text for text in texts if float(low) <= float(text) <= float(high))
        return f"{next(inside, texts[-1])} [{low}, {high}]"
    return str(cell) if isinstance(cell, int) else _rounded(cell, digits)


def _rounded(value: float, digits: int) -> str:
    """Return a number with significant digits, thousands written out.

    Examples
    --------
    >>> _rounded(0.01234, 2), _rounded(5972.6, 2), _rounded(1.0, 2)
    ('0.012', '6000', '1.0')
    """
    text = f"{value:#.{digits}g}"
    if "e" in text and 1e-4 <= abs(value) < 1e7:
        text = f"{float(text):.0f}"
    return text.removesuffix(".")
