"""The page's filters against the library, SciPy and least squares; laws of what it finds."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from robot_perception import kalman
from robot_perception.beliefs import Gaussian
from robot_perception.book import many_numbers as page
from robot_perception.chapters.many_numbers import figures
from robot_perception.evaluation import consistency
from tests.chapters.exercises import assert_judged, assert_told

seeds = st.integers(0, 2**32 - 1)


def belief(seed, n=3):
    """Return a mean and a covariance."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    return rng.standard_normal(n), A @ A.T + 0.05 * np.eye(n)


def by_differences(f, at, h=1e-6):
    """Return the derivatives of f, a column each."""
    return np.array([(f(at + d) - f(at - d)) / (2 * h) for d in h * np.eye(len(at))]).T


# Ellipses and updates ----------------------------------------------------------------------------


@given(st.floats(0.001, 0.999))
def test_an_ellipse_reaches_as_far_as_chi_squared_says(share):
    assert page.reach(share) ** 2 == pytest.approx(chi2.ppf(share, 2))


def test_drawings_reach_as_far_as_they_say():
    assert pytest.approx(page.reach(0.95), abs=1e-4) == figures.REACH
    assert pytest.approx(chi2.ppf(0.95, 1) ** 0.5, abs=1e-3) == figures.SIDE


@given(seeds)
def test_squared_distances_are_the_librarys(seed):
    _, P = belief(seed)
    errors = np.random.default_rng(seed).standard_normal((4, 3))
    assert page.squared_distance(errors, P) == pytest.approx(
        consistency.normalised_squared(errors, P), rel=1e-6
    )


@given(seeds)
@settings(max_examples=30)
def test_an_update_is_the_librarys_and_filterpys(seed):
    x, P = belief(seed)
    rng = np.random.default_rng(seed)
    H, z, R = rng.standard_normal((2, 3)), rng.standard_normal(2), 0.3 * np.eye(2)
    mean, cov = page.update(x, P, z, H, R)
    ours, _ = kalman.update(Gaussian(x, P), z, kalman.Sensor(H, R))
    theirs = KalmanFilter(dim_x=3, dim_z=2)
    theirs.x, theirs.P, theirs.H, theirs.R = x[:, None], P, H, R
    theirs.update(z)
    for other_mean, other_cov in ((ours.mean, ours.cov), (theirs.x[:, 0], theirs.P)):
        assert np.allclose(mean, other_mean)
        assert np.allclose(cov, other_cov)


@given(seeds)
def test_without_correlation_nothing_is_carried(seed):
    x, P = belief(seed, 2)
    mean, cov = page.update(x, np.diag(np.diag(P)), np.array([2.0]), page.TELLS, np.eye(1))
    assert mean[1] == x[1]
    assert cov[1, 1] == P[1, 1]


# A map that grows --------------------------------------------------------------------------------


@given(seeds)
def test_a_landmark_that_joins_is_one_that_was_unknown(seed):
    x, P = belief(seed)
    mean, cov = page.add(x, P, 1.5, 0.2)
    vague = np.diag(np.append(np.zeros(3), 1e8))
    vague[:3, :3] = P
    H = np.array([[-1.0, 0.0, 0.0, 1.0]])
    other, its = page.update(np.append(x, 0.0), vague, np.array([1.5]), H, np.array([[0.2]]))
    assert np.allclose(mean, other, atol=1e-5)
    assert np.allclose(cov, its, atol=1e-5)


def test_the_map_is_that_of_least_squares():
    rng = np.random.default_rng(3)
    x, P = np.zeros(1), np.array([[0.04]])
    rows, values, weights = [[1.0, 0.0, 0.0]], [0.0], [1 / 0.2]
    for landmark, z in zip((1, 2, 1, 2, 1), rng.normal(2.0, 0.1, 5), strict=True):
        known = landmark < len(x)
        x, P = page.see(x, P, z, landmark, 0.01) if known else page.add(x, P, z, 0.01)
        rows.append((np.eye(3)[landmark] - np.eye(3)[0]).tolist())
        values.append(z)
        weights.append(1 / 0.1)
    A, b = np.array(rows) * np.c_[weights], np.array(values) * weights
    assert np.allclose(x, np.linalg.lstsq(A, b)[0])
    assert np.allclose(P, np.linalg.inv(A.T @ A))


def test_laps_are_honest_with_correlations_and_overconfident_without():
    averages = {}
    for kept in (True, False):
        found = []
        for rng in np.random.default_rng(11).spawn(150):
            *_, (place, known, x, P) = page.lap(rng, kept)
            error = x - np.append(place, page.POSTS[list(known)])
            found.append(consistency.normalised_squared(error, P))
        averages[kept] = np.mean(found)
    low, high = consistency.average_bounds(1 + len(page.POSTS), 150, 0.999)
    assert low < averages[True] < high
    assert averages[False] > 2 * high


def test_most_drives_are_like_the_one_that_is_shown():
    missed = [
        page.mapped(page.STEPS, name).outside / (1 + len(page.POSTS)) for name in page.FILTERS
    ]
    assert missed == pytest.approx([page.misses(name) for name in page.FILTERS], abs=0.12)


# Poses, ranks, honesty ---------------------------------------------------------------------------


@given(st.floats(-3, 3), st.floats(0.1, 5), st.floats(-2, 2))
def test_a_pose_is_driven_by_its_jacobians(heading, step, turn):
    pose, (P, Q) = np.array([1.0, 2.0, heading]), (belief(1)[1], belief(2, 2)[1])
    F = by_differences(lambda p: page.drive(p, P, step, turn, Q)[0], pose)
    G = by_differences(lambda u: page.drive(pose, P, *u, Q)[0], np.array([step, turn]))
    assert np.allclose(page.drive(pose, P, step, turn, Q)[1], F @ P @ F.T + G @ Q @ G.T, atol=1e-5)


@pytest.mark.parametrize("kind", page.ERRORS)
@given(st.floats(0, 10), st.floats(0, 1.5))
def test_rows_are_the_derivatives_of_what_is_measured(kind, x, y):
    def measured(place):
        apart = page.LAMPS - place
        angles = np.arctan2(apart[:, 1], apart[:, 0])
        return np.linalg.norm(apart, axis=1) if kind == "distance" else angles

    place = np.array([x, y])
    assert np.allclose(
        page.rows(place, page.LAMPS, kind), by_differences(measured, place), atol=1e-6
    )


@given(st.floats(0, 10), st.floats(0, 1.5))
def test_information_is_the_inverse_of_an_updates_covariance(x, y):
    place = np.array([x, y])
    H = page.rows(place, page.LAMPS, "distance")
    _, P = page.update(place, 1e8 * np.eye(2), np.zeros(2), H, 0.2**2 * np.eye(2))
    Y = page.information(place, page.LAMPS, "distance", 0.2)
    assert np.allclose(np.linalg.inv(P), Y, rtol=1e-3, atol=1e-3)


def test_in_line_with_the_lamps_the_rank_is_one():
    assert page.survey(5.0, 2.0, "distance", "two").rank == 1
    assert page.survey(5.0, 2.001, "distance", "two").rank == 2


def test_gates_refuse_one_in_a_hundred_of_an_honest_filter():
    refused = page.FOLLOWED[1.0][:, 1] > chi2.ppf(0.99, 1)
    assert refused.mean() == pytest.approx(0.01, abs=0.005)


# Exercises ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "right"),
    [
        ("numbers-carry", page.of_one),
        ("numbers-join", lambda P, r: np.block([[P, P[:1].T], [P[:1], P[:1, :1] + r]])),
        ("numbers-honest", lambda e, P: np.mean([one @ np.linalg.solve(P, one) for one in e])),
        ("numbers-glance", page.sharpest),
        ("numbers-glance", lambda P, R: 1 + np.argmax(P[0, 0] + np.diag(P)[1:] - 2 * P[0, 1:])),
    ],
)
def test_answers_are_judged(key, right):
    assert_judged(page.EXERCISES[key], right)


@pytest.mark.parametrize(
    ("key", "wrong", "said"),
    [
        ("numbers-carry", lambda x, P, z, r: x + P[:, 0] * (z - x[0]) / P[0, 0], "of its own"),
        ("numbers-carry", lambda x, P, z, r: x + P[:, 0] * (z - x) / (P[0, 0] + r), "one innov"),
        ("numbers-join", lambda P, r: page.joined(P, 0.0), "variance r"),
        ("numbers-honest", lambda e, P: page.nees_of(e, P) / 3, "dimension"),
        ("numbers-honest", lambda e, P: page.nees_of(e, P) * len(e), "the mean"),
        ("numbers-glance", lambda P, R: len(P) - 1, "just seen"),
        ("numbers-glance", lambda P, R: 1, "to begin with"),
        ("numbers-glance", lambda P, R: 4, "Which variances"),
    ],
)
def test_typical_mistakes_are_told_apart(key, wrong, said):
    assert_told(page.EXERCISES[key], wrong, said)
