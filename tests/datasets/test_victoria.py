"""Victoria Park: the order of the drive, the process that reads arrays, and the recording."""

import numpy as np
import pytest

from robot_perception.datasets import (
    CorruptLog,
    read_fixes,
    read_landmark_graph,
    read_vehicle,
    victoria,
)
from tests.datasets.formats.arrays import CHAIN, fixes
from tests.datasets.here import recording
from tests.datasets.writing import write


def test_sightings_follow_the_drive_whatever_its_poses_are_called(tmp_path):
    lines = [line.replace(b"ODOMETRY 0 1", b"ODOMETRY 0 7") for line in CHAIN]
    lines = [line.replace(b"ODOMETRY 1 3", b"ODOMETRY 7 3") for line in lines]
    graph = read_landmark_graph(write(tmp_path / "a.txt", [*lines, b"LANDMARK 7 1 2 2 0.4 0 0.4"]))
    np.testing.assert_array_equal(graph.observers, [0, 1, 2, 2])
    np.testing.assert_array_equal(graph.values, [[5, -3], [2, 2], [4, -2], [1, 1]])


@pytest.mark.parametrize(
    ("reading", "cause"),
    [
        ("import os; os.abort()", "the reading process ended with -6"),
        ("import time; time.sleep(60)", "cannot be read in 0.5 s"),
    ],
)
def test_a_reading_process_that_ends_or_hangs_is_named(tmp_path, monkeypatch, reading, cause):
    path = tmp_path / "a.mat"
    path.write_bytes(fixes())
    monkeypatch.setattr(victoria, "READ_MATLAB", reading)
    monkeypatch.setattr(victoria, "MATLAB_SECONDS", 0.5 if "sleep" in reading else 60)
    with pytest.raises(CorruptLog, match=rf"a\.mat: .*{cause}"):
        read_fixes(path)


def test_recording_holds_what_is_known_of_it():
    found = recording("victoria_park")
    graph = read_landmark_graph(found / "victoria_park_graph.txt.gz")
    assert (len(graph.motions), len(graph.values)) == (6968, 3640)
    assert len(np.unique(graph.landmarks)) == 151
    assert len(read_vehicle(found / "aa3_dr.mat").times) == 61945
    receiver = read_fixes(found / "aa3_gpsx.mat")
    assert receiver.positions.shape == (4466, 2)
    assert np.diff(receiver.times).max() > 50  # the receiver failed now and then
