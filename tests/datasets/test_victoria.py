"""Victoria Park's files: read back, broken chains and damage named with file and line."""

import numpy as np
import pytest
from scipy.io import savemat
from scipy.sparse import coo_array

from robot_perception.datasets import (
    CorruptLog,
    read_fixes,
    read_landmark_graph,
    read_vehicle,
    victoria,
)
from tests.datasets.here import recording
from tests.datasets.writing import write

MOTION = b"0.01 0.001 0.002 0.04 0.003 0.05"
LINES = [
    b"# a drive",
    b"ODOMETRY 0 1 1.5 0.25 0.5 " + MOTION,
    b"LANDMARK 3 2 4.0 -2.0 0.4 0.1 0.5",
    b"LANDMARK 0 2 5.0 -3.0 0.4 0 0.4",
    b"ODOMETRY 1 3 2.5 0 -0.5 " + MOTION,
    b"LANDMARK 3 1 1.0 1.0 0.4 0 0.4",
]


def test_every_number_is_read_back_in_the_order_of_the_drive(tmp_path):
    graph = read_landmark_graph(write(tmp_path / "a.txt.gz", LINES))
    np.testing.assert_array_equal(graph.motions, [[1.5, 0.25, 0.5], [2.5, 0, -0.5]])
    expected = [[0.01, 0.001, 0.002], [0.001, 0.04, 0.003], [0.002, 0.003, 0.05]]
    np.testing.assert_array_equal(graph.motion_covs, [expected] * 2)
    np.testing.assert_array_equal(graph.observers, [0, 2, 2])  # pose 3 of the file is the third
    np.testing.assert_array_equal(graph.landmarks, [2, 2, 1])  # of a pose as in the file
    np.testing.assert_array_equal(graph.values, [[5, -3], [4, -2], [1, 1]])
    np.testing.assert_array_equal(graph.value_covs[1], [[0.4, 0.1], [0.1, 0.5]])
    assert graph.report.kept == {"ODOMETRY": 2, "LANDMARK": 3}
    assert graph.report.others == {"#": 1}


def test_sightings_follow_the_drive_whatever_its_poses_are_called(tmp_path):
    lines = [line.replace(b"ODOMETRY 0 1", b"ODOMETRY 0 7") for line in LINES]
    lines = [line.replace(b"ODOMETRY 1 3", b"ODOMETRY 7 3") for line in lines]
    graph = read_landmark_graph(write(tmp_path / "a.txt", [*lines, b"LANDMARK 7 1 2 2 0.4 0 0.4"]))
    np.testing.assert_array_equal(graph.observers, [0, 1, 2, 2])
    np.testing.assert_array_equal(graph.values, [[5, -3], [2, 2], [4, -2], [1, 1]])


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (b"ODOMETRY 1 4 1 0 0 " + MOTION, "does not begin at the pose where the motion before it"),
        (b"ODOMETRY 3 1 1 0 0 " + MOTION, "repeats a pose"),
        (b"ODOMETRY 3 4 1 0 0 1 2 0 1 0 1", "its matrix is not positive definite"),
        (b"LANDMARK 3 8 1 1 0.4 0 0", "its matrix is not positive definite"),
        (b"LANDMARK 9 8 1 1 0.4 0 0.4", "its pose is not among those the motions lead to"),
        (b"LANDMARK 3 1 1 1 0.4 0 0.4", "repeats a sighting"),
    ],
)
def test_bad_line_is_named(tmp_path, line, reason):
    path = write(tmp_path / "a.txt", [*LINES, line])
    with pytest.raises(CorruptLog, match=rf"a\.txt, line 7: .*{reason}"):
        read_landmark_graph(path)


def test_no_motion_at_all(tmp_path):
    with pytest.raises(CorruptLog, match="no ODOMETRY line"):
        read_landmark_graph(write(tmp_path / "b.txt", [b"LANDMARK 3 7 1 1 1 0 1"]))


def matlab(path, **arrays):
    savemat(path, arrays)
    return path


TIME, ONES = np.array([[0], [25], [50]], dtype=np.int32), np.ones((3, 1))


def test_vehicle_and_fixes_are_read_back_in_seconds(tmp_path):
    car = read_vehicle(matlab(tmp_path / "a.mat", time=TIME, speed=2 * ONES, steering=0.5 * ONES))
    np.testing.assert_array_equal(car.times, [0, 0.025, 0.05])
    np.testing.assert_array_equal(car.speeds, [2, 2, 2])
    np.testing.assert_array_equal(car.steerings, [0.5] * 3)
    fixes = read_fixes(matlab(tmp_path / "b.mat", timeGps=TIME, Lo_m=3 * ONES, La_m=-ONES))
    np.testing.assert_array_equal(fixes.times, [0, 0.025, 0.05])
    np.testing.assert_array_equal(fixes.positions, [[3, -1]] * 3)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"timeGps": TIME, "Lo_m": ONES}, "La_m"),
        ({"timeGps": TIME, "Lo_m": ONES, "La_m": ONES[:2]}, r"have \[2, 3\] values"),
        ({"timeGps": TIME[:0], "Lo_m": ONES[:0], "La_m": ONES[:0]}, r"have \[0\] values"),
        ({"timeGps": TIME, "Lo_m": ONES, "La_m": np.nan * ONES}, "La_m is NaN .* at row 1"),
        ({"timeGps": TIME[::-1], "Lo_m": ONES, "La_m": ONES}, "timeGps does not rise after row 1"),
        ({"timeGps": 25 * (TIME > 0), "Lo_m": ONES, "La_m": ONES}, "does not rise after row 2"),
    ],
)
def test_bad_arrays_are_named(tmp_path, arrays, message):
    with pytest.raises(CorruptLog, match=rf"a\.mat: .*{message}"):
        read_fixes(matlab(tmp_path / "a.mat", **arrays))


@pytest.mark.parametrize(
    ("array", "kind"),
    [
        (np.array("fast"), "<U4"),
        ({"left": 1.0}, "left"),
        (coo_array(np.eye(3)), "object"),
        (ONES + 1j, "complex128"),
    ],
    ids=["text", "struct", "sparse", "complex"],
)
def test_arrays_that_hold_no_real_numbers_are_refused(tmp_path, array, kind):
    path = matlab(tmp_path / "a.mat", timeGps=TIME, Lo_m=array, La_m=ONES)
    with pytest.raises(CorruptLog, match=rf"a\.mat: .*Lo_m holds no real numbers but .*{kind}"):
        read_fixes(path)


def test_what_is_no_matlab_file_is_named(tmp_path):
    path = matlab(tmp_path / "a.mat", timeGps=TIME, Lo_m=ONES, La_m=ONES)
    path.write_bytes(path.read_bytes()[:150])
    with pytest.raises(CorruptLog, match=r"a\.mat: not a MATLAB file with timeGps, Lo_m, La_m \("):
        read_fixes(path)
    with pytest.raises(FileNotFoundError, match=r"b\.mat"):
        read_vehicle(tmp_path / "b.mat")


@pytest.mark.parametrize(("place", "byte"), [(145, 9), (172, 15), (185, 255)])
def test_damage_that_ends_scipys_interpreter_is_an_error_like_any_other(tmp_path, place, byte):
    path = matlab(tmp_path / "a.mat", timeGps=TIME, Lo_m=ONES, La_m=ONES)
    content = bytearray(path.read_bytes())
    content[place] = byte
    path.write_bytes(content)
    with pytest.raises(CorruptLog, match=r"a\.mat: not a MATLAB file with timeGps"):
        read_fixes(path)


@pytest.mark.parametrize(
    ("reading", "cause"),
    [
        ("import os; os.abort()", "the reading process ended with -6"),
        ("import time; time.sleep(60)", "cannot be read in 0.5 s"),
    ],
)
def test_a_reading_process_that_ends_or_hangs_is_named(tmp_path, monkeypatch, reading, cause):
    path = matlab(tmp_path / "a.mat", timeGps=TIME, Lo_m=ONES, La_m=ONES)
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
    fixes = read_fixes(found / "aa3_gpsx.mat")
    assert fixes.positions.shape == (4466, 2)
    assert np.diff(fixes.times).max() > 50  # the receiver failed now and then
