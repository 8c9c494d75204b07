"""The claims of the chapter: as recorded, and what else their findings must show."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.chapters.monobot import many, rail, steady
from robot_perception.chapters.monobot.rail import FIG4, GOLDEN
from robot_perception.evaluation import intervals
from robot_perception.evaluation.intervals import Interval
from robot_perception.slam.monobot import settled
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change
from tests.chapters.ledger import LedgerTests, quick, recorded

COVARIANCE = "by the filter's covariance"


class TestLedger(LedgerTests):
    stem = "monobot"


def near(measured: Interval, exact: float) -> bool:
    """Tell whether a number lies within one width of a measured interval."""
    width = measured.high - measured.low
    return measured.low - width <= exact <= measured.high + width


def test_information_slopes_are_the_closed_forms():
    finding = quick("fisher-growth")
    for slope, form in finding.tables["slopes"].rows.values():
        assert slope == pytest.approx(form, rel=1e-9)
    known = finding.evidence["information on the state itself after 100 steps, n = 1"].estimate
    assert known == pytest.approx(GOLDEN, rel=1e-9)


def test_nothing_but_a_shift_is_dark():
    evidence = quick("fisher-singular").evidence
    assert {value.estimate for value in evidence.values()} == {0.0}


def test_gain_decays_by_a_power_where_the_paper_expects_a_time_constant():
    slow = quick("gain-vanishes").evidence["exponent of the own gain against k, n = 2"]
    assert slow.estimate == pytest.approx(-1, abs=0.01)


def test_the_share_that_the_first_measurement_explains_is_the_one_that_is_measured():
    finding = recorded()["first-look-stays"]
    elsewhere = finding.tables["the same in other settings"]
    form = elsewhere["P0 = V = W = 1 (theory: φ/2)", "share"]
    assert form == pytest.approx(GOLDEN / 2, rel=1e-9)
    stated, *measured = finding.evidence.values()
    assert all(near(each, stated.estimate) for each in measured)
    assert finding.value == stated
    factors = finding.tables["factors that the paper leaves out"]
    assert {factors[name, "ours"] for name in factors.rows} == {stated.estimate}


@pytest.mark.parametrize("changes", [{"start_deviation": 0.0}, {"landmarks": 5}, {"reach": 2.0}])
def test_a_share_by_covariance_is_the_squared_correlation_of_many_runs(changes):
    config = replace(FIG4, runs=4000, **changes)
    errors = rail.run(config, rng=np.random.default_rng(9)).landmark_errors.mean(axis=2)
    first, last = errors[:, 0], errors[:, -1]
    found = intervals.explained(first, last)
    assert found.low - 0.02 < steady.explained_share(config) < found.high + 0.02


def test_the_error_that_persists_is_the_one_that_is_measured():
    finding = recorded()["initial-error-persists"]
    over_form = finding.evidence["variance at P0 = V = W = 1 over its limit φ"]
    assert over_form.estimate == pytest.approx(1, rel=1e-9)
    stated, measured = (finding.evidence[name] for name in (COVARIANCE, "measured"))
    assert near(measured, stated.estimate)
    assert finding.value == stated


@pytest.mark.parametrize("claim", [steady.initial_error_persists, steady.first_look_stays])
def test_covariance_and_measured_errors_must_both_say_that_an_error_stays(claim, monkeypatch):
    """A claim that holds by both is lost by either of them alone."""
    sample = steady.fig4.result("quick")
    small = {name: 1e-3 * getattr(sample, name) for name in ("first", "near_last", "last")}
    assert claim.verdict(Finding(claim.compute(sample).value)) == "reproduced"
    assert claim.verdict(claim.compute(replace(sample, **small))) == "not reproduced"
    noisy = replace(sample, last=sample.last[::-1])  # as large, of other runs
    other = claim.verdict(Finding(claim.compute(noisy).value))
    assert other == ("not reproduced" if claim is steady.first_look_stays else "reproduced")
    for name in ("expected_persistence", "explained_share"):
        honest = getattr(steady, name)
        monkeypatch.setattr(steady, name, lambda config, honest=honest: 1e-2 * honest(config))
    assert claim.verdict(Finding(claim.compute(sample).value)) == "not reproduced"


@pytest.mark.parametrize(
    ("measured", "index"),
    [
        ((4.5, 4.4, 4.6), 0),  # within a tenth
        ((5.6, 5.4, 5.8), 0),
        ((4.4, 4.3, 4.49), 1),  # below that
        ((9.0, 8.0, 10.0), 0),  # above it: theory is the lesser
    ],
)
def test_where_theory_and_runs_differ_the_lesser_counts(measured, index):
    both = intervals.exact(5.0), Interval(*measured)
    assert steady.vouched(*both) == both[index]
    assert steady.vouched(both[0], both[0], both[1]) == both[index]  # each of several must agree


@pytest.mark.parametrize("scale", [1e-3, 0.3])
def test_an_error_persists_in_metres_not_by_correlation(scale):
    """Smaller errors keep every correlation, but they are what convergence means."""
    sample = steady.fig4.result("quick")
    small = replace(sample, first=scale * sample.first, last=scale * sample.last)
    assert small.explained.estimate == pytest.approx(sample.explained.estimate, rel=1e-6)
    found = steady.persistence(small)
    assert found.estimate == pytest.approx(scale * steady.persistence(sample).estimate, rel=1e-6)
    expected = "not reproduced" if scale < 0.1 else "reproduced"
    assert steady.initial_error_persists.verdict(Finding(found)) == expected


@pytest.mark.parametrize("change", steady.REPAIRED, ids=lambda change: change.text)
def test_what_is_computed_by_covariance_is_what_is_measured_where_the_claims_turn(change):
    sample = steady.fig4.result("quick", change)
    for exact, measured in (
        (steady.expected_persistence(sample.config), steady.persistence(sample)),
        (steady.explained_share(sample.config), sample.explained),
        (steady.explained_share(sample.config), steady.remaining_share(sample)),
    ):
        assert near(measured, exact)


def test_an_exact_start_and_first_measurement_leave_no_error_and_nothing_to_explain():
    exact = replace(FIG4, runs=50, start_deviation=0.0, first_measurement_factor=0.0)
    sample = steady.run(exact, rng=np.random.default_rng(4))
    assert steady.persistence(sample).estimate == steady.expected_persistence(exact) == 0.0
    assert sample.explained.estimate == steady.explained_share(exact) == 0.0
    assert steady.remaining_share(sample).estimate == 0.0
    start_only = replace(exact, start_deviation=0.1)
    assert steady.run(start_only, rng=np.random.default_rng(4)).explained.estimate == pytest.approx(
        1
    )


def test_the_ratio_of_variances_has_its_closed_form():
    finding = recorded()["many-landmarks-help"]
    ratios = finding.tables["other starts"]
    for start, (ratio,) in ratios.rows.items():
        forms = (
            settled(n, start_variance=float(start) ** 2, motion_variance=1, measurement_variance=1)
            for n in (50, 1)
        )
        many, one = (form.landmark_variance for form in forms)
        assert ratio == pytest.approx(many / one, abs=0.02)  # 100 measurements are not all of them
    found = [ratios[start, "n = 50 over n = 1"] for start in ratios.rows]
    assert found == sorted(found)
    measured = finding.evidence["the same, measured"]
    assert measured.low < finding.value.estimate < measured.high


@pytest.mark.parametrize("shared", [False, True])
def test_the_ratio_by_covariance_is_the_one_that_is_measured(shared):
    _, (one, fifty, _) = many.fifty.result("quick", Change("shared", shared=shared))
    measured = intervals.variance_ratio(fifty, one)
    assert near(measured, many.variance_ratio(1.0, shared))


def test_the_sum_of_squares_grows_along_a_straight_line_that_misses_the_origin():
    """Closed form: (n + 1) P0 + W a/(a + W) (1 + 2/n) after infinitely many measurements."""
    finding = quick("statement-proportional")
    adds = finding.evidence["what each further landmark adds to it"]
    assert adds.low == pytest.approx(1, abs=0.02)
    assert adds.high == pytest.approx(1, abs=0.02)
    for n, name in (
        (1, "what doubling one landmark multiplies it by"),
        (50, "what doubling 50 landmarks multiplies it by"),
    ):
        few, many = (rail.limit(k) for k in (n, 2 * n))
        sums = [
            form.vehicle_variance + k * form.landmark_variance
            for k, form in ((n, few), (2 * n, many))
        ]
        assert finding.evidence[name].estimate == pytest.approx(sums[1] / sums[0], abs=0.02)
        assert finding.evidence[name].estimate < 2


def test_whether_the_error_is_proportional_hangs_on_which_error_is_meant():
    finding = quick("statement-proportional")
    readings = finding.tables["readings"]
    said = [readings[name, "proportional"] for name in readings.rows]
    assert said == ["no", "no", f"for {many.MANY} and more"]
    of_one, of_map, of_all = (readings[name, "exponent"] for name in readings.rows)
    assert finding.value == of_all
    assert of_one.high < 0
    assert of_map.low < of_map.high < 0.5
    assert of_all.low < many.PROPORTIONAL.low < of_all.estimate < of_all.high < 1
    assert max(readings[name, "start known"].high for name in readings.rows) < 0.5
    starts = finding.tables["other starts"]
    found = [starts[start, "exponent"].estimate for start in starts.rows]
    assert found == sorted(found)


def test_it_is_conditional_whichever_error_is_called_the_one_that_is_meant():
    """Of three readings one holds and two fail; each may give the claim its value."""
    finding, claim = quick("statement-proportional"), many.statement_proportional
    assert all(c.needed and c.holds for c in finding.conditions)
    readings = finding.tables["readings"]
    for name in readings.rows:
        value = readings[name, "exponent"]
        assert claim.verdict(replace(finding, value=value)) == "conditional"
        alone = claim.verdict(Finding(value))
        assert alone == ("inconclusive" if name == many.SUM else "refuted")


@pytest.mark.parametrize("count", [many.MANY, 40, 80])
def test_the_sum_of_squares_of_many_doubles_nearly_with_their_number(count):
    """By the closed form of the limit, which the claim does not use."""
    few, more = (rail.limit(n) for n in (count, 2 * count))
    sums = [
        form.vehicle_variance + n * form.landmark_variance
        for n, form in ((count, few), (2 * count, more))
    ]
    assert np.log2(sums[1] / sums[0]) > many.PROPORTIONAL.low


def test_more_landmarks_never_remove_the_vehicles_own_error():
    name = "share of the vehicle's initial error that stays, n = 50"
    stays = recorded()["many-landmarks-help"].evidence[name]
    assert stays.low < 1 < stays.high
