"""Classes of descriptors: increments against NumPy, and what each variance makes of few."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.landmarks import (
    DescriptorClasses,
    floored_variances,
    pooled_variances,
    raw_variances,
    shrunk_variances,
)
from tests.landmarks.worlds import descriptors
from tests.unchecked import unchecked

ROUNDING = 1 / 12


def samples(counts, seed=0):
    """Return descriptors in random order, and the class of each; first the first of each."""
    rng = np.random.default_rng(seed)
    rows = np.repeat(np.arange(len(counts)), np.asarray(counts) - 1)
    rng.shuffle(rows)
    rows = np.concatenate([np.arange(len(counts)), rows])
    means = descriptors(len(counts), rng)
    return np.rint(means[rows] + rng.normal(0, 15, (len(rows), 128))), rows


def built(counts, batches=4, seed=0):
    found, rows = samples(counts, seed)
    n = len(counts)
    classes = DescriptorClasses.of(found[:n])
    for part in np.array_split(np.arange(n, len(rows)), batches):
        classes = classes.updated(rows[part], found[part])
    return classes, found, rows


@given(st.lists(st.integers(1, 9), min_size=1, max_size=6), st.integers(1, 5), st.integers(0, 99))
@settings(max_examples=30)
def test_increments_add_up_to_mean_and_variance(counts, batches, seed):
    classes, found, rows = built(counts, batches, seed)
    np.testing.assert_array_equal(classes.counts, counts)
    for i, count in enumerate(counts):
        mine = found[rows == i]
        np.testing.assert_allclose(classes.means[i], mine.mean(axis=0), rtol=1e-12, atol=1e-10)
        np.testing.assert_allclose(classes.squares[i], mine.var(axis=0) * count, atol=1e-7)


def test_increments_keep_their_digits_far_from_zero():
    """Sums of squares, the other way to do it, would have lost all of them."""
    rng = np.random.default_rng(0)
    found = 1e9 + rng.normal(size=(1000, 3))
    classes = DescriptorClasses.of(found[:1]).updated(np.zeros(999, dtype=int), found[1:])
    np.testing.assert_allclose(raw_variances(classes)[0], found.var(axis=0, ddof=1), rtol=1e-6)


def test_merged_classes_are_those_of_all_descriptors():
    classes, found, rows = built([3, 5, 2, 4])
    merged = classes[:2].merged(np.array([1, 1]), classes[2:])
    np.testing.assert_array_equal(merged.counts, [3, 11])
    mine = found[rows >= 1]
    np.testing.assert_allclose(merged.means[1], mine.mean(axis=0))
    np.testing.assert_allclose(merged.squares[1], mine.var(axis=0) * 11)
    np.testing.assert_array_equal(merged.means[0], classes.means[0])


def test_nothing_given_is_changed():
    classes, *_ = built([2, 3])
    before = [array.copy() for array in (classes.means, classes.squares, classes.counts)]
    first = np.ones((2, 128))
    made = DescriptorClasses.of(first)
    classes.merged(np.array([0, 1]), made).updated(np.array([1, 1]), first)
    for array, old in zip((classes.means, classes.squares, classes.counts), before, strict=True):
        np.testing.assert_array_equal(array, old)
    first[:] = 7
    assert made.means.max() == 1


def test_some_of_the_classes_and_others_after_them():
    classes, *_ = built([2, 3, 4])
    both = classes[np.array([2, 0])].with_others(classes[1:2])
    np.testing.assert_array_equal(both.counts, [4, 2, 3])
    np.testing.assert_array_equal(both.squares, classes.squares[[2, 0, 1]])
    assert len(both) == 3


# ---- variances -----------------------------------------------------------------------------------


def test_raw_variances_are_those_of_the_descriptors():
    classes, found, rows = built([2, 6, 30])
    raw = raw_variances(classes)
    for i in range(3):
        own = found[rows == i].var(axis=0, ddof=1)
        np.testing.assert_allclose(raw[i], np.maximum(own, ROUNDING), rtol=1e-9)
    assert (raw >= ROUNDING).all()


def test_a_floor_lifts_what_lies_below_it_alone():
    classes, *_ = built([2, 6, 30])
    raw, floored = raw_variances(classes), floored_variances(classes, 100.0)
    np.testing.assert_array_equal(floored, np.maximum(raw, 100.0))
    assert (raw < 100).any()


def test_the_pooled_variance_is_about_the_means_of_the_classes():
    classes, found, rows = built([1, 6, 30])
    means = np.stack([found[rows == i].mean(axis=0) for i in range(3)])
    expected = ((found - means[rows]) ** 2).sum(axis=0) / (37 - 3)
    np.testing.assert_allclose(pooled_variances(classes), np.tile(expected, (3, 1)), rtol=1e-9)


def test_shrinking_lies_between_raw_and_pooled_by_the_share_of_freedom():
    classes, *_ = built([1, 2, 21])
    pooled, shrunk = pooled_variances(classes), shrunk_variances(classes, 5.0)
    np.testing.assert_allclose(shrunk[0], pooled[0])
    own = classes.squares[1:] / (classes.counts[1:, None] - 1)
    weight = np.array([[1 / 6], [20 / 25]])
    np.testing.assert_allclose(shrunk[1:], weight * own + (1 - weight) * pooled[1:], rtol=1e-9)
    np.testing.assert_allclose(shrunk_variances(classes, 1e12), pooled, rtol=1e-9)


def test_shrinking_is_the_better_estimate_where_variances_differ_a_little():
    """The reason to shrink: at six descriptors its error, as a ratio, is half the raw one's."""
    rng = np.random.default_rng(0)
    true = 200 * rng.gamma(10, 0.1, (300, 128))
    found = rng.normal(0, np.sqrt(true), (6, 300, 128))
    classes = DescriptorClasses.of(found[0])
    for more in found[1:]:
        classes = classes.updated(np.arange(300), more)

    def error(variances):
        return np.sqrt(np.mean(np.log(variances / true) ** 2))

    assert error(shrunk_variances(classes, 10.0)) < 0.6 * error(raw_variances(classes))
    assert error(shrunk_variances(classes, 10.0)) < error(pooled_variances(classes))


def test_descriptors_that_never_change_still_have_the_variance_of_rounding():
    same = np.ones((2, 128))
    classes = DescriptorClasses.of(same).updated(np.array([0, 1]), same)
    for variances in (
        raw_variances(classes),
        pooled_variances(classes),
        shrunk_variances(classes, 1.0),
    ):
        np.testing.assert_array_equal(variances, np.full((2, 128), ROUNDING))


def test_one_descriptor_has_no_variance():
    classes, *_ = built([1, 1, 5])
    for variances in (raw_variances, lambda c: floored_variances(c, 1.0)):
        with pytest.raises(ValueError, match="two descriptors or more, got 2 of 3 with one"):
            variances(classes)
    lone = classes[:2]
    for variances in (pooled_variances, lambda c: shrunk_variances(c, 1.0)):
        with pytest.raises(ValueError, match="two descriptors somewhere, got 2 with one"):
            variances(lone)
    with pytest.raises(ValueError, match="least must be at least 1/12"):
        floored_variances(classes, 0.05)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"squares": -np.ones((2, 128))}, "squares must not be negative"),
        ({"squares": np.ones((1, 128))}, "squares must be"),
        ({"counts": np.array([0, 1])}, "counts must be at least 1, got 0"),
        ({"counts": np.array([1.5, 1])}, "counts must be integers"),
        ({"means": np.full((2, 128), np.nan)}, "means must be finite"),
    ],
)
def test_bad_classes_are_refused(change, message):
    good = {
        "means": np.ones((2, 128)),
        "squares": np.ones((2, 128)),
        "counts": np.array([1, 2]),
    }
    with unchecked(), pytest.raises(ValueError, match=message):
        DescriptorClasses(**good | change)


def test_rows_and_lengths_must_fit():
    classes, *_ = built([2, 3])
    one = np.ones((1, 128))
    with unchecked():
        with pytest.raises(ValueError, match="rows must be below 2, got 2"):
            classes.updated(np.array([2]), one)
        with pytest.raises(ValueError, match="rows must be at least 0, got -1"):
            classes.updated(np.array([-1]), one)
        with pytest.raises(ValueError, match="must have 128 numbers, got 127"):
            classes.updated(np.array([0]), one[:, :127])
        with pytest.raises(ValueError, match="must have 128 numbers, got 64"):
            classes.with_others(DescriptorClasses.of(one[:, :64]))
        with pytest.raises(ValueError, match=r"rows must be \(1,\) for others of 1"):
            classes.updated(np.array([0, 1]), one)
    assert len(classes.updated(np.empty(0, int), np.empty((0, 128)))) == 2
