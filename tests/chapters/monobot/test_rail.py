"""The monobot chapter: worlds against filter, claims, broken variants, the corridor, exercises."""

import gzip
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy import stats

from robot_perception import datasets
from robot_perception.beliefs import Gaussian
from robot_perception.chapters import monobot
from robot_perception.chapters.monobot import CLAIMS, EXERCISES, FIG3, FIG4, GOLDEN
from robot_perception.chapters.monobot import figures as draw
from robot_perception.evaluation.consistency import average_bounds, normalised_squared
from robot_perception.kalman import scale_free_rank
from robot_perception.slam.monobot import run_filter, settled
from robot_perception.teaching.figures import figure

RUNS = 400
RNG = np.random.default_rng


def study(base, seed=0, **changes):
    return monobot.run(replace(base, **({"runs": RUNS} | changes)), rng=RNG(seed))


# The world is written without the filter's equations: these tests compare the two.


@pytest.mark.parametrize("base", [FIG3, FIG4], ids=["fig3", "fig4"])
@pytest.mark.parametrize("landmarks", [1, 3])
def test_errors_are_as_large_as_the_filter_says(base, landmarks):
    result = study(base, landmarks=landmarks)
    errors = np.concatenate([result.vehicle_errors[..., None], result.landmark_errors], axis=-1)
    low, high = average_bounds(landmarks + 1, RUNS, 1 - 1e-4)
    for look in (0, 1, 7, 100):
        # whitened by the square root, as the covariance of many looks is close to singular
        nees = normalised_squared(errors[:, look], result.filtered.covs[0, look])
        assert low < nees.mean() < high, f"look {look}"


@pytest.mark.parametrize("base", [FIG3, FIG4], ids=["fig3", "fig4"])
def test_innovations_are_white_and_of_the_stated_size(base):
    result = study(base, landmarks=2)
    S = result.filtered.innovation_covs[0]
    nis = normalised_squared(result.filtered.innovations, S)
    low, high = average_bounds(2, RUNS * base.steps, 1 - 1e-4)
    assert low < nis.mean() < high
    white = np.stack(
        [
            z @ np.linalg.inv(np.linalg.cholesky(s)).T
            for z, s in zip(result.filtered.innovations.transpose(1, 0, 2), S, strict=True)
        ]
    )
    for lag in (1, 2, 5):
        correlation = np.mean(white[lag:] * white[:-lag])
        assert abs(correlation) < 4 / np.sqrt(white[lag:].size)


@pytest.mark.parametrize("landmarks", [1, 20])
def test_limit_of_the_error_has_the_closed_form_variance(landmarks):
    result = study(FIG3, landmarks=landmarks, steps=60, runs=2000)
    form = settled(landmarks, start_variance=1, motion_variance=1, look_variance=1)
    common = result.last_errors.mean(axis=1)
    low, high = stats.chi2.ppf([1e-4, 1 - 1e-4], 2000) / 2000
    assert low < np.mean(common**2) / form.landmark_variance < high


def test_share_explained_by_the_first_look_is_the_ratio_of_variances():
    """Estimates later in time differ from the first by what is orthogonal to the last error."""
    share = study(FIG3, steps=40, runs=4000).explained
    assert share.low < GOLDEN / 2 < share.high


def test_same_seed_same_result_and_a_run_does_not_depend_on_its_number():
    few, again, many = (study(FIG4, seed=3, runs=n) for n in (4, 4, 60))
    np.testing.assert_array_equal(few.filtered.means, again.filtered.means)
    np.testing.assert_allclose(few.filtered.means, many.filtered.means[:4], atol=1e-12)
    assert not np.allclose(study(FIG4, seed=4, runs=4).last_errors, few.last_errors)


def test_configurations_hold_what_the_captions_print():
    assert (FIG3.start_deviation, FIG3.motion_deviation, FIG3.look_deviation) == (1.0, 1.0, 1.0)
    np.testing.assert_array_equal(FIG3.motion_deviations, np.ones(100))
    assert (FIG4.start, FIG4.landmarks_at, FIG4.steps) == (-1.0, 1.0, 100)
    assert FIG4.plan[0] == -1.0
    assert FIG4.plan[-1] == pytest.approx(-1.0)
    commands, distances = np.diff(FIG4.plan), 1.0 - FIG4.plan
    np.testing.assert_allclose(FIG4.motion_deviations / np.abs(commands), FIG4.motion_share)
    np.testing.assert_allclose(FIG4.look_deviations[:, 0] / distances, FIG4.look_share)


# Claims


VERDICTS = {
    "fisher-growth": "reproduced",
    "fisher-singular": "reproduced",
    "fisher-one-landmark": "reproduced",
    "gain-vanishes": "conditional",
    "initial-error-persists": "conditional",
    "monte-carlo-unbiased": "reproduced",
    "many-landmarks-help": "conditional",
    "statement-proportional": "conditional",
}


@pytest.fixture(scope="module")
def entries():
    return {claim.id: claim.run("quick") for claim in CLAIMS}


def test_verdicts(entries):
    assert {key: entry.verdict for key, entry in entries.items()} == VERDICTS


@pytest.mark.slow
@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)
def test_full_size_gives_the_same_verdict(claim):
    assert claim.run("full").verdict == VERDICTS[claim.id]


def test_information_slopes_are_the_closed_forms(entries):
    evidence = entries["fisher-growth"].evidence
    for n in (1, 10, 50):
        slope = evidence[f"slope per step, n = {n}"]["estimate"]
        assert slope == pytest.approx(evidence[f"closed form, n = {n}"]["estimate"], rel=1e-9)
    start = evidence["information on the start itself, n = 1"]["estimate"]
    assert start == pytest.approx(1 / GOLDEN, rel=1e-9)


def test_a_biased_filter_would_fail_the_unbiasedness_claim(entries):
    claim = next(c for c in CLAIMS if c.id == "monte-carlo-unbiased")
    shifted = entries[claim.id].evidence[
        "what a sensor that reads a fifth of the spread too long would give"
    ]
    assert shifted["low"] > claim.accepted.high


def test_gain_decays_by_a_power_where_the_paper_expects_a_time_constant(entries):
    evidence = entries["gain-vanishes"].evidence
    slow = evidence["exponent of the own gain against k, n = 2"]["estimate"]
    assert slow == pytest.approx(-1, abs=0.01)


def test_more_landmarks_never_remove_the_vehicles_own_error(entries):
    stays = entries["many-landmarks-help"].evidence[
        "share of the vehicle's initial error that stays, n = 50"
    ]
    assert stays["low"] < 1 < stays["high"]


# Broken on purpose


@pytest.fixture(scope="module")
def broken():
    return monobot.variants(replace(FIG4, runs=1000), rng=RNG(8))


def test_right_variant_is_the_library(broken):
    config = replace(FIG4, runs=1000)
    world = monobot.simulate(config, rng=RNG(8))
    ours = monobot.refilter(config, world)
    np.testing.assert_allclose(broken[0].errors, ours.means[..., 1] - 1.0, atol=1e-12)
    np.testing.assert_allclose(broken[0].deviations, ours.deviations[0, :, 1], atol=1e-12)


def test_too_small_a_start_changes_no_estimate_and_is_dishonest(broken):
    right, small = broken[0], broken[1]
    np.testing.assert_allclose(small.errors, right.errors, atol=1e-12)
    assert small.nees[-1] > average_bounds(1, 1000, 1 - 1e-6)[1]


def test_early_update_is_biased(broken):
    right, late = broken[0].errors[:, -1], broken[2].errors[:, -1]
    assert abs(right.mean()) < 4 * stats.sem(right)
    assert abs(late.mean()) > 6 * stats.sem(late)


def test_forgotten_cross_covariance_is_dishonest(broken):
    low, high = average_bounds(1, 1000, 1 - 1e-6)
    assert low < broken[0].nees[-1] < high
    assert broken[3].nees[-1] > high


def test_known_landmark_repairs(broken):
    low, high = average_bounds(1, 1000, 1 - 1e-6)
    known = broken[4]
    assert low < known.nees[-1] < high
    assert known.deviations[-1] < 0.15 * broken[0].deviations[-1]
    assert np.all(np.diff(known.deviations) < 0)


# Pictures of what is known


def test_likelihood_is_level_along_a_shift_and_curved_across():
    places = np.linspace(-3, 3, 25)
    values = monobot.log_likelihood_of_shift(FIG3, places, places, rng=RNG(1))
    for offset in (-5, 0, 9):
        assert np.ptp(np.diagonal(values, offset)) < 1e-9
    # across: the information on the distance at the start, with the first look's own 1/W
    row = values[12]
    curvature = np.diff(row, 2) / np.diff(places)[0] ** 2
    np.testing.assert_allclose(curvature, -GOLDEN, rtol=1e-6)


@pytest.mark.parametrize("known", [False, True])
def test_plane_is_dark_in_one_direction_unless_a_landmark_is_known(known):
    for looks in (1, 5, 30):
        now = monobot.plane_after(looks, known_landmark=known, rng=RNG(3))
        assert scale_free_rank(now.information) == (2 if known else 1)
    assert (np.sqrt(now.cov[1, 1]) < 0.3) == known


def test_spread_falls_to_the_floor_while_the_sum_grows():
    against = monobot.spread(replace(FIG3, runs=RUNS), rng=RNG(6))
    assert np.all(np.diff(against.expected) < 0)
    assert np.all(against.expected > against.floor)
    assert np.all(np.diff(against.total) > 0)
    low, high = np.sqrt(stats.chi2.ppf([1e-4, 1 - 1e-4], RUNS) / RUNS)
    # landmarks of one run share their error, so a run counts once, not n times
    assert np.all(low < against.measured / against.expected)
    assert np.all(against.measured / against.expected < high)


def corners():
    values = {name: (c.values[0], c.values[-1]) for name, c in monobot.CONTROLS.items()}
    for chosen in product(*values.values()):
        yield dict(zip(values, chosen, strict=True))


@pytest.mark.parametrize("values", list(corners()), ids=lambda v: " ".join(map(str, v.values())))
def test_every_corner_of_the_study_can_be_drawn(values):
    _, axes = figure(1, 2)
    result = monobot.run(replace(FIG4, runs=3, **values), rng=RNG(1))
    assert np.isfinite(result.filtered.means).all()
    draw.study(axes, **result.all())
    for ax in axes:
        for line in ax.lines:
            assert np.isfinite(np.asarray(line.get_ydata(), dtype=float)).all()


# A real corridor


def write_log(folder, *, wall, turn):
    """Write a log of a robot that drives towards a wall, with its heading off by ``turn``."""
    directions = np.radians(np.arange(-90, 90))
    lines = []
    for k in range(90):
        x, heading = 0.5 * k, turn * (-1) ** k
        toward = np.cos(directions + heading)
        ranges = np.where(toward > 0.5, (wall - x) / np.maximum(toward, 0.5), 81.9)
        pose = f"{x * np.cos(0.3):.6f} {x * np.sin(0.3):.6f} {0.3 + heading:.6f}"
        wheels = f"{1.02 * x:.6f} 0 {heading:.6f}"
        readings = " ".join(f"{r:.4f}" for r in ranges)
        lines.append(f"FLASER 180 {readings} {pose} {wheels} {k} here {k}")
    with gzip.open(folder / monobot.CORRIDOR_LOG, "wt") as file:
        file.write("\n".join(lines) + "\n")


@pytest.mark.parametrize("turn", [0.0, np.radians(12)])
def test_corridor_reads_distances_and_moves_from_a_log(tmp_path, turn):
    write_log(tmp_path, wall=50.0, turn=turn)
    stretch = monobot.corridor(tmp_path)
    x = 0.5 * np.arange(90)[monobot.CORRIDOR_SCANS]
    np.testing.assert_allclose(stretch["looks"], 50.0 - x, atol=0.02)
    np.testing.assert_allclose(stretch["commands"], 1.02 * 0.5, atol=1e-5)
    np.testing.assert_allclose(stretch["track"], x - x[0], atol=1e-5)


def test_two_origins_give_one_map(tmp_path):
    write_log(tmp_path, wall=50.0, turn=0.0)
    stretch = monobot.corridor(tmp_path)
    here, there = (monobot.filter_corridor(stretch, origin=o) for o in (0.0, 100.0))
    np.testing.assert_allclose(there.means - here.means, 100.0, atol=1e-9)
    np.testing.assert_allclose(there.innovations, here.innovations, atol=1e-9)
    np.testing.assert_array_equal(there.covs, here.covs)


@pytest.mark.skipif(datasets.find("carmen_intel") is None, reason="the recording is not here")
def test_real_corridor_is_a_monobot():
    stretch = monobot.corridor(datasets.path("carmen_intel"))
    run = monobot.filter_corridor(stretch, origin=0.0)
    nis = normalised_squared(run.innovations[0], run.innovation_covs[0])
    low, high = average_bounds(1, nis.size, 0.99)
    assert low < nis.mean() < high
    wall = stretch["track"] + stretch["looks"]
    assert abs(run.means[0, -1, 1] - np.median(wall)) < 0.1


# Exercises


@pytest.mark.parametrize(
    ("key", "right", "wrong"),
    [
        ("monobot-1", 2 / (1 + np.sqrt(5)), [1.618034, 0.381966, 1.0, 7.0]),
        ("monobot-2", [0, 1, 0], [[0, -1, 1], [-1, 1, 0], [1, 0], [0, 0, 0]]),
        ("monobot-3", None, [1.618034, 0.25, 3.0]),
        ("monobot-4", None, [99, 10, 7]),
    ],
)
def test_exercises_judge_right_and_wrong(key, right, wrong):
    if key == "monobot-3":  # by the recursion, not by the closed form that the exercise uses
        start = Gaussian(np.zeros(1), np.array([[0.25]]))
        looks = np.zeros((1, 500, 4))
        run = run_filter(start, np.zeros(499), looks, motion_variance=1.0, look_variance=1.0)
        right = run.covs[0, -1, 1:, 1:].mean()
    if key == "monobot-4":
        right = next(
            n
            for n in range(80, 120)
            if settled(n, start_variance=1, motion_variance=1, look_variance=1).landmark_variance
            <= 1.01
        )
    exercise = EXERCISES[key]
    assert exercise.judge(right)[0] == "right"
    assert exercise.judge(...)[0] == "not yet"
    for answer in wrong:
        outcome, words = exercise.judge(answer)
        assert outcome == "wrong"
        assert len(words) > 20
