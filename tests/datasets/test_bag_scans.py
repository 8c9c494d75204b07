"""Scans in ROS bags: readings by REP 117, beams that differ, clouds, the scanner's place."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from robot_perception import datasets
from robot_perception.datasets import (
    CorruptLog,
    read_bag_log,
    read_bag_scans,
)
from robot_perception.geometry import se2, se3
from tests.datasets import bags
from tests.datasets.bags import (
    drive,
    scan,
    write_bag,
)

# Scans --------------------------------------------------------------------------------------------


ENDS = [np.inf, -np.inf, np.nan, 0.0, 8.0, float(np.float32(0.1))]


@given(
    readings=st.lists(
        st.floats(-1, 12, width=32) | st.sampled_from(ENDS),
        min_size=1,
        max_size=6,
    ),
    clockwise=st.booleans(),
)
@settings(max_examples=60, deadline=None)
def test_every_reading_is_a_distance_nothing_or_void(readings, clockwise, tmp_path_factory):
    """By REP 117, and clockwise as well."""
    step = -0.25 if clockwise else 0.25
    said = [scan(0, readings, angles=(-0.5, step))]
    scans = read_bag_scans(write_bag(tmp_path_factory.mktemp("rep") / "a.bag", said))
    found = scans.ranges[0][::-1] if clockwise else scans.ranges[0]
    least, most = np.float32([0.1, 8.0])
    for reading, seen in zip(np.float32(readings), found, strict=True):
        if reading > most:
            assert seen == np.inf
        elif reading >= least:
            assert seen == reading
        else:
            assert np.isnan(seen)
    assert (np.diff(scans.angles) > 0).all()
    assert scans.angles[-1 if clockwise else 0] == -0.5


def test_scans_of_other_beams_are_resampled_or_skipped(tmp_path):
    wide = np.linspace(1, 3, 101).tolist()
    said = [scan(0.1 * k, wide, angles=(-1.0, 0.02)) for k in range(3)]
    said.append(scan(0.3, np.linspace(1, 3, 103).tolist(), angles=(-1.0, 2 / 102)))
    said.append(scan(0.4, [1.0] * 11, angles=(-1.0, 0.2)))
    scans = read_bag_scans(write_bag(tmp_path / "beams.bag", said), "/scan")
    assert scans.ranges.shape == (4, 101)
    assert np.abs(scans.ranges[3] - wide).max() <= 0.0101  # half a beam
    assert scans.report.others == {"/scan, skipped": 1}
    assert scans.report.remarks == (
        "/scan: 1 scans with other beams, resampled to those of most",
        "/scan: 1 scans skipped, with beams of another step",
    )


def test_beams_beyond_a_narrow_scan_are_void(tmp_path):
    said = [scan(0.1 * k, [1.0] * 5) for k in range(2)] + [scan(0.2, [2.0] * 3, angles=(-0.5, 0.5))]
    scans = read_bag_scans(write_bag(tmp_path / "narrow.bag", said))
    np.testing.assert_array_equal(scans.ranges[2], [np.nan, 2, 2, 2, np.nan])


@pytest.mark.parametrize("big", [False, True])
def test_points_of_a_cloud_in_any_layout(big, tmp_path):
    rng = np.random.default_rng(1)
    angles, distances = rng.uniform(-3, 3, 20), rng.uniform(1, 5, 20)
    angles[:2] = np.pi - 1e-3, 1e-3 - np.pi  # of one beam
    points = np.stack([distances * np.cos(angles), distances * np.sin(angles), 0 * angles], axis=1)
    points = np.vstack([points, [np.nan] * 3, [0, 0, 0]])
    said = [bags.cloud(0, points, big=big, padded=7)]
    scans = read_bag_scans(write_bag(tmp_path / "layout", said))
    seen = np.isfinite(scans.ranges[0])
    expected = {}
    for angle, distance in zip(angles, distances, strict=True):
        beam = (round(np.rad2deg(angle) * 2) + 360) % 720 - 360
        expected[beam] = min(distance, expected.get(beam, np.inf))
    found = dict(
        zip(np.rint(np.rad2deg(scans.angles[seen]) * 2), scans.ranges[0][seen], strict=True)
    )
    assert found == pytest.approx(expected, abs=1e-5)


# Places of the scanner ----------------------------------------------------------------------------


def mounted(tmp_path, T, *, more=(), frames=("base_link", "laser")) -> datasets.LaserLog:
    said = [bags.transform(0, *frames, T)] if T is not None else []
    return read_bag_log(write_bag(tmp_path / "mounted", [*said, *more, *drive()]))


def test_a_scanner_upside_down_sees_the_same_points(tmp_path):
    """The points of a beam at angle a lie at -a of one that hangs upside down."""
    down = se3.from_se2(np.array([0.3, 0, 0.5]))
    down[:3, :3] = down[:3, :3] @ Rotation.from_euler("x", np.pi).as_matrix()
    said = [one for one in drive() if one.topic == "/odom"]
    said += [scan(0.1 * k, [1.0, np.inf, 2.0, 3.0], angles=(-0.8, 0.5)) for k in range(4)]
    path = write_bag(tmp_path / "down", [bags.transform(0, "base_link", "laser", down), *said])
    log, scans = read_bag_log(path), read_bag_scans(path)
    assert (np.diff(log.angles) > 0).all()
    for k in range(len(log.ranges)):

        def points(ranges, angles):
            good, ranges = np.isfinite(ranges), np.nan_to_num(ranges, posinf=0)
            return (ranges * [np.cos(angles), np.sin(angles)]).T[good]

        raw = points(scans.ranges[k], scans.angles)
        space = np.column_stack([raw, np.zeros(len(raw))])
        expected = se3.act(se3.compose(se3.from_se2(log.odometry[k]), down), space)[:, :2]
        found = se2.act(log.poses[k], points(log.ranges[k], log.angles))
        np.testing.assert_allclose(found[::-1], expected, atol=1e-9)


def test_the_place_is_found_along_both_branches_of_the_tree(tmp_path):
    up, ahead = (se3.from_se2(np.array(pose)) for pose in ([0, 0, 0.2], [0.2, 0.1, 0.3]))
    more = [bags.transform(0.1, "footprint", "base_link", up)]
    log = mounted(tmp_path, up @ ahead, more=more, frames=("footprint", "/laser"))
    expected = se2.compose(log.odometry, np.array([0.2, 0.1, 0.3]))
    np.testing.assert_allclose(log.poses, expected, atol=1e-9)


def test_the_place_is_found_from_frame_to_frame(tmp_path):
    mast, tip = (se3.from_se2(np.array(pose)) for pose in ([0.5, 0, 0.7], [0.2, 0.1, 0.3]))
    log = mounted(
        tmp_path, tip, more=[bags.transform(0, "base_link", "mast", mast)], frames=("mast", "laser")
    )
    place = se2.compose(np.array([0.5, 0, 0.7]), np.array([0.2, 0.1, 0.3]))
    np.testing.assert_allclose(log.poses, se2.compose(log.odometry, place), atol=1e-9)


def test_an_unknown_place_is_told(tmp_path):
    moves = [
        bags.transform(t, "base_link", "laser", se3.from_se2(np.array([t, 0, 0])), topic="/tf")
        for t in (0.0, 0.1)
    ]
    for k, more in enumerate([[], moves]):
        path = write_bag(tmp_path / str(k), [*more, *drive()])
        log = read_bag_log(path, ["/scan", "/odom"])
        np.testing.assert_array_equal(log.poses, log.odometry)
        assert log.report.remarks == (
            "the bag does not say where 'laser' is on 'base_link': taken to be the same place",
        )


def test_a_tilted_scanner_is_refused(tmp_path):
    tilted = np.eye(4)
    tilted[:3, :3] = Rotation.from_euler("y", 30, degrees=True).as_matrix()
    with pytest.raises(CorruptLog, match="the scanner 'laser' is tilted by 30 degrees"):
        mounted(tmp_path, tilted)


def test_scans_without_odometry_are_skipped_and_told(tmp_path):
    path = write_bag(tmp_path / "longer.bag", [*drive(), scan(2.0, [1.0] * 5)])
    log = read_bag_log(path)
    assert len(log.ranges) == 4
    assert "/scan: 1 scans skipped, no pose of /odom at their time" in log.report.remarks
    lone = write_bag(tmp_path / "lone.bag", [*drive()[:5], scan(9.0, [1.0] * 5)])
    with pytest.raises(CorruptLog, match=r"lone\.bag: no pose of /odom \(from .*\) at the time of"):
        read_bag_log(lone)


# Clocks -------------------------------------------------------------------------------------------


def on_two_clocks(ahead: float, behind: float = 0.0) -> list[bags.Said]:
    """Return a drive in which the clock of the scanner, and that of the poses, are ahead, s."""
    off = {"/scan": ahead, "/odom": behind}
    return [replace(one, time=one.time + off[one.topic], logged=one.time + 0.02) for one in drive()]


CLOCKS = {  # by how much the scanner's clock, and that of the poses, are ahead, s
    "a scanner that counts from when it was switched on": (-bags.START / 1e9 + 60, 0.0),
    "a scanner on atomic time": (37.0, 0.0),
    "a computer that counts from when it was switched on": (0.0, -bags.START / 1e9 + 60),
    "a day": (-86400.0, 0.0),
}


@pytest.mark.parametrize("name", CLOCKS)
def test_two_clocks_are_put_on_that_of_the_recording(name, tmp_path):
    """The poses are those of one clock."""
    ahead, behind = CLOCKS[name]
    expected = read_bag_log(write_bag(tmp_path / "one.bag", drive()))
    log = read_bag_log(write_bag(tmp_path / "two.bag", on_two_clocks(ahead, behind)))
    np.testing.assert_allclose(log.poses, expected.poses, atol=1e-6)
    np.testing.assert_allclose(np.diff(log.times), np.diff(expected.times), atol=1e-6)
    (remark,) = (remark for remark in log.report.remarks if "clocks" in remark)
    assert remark.startswith("two clocks, /scan from ")
    assert " and /odom from " in remark


def test_a_clock_that_is_ahead_of_the_recording_is_another_one(tmp_path):
    """Also where the times of both overlap, as of a scanner that leaves out leap seconds."""
    times = 0.1 * np.arange(80)
    said = [bags.odometry(t, se3.from_se2(np.array([t, 0, 0])), logged=t + 0.02) for t in times]
    said += [scan(t + 3, [1.0] * 5, logged=t + 0.02) for t in times]
    log = read_bag_log(write_bag(tmp_path / "ahead.bag", said))
    np.testing.assert_allclose(log.poses[:, 0], times, atol=1e-6)
    assert any(remark.startswith("two clocks, /scan from ") for remark in log.report.remarks)


def test_one_clock_stays_as_it_is(tmp_path):
    """Simulated time is far from that of the recording, and one of two may be computed late."""
    expected = read_bag_log(write_bag(tmp_path / "one.bag", drive()))
    simulated = on_two_clocks(60 - bags.START / 1e9, 60 - bags.START / 1e9)
    log = read_bag_log(write_bag(tmp_path / "simulated.bag", simulated))
    np.testing.assert_allclose(log.poses, expected.poses, atol=1e-6)
    assert log.report.remarks == expected.report.remarks
    late = [replace(o, logged=o.time + 5 * (o.topic == "/odom")) for o in drive()]
    log = read_bag_log(write_bag(tmp_path / "late.bag", late))
    np.testing.assert_allclose(log.times, expected.times)
    (remark,) = (remark for remark in log.report.remarks if "recorded" in remark)
    assert "/scan 0.000 s and /odom 5.000 s; if these are two clocks, poses are off" in remark


def test_clocks_that_cannot_be_joined_are_told(tmp_path):
    said = on_two_clocks(60 - bags.START / 1e9)
    apart = [replace(o, logged=o.logged + 1000 * (o.topic == "/scan")) for o in said]
    with pytest.raises(CorruptLog, match=r"/scan from .* and /odom from .* have no time in common"):
        read_bag_log(write_bag(tmp_path / "apart.bag", apart))
    unlike = [replace(o, logged=o.logged + k * (o.topic == "/scan")) for k, o in enumerate(said)]
    path = write_bag(tmp_path / "unlike.bag", unlike)
    with pytest.raises(CorruptLog, match="the clock of /scan runs unlike that of the recording"):
        read_bag_log(path)
    assert len(read_bag_scans(path).times) == 4  # which need no other clock


# A way from elsewhere -----------------------------------------------------------------------------


def test_a_way_from_elsewhere_takes_the_place_of_the_poses_of_the_bag(tmp_path):
    """And the scanner's place on the robot counts for it, too."""
    times = bags.seconds(0.1 * np.arange(5))
    way = datasets.Track(times, np.column_stack([np.arange(5.0), 0 * times, 0 * times]))
    on_it = bags.transform(0, "base_link", "laser", se3.from_se2(np.array([0.2, 0.1, 0.4])))
    path = write_bag(tmp_path / "a.mcap", [on_it, *drive()])
    log = read_bag_log(path, "/scan", way=way)
    robot, _ = way.at(log.times, longest_gap=1.0)
    np.testing.assert_allclose(log.odometry, robot)
    np.testing.assert_allclose(log.poses, se2.compose(robot, np.array([0.2, 0.1, 0.4])))
    later = datasets.Track(times + 100, way.poses)
    with pytest.raises(
        CorruptLog, match=r"no pose of way \(from .*\) at the time of a scan of /scan"
    ):
        read_bag_log(path, "/scan", way=later)
