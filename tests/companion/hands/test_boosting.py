"""Boosting against scikit-learn and by its own laws."""

import numpy as np
import pytest
from sklearn.ensemble import AdaBoostClassifier
from sklearn.tree import DecisionTreeClassifier

from robot_perception.companion.hands.boosting import Boosted, best_stump, boost
from tests.unchecked import unchecked

RNG = np.random.default_rng(0)
VALUES = RNG.normal(size=(12, 200))
LABELS = (VALUES[3] + 0.6 * VALUES[7] + 0.5 * RNG.normal(size=200)) > 0.2


def even():
    return np.where(LABELS, 0.5 / LABELS.sum(), 0.5 / (~LABELS).sum())


@pytest.mark.parametrize("seed", range(5))
def test_the_best_stump_errs_as_little_as_scikit_learns(seed):
    rng = np.random.default_rng(seed)
    weights = rng.uniform(0.1, 1, 200)
    weights /= weights.sum()
    order = VALUES.argsort(axis=1)
    feature, threshold, polarity, error = best_stump(VALUES, order, LABELS, weights)
    says = polarity * VALUES[feature] < polarity * threshold
    assert error == pytest.approx(weights[says != LABELS].sum())
    tried = []
    for values in VALUES:  # a tree chooses by impurity, so each threshold is tried
        for cut in (np.sort(values)[:-1] + np.sort(values)[1:]) / 2:
            wrong = weights[(values < cut) != LABELS].sum()
            tried.append(min(wrong, 1 - wrong))
    assert error == pytest.approx(min(tried))
    tree = DecisionTreeClassifier(max_depth=1).fit(VALUES.T, LABELS, weights)
    theirs = weights[tree.predict(VALUES.T) != LABELS].sum()
    assert error <= theirs + 1e-12


def test_a_few_stumps_are_as_good_as_scikit_learns():
    """Whose trees choose by impurity, not by the weighted error, so that the stumps may differ."""
    ours = boost(VALUES, LABELS, lambda found: False, most=6)
    theirs = AdaBoostClassifier(DecisionTreeClassifier(max_depth=1), n_estimators=6)
    theirs.fit(VALUES.T, LABELS, even())
    accuracy = ((ours.scores(VALUES) >= ours.votes.sum() / 2) == LABELS).mean()
    assert accuracy >= theirs.score(VALUES.T, LABELS) - 0.05


def test_more_stumps_err_less_on_what_they_are_trained_on():
    errors = []
    for k in (1, 4, 16, 50):
        found = boost(VALUES, LABELS, lambda found: False, most=k)
        assert len(found.features) == k
        says = found.scores(VALUES) >= found.votes.sum() / 2
        errors.append(float((says != LABELS).mean()))
    assert errors[0] > errors[2] > errors[3]
    assert errors[3] < 0.05


def test_the_error_stays_below_the_bound_of_freund_and_schapire():
    found = boost(VALUES, LABELS, lambda found: False, most=20)
    weights, bound = even(), 1.0
    for f, t, p in zip(found.features, found.thresholds, found.polarities, strict=True):
        says = p * VALUES[f] < p * t
        error = weights[says != LABELS].sum()
        bound *= 2 * np.sqrt(error * (1 - error))
        weights = weights * np.where(says == LABELS, error / (1 - error), 1)
        weights /= weights.sum()
    wrong = even()[(found.scores(VALUES) >= found.votes.sum() / 2) != LABELS].sum()
    assert wrong <= bound


def test_after_a_round_its_stump_is_no_better_than_chance():
    found = boost(VALUES, LABELS, lambda found: False, most=1)
    says = found.polarities[0] * VALUES[found.features[0]] < found.polarities[0] * found.thresholds
    error = even()[says != LABELS].sum()
    weights = even() * np.where(says == LABELS, error / (1 - error), 1)
    assert weights[says != LABELS].sum() / weights.sum() == pytest.approx(0.5)
    assert found.votes[0] == pytest.approx(np.log((1 - error) / error))


def test_boosting_stops_when_it_is_enough():
    asked = []

    def enough(found):
        asked.append(len(found.features))
        return len(found.features) == 3

    assert len(boost(VALUES, LABELS, enough).features) == 3
    assert asked == [1, 2, 3]


def test_equal_values_are_not_divided():
    values = np.array([[0.0, 0, 0, 1, 1, 1]])
    labels = np.array([True, True, False, False, False, False])
    weights = np.full(6, 1 / 6)
    order = values.argsort(axis=1, kind="stable")
    feature, threshold, polarity, error = best_stump(values, order, labels, weights)
    assert (feature, threshold, polarity) == (0, 0.5, 1)
    assert error == pytest.approx(1 / 6)


@pytest.mark.parametrize(
    ("wrong", "error", "text"),
    [
        (
            lambda: boost(VALUES, LABELS | True, lambda b: False),
            ValueError,
            "labels must be of both kinds",
        ),
        (lambda: boost(VALUES, LABELS.astype(int), lambda b: False), TypeError, "labels must be"),
        (lambda: boost(VALUES, LABELS[:9], lambda b: False), ValueError, "labels must be"),
        (
            lambda: boost(VALUES * np.nan, LABELS, lambda b: False),
            ValueError,
            "values must be finite",
        ),
        (lambda: boost(VALUES, LABELS, lambda b: False, most=0), ValueError, "most must be"),
        (
            lambda: Boosted(np.array([0]), np.zeros(1), np.array([2]), np.ones(1)),
            ValueError,
            "polarities must be 1 or -1",
        ),
        (
            lambda: Boosted(np.array([9]), np.zeros(1), np.array([1]), np.ones(1)).scores(
                VALUES[:5]
            ),
            ValueError,
            "values must be of 10 features or more",
        ),
    ],
)
def test_what_is_wrong_is_named(wrong, error, text):
    with unchecked(), pytest.raises(error, match=text):
        wrong()
