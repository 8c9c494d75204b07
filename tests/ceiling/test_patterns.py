"""Patterns: samples, correlations at places, autocorrelations and their fits, windows."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.ndimage import map_coordinates
from scipy.optimize import curve_fit

from robot_perception.ceiling.contours import Arc, ContourRules, find_contours, find_edges
from robot_perception.ceiling.patterns import (
    Decay,
    Pattern,
    PatternRules,
    WindowRules,
    autocorrelation,
    correlations,
    decay_in_picture,
    deviations,
    fit_decay,
    grey_vectors,
    interest_windows,
    make_pattern,
)
from tests.ceiling.pictures import cluttered, drawn, moved, rectangle, smooth
from tests.unchecked import unchecked

SMOOTH, CLUTTERED = smooth(0), cluttered(3)
CENTRE = (160.0, 120.0)


def lines(points, phi, samples, step):
    """Return where a line of samples across each point has them: (n, samples, 2)."""
    k = np.arange(samples) - samples // 2
    return points[:, None] + step * k[:, None] * np.stack([np.cos(phi), np.sin(phi)], -1)[:, None]


def some_pattern(seed=0, n=60, samples=11, *, centred=True, step=1.0, size=(64.0, 48.0)):
    """Return a pattern of random places and vectors."""
    rng = np.random.default_rng(seed)
    places = np.column_stack([rng.uniform(-0.5, 0.5, (n, 2)), rng.uniform(-np.pi, np.pi, n)])
    decay = Decay(rng.uniform(0.02, 0.3, n), np.ones(n))
    return Pattern(places, rng.uniform(0, 255, (n, samples)), decay, size, step, centred)


def plain(image, pattern, pose):
    """Return the correlations at one place, by SciPy's samples."""
    x, y, theta, scale = pose
    R = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    points = (x, y) + scale * (pattern.places[:, :2] * pattern.size) @ R.T
    count = pattern.vectors.shape[1]
    at = lines(points, pattern.places[:, 2] + theta, count, scale * pattern.step)
    high = np.array(image.shape[::-1]) - 1.0
    inside = ((at >= 0) & (at <= high)).all(axis=(1, 2))
    seen = map_coordinates(image.astype(float), np.moveaxis(at, -1, 0)[::-1], order=1)
    V = pattern.vectors
    if pattern.centred:
        seen, V = (v - v.mean(axis=1, keepdims=True) for v in (seen, V))
    lengths = np.linalg.norm(seen, axis=1), np.linalg.norm(V, axis=1)
    flat = np.minimum(*lengths) ** 2 < 1e-3 * count
    found = np.where(flat, 0.0, (seen * V).sum(axis=1) / np.maximum(np.prod(lengths, axis=0), 1e-9))
    return np.where(inside, found, np.nan)


def poses(seed, m=30):
    rng = np.random.default_rng(seed)
    return np.column_stack(
        [
            rng.uniform(-10, 330, m),
            rng.uniform(-10, 250, m),
            rng.uniform(-7, 7, m),
            rng.uniform(0.4, 2.0, m),
        ]
    )


# Samples -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("samples", "step"), [(3, 1.0), (11, 1.0), (9, 1.7), (21, 0.4)])
def test_samples_are_bilinear(samples, step):
    rng = np.random.default_rng(1)
    points = rng.uniform(0, (319, 239), (400, 2))
    phi = rng.uniform(-4, 4, 400)
    found = grey_vectors(SMOOTH, points, phi, samples=samples, step=step)
    at = lines(points, phi, samples, step)
    inside = ((at >= 0) & (at <= (319, 239))).all(axis=(1, 2))
    assert 50 < inside.sum() < 400
    np.testing.assert_array_equal(np.isnan(found), np.repeat(~inside[:, None], samples, axis=1))
    scipys = map_coordinates(SMOOTH.astype(float), np.moveaxis(at, -1, 0)[::-1], order=1)
    np.testing.assert_allclose(found[inside], scipys[inside], atol=2e-4)
    where = at[inside].astype(np.float32)
    cvs = cv2.remap(SMOOTH.astype(np.float32), where[..., 0], where[..., 1], cv2.INTER_LINEAR)
    np.testing.assert_allclose(found[inside], cvs, atol=1.0)  # to a 32nd of a pixel


@given(st.integers(2, 9), st.integers(2, 9), st.data())
@settings(max_examples=60)
def test_lines_that_end_on_the_border_are_inside(width, height, data):
    image = np.random.default_rng(width).integers(0, 256, (height, width), dtype=np.uint8)
    upright = data.draw(st.booleans())
    along, across = (height, width) if upright else (width, height)
    if along < 3:
        return
    ends = data.draw(st.sampled_from([0, across - 1]))
    middle = data.draw(st.sampled_from([1, along - 2]))
    point = np.array([[ends, middle] if upright else [middle, ends]], float)
    phi = np.array([np.pi / 2 if upright else 0.0])
    expected = image[middle - 1 : middle + 2, ends] if upright else image[ends, middle - 1 :][:3]
    found = grey_vectors(image, point, phi, samples=3)
    np.testing.assert_allclose(found[0], expected, atol=1e-9)
    for beyond in (-1e-6, 1e-6):
        way = np.sign(beyond) * (1 if (ends if beyond > 0 else across - 1 - ends) else -1)
        out = point + np.array([[way * 1e-6, 0] if upright else [0, way * 1e-6]])
        left = (out.min() < 0) | (out > (width - 1, height - 1)).any()
        assert np.isnan(grey_vectors(image, out, phi, samples=3)).all() == left


def test_pictures_too_small_for_four_pixels_hold_no_line():
    for shape in ((1, 1), (1, 9), (9, 1)):
        found = grey_vectors(np.ones(shape, np.uint8), np.zeros((1, 2)) + 4, np.zeros(1), samples=3)
        assert np.isnan(found).all()
        layers = np.ones((1, *shape), np.float32)
        assert np.isnan(correlations(layers, some_pattern(), poses(0))).all()


# Correlations ------------------------------------------------------------------------------------


@pytest.mark.parametrize("centred", [True, False])
@pytest.mark.parametrize(("samples", "step"), [(11, 1.0), (5, 2.3)])
def test_correlations_are_those_of_the_formula(centred, samples, step):
    pattern = some_pattern(2, samples=samples, centred=centred, step=step)
    layers, where = np.stack([smooth(4), smooth(5)]).astype(np.float32), poses(1)
    chosen = np.arange(len(where)) % 2
    found = correlations(layers, pattern, where, chosen)
    expected = [plain(layers[k], pattern, pose) for k, pose in zip(chosen, where, strict=True)]
    assert 0.1 < np.isnan(expected).mean() < 0.9
    np.testing.assert_allclose(found, expected, atol=2e-4)
    np.testing.assert_array_equal(correlations(layers[:1], pattern, where)[::2], found[::2])


def test_centred_correlations_are_those_of_corrcoef():
    pattern = some_pattern(3)
    found = correlations(SMOOTH[None].astype(np.float32), pattern, np.array([[160, 120, 0, 1.0]]))
    at = pattern.points + np.array(CENTRE)
    V = grey_vectors(SMOOTH, at, pattern.places[:, 2])
    for j in range(len(at)):
        assert found[0, j] == pytest.approx(np.corrcoef(V[j], pattern.vectors[j])[0, 1], abs=1e-4)


@pytest.mark.parametrize("amplitude", [10.0, 1.0, 0.3])
def test_small_contrasts_count_at_bright_places(amplitude):
    image = (230 + amplitude * (SMOOTH / 255 - 0.5)).astype(np.float32)
    pattern, where = some_pattern(4), np.array([[160, 120, 0.3, 1.1]])
    expected = plain(image, pattern, where[0])
    found = correlations(image[None], pattern, where)[0]
    sure = np.abs(expected) > 0
    sure &= found != 0  # at the threshold either may be right
    assert sure.sum() >= 10
    np.testing.assert_allclose(found[sure], expected[sure], atol=1e-3)


def test_a_gain_changes_nothing_and_an_offset_nothing_where_means_are_removed():
    where = poses(2)
    dark = smooth(6).astype(np.float32) / 4
    for centred in (True, False):
        pattern = some_pattern(5, centred=centred)
        before = correlations(dark[None], pattern, where)
        twice = correlations(2 * dark[None], pattern, where)
        seen = np.isfinite(before) & (np.abs(before) > 1e-6)
        assert seen.sum() > 300
        np.testing.assert_allclose(twice[seen], before[seen], atol=1e-5)
        brighter = correlations(1.7 * dark[None] + 60, pattern, where)
        change = np.abs(brighter - before)[seen]
        assert change.max() <= 1e-4 if centred else change.max() > 0.1


@pytest.mark.parametrize("centred", [True, False])
def test_vectors_without_contrast_correlate_with_nothing(centred):
    pattern, where = some_pattern(6, centred=centred), np.array([[160, 120, 0.2, 1.0]])
    blank = np.full((1, 240, 320), 0 if not centred else 247.3, np.float32)
    np.testing.assert_array_equal(correlations(blank, pattern, where), np.zeros((1, 60)))
    constant = np.full_like(pattern.vectors, 0.0 if not centred else 90.0)
    empty = replace(pattern, vectors=constant)
    layers = SMOOTH[None].astype(np.float32)
    np.testing.assert_array_equal(correlations(layers, empty, where), np.zeros((1, 60)))


@pytest.mark.parametrize(
    "pose", [(160, 120, 0, 1), (100.5, 90.2, 0.7, 1), (180, 130, -2.8, 1.3), (150, 100, 3.5, 0.8)]
)
def test_a_pattern_correlates_with_its_own_copy(pose):
    pattern = make_pattern(CLUTTERED, CENTRE)
    copy = moved(CLUTTERED, pose, CENTRE)
    where = np.array([pose, np.add(pose, (8, 0, 0, 0)), np.add(pose, (0, 0, 0.25, 0))], float)
    here, aside, turned = correlations(copy[None].astype(np.float32), pattern, where)
    assert np.isfinite(here).mean() > 0.95
    assert np.nanmedian(here) > (0.99 if pose[3] == 1 else 0.93)
    assert np.nanquantile(here, 0.1) > 0.8
    assert np.nanmedian(aside) < 0.8
    assert np.nanmedian(turned) < np.nanmedian(here) - 0.05


def test_a_quarter_turn_of_the_picture_is_one_of_the_place():
    pattern, where = some_pattern(7), poses(3)
    layers = SMOOTH[None].astype(np.float32)
    # (u, v) is seen at (v, width - 1 - u): a turn by -90°
    turned = np.column_stack([where[:, 1], 319 - where[:, 0], where[:, 2] - np.pi / 2, where[:, 3]])
    rotated = np.ascontiguousarray(np.rot90(layers, axes=(1, 2)))
    assert rotated[0, 319 - 7, 5] == layers[0, 5, 7]
    np.testing.assert_allclose(
        correlations(rotated, pattern, turned), correlations(layers, pattern, where), atol=1e-4
    )


def test_places_far_beyond_the_picture_are_not_seen():
    far = np.array([[1e99, 0, 0, 1], [1e99, 1e99, 2, 1e99], [0, 0, 1e90, 1e99]])
    assert np.isnan(correlations(SMOOTH[None].astype(np.float32), some_pattern(), far)).all()


# Autocorrelation and what is fitted to it --------------------------------------------------------


@pytest.mark.parametrize("centred", [True, False])
@pytest.mark.parametrize("samples", [3, 11, 12])
def test_autocorrelation_as_printed(centred, samples):
    V = np.random.default_rng(8).uniform(0, 255, (20, samples))
    found = autocorrelation(V, centred=centred)
    assert found.shape == (20, samples // 2 + 1)
    for vector, fall in zip(V, found, strict=True):
        G = vector - vector.mean() * centred
        full = np.correlate(G, G, "full")[samples - 1 :] / (G @ G)
        np.testing.assert_allclose(fall, full[: samples // 2 + 1], atol=1e-12)


def test_a_vector_of_equal_greys_falls_by_its_ends_alone():
    lags = np.arange(6)
    found = autocorrelation(np.full((2, 11), 87.0))
    np.testing.assert_allclose(found, [1 - lags / 11] * 2)
    np.testing.assert_array_equal(autocorrelation(np.full((2, 11), 87.0), centred=True), 1.0)
    np.testing.assert_array_equal(autocorrelation(np.zeros((2, 11))), 1.0)


@pytest.mark.parametrize("centred", [True, False])
def test_decay_in_the_picture_is_the_correlation_with_vectors_aside(centred):
    rng = np.random.default_rng(9)
    points, phi = rng.uniform((15, 15), (304, 224), (30, 2)), rng.uniform(-3, 3, 30)
    found = decay_in_picture(SMOOTH, points, phi, samples=9, step=1.2, centred=centred)
    assert found.shape == (30, 5)
    image = SMOOTH.astype(float)
    for j in range(30):
        # one long line; vectors are its pieces
        long = lines(points[j : j + 1], phi[j : j + 1], 17, 1.2)[0]
        g = map_coordinates(image, long.T[::-1], order=1)
        middle = g[4:13]
        for lag in range(5):
            pair = [g[4 + lag : 13 + lag], g[4 - lag : 13 - lag]]
            if centred:
                expected = np.mean([np.corrcoef(middle, other)[0, 1] for other in pair])
            else:
                expected = np.mean(
                    [middle @ v / np.linalg.norm(middle) / np.linalg.norm(v) for v in pair]
                )
            assert found[j, lag] == pytest.approx(expected, abs=2e-4)


def test_decay_at_a_border_takes_the_side_that_is_inside():
    points, phi = np.array([[5.0, 50.0], [5.5, 50.0], [9.0, 50.0]]), np.zeros(3)
    found = decay_in_picture(SMOOTH, points, phi)
    V = {k: grey_vectors(SMOOTH, points + np.array([k, 0.0]), phi) for k in range(-5, 6)}
    for j, most in enumerate((0, 0, 4)):  # so far on the left it is inside
        for lag in range(1, 6):
            sides = [lag, -lag] if lag <= most else [lag]
            expected = np.mean([np.corrcoef(V[0][j], V[k][j])[0, 1] for k in sides])
            assert found[j, lag] == pytest.approx(expected, abs=1e-4)
    thin = np.ascontiguousarray(SMOOTH[:, :14])
    found = decay_in_picture(thin, np.array([[6.0, 50.0]]), np.zeros(1))
    assert found[0, 1] < 1
    assert (found[0, 3:] == found[0, 2]).all() or (found[0, 4:] == found[0, 3]).all()


def falling(seed, n=12, lags=6):
    """Return functions that start at 1 and fall unevenly."""
    rng = np.random.default_rng(seed)
    lost = np.cumsum(rng.uniform(0.01, 0.2, (n, lags - 1)), axis=1)
    return np.column_stack([np.ones(n), 1 - lost])


def test_a_line_and_a_parabola_are_least_squares():
    C, lags = falling(1), np.arange(6.0)
    for curve, power in (("line", 1.0), ("parabola", 2.0)):
        found = fit_decay(C, curve)
        np.testing.assert_array_equal(found.power, power)
        for fall, rate in zip(C, found.rate, strict=True):
            best = curve_fit(lambda x, a, b=power: 1 - a * x**b, lags, fall, [0.1])[0]
            assert rate == pytest.approx(best[0], rel=1e-5)


@pytest.mark.parametrize("shape", [(0, 6), (3, 2), (0, 0)])
def test_too_few_functions_or_lags_are_named(shape):
    with unchecked(), pytest.raises(ValueError, match=r"falls must be one at least, of three lags"):
        fit_decay(np.ones(shape))


def test_a_power_is_a_line_of_logarithms():
    C = falling(2)
    found = fit_decay(C, "power")
    for fall, rate, power in zip(C, found.rate, found.power, strict=True):
        slope, start = np.polyfit(np.log(np.arange(1, 6)), np.log(1 - fall[1:]), 1)
        if 0.5 < slope < 2:
            assert (power, rate) == pytest.approx((slope, np.exp(start)))
        else:
            assert power in (0.5, 2.0)


@given(st.floats(0.002, 0.2), st.floats(0.5, 2.0))
def test_planted_parameters_are_found(rate, power):
    C = 1 - rate * np.arange(6.0)[None] ** power
    found = fit_decay(C, "power")
    assert (found.rate[0], found.power[0]) == pytest.approx((rate, power))
    if power in (1.0, 2.0):
        same = fit_decay(C, "line" if power == 1 else "parabola")
        assert same.rate[0] == pytest.approx(rate)


def test_curves_outside_the_powers_keep_their_mean_height():
    lags = np.arange(6.0)
    for steep, power in ((3.0, 2.0), (0.2, 0.5)):
        found = fit_decay(1 - 0.004 * lags[None] ** steep, "power")
        assert found.power[0] == power
        logs = np.log(found.rate[0] * lags[1:] ** power) - np.log(0.004 * lags[1:] ** steep)
        assert logs.mean() == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("curve", ["line", "parabola", "power"])
def test_without_parameters_of_their_own_all_have_the_mean(curve):
    own, mean = fit_decay(falling(3), curve), fit_decay(falling(3), curve, own=False)
    np.testing.assert_allclose(mean.rate, np.full(12, own.rate.mean()))
    np.testing.assert_allclose(mean.power, np.full(12, own.power.mean()))
    assert np.ptp(own.rate) > 0.01


@pytest.mark.parametrize("curve", ["line", "parabola", "power"])
def test_what_does_not_fall_has_the_least_rate(curve):
    assert fit_decay(np.ones((1, 6)), curve).rate[0] == pytest.approx(1e-3, rel=1)
    assert fit_decay(np.array([[1, 1.2, 1.1]]), curve).rate[0] >= 1e-3 - 1e-12


@given(st.floats(0, 30), st.integers(0, 2**32 - 1))
def test_deviations_invert_the_curve(away, seed):
    rng = np.random.default_rng(seed)
    decay = Decay(rng.uniform(0.01, 0.5, 5), rng.uniform(0.5, 2, 5))
    C = 1 - decay.rate * away**decay.power
    np.testing.assert_allclose(deviations(C, decay), np.full(5, away), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(deviations(np.stack([C, C]), decay)[1], np.full(5, away), atol=1e-5)
    line = Decay(decay.rate, np.ones(5))
    np.testing.assert_allclose(deviations(C, line), (1 - C) / decay.rate, atol=1e-12)


def test_deviations_of_what_is_better_than_perfect_or_was_not_seen():
    decay = Decay(np.array([0.1, 0.1, 0.1]), np.array([1.0, 1.0, 2.0]))
    C = np.array([1.0001, np.nan, -1.0])
    np.testing.assert_allclose(deviations(C, decay), [0.0, np.inf, 20**0.5])
    np.testing.assert_array_equal(C, [1.0001, np.nan, -1.0])


# Patterns ----------------------------------------------------------------------------------------


def test_a_pattern_is_what_eq_4_says():
    rules = PatternRules(samples=9, step=1.5, most=80)
    centre, size = (150.0, 118.0), (80.0, 56.0)
    pattern = make_pattern(CLUTTERED, centre, size, rules)
    edges = find_edges(CLUTTERED)
    at = centre + pattern.places[:, :2] * size
    np.testing.assert_allclose(pattern.points, at - centre)
    assert (np.abs(pattern.places[:, :2]) <= 0.5).all()
    np.testing.assert_allclose(pattern.places[:, 2], edges.directions(at))
    V = grey_vectors(CLUTTERED, at, pattern.places[:, 2], samples=9, step=1.5)
    np.testing.assert_allclose(pattern.vectors, V, atol=0.02)  # coordinates are rounded
    contours = find_contours(edges)
    along = np.concatenate([piece.points(rules.spacing) for piece in contours])
    for point in at:
        assert np.hypot(*(along - point).T).min() < 1e-9
    assert pattern.size == size
    assert (pattern.step, pattern.centred) == (1.5, True)
    for piece in pattern.contours:
        inside = piece.points(1.0)
        assert (np.abs(inside) <= np.array(size) / 2 + 1e-9).all()
        assert np.hypot(*np.moveaxis(inside[:, None] + centre - along, -1, 0)).min(1).max() < 3
    falls = decay_in_picture(CLUTTERED, at, pattern.places[:, 2], samples=9, step=1.5)
    np.testing.assert_allclose(pattern.decay.rate, fit_decay(falls).rate, rtol=0.01)
    padded = make_pattern(CLUTTERED, centre, size, replace(rules, fall="padded", own=False))
    falls = autocorrelation(padded.vectors, centred=True)
    np.testing.assert_allclose(padded.decay.rate, fit_decay(falls, own=False).rate, rtol=1e-6)
    printed = make_pattern(CLUTTERED, centre, size, replace(rules, centred=False, curve="power"))
    at = centre + printed.points
    falls = decay_in_picture(
        CLUTTERED, at, printed.places[:, 2], samples=9, step=1.5, centred=False
    )
    np.testing.assert_allclose(printed.decay.power, fit_decay(falls, "power").power, rtol=0.01)


def test_the_steepest_points_are_kept():
    whole = make_pattern(CLUTTERED, CENTRE, rules=PatternRules(most=1000))
    some = make_pattern(CLUTTERED, CENTRE, rules=PatternRules(most=30))
    assert len(whole.places) > 50
    assert len(some.places) == 30
    rates = np.sort(whole.decay.rate)[::-1]
    np.testing.assert_allclose(np.sort(some.decay.rate)[::-1], rates[:30])
    contours = find_contours(find_edges(CLUTTERED))
    along = np.concatenate([piece.points(PatternRules().spacing) for piece in contours])
    for pattern in (whole, some):  # in the order along the contours
        at = pattern.points + np.array(CENTRE)
        order = [np.hypot(*(along - point).T).argmin() for point in at]
        assert (np.diff(order) > 0).all()
    # the criterion is the line's, whatever curve is fitted
    power = make_pattern(CLUTTERED, CENTRE, rules=PatternRules(most=30, curve="parabola"))
    np.testing.assert_array_equal(power.places, some.places)


def test_points_picked_at_random():
    rules = PatternRules(most=30, picked="random")
    one, same, other = (
        make_pattern(CLUTTERED, CENTRE, rules=rules, rng=np.random.default_rng(seed))
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one.places, same.places)
    assert (one.places != other.places).any()
    whole = make_pattern(CLUTTERED, CENTRE, rules=PatternRules(most=1000))
    assert {tuple(p) for p in one.places} <= {tuple(p) for p in whole.places}
    assert len({tuple(p) for p in one.places}) == 30
    steepest = make_pattern(CLUTTERED, CENTRE, rules=PatternRules(most=30))
    assert one.decay.rate.mean() < steepest.decay.rate.mean()
    with pytest.raises(ValueError, match="rng must be given"):
        make_pattern(CLUTTERED, CENTRE, rules=rules)


def test_of_a_circle_that_leaves_the_window_the_pattern_holds_what_is_inside():
    image = drawn([("disc", (160, 120, 45), 60)])
    rules = ContourRules(roundness=1.1)
    pattern = make_pattern(image, CENTRE, (70, 140), contours=rules)
    assert len(pattern.contours) >= 2
    for arc in pattern.contours:
        assert isinstance(arc, Arc)
        assert (np.abs(arc.points(0.5)) <= (35 + 1e-9, 70)).all()
        assert arc.radius == pytest.approx(45, abs=0.5)
    total = sum(arc.length for arc in pattern.contours)
    assert total == pytest.approx(4 * 45 * np.arcsin(35 / 45), abs=25)


def test_points_are_seen_where_eq_5_says():
    pattern = some_pattern(8)
    pose = np.array([30.0, 40, 0.4, 1.5])
    u, v = pattern.points.T
    expected = (30, 40) + 1.5 * np.column_stack(
        [np.cos(0.4) * u - np.sin(0.4) * v, np.sin(0.4) * u + np.cos(0.4) * v]
    )
    np.testing.assert_allclose(pattern.seen(pose), expected)
    np.testing.assert_allclose(pattern.seen(np.stack([pose, pose])), [expected, expected])


def test_a_window_must_lie_in_the_picture_and_may_touch_its_border():
    shapes = [("area", rectangle(8, 8, 9, 8, 0.3), 60)]
    image = drawn(shapes, size=(40, 30))
    assert len(make_pattern(image, (15.5, 15.5), (32, 28)).places)
    assert len(make_pattern(image, (19.5, 14.5), (40, 30)).places)
    for centre in ((19.4, 14.5), (19.6, 14.5), (19.5, 14.4), (19.5, 14.6)):
        with pytest.raises(ValueError, match="centre and size must be of a window in 40 × 30"):
            make_pattern(image, centre, (40, 30))
    for centre, said in (((31, 21), "image must show a contour"), ((15, 15), "centre and size")):
        with pytest.raises(ValueError, match=said):
            make_pattern(image, centre, (10, 10) if said != "centre and size" else (0, 10))
    blank = np.full((60, 60), 90, np.uint8)
    with pytest.raises(ValueError, match="image must show a contour"):
        make_pattern(blank, (30, 30), (40, 40))


def test_points_whose_vectors_leave_the_picture_are_left_out():
    image = drawn([("area", rectangle(20, 15, 34, 24), 60)], size=(40, 30))
    pattern = make_pattern(image, (19.5, 14.5), (40, 30), PatternRules(samples=5))
    assert len(pattern.places)
    with pytest.raises(ValueError, match="image must show contrast"):
        make_pattern(image, (19.5, 14.5), (40, 30), PatternRules(samples=31))


# Windows -----------------------------------------------------------------------------------------

ARROW = np.array([[-22, -9], [3, -9], [3, -20], [23, 1], [3, 20], [3, 9], [-22, 9]]) * 1.0


def arrow(u, v):
    return ARROW + np.array([u, v])


SEARCH = WindowRules()


def windows(image, rules=SEARCH, **more):
    edges = find_edges(image)
    contours = find_contours(edges, ContourRules(roundness=1.1))
    return interest_windows(edges, contours, rules, **more)


def test_a_blank_picture_has_no_window():
    assert windows(np.full((240, 320), 180, np.uint8)) == ()
    assert windows(180 + smooth(1, 40.0) // 32) == ()
    assert windows(np.full((60, 60), 180, np.uint8)) == ()  # nor has one that is too small


def test_a_lattice_of_equal_things_has_no_window():
    tiles = [
        ("area", rectangle(u, v, 26, 26, 0.2), 60)
        for u in np.arange(10, 320, 40)
        for v in np.arange(0, 250, 40)
    ]
    image = drawn(tiles)
    assert windows(image) == ()
    assert windows(image, replace(SEARCH, rival=1.0))


def test_lines_of_one_direction_have_no_window():
    stripes = [("area", rectangle(160 + k, 120, 9 + k / 20, 600, 0.5), 60) for k in (-60, 5, 90)]
    assert windows(drawn(stripes)) == ()


def test_a_circle_alone_is_weak():
    disc = drawn([("disc", (160, 120, 22), 60)])
    assert windows(disc) == ()
    seen = windows(disc, replace(SEARCH, strength=0.5))
    assert all(window.strength < 3 for window in seen)
    key = drawn([("disc", (160, 120, 22), 60), ("area", rectangle(160, 120, 60, 10, 0.4), 60)])
    assert windows(key)


def test_a_distinctive_thing_is_chosen_and_what_is_taken_keeps_away():
    shapes = [("area", rectangle(u, 60, 20, 20), 60) for u in (60, 120, 180, 240)]
    image = drawn([*shapes, ("area", arrow(150, 170), 40)])
    found = windows(image)
    assert found
    for window in found:
        (u, v), wide = window.centre, np.array(window.size)
        assert np.abs(np.subtract((u, v), (150, 170))).max() < 40
        assert ((u, v) - (wide - 1) / 2 >= SEARCH.margin).all()
        assert window.rival <= SEARCH.rival
        assert window.strength >= SEARCH.strength
    assert windows(image, taken=np.array([found[0].centre])) != found
    everywhere = np.stack(np.meshgrid(np.arange(0, 320, 40), np.arange(0, 240, 40)), -1)
    assert windows(image, taken=everywhere.reshape(-1, 2).astype(float)) == ()


def test_windows_are_apart_the_strongest_first_and_become_patterns():
    rules = replace(SEARCH, margin=0, rival=0.95, most=6)
    found = windows(CLUTTERED, rules)
    assert 2 <= len(found) <= 6
    centres = np.array([window.centre for window in found])
    away = np.hypot(*np.moveaxis(centres[:, None] - centres, -1, 0))
    assert away[np.triu_indices(len(found), 1)].min() >= rules.apart
    for window in found:
        pattern = make_pattern(CLUTTERED, window.centre, window.size)
        assert len(pattern.places) > 10
    assert len(windows(CLUTTERED, replace(rules, most=1))) == 1
    corner = drawn([("area", ARROW[:, ::-1] * 0.9 + (30, 31), 40)], size=(64, 64))
    (window,) = windows(corner, replace(SEARCH, margin=0))
    assert window.centre == (31.5, 31.5)
    make_pattern(corner, window.centre, window.size)  # the whole picture


ARROWS = [("area", arrow(100, 100), 60), ("area", ARROW[:, ::-1] * 0.8 + (230, 140), 110)]
BARS = [
    ("area", rectangle(160 + k, 120 + 3 * k, 6, high, 0.4), grey)
    for k, high, grey in ((-20, 150, 60), (12, 170, 90))
]
BARS.append(("area", rectangle(150, 120, 26, 20, 0.4), 130))


@pytest.mark.parametrize(("shapes", "held_by"), [(ARROWS, "turn"), (BARS, "shift")])
def test_strength_and_rival_are_those_of_their_formulas(shapes, held_by):
    image = drawn(shapes)
    edges = find_edges(image)
    contours = find_contours(edges)
    found = interest_windows(edges, contours, replace(SEARCH, strength=1.0))
    assert found
    at = np.rint(np.concatenate([piece.points(SEARCH.spacing) for piece in contours]))
    lines = ndimage.gaussian_filter(edges.mask.astype(float), 1.5, mode="mirror", truncate=4)
    phi, weakest = edges.directions(at), set()
    for window in found:
        corner = np.subtract(window.centre, 31.5).astype(int)
        inside = ((at >= corner) & (at <= corner + 63)).all(axis=1)
        n = np.stack([np.cos(phi), np.sin(phi)], -1)[inside]
        shift = np.linalg.eigvalsh(n.T @ n)[0]
        p = at[inside] - window.centre

        def turning(c, n=n, p=p):
            return np.sum((n[:, 0] * (p - c)[:, 1] - n[:, 1] * (p - c)[:, 0]) ** 2) / 16**2

        from scipy.optimize import minimize

        turn = minimize(turning, np.zeros(2), tol=1e-10).fun
        assert window.strength == pytest.approx(min(shift, turn), rel=1e-5)
        weakest.add("turn" if turn < shift else "shift")
        part = lines[corner[1] : corner[1] + 64, corner[0] : corner[0] + 64]
        best = -1.0
        for v in range(240 - 63):
            for u in range(320 - 63):
                other = lines[v : v + 64, u : u + 64]
                if np.abs((u, v) - corner).max() > 16:
                    rival = np.corrcoef(part.ravel(), other.ravel())[0, 1] if other.any() else 0.0
                    best = max(best, rival if other.sum() >= 0.1 * part.sum() else 0.0)
        assert window.rival == pytest.approx(best, abs=1e-4)
    assert held_by in weakest


# Bad input ---------------------------------------------------------------------------------------

N = np.zeros((2, 2))


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: PatternRules(samples=4), "samples must be odd"),
        (lambda: PatternRules(picked="best"), "picked must be one of"),
        (lambda: Decay(np.array([0.0]), np.ones(1)), "rate must be positive"),
        (lambda: Decay(np.ones(2), np.ones(3)), "power must be"),
        (lambda: some_pattern(n=0), "places must be of 1 to 1000 points"),
        (lambda: some_pattern(samples=4), "vectors must have an odd number"),
        (lambda: replace(some_pattern(), size=(0, 5)), "size must be positive"),
        (lambda: replace(some_pattern(), decay=Decay(np.ones(3), np.ones(3))), "decay.rate"),
        (lambda: grey_vectors(SMOOTH.astype(float), N, np.zeros(2)), "image must be an array of"),
        (lambda: grey_vectors(SMOOTH, N, np.zeros(3)), "directions must be"),
        (lambda: grey_vectors(SMOOTH, N, np.zeros(2), samples=2), "samples must be"),
        (lambda: autocorrelation(np.zeros(4)), "vectors must be"),
        (lambda: fit_decay(np.ones((3, 2))), "falls must be one at least, of three lags"),
        (lambda: fit_decay(np.ones((3, 4)), "cubic"), "curve must be one of"),
        (lambda: deviations(np.ones(3), Decay(np.ones(2), np.ones(2))), "correlation must be"),
        (lambda: correlations(SMOOTH[None], some_pattern(), poses(0)), "layers must be float32"),
        (
            lambda: correlations(SMOOTH.astype(np.float32), some_pattern(), poses(0)),
            "layers must be",
        ),
        (
            lambda: correlations(SMOOTH[None].astype(np.float32), some_pattern(), -poses(0)),
            "poses must have a positive scale",
        ),
        (
            lambda: correlations(
                SMOOTH[None].astype(np.float32), some_pattern(), poses(0), np.ones(30, int)
            ),
            "chosen must be of 1 layers",
        ),
        (
            lambda: decay_in_picture(SMOOTH, np.ones((1, 2)), np.array([object()])),
            "directions must be real numbers",
        ),
        (lambda: make_pattern(SMOOTH, CENTRE, contours=3), "contours must be a ContourRules"),
        (lambda: WindowRules(size=(7, 64)), "size must be at least 8"),
        (lambda: windows(CLUTTERED, taken=np.zeros(2)), "taken must be"),
        (lambda: interest_windows(CLUTTERED, ()), "edges must be an Edges"),
        (lambda: interest_windows(find_edges(CLUTTERED), (1,)), "contours"),
        (lambda: interest_windows(find_edges(CLUTTERED), (), 3), "rules must be a WindowRules"),
    ],
)
def test_bad_input_is_named(made, said):
    with unchecked(), pytest.raises((ValueError, TypeError), match=said):
        made()


def test_nothing_is_written_to():
    image, where = CLUTTERED.copy(), poses(4)
    image.flags.writeable = where.flags.writeable = False
    pattern = make_pattern(image, CENTRE)
    windows(image, taken=where[:, :2])
    correlations(image[None].astype(np.float32), pattern, where)
