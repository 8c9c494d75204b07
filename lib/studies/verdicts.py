"""The rule by which a verdict follows from a measured interval and an accepted range.

One pure function, :func:`decide`; :func:`turn` says how far the range would have to move before
the verdict changed, :func:`turned` whether a sabotage changed it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from studies.checks import one_of
from studies.intervals import Interval


class Basis(StrEnum):
    """Basis of a verdict.

    ``mathematics``: an identity, a count or a rank, decided by proof, algebra or exhaustive check;
    ``paper``: an experiment repeated on the paper's own terms, every parameter known;
    ``substitute``: our world, recording or parameter stands in for one that is not to be had.
    """

    MATHEMATICS = "mathematics"
    PAPER = "paper"
    SUBSTITUTE = "substitute"


class Verdict(StrEnum):
    """Verdict of the computation on a claim."""

    REPRODUCED = "reproduced"
    CONDITIONAL = "conditional"
    REFUTED = "refuted"
    NOT_REPRODUCED = "not reproduced"
    INCONCLUSIVE = "inconclusive"
    ILLUSTRATED = "illustrated"
    UNTESTABLE = "untestable"


class Origin(StrEnum):
    """Origin of an accepted range: who set it."""

    THEORY = "theory"
    PAPER = "paper"
    CHOICE = "our choice"


@dataclass(frozen=True, slots=True)
class Accepted:
    """The range inside which the paper's statement counts as holding.

    Parameters
    ----------
    low, high
        Its ends, both included; infinite for an open end.
    why
        Why it is that range.
    origin
        Whether theory, the paper's own number or we set it.

    Raises
    ------
    ValueError
        If the ends are in disorder or not a number, no reason is given, or the origin is unknown.
    """

    low: float
    high: float
    why: str
    origin: Origin | str = Origin.THEORY

    def __post_init__(self) -> None:
        if not self.low <= self.high:
            raise ValueError(
                f"accepted range must satisfy low <= high, got {self.low}, {self.high}"
            )
        if not self.why.strip():
            raise ValueError("an accepted range must say why it is that range")
        object.__setattr__(self, "origin", Origin(one_of("origin", self.origin, Origin)))

    def contains(self, value: Interval) -> bool:
        """Return whether the whole interval of ``value`` lies inside the range."""
        return self.low <= value.low and value.high <= self.high

    def excludes(self, value: Interval) -> bool:
        """Return whether the interval of ``value`` and the range have no number in common."""
        return value.high < self.low or value.low > self.high


@dataclass(frozen=True, slots=True)
class Condition:
    """A part of the domain in which a claim holds, and what was seen in it and outside it.

    The paper's setting can lie in that part: what merely takes the statement back is no condition.

    Parameters
    ----------
    text
        Where the claim holds, in words that never negate the claim: it follows "only if".
    needed
        ``True`` if the claim was computed outside that part and did not hold.
    holds
        ``True`` if it was computed inside that part, besides the value of the claim, and held.
    """

    text: str
    needed: bool
    holds: bool = False

    @classmethod
    def judged(
        cls,
        text: str,
        accepted: Accepted,
        *,
        inside: Interval | None = None,
        outside: Interval | None = None,
    ) -> "Condition":
        """Return a condition by the claim's range, of values inside and outside its part."""
        needed = outside is not None and accepted.excludes(outside)
        return cls(text, needed, inside is not None and accepted.contains(inside))


def deciding(
    accepted: Accepted | None, value: Interval | None, conditions: Sequence[Condition]
) -> tuple[Condition, ...]:
    """Return the conditions on which it hangs whether a claim holds.

    The claim was seen to hold in the part that such a condition names, and to fail outside it. One
    of the two may be the claim's own value; it does not matter which.
    """
    if accepted is None or value is None:
        return ()
    holds, fails = accepted.contains(value), accepted.excludes(value)
    return tuple(c for c in conditions if (c.holds or holds) and (c.needed or fails))


def decide(
    basis: Basis | str,
    accepted: Accepted | None,
    value: Interval | None,
    conditions: Sequence[Condition] = (),
) -> Verdict:
    """Return the verdict.

    ==============  ======================================================================
    conditional     seen to hold in a named part of the domain, and to fail outside it
    reproduced      the whole interval lies inside the accepted range
    refuted         interval and range are disjoint, by mathematics or on the paper's own terms
    not reproduced  interval and range are disjoint, but something stands in for the paper's
    inconclusive    the interval overlaps the range and its complement
    illustrated     the paper gives nothing to compare with
    untestable      nothing could be measured
    ==============  ======================================================================

    Parameters
    ----------
    basis
        What the measurement stands on.
    accepted
        The range in which the claim holds, ``None`` if the paper gives nothing to compare with.
    value
        What was measured, ``None`` if nothing could be.
    conditions
        Parts of the domain in which the claim holds.
    """
    if value is None:
        return Verdict.UNTESTABLE
    if accepted is None:
        return Verdict.ILLUSTRATED
    if deciding(accepted, value, conditions):
        return Verdict.CONDITIONAL
    if accepted.contains(value):
        return Verdict.REPRODUCED
    if accepted.excludes(value):
        own_terms = Basis(basis) in (Basis.MATHEMATICS, Basis.PAPER)
        return Verdict.REFUTED if own_terms else Verdict.NOT_REPRODUCED
    return Verdict.INCONCLUSIVE


HOLDS = frozenset({Verdict.REPRODUCED, Verdict.CONDITIONAL})
FAILS = frozenset({Verdict.REFUTED, Verdict.NOT_REPRODUCED})


def turned(before: Verdict | str, after: Verdict | str) -> bool:
    """Return whether a verdict says the opposite of another one, as that of a sabotage must.

    What held must fail and what failed must hold. A claim that is undecided must be decided either
    way.

    Raises
    ------
    ValueError
        If one of the two is no verdict.
    """
    for name, verdict in (("before", before), ("after", after)):
        one_of(name, verdict, tuple(Verdict))
    if before in HOLDS:
        return after in FAILS
    return after in (HOLDS if before in FAILS else HOLDS | FAILS)


@dataclass(frozen=True, slots=True)
class Turn:
    """The smallest change of an accepted range beyond which the verdict is another one.

    Parameters
    ----------
    end
        Which end moves: ``"lower"`` or ``"upper"``, or ``"both"``.
    by
        How far, in the unit of the value; positive makes the range wider.
    """

    end: str
    by: float


def turn(accepted: Accepted, value: Interval) -> Turn | None:
    """Return how far the range must move to turn the verdict, ``None`` if no finite move does.

    An interval inside stops being so when an end of the range passes its own end; one outside
    begins to overlap; one across gets inside when the range is widened past what sticks out, or
    outside when it is narrowed to what does not.
    """
    below, above = accepted.low - value.low, value.high - accepted.high
    if accepted.contains(value):
        moves = [Turn("lower", below), Turn("upper", above)]
    elif accepted.excludes(value):
        moves = [Turn("lower", accepted.low - value.high), Turn("upper", value.low - accepted.high)]
        moves = [move for move in moves if move.by > 0]
    elif below > 0 and above > 0:
        moves = [Turn("both", max(below, above))]
    elif below > 0:
        moves = [Turn("lower", below), Turn("lower", accepted.low - value.high)]
    else:
        moves = [Turn("upper", above), Turn("upper", value.low - accepted.high)]
    finite = [move for move in moves if math.isfinite(move.by)]
    return min(finite, key=lambda move: abs(move.by), default=None)
