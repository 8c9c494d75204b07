"""The claims of the chapter: as recorded, and what else their findings must show."""

import pytest

from robot_perception.chapters.monobot.rail import GOLDEN
from robot_perception.chapters.monobot.steady import monte_carlo_unbiased
from tests.chapters.ledger import LedgerTests, quick


class TestLedger(LedgerTests):
    stem = "monobot"


def test_information_slopes_are_the_closed_forms():
    finding = quick("fisher-growth")
    for slope, form in finding.tables["slopes"].rows.values():
        assert slope == pytest.approx(form, rel=1e-9)
    start = finding.evidence["information on the start itself, n = 1"].estimate
    assert start == pytest.approx(1 / GOLDEN, rel=1e-9)


def test_nothing_but_a_shift_is_dark():
    evidence = quick("fisher-singular").evidence
    assert {value.estimate for value in evidence.values()} == {0.0}


def test_a_biased_filter_would_fail_the_unbiasedness_claim():
    shifted = quick("monte-carlo-unbiased").evidence[
        "what a sensor that reads a fifth of the spread too long would give"
    ]
    assert shifted.low > monte_carlo_unbiased.accepted.high


def test_gain_decays_by_a_power_where_the_paper_expects_a_time_constant():
    slow = quick("gain-vanishes").evidence["exponent of the own gain against k, n = 2"]
    assert slow.estimate == pytest.approx(-1, abs=0.01)


def test_the_share_that_the_first_look_explains_has_its_closed_form():
    shares = quick("initial-error-persists").tables["the same in other settings"]
    share = shares["P0 = V = W = 1 (theory: φ/2)", "share"]
    assert share.low < GOLDEN / 2 < share.high


def test_more_landmarks_never_remove_the_vehicles_own_error():
    stays = quick("many-landmarks-help").evidence[
        "share of the vehicle's initial error that stays, n = 50"
    ]
    assert stays.low < 1 < stays.high
