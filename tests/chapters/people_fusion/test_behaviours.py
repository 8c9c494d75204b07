"""Laws of the behaviours: staging, stories written down by hand, and short ones told."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from data_synth.people import SonarScan
from robot_perception.book import people_fusion as page
from robot_perception.book import people_sensors
from robot_perception.book.people_fusion import BEHAVES, LASER_SONAR, RING, STRAYS
from robot_perception.chapters.people_fusion import films
from robot_perception.people import Detections, polar
from robot_perception.people.behaviours import PARTNER

SEED = 5001  # one of those that the rules were chosen on
KINDS = ("guide", "blocked", "follow", "survey")


def story(asked=(), apart=(1.0,)):
    """Return a story of a step a second, in which the robot asks back at some of them."""
    k = len(apart)
    said = np.full(k, "", dtype="U16")
    said[list(asked)] = "come back"
    return SimpleNamespace(times=np.arange(k, dtype=float), apart=np.array(apart, float), said=said)


LEFT = [1.0] * round(STRAYS + 3) + [4.0] * 10
"""Strays, and is too far away from the third second after that on."""


@pytest.mark.parametrize(
    ("asked", "delay"),
    [([STRAYS + 6], 3.0), ([STRAYS + 6, STRAYS + 9], 3.0), ([STRAYS + 1], 0.0)],
)
def test_delay_counts_from_when_somebody_is_too_far_away(asked, delay):
    found = page.noticed(story(np.array(asked, dtype=int), LEFT), 3.0)
    assert (found["left"], found["in time"], found["after"]) == (True, True, delay)


def test_who_asks_too_late_or_never_or_before_they_stray_has_noticed_nothing():
    late = round(STRAYS) + 3 + round(page.PROMPT) + 1
    for asked in ([late], [], [3]):
        assert not page.noticed(story(asked, LEFT), 3.0)["in time"]
    stays = page.noticed(story([round(STRAYS) + 4], [1.0] * 25), 3.0)
    assert (stays["left"], stays["in time"]) == (False, False)


def test_false_stops_are_those_before_anybody_leaves():
    assert page.noticed(story([2, 5, round(STRAYS) + 4], LEFT), 3.0)["early"] == 2
    assert page.noticed(story([round(STRAYS) + 4], LEFT), 3.0)["early"] == 0


def test_seeds_of_the_rules_and_of_the_scores_never_meet():
    scored = [*page.guided.replicates, *page.surveyed.replicates, *page.cleared.replicates,
              *page.invited.replicates]  # fmt: skip
    assert len(set(scored)) == 200
    assert not set(range(5001, 5011)) & set(scored)
    assert page.followed.replicates == page.surveyed.replicates  # other worlds all the same


# Staging -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["guide", "blocked"])
def test_no_guide_arrives_before_its_story_ends(kind):
    _, route = page.stage(kind, np.random.default_rng(SEED))
    assert np.hypot(*np.diff(route, axis=0).T).sum() > page.LEADS * page.DURATION[kind]


@pytest.mark.parametrize("beside", [False, True])
def test_two_stand_in_the_way_until_they_are_asked_or_beside_it(beside):
    world, route = page.stage("blocked", np.random.default_rng(SEED), beside=beside)
    two = world.now.positions[1:]
    assert page.acts.blocks(two, route, page.WIDTH).tolist() == [not beside] * 2
    for other in ("", "come back", "thank you"):
        page.hears(world, other)
    assert [act.asked for act in world.acts[1:]] == [np.inf] * 2
    world.advance(0.2)
    page.hears(world, "clear the path")
    assert [act.asked for act in world.acts[1:]] == [world.now.time] * 2
    for _ in range(15):
        world.advance(0.2)
    assert not page.acts.blocks(world.now.positions[1:], route, page.WIDTH).any()


def test_who_is_followed_never_stops():
    world, _ = page.stage("follow", np.random.default_rng(SEED))
    (act,) = world.acts
    assert act.times[-1] >= page.DURATION["follow"]


# What the robot knows ----------------------------------------------------------------------------


def test_the_map_tells_walls_from_people_where_the_robot_takes_itself_to_be():
    """Of two readings to one side, one ends at the wall and the other well before it."""
    world, _ = page.stage("survey", np.random.default_rng(SEED))
    reports, pose = page.Reports(world, SEED, LASER_SONAR), np.array([*world.now.robot[:2], 0.0])
    side = int(np.abs(RING.angles - np.pi / 2).argmin())
    wall = world.office.rooms[-1, 3] - pose[1] - RING.radius

    def heard(ranges, pose=pose):
        readings = np.full(RING.count, np.inf)
        readings[side] = ranges
        return len(reports.detect(SonarScan(0.1, readings), pose))

    assert (heard(wall), heard(wall - 0.6)) == (0, 1)
    assert heard(wall - 0.6, pose + np.array([0, 0.6, 0])) == 0  # it is wrong by that


def test_a_reading_is_taken_in_where_the_wheels_say_that_the_robot_was_at_its_time():
    """Half-way between two moments half of what they rolled, and all of it in the end."""
    start, rolled, taken = np.array([1.0, 2.0, np.pi / 2]), np.array([0.2, 0.0, 0.0]), []
    before, now = (SimpleNamespace(time=time) for time in (4.0, 4.2))
    one = Detections(4.1, "laser", polar(np.array([2.0]), np.zeros(1), 0.1, 0.1))

    def detect(reading, pose):
        taken.append(pose)
        return reading

    reports = SimpleNamespace(due=lambda *_: [one], detect=detect)
    robot = page.robot_of("guide", BEHAVES)
    known, _ = page.live(robot, robot.start(start), reports, rolled, before, now, None)
    assert taken == [pytest.approx([1.0, 2.1, np.pi / 2])]
    assert known.people.pose == pytest.approx(taken[0])
    assert known.pose == pytest.approx([1.0, 2.2, np.pi / 2])


@pytest.mark.parametrize("kind", KINDS)
def test_the_robot_of_a_story_does_what_the_story_is_about(kind):
    robot = page.robot_of(kind, BEHAVES)
    assert robot.task == {"blocked": "guide"}.get(kind, kind)
    assert robot.behaviours.speed == (page.LEADS if robot.task == "guide" else BEHAVES.speed)
    assert (robot.known, robot.width) == (page.KNOWN, page.WIDTH)


# Stories -----------------------------------------------------------------------------------------


happened = page.happened.__wrapped__  # whatever this computer has kept


@pytest.fixture(scope="module")
def followed():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(page.DURATION, "follow", 10.0)
        found = happened("follow", SEED, LASER_SONAR)
    apart = np.linalg.norm(found["people"][:, 0] - found["robot"][:, :2], axis=-1)
    return SimpleNamespace(**found, apart=apart)


def test_the_same_seed_tells_the_same_story(followed, monkeypatch):
    monkeypatch.setitem(page.DURATION, "follow", 1.0)
    again = happened("follow", SEED, LASER_SONAR)
    for name, part in again.items():
        assert np.array_equal(part, getattr(followed, name)[: len(part)]), name
    other = happened("follow", SEED + 1, LASER_SONAR)
    assert not np.allclose(other["people"], again["people"])


def test_the_wheels_slip(followed):
    """The reckoned path is not the true one, and off by a few parts in a hundred."""
    steps = np.hypot(*np.diff(followed.robot[:, :2], axis=0).T).sum()
    off = np.hypot(*(followed.robot - followed.reckoned)[-1, :2])
    assert steps > 3.0
    assert 1e-4 * steps < off < 0.1 * steps


def test_the_robot_keeps_to_the_one_it_follows(followed):
    assert (followed.apart < BEHAVES.reach).all()
    assert followed.speed.max() <= BEHAVES.speed
    assert not followed.bumped.any()


def test_a_story_without_the_camera_renders_no_image(monkeypatch):
    monkeypatch.setitem(page.DURATION, "survey", 0.5)
    monkeypatch.setattr(people_sensors, "skin_model", None)
    monkeypatch.setattr(page.Sensing, "_image", None)
    assert len(happened("survey", SEED, LASER_SONAR)["times"]) == 10


def test_who_comes_near_is_asked_nearer_and_then_to_take_part(monkeypatch):
    monkeypatch.setitem(page.DURATION, "survey", 9.0)
    monkeypatch.setattr(page, "happened", cache(happened))
    found = page.invited.one(SEED, sensors=LASER_SONAR)
    assert found["in time"]
    assert found["early"] == 0
    said = [word for word in page.told("survey", SEED, LASER_SONAR).said.tolist() if word]
    assert said[:2] == ["come nearer", "take part"]


@pytest.mark.parametrize(
    ("asked", "in_time", "early"), [(5, True, 0), (3, False, 1), (9, False, 0)]
)
def test_somebody_is_asked_nearer_when_they_come_within_reach(monkeypatch, asked, in_time, early):
    comes = story(apart=4.0 - 0.25 * np.arange(13))  # m a second; within three metres after five
    comes.said[asked] = "come nearer"
    monkeypatch.setattr(page, "told", lambda *how: comes)
    found = page.invited.one(SEED)
    assert (found["in time"], found["early"]) == (in_time, early)


def test_a_guide_whose_path_is_blocked_asks_waits_and_drives_on(monkeypatch):
    monkeypatch.setitem(page.DURATION, "blocked", 7.0)
    monkeypatch.setattr(page, "happened", cache(happened))
    assert page.cleared.one(SEED)["asked"]
    seen = page.told("blocked", SEED, LASER_SONAR)
    asked = int(np.flatnonzero(seen.said == "clear the path")[0])
    assert (seen.speed[asked : asked + 10] == 0).all()
    assert seen.speed[:asked].max() > 0


# Films -------------------------------------------------------------------------------------------


def test_words_stand_for_a_while():
    told = story([5], [1.0] * 20)
    assert [k for k in range(20) if films._last_word(told, k)] == [5, 6, 7]


def test_a_frame_shows_what_is_believed(followed):
    """One filled ellipse for the one it is about, and none if nothing is believed."""
    _, ax = films.figure(width=films.WIDTH, height=films.HEIGHT)
    faces = np.array([[[0.0, 0.0], [1.0, 0.0]]])
    none = {name: getattr(followed, name)[:0] for name in ("mean", "cov", "weight", "status")}
    nothing = SimpleNamespace(**vars(followed) | none | {"counts": 0 * followed.counts})
    drawn = []
    for one in (nothing, followed):
        films.frame(ax, one, 30, faces, np.zeros((0, 3)))
        drawn.append(len(ax.patches))
    row = slice(followed.counts[:30].sum(), followed.counts[:31].sum())
    assert (followed.status[row] == PARTNER).sum() == 1
    assert drawn == [2, 3]  # robot and person; and the hypothesis


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_frame_of_a_film_is_one_in_which_something_is_said(kind):
    seen = SimpleNamespace(**page.filmed(kind))
    poster = films._TOLD[kind][0]
    look = np.linspace(0, len(seen.looks) - 1, films.FRAMES).round().astype(int)[poster]
    assert films._last_word(seen, int(seen.looks[look])) or kind == "follow"
    assert poster > 10
