"""New or known: curves against a count by hand, and what the printed rule would do."""

import numpy as np
import pytest

from robot_perception.book import sift_association as page
from robot_perception.book.sift_association import curve
from tests.chapters.sift_association.worlds import clear_views

RNG = np.random.default_rng


def sample(count=60):
    """Distances, of which those of new landmarks tend to be larger."""
    rng = RNG(4)
    new = rng.random(count) < 0.4
    away = rng.gamma(2.0, size=count) + 2.0 * new
    return away, new


def test_precision_and_recall_are_those_of_a_count():
    away, new = sample()
    found = curve(away, new)
    assert (found.limits[0], found.limits[-1]) == (away.min(), away.max())
    for k, limit in enumerate(found.limits):
        called = [d > limit for d in away]
        hits = sum(c and n for c, n in zip(called, new, strict=True))
        assert found.precision[k] == pytest.approx(hits / sum(called) if any(called) else 1.0)
        assert found.recall[k] == pytest.approx(hits / new.sum())


def test_a_higher_threshold_calls_fewer_new():
    found = curve(*sample())
    assert (np.diff(found.recall) <= 0).all()
    assert (found.recall[-1], found.precision[-1]) == (0, 1)


def test_best_is_the_largest_harmonic_mean():
    found = curve(*sample())
    means = [
        2 / (1 / p + 1 / r) if p and r else 0.0
        for p, r in zip(found.precision, found.recall, strict=True)
    ]
    assert found.best == int(np.argmax(means))


@pytest.mark.parametrize("aside", [False, True])
def test_where_landmarks_look_different_new_ones_are_all_found(aside):
    """What is seen from aside is not tested."""
    seen = clear_views(40, RNG(1))
    if aside:
        seen.aside[::2], seen.tests[::2] = 0.3, 0
    for found in page.found_new(seen, 4, RNG(2))[0].values():
        assert found.precision[found.best] == 1
        assert found.recall[found.best] > 0.95  # a threshold is one of the distances


def test_what_is_in_the_map_is_not_new(monkeypatch):
    """At the least threshold all but one are called new: so many of them are as were left out."""
    seen = clear_views(40, RNG(1))
    for share in (0.25, 0.75):
        monkeypatch.setattr(page, "LEFT_OUT", share)
        for found in page.found_new(seen, 4, RNG(2))[0].values():
            assert found.precision[0] == pytest.approx(share, abs=0.15)


def test_as_printed_nothing_is_new_and_as_meant_nearly_all(monkeypatch):
    """§4 calls new what exceeds the threshold for none of the landmarks; some are always far."""
    seen = clear_views(40, RNG(1), frames=10)
    monkeypatch.setattr(page, "views", lambda stations, seed: seen)
    printed, meant = (page.called.but(meant=how).trial(building=0) for how in (False, True))
    assert printed["called"] == 0
    assert meant["called"] == printed["as meant"] > 0.95


@pytest.mark.parametrize("model", page.JUDGES)
def test_new_is_what_is_far_from_all_that_are_known(model):
    seen = clear_views(40, RNG(1))
    known = np.arange(40) < 20
    new = ~seen.same()[:, known].any(axis=1)
    decided = page.decide(model, seen.classes(4)[known])
    distances = decided.distances(seen.tests.astype(float))
    limit = distances[~new].min(axis=1).max()  # the least that knows all known ones
    assert ((distances > limit).all(axis=1) == new).all()
    assert not (distances <= limit).all(axis=1).any()
