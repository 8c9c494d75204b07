"""The claims of the chapter: the record, and what their findings must say."""

import numpy as np
import pytest

from robot_perception.chapters.loop_closing import figures as draw
from robot_perception.chapters.loop_closing import loops, posts
from robot_perception.teaching.figures import figure
from tests.chapters.ledger import LedgerTests, quick, recorded

LARGE = "large noise, gated, uncertain start"
FACTOR = "NEES, plain over first estimates"


class TestLedger(LedgerTests):
    stem = "loop_closing"


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("loop_closing").entries} == {
        "planar-loop": "not reproduced",
        "controllability-observable": "conditional",  # on two that have left
        "controllability-rule": "not reproduced",
        "jacobian-consistency": "conditional",
    }


# The loop


def test_the_anchor_and_the_plain_filter_end_alike_and_the_external_sensor_does_not():
    finding = quick("planar-loop")
    external = finding.evidence["end error, external over plain"].estimate
    assert external < 0.5 < finding.value.low


def test_an_exact_start_leaves_the_anchor_nothing_to_do_and_an_uncertain_one_does():
    """Of the record: what the claim is not tested on, and where an anchor helps."""
    table = recorded()["planar-loop"].tables["what the anchor does"]
    for noise in ("small", "large"):
        exact, uncertain = (
            table[f"{noise} noise, known, {start} start", "ratio"]
            for start in ("exact", "uncertain")
        )
        assert uncertain.high < 1
        assert uncertain.estimate < exact.low
    assert table["small noise, gated, displaced start", "ratio"].high < 0.2


def test_hardly_a_landmark_of_the_building_is_seen_often_enough_for_the_papers_limit():
    finding = recorded()["planar-loop"]
    seen = finding.evidence["sightings of a landmark in a drive"]
    assert 5 < seen.estimate < seen.high < 50
    assert finding.evidence["landmarks removed by the rule at 15"].low > 5


def test_tables_and_ratios_of_the_loop_are_of_the_same_runs():
    finding = quick("planar-loop")
    table = finding.tables[LARGE]
    for name in ("anchored", "external"):
        ratio = table[name, "end (m)"].estimate / table["plain", "end (m)"].estimate
        assert finding.evidence[f"end error, {name} over plain"].estimate == pytest.approx(ratio)
    assert finding.tables["what the anchor does"][LARGE, "ratio"] == finding.value
    known = finding.tables["large noise, known, exact start"]
    assert list(known.rows) == ["plain", "anchored"]
    assert known["plain", "wrong"].high == known["plain", "twice"].high == 0
    _, axes = figure(1, 2)
    draw.end_errors.on(axes, {"large": table, "known": known})
    assert [name.get_text().replace("\n", " ") for name in axes[0].get_yticklabels()] == list(
        table.rows
    )


# The posts


def test_the_factor_of_the_jacobians_is_that_of_the_tables_and_needs_a_turned_start():
    finding = quick("jacobian-consistency")
    for name in posts.STUDIES:
        table, factor = finding.tables[name], finding.evidence[f"{FACTOR}, {name}"]
        means = [table[variant, "NEES"].estimate for variant in posts.CHANGING]
        assert factor.estimate == pytest.approx(means[0] / means[1])
    assert finding.value == finding.evidence[f"{FACTOR}, turned"]
    assert finding.evidence[f"{FACTOR}, linear"].high < posts.EXCESS


def test_agreeing_jacobians_remove_most_of_the_excess_nees_and_little_of_the_error():
    found = recorded()["jacobian-consistency"].evidence
    assert found[f"{posts.EXCESS_SHARE}, turned"].low > 0.5
    assert found[f"{posts.ERROR_SHARE}, turned"].high < 0.5


def test_the_rule_is_judged_by_consistency_and_its_errors_stand_beside():
    finding = quick("controllability-rule")
    table = finding.tables["with and without the rule"]
    with_rule, without = table["rule at 50", "NEES"], table["plain", "NEES"]
    assert finding.value.estimate == pytest.approx(with_rule.estimate / without.estimate)


def test_by_rank_two_removed_landmarks_are_enough_and_one_is_not():
    finding = quick("controllability-observable")
    assert [posts.unseen_by_rank(posts.Removed(n)).estimate for n in range(3)] == [3, 1, 0]
    (condition,) = finding.conditions
    assert condition.needed
    assert finding.value.estimate == 0


def test_the_second_landmark_leaves_when_the_filter_says_so():
    """By the sizes of the map that the filter keeps: it drops twice before the share is over."""
    one = posts.simulate(posts.RULE, rng=np.random.default_rng(3))
    history = loops.filter_drive(posts.case(posts.RULE, "rule at 50"), one)
    seen = [set(ids) for ids in (step.ids.tolist() for step in one.seen)]
    known = [len(set().union(*seen[: k + 1])) for k in range(len(seen))]
    removed = np.array(known) - history.sizes
    assert posts.before_two_leave(posts.RULE, 50).estimate == pytest.approx((removed < 2).mean())
