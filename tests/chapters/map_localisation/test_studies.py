"""What the studies count, on a building of points that takes no rendering."""

import numpy as np
import pytest

from robot_perception.book import map_localisation as page
from robot_perception.geometry import compose, inverse, se3
from robot_perception.slam.localisation import LandmarkMap, LocaliserRules, MapLocaliser
from robot_perception.slam.planar import Odometry
from robot_perception.slam.visual import Looks

ONTO = np.array([3.0, -1.0, 0.4])
"""From the map to the world: where a map lies is nothing that counts."""


def points(seed):
    """Return places of the world and what they look like."""
    rng = np.random.default_rng([seed, 99])
    return rng.uniform([0, -6, 0.3], [20, 8, 2.5], (300, 3)), rng.uniform(0, 90, (300, 128)).round()


def mapped(seed):
    """Return a map of the points, and the motion that lays it on the world."""
    places, found = points(seed)
    T = se3.from_se2(inverse(ONTO))
    looks = Looks(found, found, 0 * found, np.ones(300, dtype=int))
    return LandmarkMap(se3.act(T, places), np.tile(1e-3 * np.eye(3), (300, 1, 1)), looks), ONTO


def later(seed, way):
    """Return a drive among the points; the other way its robot sees other points."""
    rng = np.random.default_rng(seed)
    count = page.LATER if way == page.WAYS[0] else page.LATER // 2
    turns = np.linspace(0, 4.0, count)
    path = np.column_stack([10 + 5 * np.cos(turns), 1 + 4 * np.sin(turns), turns + np.pi / 2])
    sigmas = np.array([0.05, 0.02, 0.03])
    steps = compose(inverse(path[:-1]), path[1:]) + sigmas * rng.standard_normal((count - 1, 3))
    places, looks = points(seed + 50 * page.WAYS.index(way))
    shown = []
    for pose in path:
        seen = se3.act(se3.inverse(se3.from_se2(pose) @ page.MOUNT), places)
        rows = np.flatnonzero((seen[:, 2] > 0.5) & (seen[:, 2] < 7))
        noise = 0.03 * rng.standard_normal((len(rows), 3))
        covs = np.tile(1e-3 * np.eye(3), (len(rows), 1, 1))
        blurred = looks[rows] + rng.integers(0, 3, (len(rows), 128))  # never quite the same
        shown.append((seen[rows] + noise, covs, blurred.astype(np.uint8)))
    motions = tuple(Odometry(step, np.diag(sigmas**2)) for step in steps)
    return path, motions, tuple(shown)


@pytest.fixture(autouse=True)
def of_points(monkeypatch):
    monkeypatch.setattr(page, "mapped", mapped)
    monkeypatch.setattr(page, "later", later)


def one(study, **levels):
    """Return what the trial of a study says, computed here."""
    arguments = {"rng": np.random.default_rng(0), **levels}
    return study.one(**arguments)


def test_off_is_told_in_the_world():
    truth = np.array([1.0, 2.0, 3.0])
    gap, turned = page.off(compose(inverse(ONTO), truth + np.array([0.3, 0.4, 0.5])), truth, ONTO)
    assert gap == pytest.approx(0.5)
    assert turned == pytest.approx(0.5)
    _, turned = page.off(compose(inverse(ONTO), truth + np.array([0, 0, 6.0])), truth, ONTO)
    assert turned == pytest.approx(2 * np.pi - 6.0)


@pytest.mark.slow
def test_a_robot_is_found_where_points_are_known_and_not_where_they_are_others():
    rows = one(page.started, building=1, way=page.WAYS[0], finder=page.SEVERAL)
    assert list(rows) == [
        "start", "first", "fourth", "eighth", "found", "metres", "sure_and_wrong"
    ]  # fmt: skip
    assert rows["start"].tolist() == [0, 23, 47, 70, 94]
    assert rows["found"].all()
    assert (rows["metres"] < 0.3).all()
    back = one(page.started, building=1, way=page.WAYS[1], finder=page.SEVERAL)
    assert back["start"].tolist() == [0, 9, 19, 29, 39]
    assert not back["found"].any()
    assert (back["metres"] > 1).all()


def test_buildings_of_other_plans_are_tried_alike():
    """The drives of `PLANS` have a route of their own, and are told as those of one plan are."""
    ours, theirs = (
        one(study, building=221, way=page.WAYS[0], finder="one picture")
        for study in (page.anywhere, page.started)
    )
    assert {name: values.tolist() for name, values in ours.items()} == {
        name: values.tolist() for name, values in theirs.items()
    }


def test_a_plan_is_driven_as_far_as_its_route_goes():
    for seed, length in ((5, 52.0), (222, 81.0)):
        path = page.route(seed, page.WAYS[0], 400, np.random.default_rng(1))
        way = np.hypot(*np.diff(path[:, :2], axis=0).T).sum()
        assert way == pytest.approx(length, abs=4)


def test_a_ring_is_driven_one_way_and_a_dead_end_both():
    """By the plans: the first is a ring, the ninth one corridor with its ends."""
    assert page.both_ways(220) == 0
    assert page.both_ways(228) > 0.7


def test_shares_are_of_buildings():
    """No building's five starts are five opinions: the interval is as wide as of ten numbers."""
    rows = page.anywhere.rows()
    shares = rows.where(way=page.WAYS[0], finder=page.SEVERAL).of("found").reshape(-1, page.STARTS)
    found, own = page.found_in(rows, page.WAYS[0]), shares.mean(axis=1)
    assert found.estimate == pytest.approx(own.mean())
    assert found.high - found.low == pytest.approx(4 * own.std() / np.sqrt(10), rel=0.4)


@pytest.mark.parametrize("finder", ["one picture", "wheels alone", "the twin floor's map"])
def test_opponents(finder):
    rows = one(page.started, building=1, way=page.WAYS[0], finder=finder)
    assert rows["first"].all() == rows["found"].all() == (finder == "one picture")
    assert not rows["sure_and_wrong"].any()


def test_one_eye_sees_from_where_it_looks():
    """Points without noise give the pose; a point that is another landmark's does not harm it."""
    (map_, onto), (path, _, _) = mapped(1), later(1, page.WAYS[0])
    places, looks = points(1)
    for pose in path[::40]:
        seen = se3.act(se3.inverse(se3.from_se2(pose) @ page.MOUNT), places)
        rows = np.flatnonzero((seen[:, 2] > 0.5) & (seen[:, 2] < 7))
        taken = looks[rows]
        taken[:2] = taken[:2][::-1]  # each of two is taken for the other
        picture = seen[rows], None, taken.astype(np.uint8)
        found, agree = page.perspective(map_, picture, 0.8, np.random.default_rng(0))
        away, turned = page.off(found, pose, onto)
        assert (away < 0.01, turned < 0.01) == (True, True)
        assert len(rows) - 2 <= agree <= len(rows)


def test_landmarks_with_a_double_are_not_clear():
    (map_, _), (_, _, shown) = mapped(1), later(1, page.WAYS[0])
    looks = map_.looks
    columns = (looks.firsts, looks.means, looks.squares, looks.counts)
    twice = Looks(*(np.concatenate([column] * 2) for column in columns))
    both = LandmarkMap(np.tile(map_.means, (2, 1)), np.tile(map_.covs, (2, 1, 1)), twice)
    rng = np.random.default_rng(0)
    assert page.perspective(both, shown[0], 0.8, rng)[1] == 0
    assert page.perspective(map_, shown[0], 0.8, rng)[1] > 10
    assert page.perspective(map_, (np.zeros((0, 3)), None, np.zeros((0, 128))), 0.8, rng)[1] == 0


def test_one_eye_is_enough_where_points_are_known():
    rows = one(page.posed, building=1, way=page.WAYS[0], finder=page.EYE)
    assert rows["start"].tolist() == [0, 23, 47, 70, 94]
    assert rows["first"].all()
    assert (rows["metres"] < 0.3).all()
    assert not rows["sure_and_wrong"].any()
    back = one(page.posed, building=1, way=page.WAYS[1], finder=page.EYE)
    assert not back["found"].any()


@pytest.mark.slow
def test_landmarks_that_are_not_recognised_tell_nothing():
    rows = one(page.started, building=1, way=page.WAYS[0], finder=page.SEVERAL, shuffled=True)
    assert not rows["found"].all()
    told = one(page.tracked, building=1, way=page.WAYS[0], limit=0.0)
    assert told["filter"] > 0.8 * told["wheels"]


def test_the_map_keeps_the_place_that_wheels_lose():
    told = one(page.tracked, building=1, way=page.WAYS[0])
    path, motions, _ = later(1, page.WAYS[0])
    alone = [path[0]]
    for motion in motions:
        alone.append(motion.move(alone[-1]))
    square = ((np.array(alone) - path)[:, :2] ** 2).sum(axis=1).mean()
    assert told["wheels"] == pytest.approx(np.sqrt(square))
    assert told["filter"] < 0.2 < told["wheels"]


def test_a_robot_that_is_carried_away_is_found_with_fresh_particles():
    for fresh in page.FRESH:
        rows = one(page.carried, building=1, fresh=fresh)
        assert rows["before"].tolist() == [1, 1, 1]
        assert rows["after"].tolist() == [fresh > 0] * 3


def test_a_jump_is_not_told_by_the_wheels():
    (map_, _), drive = mapped(1), later(1, page.WAYS[0])
    tracker = MapLocaliser(map_, page.MOUNT, LocaliserRules(particles=50, limit=0.0, share=0.0))
    rng = np.random.default_rng(0)
    state = tracker.start(rng=rng)
    pictures, seen = [3, 4, 60, 61], {}
    for k, now, info in page.followed(tracker, state, drive, pictures, rng, jumps=(60,)):
        seen[k] = now.particles.states
        assert (info.names < 0).all()
    assert np.array_equal(seen[60], seen[4])
    moved = compose(inverse(seen[3]), seen[4]).mean(axis=0)
    np.testing.assert_allclose(moved, drive[1][3].increment, atol=0.03)
    assert not np.array_equal(seen[61], seen[60])


def test_the_best_picture_is_kept_and_moved_by_the_wheels():
    (map_, onto), drive = mapped(1), later(1, page.WAYS[0])
    path, motions, shown = drive
    blind = (*shown[:6], *((s[0][:0], s[1][:0], s[2][:0]) for s in shown[6:12]))
    tracker = MapLocaliser(map_, page.MOUNT)
    told = list(
        page.by_one_picture(tracker, (path, motions, blind), range(4, 12), np.random.default_rng(0))
    )
    assert [k for k, *_ in told] == list(range(4, 12))
    assert all(sure for *_, sure in told)
    assert page.off(told[1][1], path[5], onto)[0] < 0.1
    kept = told[1][1]
    for k in range(6, 12):
        kept = motions[k - 1].move(kept)
    np.testing.assert_allclose(told[-1][1][:2], kept[:2])


def test_landmarks_that_are_shuffled_keep_their_places():
    map_, _ = mapped(1)
    other = page.shuffled_looks(map_, np.random.default_rng(0))
    assert np.array_equal(other.means, map_.means)
    assert not np.array_equal(other.looks.means, map_.looks.means)
    assert np.array_equal(np.sort(other.looks.means, axis=0), np.sort(map_.looks.means, axis=0))


def test_the_other_way_is_the_same_line_backwards():
    there, back = (page.route(5, way, 400, np.random.default_rng(1)) for way in page.WAYS)
    gaps = np.linalg.norm(there[:, None, :2] - back[None, :, :2], axis=-1)
    assert gaps.min(axis=1).max() < 1.0
    nearest = gaps.argmin(axis=1)
    turned = np.cos(there[:, 2] - back[nearest, 2])
    assert np.median(turned) < -0.9


def test_wheels_report_a_step_before_each_picture_but_the_first():
    path = page.route(5, page.WAYS[0], 300, np.random.default_rng(1))
    first, *steps = page.rolled(path, np.random.default_rng(2))
    assert first is None
    true = compose(inverse(path[:-1]), path[1:])
    told = np.array([step.increment for step in steps])
    sigmas = np.sqrt([np.diag(step.noise) for step in steps])
    errors = (told - true + [0, 0, np.pi]) % [1e9, 1e9, 2 * np.pi] - [0, 0, np.pi]
    errors[:, :2] = (told - true)[:, :2]
    assert np.std(errors / sigmas) == pytest.approx(1, abs=0.1)
