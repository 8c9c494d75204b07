"""New or known: curves against a count by hand, and what the printed rule would do."""

import numpy as np
import pytest

from robot_perception.chapters.sift_association import table1, threshold
from robot_perception.chapters.sift_association.threshold import Config, curve
from robot_perception.landmarks import Nearest
from tests.chapters.sift_association.worlds import clear_views

RNG = np.random.default_rng


def sample(count=60):
    """Distances, of which those of new landmarks tend to be larger; some names are wrong."""
    rng = RNG(4)
    new = rng.random(count) < 0.4
    away = rng.gamma(2.0, size=count) + 2.0 * new
    right = ~new & (rng.random(count) < 0.8)
    classes = np.stack([np.arange(count), np.arange(count)], axis=1)
    return Nearest(classes, np.stack([away, away + 1], axis=1)), new, right


def test_precision_and_recall_are_those_of_a_count():
    nearest, new, right = sample()
    found = curve(nearest, new, right)
    away = nearest.distances[:, 0]
    assert (found.limits[0], found.limits[-1]) == (away.min(), away.max())
    for k, limit in enumerate(found.limits):
        called = [d > limit for d in away]
        hits = sum(c and n for c, n in zip(called, new, strict=True))
        assert found.precision[k] == pytest.approx(hits / sum(called) if any(called) else 1.0)
        assert found.recall[k] == pytest.approx(hits / new.sum())
        named = sum(not c and not r for c, r in zip(called, right, strict=True))
        assert found.wrong[k] == pytest.approx(named / len(new))


def test_a_higher_threshold_calls_fewer_new():
    found = curve(*sample())
    assert (np.diff(found.recall) <= 0).all()
    assert (np.diff(found.wrong) >= 0).all()
    assert (found.recall[-1], found.precision[-1]) == (0, 1)


def test_best_is_the_largest_harmonic_mean():
    found = curve(*sample())
    means = [
        2 / (1 / p + 1 / r) if p and r else 0.0
        for p, r in zip(found.precision, found.recall, strict=True)
    ]
    assert found.best == int(np.argmax(means))


@pytest.fixture
def clear(monkeypatch):
    """A run on landmarks that look nothing like each other, of which half are left out."""
    seen = clear_views(40, RNG(1))
    monkeypatch.setattr(threshold, "views", lambda stations, seed: seen)
    return threshold.run(Config(p=4), rng=RNG(2))


def test_where_landmarks_look_different_new_ones_are_all_found(clear):
    assert clear.descriptors == 160
    assert 0 < clear.new < clear.descriptors
    assert clear.new % 4 == 0  # each landmark has four descriptors
    for found in clear.curves.values():
        assert found.precision[found.best] == 1
        assert found.recall[found.best] > 0.98  # a threshold is one of the distances
        assert found.wrong[found.best] <= 1 / clear.new


def test_from_aside_nothing_is_tested(monkeypatch):
    seen = clear_views(20, RNG(1))
    seen.aside[::2] = 0.3
    monkeypatch.setattr(threshold, "views", lambda stations, seed: seen)
    assert threshold.run(Config(p=4), rng=RNG(2)).descriptors == 40


def test_as_printed_nothing_is_new():
    """§4 calls new what exceeds the threshold for none of the landmarks; some are always far."""
    seen = clear_views(40, RNG(1))
    known = np.arange(40) < 20
    part = table1.part_of(seen, known)
    new = ~seen.same()[:, known].any(axis=1)
    for model in threshold.MODELS:
        distances = table1.decide(model, part, 4, table1.Config()).distances(
            seen.tests.astype(float)
        )
        limit = distances[~new].min(axis=1).max()  # the least that knows all known ones
        assert ((distances > limit).all(axis=1) == new).all()
        assert not (distances <= limit).all(axis=1).any()
