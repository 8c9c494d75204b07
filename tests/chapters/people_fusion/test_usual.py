"""The usual tracker: Kalman filters, an assignment of all pairs at once, M of N, and an end."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from robot_perception.beliefs import Gaussian
from robot_perception.book import people_fusion as page
from robot_perception.book.people_fusion import SORT, Tracks
from robot_perception.geometry import wrap_angle
from tests.chapters.people_fusion.sessions import SPREAD, session
from tests.chapters.people_fusion.test_studies import rows

STILL = replace(SORT, speed=0.0)


def detections(places, sensor="laser"):
    """Return detections of a sensor at some distances and directions."""
    places = np.array(places, dtype=float).reshape(-1, 2)
    return Gaussian(places, np.tile(np.diag(SPREAD[sensor]) ** 2, (len(places), 1, 1)))


def tracks_at(places, rules=STILL, sensor="laser"):
    """Return tracks of what a sensor has seen once."""
    return Tracks.new(detections(places, sensor), 0.0, 0, rules)


def test_the_rules_are_one_of_as_many_draws_as_those_of_the_committee():
    source = np.random.default_rng(0)
    assert SORT in [page.drawn_nearest(source) for _ in range(page.DRAWS)]


@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_one_track_is_the_filter_of_filterpy(speed):
    """Somebody walks; process noise in distance and direction is written down anew."""
    rules, rng, dt = replace(SORT, speed=speed), np.random.default_rng(3), 0.1
    seen = np.column_stack([3 - 0.1 * np.arange(12), 0.4 + 0.02 * np.arange(12)])
    seen += rng.normal(0, SPREAD["laser"], seen.shape)
    tracks = tracks_at(seen[:1], rules)
    theirs = KalmanFilter(dim_x=4, dim_z=2)
    theirs.x, theirs.P = tracks.mean[0].copy(), tracks.cov[0].copy()
    theirs.H, theirs.R = np.eye(4)[:2], np.diag(SPREAD["laser"]) ** 2
    for place in seen[1:]:
        units = np.diag([1.0, 1 / theirs.x[0]])
        noise = rules.walk**2 * units**2
        if speed:
            theirs.F = np.block([[np.eye(2), dt * np.eye(2)], [np.zeros((2, 2)), np.eye(2)]])
            parts = [[noise * dt**3 / 3, noise * dt**2 / 2], [noise * dt**2 / 2, noise * dt]]
            theirs.Q = np.block(parts)
        else:
            theirs.F = np.eye(4)
            theirs.Q = np.block([[noise * dt, np.zeros((2, 2))], [np.zeros((2, 4))]])
        theirs.predict()
        theirs.update(place)
        found = detections([place])
        tracks, i, j = page.assigned(found, page.coasted(tracks, dt, rules), rules)
        assert (i.tolist(), j.tolist()) == ([0], [0])
        np.testing.assert_allclose(tracks.mean[0], theirs.x, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(tracks.cov[0], theirs.P, rtol=1e-9, atol=1e-12)


def test_all_pairs_together_are_nearest_where_the_nearest_first_would_not_be():
    """The nearest pair of all leaves the other two far apart, yet inside the gate."""
    known, seen = [(2.0, 0.0), (2.3, 0.0)], [(2.28, 0.0), (2.6, 0.0)]
    _, i, j = page.assigned(detections(known), tracks_at(seen), STILL)
    assert sorted(zip(i.tolist(), j.tolist(), strict=True)) == [(0, 0), (1, 1)]


def test_pairs_have_the_least_sum_of_all_permutations():
    rng = np.random.default_rng(5)
    for _ in range(20):
        old = np.column_stack([rng.uniform(2, 2.4, 4), rng.uniform(-0.1, 0.1, 4)])
        new = old + rng.normal(0, 0.05, old.shape)
        _, i, j = page.assigned(detections(new), tracks_at(old), STILL)
        assert len(i) == 4  # all are inside the gate
        S = 2 * np.array(SPREAD["laser"]) ** 2
        cost = ((new[:, None] - old) ** 2 / S).sum(axis=-1)
        least = min(cost[range(4), order].sum() for order in map(list, permutations(range(4))))
        assert cost[i, j].sum() == pytest.approx(least)


def test_a_pair_outside_the_gate_costs_no_more_than_none():
    """The sum of both distances is least if neither detection gets its nearest track."""
    _, i, j = page.assigned(
        detections([(2.0, 0.0), (2.9, 0.0)]), tracks_at([(2.05, 0.0), (1.5, 0.0)]), STILL
    )
    assert (i.tolist(), j.tolist()) == ([0], [0])


def test_what_is_outside_the_gate_is_nobodys():
    _, i, j = page.assigned(detections([(2.0, 0.0)]), tracks_at([(3.5, 0.0)]), STILL)
    assert not len(i)
    assert not len(j)


def test_the_camera_corrects_the_direction_alone_the_short_way():
    before = tracks_at([(3.0, 3.1)])
    after, i, _ = page.assigned(detections([(2.0, -3.1)], "camera"), before, STILL)
    assert len(i) == 1
    assert after.mean[0, 0] == 3.0
    assert after.cov[0, 0, 0] == before.cov[0, 0, 0]
    middle = 3.1 + 0.5 * (2 * np.pi - 6.2)
    assert wrap_angle(after.mean[0, 1] - middle) == pytest.approx(0, abs=1e-9)


def test_a_track_counts_after_m_of_n_readings_and_goes_on_counting():
    rules, counts = replace(STILL, hits=3, readings=4), []
    tracks = tracks_at([(2.0, 0.0)], rules)  # the first hit
    for k, hit in enumerate((False, False, True, False, True, True, False)):
        j = np.flatnonzero([hit])
        tracks = page.confirmed(tracks, j, 0.1 * (k + 1), rules)
        counts.append(bool(tracks.counts[0]))
    assert counts == [False] * 5 + [True] * 2  # the third hit comes too late, the fourth in time
    assert tracks.seen[0] == pytest.approx(0.6)


def test_people_who_stand_are_found_and_forgotten_when_nobody_reports():
    whole = session([(2.0, 0.3), (1.2, 2.8)], 6.0)
    run = page.by_nearest(page.without(whole, np.repeat(whole.times > 4.0, whole.counts)), SORT)
    assert run.rows == list(range(len(whole.judged)))
    there, gone = run.at(3.9), run.at(4.0 + SORT.patience + 0.2)
    assert len(there) == 2
    assert np.sort(there.mean[:, 1]) == pytest.approx([0.3, 2.8], abs=0.05)
    assert len(gone) == 0


def test_a_trial_counts_in_all_views_and_believes_sooner_with_fewer_hits(monkeypatch):
    whole = session([(2.0, 0.3), (1.2, 2.8)], 4.0)
    monkeypatch.setattr(page, "record", lambda config: whole)
    slow, quick = (page.contested.one(1, hits=hits) for hits in (SORT.hits, 1))
    assert slow["view"] == [*page.VIEWS]
    assert (quick["people"] == slow["people"]).all()
    assert quick["matched"][0] > slow["matched"][0] > 0.8 * slow["people"][0]


def test_both_are_compared_over_the_same_sessions():
    views = ["everywhere", "ahead", "behind"]
    frame = {
        "session": [1, 2] * 3,
        "view": np.repeat(views, 2),
        "people": [10] * 6,
        "found": [10, 8] * 3,
        "matched": [8, 6] * 3,
    }
    ours = rows(**frame, who=["together"] * 6)
    assert page.usual_over_ours(rows(**frame), ours).estimate == 1
    more = rows(**(frame | {"matched": [9, 8] * 3}))
    assert page.usual_over_ours(more, ours).estimate > 1
    table = page.beside_committee(more, ours)
    names = ("the committee", "the usual tracker")
    assert list(table.rows) == [f"{view}: {name}" for view in views for name in names]
    found = [table.rows[name][0].estimate for name in list(table.rows)[:2]]
    assert found == pytest.approx([14 / 20, 17 / 20])
