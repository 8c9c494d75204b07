"""Claims: what the papers say, declared on what tests it.

`robot_perception.teaching.studies.Study.claim` declares one. Its verdict follows from the finding
and the accepted range (:mod:`.verdicts`), never from a label that somebody typed; a sabotage
computes the same value where the truth of the statement is turned, and the verdict must turn with
it. The recorded ledger (:mod:`.ledger`) is written by the command line; badges, scorecard and tests
read it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import ModuleType
from typing import TYPE_CHECKING, Any

from robot_perception.evaluation.intervals import Interval
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Basis, Condition, Verdict, decide, deciding

if TYPE_CHECKING:
    from robot_perception.teaching.studies import Change, Study


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
        Conditions that were tried; those that decide (:func:`.verdicts.deciding`) make the claim
        conditional.
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


@dataclass(frozen=True, slots=True)
class Claim:
    """One statement of a paper and how the book tests it; `Study.claim` declares one.

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
    study
        What gives the result.
    compute
        Function of the study's result that returns the finding.
    accepted
        Range of the value inside which the statement holds, or ``None`` for a statement without a
        number, whose verdict is then ``illustrated``.
    paper_value
        The paper's value if it gives one.
    value
        Where the rest of a finding asks for more than the result of a sabotage has: computes the
        value of both, which ``compute`` takes as its second argument.
    sabotages
        Changes of the study that turn the truth of the statement. Where the statement itself fails,
        it is a variant in which it is true: a verdict that no computation could turn says nothing.

    Raises
    ------
    ValueError
        If the basis is unknown, or a text that a reader needs is empty.
    """

    id: str
    chapter: str
    paper: str
    place: str
    basis: Basis | str
    statement: str
    method: str
    study: "Study"
    compute: Callable[..., Finding]
    accepted: Accepted | None = None
    paper_value: str = ""
    value: Callable[..., Interval] | None = None
    sabotages: "tuple[Change, ...]" = ()

    def __post_init__(self) -> None:
        for name in ("id", "place", "statement", "method"):
            if not getattr(self, name).strip():
                raise ValueError(f"claim {self.id!r} needs a {name}")
        if not all(change.text.strip() for change in self.sabotages):
            raise ValueError("the text of a sabotage must say what it changes")
        object.__setattr__(self, "basis", Basis(self.basis))

    @property
    def seed(self) -> int:
        """Seed of the study's generator."""
        return self.study.seed

    def find(self, size: Size | str = Size.QUICK) -> Finding:
        """Compute the claim; the same size always gives the same finding."""
        result = self.study.result(size)
        return self.compute(result, *([self.value(result)] if self.value else []))

    def sabotaged(self, change: "Change") -> Finding:
        """Compute the value of a sabotage, and nothing else, at the quick size."""
        result = self.study.result(Size.QUICK, change)
        return Finding(self.value(result) if self.value else self.compute(result).value)

    def verdict(self, finding: Finding) -> Verdict:
        """Return the verdict that follows from a finding."""
        return decide(self.basis, self.accepted, finding.value, finding.conditions)

    def deciding(self, finding: Finding) -> tuple[Condition, ...]:
        """Return the conditions of a finding on which the verdict hangs."""
        return deciding(self.accepted, finding.value, finding.conditions)


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
