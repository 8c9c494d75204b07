"""Line fits against finite differences, an eigenvector fit and Monte Carlo; scans by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from jaxtyping import TypeCheckError
from scipy import stats

from robot_perception.evaluation.consistency import average_bounds, normalised_squared
from robot_perception.walls import (
    Extraction,
    RangeNoise,
    extract_segments,
    find_breaks,
    fit_line,
    is_simple,
    project,
    to_points,
)
from tests.unchecked import unchecked

NOISE = RangeNoise(0.02, np.deg2rad(0.1))


def ranges_to_line(rho, theta, angles):
    return rho / np.cos(angles - theta)


@pytest.mark.parametrize(
    ("rho", "theta"), [(2.0, 0.3), (4.0, -1.2), (1.0, 1.5), (3, 0), (2, 2.9), (2, -2.9)]
)
def test_exact_readings_give_the_line(rho, theta):
    angles = theta + np.linspace(-0.5, 0.6, 40)
    line = fit_line(ranges_to_line(rho, theta, angles), angles, NOISE)
    np.testing.assert_allclose(line.mean, [rho, theta], atol=1e-12)


@given(st.integers(0, 10**6))
def test_fit_is_the_eigenvector_of_least_spread(seed):
    rng = np.random.default_rng(seed)
    theta, angles = rng.uniform(-3, 3), np.linspace(-0.6, 0.4, 25)
    ranges = ranges_to_line(rng.uniform(1, 6), 0.0, angles) + rng.normal(0, 0.03, 25)
    line = fit_line(ranges, angles + theta, NOISE)
    points = to_points(ranges, angles + theta)
    normal = np.linalg.eigh(np.cov(points.T))[1][:, 0]
    along = normal @ [np.cos(line.mean[1]), np.sin(line.mean[1])]
    assert abs(along) == pytest.approx(1.0)
    assert line.mean[0] == pytest.approx(abs(points.mean(axis=0) @ normal))
    assert line.mean[0] >= 0


@pytest.mark.parametrize("theta", [0.2, 2.9, -2.0])
def test_covariance_is_the_jacobian_by_finite_differences(theta):
    rng = np.random.default_rng(3)
    angles = theta + np.linspace(-0.7, 0.5, 30)
    ranges = ranges_to_line(2.5, theta, angles) + rng.normal(0, 0.02, 30)
    h, cov = 1e-6, np.zeros((2, 2))
    for k in range(30):
        for sigma, in_range in ((NOISE.range_sigma, True), (NOISE.bearing_sigma, False)):
            step = np.zeros(30)
            step[k] = h
            plus, minus = (
                fit_line(ranges + s * step * in_range, angles + s * step * (not in_range), NOISE)
                for s in (1, -1)
            )
            column = (plus.mean - minus.mean) / (2 * h)
            cov += sigma**2 * np.outer(column, column)
    np.testing.assert_allclose(fit_line(ranges, angles, NOISE).cov, cov, rtol=1e-5)


def test_covariance_is_consistent_with_monte_carlo():
    rng, runs = np.random.default_rng(0), 4000
    truth = np.array([2.0, 0.4])
    angles = truth[1] + np.linspace(-0.9, 0.6, 60)
    aimed = angles + rng.normal(0, NOISE.bearing_sigma, (runs, 60))  # where the beams really went
    ranges = ranges_to_line(*truth, aimed) + rng.normal(0, NOISE.range_sigma, (runs, 60))
    fits = fit_line(ranges, angles, NOISE)
    low, high = average_bounds(2, runs, 0.999)
    assert low < normalised_squared(fits.mean - truth, fits.cov).mean() < high
    assert np.abs(fits.mean.mean(axis=0) - truth).max() < 1e-3


def test_batch_of_fits_equals_the_loop():
    rng = np.random.default_rng(0)
    angles = np.linspace(-0.3, 0.4, 20)
    ranges = ranges_to_line(3.0, 0.1, angles) + rng.normal(0, 0.02, (5, 20))
    batch = fit_line(ranges, angles, NOISE)
    for k in range(5):
        one = fit_line(ranges[k], angles, NOISE)
        np.testing.assert_allclose(batch.mean[k], one.mean, rtol=1e-12)
        np.testing.assert_allclose(batch.cov[k], one.cov, rtol=1e-9)


def test_fit_refuses_what_has_no_line():
    angles = np.array([0.1, 0.1])
    with pytest.raises(ValueError, match="no line through them"):
        fit_line(np.array([2.0, 2.0]), angles, NOISE)
    with pytest.raises(ValueError, match="at least two readings, got 1"):
        fit_line(np.array([2.0]), np.array([0.0]), NOISE)
    with pytest.raises(ValueError, match="1 are not"):
        fit_line(np.array([2.0, np.inf]), np.array([0.0, 0.1]), NOISE)


def test_breaks_separate_a_step_but_not_a_slanted_wall():
    angles = np.deg2rad(np.arange(-45, 46, 0.5))
    wall = ranges_to_line(2.0, np.deg2rad(30), angles)  # seen under 15° at the far end
    assert not find_breaks(wall, angles, NOISE, np.deg2rad(10)).any()
    box = np.where(np.abs(angles) < 0.2, 1.0, wall)
    breaks = find_breaks(box, angles, NOISE, np.deg2rad(10))
    assert breaks.sum() == 2
    wide = np.deg2rad(np.array([0.0, 20.0]))  # two readings farther apart than the grazing angle
    assert find_breaks(np.array([1.0, 1.0]), wide, NOISE, np.deg2rad(10)).all()


@pytest.mark.parametrize("grazing_deg", [8.0, 15.0, 40.0])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_wall_breaks_where_it_is_seen_at_less_than_the_grazing_angle(grazing_deg, sign):
    """The nearer of two readings and the grazing angle say where the farther may lie."""
    angles, exact = np.deg2rad([0.0, 1.0]), RangeNoise(1e-9)
    for share in (0.99, 1.01):
        tilt = np.deg2rad(grazing_deg) * share  # of the wall against the nearer reading's beam
        farther = np.sin(tilt) / np.sin(tilt - angles[1])
        gaps = find_breaks(
            2.0 * np.array([1.0, farther])[::sign], angles, exact, np.deg2rad(grazing_deg)
        )
        assert gaps.tolist() == [share < 1]


def test_breaks_leave_three_deviations_to_the_noise():
    angles = np.array([0.0, 1e-9])
    for jump in (0.055, 0.065):
        ranges = np.array([2.0, 2.0 + jump])
        assert find_breaks(ranges, angles, RangeNoise(0.02), 0.2).tolist() == [jump > 0.06]


@pytest.mark.parametrize(("height", "walls"), [(0.07, 1), (0.09, 2)])
def test_a_wall_bent_by_more_than_the_tolerance_is_two(height, walls):
    angles = np.deg2rad(np.arange(-40, 40.5, 0.5))
    slope = np.sign(angles) * height / (2 * np.tan(angles[-1]))  # of each half against the chord
    ranges = 2.0 / (np.cos(angles) + slope * np.sin(angles))
    assert len(extract_segments(ranges, angles, Extraction(tolerance=0.08))[0]) == walls


def test_as_many_readings_as_asked_for_make_a_wall():
    angles = np.deg2rad(np.arange(-90, 91, 5.0))
    for readings in (5, 6):
        ranges = np.full(37, np.inf)
        ranges[10 : 10 + readings] = ranges_to_line(3.0, -0.3, angles[10 : 10 + readings])
        segments, report = extract_segments(ranges, angles, Extraction(grazing=np.deg2rad(20)))
        assert (len(segments), report.lone) == ((0, 5) if readings == 5 else (1, 0))
        assert report.stretches == 1


def test_readings_are_in_a_wall_dropped_or_corners():
    """Law: between two walls, one reading is the corner and counted to neither."""
    angles = np.deg2rad(np.arange(-60, 61, 0.5))
    near = ranges_to_line(2.0, -0.5, angles), ranges_to_line(3.0, 0.9, angles)
    ranges = np.min([np.where(r > 0, r, np.inf) for r in near], axis=0)
    segments, report = extract_segments(ranges, angles, Extraction())
    first, second = segments.spans.tolist()
    assert (first[0], second[1], second[0] - first[1]) == (0, angles.size - 1, 2)
    short = Extraction(least_length=1.5 * segments.lengths.min())
    kept, told = extract_segments(ranges, angles, short)
    (start, stop), (left,) = sorted(segments.spans[segments.lengths.argmin()]), kept.spans.tolist()
    assert left in segments.spans.tolist()
    assert (told.dropped, report.dropped) == (stop - start + 1, 0)


def test_corner_of_a_room_gives_its_two_walls_with_right_uncertainty():
    rng = np.random.default_rng(5)
    angles = np.deg2rad(np.arange(-60, 61, 0.5))
    truths = np.array([[2.0, -0.5], [3.0, 0.9]])
    errors, covs = [], []
    for _ in range(150):
        both = np.abs(np.stack([ranges_to_line(*t, angles) for t in truths]))
        facing = np.stack([np.cos(angles - t[1]) > 0.05 for t in truths])
        ranges = np.where(facing, both, np.inf).min(axis=0)
        ranges = ranges + rng.normal(0, 0.02, angles.size)
        segments, report = extract_segments(
            ranges, angles, Extraction(RangeNoise(0.02), tolerance=0.12)
        )
        assert len(segments) == 2
        assert report.no_return == 0
        errors.append(segments.lines - truths)
        covs.append(segments.covs)
    nees = normalised_squared(np.array(errors), np.array(covs)).ravel()
    # reading the corner itself costs a little consistency: the tail may be heavier than χ²
    assert np.mean(nees < stats.chi2.ppf(0.95, 2)) > 0.85
    assert np.median(nees) < 2 * stats.chi2.ppf(0.5, 2)


def test_ends_lie_on_the_line_and_spans_name_the_readings():
    angles = np.deg2rad(np.arange(-40, 41, 1.0))
    ranges = ranges_to_line(3.0, 0.2, angles)
    ranges[:10] = np.inf
    segments, report = extract_segments(ranges, angles, Extraction())
    assert segments.spans.tolist() == [[10, 80]]
    np.testing.assert_allclose(
        segments.ends, to_points(ranges[[10, 80]], angles[[10, 80]])[None], atol=1e-9
    )
    np.testing.assert_allclose(project(segments.lines, segments.ends), segments.ends, atol=1e-12)
    assert report.no_return == 10
    assert segments.lengths[0] > 3


@pytest.mark.parametrize("readings", [0, 1, 2, 5])
def test_few_readings_are_a_counted_skip(readings):
    angles = np.linspace(-0.1, 0.1, readings)
    segments, report = extract_segments(np.full(readings, 2.0), angles, Extraction())
    assert len(segments) == 0
    assert report.readings == readings
    assert report.lone + report.dropped == readings


@given(
    arrays(np.float64, 40, elements=st.floats(width=64, allow_nan=True, allow_infinity=True)),
)
def test_every_hostile_reading_is_accounted_for(ranges):
    ranges = np.where(np.abs(ranges) > 1e6, np.inf, ranges)
    angles = np.linspace(-1.5, 1.5, 40)
    segments, report = extract_segments(ranges, angles, Extraction())
    skipped = report.no_return + report.not_a_number + report.not_positive
    assert skipped == np.count_nonzero(~((ranges > 0) & np.isfinite(ranges)))
    assert np.isfinite(segments.lines).all()
    assert np.isfinite(segments.covs).all()


def test_readings_of_every_kind_are_counted():
    ranges = np.full(50, 2.0)
    ranges[3], ranges[4], ranges[10], ranges[20], ranges[30] = np.inf, -np.inf, np.nan, 0.0, -1.0
    _, report = extract_segments(ranges, np.linspace(-0.5, 0.5, 50), Extraction())
    assert (report.no_return, report.not_a_number, report.not_positive) == (2, 1, 2)
    assert (report + report).readings == 100


@given(st.integers(0, 10**6))
def test_stretches_of_one_scan_are_simple_chains(seed):
    rng = np.random.default_rng(seed)
    angles = np.linspace(-np.pi / 2, np.pi / 2, 181)
    assert is_simple(to_points(rng.uniform(0.2, 8, 181), angles))


def test_bad_angles_are_an_error():
    with pytest.raises((ValueError, TypeCheckError)):
        extract_segments(np.ones(5), np.zeros(4), Extraction())
    with pytest.raises(ValueError, match="strictly increasing"):
        extract_segments(np.ones(5), np.zeros(5), Extraction())
    with pytest.raises(ValueError, match="more than one turn"):
        extract_segments(np.ones(5), np.linspace(0, 7, 5), Extraction())


@pytest.mark.parametrize(
    "make",
    [
        lambda: RangeNoise(0.0),
        lambda: RangeNoise(0.01, -1.0),
        lambda: Extraction(tolerance=np.nan),
        lambda: Extraction(grazing=2.0),
        lambda: Extraction(least_readings=2),
        lambda: Extraction(least_length=0.0),
    ],
)
def test_settings_are_validated(make):
    with pytest.raises(ValueError, match=r"must (not )?be"):
        make()


def test_settings_of_a_wrong_type_are_named():
    with unchecked():
        with pytest.raises(ValueError, match="least_readings must be a whole number, got nan"):
            Extraction(least_readings=np.nan)
        with pytest.raises(TypeError, match=r"noise must be a RangeNoise, got 0\.02"):
            Extraction(noise=0.02)
