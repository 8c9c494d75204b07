"""Stories for a robot that acts: everybody stands where the story wants them, and hears."""

from functools import cache

import numpy as np
import pytest

from data_synth.people.stories import (
    KINDS,
    StepsAside,
    TurnedRing,
    ask_aside,
    make_story,
    meeting_place,
)
from data_synth.people.world import Visit
from data_synth.sonar import SonarRing

SEED = 5001


def story(kind, seed=SEED, **how):
    return make_story(kind, rng=np.random.default_rng(seed), **how)


@cache
def still(kind, seed=SEED):
    """Return a story that nobody runs."""
    return story(kind, seed)


def seen(robot, place):
    """Return how far ahead of a robot and how far to its left a place is."""
    x, y = place - robot[:2]
    cos, sin = np.cos(robot[2]), np.sin(robot[2])
    return cos * x + sin * y, cos * y - sin * x


def off(points, route):
    """Return how far points are from the nearest of a route's."""
    return np.linalg.norm(points[:, None] - route, axis=-1).min(axis=1)


@pytest.mark.parametrize("count", [8, 16])
def test_a_sonar_of_the_turned_ring_looks_back_and_one_ahead(count):
    ring = TurnedRing(count=count)
    assert np.abs(ring.angles).max() == pytest.approx(np.pi)
    assert np.abs(ring.angles).min() == pytest.approx(0.0)
    assert np.diff(ring.angles) == pytest.approx(2 * np.pi / count)
    assert np.abs(SonarRing(count=count).angles).max() < np.pi - 0.1


def test_who_steps_aside_does_so_once_and_in_a_straight_line():
    places = np.array([[1.0, 2.0], [1.0, 5.0]])
    one = StepsAside(places, np.array([0.0, 99.0]))
    assert one.asked == np.inf
    assert (one.position(50.0) == places[0]).all()
    for time in (7.0, 4.0, 9.0):  # the first time counts
        one.ask(time)
    assert one.asked == 4.0
    assert (one.position(4.8) == places[0]).all()
    assert one.position(4.8 + 0.75) == pytest.approx(places.mean(axis=0))
    assert (one.position(4.8 + 1.51) == places[1]).all()


@pytest.mark.parametrize("seed", [5001, 5002])
@pytest.mark.parametrize("kind", KINDS)
def test_everybody_stands_free_and_the_person_where_the_story_wants_them(kind, seed):
    world, route = still(kind, seed)
    robot, place = world.now.robot, world.now.positions[0]
    assert world.office.free(np.concatenate([robot[None, :2], world.now.positions])).min() >= 0.25
    ahead, left = seen(robot, place)
    if kind == "follow":
        assert np.hypot(ahead, left) == pytest.approx(1.2, abs=0.2)
    else:
        assert 3.0 < np.hypot(ahead, left) < 4.6
    assert abs(left) < abs(ahead)
    leads = kind in ("guide", "blocked")
    assert (ahead < 0) == leads == bool(len(route))
    if leads:
        assert world.office.free(route).min() >= 0.25
        assert np.hypot(*np.diff(route, axis=0).T).max() < 0.11
        assert np.hypot(*(route[0] - robot[:2])) < 1e-3
        assert seen(robot, route[5])[0] > 0.4


def test_a_visitor_comes_from_where_and_strays_when_it_is_said():
    world, _ = story("guide", comes=2.0, strays=5.0)
    away = np.hypot(*(world.now.positions[0] - world.now.robot[:2]))
    assert 1.4 < away < 2.1
    (act,) = world.acts
    assert isinstance(act, Visit)
    assert (act.strays, act.returns) == ((5.0,), True)
    (act,) = still("survey")[0].acts
    assert (act.strays, act.returns) == ((9.0,), False)
    assert still("blocked")[0].acts[0].strays == ()


def test_who_is_followed_starts_at_the_gap_and_walks_as_fast_as_is_said():
    for gap, pace, (world, _) in (
        (1.2, 0.5, still("follow")),
        (2.0, 0.8, story("follow", gap=2.0, pace=0.8)),
    ):
        (act,) = world.acts
        away = np.hypot(*(act.waypoints[0] - world.now.robot[:2]))
        assert away == pytest.approx(gap, abs=0.3)
        assert (act.waypoints[0] == act.waypoints[1]).all()  # and waits
        legs = np.hypot(*np.diff(act.waypoints[1:], axis=0).T) / np.diff(act.times[1:])
        assert legs.max() == pytest.approx(pace, abs=1e-6)


@pytest.mark.parametrize("beside", [False, True])
def test_two_stand_in_the_way_until_they_are_asked_or_beside_it(beside):
    world, route = story("blocked", beside=beside)
    two = world.now.positions[1:]
    place, across = meeting_place(world.office, route)
    assert np.hypot(*across) == pytest.approx(1.0)
    assert two.mean(axis=0) == pytest.approx(place, abs=1e-3)
    assert ((off(two, route) < 0.4) != beside).all()
    for _ in range(10):
        world.advance(0.2)
    assert world.now.positions[1:] == pytest.approx(two, abs=1e-6)
    ask_aside(world)
    for _ in range(15):
        world.advance(0.2)
    aside = world.now.positions[1:]
    assert (off(aside, route) > 0.6).all()
    assert world.office.free(aside).min() > 0.2


def test_the_same_seed_is_the_same_story_and_what_has_no_room_is_an_error():
    (one, route), (other, again) = still("blocked"), story("blocked")
    assert (one.now.positions == other.now.positions).all()
    assert (route == again).all()
    with pytest.raises(ValueError, match="comes must leave room"):
        story("guide", comes=20.0)
    with pytest.raises(ValueError, match="kind must be one of"):
        story("dance")
    with pytest.raises(ValueError, match="route must have a place"):
        meeting_place(one.office, route[:20])
