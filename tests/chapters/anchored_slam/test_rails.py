"""Figs 5 and 6: worlds against filters, closed forms, and the pictures."""

from dataclasses import replace

import numpy as np
import pytest
import sympy
from scipy import stats

from robot_perception.chapters.anchored_slam import figures as draw
from robot_perception.chapters.anchored_slam import rails
from robot_perception.chapters.anchored_slam.rails import FIG5, FIG6
from robot_perception.chapters.monobot import rail
from robot_perception.chapters.monobot.rail import FIG3, FIG4, ORIGIN, ends
from robot_perception.evaluation.consistency import average_bounds, normalised_squared
from robot_perception.teaching.figures import figure

RNG = np.random.default_rng
RUNS = 400


def study(config, seed=0, **changes):
    return rails.run(replace(config, **({"runs": RUNS} | changes)), rng=RNG(seed))


@pytest.mark.parametrize("config", [FIG5, FIG6], ids=["fig5", "fig6"])
@pytest.mark.parametrize("landmarks", [1, 3])
def test_errors_and_innovations_are_as_large_as_the_filter_says(config, landmarks):
    result = study(config, landmarks=landmarks)
    errors = np.concatenate([result.vehicle_errors[..., None], result.landmark_errors], axis=-1)
    low, high = average_bounds(landmarks + 1, RUNS, 1 - 1e-4)
    for step in (0, 1, 7, 25, 100):
        nees = normalised_squared(errors[:, step], result.filtered.covs[0, step])
        assert low < nees.mean() < high, f"step {step}"
    nis = normalised_squared(result.filtered.innovations, result.filtered.innovation_covs[0])
    low, high = average_bounds(landmarks + 1, nis.size, 1 - 1e-4)
    assert low < nis.mean() < high


def test_figures_share_their_worlds_and_their_first_measurement():
    four, five, six = rails.figures(rng=RNG(3)).values()
    alone = rail.refilter(FIG4, rail.simulate(FIG4, rng=RNG(3)))
    np.testing.assert_array_equal(four.filtered.means, alone.means)
    np.testing.assert_array_equal(five.first_errors, four.first_errors)
    np.testing.assert_array_equal(six.world.positions, four.world.positions)
    assert five.gains.shape == four.gains.shape


def test_gain_drawn_is_that_of_the_landmarks_own_innovation():
    result = rails.figures(rng=RNG(3))["Fig. 5: anchor"]
    np.testing.assert_array_equal(result.gains[:, 1], result.filtered.gains[0, :, 1, 1])
    assert np.all(result.gains[:, 1] > 0)


def test_configurations_hold_what_the_captions_print():
    assert ORIGIN == 0.0
    distance = np.abs(FIG4.plan[1:])
    np.testing.assert_allclose(FIG5.reference_deviations, 0.01 + FIG4.measurement_share * distance)
    np.testing.assert_allclose(FIG6.reference_deviations, 0.1)
    plain = {"reference": "none", "reference_deviation": None, "reference_share": 0.0}
    assert replace(FIG5, **plain) == replace(FIG6, **plain) == FIG4


@pytest.mark.parametrize("config", [FIG4, FIG5, FIG6], ids=["fig4", "fig5", "fig6"])
def test_share_left_is_how_much_of_the_first_error_is_still_there(config):
    """Slope and squared correlation, measured, against the covariances."""
    result = study(config, runs=4000, seed=5)
    first, last = result.first_errors[:, 0], result.last_errors[:, 0]
    share = rails.remaining_shares(config)[-1]
    fit = stats.linregress(first, last)
    assert abs(fit.slope - share) < 4 * fit.stderr
    z = abs(np.arctanh(fit.rvalue) - np.arctanh(np.sqrt(share))) * np.sqrt(3997)
    assert z < 4


def test_share_left_sees_an_error_that_is_large_and_one_that_the_first_measurement_fixes():
    result = study(FIG5, runs=4000, seed=5)
    allowed, found = rails.anchor_unbiased.accepted, ends(result)
    value = rails.share_left(found)
    assert allowed.contains(value)
    assert value.low / 1.1 <= rails.remaining_shares(FIG5)[-1] <= value.high
    for spoilt in (0.15 * found.first, RNG(1).normal(size=4000)):
        assert allowed.excludes(rails.share_left(replace(found, last=spoilt)))


def test_anchored_map_is_the_relative_map():
    anchored, relative = rails.anchored_and_relative(20, rng=RNG(4))
    np.testing.assert_allclose(anchored, relative, atol=1e-12)
    assert np.abs(np.diff(anchored, axis=1)).max() > 0.01  # the estimates do move


@pytest.mark.parametrize("reference", ["anchor", "external sensor"])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_information_in_symbols(n, reference):
    """Determinant by Cauchy–Binet, and positive definite wherever S is, by Sylvester's minors."""
    J, weights = rails.symbolic_information(n, reference)
    assert sympy.expand(J.det(method="berkowitz") - weights.det(method="berkowitz")) == 0
    rng = RNG(n)
    A = rng.normal(size=(n + 1, n + 1))
    S = A @ A.T + np.eye(n + 1)
    inverse = np.linalg.inv(S)
    values = {weights[i, j]: inverse[i, j] for i in range(n + 1) for j in range(n + 1)}
    number = np.array(J.subs(values), dtype=float)
    H = np.vstack([np.eye(n + 1)[0] * (-1 if reference == "anchor" else 1), 0 * A[1:]])
    H[1:, 0], H[1:, 1:] = -1, np.eye(n)
    np.testing.assert_allclose(number, H.T @ inverse @ H, atol=1e-12)
    assert np.linalg.eigvalsh(number)[0] > 0


def test_information_without_a_reference_is_singular_in_symbols():
    J, _ = rails.symbolic_information(2, "none")
    assert J.applyfunc(sympy.expand) * sympy.ones(3, 1) == sympy.zeros(3, 1)


def test_information_on_the_start_is_what_least_squares_says():
    """Oracle: invert the joint information of the whole run, without any prior on the start."""
    steps = 6
    config = replace(FIG3, steps=steps, reference="anchor", reference_deviation=0.7)
    eye = np.eye(steps + 2)  # positions 0 … steps, landmark
    total = np.zeros_like(eye)
    for k in range(steps):
        total += np.outer(eye[k + 1] - eye[k], eye[k + 1] - eye[k])
        total += np.outer(eye[k + 1], eye[k + 1]) / 0.49
        total += np.outer(eye[-1] - eye[k + 1], eye[-1] - eye[k + 1])
    kept = np.ix_([0, steps + 1], [0, steps + 1])
    marginal = np.linalg.inv(np.linalg.inv(total)[kept])
    np.testing.assert_allclose(rails.information_on_start(config)[-1], marginal, rtol=1e-9)


def test_a_misplaced_anchor_moves_the_map_and_the_innovations_fall_silent():
    result = study(replace(FIG5, misplaced=0.1))
    last = result.last_errors[:, 0]
    assert abs(last.mean() - 0.1) < 4 * stats.sem(last) + 0.001
    late = result.filtered.innovations[:, 50:]
    nis = normalised_squared(late, result.filtered.innovation_covs[0, 50:])
    low, high = average_bounds(2, nis.size, 1 - 1e-4)
    assert low < nis.mean() < high


# Pictures


def test_side_by_side_draws_the_same_scales_and_stays_finite():
    _, axes = figure(4, 3, width=7.2, height=7.2)
    results = rails.figures(rng=RNG(1))
    draw.side_by_side.on(axes, results, 0)
    for row in axes:
        assert len({ax.get_ylim() for ax in row}) == 1
        for ax in row:
            for line in ax.lines:
                assert np.isfinite(np.asarray(line.get_ydata(), dtype=float)).all()
    (error,) = (line.get_ydata() for line in axes[2, 1].lines if len(line.get_ydata()) == 101)
    anchored = results["Fig. 5: anchor"]
    np.testing.assert_allclose(error, anchored.filtered.means[0, :, 1] - 1.0)
