"""Distances and the two nearest classes, against one pair at a time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from robot_perception.landmarks import Euclidean, Mahalanobis, textbook
from tests.landmarks.worlds import descriptors
from tests.unchecked import unchecked


def scene(m, n, d=128, seed=0, spread=12.0):
    """Return descriptors, and the means and variances of classes of which they are."""
    rng = np.random.default_rng(seed)
    means = descriptors(n, rng)[:, :d].astype(float)
    which = rng.integers(max(n, 1), size=m)
    found = np.rint(means[which] + rng.normal(0, spread, (m, d))) if n else np.ones((m, d))
    return found, means, rng.uniform(1 / 12, 400.0, means.shape), which


def brute(found, means, variances=None):
    """Return all squared distances, one after the other."""
    rows = np.empty((len(found), len(means)))
    for i, descriptor in enumerate(found):
        for j, mean in enumerate(means):
            rows[i, j] = (
                textbook.euclidean(descriptor, mean)
                if variances is None
                else textbook.mahalanobis(descriptor, mean, variances[j])
            )
    return rows


def expect_nearest(nearest, squared):
    """Compare with all distances: classes may differ where the distances are equal."""
    two = np.sort(squared, axis=1)[:, :2]
    np.testing.assert_allclose(nearest.distances, two, rtol=1e-12)
    at = np.take_along_axis(squared, nearest.classes, axis=1)
    np.testing.assert_allclose(at, two, rtol=1e-12)
    assert (nearest.classes[:, 0] != nearest.classes[:, 1]).all()


@given(st.integers(1, 20), st.integers(2, 150), st.integers(1, 128), st.integers(0, 99))
@settings(max_examples=25)
def test_products_give_what_one_pair_at_a_time_gives(m, n, d, seed):
    found, means, variances, _ = scene(m, n, d, seed)
    plain, weighted = brute(found, means), brute(found, means, variances)
    np.testing.assert_allclose(Euclidean(means).distances(found), plain, rtol=1e-9, atol=1e-7)
    mahalanobis = Mahalanobis(means, variances)
    np.testing.assert_allclose(mahalanobis.distances(found), weighted, rtol=1e-9, atol=1e-6)
    expect_nearest(Euclidean(means).two_nearest(found), plain)
    expect_nearest(mahalanobis.two_nearest(found), weighted)
    logs = np.log(variances).sum(axis=1)
    whole = Mahalanobis(means, variances, log_determinant=True)
    np.testing.assert_allclose(whole.distances(found), weighted + logs, rtol=1e-9, atol=1e-6)
    expect_nearest(whole.two_nearest(found), weighted + logs)


def test_with_the_log_determinant_it_is_the_likelihood_of_a_normal_class():
    found, means, variances, _ = scene(4, 3, d=5)
    distance = Mahalanobis(means, variances, log_determinant=True).distances(found)
    for j in range(3):
        normal = multivariate_normal(means[j], np.diag(variances[j]))
        constant = 5 * np.log(2 * np.pi)
        np.testing.assert_allclose(distance[:, j], -2 * normal.logpdf(found) - constant, rtol=1e-9)


def test_with_the_log_determinant_a_narrow_class_may_be_nearer_than_zero():
    found, means, variances, _ = scene(20, 30)
    narrow = variances / 4000
    squared = ((found[:, None] - means) ** 2 / narrow).sum(axis=-1) + np.log(narrow).sum(axis=1)
    found[0] = means[3]
    squared[0] = ((means[3] - means) ** 2 / narrow).sum(axis=-1) + np.log(narrow).sum(axis=1)
    with unchecked():
        nearest = Mahalanobis(means, narrow, log_determinant=True).two_nearest(found)
    expect_nearest(nearest, squared)
    assert nearest.distances[0, 0] < 0
    assert nearest.within(0.0)[0] == 3


def test_equal_variances_give_the_order_of_euclid():
    found, means, _, which = scene(50, 80)
    nearest = Mahalanobis(means, np.full(means.shape, 4.0)).two_nearest(found)
    plain = Euclidean(means).two_nearest(found)
    np.testing.assert_array_equal(nearest.classes, plain.classes)
    np.testing.assert_allclose(nearest.distances, plain.distances / 4)
    np.testing.assert_array_equal(plain.classes[:, 0], which)


@pytest.mark.parametrize("offset", [0.0, 2000.0])
def test_the_nearest_are_exact_where_single_precision_cannot_tell(offset):
    """Classes that differ by less than the rounding of a product of single numbers."""
    rng = np.random.default_rng(1)
    base = descriptors(1, rng).astype(float) + offset
    means = base + rng.normal(0, 1e-3, (700, 128))
    found = base + rng.normal(0, 1e-3, (40, 128))
    expect_nearest(Euclidean(means).two_nearest(found), brute(found, means))
    variances = rng.uniform(0.9, 1.1, means.shape) / 12
    nearest = Mahalanobis(means, variances).two_nearest(found)
    expect_nearest(nearest, brute(found, means, variances))
    single = (found.astype(np.float32) @ means.T.astype(np.float32)) * -2
    rounded = single + (means**2).sum(axis=1)
    assert (rounded.argmin(axis=1) != nearest.classes[:, 0]).any()


def test_many_descriptors_are_taken_in_parts():
    found, means, variances, which = scene(900, 300, d=8, spread=0.5)
    nearest = Euclidean(means).two_nearest(found)
    expect_nearest(nearest, ((found[:, None] - means) ** 2).sum(axis=-1))
    expect_nearest(
        Mahalanobis(means, variances).two_nearest(found),
        ((found[:, None] - means) ** 2 / variances).sum(axis=-1),
    )
    assert (nearest.classes[:, 0] == which).mean() > 0.5


def test_of_equal_classes_the_first_is_taken():
    means = np.zeros((130, 4))
    nearest = Euclidean(means).two_nearest(np.ones((1, 4)))
    np.testing.assert_array_equal(nearest.classes, [[0, 1]])
    means[:] = 9
    means[[1, 64]] = 0
    nearest = Euclidean(means).two_nearest(np.ones((1, 4)))
    np.testing.assert_array_equal(nearest.classes, [[1, 64]])


@pytest.mark.parametrize("classes", [0, 1])
def test_fewer_than_two_classes(classes):
    found, means, variances, _ = scene(3, classes)
    for metric in (Euclidean(means), Mahalanobis(means, variances, log_determinant=True)):
        nearest = metric.two_nearest(found)
        np.testing.assert_array_equal(nearest.classes[:, classes:], -1)
        np.testing.assert_array_equal(nearest.distances[:, classes:], np.inf)
        np.testing.assert_array_equal(nearest.classes[:, :classes], 0)
        np.testing.assert_array_equal(nearest.within(np.inf), np.full(3, classes - 1))
        np.testing.assert_array_equal(nearest.within(np.inf, ratio=0.8), np.full(3, classes - 1))
        assert metric.distances(found).shape == (3, classes)
    assert len(Euclidean(means).two_nearest(np.empty((0, 128))).classes) == 0


def test_far_descriptors_are_new_landmarks():
    means = np.array([[0.0, 0.0], [10.0, 0.0]])
    nearest = Euclidean(means).two_nearest(np.array([[3.0, 0.0], [6.0, 0.0], [9.0, 0.0]]))
    np.testing.assert_array_equal(nearest.within(9.0), [0, -1, 1])
    np.testing.assert_array_equal(nearest.within(16.0), [0, 1, 1])
    np.testing.assert_array_equal(nearest.within(8.9), [-1, -1, 1])
    np.testing.assert_array_equal(nearest.within(np.inf, ratio=0.5), [0, -1, 1])  # 3/7, 4/6, 1/9
    np.testing.assert_array_equal(nearest.within(np.inf, ratio=0.4), [-1, -1, 1])


def test_nothing_given_is_changed():
    found, means, variances, _ = scene(5, 7)
    copies = [array.copy() for array in (found, means, variances)]
    Mahalanobis(means, variances).two_nearest(found)
    Euclidean(means).two_nearest(found)
    for array, old in zip((found, means, variances), copies, strict=True):
        np.testing.assert_array_equal(array, old)


def test_wrong_classes_and_descriptors_are_named():
    found, means, variances, _ = scene(5, 7)
    with unchecked():
        with pytest.raises(ValueError, match="variances must be positive, got 0"):
            Mahalanobis(means, np.zeros_like(means))
        with pytest.raises(ValueError, match=r"variances must be \(7, 128\)"):
            Mahalanobis(means, variances[:6])
        with pytest.raises(ValueError, match=r"descriptors must be \(m, 128\), got \(5, 64\)"):
            Euclidean(means).two_nearest(found[:, :64])
        with pytest.raises(ValueError, match="descriptors and means must fit single precision"):
            Euclidean(means).two_nearest(1e30 * found)
        with pytest.raises(ValueError, match="descriptors and means must fit single precision"):
            Mahalanobis(means, 1e-44 * variances).two_nearest(found)
        with pytest.raises(ValueError, match="means must be finite, got"):
            Euclidean(np.where(means == means[6], np.nan, means))
        with pytest.raises(ValueError, match="descriptors must be finite, got"):
            Euclidean(means).two_nearest(np.where(found == found[4], np.inf, found))
        with pytest.raises(TypeError, match="log_determinant must be True or False"):
            Mahalanobis(means, variances, log_determinant=1)
