"""Claims: what a paper states, how the book tests it, and what the computation shows.

A study (:mod:`.trials`) declares a claim: its value is a function of rows, and so is what else it
shows; where that takes a computation of its own, the claim stands on a function. The verdict
follows from the finding and the accepted range (:mod:`.verdicts`), never from a label that somebody
typed; a sabotage computes the same value where the truth of the statement is turned, and the
verdict must turn with it. The recorded ledger (:mod:`.ledger`) is written by the command line;
badges, scorecard and tests read it.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Any

from studies.intervals import Interval
from studies.sentences import VALUE, Form
from studies.tables import Table
from studies.verdicts import Accepted, Basis, Condition, Verdict, decide, deciding

STOPPING = "as many as the study has"
"""Stopping rule of the replicates, unless a claim says otherwise."""


@dataclass(frozen=True, slots=True)
class Finding:
    """Finding of the computation of one claim.

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
    """One statement of a paper and how the book tests it; a study's ``claim`` declares one.

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
    says
        Words of the result, with ``{value}`` where its number stands.
    form
        How that number is written.
    method
        What is measured, and how.
    study
        The :class:`.trials.Trials` whose rows it reads.
    compute
        Function of the rows, and of the value if there is one, that returns the finding; ``None``
        where the fields below say all.
    accepted
        Range of the value inside which the statement holds, or ``None`` for a statement without a
        number, whose verdict is then ``illustrated``.
    paper_value
        The paper's value if it gives one.
    value
        Function of the rows, and of those of a sabotage, that returns the value.
    evidence, tables
        By name, functions of the rows that return numbers and tables beside it.
    conditions
        What decides whether it holds: each is ``judged(rows, accepted)``.
    note
        As in `Finding`, or a function of the rows.
    sabotages
        Studies in which the truth of the statement is turned. Where the statement itself fails,
        it is a variant in which it is true: a verdict that no computation could turn says nothing.
    stopping
        When there are enough replicates, as registered.

    Raises
    ------
    ValueError
        If the basis or the form is unknown, a text that a reader needs is empty, or the result has
        no place for its number.
    """

    id: str
    chapter: str
    paper: str
    place: str
    basis: Basis | str
    statement: str
    says: str
    form: Form | str
    method: str
    study: Any
    compute: Any = None
    accepted: Accepted | None = None
    paper_value: str = ""
    value: Callable[..., Interval] | None = None
    evidence: Mapping[str, Callable[..., Interval]] = field(default_factory=dict)
    tables: Mapping[str, Callable[..., Table]] = field(default_factory=dict)
    conditions: tuple[Any, ...] = ()
    note: str | Callable[..., str] = ""
    sabotages: tuple[Any, ...] = ()
    stopping: str = STOPPING

    def __post_init__(self) -> None:
        for name in ("id", "place", "statement", "method"):
            if not getattr(self, name).strip():
                raise ValueError(f"claim {self.id!r} needs a {name}")
        if not all(change.text.strip() for change in self.sabotages):
            raise ValueError("the text of a sabotage must say what it changes")
        if self.says.count(VALUE) != 1:
            raise ValueError(f"claim {self.id!r} must say {VALUE} once, got {self.says!r}")
        if self.compute is None and self.value is None:
            raise ValueError(f"claim {self.id!r} needs a value, or a function that finds it")
        object.__setattr__(self, "basis", Basis(self.basis))
        object.__setattr__(self, "form", Form(self.form))

    def __call__(self, compute: Callable[..., Finding]) -> "Claim":
        """Let a function of rows and value find what else there is: the claim stands on it."""
        return replace(self, compute=compute)

    @property
    def seed(self) -> int:
        """Seed of the study's generators."""
        return self.study.seed

    @property
    def module(self) -> str:
        """Name of the module that declares it."""
        return inspect.unwrap(self.compute or self.study.one).__module__

    def find(self) -> Finding:
        """Compute the claim of the rows of its study."""
        rows = self.study.rows()
        value = self.value(rows) if self.value else None
        if self.compute is not None:
            return self.compute(rows, *([value] if self.value else []))
        return Finding(
            value,
            {name: one(rows) for name, one in self.evidence.items()},
            {name: one(rows) for name, one in self.tables.items()},
            tuple(one.judged(rows, self.accepted) for one in self.conditions),
            self.note(rows) if callable(self.note) else self.note,
        )

    def sabotaged(self, change: Any) -> Finding:
        """Compute the value of a sabotage, and nothing else."""
        rows = change.study.rows()
        return Finding(self.value(rows) if self.value else self.compute(rows).value)

    def verdict(self, finding: Finding) -> Verdict:
        """Return the verdict that follows from a finding."""
        return decide(self.basis, self.accepted, finding.value, finding.conditions)

    def deciding(self, finding: Finding) -> tuple[Condition, ...]:
        """Return the conditions of a finding on which the verdict hangs."""
        return deciding(self.accepted, finding.value, finding.conditions)


def claims_in(module: ModuleType) -> tuple[Claim, ...]:
    """Return the claims that are declared in a module, in the order of their declarations."""
    return tuple(
        value
        for value in vars(module).values()
        if isinstance(value, Claim) and value.module == module.__name__
    )
