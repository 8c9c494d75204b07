"""Claims: what the papers say, declared on the computation that tests it.

.. code-block:: python

    @claim("gain-vanishes", paper=PAPER, place="§2.2, Fig. 4", basis="mathematics",
           statement="…", method="…", accepted=Accepted(0.3819, 0.3820, "the pole 1/φ² …"))
    def gain_vanishes(size: Size, rng: Generator) -> Finding: ...

    @gain_vanishes.sabotage("a landmark that wanders, so that measurements never stop counting")
    def wandering(size: Size, rng: Generator) -> Finding: ...

The decorated function becomes a :class:`Claim`. Its verdict follows from the finding and the
accepted range (:mod:`.verdicts`), never from a label that somebody typed; a :class:`Sabotage`
computes the same value where the truth of the statement is turned, and the verdict must turn with
it. The recorded ledger (:mod:`.ledger`) is written by the command line; badges, scorecard and tests
read it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from robot_perception.evaluation.intervals import Interval
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Basis, Condition, Verdict, decide

if TYPE_CHECKING:
    from robot_perception.teaching.studies import Study


class Size(StrEnum):
    """How much of a study is run: ``quick`` for the tests, ``full`` for the recorded ledger."""

    QUICK = "quick"
    FULL = "full"


@dataclass(frozen=True, slots=True)
class Finding:
    """What the computation of one claim shows.

    Parameters
    ----------
    value
        Our value, compared with the claim's accepted range; ``None`` if nothing can be measured,
        and then the note says why.
    evidence
        A few further numbers by name, shown beside the value.
    tables
        More than a few, by name.
    conditions
        Conditions that were tried; the needed ones make a holding claim conditional.
    note
        One or two sentences for the reader; numbers in it come from the computation.

    Raises
    ------
    ValueError
        If there is neither a value nor a note.
    """

    value: Interval | None
    evidence: Mapping[str, Interval] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)
    conditions: tuple[Condition, ...] = ()
    note: str = ""

    def __post_init__(self) -> None:
        if self.value is None and not self.note.strip():
            raise ValueError("a finding without a value must say in its note why there is none")


Compute = Callable[[Size, np.random.Generator], Finding]


@dataclass(frozen=True, slots=True)
class Claim:
    """One statement of a paper and how the book tests it; use :func:`claim` to declare one.

    Parameters
    ----------
    id
        Identifier, for instance ``"dp-quadratic"``.
    chapter
        Stem of the chapter that computes the claim.
    paper
        Key of the paper in the bibliography.
    place
        Section, equation, table or figure.
    basis
        What a verdict stands on.
    statement
        The claim in our own words.
    method
        What is measured, and how.
    accepted
        Range of the value inside which the statement holds, or ``None`` for a statement without a
        number, whose verdict is then ``illustrated``.
    compute
        Function of the study's result that returns the finding; without a study, of the size and
        a generator.
    paper_value
        The paper's value if it gives one.
    seed
        Seed of the generator.
    study
        What gives the result.
    value
        Computes the value of a result, where the function that returns the finding is handed it.
    sabotages
        Variants in which the truth of the statement is turned.
    """

    id: str
    chapter: str
    paper: str
    place: str
    basis: Basis
    statement: str
    method: str
    accepted: Accepted | None
    compute: Callable[..., Finding]
    paper_value: str = ""
    seed: int = 0
    study: "Study | None" = None
    value: Callable[..., Interval] | None = None
    sabotages: list["Sabotage"] = field(default_factory=list)

    def find(self, size: Size | str = Size.QUICK) -> Finding:
        """Compute the claim; the same size always gives the same finding."""
        size = Size(size)
        if self.study is not None:
            result = self.study.result(size)
            return self.compute(result, *([self.value(result)] if self.value else []))
        return self.compute(size, np.random.default_rng(self.seed))

    def verdict(self, finding: Finding) -> Verdict:
        """Return the verdict that follows from a finding."""
        return decide(self.basis, self.accepted, finding.value, finding.conditions)

    def sabotage(self, text: str) -> Callable[[Compute], Compute]:
        """Declare a sabotage of a claim without a study on the function that computes it.

        Parameters
        ----------
        text
            What was changed, in words that complete "The same with …".
        """

        def declare(compute: Compute) -> Compute:
            find = lambda: compute(Size.QUICK, np.random.default_rng(self.seed))  # noqa: E731
            self.sabotages.append(Sabotage(text, find))
            return compute

        return declare


@dataclass(frozen=True, slots=True)
class Sabotage:
    """A variant of a study in which a claim's statement is false.

    Where the statement itself fails, its sabotage is a variant in which it is true: a verdict that
    no computation could turn says nothing.

    Parameters
    ----------
    text
        What was changed, in words that complete "The same with …".
    find
        Computes the value at the quick size, with the seed of the claim.
    """

    text: str
    find: Callable[[], Finding]

    def __post_init__(self) -> None:
        if not self.text.strip():
            raise ValueError("the text of a sabotage must say what it changes")


def claim(
    id: str,
    *,
    paper: str,
    place: str,
    basis: Basis | str,
    statement: str,
    method: str,
    accepted: Accepted | None = None,
    paper_value: str = "",
    seed: int = 0,
) -> Callable[[Compute], Claim]:
    """Declare a claim on the function that computes it; the parameters are those of `Claim`.

    The chapter is the package below ``chapters`` in which the function is defined.

    Raises
    ------
    ValueError
        If the basis is unknown, a text that a reader needs is empty, or the function is outside
        the chapters.
    """
    needed(id=id, place=place, statement=statement, method=method)

    def declare(compute: Compute) -> Claim:
        return Claim(
            id=id,
            chapter=chapter_of(id, compute),
            paper=paper,
            place=place,
            basis=Basis(basis),
            statement=statement,
            method=method,
            accepted=accepted,
            compute=compute,
            paper_value=paper_value,
            seed=seed,
        )

    return declare


def needed(**texts: str) -> None:
    """Refuse a claim that does not say what a reader needs."""
    for name, text in texts.items():
        if not text.strip():
            raise ValueError(f"claim {texts['id']!r} needs a {name}")


def chapter_of(claim_id: str, function: Callable[..., Any]) -> str:
    """Return the chapter in whose package a function is defined."""
    _, inside, rest = function.__module__.partition(".chapters.")
    if not inside:
        raise ValueError(
            f"claim {claim_id!r} is declared outside the chapters: {function.__module__}"
        )
    return rest.split(".")[0]


def claims_in(module: ModuleType) -> tuple[Claim, ...]:
    """Return the claims that are declared in a module, in the order of their declarations."""
    return tuple(
        value
        for value in vars(module).values()
        if isinstance(value, Claim) and value.compute.__module__ == module.__name__
    )
