"""The claims of the chapter: the record, and what their findings must say."""

import pytest

from robot_perception.chapters.sift_association import table1
from tests.chapters.ledger import LedgerTests, quick, recorded

TO_MEANS = "gain over Euclid to the means"


class TestLedger(LedgerTests):
    stem = "sift_association"
    open_when_quick = frozenset({"table1"})


def test_right_matches_are_fewer_without_either_rule():
    table = recorded()["stereo-sift"].tables["with and without the rules"]
    both = table["both rules", "right"]
    for name in ("no row rule", "no threshold", "neither"):
        assert table[name, "right"].estimate < both.estimate
    assert table["neither", "right"].high < both.low


def test_a_landmark_from_aside_is_farther_than_a_look_alike_and_nearer_than_another_landmark():
    finding = quick("viewpoint")
    alike, large, other = (
        finding.evidence[name]
        for name in (
            "distance between look-alikes",
            "distance at 30°",
            "distance to the nearest other landmark",
        )
    )
    assert alike.high < large.low
    assert large.high < other.low


def test_gains_are_differences_of_the_shares():
    finding = quick("mahalanobis-needs")
    right = quick("table1").tables[f"right, {table1.TESTS['again']}"]
    for table, other in (("gain over Euclid", table1.ONE_VIEW), (TO_MEANS, table1.EUCLID)):
        gain = right["raw", "p = 3"].estimate - right[other, "p = 3"].estimate
        row = f"raw, {table1.TESTS['again']}"
        assert finding.tables[table][row, "p = 3"].estimate == pytest.approx(gain)


def test_the_verdict_hangs_on_which_descriptor_euclid_is_to():
    found = recorded()["mahalanobis-needs"]
    assert found.value.low > 0 > found.evidence[TO_MEANS].high
    assert table1.FIRST in found.conditions


def test_five_degrees_are_not_nothing_and_thirty_are_more():
    found = recorded()["viewpoint"].evidence
    assert found["distance, 5° apart over look-alikes"].low > 1.5
    assert found["distance at 30°"].low > 1.5 * found["distance at 5°"].high


def test_a_class_knows_its_own_frames_and_with_few_of_them_hardly_any_others():
    tables = recorded()["table1"].tables
    own, other = (tables[f"right, {table1.TESTS[name]}"] for name in ("trained", "again"))
    assert own["raw", "p = 3"].low > 99
    assert other["raw", "p = 3"].estimate < other["Euclid", "p = 3"].estimate - 2


def test_shared_variances_do_not_lose_where_raw_ones_do():
    gains = recorded()["mahalanobis-needs"].tables[TO_MEANS]
    row = table1.TESTS["aside"] + table1.STRAIGHT
    for column in gains.columns:
        assert gains[f"raw, {row}", column].high < -5
        assert gains[f"pooled, {row}", column].low > -1


def test_as_printed_nothing_is_new_and_as_meant_most_of_it():
    found = recorded()["erratum-new-landmark"]
    assert found.value.high == 0
    assert found.evidence["called new if all exceed the threshold"].low > 0.7


def test_shrunk_variances_break_even_and_with_the_log_determinant_gain_less_than_two_points():
    gains, row = recorded()["mahalanobis-needs"].tables[TO_MEANS], table1.TESTS["again"]
    even = gains[f"shrunk, {row}", "p = 30"]
    assert even.low < 0 < even.high
    assert 0 < gains[f"shrunk{table1.WITH}, {row}", "p = 30"].low < 2
