"""People who walk: scripts to the letter, and nobody through anybody or anything."""

import numpy as np
import pytest

from data_synth.people import (
    STEP,
    Moment,
    Person,
    Visit,
    Wander,
    World,
    make_person,
    walk,
)
from data_synth.people.world import between
from tests.data_synth.offices import office

GRID = 1e-6  # of what a step hands to the next, m: two of them in a step are 4e-5 m/s
OFFICE = office(0)
MIDDLE = (OFFICE.rooms[1, :2] + OFFICE.rooms[1, 2:]) / 2
CORRIDOR = (OFFICE.rooms[-1, :2] + OFFICE.rooms[-1, 2:]) / 2


def world(acts, *, robot=None, seed=0, starts=None):
    people = [make_person(rng=rng) for rng in np.random.default_rng(seed).spawn(len(acts))]
    robot = np.array([*MIDDLE, 0.0]) if robot is None else robot
    return World(OFFICE, people, acts, robot, rng=np.random.default_rng(seed), starts=starts)


def test_a_script_is_walked_as_written_but_for_rounded_corners():
    points = np.array([[0.0, 0], [2, 0], [2, 0], [2, 3]])
    script = walk(points, np.array([0.0, 2, 4, 7]))
    np.testing.assert_allclose(script.position(1.0), [1, 0])
    np.testing.assert_allclose(script.position(3.0), [2, 0])
    np.testing.assert_allclose(script.position(6.0), [2, 2])
    np.testing.assert_allclose(script.position(9.0), [2, 3])
    # the mean of 1 m/s until 2 s and a stop, over 0.35 s before and after
    np.testing.assert_allclose(script.position(2.0), [2 - 0.35**2 / 2 / 0.7, 0])
    times = np.arange(-1, 8, 0.01)
    speeds = np.hypot(*np.diff([script.position(t) for t in times], axis=0).T) / 0.01
    assert speeds.max() < 1.0 + 1e-9
    assert np.abs(np.diff(speeds)).max() < 0.02


@pytest.mark.parametrize(
    ("times", "facing", "words"),
    [
        ([0.0, 1.0, 1.0], "ahead", "times"),
        ([0.0, 0.5, 3.0], "ahead", "waypoints ask for 2.00 m/s"),
        ([0.0, 1.0, 3.0], "back", "facing"),
    ],
)
def test_bad_scripts_are_named(times, facing, words):
    with pytest.raises(ValueError, match=words):
        walk(np.array([[0.0, 0], [1, 0], [1, 1]]), np.array(times), facing=facing)


def test_a_scripted_person_is_there_from_the_first_time_to_the_last():
    spots = MIDDLE + np.array([[-1.5, 1.0], [1.5, 1.0]])
    here = world([walk(spots, np.array([1.0, 4.0]), facing="robot")])
    moments = [here.advance(STEP) for _ in range(round(5 / STEP))]
    present = np.array([m.present[0] for m in moments])
    times = np.array([m.time for m in moments])
    np.testing.assert_array_equal(present, (times > 1 - 1e-9) & (times < 4 + 1e-9))
    walking = next(m for m in moments if m.time > 2.5)
    assert walking.headings[0] == pytest.approx(0.0, abs=0.01)  # along the way
    assert np.exp(1j * walking.gazes[0]) == pytest.approx(np.exp(-1j * np.deg2rad(70)), abs=0.3)


@pytest.mark.parametrize("seed", range(3))
def test_nobody_walks_through_anybody_or_anything(seed):
    here = world([Wander(leaves=0.3)] * 4, seed=seed)
    moments = [here.now] + [here.advance(STEP) for _ in range(round(40 / STEP))]
    places = np.array([m.positions for m in moments])
    there = np.array([m.present for m in moments])
    velocities = np.diff(places, axis=0) / STEP
    steady = there[1:] & there[:-1]
    speeds = np.hypot(*np.moveaxis(velocities, -1, 0))
    assert speeds[steady].max() <= 1.6 + 2 * GRID / STEP
    assert 0.15 < (speeds[steady] > 0.3).mean() < 0.95
    changes = np.linalg.norm(np.diff(velocities, axis=0), axis=-1)[steady[1:] & steady[:-1]] / STEP
    assert np.quantile(changes, 0.995) <= 3.0 + 4 * GRID / STEP**2  # hardest braking aside
    assert (OFFICE.free(places[there]) > 0.15).all()
    for k in range(4):
        gap = np.hypot(*(places[there[:, k], k] - MIDDLE).T)
        assert gap.min() > 0.5
        for other in range(k):
            both = there[:, k] & there[:, other]
            assert np.hypot(*(places[both, k] - places[both, other]).T).min() > 0.5


def test_nobody_walks_on_into_somebody_who_turns_up_before_him():
    start, end = CORRIDOR + np.array([[-3.0, 0.0], [3.0, 0.0]])
    visit = Visit(strays=(0.5,), to=tuple(end))

    def goes(spot, until):
        script = walk(np.array([spot, spot]), np.array([2.0, 9.0]))
        robot = np.array([start[0] - 1.3, start[1], 0.0])
        here = world([visit, script], robot=robot, starts=np.array([start, spot]))
        return np.array([here.advance(STEP).positions[0] for _ in range(round(until / STEP))])

    before, last = goes(MIDDLE, 2.0)[-2:]
    ahead = (last - before) / np.hypot(*(last - before))
    spot = last + 0.6 * ahead
    gaps = np.hypot(*(goes(spot, 3.0) - spot).T)[40:]
    assert gaps[0] == pytest.approx(0.6, abs=0.1)
    assert gaps.min() > 0.54


def test_people_leave_and_come_back():
    here = world([Wander(leaves=1.0)], seed=4)
    there = np.array([here.advance(0.1).present[0] for _ in range(900)])
    changes = np.diff(there.astype(int))
    assert (changes == -1).any()
    assert (changes == 1).any()


def test_a_visitor_follows_strays_and_comes_back_when_asked():
    away = (OFFICE.exits[0] + [1.0, 0]).tolist()
    visit = Visit(strays=(12.0,), to=tuple(away))
    robot = np.array([4.0, CORRIDOR[1], 0.0])
    starts = np.array([[5.4, CORRIDOR[1] + 0.3]])
    for returns in (True, False):
        act = Visit(strays=(12.0,), to=tuple(away), returns=returns)
        here = world([act], robot=robot, starts=starts, seed=1)
        gaps, bumped = [], False
        for _ in range(round(12 / STEP)):
            now = here.advance(STEP, (0.4, 0.0))
            bumped |= here.bumped
            gaps.append(np.hypot(*(now.positions[0] - now.robot[:2])))
        assert max(gaps[60:]) < 2.2
        for _ in range(round(8 / STEP)):
            now = here.advance(STEP)
        assert np.hypot(*(now.positions[0] - now.robot[:2])) > 3.0
        here.ask(0)
        for _ in range(round(14 / STEP)):
            now = here.advance(STEP)
        near = np.hypot(*(now.positions[0] - now.robot[:2])) < 2.0
        assert near == returns
    assert visit.returns


def test_a_visitor_looks_at_the_robot():
    here = world([Visit()], seed=2)
    for _ in range(100):
        now = here.advance(STEP)
    gap = now.robot[:2] - now.positions[0]
    assert np.cos(now.gazes[0] - np.arctan2(gap[1], gap[0])) > np.cos(0.1)


def test_the_robot_drives_as_it_is_told_and_not_into_walls():
    here = world([], robot=np.array([*CORRIDOR, 0.0]))
    for _ in range(40):
        now = here.advance(STEP, (0.5, 0.4))
    turned = 0.4 * 2.0
    radius = 0.5 / 0.4
    expected = CORRIDOR + radius * np.array([np.sin(turned), 1 - np.cos(turned)])
    np.testing.assert_allclose(now.robot, [*expected, turned], rtol=0, atol=40 * 2 * GRID)
    for _ in range(200):
        now = here.advance(STEP, (0.5, 0.0))
    assert here.bumped
    assert OFFICE.free(now.robot[None, :2])[0] >= 0.25


def test_between_two_moments_angles_take_the_short_way():
    first, second = (
        Moment(
            t, np.array([t, 0.0, a]), np.array([[t, 1.0]]), *np.array([[a], [a], [a], [t]]), here
        )
        for t, a, here in ((0.0, 3.0, np.array([True])), (1.0, -3.0, np.array([False])))
    )
    middle = between(first, second, 0.5)
    for angle in (middle.robot[2], middle.headings[0], middle.gazes[0]):
        assert np.cos(angle) == pytest.approx(-1)
    np.testing.assert_allclose(middle.positions, [[0.5, 1.0]])
    assert between(first, second, 0.4).present[0]
    assert not between(first, second, 0.6).present[0]


def test_parts_of_a_step_are_steps():
    one, other = (world([Wander()] * 2, seed=3) for _ in range(2))
    long = one.advance(4 * STEP)
    for _ in range(4):
        short = other.advance(STEP)
    np.testing.assert_array_equal(long.positions, short.positions)
    assert one.before.time == 0.0


def test_what_is_wrong_with_a_world_is_named():
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="acts must be 1"):
        World(OFFICE, [Person()], [], np.array([*MIDDLE, 0.0]), rng=rng)
    with pytest.raises(ValueError, match="robot must stand free"):
        World(OFFICE, [], [], np.array([-5.0, 0.0, 0.0]), rng=rng)
