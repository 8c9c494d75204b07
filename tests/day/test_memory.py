"""What is kept of a way: where pictures of it were taken, and which come next."""

from types import SimpleNamespace

import numpy as np
import pytest

from robot_perception.ceiling.mosaic import NoCommonPattern
from robot_perception.ceiling.visual_memory import KeyRules
from robot_perception.day.memory import Lesson, Memory, remember
from robot_perception.walls.wall_map import WallMap

EAST = np.column_stack([np.linspace(0, 5, 51), np.zeros(51), np.zeros(51)])
WEST = np.column_stack([np.linspace(5, 0, 51), np.ones(51), np.full(51, np.pi)])
WAY = np.concatenate([EAST, WEST])
SEEN = tuple({"a": np.array([100.0 + k, 80, 0, 1]), "b": np.array([200.0 + k, 60, 0, 1])}
             for k in range(len(WAY)))  # fmt: skip


def memory(places=None):
    places = {"door 1": np.array([2.0, -1.0])} if places is None else places
    nothing = SimpleNamespace()
    return Memory(nothing, WallMap.empty(), WAY, SEEN, {}, nothing, np.zeros(3), places)


def test_the_nearest_picture_looks_about_the_same_way():
    kept = memory()
    assert kept.nearest(np.array([2.0, 0.6, 0.1]), 0.5) == 20
    assert kept.nearest(np.array([2.0, 0.4, 3.1]), 0.5) == 51 + 30
    assert kept.nearest(np.array([2.0, 0.4, -3.1]), 0.5) == 51 + 30  # across ±π
    assert kept.nearest(np.array([2.0, 0.4, np.pi / 2]), 0.5) is None


def test_a_place_is_passed_twice_on_the_way_there_and_back():
    assert memory().passes("door 1", within=2.5) == [20, 81]
    assert memory({"end": np.array([0.0, 0.0])}).passes("end", within=0.5) == [0]
    with pytest.raises(ValueError, match="place must be one of 'door 1', got 'door 2'"):
        memory().passes("door 2")


def test_a_route_begins_and_ends_with_its_pictures():
    found = memory().route(3, 30, KeyRules(common=2, shift=12.0))
    firsts = [one.sightings["a"][0] for one in found]
    assert firsts[0] == 103
    assert firsts[-1] == 130
    assert np.diff(firsts).max() <= 12
    with pytest.raises(NoCommonPattern, match="the way from 3 to 30 has a gap: run must go on"):
        memory().route(3, 30, KeyRules(common=3, shift=12.0))
    with pytest.raises(ValueError, match="last must come after first 30 on the way, got 3"):
        memory().route(30, 3, KeyRules())


def test_a_lesson_without_a_pair_is_none():
    with pytest.raises(TypeError, match="lesson must be a Lesson"):
        remember(None, None, None, None)
    assert Lesson().told == {}
