"""The stored maps of two real buildings."""

import pytest

from robot_perception.chapters.walls import recordings


@pytest.mark.parametrize("recording", [recordings.FR079, recordings.INTEL], ids=lambda r: r.store)
def test_stored_map_is_one(recording):
    found = recording.stored().result
    assert found.walls == len(found.ends) == len(found.scans)
    assert found.scans.min() >= recordings.LEAST_SCANS
    assert found.direction_share.sum() == pytest.approx(1.0)
    assert 0.5 < found.square <= 1.0
    assert 0 < found.shared <= found.walls
