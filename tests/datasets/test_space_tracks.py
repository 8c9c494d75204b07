"""Trajectories in space: every format gives the poses that were written, between poses as SciPy."""

import gzip

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from robot_perception.datasets import (
    CorruptLog,
    SpaceTrack,
    read_space_track,
    read_track,
    track_format,
    write_kitti,
    write_tum,
)
from robot_perception.geometry import se3
from tests.datasets.space import path_in_space, write_path
from tests.unchecked import unchecked

FORMATS = ("TUM", "KITTI", "EuRoC", "space")
SEEDS = st.integers(0, 2**31)


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("kind", FORMATS)
def test_what_was_written_is_read(kind, packed, tmp_path):
    times, poses = path_in_space(np.random.default_rng(3))
    path = write_path(tmp_path / "path", kind, times, poses)
    if packed:
        path = path.with_suffix(".gz")
        path.write_bytes(gzip.compress((tmp_path / "path").read_bytes()))
    assert track_format(path) == kind
    track = read_space_track(path)
    np.testing.assert_allclose(track.poses, poses, atol=1e-10)
    assert (track.times is None) == (kind == "KITTI")
    if track.times is not None:
        np.testing.assert_allclose(track.times, times, rtol=0, atol=1e-6)


@pytest.mark.parametrize(("write", "kind"), [(write_tum, "TUM"), (write_kitti, "KITTI")])
def test_what_the_library_writes_is_read(write, kind, tmp_path):
    times, poses = path_in_space(np.random.default_rng(4))
    path = tmp_path / "path.txt"
    write(path, *((times, poses) if kind == "TUM" else (poses,)))
    assert track_format(path) == kind
    np.testing.assert_allclose(read_space_track(path).poses, poses, atol=1e-8)


def test_six_digits_are_rotations_and_become_exact(tmp_path):
    _, poses = path_in_space(np.random.default_rng(5))
    np.savetxt(tmp_path / "poses.txt", poses[:, :3].reshape(-1, 12), fmt="%.6f")
    track = read_space_track(tmp_path / "poses.txt")
    np.testing.assert_allclose(track.poses, poses, atol=2e-6)
    R = track.poses[:, :3, :3]
    np.testing.assert_allclose(R.mT @ R, np.broadcast_to(np.eye(3), R.shape), atol=1e-14)


def test_euroc_without_names_and_with_a_comma_at_the_end(tmp_path):
    times, poses = path_in_space(np.random.default_rng(6))
    path = write_path(tmp_path / "data.csv", "EuRoC", times, poses)
    bare = [line + "," for line in path.read_text().splitlines()[1:]]
    path.write_text("\n".join(bare))
    np.testing.assert_allclose(read_space_track(path).poses, poses, atol=1e-10)
    names = "timestamp,p_RS_R_x,p_RS_R_y,p_RS_R_z,q_RS_w,q_RS_x,q_RS_y,q_RS_z"
    path.write_text("\n".join([names, *(line[: line.rindex(",0.0")] for line in bare)]))
    np.testing.assert_allclose(read_space_track(path).poses, poses, atol=1e-10)


@pytest.mark.parametrize("kind", ["TUM", "space"])
def test_times_may_be_counted_in_other_units(kind, tmp_path):
    times, poses = path_in_space(np.random.default_rng(7))
    path = write_path(tmp_path / "path", kind, times * 1000, poses)
    np.testing.assert_allclose(read_space_track(path, time_unit="ms").times, times, atol=1e-6)
    with pytest.raises(CorruptLog, match="time_unit='ms'"):
        read_space_track(path)


def test_tum_between_commas_is_told_by_the_names_in_its_comment(tmp_path):
    path = tmp_path / "path.csv"
    path.write_text("#timestamp,tx,ty,tz,qx,qy,qz,qw\n0,1,2,3,1,0,0,0\n1,1,2,3,1,0,0,0\n")
    assert track_format(path) == "TUM"
    turn = read_space_track(path).poses[0, :3, :3]
    np.testing.assert_allclose(turn, np.diag([1, -1, -1]))  # half a turn about x, not none


def test_a_path_in_the_plane_lies_at_height_nothing(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("time_s,x_m,y_m,heading_rad\n0,1,2,0\n1,2,2,1.5\n")
    assert track_format(path) == "plane"
    track, flat = read_space_track(path), read_track(path)
    np.testing.assert_array_equal(track.times, flat.times)
    np.testing.assert_allclose(track.poses, se3.from_se2(flat.poses))


def test_the_reader_of_planar_tracks_names_the_reader_of_poses_in_space(tmp_path):
    _, poses = path_in_space(np.random.default_rng(8), k=3)
    with pytest.raises(CorruptLog, match=r"line 1: more .* KITTI, in space; read_space_track"):
        read_track(write_path(tmp_path / "poses.txt", "KITTI", np.arange(3), poses))


@pytest.mark.parametrize(
    ("ahead", "reads"), [(np.array([1, 0, 0]), True), (np.array([0, 0, 1]), False)]
)
def test_a_camera_that_drives_along_its_axis_is_in_no_plane(ahead, reads, tmp_path):
    """Places in the axes of a camera, z ahead, are no drive that only has heights."""
    file, way = tmp_path / "a.tum", np.arange(5.0)[:, None] * ahead
    rows = np.column_stack([np.arange(5.0), way, np.tile([0, 0, 0, 1], (5, 1))])
    np.savetxt(file, rows)
    if reads:
        np.testing.assert_array_equal(read_track(file).poses[:, :2], way[:, :2])
    else:
        with pytest.raises(
            ValueError, match=r"a\.tum: its places reach 4\.000 m in z, .*read_space"
        ):
            read_track(file)
    np.testing.assert_array_equal(read_space_track(file).poses[:, :3, 3], way)


@given(SEEDS)
@settings(max_examples=30)
def test_between_poses_a_track_is_scipys(seed):
    rng = np.random.default_rng(seed)
    times, poses = path_in_space(rng, k=8)
    asked = rng.uniform(times[0], times[-1], 20)
    found, covered = SpaceTrack(times, poses).at(asked, longest_gap=1.0)
    assert covered.all()
    turns = Slerp(times, Rotation.from_matrix(poses[:, :3, :3]))(asked)
    np.testing.assert_allclose(found[:, :3, :3], turns.as_matrix(), atol=1e-6)
    for axis in range(3):
        line = np.interp(asked, times, poses[:, axis, 3])
        np.testing.assert_allclose(found[:, axis, 3], line, atol=1e-6)


def test_nothing_is_extrapolated_and_no_long_gap_is_bridged():
    track = SpaceTrack(np.array([0.0, 1, 5]), se3.exp(np.arange(18.0).reshape(3, 6) / 10))
    poses, covered = track.at(np.array([-0.1, 0.0, 0.5, 3.0, 5.0, 5.1]), longest_gap=2.0)
    assert covered.tolist() == [False, True, True, False, True, False]
    assert np.isnan(poses[~covered]).all()
    np.testing.assert_allclose(poses[[1, 4]], track.poses[[0, 2]], atol=1e-12)
    one = SpaceTrack(np.array([2.0]), np.eye(4)[None])
    assert one.at(np.array([1.0, 2.0]), longest_gap=1.0)[1].tolist() == [False, True]


EYE = np.stack([np.eye(4)] * 2)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: SpaceTrack(None, EYE[0]), r"poses must be \(k, 4, 4\)"),
        (lambda: SpaceTrack(None, 2 * EYE), "poses must have the last row"),
        (lambda: SpaceTrack(np.zeros(3), EYE), r"times must be \(2,\) for these poses"),
        (lambda: SpaceTrack(np.ones(2), EYE), "times must rise"),
        (lambda: SpaceTrack(None, EYE).at(np.ones(1), longest_gap=1), "times can be asked of"),
        (lambda: SpaceTrack(np.arange(2), EYE).at(np.ones(1), longest_gap=0), "longest_gap must"),
    ],
)
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises((ValueError, TypeError), match=message):
        build()


SHORT = "timestamp,p_RS_R_x,p_RS_R_y,p_RS_R_z,q_RS_w,q_RS_x,q_RS_y\n1,0,0,0,1,0,0\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 0 0 0 0 0 0 2\n", "line 1: its quaternion qx qy qz qw is not of unit length"),
        ("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "line 2: its time does not lie after"),
        ("1 0 0 0 0 1 0 0 0 0 2 0\n", "line 1: its matrix of 3 × 3 is no rotation"),
        ("-1 0 0 0 0 1 0 0 0 0 1 0\n", "line 1: its matrix of 3 × 3 is no rotation"),
        ("0 0 0 0 0 0 0\n", "line 1: fewer values than announced"),
        ("0.5,0,0,0,1,0,0,0\n", "line 1: its time is not in whole nanoseconds"),
        ("0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0,0\n", "line 2: its time is not in whole nanoseconds"),
        ("0,0,0,0,1,1,0,0\n", "line 1: its quaternion"),
        (SHORT, "no column time_s"),
        ("#timestamp,tx,ty,tz,qx,qy,qz,qw\n0,0,0,0,0,0,0,2\n", "line 2: its quaternion"),
        ("0 2e8 0 0 0 0 0 1\n", "line 1: a place lies beyond 1e\\+08 m"),
        ("1 0 0 2e8 0 1 0 0 0 0 1 0\n", "line 1: a place lies beyond 1e\\+08 m"),
        ("0,2e8,0,0,1,0,0,0\n", "line 1: a place lies beyond 1e\\+08 m"),
        ("0 0 0 0 0 0 0 1\n9e9 0 0 0 0 0 0 1\n", "look like .*time_unit='ns'"),
        ("0,0,0,0,1,0,0\n", "line 1: fewer values than announced"),
        ("time_s,x_m,y_m,z_m,qx,qy,qz,qw\n0,0,0,0,0,0.5,0,1\n", "row 1: its quaternion"),
        ("time_s,x_m,y_m,qx,qy,qz,qw\n0,0,0,0,0,0,1\n", "no column z_m"),
        ("timestamp,tx,ty,tz,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n", "no column time_s"),
        ("a,b\n1,2\n", "no column time_s"),
        ("# nothing\n", "no pose line"),
    ],
)
def test_a_bad_file_is_named(text, message, tmp_path):
    path = tmp_path / "path.txt"
    path.write_text(text)
    with pytest.raises(CorruptLog, match=rf"path\.txt.*{message}"):
        read_space_track(path)
