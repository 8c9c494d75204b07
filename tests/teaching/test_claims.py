"""The ledger: verdicts follow from findings, intervals from statistics, JSON loses nothing."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.teaching.claims import (
    Accepted,
    Claim,
    Condition,
    Finding,
    Interval,
    Ledger,
    Size,
    Verdict,
    unique,
)

ACCEPTED = Accepted(1.0, 2.0, "theory")


def claim(value, accepted=ACCEPTED, conditions=(), **changes):
    fields = {
        "id": "some-claim",
        "chapter": "walls",
        "paper": "perception-issues",
        "place": "§2.1",
        "statement": "Something holds.",
        "paper_value": "",
        "method": "measured",
        "accepted": accepted,
        "compute": lambda size, rng: Finding(value, conditions=conditions),
        "seed": 3,
    }
    return Claim(**(fields | changes))


@pytest.mark.parametrize(
    ("value", "conditions", "verdict"),
    [
        (Interval(1.5, 1.2, 1.8), (), Verdict.REPRODUCED),
        (Interval(1.5, 1.0, 2.0), (), Verdict.REPRODUCED),
        (Interval(1.5, 0.9, 1.8), (), Verdict.REFUTED),
        (Interval(3.0, 2.5, 3.5), (), Verdict.REFUTED),
        (Interval(1.5, 1.2, 1.8), (Condition("it rains", needed=True),), Verdict.CONDITIONAL),
        (Interval(1.5, 1.2, 1.8), (Condition("it rains", needed=False),), Verdict.REPRODUCED),
        (Interval(3.0, 2.5, 3.5), (Condition("it rains", needed=True),), Verdict.REFUTED),
    ],
)
def test_verdict_follows_from_interval_and_conditions(value, conditions, verdict):
    entry = claim(value, conditions=conditions).run()
    assert entry.verdict == verdict
    assert entry.conditions == [c.text for c in conditions if c.needed]


def test_claim_without_accepted_range_is_illustrated():
    assert claim(Interval.exact(7), accepted=None).run().verdict == Verdict.ILLUSTRATED


def test_compute_gets_the_size_and_the_seeded_generator():
    seen = []

    def compute(size, rng):
        seen.append((size, rng.integers(1 << 30)))
        return Finding(Interval.exact(1.5))

    some = claim(None, compute=compute)
    some.run("full")
    some.run(Size.FULL)
    assert seen[0] == seen[1] == (Size.FULL, np.random.default_rng(3).integers(1 << 30))


@pytest.mark.parametrize("bad", [(3, 1, 2), (1, 2, 3), (math.nan, 0, 1), (1, 0, math.inf)])
def test_interval_refuses_disorder_and_non_finite(bad):
    with pytest.raises(ValueError, match="interval must"):
        Interval(*bad)


def test_mean_interval_covers_the_truth_as_often_as_it_says():
    samples = np.random.default_rng(0).normal(3.0, 2.0, size=(4000, 12))
    covered = 0
    for run in samples:
        interval = Interval.of_mean(run)
        covered += interval.low <= 3.0 <= interval.high
    low, high = 4000 * 0.95 + np.array([-4, 4]) * math.sqrt(4000 * 0.95 * 0.05)
    assert low < covered < high


def test_proportion_interval_is_wilson():
    interval = Interval.of_proportion(8, 10)
    z = 1.959963984540054
    centre = (0.8 + z**2 / 20) / (1 + z**2 / 10)
    half = z / (1 + z**2 / 10) * math.sqrt(0.16 / 10 + z**2 / 400)
    assert (interval.low, interval.high) == pytest.approx((centre - half, centre + half))


@given(st.integers(1, 200).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_proportion_interval_holds_the_rate(counts):
    interval = Interval.of_proportion(*counts)
    assert 0 <= interval.low <= interval.estimate <= interval.high <= 1


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: Interval.of_mean(np.array([1.0])), "at least 2"),
        (lambda: Interval.of_mean(np.array([1.0, np.nan])), "not finite"),
        (lambda: Interval.of_quantiles(np.array([])), "at least 1"),
        (lambda: Interval.of_proportion(3, 2), "3 of 2"),
        (lambda: Accepted(2, 1, "why"), "low <= high"),
        (lambda: Accepted(1, 2, " "), "say why"),
        (lambda: unique([claim(Interval.exact(1)), claim(Interval.exact(2))]), "some-claim"),
    ],
)
def test_bad_input_is_named(make, match):
    with pytest.raises(ValueError, match=match):
        make()


def test_json_round_trip_keeps_every_field_and_infinite_ends():
    some = claim(Interval(1.5, 1.2, 1.8, "m", "95 %"), Accepted(1.0, math.inf, "one-sided"))
    ledger = Ledger((some.run(),), {"numpy": "2"}, "2026-01-01")
    document = json.loads(ledger.to_json(), parse_constant=pytest.fail)
    assert document["claims"][0]["accepted"] == [1.0, None]
    again = Ledger.from_json(ledger.to_json())
    assert again["some-claim"].interval == Interval(1.5, 1.2, 1.8, "m", "95 %")
    assert again.to_json() == ledger.to_json()
    assert again.chapter("monobot").entries == ()


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"claims": [{"id": 1}]}', "\x00"])
def test_reading_no_ledger_is_a_clear_error(text):
    with pytest.raises(ValueError, match="not a claim ledger"):
        Ledger.from_json(text)


def test_unknown_claim_names_the_known_ones():
    with pytest.raises(KeyError, match="some-claim"):
        Ledger((claim(Interval.exact(1.5)).run(),))["other"]
