"""One's own tables and trajectories: what a run wrote is read back, headings are yaws."""

import gzip
from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from robot_perception.datasets import read_columns, read_ranges, read_track
from robot_perception.slam.planar import CartesianSensor, Settings, run_filter
from tests.slam.planar.drives import R, drive


def put(folder, text, name="own.csv"):
    path = folder / name
    path.write_bytes(gzip.compress(text.encode()) if name.endswith(".gz") else text.encode())
    return path


def test_optional_columns_may_be_missing(tmp_path):
    path = put(tmp_path, "time_s\n1\n")
    found = read_columns(path, {"time_s": 9.0, "id": 9.0}, optional=["id"], integers=["id"])
    assert list(found) == ["time_s"]


@given(hnp.arrays(float, hnp.array_shapes(min_dims=2, max_dims=2), elements=st.floats(0, 90)))
def test_ranges_are_the_same_from_array_and_text(tmp_path_factory, ranges):
    folder = tmp_path_factory.mktemp("ranges")
    ranges[0, 0] = 1.0
    expected = np.where(ranges >= 80, np.inf, ranges)
    np.save(folder / "own.npy", ranges)
    np.savetxt(folder / "own.csv", ranges, "%.17g", ",")
    for name in ("own.npy", "own.csv"):
        np.testing.assert_array_equal(read_ranges(folder / name, max_range=80.0), expected)


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
