"""The stored maps of two real buildings."""

import numpy as np
import pytest

from data_synth.laser import Scanner, scan
from robot_perception.chapters.walls import recordings
from robot_perception.datasets import LaserLog, ReadReport
from studies.records import records


@pytest.mark.parametrize("recording", [recordings.FR079, recordings.INTEL], ids=lambda r: r.store)
def test_stored_map_is_one(recording):
    found = recording.stored().result
    assert found.walls == len(found.ends) == len(found.scans)
    assert found.scans.min() >= recordings.LEAST_SCANS
    assert found.direction_share.sum() == pytest.approx(1.0)
    assert 0.5 < found.square <= 1.0
    assert 0 < found.shared <= found.walls


def map_of_room(ring):
    """The map of a room with these corners, recorded from ten places, twice."""
    faces = np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)
    rng, scanner = np.random.default_rng(0), Scanner(dropout=0.0)
    poses = np.column_stack([rng.uniform([2, 1], [3, 2], (20, 2)), 2 * np.pi * np.arange(20) / 5])
    ranges = scan(faces, poses, scanner, rng=rng).ranges
    report = ReadReport(records(), {}, {})
    log = LaserLog(ranges, scanner.angles, poses, poses, np.arange(20.0), 12.0, report)
    return recordings.recorded_map(log, 1)


def test_walls_of_a_room_that_lean_to_both_sides_are_aligned():
    found = map_of_room(np.array([[0.0, 0], [6, 0.2], [6.2, 4.2], [0, 4]]))
    assert found.walls == 4
    assert found.square == pytest.approx(1.0)


def test_map_of_a_room_has_its_directions_by_length():
    """A room with one slanted wall."""
    found = map_of_room(np.array([[0.0, 0], [6, 0], [6, 2], [4, 4], [0, 4]]))
    assert (found.used, found.walls, found.shared) == (20, 5, 5)
    slanted, length = np.sqrt(8), 16 + np.sqrt(8)
    assert found.length == pytest.approx(length, rel=0.03)
    assert found.explained > 0.98
    at = {d: s for d, s in zip(found.directions, found.direction_share, strict=True) if s > 0}
    assert set(at) <= {2.5, 42.5, 47.5, 87.5}
    share = pytest.approx(slanted / length, abs=0.01)
    assert at.get(42.5, 0.0) + at.get(47.5, 0.0) == share
    assert 1 - found.square == share
    assert min(found.square_at, 90 - found.square_at) <= 5
    assert found.offset_mm < 20
    assert found.turn_deg < 1
