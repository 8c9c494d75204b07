"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

import numpy as np
import pytest

from robot_perception.chapters.anchored_slam import gauge, rails
from robot_perception.chapters.anchored_slam.figures import loops as draw
from robot_perception.slam.observability.symbolic import Reading
from robot_perception.teaching.claims import Size
from robot_perception.teaching.figures import figure
from tests.chapters.ledger import LedgerTests, quick, recorded

LARGE = "large noise, gated, exact start"


class TestLedger(LedgerTests):
    stem = "anchored_slam"


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("anchored_slam").entries} == {
        "anchor-full-rank": "reproduced",
        "anchor-unbiased": "reproduced",
        "external-sensor": "conditional",  # on a sensor that is good enough
        "planar-observability": "conditional",
        "planar-loop": "not reproduced",
        "controllability-rule": "conditional",
        "jacobian-consistency": "conditional",
    }


# The rail


def test_the_filter_without_a_reference_would_fail_the_claim():
    table = quick("anchor-unbiased").tables["with and without the anchor"]
    assert table["none", "explained"].low > rails.anchor_unbiased.accepted.high


def test_without_the_anchor_a_rank_is_missing():
    finding = quick("anchor-full-rank")
    assert finding.evidence["missing ranks without the anchor, n = 1"].estimate == 1
    table = finding.tables["information on the start (1/m²)"]
    ratio = table["landmark", "200 looks"] / table["landmark", "100 looks"]
    assert ratio == pytest.approx(2, rel=0.01)


@pytest.mark.parametrize("key", ["anchor-unbiased", "external-sensor"])
def test_dependence_falls_like_one_over_the_looks(key):
    name = "exponent of the explained share against the looks, by the covariances"
    assert quick(key).evidence[name].estimate == pytest.approx(-1, abs=0.01)


# One anchor in the plane


def test_one_anchor_is_conditional_and_says_on_what():
    finding = quick("planar-observability")
    assert finding.value.estimate == 0
    company, translates = finding.conditions
    assert company.needed
    assert "second anchor or a compass" in company.text
    assert translates.needed
    assert "translates" in translates.text
    for (name, reading), exact in gauge.ranks(moving=True).items():
        assert finding.tables["ranks"][name, reading] == exact.rank
    assert "in 10 of 10 runs" in finding.note
    assert finding.note.endswith("at consistent points, in 0.")


@pytest.mark.parametrize(
    ("better", "verdict"),
    [
        ({}, "conditional"),
        ({"one anchor": 5}, "conditional"),
        ({"one anchor": 5, "position sensor": 5}, "reproduced"),
        ({"two anchors": 4}, "refuted"),
    ],
)
def test_the_verdict_follows_from_the_ranks(monkeypatch, better, verdict):
    honest = {moving: gauge.ranks(moving=moving) for moving in (True, False)}

    def doctored(*, moving):
        table = dict(honest[moving])
        for (name, reading), exact in honest[moving].items():
            rank = better.get(name, exact.rank)
            table[name, reading] = Reading(exact.dimension, rank, exact.unseen)
        return MappingProxyType(table)

    monkeypatch.setattr(gauge, "ranks", doctored)
    monkeypatch.setattr(gauge, "RUNS", {Size.QUICK: 2})
    claim = gauge.planar_observability
    finding = claim.compute(Size.QUICK, np.random.default_rng(claim.seed))
    assert claim.verdict(finding) == verdict


# The loop


def test_the_anchor_and_the_plain_filter_end_alike_and_the_external_sensor_does_not():
    finding = quick("planar-loop")
    external = finding.evidence["end error, external over plain"].estimate
    assert external < 0.5 < finding.value.low


def test_tables_and_ratios_of_the_loop_are_of_the_same_runs():
    finding = quick("planar-loop")
    table = finding.tables[LARGE]
    for name in ("anchored", "external"):
        ratio = table[name, "end (m)"].estimate / table["plain", "end (m)"].estimate
        assert finding.evidence[f"end error, {name} over plain"].estimate == pytest.approx(ratio)
    known = finding.tables["large noise, known, exact start"]
    assert list(known.rows) == ["plain", "anchored"]
    assert known["plain", "wrong"].high == known["plain", "twice"].high == 0
    _, axes = figure(1, 2)
    draw.end_errors(axes, {"large": table, "known": known})
    assert [t.get_text() for t in axes[0].get_yticklabels()] == list(table.rows)
