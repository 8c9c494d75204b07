"""Table 1: what is assigned to what, by hand and by law."""

from types import SimpleNamespace

import numpy as np
import pytest

from robot_perception.book import sift_association as page
from robot_perception.chapters.sift_association import recordings
from robot_perception.landmarks import Mahalanobis
from studies.rows import Rows, framed
from tests.chapters.sift_association.worlds import clear_views
from tests.unchecked import unchecked

RNG = np.random.default_rng


def test_shares_count_what_is_right_and_what_looks_alike():
    nearest = SimpleNamespace(classes=np.array([[0, 1], [1, 0], [2, 0], [2, 1]]))
    rule = SimpleNamespace(two_nearest=lambda found: nearest)
    there, like = np.zeros((2, 4, 3), dtype=bool)
    there[[0, 1], [0, 1]] = True  # the last two are assigned wrong
    like[[0, 2], [0, 2]] = True  # one that is right may look alike besides: no error
    assert page.shares(rule, np.zeros((4, 128)), there, like) == (50.0, 25.0)


def test_a_sample_holds_no_more_than_are_assigned_and_all_of_fewer(monkeypatch):
    mask = np.arange(60) % 2 == 0
    assert page.sample(mask, RNG(0)).tolist() == np.flatnonzero(mask).tolist()
    monkeypatch.setattr(page, "DESCRIPTORS", 7)
    some = page.sample(mask, RNG(0))
    assert len(set(some.tolist())) == 7
    assert mask[some].all()
    assert (np.diff(some) > 0).all()


@pytest.fixture
def clear(monkeypatch):
    """Landmarks that look nothing like each other; half of the tests are from aside, and odd."""
    seen = clear_views(40, RNG(1), frames=30)
    seen.aside[::2] = 0.6
    seen.tests[::2] = np.roll(seen.tests[::2], 2, axis=0)
    monkeypatch.setattr(page, "views", lambda stations, seed: seen)
    monkeypatch.setattr(page, "DESCRIPTORS", 60)
    return seen


def test_who_looks_different_is_told_apart_wherever_tests_come_from(clear):
    with unchecked():
        trial = page.assigned.trial(building=0, swing=0.3)
    rows = Rows(framed([trial]), "building", {})
    for model in page.MODELS:
        for where in (page.OWN, page.OTHER):
            assert (rows.of("right", model=model, where=where) > 95).all()
        farther = rows.of("right", model=model, where=page.FARTHER)
        assert (farther < 60).all()  # they show another landmark than lies there
    assert set(rows.of("landmarks")) == {40}
    assert rows.levels("p") == page.TRACKED


def test_dealt_variances_are_those_of_others(clear):
    classes = clear.classes(10)
    own, dealt = (page.decide("raw", classes, dealt=how).variances for how in (False, True))
    assert (np.roll(own, 20, axis=0) == dealt).all()
    assert (own != dealt).any()


def test_the_mean_distance_to_the_own_class_is_that_of_the_definition(clear):
    with unchecked():
        trial = page.assigned.trial(building=0, swing=0.3)
    rows = Rows(framed([trial]), "building", {})
    at = np.flatnonzero(clear.aside == 0)
    owners = clear.same()[at].argmax(axis=1)
    for p in (3, 30):
        classes = clear.classes(p)
        rule = Mahalanobis(classes.means, page.raw_variances(classes))
        some = rule.distances(clear.tests[at].astype(float))[np.arange(len(at)), owners]
        found = set(rows.of("L", p=p))
        assert len(found) == 1
        assert found.pop() == pytest.approx(some.mean(), rel=0.2)  # 60 of them were drawn


def test_gains_are_differences_of_shares():
    right = {page.ONE_VIEW: 80.0, page.EUCLID: 88.0, page.RAW: 85.0}
    trials = [
        {"building": k, "p": 30, "model": list(right), "where": page.OTHER,
         "right": [value + k for value in right.values()]}
        for k in range(3)
    ]  # fmt: skip
    rows = Rows(framed(trials), "building", {})
    assert page.gain(rows, page.OTHER).estimate == pytest.approx(5)
    assert page.gain(rows, page.OTHER, over=page.EUCLID).estimate == pytest.approx(-3)


def test_real_tracks_are_judged_by_the_same_estimates():
    assert list(recordings.VARIANCES) == list(page.VARIANCES)
    classes = clear_views(6, RNG(0)).classes(4)
    for name, variances in recordings.VARIANCES.items():
        assert (variances(classes) == page.VARIANCES[name](classes)).all()
