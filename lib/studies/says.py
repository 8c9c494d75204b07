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

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from studies.intervals import Interval
from studies.rows import Rows, Say, value_of
from studies.tables import Cell, Table
from studies.verdicts import Accepted, Condition

if TYPE_CHECKING:
    from studies.trials import Trials


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
        factor: str,
        *names: str,
        corner: str | None = None,
        about: str | None = None,
        **levels: Any,
    ) -> Callable[..., Table]:
        """Return a table as a function of rows: a row for each level of a factor.

        Parameters
        ----------
        factor
            What the rows of the table are.
        *names
            The measures that are its columns; all of them by default.
        corner, about
            What stands in the corner, and beside the numbers.
        **levels
            Levels of other factors.
        """
        chosen = {name: self(name) for name in names or self._says}

        def table(rows: Rows | None = None) -> Table:
            rows = (self._study.rows() if rows is None else rows).where(**levels)
            heads = {name: name.replace("_", " ") for name in chosen}
            words = {heads[name]: self._words[name] for name in chosen}
            columns: dict[str, Say] = {heads[name]: one.say for name, one in chosen.items()}
            text = self._about if about is None else about
            counts = {name: len(rows.levels(name)) for name in rows.table}
            return rows.by(factor, columns, words, text.format_map(counts), corner)

        return table


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
