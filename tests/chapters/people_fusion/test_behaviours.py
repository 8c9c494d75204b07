"""Laws of the behaviours: staging, stories written down by hand, and short ones told."""

from dataclasses import fields, replace

import numpy as np
import pytest

from data_synth.people import SonarScan
from robot_perception.chapters.people_fusion import behaviours, films
from robot_perception.chapters.people_fusion.behaviours import RING, RULES, SAID, STRAYS, Story
from robot_perception.chapters.people_sensors import sessions
from robot_perception.geometry import se2
from robot_perception.people.behaviours import PARTNER, PHASES

SEED = behaviours.CHOOSE[0]


def story(asked=(), apart=(1.0,), busy=True):
    """Return a story of a step a second, in which the robot asks back at some of them."""
    k = len(apart)
    said = np.zeros(k, dtype=int)
    said[list(asked)] = SAID.index("come back")
    visitor = np.stack([np.array(apart, float), np.zeros(k)], axis=-1)
    phase = np.broadcast_to(np.where(busy, PHASES.index("busy"), PHASES.index("asking back")), k)
    nothing = np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros(0), np.zeros(0, dtype=int)
    return Story(
        *(np.arange(k, dtype=float), np.zeros((k, 3)), np.zeros((k, 3)), visitor, phase, said),
        *(np.zeros(k), np.zeros(k, dtype=bool), np.arange(k), np.zeros(k, dtype=int), *nothing),
    )


LEFT = [1.0] * round(STRAYS + 3) + [4.0] * 10
"""Strays, and is too far away from the third second after that on."""


@pytest.mark.parametrize(
    ("asked", "delay"),
    [
        ([STRAYS + 6], 3.0),
        ([STRAYS + 6, STRAYS + 9], 3.0),
        ([STRAYS + 1], 0.0),  # before they are too far away
        ([], np.inf),
        ([3], np.inf),  # before they stray
    ],
)
def test_delay_counts_from_when_somebody_is_too_far_away(asked, delay):
    told = story(np.array(asked, dtype=int), LEFT)
    assert behaviours.delays([told], 3.0).tolist() == [delay]


def test_who_asks_back_somebody_that_stays_has_not_noticed_anything():
    told = story([round(STRAYS) + 4], [1.0] * 25)
    assert behaviours.delays([told], 3.0).tolist() == [np.inf]


def test_false_stops_are_those_before_anybody_leaves():
    some = [story([2, 5, round(STRAYS) + 4], LEFT), story([round(STRAYS) + 4], LEFT)]
    assert behaviours.false_stops(some).tolist() == [2, 0]


def test_a_tour_goes_on_with_a_visitor_who_is_back():
    asked, back = [round(STRAYS) + 5], [*LEFT, 1.0, 1.0, 1.0]
    busy = np.arange(len(back)) != asked[0]
    late = np.arange(len(back)) < asked[0]  # it asks for ever
    some = [story(asked, back, busy), story(asked, back, late)]
    assert behaviours.continued(some).tolist() == [True, False]
    away, nobody = story(asked, LEFT, busy[:-3]), story([], back)
    assert behaviours.continued([away, nobody, story(asked, back[:-2], busy[:-2])]).size == 0


def test_seeds_of_the_rules_and_of_the_scores_never_meet():
    assert not set(behaviours.CHOOSE) & set(behaviours.SEEDS)
    assert len(behaviours.SEEDS) == 20


# Staging -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", behaviours.CHOOSE[:3])
@pytest.mark.parametrize("kind", ["guide", "follow", "survey"])
def test_staging(kind, seed):
    """Everybody stands free, the person where the sensors will find them, the route is inside."""
    world, route = behaviours.stage(kind, np.random.default_rng(seed))
    robot, place = world.now.robot, world.now.positions[0]
    assert world.office.free(np.stack([robot[:2], place])).min() >= 0.25
    ahead, left = se2.act(se2.inverse(robot), place[None])[0]
    if kind == "follow":
        assert np.hypot(ahead, left) == pytest.approx(behaviours.BACK_TO_ROBOT, abs=0.2)
    else:
        assert 3.0 < np.hypot(ahead, left) < behaviours.COMES + 0.1
    assert abs(left) < abs(ahead)
    assert (ahead < 0) == (kind == "guide")
    assert bool(len(route)) == (kind == "guide")
    if kind == "guide":
        assert world.office.free(route).min() >= 0.25
        gaps = np.hypot(*np.diff(route, axis=0).T)
        assert gaps.max() < 0.11
        assert gaps.sum() > behaviours.LEADS * behaviours.DURATION[kind]


def test_who_is_followed_never_stops():
    world, _ = behaviours.stage("follow", np.random.default_rng(SEED))
    (act,) = world.acts
    assert act.times[-1] >= behaviours.DURATION["follow"]


def test_a_sonar_of_the_turned_ring_looks_back():
    assert np.abs(RING.angles).max() == pytest.approx(np.pi)
    assert np.diff(RING.angles) == pytest.approx(2 * np.pi / RING.count)


# What the robot knows ----------------------------------------------------------------------------


def robot(kind="survey"):
    world, _ = behaviours.stage(kind, np.random.default_rng(SEED))
    return behaviours._Robot(kind, SEED, behaviours.WITHOUT_CAMERA, RULES, world), world


def test_the_map_tells_walls_from_people_where_the_robot_takes_itself_to_be():
    """Of two readings to one side, one ends at the wall and the other well before it."""
    mind, world = robot()
    mind.pose = np.array([*world.now.robot[:2], 0.0])
    side = int(np.abs(RING.angles - np.pi / 2).argmin())
    wall = world.office.rooms[-1, 3] - mind.pose[1] - RING.radius
    for ranges, count in ((wall, 0), (wall - 0.6, 1)):
        readings = np.full(RING.count, np.inf)
        readings[side] = ranges
        assert len(mind.found(SonarScan(0.1, readings))) == count
    mind.pose = mind.pose + np.array([0, 0.6, 0])  # it is wrong by that
    assert len(mind.found(SonarScan(0.1, readings))) == 0


# Stories -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def followed():
    return behaviours.told.__wrapped__("follow", SEED, behaviours.WITHOUT_CAMERA, RULES)


def test_the_same_seed_tells_the_same_story(followed, monkeypatch):
    monkeypatch.setitem(behaviours.DURATION, "follow", 4.0)
    again = behaviours.told.__wrapped__("follow", SEED, behaviours.WITHOUT_CAMERA, RULES)
    for entry in fields(Story):
        part = getattr(again, entry.name)
        assert np.array_equal(part, getattr(followed, entry.name)[: len(part)]), entry.name
    other = behaviours.told.__wrapped__("follow", SEED + 1, behaviours.WITHOUT_CAMERA, RULES)
    assert not np.allclose(other.visitor, again.visitor)


def test_the_wheels_slip(followed):
    """The reckoned path is not the true one, and off by a few parts in a hundred."""
    steps = np.hypot(*np.diff(followed.robot[:, :2], axis=0).T).sum()
    off = np.hypot(*(followed.robot - followed.reckoned)[-1, :2])
    assert steps > 5.0
    assert 1e-4 * steps < off < 0.1 * steps


def test_the_robot_keeps_to_the_one_it_follows(followed):
    assert (followed.apart < RULES.reach).all()
    assert followed.speed.max() <= RULES.speed
    assert not followed.bumped.any()


def test_a_story_without_the_camera_renders_no_image(monkeypatch):
    monkeypatch.setitem(behaviours.DURATION, "survey", 0.5)
    monkeypatch.setattr(sessions, "skin_model", None)
    monkeypatch.setattr(behaviours.Sensing, "_image", None)
    told = behaviours.told.__wrapped__("survey", SEED, behaviours.WITHOUT_CAMERA, RULES)
    assert len(told.times) == 10


def test_a_patient_robot_asks_later(monkeypatch):
    """Laser and sonars alone: the sabotage is in the patience, not in what is seen."""
    quick, slow = (
        behaviours.told.__wrapped__("survey", SEED, behaviours.WITHOUT_CAMERA, rules)
        for rules in (RULES, behaviours.SLOW)
    )
    assert np.array_equal(quick.visitor, slow.visitor)
    assert behaviours.delays([quick], RULES.close)[0] <= behaviours.PROMPT
    assert behaviours.delays([slow], RULES.close)[0] > behaviours.PROMPT


# Films -------------------------------------------------------------------------------------------


def test_words_stand_for_a_while():
    told = story([5], [1.0] * 20)
    assert [k for k in range(20) if films._last_word(told, k)] == [5, 6, 7]
    assert set(films._WORDS) == set(SAID) - {""}


def test_a_frame_shows_what_is_believed(followed):
    """One filled ellipse for the one it is about, and none if nothing is believed."""
    _, ax = films.figure(width=films.WIDTH, height=films.HEIGHT)
    faces = np.array([[[0.0, 0.0], [1.0, 0.0]]])
    none = {name: getattr(followed, name)[:0] for name in ("mean", "cov", "weight", "status")}
    nothing = replace(followed, counts=0 * followed.counts, **none)
    drawn = []
    for story in (nothing, followed):
        films.frame(ax, story, 60, faces, np.zeros((0, 3)))
        drawn.append(len(ax.patches))
    row = slice(followed.counts[:60].sum(), followed.counts[:61].sum())
    assert (followed.status[row] == PARTNER).sum() == 1
    assert drawn == [2, 3]  # robot and person; and the hypothesis
