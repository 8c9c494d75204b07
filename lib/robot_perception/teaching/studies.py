"""Studies: data and one function, run once, and the claims that stand on what they give.

.. code-block:: python

    fig4 = Study(run, full=Config(runs=100), quick=Config(runs=20), seed=4)

    @fig4.claim("gain-vanishes", paper=PAPER, place="§2.2, Fig. 4", basis="mathematics",
                statement="…", method="…", accepted=Accepted(0.3819, 0.3820, "the pole 1/φ² …"),
                sabotage=Change("a landmark that wanders", walk=0.1))
    def gain_vanishes(result: Result) -> Finding: ...

``run(config, *, rng)`` computes; a study knows its configuration at the full size, which is
recorded, and at the quick one, which the tests compute, and its seed. Its result is kept
(:mod:`.results`), so that notebook, explorer, claim, sabotage and test share it. The decorated
function says what a result shows and becomes a :class:`.claims.Claim`; a sabotage is another
configuration of the same study, or another function that runs it, and its value is computed by the
same code.

The verdict of a claim follows from the finding and the accepted range (:mod:`.verdicts`), never
from a label that somebody typed; a sabotage computes the same value where the truth of the
statement is turned, and the verdict must turn with it. The recorded ledger (:mod:`.ledger`) is
written by the command line; badges, scorecard and tests read it.

A chapter whose notebook computes declares :class:`.trials.Trials` instead: rows, no sizes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from types import ModuleType
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from robot_perception.evaluation.intervals import Interval
from robot_perception.teaching.claims import Finding, Size
from robot_perception.teaching.results import keep, told
from robot_perception.teaching.verdicts import Accepted, Basis, Condition, Verdict, decide, deciding

Config = TypeVar("Config")
Result = TypeVar("Result")

STOPPING = "as many as the study has"
"""When there are enough replicates, unless a claim says otherwise."""
IN_MEMORY = 64
"""So many results of all studies stay in the memory of a process."""


class Change:
    """What a sabotage changes in a study, at its quick size.

    Parameters
    ----------
    text
        What was changed, in words that complete "The same with …".
    run
        A function that runs the study in another way; that of the study if none is given.
    config
        The whole configuration; that of the study's quick size if none is given.
    **fields
        Fields of the configuration and their other values.
    """

    def __init__(
        self, text: str, run: Callable[..., Any] | None = None, *, config: Any = None, **fields: Any
    ) -> None:
        self.text, self.run, self.config, self.fields = text, run, config, fields


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
    method
        What is measured, and how.
    study
        What gives the result: a `Study`, or :class:`.trials.Trials`, whose rows are the result.
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
    stopping
        When there are enough replicates, as registered.

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
    study: "Study | Any"
    compute: Callable[..., Finding]
    accepted: Accepted | None = None
    paper_value: str = ""
    value: Callable[..., Interval] | None = None
    sabotages: "tuple[Change | Any, ...]" = ()
    stopping: str = STOPPING

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

    def sabotaged(self, change: "Change | Any") -> Finding:
        """Compute the value of a sabotage, and nothing else, at the quick size."""
        result = self.study.result(Size.QUICK, change)
        return Finding(self.value(result) if self.value else self.compute(result).value)

    def verdict(self, finding: Finding) -> Verdict:
        """Return the verdict that follows from a finding."""
        return decide(self.basis, self.accepted, finding.value, finding.conditions)

    def deciding(self, finding: Finding) -> tuple[Condition, ...]:
        """Return the conditions of a finding on which the verdict hangs."""
        return deciding(self.accepted, finding.value, finding.conditions)


@dataclass(frozen=True, slots=True, eq=False)
class Study(Generic[Config, Result]):
    """A function and the configurations that it is run with.

    Parameters
    ----------
    run
        Function of a configuration and ``rng`` that always gives the same for the same draws.
    full, quick
        The configurations of both sizes: a frozen dataclass, a number, a text, or a tuple of them.
    seed
        Of the generator of each run.
    """

    run: Callable[..., Result]
    full: Config
    quick: Config
    seed: int = 0
    sizes: ClassVar[tuple[Size, ...]] = (Size.QUICK, Size.FULL)

    def result(self, size: Size | str = Size.FULL, change: Change | None = None) -> Result:
        """Return what the study gives at a size, with a change if there is one; computed once."""
        run, config = self.run, getattr(self, Size(size))
        if change is not None:
            run = change.run or run
            config = config if change.config is None else change.config
            config = replace(config, **change.fields) if change.fields else config
        told(config)
        return _computed(run, config, self.seed)

    def claim(
        self, id: str, *, sabotage: Change | Sequence[Change] = (), **words: Any
    ) -> Callable[[Callable[..., Finding]], Claim]:
        """Declare a claim on the function that says what a result shows of it.

        The chapter is the package below ``chapters`` of the function.

        Parameters
        ----------
        id
            Identifier of the claim.
        sabotage
            What makes its statement false, or true where it fails.
        **words
            The other fields of `Claim`.

        Raises
        ------
        ValueError
            If the basis is unknown, a text that a reader needs is empty, or the function is
            outside the chapters.
        """
        changes = (sabotage,) if isinstance(sabotage, Change) else tuple(sabotage)

        def declare(finding: Callable[..., Finding]) -> Claim:
            chapter = chapter_of(id, finding)
            own = {"study": self, "compute": finding, "sabotages": changes}
            return Claim(id=id, chapter=chapter, **own, **words)

        return declare


@lru_cache(maxsize=IN_MEMORY)
def _computed(run: Callable[..., Any], config: Any, seed: int) -> Any:
    return keep(run, (config, seed), lambda: run(config, rng=np.random.default_rng(seed)))


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
