"""The chapter's studies: recorded rows against closed forms, and theory against runs."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from robot_perception.beliefs import Gaussian
from robot_perception.book import monobot as book
from robot_perception.book.monobot import GOLDEN
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.kalman import Sensor, predict
from robot_perception.slam.monobot import motion, settled
from studies import intervals
from studies.claims import Finding
from studies.intervals import Interval

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
    known = book.fisher_growth.study.rows().of("as it is", landmarks=1)[-1]
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
    stated, *measured = book.explained(book.frozen.rows()).values()
    assert all(near(each, stated.estimate) for each in measured)
    assert finding.value == stated
    factors = finding.tables["factors that the paper leaves out"]
    ours = [factors[name, "ours"] for name in factors.rows]
    np.testing.assert_allclose(ours, stated.estimate, rtol=1e-12)


def test_the_error_that_persists_is_the_one_that_is_measured():
    finding = book.initial_error_persists.find()
    assert book.of_settings("σ")["P0 = V = W = 1 m²"] ** 2 == pytest.approx(GOLDEN, rel=1e-9)
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
    rows = book.fifty.rows()
    stays = intervals.slope(rows.of("start"), rows.of("many"))
    assert stays.low < 1 < stays.high


def sums(count):
    """Return the sum of squares at n and at 2n by the closed form of the limit."""
    forms = {n: book.limit(n) for n in (count, 2 * count)}
    return [form.vehicle_variance + n * form.landmark_variance for n, form in forms.items()]


def test_the_sum_of_squares_grows_along_a_straight_line_that_misses_the_origin():
    """Closed form: (n + 1) P0 + W a/(a + W) (1 + 2/n) after infinitely many measurements."""
    evidence = book.sums_of_squares(book.grown.rows().where(start=1.0))
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
    evidence = book.sums_of_squares(book.grown.rows().where(start=1.0))
    stated = evidence["sum of squares by the filter, n = 50"]
    assert near(evidence["the same, measured"], stated.estimate)


def test_which_error_is_proportional():
    """By exponents between two numbers of landmarks from the closed form of the limit."""
    n = np.array(book.DOUBLED[3:])
    forms = [book.limit(int(each)) for each in n]
    one = np.array([form.landmark_variance for form in forms])
    everything = n * one + [form.vehicle_variance for form in forms]
    for claim, values in (
        (book.statement_proportional, everything),
        (book.proportional_map, np.sqrt(n * one)),
        (book.proportional_landmark, one),
    ):
        value = claim.find().value
        steps = np.diff(np.log(values)) / np.log(2)
        assert (value.low, value.high) == pytest.approx((steps.min(), steps.max()), abs=0.01)


def test_few_landmarks_and_a_known_start_stand_outside():
    conditions = book.statement_proportional.find().conditions
    assert [(c.needed, c.holds) for c in conditions] == [(True, True)] * 2
    starts = book.statement_proportional.find().tables["other starts"]
    found = [starts[start, "exponent"].estimate for start in starts.rows]
    assert found == sorted(found)


def test_the_page_sets_three_readings_beside_each_other():
    rows = book.grown.rows()
    table = book.readings(rows.where(start=1.0), rows.where(start=0.0))
    assert [table[name, "proportional"] for name in (ONE, MAP, SUM)] == ["no", "no", "yes"]
    assert max(table[name, "start known"].estimate for name in table.rows) < 0.5
    wide = intervals.Interval(1.0, 0.8, 1.2)
    assert book.is_proportional(wide) == "undecided"


def test_an_exponent_is_fitted_from_end_to_end():
    rows = book.grown.rows().where(start=1.0)
    n = rows.of("landmarks").astype(float)
    fitted = book.power(changed(rows, all=n**3), "all", least=10, most=100)
    assert fitted.estimate == pytest.approx(3)
    assert "n = 10 to 100;" in fitted.about
    assert book.power(changed(rows, all=n**3), "all", times=2).estimate == pytest.approx(6)


def test_a_map_made_on_the_way_is_that_of_a_filter():
    """Each landmark is put into the map by its only measurement, after one more move."""
    n, start = 4, 0.7
    P = np.array([[start**2]])
    for k in range(n):
        P[0, 0] += 1.0
        enters = np.vstack([np.eye(k + 1), np.eye(k + 1)[:1]])  # the new one where the robot is
        P = enters @ P @ enters.T
        P[-1, -1] += 1.0
    np.testing.assert_allclose(book.explored(n, start), P)


# What the paper says in passing, and what it repeats ---------------------------------------------


def test_eq_9_is_wrong_by_the_noise_that_it_leaves_out():
    """Closed form in one dimension: p = 1, h = 1, K = 1 / (1 + hw² w)."""
    for hw, w in ((1.0, 0.5), (2.0, 0.5), (0.1, 3.0)):
        K = 1 / (1 + hw**2 * w)
        printed, right = (1 - K) ** 2 + K**2 * w, hw**2 * w / (1 + hw**2 * w)
        assert (printed == pytest.approx(right)) == (hw == 1)
    printed = [book.joseph.trial(sample=k) for k in range(20)]
    plain = [book.joseph.but(scaled=False).trial(sample=k) for k in range(20)]
    assert min(one["off"] for one in printed) > 1e-6
    assert max(one["off"] for one in plain) < 1e-12
    assert any(one["too certain"] for one in printed)
    assert not any(one["too certain"] for one in plain)
    assert min(one["least"] for one in (*printed, *plain)) > 0
    assert min(book.joseph.but(short=True).trial(sample=k)["least"] for k in range(20)) < 0


@pytest.mark.parametrize("n", [1, 3])
def test_what_eq_9_states_in_fig_4_is_not_what_is_and_neither_is_the_best(n):
    """Against the mean square error of a filter that is run with the printed gains."""
    found = book.misprinted.trial(landmarks=n)
    assert found["best"] < found["is"]
    assert found["said"] < found["is"]
    robot, share = book.monobot(n, **book.FIG4), book.FIG4["measurement_share"]

    def as_printed(belief, move, z, sensor):
        moved, H = predict(belief, move), sensor.matrix
        K = moved.cov @ H.T @ np.linalg.inv(H @ moved.cov @ H.T + sensor.noise)
        rest = np.eye(n + 1) - K @ H
        mean = moved.mean + (z - moved.mean @ H.T) @ K.T
        cov = rest @ moved.cov @ rest.T + share**2 * K @ K.T
        return Gaussian(mean, cov), SimpleNamespace(innovation_cov=sensor.noise, gain=K)

    _, z = book.drive(robot, 4000, np.random.default_rng(5))
    run = book.filtered(robot, z, step=as_printed)
    assert run.deviations[-1, 1] == pytest.approx(found["said"], rel=1e-9)
    low, high = stats.chi2.ppf([1e-4, 1 - 1e-4], 4000) / 4000
    errors = run.means[:, -1, 1] - book.LANDMARK
    assert low < np.mean(errors**2) / found["is"] ** 2 < high


def test_a_zero_gain_goes_with_a_variance_above_the_start():
    one = book.believed.trial(landmarks=1, noise="Fig. 3")
    assert one["gain"] < 1e-9
    assert 2 * one["left"] ** 2 == pytest.approx(GOLDEN, rel=1e-9)  # P0 + W at first
    cured = book.believed.but(cured=True).trial(landmarks=1, noise="Fig. 3")
    assert cured["left"] == pytest.approx(101**-0.5)


@pytest.mark.parametrize("plant", [0.01, 0.5, 2.0, 10.0])
def test_an_update_revises_by_the_recursion_of_the_two_parts(plant):
    """Both parts shrink by W / s; a move adds V to the robot's."""
    found = book.revised.trial(landmarks=1, plant=plant)["robot over landmark"]
    x, y = plant, 1.0
    for quotient in found[:12]:
        assert quotient == pytest.approx(min(x / y, book.MUCH), rel=1e-6)
        s = x + y + 1
        x, y = x / s + plant, y / s


@pytest.mark.parametrize("plant", [0.5, 2 / 3, 2.0])
def test_the_first_of_many_landmarks_is_revised_by_the_closed_form(plant):
    n = 50
    found = book.revised.trial(landmarks=n, plant=plant)["robot over landmark"][0]
    assert found**2 == pytest.approx(2 * n * plant**2 / (2 + (n - 1) * plant))


@pytest.mark.parametrize("ratio", [0.01, 0.1])
def test_the_robot_takes_over_after_the_root_of_twice_the_ratio(ratio):
    found = book.worse_sensor.rows().of("robot over landmark", landmarks=1, plant=ratio)
    first = 1 + int(np.argmax(found > 1))
    assert abs(first - np.sqrt(2 / ratio)) < 1.5


@pytest.mark.parametrize("n", [2, 4])
def test_the_end_of_a_run_is_its_last_update_the_other_way_round(n):
    whole = book.revised.trial(landmarks=n, plant=0.01)["robot over landmark"]
    end = book.ended.but(updates=len(whole)).trial(landmarks=n, plant=0.01)["landmark over robot"]
    assert end * whole[-1] == pytest.approx(1, rel=1e-6)


def test_the_table_of_revisions_says_at_which_update():
    table = book.by_update()
    assert table["0.5", "update 1"] == pytest.approx(0.5)
    assert table["0.5", "update 2"] == pytest.approx(1.75)
    assert table["10", "update 2"] == pytest.approx(130)


@pytest.mark.parametrize("noise", book.NOISES)
@pytest.mark.parametrize("n", [2, 5])
def test_two_landmarks_are_as_far_apart_as_independent_measurements_leave_them(n, noise):
    found = book.agreed.trial(landmarks=n, noise=noise)
    np.testing.assert_allclose(found["over a mean"], 1, rtol=1e-9)
    W = book.monobot(n, **book.NOISES[noise]).W[:, 0]
    np.testing.assert_allclose(found["difference"], 2 / np.cumsum(1 / W), rtol=1e-9)
    assert found["correlation"][0] == pytest.approx(0.5)
    assert np.all(np.diff(found["correlation"]) > 0)
    common = book.limit(n).landmark_variance
    if noise == "Fig. 3":  # what two do not share is half of their difference
        short = 1 / 101 / (common + (1 - 1 / n) / 101)
        assert 1 - found["correlation"][-1] == pytest.approx(short, rel=1e-6)


def test_an_anchor_keeps_the_correlation_at_a_half():
    found = book.agreed.but(anchor=True).trial(landmarks=3, noise="Fig. 4")
    np.testing.assert_allclose(found["correlation"], 0.5)


def test_growth_is_the_least_fall_of_what_is_missing():
    rows = book.agreed.rows()
    rho = np.tile(1 - 0.9 ** np.arange(101.0), len(rows) // 101)
    assert book.growth(changed(rows, correlation=rho)).estimate == pytest.approx(0.1)
    rho[7] = rho[6]
    assert book.growth(changed(rows, correlation=rho)).estimate == pytest.approx(0)


@pytest.mark.parametrize("start", [0.5, 2.0])
@pytest.mark.parametrize("plant", [0.0, 0.5, 2.0])
def test_a_landmark_ends_where_the_closed_form_says(start, plant):
    found = book.reached.trial(landmarks=1, start=start, plant=plant, sensing=0.5)
    form = start**2 + 0.25 / (book.STEPS + 1)
    if plant:
        noises = {"motion_variance": plant**2, "measurement_variance": 0.25}
        form = settled(1, start_variance=start**2, **noises).landmark_variance
    assert found["variance"] == pytest.approx(form, rel=1e-6)
    assert found["over start"] == pytest.approx(form / start**2, rel=1e-6)


def test_a_difference_does_not_know_the_plant_noise_and_an_anchor_undercuts_the_start():
    where = {"start": 1.0, "plant": 2.0, "sensing": 1.0}
    apart = book.reached.but(differences=True).trial(landmarks=3, **where)["variance"]
    assert apart == pytest.approx(2 / (book.STEPS + 1))
    anchored = book.reached.but(anchor=True).trial(landmarks=3, **where)
    assert anchored["over start"] < 0.1


@pytest.mark.parametrize("n", [1, 2, 10])
def test_the_common_error_shrinks_by_the_closed_form_and_differences_by_none(n):
    form = settled(n, start_variance=1, motion_variance=4, measurement_variance=1).pole
    common = book.paced.but(common=True).trial(landmarks=n, plant=2.0)["pole"]
    assert common == pytest.approx(form, rel=1e-6)
    slowest = book.paced.trial(landmarks=n, plant=2.0)["pole"]
    assert slowest == pytest.approx(form if n == 1 else 1.0, rel=1e-6)


def test_largest_over_least_is_taken_for_each_number_of_landmarks():
    rows = book.paced.rows()
    np.testing.assert_allclose(book.by_plant(rows, "pole")[1:], 1, rtol=1e-6)
    poles = rows.of("pole", landmarks=1)
    assert book.by_plant(rows, "pole")[0] == pytest.approx(poles.max() / poles.min())


def test_the_bound_is_the_least_of_each_start():
    rows = book.reached.rows()
    least = rows.table.groupby("start")["over start"].min()
    found = book.bound(rows)
    assert (found.low, found.high) == pytest.approx((least.min(), least.max()))


def test_a_landmark_is_where_the_whole_run_says():
    """Three measurements, against the sum over all positions of the robot by the least squares."""
    robot = book.monobot(steps=2, start_deviation=1.0)
    robot.u[:], robot.V[:], z = (0.3, -0.1), (0.5, 2.0), np.array([[2.0], [1.5], [1.9]])
    best, sigma = book.by_least_squares(robot, z)
    rows = [[0, 0, 1], [-1, 0, 1], [0, -1, 1], [1, 0, 0], [-1, 1, 0]]  # of both places, landmark
    weights, seen = [1, 1, 1, 1 / 0.5, 1 / 2.0], [2.0, 1.5, 1.9, 0.3, -0.1]
    A, W = np.array(rows, dtype=float), np.diag(weights)
    cov = np.linalg.inv(A.T @ W @ A)
    assert best == pytest.approx((cov @ A.T @ W @ seen)[2])
    assert sigma == pytest.approx(cov[2, 2] ** 0.5)


@pytest.mark.parametrize("noise", book.NOISES)
def test_the_least_sum_is_where_the_whole_run_says(noise):
    assert book.nearest.trial(sample=3, noise=noise)["apart"] < 1e-6


def test_the_least_sum_of_wrong_distances_is_elsewhere():
    assert book.nearest.but(alike=True).trial(sample=3, noise="Fig. 4")["apart"] > 1e-3


def test_neither_data_nor_the_start_change_the_information():
    found = book.by_data.trial(sample=3)
    assert found["by drive"] == found["by start"] == 0
    squared = book.by_data.but(squared=True).trial(sample=3)
    assert min(squared.values()) > 1e-3


def test_a_sensor_of_squares_is_linearised_where_the_filter_is():
    """By the derivative of the squared distance, in differences."""
    robot, jacobians = book.monobot(2, 1), []
    belief = Gaussian(np.array([[0.1, 1.2, 2.5]]), np.eye(3) * 0.1)
    sensor = Sensor(robot.H, np.eye(2))
    at_rest = motion(0.4, 0.0, 2)
    seen = np.array([0.7, 2.0])  # distances from where it stands then
    found, _ = book.squares(jacobians)(belief, at_rest, seen[None], sensor)
    x = np.array([0.5, 1.2, 2.5])

    def squared(state):
        return (state[1:] - state[0]) ** 2

    steps = 1e-6 * np.eye(3)
    slope = [(squared(x + step) - squared(x - step)) / 2e-6 for step in steps]
    np.testing.assert_allclose(jacobians[0], np.transpose(slope), atol=1e-6)
    np.testing.assert_allclose(found.mean[0], x, atol=1e-12)


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
