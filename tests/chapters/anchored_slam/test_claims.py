"""The claims of the chapter: the record, and what their findings must say."""

from dataclasses import replace

import pytest

from robot_perception.chapters.anchored_slam import gauge, rails
from tests.chapters.ledger import LedgerTests, quick, recorded


class TestLedger(LedgerTests):
    stem = "anchored_slam"


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("anchored_slam").entries} == {
        "anchor-full-rank": "reproduced",
        "anchor-unbiased": "conditional",  # on a reference that is good enough
        "external-sensor": "conditional",  # on the same
        "planar-anchor-matrix": "conditional",  # on a robot that translates
        "planar-anchor": "refuted",
        "planar-position-sensor": "conditional",  # on a robot that translates
    }


# The rail


def test_the_filter_without_a_reference_would_fail_the_claim():
    table = quick("anchor-unbiased").tables["with and without the reference"]
    assert table["none", "left"].low > rails.anchor_unbiased.accepted.high
    assert table["anchor", "left"] == quick("anchor-unbiased").value


def test_without_the_anchor_a_rank_is_missing():
    finding = quick("anchor-full-rank")
    assert finding.evidence["missing ranks without the anchor, n = 1"].estimate == 1
    table = finding.tables["information on the start (1/m²)"]
    ratio = table["landmark", "200 measurements"] / table["landmark", "100 measurements"]
    assert ratio == pytest.approx(2, rel=0.01)


def test_anchor_and_sensor_are_one_system_with_one_range_and_one_condition():
    anchor, sensor = quick("anchor-unbiased"), quick("external-sensor")
    assert rails.anchor_unbiased.accepted == rails.external_sensor.accepted
    for finding, other in ((anchor, "external sensor"), (sensor, "anchor")):
        for what in ("covariances", "sums (14)"):
            name = f"largest relative difference of the {what} from an {other} of equal noise"
            assert finding.evidence[name].estimate == 0
        (condition,) = finding.conditions
        assert condition.needed
        left = [finding.tables["other noises"][f"{d} m", "left"] for d in rails.NOISES]
        assert left == sorted(left)
        assert left[0] < rails.UNSEEN < left[-1]


@pytest.mark.parametrize("key", ["anchor-unbiased", "external-sensor"])
def test_dependence_falls_like_one_over_the_measurements(key):
    name = "exponent of the explained share against the measurements, by the covariances"
    assert quick(key).evidence[name].estimate == pytest.approx(-1, abs=0.01)


# One anchor in the plane


def test_one_anchor_leaves_the_turn_about_itself_unseen():
    finding = quick("planar-anchor")
    assert finding.value.estimate == 1
    assert not finding.conditions
    for (name, reading), exact in gauge.ranks(moving=True).items():
        assert finding.tables["ranks"][name, reading] == exact.rank
    assert finding.evidence["directions unseen, two anchors"].estimate == 0
    assert "in 10 of 10 runs" in finding.note
    assert finding.note.endswith("at consistent points, in 0.")


@pytest.mark.parametrize(
    ("better", "anchor", "sensor"),
    [
        ({}, "refuted", "conditional"),
        ({"one anchor": 5}, "reproduced", "conditional"),
        ({"position sensor": 5}, "refuted", "reproduced"),
        ({"two anchors": 4, "position sensor": 4}, "refuted", "refuted"),
    ],
)
def test_the_verdicts_follow_from_the_ranks(monkeypatch, better, anchor, sensor):
    honest = {moving: gauge.ranks(moving=moving) for moving in (True, False)}

    def doctored(*, moving):
        return {
            (name, reading): replace(exact, rank=better.get(name, exact.rank))
            for (name, reading), exact in honest[moving].items()
        }

    monkeypatch.setattr(gauge, "ranks", doctored)
    filters = gauge.ONE_ANCHOR.result("quick").filters
    found = gauge.Observed(gauge.unseen("one anchor"), filters)
    assert gauge.planar_anchor.verdict(gauge.planar_anchor.compute(found, found.unseen)) == anchor
    found = gauge.Observed(gauge.unseen("position sensor"), {})
    claim = gauge.planar_position_sensor
    assert claim.verdict(claim.compute(found)) == sensor


@pytest.mark.parametrize("key", ["planar-position-sensor", "planar-anchor-matrix"])
def test_full_rank_needs_a_robot_that_translates(key):
    (translates,) = quick(key).conditions
    assert translates.needed
    assert "translates" in translates.text


def test_the_matrix_has_the_rank_that_the_anchor_has_not():
    """The two claims differ in one thing, the points at which Jacobians are taken."""
    matrix, anchor = gauge.planar_anchor_matrix, gauge.planar_anchor
    assert matrix.study.full.sensing == anchor.study.full.sensing
    assert quick("planar-anchor-matrix").value.estimate == 0
    for reading in gauge.READINGS:
        missing = gauge.unseen("one anchor", (reading,)).estimate
        assert missing == (reading != "one point")
    assert gauge.unseen("one anchor, robot at rest", ("one point",)).estimate == 1
