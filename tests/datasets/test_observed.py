"""What sensors saw is read in the order of time."""

import numpy as np
import pytest

from robot_perception.datasets import read_detections, read_landmarks
from tests.unchecked import unchecked

POLAR = {"range_m": 200, "bearing_rad": 7}
SEEN = "time_s,landmark,range_m,bearing_rad\n"
MOVES = "time_s,speed_m_s,turn_rate_rad_s\n"
FELT = "time_s,sensor,distance_m,direction_rad,distance_sigma_m,direction_sigma_rad\n"


def put(folder, text):
    path = folder / "seen.csv"
    path.write_text(text)
    return path


def test_observations_come_in_the_order_of_their_times(tmp_path):
    """Rows of one time need not stand together; among these the order of the file stays."""
    found = read_landmarks(put(tmp_path, SEEN + "1,7,3,0\n2,7,3,.1\n1,9,2,1\n1,-1,5,0\n"), POLAR)
    assert found.times.tolist() == [1, 1, 1, 2]
    assert found.landmarks.tolist() == [7, 9, -1, 7]
    np.testing.assert_array_equal(found.values, [[3, 0], [2, 1], [5, 0], [3, 0.1]])
    assert found.report.remarks == ("seen.csv: rows were brought into the order of their times",)
    in_order = read_landmarks(put(tmp_path, SEEN + "1,7,3,0\n1,9,3,0\n2,7,3,0\n"), POLAR)
    assert in_order.report.remarks == ()
    assert in_order.report.kept == {"observation": 3}


def test_landmarks_need_no_names(tmp_path):
    found = read_landmarks(put(tmp_path, "time_s,y_m,x_m\n1,0,0\n1,0,0\n"), {"x_m": 9, "y_m": 9})
    assert found.landmarks.tolist() == [-1, -1]
    assert found.values.shape == (2, 2)


def test_detections_tell_who_saw_nobody(tmp_path):
    rows = "2,laser,1,.5,.1,.2\n1,eye,-1,0,0,0\n3,laser,0,0,1,1\n"
    found = read_detections(put(tmp_path, FELT + rows))
    assert found.times.tolist() == [2, 1, 3]
    assert found.sensors.tolist() == ["laser", "eye", "laser"]
    assert found.seen.tolist() == [True, False, True]
    np.testing.assert_array_equal(found.values[0], [1, 0.5, 0.1, 0.2])
    assert read_detections(tmp_path / "seen.csv", {"laser": 1, "eye": 2}).report.lines == 3


def test_sensors_must_be_names(tmp_path):
    with unchecked(), pytest.raises(TypeError, match=r"sensors\[0\] must be a str"):
        read_detections(put(tmp_path, FELT + "1,laser,2,0,1,1\n"), [1])
