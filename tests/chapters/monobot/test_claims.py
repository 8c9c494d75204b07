"""The claims of the chapter: as recorded, and what else their findings must show."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.chapters.monobot import rail, steady
from robot_perception.chapters.monobot.rail import FIG4, GOLDEN
from robot_perception.slam.monobot import settled
from robot_perception.teaching.claims import Finding
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


def test_gain_decays_by_a_power_where_the_paper_expects_a_time_constant():
    slow = quick("gain-vanishes").evidence["exponent of the own gain against k, n = 2"]
    assert slow.estimate == pytest.approx(-1, abs=0.01)


def test_the_share_that_the_first_look_explains_has_its_closed_form():
    finding = quick("first-look-stays")
    share = finding.tables["the same in other settings"]["P0 = V = W = 1 (theory: φ/2)", "share"]
    assert share.low < GOLDEN / 2 < share.high
    exact = finding.evidence["share by the filter's covariance"].estimate
    assert finding.value.low < exact < finding.value.high
    factors = finding.tables["factors that the paper leaves out"]
    assert {factors[name, "ours"] for name in factors.rows} == {exact}


def test_the_error_that_persists_has_its_closed_form():
    over_form = quick("initial-error-persists").evidence[
        "variance at P0 = V = W = 1 over its limit φ"
    ]
    assert over_form.low < 1 < over_form.high


@pytest.mark.parametrize("scale", [1e-3, 0.3])
def test_an_error_persists_in_metres_not_by_correlation(scale):
    """Smaller errors keep every correlation, but they are what convergence means."""
    result = rail.run(replace(FIG4, runs=500), rng=np.random.default_rng(4))
    shrunk = 1.0 + scale * result.landmark_errors
    means = np.concatenate([result.filtered.means[..., :1], shrunk], axis=-1)
    small = replace(result, filtered=replace(result.filtered, means=means))
    assert small.explained.estimate == pytest.approx(result.explained.estimate, rel=1e-6)
    found = steady.persistence(small).estimate
    assert found == pytest.approx(scale * steady.persistence(result).estimate, rel=1e-6)
    expected = "not reproduced" if scale < 0.1 else "reproduced"
    assert steady.initial_error_persists.verdict(Finding(steady.persistence(small))) == expected


def test_an_exact_start_and_first_look_leave_no_error_and_nothing_to_explain():
    exact = replace(FIG4, runs=50, start_deviation=0.0, first_look_factor=0.0)
    result = rail.run(exact, rng=np.random.default_rng(4))
    assert steady.persistence(result).estimate == 0.0
    assert result.explained.estimate == 0.0
    start_only = replace(exact, start_deviation=0.1)
    assert rail.run(start_only, rng=np.random.default_rng(4)).explained.estimate == pytest.approx(1)


def test_both_claims_about_many_landmarks_name_the_start_beside_which_they_hold():
    ratios = quick("many-landmarks-help").tables["other starts"]
    for start, (ratio,) in ratios.rows.items():
        forms = (
            settled(n, start_variance=float(start) ** 2, motion_variance=1, look_variance=1)
            for n in (50, 1)
        )
        many, one = (form.landmark_variance for form in forms)
        assert ratio == pytest.approx(many / one, abs=0.02)  # 100 looks are not all of them
    powers = quick("statement-proportional").tables["other starts"]
    found = [powers[start, "exponent"].estimate for start in powers.rows]
    assert found == sorted(found)
    assert found[0] < 0.5 < 0.9 < found[-1]
    for name in ("many-landmarks-help", "statement-proportional"):
        needed = [c.text for c in quick(name).conditions if c.needed]
        assert any("start" in text and "beside looks of 1 m" in text for text in needed)


def test_more_landmarks_never_remove_the_vehicles_own_error():
    stays = quick("many-landmarks-help").evidence[
        "share of the vehicle's initial error that stays, n = 50"
    ]
    assert stays.low < 1 < stays.high
