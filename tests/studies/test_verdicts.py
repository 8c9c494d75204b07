"""The rule of the verdicts: a table of cases, and laws that every case obeys."""

import math
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from studies.intervals import Interval
from studies.verdicts import (
    Accepted,
    Basis,
    Condition,
    Origin,
    Turn,
    Verdict,
    decide,
    deciding,
    turn,
    turned,
)

HALF = Accepted(0.0, 0.5, "for the test")
SEEN, UNSEEN = Condition("it rains", needed=True), Condition("it rains", needed=False)


@pytest.mark.parametrize(
    ("low", "high", "conditions", "on_its_terms", "substitute"),
    [
        (0.1, 0.4, (), "reproduced", "reproduced"),
        (0.0, 0.5, (), "reproduced", "reproduced"),
        (0.1, 0.4, (UNSEEN,), "reproduced", "reproduced"),
        (0.1, 0.4, (UNSEEN, SEEN), "conditional", "conditional"),
        (0.35, 0.55, (), "inconclusive", "inconclusive"),
        (0.35, 0.55, (SEEN,), "inconclusive", "inconclusive"),
        (0.0, 3.0, (), "inconclusive", "inconclusive"),
        (-1.0, 3.0, (), "inconclusive", "inconclusive"),
        (0.5, 0.6, (), "inconclusive", "inconclusive"),
        (0.51, 0.6, (), "refuted", "not reproduced"),
        (0.51, 0.6, (SEEN,), "refuted", "not reproduced"),
        (-0.2, -0.1, (), "refuted", "not reproduced"),
    ],
)
def test_table_of_verdicts(low, high, conditions, on_its_terms, substitute):
    value = Interval((low + high) / 2, low, high)
    for basis in (Basis.MATHEMATICS, Basis.PAPER):
        assert decide(basis, HALF, value, conditions) == on_its_terms
    assert decide(Basis.SUBSTITUTE, HALF, value, conditions) == substitute


YES, NO, OPEN = Interval(0.2, 0.1, 0.4), Interval(0.7, 0.6, 0.8), Interval(0.4, 0.35, 0.55)


@pytest.mark.parametrize(
    ("value", "inside", "outside", "on_its_terms", "substitute"),
    [
        # the claim's own value lies in the part that the condition names
        (YES, None, None, "reproduced", "reproduced"),
        (YES, None, YES, "reproduced", "reproduced"),
        (YES, None, OPEN, "reproduced", "reproduced"),
        (YES, None, NO, "conditional", "conditional"),
        (YES, NO, None, "reproduced", "reproduced"),
        # it lies outside that part
        (NO, None, None, "refuted", "not reproduced"),
        (NO, NO, None, "refuted", "not reproduced"),
        (NO, OPEN, None, "refuted", "not reproduced"),
        (NO, YES, None, "conditional", "conditional"),
        (NO, None, NO, "refuted", "not reproduced"),
        # it reaches across both
        (OPEN, YES, NO, "conditional", "conditional"),
        (OPEN, YES, None, "inconclusive", "inconclusive"),
        (OPEN, None, NO, "inconclusive", "inconclusive"),
        (OPEN, NO, YES, "inconclusive", "inconclusive"),
    ],
)
def test_table_of_conditions(value, inside, outside, on_its_terms, substitute):
    condition = Condition.judged("it rains", HALF, inside=inside, outside=outside)
    for basis in (Basis.MATHEMATICS, Basis.PAPER):
        assert decide(basis, HALF, value, [condition]) == on_its_terms
    assert decide(Basis.SUBSTITUTE, HALF, value, [condition]) == substitute
    decided = (condition,) if on_its_terms == "conditional" else ()
    assert deciding(HALF, value, [UNSEEN, condition]) == decided


def test_nothing_to_compare_and_nothing_measured():
    assert decide(Basis.PAPER, None, Interval(1, 1, 1)) == Verdict.ILLUSTRATED
    assert decide(Basis.MATHEMATICS, HALF, None, (SEEN,)) == Verdict.UNTESTABLE
    assert decide(Basis.SUBSTITUTE, None, None) == Verdict.UNTESTABLE
    assert deciding(None, Interval(1, 1, 1), [SEEN]) == deciding(HALF, None, [SEEN]) == ()


def test_a_basis_that_is_none_is_refused():
    with pytest.raises(ValueError, match="guess"):
        decide("guess", HALF, Interval(1, 1, 1))


numbers = st.integers(-200, 200).map(lambda n: n / 8)  # sums and differences are exact
intervals = (
    st.tuples(numbers, numbers, numbers).map(sorted).map(lambda x: Interval(x[1], x[0], x[2]))
)
ends = st.tuples(numbers | st.just(-math.inf), numbers | st.just(math.inf))
ranges = ends.filter(lambda e: e[0] <= e[1]).map(lambda e: Accepted(*e, "drawn"))
bases = st.sampled_from(Basis)
some = st.lists(st.sampled_from([SEEN, UNSEEN]), max_size=2)
HOLDING = {Verdict.REPRODUCED, Verdict.CONDITIONAL}
FAILING = {Verdict.REFUTED, Verdict.NOT_REPRODUCED}


@given(bases, ranges, intervals, some)
def test_the_sure_verdicts_need_every_number_of_the_interval(basis, accepted, value, conditions):
    verdict = decide(basis, accepted, value, conditions)
    inside = [accepted.low <= x <= accepted.high for x in (value.low, value.high)]
    points = [
        decide(basis, accepted, Interval(x, x, x), conditions) for x in (value.low, value.high)
    ]
    if verdict in HOLDING:
        assert all(inside)
    if verdict in FAILING:
        assert not any(inside)
        assert verdict == (Verdict.NOT_REPRODUCED if basis == Basis.SUBSTITUTE else Verdict.REFUTED)
    if verdict == Verdict.INCONCLUSIVE:
        between = value.low < accepted.low <= accepted.high < value.high
        assert between or any(inside)
        assert not all(inside)
    else:
        assert set(points) == {verdict}


@given(bases, ranges, intervals, intervals, intervals)
def test_it_does_not_matter_which_reading_is_called_the_claims_own(basis, accepted, a, b, c):
    """Of a value inside a part and one outside it, each may be the claim's own, or neither."""
    outside, inside, both = (
        Condition.judged("it rains", accepted, **values)
        for values in ({"outside": b}, {"inside": a}, {"inside": a, "outside": b})
    )
    conditional = accepted.contains(a) and accepted.excludes(b)
    for value, condition in ((a, outside), (b, inside)):
        verdict = decide(basis, accepted, value, [condition])
        assert (verdict == Verdict.CONDITIONAL) == conditional
    if conditional:
        assert decide(basis, accepted, c, [both]) == Verdict.CONDITIONAL


@given(bases, ranges, intervals, st.floats(0, 10), st.floats(0, 10))
def test_a_wider_range_never_makes_a_claim_fail_that_held(basis, accepted, value, below, above):
    wider = replace(accepted, low=accepted.low - below, high=accepted.high + above)
    before, after = (decide(basis, a, value) for a in (accepted, wider))
    rank = {Verdict.REFUTED: 0, Verdict.NOT_REPRODUCED: 0, Verdict.INCONCLUSIVE: 1}
    assert rank.get(before, 2) <= rank.get(after, 2)


@given(bases, ranges, intervals)
def test_turn_is_where_the_verdict_changes(basis, accepted, value):
    move = turn(accepted, value)
    before = decide(basis, accepted, value)
    if move is None:
        assert accepted.contains(value)
        assert math.isinf(accepted.high)
        assert math.isinf(accepted.low)
        return
    slack = 1 / 64

    def moved(by):
        low = accepted.low - (by if move.end in ("lower", "both") else 0)
        high = accepted.high + (by if move.end in ("upper", "both") else 0)
        assume(low <= high)  # a range that is narrowed to nothing holds nothing
        return decide(basis, replace(accepted, low=low, high=high), value)

    if move.by == 0:  # it touches: the least step one way turns it
        assert {moved(slack), moved(-slack)} > {before}
    else:
        beyond = math.copysign(slack, move.by)
        assert moved(move.by + beyond) != before
        assert moved(move.by - beyond) == before


def test_range_says_who_set_it_and_why():
    assert HALF.origin == Origin.THEORY
    assert Accepted(0, 1, "a round number", "our choice").origin is Origin.CHOICE
    for bad, match in (
        ((2, 1, "why"), "low <= high"),
        ((math.nan, 1, "why"), "low <= high"),
        ((1, 2, " "), "say why"),
        ((1, 2, "why", "habit"), "habit"),
    ):
        with pytest.raises(ValueError, match=match):
            Accepted(*bad)


def test_turn_in_numbers():
    assert turn(HALF, Interval(0.3, 0.1, 0.45)).end == "upper"
    assert turn(HALF, Interval(0.3, 0.1, 0.45)).by == pytest.approx(-0.05)
    assert turn(HALF, Interval(0.7, 0.6, 0.8)).by == pytest.approx(0.1)
    assert turn(HALF, Interval(0.7, 0.45, 0.8)).by == pytest.approx(-0.05)
    assert turn(Accepted(-math.inf, 1, "one-sided"), Interval(0.7, 0.6, 0.8)).by == pytest.approx(
        -0.2
    )
    assert turn(Accepted(-math.inf, math.inf, "all"), Interval(0.7, 0.6, 0.8)) is None
    assert turn(HALF, Interval(1, -1, 3)) == Turn("both", 2.5)
    assert turn(Accepted(0, 0, "a point"), Interval(1, 1, 1)) == Turn("upper", 1)


@pytest.mark.parametrize(
    ("before", "turning"),
    [
        ("reproduced", {"refuted", "not reproduced"}),
        ("conditional", {"refuted", "not reproduced"}),
        ("refuted", {"reproduced", "conditional"}),
        ("not reproduced", {"reproduced", "conditional"}),
        ("inconclusive", {"reproduced", "conditional", "refuted", "not reproduced"}),
    ],
)
def test_a_sabotage_turns_a_verdict_only_into_its_opposite(before, turning):
    assert {str(v) for v in Verdict if turned(before, v)} == turning
