"""Trajectories in space: every format gives the poses that were written, between poses as SciPy."""

import gzip
from itertools import product

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
)
from robot_perception.datasets.poses import SPACE
from robot_perception.geometry import se2, se3
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


NAMED = {  # how a file says which column is what, where its quaternions begin, and its unit
    "our names": ("time_s,x_m,y_m,z_m,qx,qy,qz,qw", "xyzw", 1),
    "our names, w first": ("time_s,x_m,y_m,z_m,qw,qx,qy,qz", "wxyz", 1),
    "TUM": ("timestamp,tx,ty,tz,qx,qy,qz,qw", "xyzw", 1),
    "TUM, w first": ("timestamp,tx,ty,tz,qw,qx,qy,qz", "wxyz", 1),
    "TUM in a comment": ("# timestamp tx ty tz qx qy qz qw", "xyzw", 1),
    "in a comment, w first": ("# timestamp tx ty tz qw qx qy qz", "wxyz", 1),
    "EuRoC": (
        "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],"
        "q_RS_z []",
        "wxyz",
        10**9,
    ),
    "short": ("t,x,y,z,q_w,q_x,q_y,q_z", "wxyz", 1),
    "nanoseconds": ("timestamp_ns,px,py,pz,qx,qy,qz,qw", "xyzw", 10**9),
    "a unit in brackets": ("time (ms),x (m),y (m),z (m),qx,qy,qz,qw", "xyzw", 10**3),
    "ROS": (
        "%time,field.pose.position.x,field.pose.position.y,field.pose.position.z,"
        "field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,"
        "field.pose.orientation.w",
        "xyzw",
        1,
    ),
}
TURN = dict(zip("xyzw", (0.0, 0.0, 0.6, 0.8), strict=True))  # in the plane, so that both can read


def upright(path, order="xyzw", unit=1, separator=",", names=None, start=1.4e9):
    """Write a path of two poses."""
    rows = [] if names is None else [names]
    for k in range(2):
        time = f"{round((start + k) * unit)}" if unit > 1 else f"{start + k:.1f}"
        rows.append(separator.join([time, f"{k}.5", "2", "0", *(str(TURN[q]) for q in order)]))
    path.write_text("\n".join(rows) + "\n")
    return path


def check_upright(path, remarks=0):
    """In space and in the plane a path of two poses is the same."""
    space, flat = read_space_track(path), read_track(path)
    np.testing.assert_allclose(space.times, [1.4e9, 1.4e9 + 1], rtol=0, atol=1e-6)
    np.testing.assert_array_equal(flat.times, space.times)
    np.testing.assert_allclose(space.poses[:, :3, 3], [[0.5, 2, 0], [1.5, 2, 0]])
    np.testing.assert_allclose(space.poses[:, :2, :2], [[[0.28, -0.96], [0.96, 0.28]]] * 2)
    np.testing.assert_allclose(se3.from_se2(flat.poses), space.poses, atol=1e-12)
    assert len(space.report.remarks) == len(flat.report.remarks) == remarks
    return space.report.remarks


@pytest.mark.parametrize(("names", "order", "unit"), NAMED.values(), ids=NAMED)
def test_columns_are_found_by_their_names_in_plane_and_space(names, order, unit, tmp_path):
    separator = " " if names.startswith("# ") else ","
    check_upright(upright(tmp_path / "a.csv", order, unit, separator, names))


def test_names_may_stand_in_any_order_among_others(tmp_path):
    (tmp_path / "a.csv").write_text(
        "frame,qw,qz,qy,qx,z,y,x,timestamp\nodom,0.8,0.6,0,0,0,2,0.5,1.4e9\n"
        "odom,0.8,0.6,0,0,0,2,1.5,1400000001\n"
    )
    check_upright(tmp_path / "a.csv")


BARE = {  # the order of a quaternion and the unit that a file without names is read in
    "TUM": ("xyzw", 1, " ", "a.csv: no names of columns: read as TUM, time x y z qx qy qz qw"),
    "TUM with commas": ("xyzw", 1, ",", "a.csv: no names of columns: read as TUM, time x y z qx"),
    "TUM with tabs": ("xyzw", 1, "\t", "a.csv: no names of columns: read as TUM, time x y z qx"),
    "EuRoC": (
        "wxyz",
        10**9,
        ",",
        "a.csv: no names of columns: read as EuRoC, time in ns, x y z qw",
    ),
}


@pytest.mark.parametrize(("order", "unit", "separator", "remark"), BARE.values(), ids=BARE)
def test_a_file_without_names_says_how_it_was_read(order, unit, separator, remark, tmp_path):
    path = upright(tmp_path / "a.csv", order, unit, separator)
    assert check_upright(path, 1)[0].startswith(remark)


@pytest.mark.parametrize("unit", ["ms", "us"])
def test_tum_with_commas_may_count_time_in_other_units(unit, tmp_path):
    path = upright(tmp_path / "a.csv", unit={"ms": 10**3, "us": 10**6}[unit])
    assert track_format(path) == "TUM"
    for read in (read_space_track, read_track):
        np.testing.assert_allclose(read(path, time_unit=unit).times, [1.4e9, 1.4e9 + 1])


def test_whole_seconds_between_commas_are_no_nanoseconds(tmp_path):
    (tmp_path / "a.csv").write_text("0,1,2,0,0,0,0.6,0.8\n1,1,2,0,0,0,0.6,0.8\n")
    assert track_format(tmp_path / "a.csv") == "TUM"
    np.testing.assert_allclose(read_track(tmp_path / "a.csv").poses[:, 2], 2 * np.arctan(0.75))


def test_matrices_say_how_they_were_read(tmp_path):
    write_kitti(tmp_path / "a.txt", np.eye(4)[None])
    (remark,) = read_space_track(tmp_path / "a.txt").report.remarks
    assert (
        remark
        == "a.txt: no names of columns: read as KITTI, matrices of 3 × 4 by rows, without times"
    )


@pytest.mark.parametrize("decimals", [1, 2, 3])
@pytest.mark.parametrize("seed", range(20))
def test_rounded_quaternions_are_made_unit_in_plane_and_space(decimals, seed, tmp_path):
    heading = np.random.default_rng(seed).uniform(-3, 3, 5)
    turns = Rotation.from_euler("z", heading[:, None]).as_quat().round(decimals)
    table = np.column_stack([np.arange(5.0), np.arange(5.0), np.zeros((5, 2)), turns])
    np.savetxt(tmp_path / "a.tum", table, "%.9g")
    np.savetxt(tmp_path / "a.csv", table, "%.9g", ",", header=",".join(SPACE), comments="")
    for name, read in product(("a.tum", "a.csv"), (read_space_track, read_track)):
        found = read(tmp_path / name)
        turned = found.poses[:, :2, :2] if found.poses.ndim == 3 else se2_turns(found.poses)
        np.testing.assert_allclose(turned, se2_turns(heading), atol=2 * 10.0**-decimals)
        off = np.abs(np.linalg.norm(turns, axis=1) - 1).max()
        assert any(f"up to {off:.1%}" in one for one in found.report.remarks) == (off > 1e-3)


def se2_turns(poses):
    """Return the rotations of headings, or of poses with these."""
    return se2.rotation(poses if poses.ndim == 1 else poses[:, 2])


@pytest.mark.parametrize("decimals", [1, 2, 3, 6])
def test_rounded_matrices_are_made_rotations(decimals, tmp_path):
    _, poses = path_in_space(np.random.default_rng(9))
    np.savetxt(tmp_path / "a.txt", poses[:, :3].reshape(-1, 12).round(decimals), "%.9g")
    found = read_space_track(tmp_path / "a.txt").poses
    np.testing.assert_allclose(found[:, :3, :3], poses[:, :3, :3], atol=3 * 10.0**-decimals)
    assert se3.checked("poses", found) is not None


def test_a_path_in_the_plane_lies_at_height_nothing(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("time_s,x_m,y_m,heading_rad\n0,1,2,0\n1,2,2,1.5\n")
    assert track_format(path) == "plane"
    track, flat = read_space_track(path), read_track(path)
    np.testing.assert_array_equal(track.times, flat.times)
    np.testing.assert_allclose(track.poses, se3.from_se2(flat.poses))


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
        (lambda: SpaceTrack(np.arange(3), EYE), r"poses must be \(3, 4, 4\) for times \(3,\)"),
        (lambda: SpaceTrack(np.ones(2), EYE), "times must rise"),
        (lambda: SpaceTrack(None, EYE).at(np.ones(1), longest_gap=1), "times can be asked of"),
        (lambda: SpaceTrack(np.arange(2), EYE).at(np.ones(1), longest_gap=0), "longest_gap must"),
    ],
)
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises((ValueError, TypeError), match=message):
        build()
