"""The chapter's studies: recorded rows against closed forms, and theory against runs."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from robot_perception.book import monobot as book
from robot_perception.book.monobot import GOLDEN
from robot_perception.evaluation import intervals
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.evaluation.intervals import Interval
from robot_perception.slam.monobot import settled
from robot_perception.teaching.claims import Finding

ONE, MAP, SUM = book.READINGS.values()


def near(measured: Interval, exact: float) -> bool:
    """Tell whether a number lies within one width of a measured interval."""
    width = measured.high - measured.low
    return measured.low - width <= exact <= measured.high + width


def changed(rows, **columns):
    """Return rows in which some columns are others."""
    return replace(rows, table=rows.table.assign(**columns))


# Information ----------------------------------------------------------------------------------


def test_information_slopes_are_the_closed_forms():
    finding = book.fisher_growth.find()
    for slope, form in finding.tables["slopes"].rows.values():
        assert slope == pytest.approx(form, rel=1e-9)
    known = finding.evidence["information on the state itself after 100 steps, n = 1"].estimate
    assert known == pytest.approx(GOLDEN, rel=1e-9)


def test_nothing_but_a_shift_is_dark():
    rows = book.blind.rows()
    assert set(rows.of("missing")) == {1}
    assert set(rows.of("row sum")) == set(rows.of("angle")) == {0.0}


def test_gain_decays_by_a_power_where_the_paper_expects_a_time_constant():
    assert book.slow(book.dying.rows()) == pytest.approx(-1, abs=0.01)


def test_a_landmark_that_wanders_is_listened_to_for_ever():
    """Closed form q / p, with the variance p of the distance before a measurement."""
    gain = book.dying.but(wander=0.5).rows().of("common", landmarks=1, noise="Fig. 3")
    q = 0.5**2
    p = (1 + q + np.sqrt((1 + q) ** 2 + 4 * (1 + q))) / 2  # p² = (1 + q) (p + 1)
    np.testing.assert_allclose(gain[50:], q / p, rtol=1e-9)


# The last error -------------------------------------------------------------------------------


def test_the_share_that_the_first_measurement_explains_is_the_one_that_is_measured():
    finding = book.first_look_stays.find()
    form = book.of_settings("share")["P0 = V = W = 1 m²"]
    assert form == pytest.approx(GOLDEN / 2, rel=1e-9)
    stated, *measured = finding.evidence.values()
    assert all(near(each, stated.estimate) for each in measured)
    assert finding.value == stated
    factors = finding.tables["factors that the paper leaves out"]
    ours = [factors[name, "ours"] for name in factors.rows]
    np.testing.assert_allclose(ours, stated.estimate, rtol=1e-12)


def test_the_error_that_persists_is_the_one_that_is_measured():
    finding = book.initial_error_persists.find()
    over_form = finding.evidence["variance at P0 = V = W = 1 over its limit φ"]
    assert over_form.estimate == pytest.approx(1, rel=1e-9)
    stated, measured = book.persistence(book.frozen.rows()).values()
    assert near(measured, stated.estimate)
    assert finding.value == stated


@pytest.mark.parametrize("claim", [book.initial_error_persists, book.first_look_stays])
def test_covariance_and_measured_errors_must_both_say_that_an_error_stays(claim):
    """A claim that holds by both is lost by either of them alone."""
    rows = book.frozen.rows()
    first, last = rows.of("first"), rows.of("last")

    def verdict(**columns):
        return claim.verdict(Finding(claim.value(changed(rows, **columns))))

    assert verdict() == "reproduced"
    assert verdict(first=1e-3 * first, last=1e-3 * last) == "not reproduced"
    other = verdict(last=last[::-1])  # as large, of other runs
    assert other == ("not reproduced" if claim is book.first_look_stays else "reproduced")
    assert verdict(**{"σ last": 1e-2 * rows.of("σ last")}) == "not reproduced"


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
    assert book.vouched(*both) == both[index]
    assert book.vouched(both[0], both[0], both[1]) == both[index]  # each of several must agree


@pytest.mark.parametrize("scale", [1e-3, 0.3])
def test_an_error_persists_in_metres_not_by_correlation(scale):
    """Smaller errors keep every correlation, but they are what convergence means."""
    rows, squared = book.frozen.rows(), "squared correlation, measured"
    small = changed(rows, first=scale * rows.of("first"), last=scale * rows.of("last"))
    ratio = book.explained(small)[squared].estimate / book.explained(rows)[squared].estimate
    assert ratio == pytest.approx(1, rel=1e-6)
    found, before = (book.persistence(each)["measured"] for each in (small, rows))
    assert found.estimate == pytest.approx(scale * before.estimate, rel=1e-6)
    expected = "not reproduced" if scale < 0.1 else "reproduced"
    assert book.initial_error_persists.verdict(Finding(found)) == expected


@pytest.mark.parametrize("setting", [book.AT_REST, book.SHARP, book.ANCHOR])
def test_what_is_computed_by_covariance_is_what_is_measured_where_the_claims_turn(setting):
    rows = book.repaired(setting)[setting].rows()
    for stated, *measured in (book.persistence(rows).values(), book.explained(rows).values()):
        assert all(near(each, stated.estimate) for each in measured)


def test_an_exact_start_and_first_measurement_leave_no_error_and_nothing_to_explain():
    rows = book.repaired(book.EXACT)[book.EXACT].rows()
    found = [*book.persistence(rows).values(), *book.explained(rows).values()]
    assert {value.estimate for value in found} == {0.0}


def test_the_share_falls_below_a_half_for_two_of_eight_changes():
    table = book.explained_by_factors()
    changes = {(row, col): table[row, col] for row in table.rows for col in ("half", "twice")}
    below = {place for place, share in changes.items() if share < 0.5}
    assert below == {("σ of the start", "half"), ("σ of a measurement", "twice")}


def test_settings_change_what_their_names_say():
    for name, field in book.FACTORS.items():
        for word, times in (("half", 0.5), ("twice", 2.0)):
            there = book.SETTINGS[f"{name}, {word}"]
            assert there == book.FIG4 | {field: times * book.FIG4[field]}


def test_averaging_of_measurements_is_that_of_their_inverse_variances():
    robot = book.monobot(**book.FIG4)
    sigma = 0.05 * np.abs(1 - robot.path[1:])
    assert book.independent(robot) == pytest.approx(1 / np.sqrt(np.sum(sigma**-2.0)))


# Many landmarks -------------------------------------------------------------------------------


def test_error_of_one_falls_to_the_floor_while_the_sum_grows():
    rows = book.helped.rows()
    counts, measured, stated, total = (
        rows.of(name) for name in ("landmarks", "measured", "stated", "all")
    )
    assert np.all(np.diff(stated) < 0)
    assert np.all(stated > 1)
    assert np.all((np.diff(total) > 0) & (np.diff(total) / np.diff(counts) < 1.03))
    low, high = np.sqrt(stats.chi2.ppf([1e-4, 1 - 1e-4], 400) / 400)
    # landmarks of one run share their error, so a run counts once, not n times
    assert np.all((low < measured / stated) & (measured / stated < high))


def test_the_ratio_of_variances_has_its_closed_form():
    finding = book.many_landmarks_help.find()
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
    assert ratios["1", "n = 50 over n = 1"] == pytest.approx(finding.value.estimate, rel=1e-12)


@pytest.mark.parametrize(
    "study", [book.fifty, book.fifty.but(runs=2000, shared=True)], ids=["own", "shared"]
)
def test_the_ratio_by_covariance_is_the_one_that_is_measured(study):
    rows = study.rows()
    measured = intervals.variance_ratio(rows.of("many"), rows.of("one"))
    assert near(measured, book.once(rows, "ratio"))


def test_more_landmarks_never_remove_the_vehicles_own_error():
    stays = book.many_landmarks_help.find().evidence[book.STAYS]
    assert stays.low < 1 < stays.high


def sums(count):
    """Return the sum of squares at n and at 2n by the closed form of the limit."""
    forms = {n: book.limit(n) for n in (count, 2 * count)}
    return [form.vehicle_variance + n * form.landmark_variance for n, form in forms.items()]


def test_the_sum_of_squares_grows_along_a_straight_line_that_misses_the_origin():
    """Closed form: (n + 1) P0 + W a/(a + W) (1 + 2/n) after infinitely many measurements."""
    evidence = book.statement_proportional.find().evidence
    adds = evidence["what each further landmark adds to it"]
    assert adds.low == pytest.approx(1, abs=0.02)
    assert adds.high == pytest.approx(1, abs=0.02)
    for n, what in ((1, "one landmark"), (50, "50 landmarks")):
        few, many = sums(n)
        found = evidence[f"what doubling {what} multiplies it by"].estimate
        assert found == pytest.approx(many / few, abs=0.02)
        assert found < 2


@pytest.mark.parametrize("count", [book.MANY, 40, 80])
def test_the_sum_of_squares_of_many_doubles_nearly_with_their_number(count):
    """By the closed form of the limit, which the claim does not use."""
    few, many = sums(count)
    assert np.log2(many / few) > book.PROPORTIONAL.low


def test_sum_of_squares_by_the_filter_is_the_one_that_is_measured():
    evidence = book.statement_proportional.find().evidence
    stated = evidence["sum of squares by the filter, n = 50"]
    assert near(evidence["the same, measured"], stated.estimate)


def test_whether_the_error_is_proportional_hangs_on_which_error_is_meant():
    finding = book.statement_proportional.find()
    table = finding.tables["readings"]
    said = [table[name, "proportional"] for name in table.rows]
    assert said == ["no", "no", f"for {book.MANY} and more"]
    of_one, of_map, of_all = (table[name, "exponent"] for name in (ONE, MAP, SUM))
    assert finding.value == of_all
    assert of_one.high < 0
    assert of_map.low < of_map.high < 0.5
    assert of_all.low < book.PROPORTIONAL.low < of_all.estimate < of_all.high < 1
    assert max(table[name, "start known"].estimate for name in table.rows) < 0.5
    starts = finding.tables["other starts"]
    found = [starts[start, "exponent"].estimate for start in starts.rows]
    assert found == sorted(found)


def test_it_is_conditional_whichever_error_is_called_the_one_that_is_meant():
    """Of three readings one holds and two fail; each may give the claim its value."""
    claim, finding = book.statement_proportional, book.statement_proportional.find()
    assert all(c.needed and c.holds for c in finding.conditions)
    table = finding.tables["readings"]
    for name in table.rows:
        value = table[name, "exponent"]
        assert claim.verdict(replace(finding, value=value)) == "conditional"
        assert claim.verdict(Finding(value)) == ("inconclusive" if name == SUM else "refuted")


# The filter broken on purpose ------------------------------------------------------------------


@pytest.fixture(scope="module")
def ways():
    rows = book.wrong.rows()
    return {way: rows.where(way=way) for way in book.WAYS}


def test_too_small_a_start_changes_no_estimate_and_is_dishonest(ways):
    right, small = ways["as the paper says"], ways["P0 a hundredth of the truth"]
    assert small.of("apart").max() == 0
    lost = right.of("states") ** 2 - small.of("states") ** 2
    np.testing.assert_allclose(lost, 0.99 * book.FIG4["start_deviation"] ** 2, rtol=1e-9)
    assert small.of("NEES")[-1] > average_bounds(1, 1000, 1 - 1e-6)[1]


def test_the_other_ways_change_the_estimates(ways):
    apart = [way for way, rows in ways.items() if rows.of("apart").max() > 1e-3]
    assert apart == list(book.WAYS)[2:]


def test_a_hundred_runs_find_the_bias_of_an_early_update_by_its_mean_and_not_by_its_spread(ways):
    def over_its_error(way, runs):
        rms, mean = (ways[way].of(name)[-1] for name in ("rms", "mean"))
        return abs(mean) / np.sqrt((rms**2 - mean**2) / runs)

    assert over_its_error("as the paper says", 1000) < 4
    assert over_its_error("update before predict", 1000) > 6
    assert over_its_error("update before predict", 100) > 3
    assert ways["update before predict"].of("NEES")[-1] < average_bounds(1, 100)[1]


def test_forgotten_cross_covariance_is_dishonest_and_an_anchor_repairs(ways):
    low, high = average_bounds(1, 1000, 1 - 1e-6)
    right, forgot, known = (ways[way] for way in (
        "as the paper says", "no cross-covariance", "one known landmark"
    ))  # fmt: skip
    assert low < right.of("NEES")[-1] < high
    assert low < known.of("NEES")[-1] < high
    assert forgot.of("NEES")[-1] > high
    assert forgot.of("apart")[0] == 0
    assert forgot.of("states")[0] == pytest.approx(right.of("states")[0])
    assert known.of("states")[-1] < 0.15 * right.of("states")[-1]
    assert np.all(np.diff(known.of("states")) < 0)
