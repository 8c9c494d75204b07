"""The tracker: likelihood against a double loop, tolerance, smoothing, accuracy, loss."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.beliefs import ParticleSet
from robot_perception.ceiling.mapping import PatternTrackers
from robot_perception.ceiling.patterns import (
    Decay,
    correlations,
    deviations,
    make_pattern,
)
from robot_perception.ceiling.tracker import (
    Layers,
    PatternState,
    PatternTracker,
    TrackerRules,
    log_likelihoods,
    smoothing,
)
from tests.ceiling.pictures import cluttered, moved, smooth
from tests.unchecked import unchecked

CENTRE = (160.0, 120.0)
START = np.array([*CENTRE, 0.0, 1.0])
IMAGE = cluttered(3)
PATTERN = make_pattern(IMAGE, CENTRE)
RULES = TrackerRules()
TRACKER = PatternTracker(PATTERN)
SIGMAS = np.array(RULES.sigmas)


def rng(seed=0):
    return np.random.default_rng(seed)


def errors(tracker, seeds, spread=1.0, sigmas=SIGMAS):
    """Return the errors of estimates for drawn displacements of the pattern."""
    found = []
    for seed in seeds:
        away = spread * rng(seed).uniform(-1, 1, 4) * sigmas
        image = moved(IMAGE, START + away, CENTRE)
        state, _ = tracker.step(tracker.start(START), image, rng=rng(seed))
        found.append(state.pose - START - away)
    return np.array(found)


# Likelihood --------------------------------------------------------------------------------------


def by_hand(C, decay, rules):
    """Return eq. (6) by a double loop: products of Gaussians, with the rule of bad vectors."""
    found = []
    for row in C:
        away, unseen = [], 0
        for c, a, b in zip(row, decay.rate, decay.power, strict=True):
            unseen += np.isnan(c)
            away.append(0.0 if np.isnan(c) else ((1 - min(c, 1.0)) / a) ** (1 / b))
        if 2 * unseen > len(away):
            found.append(-1e6)
            continue
        away.sort(reverse=True)
        may_be_bad, total = int(rules.tolerated * len(away) + 1e-9), 0.0
        for k, lost in enumerate(away):
            if k < may_be_bad and lost > rules.worst:
                if rules.bad == "left out":
                    continue
                lost = rules.worst
            total -= lost**2 / (2 * rules.deviation**2)
        found.append(total * len(away) / (len(away) - unseen))
    return np.array(found)


@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 12),
    st.sampled_from([0.0, 0.1, 0.29, 0.5, 1.0]),
    st.sampled_from(["left out", "at worst"]),
    st.sampled_from([1.0, 2.0, 4.0]),
)
@settings(max_examples=150)
def test_likelihoods_are_those_of_a_double_loop(seed, n, tolerated, bad, worst):
    draw = rng(seed)
    C = draw.uniform(-1, 1, (7, n))
    C[draw.uniform(size=C.shape) < 0.2] = np.nan
    C[draw.uniform(size=C.shape) < 0.2] = 0.999
    decay = Decay(draw.uniform(0.05, 0.5, n), draw.choice([1.0, 1.5, 2.0], n))
    rules = replace(RULES, tolerated=tolerated, bad=bad, worst=worst, deviation=2.5)
    before = C.copy()
    found = log_likelihoods(C, decay, rules)
    np.testing.assert_allclose(found, by_hand(C, decay, rules), rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(C, before)


def test_what_leaves_the_picture_counts_as_the_others_until_less_than_half_is_seen():
    decay, rules = Decay(np.full(4, 0.2), np.ones(4)), replace(RULES, tolerated=0.0)
    C = np.array([[0.9, 0.8, np.nan, np.nan], [0.9, 0.8, 0.9, 0.8], [1.0, *3 * [np.nan]]])
    half, all_four, less = log_likelihoods(C, decay, rules)
    assert half == pytest.approx(all_four) == pytest.approx(-2 * (0.5**2 + 1) / 32)
    assert less == -1e6


def test_leaving_out_makes_the_bad_as_good_as_perfect():
    decay, rules = Decay(np.full(10, 0.1), np.ones(10)), replace(RULES, worst=2.0)
    C = np.full((3, 10), 0.85)
    C[1, :3], C[2, :3] = -0.5, 1.0
    left, kept = (
        log_likelihoods(C, decay, replace(rules, bad=b)) for b in ("left out", "at worst")
    )
    assert left[1] == pytest.approx(left[2])  # three bad ones count as three perfect ones
    assert left[1] > left[0]
    assert kept[1] < kept[0] < kept[2]
    assert kept[1] == pytest.approx(-(7 * 1.5**2 + 3 * 2.0**2) / 32)


def test_the_number_that_may_be_bad_is_rounded_down_but_not_by_floating_point():
    decay = Decay(np.full(100, 0.1), np.ones(100))
    C = np.ones((2, 100))
    C[0, :29], C[1, :30] = 0.0, 0.0
    rules = replace(RULES, tolerated=0.29, bad="left out")
    found = log_likelihoods(C, decay, rules)
    assert found[0] == 0  # 0.29 * 100 is 28.999999999999996
    assert found[1] == pytest.approx(-100 / 32)


def test_a_quarter_turn_of_the_picture_changes_no_likelihood():
    where = START + rng(1).normal(size=(40, 4)) * (5, 5, 1.0, 0.15)
    turned = np.column_stack([where[:, 1], 319 - where[:, 0], where[:, 2] - np.pi / 2, where[:, 3]])
    rotated = np.ascontiguousarray(np.rot90(IMAGE))
    for kind in ("none", "scale", "difference"):
        one, other = (
            log_likelihoods(Layers(image).correlations(PATTERN, p, kind), PATTERN.decay, RULES)
            for image, p in ((IMAGE, where), (rotated, turned))
        )
        np.testing.assert_allclose(other, one, rtol=1e-3, atol=1e-3)


# Smoothing ---------------------------------------------------------------------------------------


def test_how_much_is_smoothed():
    s = np.array([0.3, 1.0, 1.0 + 1e-9, 1.25, 2.0])
    np.testing.assert_array_equal(smoothing(s, "none"), np.zeros(5))
    np.testing.assert_allclose(smoothing(s, "scale"), [0, 0, 1, 1.25, 2])  # a jump at 1
    np.testing.assert_allclose(
        smoothing(s, "difference"), [0, 0, 2e-9**0.5, 0.75, 3**0.5], atol=1e-12
    )


@pytest.mark.parametrize("kind", ["none", "scale", "difference"])
def test_each_pose_is_seen_in_the_copy_of_its_scale(kind):
    where = np.tile(START, (9, 1))
    where[:, 3] = [1.5, 0.7, 1.0, 1.02, 1.2, 1.5, 2.0, 1.21, 3.0]
    layers = Layers(IMAGE)
    found = layers.correlations(PATTERN, where, kind)
    for pose, row in zip(where, found, strict=True):
        sigma = round(float(smoothing(pose[3:], kind)[0]) / Layers.STEP) * Layers.STEP
        copy = IMAGE.astype(np.float32)
        if sigma:
            copy = cv2.GaussianBlur(copy, (0, 0), sigma)
        np.testing.assert_array_equal(row, correlations(copy[None], PATTERN, pose[None])[0])
    np.testing.assert_array_equal(layers.correlations(PATTERN, where[5:6], kind), found[5:6])


def test_a_blur_that_grew_with_the_scale_fits_where_it_is_made_up_for():
    # a fine pattern, enlarged: the model's blur of a pixel has become one of s pixels
    image = cv2.GaussianBlur(smooth(2, 1.0), (0, 0), 1.0)
    pattern = make_pattern(image, CENTRE)
    sharp = cv2.resize(image, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    pose = np.array([[2 * 160 + 0.5, 2 * 120 + 0.5, 0, 2.0]])
    blurred = cv2.GaussianBlur(sharp, (0, 0), 3**0.5)
    plain = np.nanmedian(Layers(sharp).correlations(pattern, pose, "none"))
    assert plain > 0.99
    assert np.nanmedian(Layers(sharp).correlations(pattern, pose, "difference")) < plain
    assert np.nanmedian(Layers(blurred).correlations(pattern, pose, "none")) < plain


# States ------------------------------------------------------------------------------------------


def test_the_mean_goes_around_the_circle():
    draw = rng(4)
    weights = draw.normal(size=500)
    for middle in (0.3, np.pi - 0.02, -np.pi + 0.01, 3 * np.pi):
        theta = middle + 0.1 * draw.standard_normal(500)
        for wrapped in (theta, np.angle(np.exp(1j * theta))):
            states = np.column_stack([draw.normal(100, 3, (500, 2)), wrapped, np.full(500, 1.2)])
            particles = ParticleSet(states, weights)
            state = PatternState(particles)
            expected = np.angle(np.sum(particles.weights * np.exp(1j * theta)))
            assert state.pose[2] == pytest.approx(expected)
            np.testing.assert_allclose(state.pose[[0, 1, 3]], particles.mean[[0, 1, 3]])


def test_the_covariance_does_not_depend_on_where_angles_are_cut():
    still = replace(RULES, sigmas=(0, 0, 0, 0), particles=60)
    theta = rng(5).normal(0, 0.05, 60)
    covs = []
    for middle in (0.0, np.pi):
        image = IMAGE if middle == 0 else np.ascontiguousarray(IMAGE[::-1, ::-1])
        centre = CENTRE if middle == 0 else (319 - CENTRE[0], 239 - CENTRE[1])
        states = np.tile([*centre, 0.0, 1.0], (60, 1))
        states[:, 2] = np.angle(np.exp(1j * (theta + middle)))
        _, info = PatternTracker(PATTERN, still).step(
            PatternState(ParticleSet.uniform(states)), image, rng=rng(1)
        )
        covs.append(info.cov)
    np.testing.assert_allclose(covs[1], covs[0], atol=1e-6)
    assert 1e-6 < covs[0][2, 2] < 0.05**2


# Steps -------------------------------------------------------------------------------------------


def test_a_start_is_certain():
    state = TRACKER.start(START)
    np.testing.assert_allclose(state.pose, START, atol=1e-12)
    np.testing.assert_array_equal(state.particles.states, np.tile(START, (200, 1)))
    assert state.lost == 0


def test_a_pattern_that_does_not_move_stays_where_nothing_is_drawn():
    still = PatternTracker(PATTERN, replace(RULES, sigmas=(0, 0, 0, 0), passes=2))
    pose = START + np.array([3.0, -2.0, 0.1, 0.05])
    state, info = still.step(still.start(pose), IMAGE, rng=rng())
    np.testing.assert_allclose(state.pose, pose)
    np.testing.assert_allclose(info.cov, 0, atol=1e-12)
    assert info.effective == pytest.approx(200)


def test_what_a_step_tells_is_so():
    state, info = TRACKER.step(TRACKER.start(START), IMAGE, rng=rng(2))
    np.testing.assert_array_equal(info.pose, state.pose)
    C = Layers(IMAGE).correlations(PATTERN, state.pose[None], RULES.smoothing)[0]
    np.testing.assert_array_equal(info.correlation, C)
    np.testing.assert_allclose(info.deviation, deviations(C, PATTERN.decay))
    np.testing.assert_array_equal(info.good, info.deviation <= RULES.worst)
    assert 1 <= info.effective <= 200
    particles = state.particles
    away = particles.states - state.pose
    np.testing.assert_allclose(info.cov, (particles.weights * away.T) @ away, atol=1e-9)
    logs = log_likelihoods(
        Layers(IMAGE).correlations(PATTERN, particles.states, RULES.smoothing),
        PATTERN.decay,
        RULES,
    )
    relative = particles.log_weights - particles.log_weights.max()
    np.testing.assert_allclose(relative, logs - logs.max(), atol=1e-6)


def test_particles_move_by_the_sigmas_and_keep_a_scale():
    many = PatternTracker(PATTERN, replace(RULES, particles=4000))
    state, _ = many.step(many.start(START), IMAGE, rng=rng(3))
    away = state.particles.states - START  # all were drawn from one place
    np.testing.assert_allclose(away.std(axis=0), SIGMAS, rtol=0.05)
    np.testing.assert_allclose(away.mean(axis=0), np.zeros(4), atol=0.06 * SIGMAS.max())
    wide = PatternTracker(PATTERN, replace(RULES, sigmas=(0, 0, 0, 3.0)))
    state, _ = wide.step(wide.start(START), IMAGE, rng=rng(3))
    assert state.particles.states[:, 3].min() == 0.05


@pytest.mark.parametrize("passes", [0, 1, 2])
def test_each_pass_walks_a_third_as_far(passes):
    tracker = PatternTracker(PATTERN, replace(RULES, particles=4000, passes=passes))
    blank = np.full((240, 320), 128, np.uint8)  # where all particles are as likely
    state, info = tracker.step(tracker.start(START), blank, rng=rng(6))
    assert info.effective == pytest.approx(4000, rel=1e-3)
    expected = SIGMAS * np.sqrt(sum(9.0**-k for k in range(passes + 1)))
    away = state.particles.states - START
    np.testing.assert_allclose(away.std(axis=0), expected, rtol=0.035)


def test_estimates_are_near_within_a_sigma():
    away = errors(TRACKER, range(12))
    assert np.abs(np.median(np.abs(away), axis=0) <= (1.5, 1.5, np.deg2rad(1.5), 0.04)).all()
    assert np.abs(away[:, :2]).max() <= 5


def test_further_passes_lessen_the_error():
    size = np.array([5, 5, np.deg2rad(3), 0.1])
    once, often = (
        np.mean(np.abs(errors(PatternTracker(PATTERN, replace(RULES, passes=k)), range(10))) / size)
        for k in (0, 2)
    )
    assert often < 0.75 * once


def test_a_moving_pattern_is_followed():
    tracker = PatternTracker(PATTERN, replace(RULES, passes=1))
    state = tracker.start(START)
    for k in range(1, 13):
        pose = START + np.array([3.0 * k, 2.0 * k - 10 * np.sin(k / 6), 0.03 * k, 0.015 * k])
        state, info = tracker.step(state, moved(IMAGE, pose, CENTRE), rng=rng(k))
        assert not info.lost
        assert np.hypot(*(state.pose - pose)[:2]) <= 3
        assert abs(state.pose[2] - pose[2]) <= np.deg2rad(3)
        assert abs(state.pose[3] - pose[3]) <= 0.08
    assert state.lost == 0


def test_an_unrelated_picture_and_a_cover_are_noticed():
    state = TRACKER.start(START)
    for seed in (0, 1):
        state, info = TRACKER.step(state, cluttered(seed + 50), rng=rng(seed))
        assert info.lost
        assert state.lost == seed + 1
        assert info.good.mean() < 0.7
    covered = IMAGE.copy()
    covered[70:170, 110:210] = 128
    state, info = TRACKER.step(TRACKER.start(START), covered, rng=rng())
    assert info.lost
    state, info = TRACKER.step(PatternState(state.particles, 4), covered, rng=rng())
    assert state.lost == 5
    state, info = TRACKER.step(PatternState(TRACKER.start(START).particles, 4), IMAGE, rng=rng(2))
    assert (info.lost, state.lost) == (False, 0)


def test_more_bad_vectors_than_tolerated_are_a_loss():
    rules = replace(RULES, sigmas=(0, 0, 0, 0), particles=2)
    image = IMAGE.copy()
    image[:, 170:] = smooth(3)[:, 170:]
    C = Layers(image).correlations(PATTERN, START[None], "none")[0]
    bad = deviations(C, PATTERN.decay) > rules.worst
    share = bad.mean()
    assert 0.1 < share < 0.9
    for tolerated, lost in ((share, False), (share - 0.5 / len(bad), True)):
        tracker = PatternTracker(PATTERN, replace(rules, tolerated=tolerated))
        _, info = tracker.step(tracker.start(START), image, rng=rng())
        assert info.lost == lost


def at_the_border(share):
    """Return a place at which so many vectors or a few more reach beyond the picture."""
    for x in np.arange(60.0, 0.0, -0.5):
        pose = np.array([x, 120.0, 0.0, 1.0])
        image = moved(IMAGE, pose, CENTRE)
        C = Layers(image).correlations(PATTERN, pose[None], "none")[0]
        if np.isnan(C).mean() >= share:
            return pose, image, C
    raise AssertionError("no such place")


@pytest.mark.parametrize("share", [0.1, 0.35, 0.45])
def test_what_reaches_beyond_the_picture_is_not_bad(share):
    """A pattern is lost by what is seen of it, whatever part of it is not."""
    pose, image, C = at_the_border(share)
    unseen = np.isnan(C)
    assert share <= unseen.mean() < 0.5
    rules = replace(RULES, sigmas=(0, 0, 0, 0), particles=2, tolerated=0.05)
    tracker = PatternTracker(PATTERN, rules)
    _, info = tracker.step(tracker.start(pose), image, rng=rng())
    assert not info.good[unseen].any()
    assert not info.lost
    dark = image.copy()
    dark[110:] = 128  # what is seen of the lower half is bad
    _, info = tracker.step(tracker.start(pose), dark, rng=rng())
    assert info.lost


def test_the_match_counts_what_is_beyond_the_picture_as_the_opposite():
    pose, image, C = at_the_border(0.3)
    rules = replace(RULES, sigmas=(0, 0, 0, 0), particles=2)
    tracker = PatternTracker(PATTERN, rules)
    _, info = tracker.step(tracker.start(pose), image, rng=rng())
    unseen = np.isnan(C)
    expected = (C[~unseen].sum() - unseen.sum()) / len(C)
    assert info.match == pytest.approx(expected, abs=1e-6)
    _, whole = tracker.step(tracker.start(START), IMAGE, rng=rng())
    assert whole.match == pytest.approx(1, abs=1e-4)


def test_a_covered_part_does_not_carry_the_estimate_away():
    image = IMAGE.copy()
    image[88:104, 128:192] = 30  # a quarter of the window
    pose = []
    for seed in range(5):
        state, _ = TRACKER.step(TRACKER.start(START), image, rng=rng(seed))
        pose.append(state.pose)
    assert np.abs(np.mean(pose, axis=0) - START)[:2].max() <= 2


def test_one_seed_gives_the_same_numbers():
    one, same, other = (TRACKER.step(TRACKER.start(START), IMAGE, rng=rng(s))[0] for s in (1, 1, 2))
    np.testing.assert_array_equal(one.particles.states, same.particles.states)
    assert (one.pose != other.pose).all()


# Bad input ---------------------------------------------------------------------------------------

ONE = ParticleSet.uniform(np.ones((3, 4)))


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: TrackerRules(particles=0), "particles must be from 1"),
        (lambda: TrackerRules(sigmas=(1, 1, -1, 0)), "sigmas must not be negative"),
        (lambda: TrackerRules(worst=0), "worst must be positive"),
        (lambda: TrackerRules(tolerated=1.2), "tolerated must be from 0 to 1"),
        (lambda: TrackerRules(bad="ignored"), "bad must be one of"),
        (lambda: TrackerRules(smoothing="some"), "smoothing must be one of"),
        (lambda: PatternState(ParticleSet.uniform(np.ones((3, 3)))), "particles.states must be"),
        (lambda: PatternState(ParticleSet.uniform(np.zeros((3, 4)))), "positive scale"),
        (lambda: PatternState(ONE, -1), "lost must be at least 0"),
        (lambda: TRACKER.start(np.array([1, 2, 3, 0.0])), "pose must have a positive scale"),
        (lambda: TRACKER.step(ONE, IMAGE, rng=rng()), "state must be a PatternState"),
        (
            lambda: TRACKER.step(TRACKER.start(START), IMAGE.astype(float), rng=rng()),
            "image must be an array of bytes",
        ),
        (lambda: TRACKER.step(TRACKER.start(START), IMAGE, rng=0), "rng must be a Generator"),
        (
            lambda: TRACKER.step(TRACKER.start(START), IMAGE[:1, :1], rng=rng()),
            r"image must be \(\d+, \d+\) as that of the pattern, got \(1, 1\)",
        ),
        (
            lambda: TRACKER.step(TRACKER.start(START), IMAGE[:, :-1], rng=rng()),
            "image must be .* as that of the pattern",
        ),
        (
            lambda: PatternTrackers({"a": PATTERN}).step(
                {"a": TRACKER.start(START)}, IMAGE[:-1], rng=rng()
            ),
            "image must be .* as that of the pattern",
        ),
        (
            lambda: Layers(IMAGE).correlations(PATTERN, np.full((1, 4), 2.0**62), "scale"),
            "poses must be within 1e",
        ),
        (lambda: smoothing(np.ones(2), "more"), "kind must be one of"),
        (
            lambda: log_likelihoods(np.ones((3, 2)), PATTERN.decay, RULES),
            "correlation must be .* for this decay",
        ),
    ],
)
def test_bad_input_is_named(made, said):
    with unchecked(), pytest.raises((ValueError, TypeError), match=said):
        made()
