"""ROS bags of every kind: what was written is read, what is skipped is told, damage is named."""

import io
import sqlite3
import sys
import tomllib
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from scipy.spatial.transform import Rotation

from robot_perception import datasets, extras
from robot_perception.datasets import (
    Calibration,
    CorruptImage,
    CorruptLog,
    bag_topics,
    is_bag,
    read_bag_film,
    read_bag_log,
    read_bag_motion,
    read_bag_scans,
    read_bag_stereo,
    read_film,
    read_leg_scans,
    read_track,
)
from robot_perception.geometry import se2, se3
from tests.datasets import bags
from tests.datasets.bags import KINDS, odometry, scan, write_bag

PROJECT = Path(__file__).parents[2] / "pyproject.toml"
P = np.array([[50.0, 0, 16, 0], [0, 50, 12, 0], [0, 0, 1, 0]])
RIGHT = P - np.array([0, 0, 0, 5.0]) * (np.arange(3) == 0)[:, None]  # 0.1 m to the right
GREY = (np.arange(24 * 32).reshape(24, 32) % 251).astype(np.uint8)
COLOUR = np.stack([GREY, GREY[::-1], GREY[:, ::-1]], axis=-1)
TIMES = 0.1 * np.arange(5)
POSES = np.column_stack([TIMES, 0.5 * TIMES, 3.0 + TIMES])  # the heading wraps
COV = np.array([[0.02, 0.01, 0], [0.01, 0.03, 0], [0, 0, 0.001]])
RANGES = [[1.0, 2.0, np.inf, 9.0, np.nan], [0.05, 0.0, -np.inf, 8.0, 0.5]]
READ = [[1.0, 2.0, np.inf, np.inf, np.nan], [np.nan, np.nan, np.nan, 8.0, 0.5]]


def drive() -> list[bags.Said]:
    """Odometry at five times, and a scan at each but the first, 10 ms before."""
    moved = [
        odometry(time, se3.from_se2(pose), speed=1.1, turn=1.0, cov=COV)
        for time, pose in zip(TIMES, POSES, strict=True)
    ]
    return moved + [scan(TIMES[k] - 0.01, RANGES[k % 2]) for k in range(1, 5)]


def eyes(**more) -> list[bags.Said]:
    """Three rectified pairs, of which the right one is 2 ms late."""
    said = []
    for time in TIMES[:3]:
        for side, matrix, late in (("left", P, 0.0), ("right", RIGHT, 0.002)):
            picture = GREY + round(10 * time) + (side == "right")
            said += [
                bags.image(time + late, picture, "mono8", topic=f"/{side}/image_rect"),
                bags.camera_info(time, matrix, (32, 24), topic=f"/{side}/camera_info", **more),
            ]
    return said


def seconds(times) -> np.ndarray:
    return bags.START / 1e9 + np.asarray(times)


# Every kind of bag × every kind of message --------------------------------------------------------


@pytest.fixture(scope="module", params=KINDS)
def bag(request, tmp_path_factory) -> Path:
    """The same messages, in each kind of bag."""
    path = tmp_path_factory.mktemp("bags") / request.param
    ros = 1 if path.suffix == ".bag" else 2
    ahead = bags.transform(
        0, "base_link", "laser", se3.from_se2(np.array([0.2, 0.1, np.pi / 2])), ros=ros
    )
    square = np.array([[1, 0, 0], [0, 2, 0.01], [-3, 0, 0]])
    jpeg = io.BytesIO()
    Image.fromarray(COLOUR).save(jpeg, "png")
    more = [bags.compressed(time, jpeg.getvalue(), "png") for time in TIMES]
    more += [bags.cloud(time, square, ros=ros) for time in TIMES]
    more += [
        bags.stamped_pose(time, se3.from_se2(pose)) for time, pose in zip(TIMES, POSES, strict=True)
    ]
    return write_bag(path, [ahead, *drive(), *eyes(), *more])


def test_a_bag_is_known_with_its_topics(bag):
    assert is_bag(bag)
    assert bag_topics(bag) == {
        "/camera/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
        "/left/camera_info": "sensor_msgs/msg/CameraInfo",
        "/left/image_rect": "sensor_msgs/msg/Image",
        "/odom": "nav_msgs/msg/Odometry",
        "/points": "sensor_msgs/msg/PointCloud2",
        "/pose": "geometry_msgs/msg/PoseStamped",
        "/right/camera_info": "sensor_msgs/msg/CameraInfo",
        "/right/image_rect": "sensor_msgs/msg/Image",
        "/scan": "sensor_msgs/msg/LaserScan",
        "/tf_static": "tf2_msgs/msg/TFMessage",
    }


def test_scans_are_read(bag):
    scans = read_bag_scans(bag)
    np.testing.assert_allclose(scans.times, seconds(TIMES[1:] - 0.01), atol=1e-6)
    np.testing.assert_allclose(scans.ranges, np.float32([READ[1], READ[0]] * 2))
    np.testing.assert_allclose(scans.angles, [-1, -0.5, 0, 0.5, 1])
    assert (scans.frame, scans.topic, scans.farthest) == ("laser", "/scan", 8.0)
    assert scans.report.kept == {"/scan": 4}
    assert scans.report.others["/odom"] == 5
    assert scans.report.lines == 4 + 5 + 1 + 12 + 15
    assert str(scans.report).startswith(f"{bag.name}: 37 messages; read 4 /scan; other kinds 5 ")
    legs = read_leg_scans(bag)
    np.testing.assert_array_equal(
        legs.ranges, np.nan_to_num(scans.ranges, nan=np.inf, posinf=np.inf)
    )
    np.testing.assert_array_equal(legs.angles, scans.angles)
    assert legs.sector is None
    assert legs.report == scans.report


def test_odometry_is_read(bag):
    motion = read_bag_motion(bag)
    np.testing.assert_allclose(motion.times, seconds(TIMES), atol=1e-6)
    np.testing.assert_allclose(motion.poses, se3.from_se2(POSES), atol=1e-12)
    np.testing.assert_array_equal(motion.covs, [COV] * 5)
    np.testing.assert_array_equal(motion.velocities, [[1.1, 1.0]] * 5)
    assert (motion.world, motion.body, motion.topic) == ("odom", "base_link", "/odom")
    track, commands = read_track(bag), motion.commands()
    np.testing.assert_allclose(se2.between(track.poses, POSES), 0, atol=1e-12)
    np.testing.assert_array_equal(track.covs, motion.covs)
    np.testing.assert_array_equal(commands.times, track.times)
    np.testing.assert_array_equal(commands.velocities, motion.velocities)
    assert track.report.kept == {"/odom": 5}
    by_name = read_bag_motion(bag, "/pose")
    np.testing.assert_allclose(by_name.poses, motion.poses, atol=1e-12)
    assert (by_name.covs, by_name.velocities, by_name.world) == (None, None, "map")
    with pytest.raises(CorruptLog, match="/pose holds poses without velocities"):
        by_name.commands()


def test_a_log_joins_scans_odometry_and_the_place_of_the_scanner(bag):
    log = read_bag_log(bag)
    robot = np.column_stack([TIMES[1:] - 0.01, 0.5 * (TIMES[1:] - 0.01), TIMES[1:] + 2.99])
    np.testing.assert_allclose(se2.between(log.odometry, robot), 0, atol=1e-6)
    mounted = se2.compose(robot, np.array([0.2, 0.1, np.pi / 2]))
    np.testing.assert_allclose(se2.between(log.poses, mounted), 0, atol=1e-6)
    np.testing.assert_array_equal(log.ranges, read_bag_scans(bag).ranges)
    assert log.max_range == 8.0
    assert log.report.kept == {"/scan": 4, "/odom": 5}
    assert not log.report.remarks


def test_a_flat_cloud_is_a_scan(bag):
    scans = read_bag_scans(bag, "points")
    seen = np.flatnonzero(np.isfinite(scans.ranges[0]))
    np.testing.assert_allclose(np.rad2deg(scans.angles[seen]), [-180, 0, 90], atol=1e-9)
    np.testing.assert_allclose(scans.ranges[:, seen], [[3, 1, 2]] * 5)
    assert len(scans.angles) == 720
    assert scans.farthest == np.inf


def test_pictures_are_a_film(bag):
    film = read_film(bag, topic="/left/image_rect")
    assert (film.size, film.promised, film.remarks) == ((32, 24), 3, [])
    assert film.rate == pytest.approx(10)
    frames = list(film)
    for k, frame in enumerate(frames):
        np.testing.assert_array_equal(frame, np.dstack([GREY + k] * 3))
    np.testing.assert_allclose(film.times, seconds(TIMES[:3]), atol=1e-6)
    assert film.numbers == [1, 2, 3]
    assert (film.finished, film.missing) == (True, 0)
    (first, *_) = read_bag_film(bag, ["/camera/image_raw/compressed", "/scan"])
    np.testing.assert_array_equal(first, COLOUR)


def test_pairs_are_matched_and_calibrated(bag):
    pairs = read_bag_stereo(bag)
    assert (len(pairs), pairs.size) == (3, (32, 24))
    assert pairs.calibration.focal == (50, 50)
    assert pairs.calibration.baseline == pytest.approx(0.1)
    np.testing.assert_allclose(pairs.times, seconds(TIMES[:3]), atol=1e-6)
    for k, (left, right) in enumerate(pairs):
        np.testing.assert_array_equal(left, GREY + k)
        np.testing.assert_array_equal(right, GREY + k + 1)
    np.testing.assert_array_equal(pairs[2], [GREY + 2, GREY + 3])
    assert pairs.report.kept == {"/left/image_rect": 3, "/right/image_rect": 3}


# What is a bag, and which topic -------------------------------------------------------------------


def test_a_file_of_messages_alone_is_read_as_well(tmp_path):
    for kind, ending in (("mcap", ".mcap"), ("sqlite", ".db3")):
        folder = write_bag(tmp_path / kind, drive())
        (file,) = folder.glob(f"*{ending}")
        assert is_bag(file)
        expected = read_track(folder).poses
        np.testing.assert_array_equal(read_track(file).poses, expected)
        (folder / "metadata.yaml").unlink()  # the recording was interrupted
        assert is_bag(folder)
        np.testing.assert_array_equal(read_track(folder).poses, expected)
        file.rename(folder / f"a{ending}")
        (folder / f"b{ending}").write_bytes((folder / f"a{ending}").read_bytes())
        with pytest.raises(CorruptLog, match=rf"{kind}: no ROS 2 bag: no metadata.yaml, and 2 "):
            read_track(folder)


def test_other_files_and_folders_are_no_bags(tmp_path):
    (tmp_path / "metadata.yaml").write_text("title: mine\n")
    (tmp_path / "1.png").write_bytes(b"")
    assert not is_bag(tmp_path)
    for name in ("a.csv", "a.bag.gz", "a.tum", "bag", "a.mcap.csv"):
        assert not is_bag(tmp_path / name)
    for name in ("none.bag", "none.mcap"):
        with pytest.raises(FileNotFoundError, match=f"no such bag: .*{name}"):
            bag_topics(tmp_path / name)
    (tmp_path / "a.csv").write_text("1,2\n")
    with pytest.raises(CorruptLog, match=r"a\.csv: no ROS bag"):
        bag_topics(tmp_path / "a.csv")


READERS = {
    "motion": read_bag_motion,
    "scans": read_bag_scans,
    "log": read_bag_log,
    "film": read_bag_film,
    "stereo": read_bag_stereo,
}


@pytest.mark.parametrize("name", READERS)
def test_topics_that_are_not_there_are_named_with_those_that_are(name, tmp_path):
    said = [bags.Said("/battery", "std_msgs/msg/Float32", {"data": 1.0}, 0.0)]
    path = write_bag(tmp_path / "other", said)
    with pytest.raises(CorruptLog, match=r"other: .*(/battery \(Float32\)|left may be none)"):
        READERS[name](path)
    with pytest.raises(CorruptLog, match=r"topic '/scan' is not in this bag, which has /battery"):
        READERS[name](path, "/scan")
    with pytest.raises(CorruptLog, match=r"topic '/battery' holds Float32, not|left may be none"):
        READERS[name](path, "/battery")
    with pytest.raises(TypeError, match="topic"):
        READERS[name](path, 3)


def test_where_several_topics_would_do_they_are_listed(tmp_path):
    said = [*drive(), scan(0.2, [3.0] * 5, topic="/rear")]
    path = write_bag(tmp_path / "two.bag", said)
    with pytest.raises(
        CorruptLog, match=r"2 topics hold LaserScan or PointCloud2: /rear, /scan; say"
    ):
        read_bag_log(path)
    for topic in ("/rear", "rear", ("/rear",), ["/odom", "rear"]):
        assert read_bag_log(path, topic).report.kept == {"/rear": 1, "/odom": 5}
    with pytest.raises(CorruptLog, match="2 topics hold"):
        read_bag_scans(path, ["/rear", "/scan"])


def test_odometry_goes_before_goals(tmp_path):
    path = write_bag(tmp_path / "goal.bag", [*drive(), bags.stamped_pose(0, np.eye(4))])
    assert read_bag_motion(path).topic == "/odom"


# Times --------------------------------------------------------------------------------------------


def test_what_has_no_time_or_an_old_one_is_skipped_and_told(tmp_path):
    said = [
        scan(0.0, [1.0] * 5),
        scan(0.1, [2.0] * 5),
        scan(0.1, [3.0] * 5, logged=0.15),  # twice the same time
        scan(0.05, [4.0] * 5, logged=0.17),  # late
        scan(np.nan, [5.0] * 5, logged=0.18),  # no time at all
        scan(0.2, [6.0] * 5),
    ]
    scans = read_bag_scans(write_bag(tmp_path / "times.bag", said))
    np.testing.assert_array_equal(scans.ranges[:, 0], [1, 2, 6])
    assert scans.report.kept == {"/scan": 3}
    assert scans.report.others == {"/scan, skipped": 3}
    assert scans.report.remarks == (
        "/scan: 1 messages skipped, without time stamp",
        "/scan: 2 messages skipped, time stamp not after the one before",
    )


def test_without_any_time_stamps_the_recording_tells(tmp_path):
    said = [scan(np.nan, [1.0 + k] * 5, logged=0.1 * k) for k in range(3)]
    scans = read_bag_scans(write_bag(tmp_path / "unstamped", said))
    np.testing.assert_allclose(scans.times, seconds([0, 0.1, 0.2]), atol=1e-6)
    assert scans.report.remarks == ("/scan: no time stamps, so the times of recording were taken",)


@pytest.mark.parametrize("name", READERS)
def test_a_clock_that_was_set_back_is_refused(name, tmp_path):
    said = [*drive(), *eyes()]
    again = [
        bags.Said(one.topic, one.kind, one.fields, one.time - 5, one.time + 20, one.frame)
        for one in said
    ]
    path = write_bag(tmp_path / "again.bag", [*said, *again])
    topic = {"film": "/left/image_rect"}.get(name)
    with pytest.raises(
        CorruptLog, match=r"again\.bag: at message \d of /\S+ time falls by 5\.\d* s"
    ):
        READERS[name](path, topic)


# Scans --------------------------------------------------------------------------------------------


@given(
    readings=st.lists(
        st.floats(-1, 12, width=32) | st.sampled_from([np.inf, -np.inf, np.nan]),
        min_size=1,
        max_size=6,
    ),
    clockwise=st.booleans(),
)
@settings(max_examples=25, deadline=None)
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
    scans = read_bag_scans(write_bag(tmp_path / "beams.bag", said))
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


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ([scan(0, [1], frame="a"), scan(1, [1], frame="b")], "scans of several frames: a, b"),
        (
            [scan(0, [1, 1], angles=(0.0, 0.0))],
            "scan 1 of /scan has 2 beams from 0 rad in steps of 0",
        ),
        ([scan(0, [1, 1], angles=(np.nan, 0.1))], "scan 1 of /scan has 2 beams from nan rad"),
        ([scan(0, [])], "scan 1 of /scan has 0 beams"),
        ([scan(0, [1], range_max=0.0)], "scan 1 of /scan has ranges from 0.1 to 0 m"),
        (
            [bags.cloud(0, np.array([[1, 0, 0], [1, 0, 2.0]]))],
            "heights from 0.00 to 2.00 m, not a scan",
        ),
        (
            [bags.cloud(0, np.ones((2, 2)), names="xy")],
            "scan 1 of /points: a damaged cloud of points",
        ),
    ],
)
def test_what_is_no_scan_is_named(said, message, tmp_path):
    with pytest.raises(CorruptLog, match=rf"/none: .*{message}"):
        read_bag_scans(write_bag(tmp_path / "none", said))


@pytest.mark.parametrize("big", [False, True])
def test_points_of_a_cloud_in_any_layout(big, tmp_path):
    rng = np.random.default_rng(1)
    angles, distances = rng.uniform(-3, 3, 20), rng.uniform(1, 5, 20)
    points = np.stack([distances * np.cos(angles), distances * np.sin(angles), 0 * angles], axis=1)
    points = np.vstack([points, [np.nan] * 3, [0, 0, 0]])
    said = [bags.cloud(0, points, big=big, padded=7)]
    scans = read_bag_scans(write_bag(tmp_path / "layout", said))
    seen = np.isfinite(scans.ranges[0])
    expected = {}
    for angle, distance in zip(angles, distances, strict=True):
        beam = round(np.rad2deg(angle) * 2)
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
    log, scans = mounted(tmp_path, down), read_bag_scans(tmp_path / "mounted")
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


def test_an_unknown_place_is_told(tmp_path):
    moves = [
        bags.transform(t, "base_link", "laser", se3.from_se2(np.array([t, 0, 0])), topic="/tf")
        for t in (0.0, 0.1)
    ]
    for k, more in enumerate([[], moves]):
        log = read_bag_log(write_bag(tmp_path / str(k), [*more, *drive()]))
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
    assert "/scan: 1 scans skipped, no odometry at their time" in log.report.remarks
    lone = write_bag(tmp_path / "lone.bag", [*drive()[:5], scan(9.0, [1.0] * 5)])
    with pytest.raises(CorruptLog, match=r"lone\.bag: no odometry of /odom at the time of a scan"):
        read_bag_log(lone)


# Motion -------------------------------------------------------------------------------------------


def one(**changes):
    return odometry(0.0, np.eye(4), **changes)


def broken(place: str, value: float) -> bags.Said:
    said = one()
    said.fields["pose"]["pose"][place]["w" if place == "orientation" else "x"] = value
    return said


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (broken("position", np.nan), "message 1 of /odom is NaN or infinite"),
        (broken("orientation", 0.0), "pose 1 of /odom has no quaternion of unit length"),
        (one(speed=np.inf), "message 1 of /odom is NaN or infinite"),
    ],
)
def test_what_is_no_pose_is_named(said, message, tmp_path):
    with pytest.raises(CorruptLog, match=rf"odd\.bag: {message}"):
        read_bag_motion(write_bag(tmp_path / "odd.bag", [said]))


def test_a_camera_on_its_side_has_a_pose_in_space_but_no_heading(tmp_path):
    side = np.eye(4)
    side[:3, :3] = Rotation.from_euler("x", -90, degrees=True).as_matrix()
    path = write_bag(tmp_path / "side.bag", [odometry(0, np.eye(4)), odometry(1, side)])
    np.testing.assert_allclose(read_bag_motion(path).poses, [np.eye(4), side], atol=1e-12)
    with pytest.raises(
        CorruptLog, match=r"side\.bag: pose 2 of /odom turns the robot onto its side"
    ):
        read_track(path)


def test_covariances_that_are_none_are_left_out_and_told(tmp_path):
    unknown = read_bag_motion(write_bag(tmp_path / "unknown.bag", [one(), odometry(1, np.eye(4))]))
    assert unknown.covs is None
    assert not unknown.report.remarks
    wrong = read_bag_motion(write_bag(tmp_path / "wrong.bag", [one(cov=-np.eye(3))]))
    assert wrong.covs is None
    assert "/odom: without its covariances, which are none" in wrong.report.remarks[0]


def test_velocities_that_say_nothing_are_refused(tmp_path):
    still = [odometry(k, se3.from_se2(np.zeros(3))) for k in range(2)]
    motion = read_bag_motion(write_bag(tmp_path / "still.bag", still))
    np.testing.assert_array_equal(motion.commands().velocities, np.zeros((2, 2)))
    moving = [odometry(k, se3.from_se2(np.array([k, 0.0, 0]))) for k in range(2)]
    with pytest.raises(CorruptLog, match=r"moving\.bag: /odom holds velocities of 0 while the"):
        read_bag_motion(write_bag(tmp_path / "moving.bag", moving)).commands()


# Pictures -----------------------------------------------------------------------------------------

MOSAIC = np.zeros((24, 32), np.uint8)  # of one colour: 200, 120, 40
MOSAIC[::2, ::2], MOSAIC[1::2, 1::2], MOSAIC[::2, 1::2], MOSAIC[1::2, ::2] = 200, 40, 120, 120
SHIFTS = {"rggb": (0, 0), "grbg": (0, 1), "gbrg": (1, 0), "bggr": (1, 1)}
ALPHA = np.full((24, 32, 1), 90, np.uint8)
EVEN = np.full((24, 32, 3), [180, 90, 60], np.uint8)
LUMA = cv2.cvtColor(EVEN, cv2.COLOR_RGB2YUV)[0, 0]
ENCODED = {  # by the encoding: the bytes, and what they show
    "mono8": (GREY, np.dstack([GREY] * 3)),
    "8UC1": (GREY, np.dstack([GREY] * 3)),
    "rgb8": (COLOUR, COLOUR),
    "bgr8": (COLOUR[..., ::-1], COLOUR),
    "8UC3": (COLOUR[..., ::-1], COLOUR),
    "rgba8": (np.dstack([COLOUR, ALPHA]), COLOUR),
    "bgra8": (np.dstack([COLOUR[..., ::-1], ALPHA]), COLOUR),
    "8UC4": (np.dstack([COLOUR[..., ::-1], ALPHA]), COLOUR),
    "mono16": (GREY.astype("<u2") * 256 + 7, np.dstack([GREY] * 3)),
    "16UC1": (GREY.astype("<u2") * 256 + 7, np.dstack([GREY] * 3)),
    **{
        f"bayer_{name}8": (np.roll(MOSAIC, shift, (0, 1)), np.full_like(COLOUR, [200, 120, 40]))
        for name, shift in SHIFTS.items()
    },
}


@pytest.mark.parametrize("step", [None, 300])
@pytest.mark.parametrize("encoding", ENCODED)
def test_encodings(encoding, step, tmp_path):
    raw, shown = ENCODED[encoding]
    path = write_bag(tmp_path / "a.bag", [bags.image(0, raw, encoding, step=step)])
    film = read_bag_film(path)
    assert film.rate is None
    np.testing.assert_array_equal(next(film), shown)


@pytest.mark.parametrize("encoding", ["yuv422", "uyvy", "yuv422_yuy2", "yuyv"])
def test_packed_colours(encoding, tmp_path):
    y, u, v = LUMA.tolist()
    y = round(16 + 219 / 255 * y)
    u, v = (round(128 + 224 / 255 * (channel - 128)) for channel in _uv())
    pair = [y, u, y, v] if encoding in ("yuv422_yuy2", "yuyv") else [u, y, v, y]
    raw = np.tile(np.array(pair, np.uint8), (24, 16)).reshape(24, 32, 2)
    film = read_bag_film(write_bag(tmp_path / "a.bag", [bags.image(0, raw, encoding)]))
    assert np.abs(next(film).astype(int) - EVEN).max() <= 3


def _uv() -> tuple[float, float]:
    """Cb and Cr of EVEN by ITU-R BT.601."""
    r, g, b = EVEN[0, 0].astype(float)
    y = 0.299 * r + 0.587 * g + 0.114 * b
    return 128 + (b - y) / 1.772, 128 + (r - y) / 1.402


def test_sixteen_bits_with_the_first_byte_first(tmp_path):
    raw = (GREY.astype(int) * 256 + 7).astype(">u2")
    path = write_bag(tmp_path / "big.bag", [bags.image(0, raw, "mono16", is_bigendian=1)])
    np.testing.assert_array_equal(next(read_bag_film(path))[..., 0], GREY)


def test_jpeg_is_read_as_from_a_file(tmp_path):
    Image.fromarray(COLOUR).save(tmp_path / "a.jpg", quality=90)
    content = (tmp_path / "a.jpg").read_bytes()
    path = write_bag(tmp_path / "jpeg", [bags.compressed(0, content, "bgr8; jpeg compressed bgr8")])
    expected = datasets.read_image(tmp_path / "a.jpg", colour=True)
    np.testing.assert_array_equal(next(read_bag_film(path)), expected)


DEPTHS = np.where(GREY > 100, 2000 + GREY.astype(np.uint16), 0).astype("<u2")


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (bags.image(0, GREY, "32FC1"), "is encoded as '32FC1', which is none of mono8"),
        (bags.image(0, DEPTHS, "16UC1"), "a picture of depths"),
        (bags.compressed(0, b"x", "16UC1; compressedDepth"), "holds depths, not grey values"),
        (bags.compressed(0, b"x"), "no picture, or a damaged one"),
        (bags.compressed(0, b""), "empty"),
        (bags.image(0, GREY[:, :16], "bgr8", step=20), "is damaged: 480 bytes for 16 x 24 px of 3"),
        (bags.image(0, np.zeros((4, 0), np.uint8), "mono8"), "has 0 x 4 px"),
    ],
)
def test_what_is_no_picture_is_named(said, message, tmp_path):
    with pytest.raises(CorruptImage, match=rf"odd\.bag: picture 1 of /camera/.*{message}"):
        read_bag_film(write_bag(tmp_path / "odd.bag", [said]))


def test_a_picture_of_another_size_ends_the_film(tmp_path):
    said = [bags.image(k, GREY[: 24 - 12 * k], "mono8") for k in range(2)]
    film = read_bag_film(write_bag(tmp_path / "grows.bag", said))
    next(film)
    with pytest.raises(
        CorruptImage, match=r"picture 2 of \S+ has 32 x 12 px, the first one 32 x 24"
    ):
        next(film)


# Stereo -------------------------------------------------------------------------------------------


def test_pairs_lie_near_in_time_and_others_are_told(tmp_path):
    said = [one for one in eyes() if not (one.topic == "/right/image_rect" and one.time < 0.1)]
    path = write_bag(tmp_path / "lost.bag", said)
    pairs = read_bag_stereo(path)
    np.testing.assert_array_equal([left[0, 0] for left, _ in pairs], [1, 2])
    assert pairs.report.remarks == ("/left/image_rect: 1 pictures without a partner left out",)
    with pytest.raises(CorruptLog, match=r"within 0\.001 s \(tolerance\)"):
        read_bag_stereo(path, tolerance=0.001)
    with pytest.raises(ValueError, match="tolerance must not be negative"):
        read_bag_stereo(path, tolerance=-1)


@given(
    left=st.lists(st.integers(0, 60), min_size=1, unique=True),
    right=st.lists(st.integers(0, 60), min_size=1, unique=True),
    tolerance=st.integers(0, 9),
)
def test_matches_are_mutual_nearest_and_none_is_used_twice(left, right, tolerance):
    from robot_perception.datasets.bag_pictures import _matched

    left, right = np.sort(left), np.sort(right)
    mine, theirs = _matched(left, right, tolerance)
    assert len(set(mine)) == len(mine)
    assert len(set(theirs)) == len(theirs)
    gaps = np.abs(left[:, None] - right)
    for i, j in zip(mine, theirs, strict=True):
        assert gaps[i, j] <= tolerance
        assert gaps[i, j] == gaps[i].min() == gaps[:, j].min()
    alone = np.delete(gaps, mine, axis=0)
    alone = np.delete(alone, theirs, axis=1)
    assert not (alone <= tolerance).any() or len(mine)  # the nearest two of all are always a pair


def test_raw_pictures_are_rectified(tmp_path):
    """A pattern bent by a lens is that of the straight camera again."""
    wide, high = 160, 120
    K = np.array([[100.0, 0, 80], [0, 100, 60], [0, 0, 1]])
    D, R = np.array([-0.25, 0.05, 0.001, -0.002, 0.0]), Rotation.from_euler("y", 3, degrees=True)
    matrix = np.column_stack([K, np.zeros(3)])
    rows, columns = np.mgrid[:high, :wide].astype(float)

    def pattern(u, v):
        return 128 + 60 * np.sin(u / 9) + 50 * np.cos(v / 7)

    seen = cv2.undistortPoints(
        np.stack([columns, rows], -1).reshape(-1, 1, 2), K, D, None, R.as_matrix(), K
    )
    bent = pattern(*seen.reshape(high, wide, 2).transpose(2, 0, 1)).round().astype(np.uint8)
    lens = {"d": D, "r": R.as_matrix().ravel(), "k": K.ravel()}
    said = []
    for side, shift in (("left", 0.0), ("right", -10.0)):
        of_side = matrix.copy()
        of_side[0, 3] = shift
        info = bags.camera_info(0, of_side, (wide, high), topic=f"/{side}/camera_info", **lens)
        said += [bags.image(0, bent, "mono8", topic=f"/{side}/image_raw"), info]
    pairs = read_bag_stereo(write_bag(tmp_path / "raw", said))
    assert pairs.calibration == Calibration((100.0, 100.0), (80.0, 60.0), 0.1) or (
        pairs.calibration.baseline == pytest.approx(0.1)
    )
    inner = np.s_[15:-15, 20:-20]
    for picture in pairs[0]:
        assert np.abs(picture[inner] - pattern(columns, rows)[inner]).max() < 2
    assert np.abs(bent[inner] - pattern(columns, rows)[inner]).max() > 20


def changed(topic: str, **fields) -> list[bags.Said]:
    """The pairs, with other fields in the calibration of one side."""
    said = eyes()
    for one in said:
        if one.topic == topic:
            one.fields.update(fields)
    return said


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (
            [one for one in eyes() if "info" not in one.topic],
            "left may be none, right none, without",
        ),
        (
            [one for one in eyes() if "right" not in one.topic],
            "left may be /left/image_rect, right none",
        ),
        (
            changed("/right/camera_info", p=(RIGHT * [2, 1, 1, 1]).ravel()),
            "not those of a rectified pair",
        ),
        (changed("/left/camera_info", width=64), "have 32 x 24 px, their CameraInfo says 64 x 24"),
        (
            [*eyes(), bags.camera_info(9, 2 * P, (32, 24), topic="/left/camera_info")],
            "the calibration in /left/camera_info changes",
        ),
        (
            [
                bags.Said(o.topic.replace("rect", "raw"), o.kind, o.fields, o.time)
                for o in changed("/left/camera_info", d=np.ones(5), distortion_model="mine")
            ],
            "their lens is of the unknown model 'mine'",
        ),
    ],
)
def test_what_is_no_stereo_camera_is_named(said, message, tmp_path):
    with pytest.raises((CorruptLog, CorruptImage), match=rf"odd: .*{message}"):
        read_bag_stereo(write_bag(tmp_path / "odd", said))


def test_the_two_topics_may_be_named(tmp_path):
    more = [bags.image(0, GREY, "mono8", topic="/depth/image_rect")]
    more += [bags.camera_info(0, P, (32, 24), topic="/depth/camera_info")]
    path = write_bag(tmp_path / "three.bag", [*eyes(), *more])
    with pytest.raises(CorruptLog, match="left may be /depth/image_rect, /left/image_rect, right"):
        read_bag_stereo(path)
    assert len(read_bag_stereo(path, ["/left/image_rect", "/right/image_rect"])) == 3


# Damage -------------------------------------------------------------------------------------------


def storage(path: Path) -> Path:
    return path if path.is_file() else next(p for p in path.iterdir() if p.suffix != ".yaml")


@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_that_was_cut_is_named(kind, tmp_path):
    """Nowhere is a part of it taken for the whole."""
    noise = np.random.default_rng(0).integers(0, 255, (24, 32), np.uint8)
    many = [bags.image(0.1 * k, noise, "mono8") for k in range(40)]
    path = write_bag(tmp_path / kind, [*drive(), *many])
    file, whole = storage(path), storage(path).read_bytes()
    for share in (0.0, 0.002, 0.3, 0.5, 0.7, 0.9, 0.999):
        file.write_bytes(whole[: int(share * len(whole))])
        for read in (read_track, read_bag_log, lambda path: list(read_film(path))):
            with pytest.raises(CorruptLog, match=rf"{path.name}"):
                read(path)


@pytest.mark.parametrize("kind", KINDS)
def test_a_bit_that_fell_over_ends_in_no_foreign_error(kind, tmp_path):
    path = write_bag(tmp_path / kind, drive())
    file, whole = storage(path), storage(path).read_bytes()
    rng = np.random.default_rng(1)
    for _ in range(30):
        wrong = bytearray(whole)
        wrong[rng.integers(len(whole))] ^= 1 << rng.integers(8)
        file.write_bytes(wrong)
        with suppress(CorruptLog):
            assert len(read_track(path).times) <= 5


def test_a_bag_that_holds_fewer_messages_than_it_says_is_refused(tmp_path):
    path = write_bag(tmp_path / "sqlite", drive())
    with sqlite3.connect(storage(path)) as connection:
        connection.execute("DELETE FROM messages WHERE id = 3")
    connection.close()
    with pytest.raises(CorruptLog, match=r"/odom has 4 of its 5 messages"):
        read_track(path)


def test_a_recording_that_was_not_ended_is_named(tmp_path):
    path = write_bag(tmp_path / "sqlite", drive())
    file = storage(path)
    file.with_name(f"{file.name}-wal").write_bytes(b"messages that are not in the file yet")
    with pytest.raises(
        CorruptLog, match=r"its recording was not ended, and messages are in .*-wal"
    ):
        read_track(path)


def test_a_bag_without_descriptions_of_its_types_is_read(tmp_path):
    """As ROS 2 wrote them before Iron."""
    path = write_bag(tmp_path / "sqlite", drive())
    with sqlite3.connect(storage(path)) as connection:
        connection.execute("DROP TABLE message_definitions")
        connection.execute("UPDATE schema SET schema_version = 3")
    connection.close()
    assert len(read_bag_log(path).ranges) == 4


def test_a_missing_package_names_its_extra(tmp_path, monkeypatch):
    path = write_bag(tmp_path / "a.bag", drive())
    (line,) = tomllib.loads(PROJECT.read_text("utf-8"))["project"]["optional-dependencies"]["ros"]
    monkeypatch.setattr(extras, "requires", lambda name: [f"{line}; extra == 'ros'"])
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(
        ModuleNotFoundError, match=r"rosbags: pip install 'robot-perception\[ros\]'"
    ):
        read_track(path)
