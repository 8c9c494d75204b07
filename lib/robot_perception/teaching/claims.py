"""The claim ledger: what the papers say, what the computation shows, and the verdict.

A :class:`Claim` is declared in the experiment that computes it. Its ``compute`` function returns a
:class:`Finding`; the verdict follows from the finding and the accepted range, never from a label
that somebody typed. The recorded ledger (``book/_data/claims.json``) is written by the command
line, and the badges, the scorecard and the tests read it.
"""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats


class Size(StrEnum):
    """How much of a study is run: ``quick`` for the tests, ``full`` for the recorded ledger."""

    QUICK = "quick"
    FULL = "full"


class Verdict(StrEnum):
    """What the computation shows about a claim."""

    REPRODUCED = "reproduced"
    CONDITIONAL = "conditional"
    REFUTED = "refuted"
    ILLUSTRATED = "illustrated"
    UNTESTABLE = "untestable"


@dataclass(frozen=True, slots=True)
class Interval:
    """A value with its uncertainty.

    Parameters
    ----------
    estimate, low, high
        The value and the ends of its interval, ``low <= estimate <= high``; equal for a number
        that is exact or deterministic.
    unit
        Unit as printed, empty for a pure number.
    about
        What the interval is, for instance ``"95 % over 100 runs"``.

    Raises
    ------
    ValueError
        If a number is not finite or the order is broken.
    """

    estimate: float
    low: float
    high: float
    unit: str = ""
    about: str = "exact"

    def __post_init__(self) -> None:
        values = (self.estimate, self.low, self.high)
        if not all(math.isfinite(v) for v in values):
            raise ValueError(f"interval must be finite, got {values}")
        if not self.low <= self.estimate <= self.high:
            raise ValueError(f"interval must satisfy low <= estimate <= high, got {values}")

    @classmethod
    def exact(cls, value: float, unit: str = "", about: str = "exact") -> "Interval":
        """Return the interval of a deterministic number, both ends equal to it."""
        value = float(value)
        return cls(value, value, value, unit, about)

    @classmethod
    def of_mean(cls, samples: np.ndarray, unit: str = "", level: float = 0.95) -> "Interval":
        r"""Return the mean of independent samples with its Student interval.

        .. math:: \bar x \pm t_{(1+\ell)/2,\,n-1}\, s / \sqrt n
        """
        samples = _samples(samples, least=2)
        mean, half = samples.mean(), stats.sem(samples)
        half *= stats.t.ppf((1 + level) / 2, samples.size - 1)
        about = f"{level:.0%} of the mean over {samples.size} runs"
        return cls(float(mean), float(mean - half), float(mean + half), unit, about)

    @classmethod
    def of_proportion(cls, successes: int, trials: int, level: float = 0.95) -> "Interval":
        """Return a proportion with its Wilson interval."""
        if not 0 <= successes <= trials or trials < 1:
            raise ValueError(f"need 0 <= successes <= trials, got {successes} of {trials}")
        test = stats.binomtest(int(successes), int(trials))
        bounds = test.proportion_ci(level, method="wilson")
        about = f"{level:.0%} of the rate over {trials} trials"
        rate = successes / trials
        return cls(rate, min(float(bounds.low), rate), max(float(bounds.high), rate), "", about)

    @classmethod
    def of_quantiles(
        cls, samples: np.ndarray, unit: str = "", level: float = 0.95, about: str = ""
    ) -> "Interval":
        """Return the median of samples with the central range that holds ``level`` of them."""
        samples = _samples(samples, least=1)
        low, mid, high = np.quantile(samples, [(1 - level) / 2, 0.5, (1 + level) / 2])
        about = about or f"median and central {level:.0%} of {samples.size} runs"
        return cls(float(mid), float(low), float(high), unit, about)

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        if self.low == self.high:
            return f"{self.estimate:.4g}{unit}"
        return f"{self.estimate:.4g} [{self.low:.4g}, {self.high:.4g}]{unit}"


def _samples(samples: np.ndarray, least: int) -> np.ndarray:
    samples = np.asarray(samples, dtype=float).ravel()
    if samples.size < least:
        raise ValueError(f"need at least {least} samples, got {samples.size}")
    if not np.isfinite(samples).all():
        raise ValueError(f"{np.count_nonzero(~np.isfinite(samples))} samples are not finite")
    return samples


@dataclass(frozen=True, slots=True)
class Accepted:
    """The range inside which the paper's statement counts as holding, and why it is that range."""

    low: float
    high: float
    why: str

    def __post_init__(self) -> None:
        if not self.low <= self.high:
            raise ValueError(
                f"accepted range must satisfy low <= high, got {self.low}, {self.high}"
            )
        if not self.why.strip():
            raise ValueError("an accepted range must say why it is that range")

    def holds(self, value: Interval) -> bool:
        """Return whether the whole interval of ``value`` lies inside the range."""
        return self.low <= value.low and value.high <= self.high

    def ends(self) -> list[float | None]:
        """Return both ends, ``None`` for an open one, as JSON can hold them."""
        return [end if math.isfinite(end) else None for end in (self.low, self.high)]


@dataclass(frozen=True, slots=True)
class Condition:
    """A condition of a claim: its words, and whether the computation saw the claim fail without it.

    Parameters
    ----------
    text
        Under what condition the claim holds.
    needed
        ``True`` if the claim was computed without the condition and did not hold.
    """

    text: str
    needed: bool


@dataclass(frozen=True, slots=True)
class Finding:
    """What the computation of one claim shows.

    Parameters
    ----------
    value
        Our value, compared with the claim's accepted range.
    evidence
        Further measured numbers by name, shown beside the value.
    conditions
        Conditions that were tried; the needed ones make a holding claim conditional.
    note
        One or two sentences for the reader; numbers in it come from the computation.
    """

    value: Interval
    evidence: Mapping[str, Interval] = field(default_factory=dict)
    conditions: tuple[Condition, ...] = ()
    note: str = ""


@dataclass(frozen=True, slots=True)
class Claim:
    """One statement of a paper and how the book tests it.

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
    statement
        The claim in our own words.
    paper_value
        The paper's value if it gives one.
    method
        What is measured, and how.
    accepted
        Range of the value inside which the statement holds, or ``None`` for a statement without a
        number, whose verdict is then ``illustrated``.
    compute
        Function of the size and a generator that returns the finding.
    seed
        Seed of the generator.
    """

    id: str
    chapter: str
    paper: str
    place: str
    statement: str
    paper_value: str
    method: str
    accepted: Accepted | None
    compute: Callable[[Size, np.random.Generator], Finding]
    seed: int = 0

    def verdict(self, finding: Finding) -> Verdict:
        """Return the verdict that follows from a finding."""
        if self.accepted is None:
            return Verdict.ILLUSTRATED
        if not self.accepted.holds(finding.value):
            return Verdict.REFUTED
        if any(condition.needed for condition in finding.conditions):
            return Verdict.CONDITIONAL
        return Verdict.REPRODUCED

    def run(self, size: Size | str = Size.QUICK) -> "Entry":
        """Compute the claim and return its ledger entry."""
        size = Size(size)
        finding = self.compute(size, np.random.default_rng(self.seed))
        return Entry(
            id=self.id,
            chapter=self.chapter,
            paper=self.paper,
            place=self.place,
            statement=self.statement,
            paper_value=self.paper_value,
            method=self.method,
            accepted=None if self.accepted is None else self.accepted.ends(),
            accepted_why="" if self.accepted is None else self.accepted.why,
            seed=self.seed,
            size=str(size),
            verdict=str(self.verdict(finding)),
            value=asdict(finding.value),
            evidence={name: asdict(value) for name, value in finding.evidence.items()},
            conditions=[c.text for c in finding.conditions if c.needed],
            note=finding.note,
        )


@dataclass(frozen=True, slots=True)
class Entry:
    """One row of the ledger: a claim with what was computed, in plain types that JSON can hold."""

    id: str
    chapter: str
    paper: str
    place: str
    statement: str
    paper_value: str
    method: str
    accepted: list[float | None] | None
    accepted_why: str
    seed: int
    size: str
    verdict: str
    value: dict[str, Any]
    evidence: dict[str, dict[str, Any]]
    conditions: list[str]
    note: str

    @property
    def interval(self) -> Interval:
        """Our value as an :class:`Interval`."""
        return Interval(**self.value)


@dataclass(frozen=True, slots=True)
class Ledger:
    """The recorded claims with what was used to compute them."""

    entries: tuple[Entry, ...]
    versions: Mapping[str, str] = field(default_factory=dict)
    date: str = ""

    def __getitem__(self, claim_id: str) -> Entry:
        for entry in self.entries:
            if entry.id == claim_id:
                return entry
        known = ", ".join(e.id for e in self.entries)
        raise KeyError(f"no claim {claim_id!r} in the ledger; it has {known}")

    def chapter(self, stem: str) -> "Ledger":
        """Return the part of the ledger that one chapter computes."""
        return Ledger(tuple(e for e in self.entries if e.chapter == stem), self.versions, self.date)

    def to_json(self) -> str:
        """Return the ledger as JSON text."""
        document = {
            "date": self.date,
            "versions": dict(self.versions),
            "claims": [asdict(e) for e in self.entries],
        }
        return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"

    @classmethod
    def from_json(cls, text: str) -> "Ledger":
        """Return the ledger written by :meth:`to_json`.

        Raises
        ------
        ValueError
            If the text is no ledger.
        """
        try:
            document = json.loads(text)
            entries = tuple(Entry(**row) for row in document["claims"])
            return cls(entries, document["versions"], document["date"])
        except (KeyError, TypeError, json.JSONDecodeError) as error:
            raise ValueError(f"not a claim ledger: {error}") from error

    @classmethod
    def read(cls, path: Path | str) -> "Ledger":
        """Return the ledger stored in a file."""
        return cls.from_json(Path(path).read_text(encoding="utf-8"))


def unique(claims: Iterable[Claim]) -> tuple[Claim, ...]:
    """Return the claims as a tuple.

    Raises
    ------
    ValueError
        If two of them share an identifier.
    """
    claims = tuple(claims)
    ids = [claim.id for claim in claims]
    twice = sorted({i for i in ids if ids.count(i) > 1})
    if twice:
        raise ValueError(f"claims declared twice: {', '.join(twice)}")
    return claims
