"""What a filter asks of descriptors: four distances, against SciPy and NumPy one pair at a time."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import mahalanobis as pair
from scipy.stats import chi2

from robot_perception.landmarks import metrics
from tests.unchecked import unchecked

seeds = st.integers(0, 10**6)


@dataclass
class Looks:
    """What is kept of some stacks of descriptors, by NumPy."""

    firsts: np.ndarray
    means: np.ndarray
    squares: np.ndarray
    counts: np.ndarray


@dataclass
class Asked:
    """Newcomers and landmarks; no class of the library."""

    descriptors: np.ndarray
    looks: Looks


def stacks_of(rng, sizes, d=8, spread=9.0):
    """Return whole numbers, as descriptors are, of landmarks that were seen so often."""
    return [np.rint(rng.uniform(0, 255, d) + rng.normal(0, spread, (p, d))) for p in sizes]


def asked(new, stacks):
    looks = Looks(
        np.array([stack[0] for stack in stacks]),
        np.array([stack.mean(axis=0) for stack in stacks]),
        np.array([stack.var(axis=0) * len(stack) for stack in stacks]),
        np.array([len(stack) for stack in stacks]),
    )
    return Asked(np.array([stack.mean(axis=0) for stack in new]), looks)


def each_pair(question, distance):
    """Return a distance of each newcomer to each landmark."""
    count = len(question.looks.counts)
    return [[distance(d, i) for i in range(count)] for d in question.descriptors]


@given(seed=seeds, sizes=st.lists(st.integers(2, 7), min_size=1, max_size=6))
@settings(max_examples=25)
def test_raw_is_scipys_mahalanobis_distance_with_a_diagonal(seed, sizes):
    """Variances over p - 1, and none below the 1/12 of rounding."""
    rng = np.random.default_rng(seed)
    stacks = stacks_of(rng, sizes, spread=rng.uniform(0, 20))
    question = asked(stacks_of(rng, [6] * 3), stacks)
    inverses = [np.diag(1 / np.maximum(s.var(axis=0, ddof=1), 1 / 12)) for s in stacks]
    expected = each_pair(question, lambda d, i: pair(d, question.looks.means[i], inverses[i]))
    np.testing.assert_allclose(metrics.mahalanobis(question), expected, rtol=1e-9, atol=1e-5)


@given(seed=seeds, strength=st.floats(0.1, 1e3), sizes=st.lists(st.integers(1, 7), max_size=5))
@settings(max_examples=25)
def test_shrunk_lies_between_raw_and_pooled(seed, strength, sizes):
    rng = np.random.default_rng(seed)
    sizes = [4, *sizes]
    stacks = stacks_of(rng, sizes, spread=5.0)
    question = asked(stacks_of(rng, [6] * 3), stacks)
    freedom = np.array(sizes)[:, None] - 1
    own = np.array([s.var(axis=0) * len(s) for s in stacks])
    pooled = np.maximum(own.sum(axis=0) / freedom.sum(), 1 / 12)
    variances = np.maximum((own + strength * pooled) / (freedom + strength), 1 / 12)
    expected = each_pair(
        question, lambda d, i: pair(d, question.looks.means[i], np.diag(1 / variances[i]))
    )
    found = metrics.mahalanobis_shrunk(question, strength)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-5)
    if min(sizes) > 1:
        little = metrics.mahalanobis_shrunk(question, 1e-9)
        np.testing.assert_allclose(little, metrics.mahalanobis(question), rtol=1e-5)


@given(seeds)
@settings(max_examples=10)
def test_euclid_is_the_length_of_the_difference_to_mean_or_first(seed):
    rng = np.random.default_rng(seed)
    question = asked(stacks_of(rng, [6] * 3), stacks_of(rng, [1, 5, 3]))
    for metric, landmarks in (
        (metrics.euclidean_mean, question.looks.means),
        (metrics.euclidean_first, question.looks.firsts),
    ):
        expected = each_pair(question, lambda d, i, own=landmarks: np.linalg.norm(d - own[i]))
        np.testing.assert_allclose(metric(question), expected, rtol=1e-9, atol=1e-5)


def test_of_known_variances_it_is_chi_squared_as_the_limit_is_said_to_be():
    """Means of p descriptors each: L = 2/p χ², by classes of so many that variances are known."""
    rng = np.random.default_rng(0)
    p, d, n = 6, 128, 300
    means, sigma = rng.uniform(0, 255, d), rng.uniform(5, 30, d)
    classes = means + sigma / np.sqrt(p) * rng.standard_normal((n, d))
    looks = Looks(classes, classes, np.tile(10**6 * sigma**2, (n, 1)), np.full(n, 10**6 + 1))
    new = means + sigma / np.sqrt(p) * rng.standard_normal((n, d))
    squared = np.diag(metrics.mahalanobis(Asked(new, looks))) ** 2
    passed = np.mean(squared <= 2 / p * chi2.ppf(0.9, d))
    assert passed == pytest.approx(0.9, abs=4 * np.sqrt(0.09 / n))


def test_without_landmarks_or_newcomers_the_table_is_empty():
    some = asked(
        stacks_of(np.random.default_rng(0), [3] * 2), stacks_of(np.random.default_rng(1), [3])
    )
    none = replace(some, descriptors=np.empty((0, 8)))
    assert {metric(none).shape for metric in metrics.METRICS.values()} == {(0, 1)}


@pytest.mark.parametrize(
    ("metric", "change", "message"),
    [
        (metrics.mahalanobis, {"counts": np.array([1])}, "classes must have two descriptors or"),
        (metrics.mahalanobis_shrunk, {"counts": np.array([1])}, "two descriptors somewhere"),
        (metrics.mahalanobis, {"squares": -np.ones((1, 8))}, "squares must not be negative"),
        (metrics.euclidean_first, {"firsts": np.ones((1, 9))}, r"descriptors must be \(m, 9\)"),
        (metrics.euclidean_mean, {"means": np.full((1, 8), np.nan)}, "means must be finite"),
    ],
)
def test_what_is_wrong_is_said(metric, change, message):
    rng = np.random.default_rng(0)
    question = asked(stacks_of(rng, [3] * 2), stacks_of(rng, [3]))
    question.looks = replace(question.looks, **change)
    with unchecked(), pytest.raises(ValueError, match=message):
        metric(question)


def test_what_is_no_question_is_refused():
    question = asked(stacks_of(np.random.default_rng(0), [3]), [np.ones((2, 8))])
    with unchecked():
        with pytest.raises(TypeError, match="asked must be"):
            metrics.mahalanobis(np.ones((3, 8)))
        with pytest.raises(TypeError, match=r"asked\.looks must be"):
            metrics.euclidean_mean(replace(question, looks=None))
        with pytest.raises(ValueError, match="strength must be positive"):
            metrics.mahalanobis_shrunk(question, 0.0)
