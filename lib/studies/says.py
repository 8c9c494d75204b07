"""Measures of a study's rows, each said once: a name, an expression, words.

.. code-block:: python

    holds = bridged.says(
        "{film} films of each kind; 95 %",
        filter=("share", "filter", "missed", "of the faces missed, those that the filter holds"),
        last=("share", "last", "missed", "those that the last detection holds"),
    )
    holds("filter", scene="short")                       # a measure: a function of rows
    holds.by("scene")()                                  # a table: a column for each measure
    tell("{short.filter:.0%} …", short=holds.at(scene="short"))    # numbers in a sentence

Measures and tables are functions of rows, and take those of the study where none are given. So a
claim has a measure for its value, the page a table and a sentence of the same names, and the
expression stands in one place.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

from studies.intervals import Interval
from studies.rows import Rows, Say, value_of
from studies.tables import Cell, Table
from studies.verdicts import Accepted, Condition

if TYPE_CHECKING:
    from studies.trials import Trials

Factors = str | Sequence[str]
"""A factor or several."""
Place = Mapping[str, Any] | Callable[[Rows], Rows]
"""Rows of a table: those at levels of factors, or what a function makes of all rows."""


@dataclass(frozen=True, slots=True)
class Measure:
    """Measure of rows at some levels: a function of rows, or of those of the study.

    Parameters
    ----------
    study
        The study.
    say
        A method of `Rows` and its columns, or a function of rows.
    levels
        Levels of factors.
    """

    study: "Trials"
    say: Say
    levels: Mapping[str, Any]

    def __call__(self, rows: Rows | None = None) -> Cell:
        """Return the number."""
        rows = self.study.rows() if rows is None else rows
        return value_of(self.say, rows.where(**self.levels))


class Says:
    """The measures of a study's rows by name.

    Parameters
    ----------
    study
        The study.
    about
        What stands beside a table; ``{film}`` is the number of the films in the rows.
    **measures
        A method of `Rows` with its columns, or a function of rows; then words, with the unit. In a
        table a name has blanks for its underscores.
    """

    def __init__(self, study: "Trials", about: str = "", **measures: tuple[Any, ...]) -> None:
        self._study, self._about = study, about
        self._words = {name: words for name, (*_, words) in measures.items()}
        self._says: dict[str, Say] = {
            name: say[0] if callable(say[0]) else tuple(say) for name, (*say, _) in measures.items()
        }

    def __call__(self, name: str, **levels: Any) -> Measure:
        """Return a measure at some levels.

        Raises
        ------
        KeyError
            If there is no measure of that name.
        """
        if name not in self._says:
            raise KeyError(f"no measure {name!r}; there are {', '.join(self._says)}")
        return Measure(self._study, self._says[name], levels)

    def at(self, **levels: Any) -> "Numbers":
        """Return the numbers of all measures at some levels by name, read when asked for."""
        return Numbers(self, levels)

    def by(
        self,
        factor: Factors | Mapping[str, Place],
        *names: str,
        across: Factors = (),
        below: Mapping[str, Mapping[str, Say]] | None = None,
        corner: str | None = None,
        about: str | None = None,
        **levels: Any,
    ) -> Callable[..., Table]:
        """Return a table as a function of rows: a row for each level of a factor.

        Parameters
        ----------
        factor
            What the rows of the table are: a factor, several, or by the name of a row levels, or a
            function of rows that returns others.
        *names
            The measures that are its columns; all of them by default. A name is followed by the
            unit of its numbers, as in "end (m)".
        across
            Factors whose levels are columns, too; of one measure they are the names.
        below
            Rows after these: by their name, what they say in place of some measures.
        corner, about
            What stands in the corner, and beside the numbers.
        **levels
            Levels of factors; of those that are rows or columns in the order given, or by names.
        """
        chosen = {name: self(name).say for name in names or self._says}

        def table(rows: Rows | None = None) -> Table:
            fixed = {one: at for one, at in levels.items() if not isinstance(at, Mapping)}
            rows = (self._study.rows() if rows is None else rows).where(**fixed)
            places = _places(rows, across, levels)
            own = factor if isinstance(factor, Mapping) else _places(rows, factor, levels)
            lines: list[tuple[str, Place, Mapping[str, Say]]] = [
                *((name, place, chosen) for name, place in own.items()),
                *((name, {}, says) for name, says in (below or {}).items()),
            ]
            columns = [*product(chosen, places)]
            cells = {
                line: [
                    value_of(says[name], _at(place, rows).where(**places[there]))
                    if name in says
                    else None
                    for name, there in columns
                ]
                for line, place, says in lines
            }
            words = {
                _head(*column, len(chosen), found): self._words[column[0]]
                for column, found in zip(columns, zip(*cells.values(), strict=True), strict=True)
            }
            text = self._about if about is None else about
            counts = {name: len(rows.levels(name)) for name in rows.table}
            first = corner if corner is not None else factor if isinstance(factor, str) else ""
            return Table(cells, words, text.format_map(counts), first)

        return table


def _places(rows: Rows, factors: Factors, levels: Mapping[str, Any]) -> dict[str, Mapping]:
    """Return by name the levels of factors, of several those of each pair."""
    factors = (factors,) if isinstance(factors, str) else factors
    told = [levels.get(one, rows.levels(one)) for one in factors]
    listed = ((at,) if isinstance(at, str) or not isinstance(at, Collection) else at for at in told)
    named = [at if isinstance(at, Mapping) else {f"{one}": one for one in at} for at in listed]
    return {
        ", ".join(name for name, _ in pairs): {
            one: at for one, (_, at) in zip(factors, pairs, strict=True)
        }
        for pairs in product(*(each.items() for each in named))
    }


def _at(place: Place, rows: Rows) -> Rows:
    return place(rows) if callable(place) else rows.where(**place)


def _head(name: str, place: str, measures: int, cells: Sequence[Cell]) -> str:
    """Return the name of a column: measure and unit, level, or both."""
    if place:
        return place if measures == 1 else f"{name.replace('_', ' ')}, {place}"
    units = {cell.unit for cell in cells if isinstance(cell, Interval)} - {""}
    return " ".join([name.replace("_", " "), *(f"({unit})" for unit in units if len(units) == 1)])


class Numbers:
    """The numbers of measures at some levels, for a sentence: ``{short.filter:.0%}``."""

    def __init__(self, says: Says, levels: Mapping[str, Any]) -> None:
        self._says, self._levels = says, levels

    def __getattr__(self, name: str) -> Any:
        return self._says(name, **self._levels)()


@dataclass(frozen=True, slots=True)
class When:
    """Condition of a claim, judged by the claim's own range.

    Parameters
    ----------
    text
        Where the claim holds; it follows "only if".
    inside, outside
        What rows say where it is so and where it is not, as functions of rows.
    """

    text: str
    inside: Callable[[Rows], Interval] | None = None
    outside: Callable[[Rows], Interval] | None = None

    def judged(self, rows: Rows, accepted: Accepted) -> Condition:
        """Return the condition that rows show."""
        inside, outside = (one and one(rows) for one in (self.inside, self.outside))
        return Condition.judged(self.text, accepted, inside=inside, outside=outside)
