"""One's own tables and trajectories: what was written is read back, the rest stops at its line."""

import gzip
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from robot_perception.datasets import CorruptLog, read_columns, read_ranges, read_track
from robot_perception.slam.planar import CartesianSensor, Settings, run_filter
from tests.slam.planar.drives import R, drive
from tests.unchecked import unchecked

LIMITS = {"time_s": np.inf, "id": 100.0, "bearing_rad": 7.0}
ROWS = "bearing_rad,time_s,note,id\n0.5,1.5e1,1,3\n# pause\n\n -7 ,2,2, 4\n"


def put(folder, text, name="own.csv"):
    path = folder / name
    path.write_bytes(gzip.compress(text.encode()) if name.endswith(".gz") else text.encode())
    return path


@pytest.mark.parametrize("name", ["own.csv", "own.csv.gz"])
def test_columns_are_found_by_name(tmp_path, name):
    found = read_columns(put(tmp_path, ROWS, name), LIMITS, integers=["id"])
    assert list(found) == list(LIMITS)
    np.testing.assert_array_equal(found["time_s"], [15, 2])
    np.testing.assert_array_equal(found["bearing_rad"], [0.5, -7])
    np.testing.assert_array_equal(found["id"], [3, 4])
    assert found["id"].dtype == np.int64


def test_optional_columns_may_be_missing(tmp_path):
    path = put(tmp_path, "time_s\n1\n")
    found = read_columns(path, {"time_s": 9.0, "id": 9.0}, optional=["id"], integers=["id"])
    assert list(found) == ["time_s"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "own.csv: the file is empty"),
        ("# nothing\n", "no column time_s and no column id and .*; there is nothing"),
        ("0,1,2\n", "line 1: no column time_s and .*; there is 0, 1, 2"),
        ("time_s,id\n1,2\n", "line 1: no column bearing_rad; there is time_s, id"),
        ("time_s,id,bearing_rad,id\n1,2,3,4\n", "line 1: column id is there twice"),
        ("time_s,id,bearing_rad\n", "own.csv: no row line"),
        ("time_s,id,bearing_rad\n1,2,3\n1,2\n", "line 3: fewer values"),
        ("time_s,id,bearing_rad\n1,2,3,4\n", "line 2: more values"),
        ("time_s,id,bearing_rad\n1,2,x\n", "line 2: bearing_rad is 'x', not a finite number"),
        ("time_s,id,bearing_rad\n1,2,\n", "line 2: bearing_rad is '', not a finite number"),
        ("time_s,id,bearing_rad\ninf,2,3\n", "line 2: time_s is 'inf', not a finite number"),
        ("time_s,id,bearing_rad\n1,2,3\n1,2,nan\n", "line 3: bearing_rad is 'nan', not a finite"),
        ("time_s,id,bearing_rad\n1,2,-45\n", "bearing_rad is '-45', beyond 7: is the unit right"),
        ("time_s,id,bearing_rad\n1,2.5,3\n", "line 2: id is '2.5', not a whole number"),
        ("time_s,id,bearing_rad\n1_0,2,3\n", "line 2: time_s is '1_0', not a finite number"),
    ],
)
def test_bad_tables_stop_at_their_line(tmp_path, text, message):
    with pytest.raises(CorruptLog, match=message):
        read_columns(put(tmp_path, text), LIMITS, integers=["id"])


@given(hnp.arrays(float, hnp.array_shapes(min_dims=2, max_dims=2), elements=st.floats(0, 90)))
def test_ranges_are_the_same_from_array_and_text(tmp_path_factory, ranges):
    folder = tmp_path_factory.mktemp("ranges")
    ranges[0, 0] = 1.0
    expected = np.where(ranges >= 80, np.inf, ranges)
    np.save(folder / "own.npy", ranges)
    np.savetxt(folder / "own.csv", ranges, "%.17g", ",")
    for name in ("own.npy", "own.csv"):
        np.testing.assert_array_equal(read_ranges(folder / name, max_range=80.0), expected)


def test_void_readings_are_kept(tmp_path):
    path = put(tmp_path, "1,nan,inf\n-1,0,80\n")
    expected = [[1, np.nan, np.inf], [-1, 0, np.inf]]
    np.testing.assert_array_equal(read_ranges(path, max_range=80.0), expected)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1,2\n1\n", "line 2: fewer values"),
        ("1,2\n1,2,3\n", "line 2: more values"),
        ("r1,r2\n1,2\n", "line 1: a value is not a number: 'r1' in column 1"),
        ("1,2\n1,x\n", "line 2: a value is not a number: 'x' in column 2"),
        ("80,80\n", "own.csv: no reading is below 80 m; are they in metres?"),
        ("300,4000\n", "own.csv: no reading is below 80 m; are they in metres?"),
        ("# nothing\n", "no scan line"),
    ],
)
def test_bad_ranges_stop_at_their_line(tmp_path, text, message):
    with pytest.raises(ValueError, match=message):
        read_ranges(put(tmp_path, text), max_range=80.0)


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros(3), r"ranges must be \(scans, beams\), got \(3,\)"),
        (np.zeros((0, 3)), r"got \(0, 3\)"),
        (np.array([["a"]]), "no array of numbers"),
        (np.array([[None]]), "no array of numbers"),
        (np.array([[1.0, 2.0], [3.0, -2e6]]), "reading 2, 2 is -2e\\+06, no distance in metres"),
    ],
)
def test_arrays_that_are_no_ranges(tmp_path, array, message):
    np.save(tmp_path / "own.npy", array)
    with unchecked(), pytest.raises(ValueError, match=message):
        read_ranges(tmp_path / "own.npy", max_range=80.0)


def test_a_run_is_read_back_as_it_was_written(tmp_path):
    made = drive(np.random.default_rng(5))
    steps = [
        type(step)(step.motion, step.observations, time=k / 7) for k, step in enumerate(made.steps)
    ]
    run = run_filter(made.start, steps, Settings(CartesianSensor(R)))
    run.to_csv(tmp_path / "run.csv")
    run.to_tum(tmp_path / "run.tum")
    full, flat = read_track(tmp_path / "run.csv"), read_track(tmp_path / "run.tum")
    for track in (full, flat):
        np.testing.assert_allclose(track.times, run.times, atol=1e-9)
        np.testing.assert_allclose(track.poses, run.poses, atol=1e-8)
    np.testing.assert_allclose(full.covs, run.pose_covs, rtol=1e-11)
    assert flat.covs is None


def test_a_run_far_from_the_origin_keeps_its_decimals(tmp_path):
    made = drive(np.random.default_rng(5))
    run = run_filter(made.start, made.steps, Settings(CartesianSensor(R)))
    times = 1.7e9 + np.arange(len(run.poses)) / 7
    run = replace(run, times=times, poses=np.add(run.poses, [458074.604, 5429380.172, 0]))
    run.to_csv(tmp_path / "run.csv")
    run.to_tum(tmp_path / "run.tum")
    for name in ("run.csv", "run.tum"):
        track = read_track(tmp_path / name)
        np.testing.assert_allclose(track.times, times, rtol=0, atol=1e-6)
        np.testing.assert_allclose(track.poses, run.poses, rtol=0, atol=1e-6)


@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(-3.1, 3.1), st.sampled_from([-1, 1]))
def test_the_heading_of_a_quaternion_is_scipys_yaw(tmp_path_factory, roll, pitch, yaw, sign):
    """Also of the opposite quaternion, and of a robot that is tipped a little."""
    roll, pitch = roll / 2, pitch / 2
    quaternion = sign * Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat()
    path = tmp_path_factory.mktemp("tum") / "own.tum"
    path.write_text("# by hand\n7 1 2 3 " + " ".join(map(repr, quaternion.tolist())) + "\n")
    track = read_track(path)
    np.testing.assert_allclose(track.poses, [[1, 2, yaw]], atol=1e-9)
    assert track.times.tolist() == [7.0]


CSV = "time_s,x_m,y_m,heading_rad"
COVS = f"{CSV},cov_xx,cov_xy,cov_xh,cov_yy,cov_yh,cov_hh"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"{CSV}\n1,0,0,0\n#\n1,0,0,0\n", "line 4: times must rise, got 1 before 1"),
        (f"{CSV}\n1,0,0,0\n2,0,0,90\n", "line 3: heading_rad is 90, .* are these degrees"),
        ("time_s,x_m,y_m\n1,0,0\n", "line 1: no column heading_rad"),
        (f"{CSV},cov_xx\n1,0,0,0,1\n", "some covariances are there, but no column cov_xy"),
        (
            f"{COVS}\n1,0,0,0,1,0,0,1,0,1\n2,0,0,0,1,2,0,1,0,1\n",
            "line 3: covariances must be",
        ),
        ("1 0 0 0 0 0 0\n", "line 1: fewer values"),
        ("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "line 2: its time does not lie after"),
        ("2 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n", "line 2: its time does not lie after"),
        ("1 0 0 0 0 0 0 1.01\n", "line 1: its quaternion qx qy qz qw is not of unit length"),
        ("1 0 0 0 0 0 1 1\n", "line 1: its quaternion qx qy qz qw is not of unit length"),
        ("1 0 0 0 1 0 0 0\n", "line 1: its quaternion qx qy qz qw turns the robot onto its side"),
        ("1 0 0 0 0 0 nan 1\n", "line 1: a value is NaN or infinite, in column 7"),
        ("1 0 0 0 0 0 x 1\n", "line 1: a value is not a number: 'x'"),
    ],
)
def test_bad_trajectories_are_refused(tmp_path, text, message):
    with pytest.raises(CorruptLog, match=message):
        read_track(put(tmp_path, text))
