"""No last bit of a sine survives a step: on every processor the same people walk the same ways."""

from functools import cache

import numpy as np
import pytest

from data_synth._grid import direction, on_grid
from data_synth.people import Session, Visit, World, make_people_office, make_person, make_session
from tests.data_synth.last_bits import WAYS, Way, last_bits

COLUMNS = ("times", "robot", "positions", "headings", "gazes", "phases", "swings", "present")


def session(robot: str) -> Session:
    """Return 45 s of three people, whose robot stands or drives; with an office of its own."""
    rng = np.random.default_rng(7003)
    office = make_people_office(rng=rng)
    return make_session(office, rng=rng, duration=45.0, people=3, robot=robot)


recorded = cache(session)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("robot", ["stands", "drives"])
def test_a_session_is_the_same_with_other_last_bits(robot: str, way: Way):
    expected = recorded(robot)
    with last_bits(way):
        found = session(robot)
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), name)
    np.testing.assert_array_equal(found.office.clearance, expected.office.clearance)
    for name in ("increments", "deviations"):  # noise is put on steps, which are not on a grid
        ours, theirs = (getattr(s.odometry, name) for s in (found, expected))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12)


def test_people_walk_about_in_that_session():
    gone = np.hypot(*np.diff(recorded("drives").positions, axis=0).T).sum(axis=1)
    assert (gone > 3.0).all()
    assert np.hypot(*np.diff(recorded("drives").robot[:, :2], axis=0).T).sum() > 3.0


def visited() -> np.ndarray:
    """Return the steps of a visitor who follows a robot and strays, and of the robot."""
    rng = np.random.default_rng(5)
    office = make_people_office(rng=rng)
    middle = (office.rooms[-1, :2] + office.rooms[-1, 2:]) / 2
    visit = Visit(strays=(20.0,), to=tuple(office.exits[0] + [1.0, 0.0]))
    robot, starts = np.array([4.0, middle[1], 0.3]), np.array([[5.4, middle[1]]])
    world = World(office, [make_person(rng=rng)], [visit], robot, rng=rng, starts=starts)
    steps = []
    for k in range(400):
        if k == 300:
            world.ask(0)
        now = world.advance(0.1, (0.3 * np.cos(0.01 * k), 0.2 * np.sin(0.02 * k)))
        steps.append([*now.robot, *now.positions[0], now.headings[0], now.gazes[0]])
    return np.array(steps)


@pytest.mark.parametrize("way", WAYS)
def test_a_visitor_takes_the_same_way_with_other_last_bits(way: Way):
    expected = visited()
    with last_bits(way):
        np.testing.assert_array_equal(visited(), expected)


def test_the_grid_is_far_below_noise_and_far_above_rounding():
    values = np.random.default_rng(0).uniform(-20, 20, 10000)
    assert np.abs(on_grid(values) - values).max() <= 0.5e-6 + 1e-12
    np.testing.assert_array_equal(on_grid(on_grid(values) + 1e-12), on_grid(values))
    assert not np.signbit(on_grid([-0.0, -1e-9])).any()


def test_directions_are_wrapped_on_their_grid():
    angles = np.random.default_rng(0).uniform(-20, 20, 10000)
    found = direction(angles)
    assert ((found >= -np.pi) & (found < np.pi)).all()
    assert np.abs(np.exp(1j * found) - np.exp(1j * angles)).max() < 1e-6
    np.testing.assert_array_equal(direction(found + 1e-12), found)
    assert len({float(direction(s * np.pi + e)) for s in (-1, 1) for e in (-1e-12, 0, 1e-12)}) == 1
