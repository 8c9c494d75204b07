"""ROS bags of every kind: what was written is read, what is skipped is told, damage is named."""

import io
import sqlite3
import sys
import tomllib
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

from robot_perception import extras
from robot_perception.datasets import (
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
from tests.datasets.bags import (
    COLOUR,
    COV,
    GREY,
    KINDS,
    POSES,
    READ,
    TIMES,
    drive,
    eyes,
    odometry,
    scan,
    seconds,
    write_bag,
)

PROJECT = Path(__file__).parents[2] / "pyproject.toml"

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
    scans = read_bag_scans(bag, "/scan")
    np.testing.assert_allclose(scans.times, seconds(TIMES[1:] - 0.01), atol=1e-6)
    np.testing.assert_allclose(scans.ranges, np.float32([READ[1], READ[0]] * 2))
    np.testing.assert_allclose(scans.angles, [-1, -0.5, 0, 0.5, 1])
    assert (scans.frame, scans.topic, scans.farthest) == ("laser", "/scan", 8.0)
    assert scans.report.kept == {"/scan": 4}
    assert scans.report.others["/odom"] == 5
    assert scans.report.lines == 4 + 5 + 1 + 12 + 15
    assert str(scans.report).startswith(f"{bag.name}: 37 messages; read 4 /scan; other kinds 5 ")
    legs = read_leg_scans(bag, topic="/scan")
    np.testing.assert_array_equal(
        legs.ranges, np.nan_to_num(scans.ranges, nan=np.inf, posinf=np.inf)
    )
    np.testing.assert_array_equal(legs.angles, scans.angles)
    assert legs.sector is None
    assert legs.report == scans.report


def test_odometry_is_read(bag):
    motion = read_bag_motion(bag, "/odom")
    np.testing.assert_allclose(motion.times, seconds(TIMES), atol=1e-6)
    np.testing.assert_allclose(motion.poses, se3.from_se2(POSES), atol=1e-12)
    np.testing.assert_array_equal(motion.covs, [COV] * 5)
    np.testing.assert_array_equal(motion.velocities, [[1.1, 1.0]] * 5)
    assert (motion.world, motion.body, motion.topic) == ("odom", "base_link", "/odom")
    track, commands = read_track(bag, topic="/odom"), motion.commands()
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
    log = read_bag_log(bag, ["/scan", "/odom"])
    robot = np.column_stack([TIMES[1:] - 0.01, 0.5 * (TIMES[1:] - 0.01), TIMES[1:] + 2.99])
    np.testing.assert_allclose(se2.between(log.odometry, robot), 0, atol=1e-6)
    mounted = se2.compose(robot, np.array([0.2, 0.1, np.pi / 2]))
    np.testing.assert_allclose(se2.between(log.poses, mounted), 0, atol=1e-6)
    np.testing.assert_array_equal(log.ranges, read_bag_scans(bag, "/scan").ranges)
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
    with pytest.raises(
        CorruptLog, match=r"other: .*(/battery \(Float32, 1 message\)|left may be none)"
    ):
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
        CorruptLog,
        match=r"2 topics hold scans: /rear \(LaserScan, 1 message\), /scan \(LaserScan, 4 .*; say",
    ):
        read_bag_log(path)
    for topic in ("/rear", "rear", ("/rear",), ["/odom", "rear"]):
        assert read_bag_log(path, topic).report.kept == {"/rear": 1, "/odom": 5}
    with pytest.raises(CorruptLog, match="2 topics hold"):
        read_bag_scans(path, ["/rear", "/scan"])


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
    scans = read_bag_scans(write_bag(tmp_path / "times.bag", said), "/scan")
    np.testing.assert_array_equal(scans.ranges[:, 0], [1, 2, 6])
    assert scans.report.kept == {"/scan": 3}
    assert scans.report.others == {"/scan, skipped": 3}
    assert scans.report.remarks == (
        "/scan: 1 messages skipped, without time stamp",
        "/scan: 2 messages skipped, time stamp not after the one before",
    )


def test_without_any_time_stamps_the_recording_tells(tmp_path):
    said = [scan(np.nan, [1.0 + k] * 5, logged=0.1 * k) for k in range(3)]
    scans = read_bag_scans(write_bag(tmp_path / "unstamped", said), "/scan")
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
    said = [one(), odometry(1, np.eye(4))]
    nothing = read_bag_motion(write_bag(tmp_path / "nothing.bag", said), "/odom")
    assert nothing.covs is None
    assert not nothing.report.remarks
    wide = np.array([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    wrong = read_bag_motion(write_bag(tmp_path / "wrong.bag", [one(cov=wide)]), "/odom")
    assert wrong.covs is None
    assert "/odom: without its covariances, which are none" in wrong.report.remarks[0]


DRIVERS = {  # what is written where nobody knows, on the diagonal, by drivers and filters
    "kobuki": (0.1, 0.1, 1.7e308),
    "gazebo": (1e12, 1e12, 0.01),
    "diff_drive_controller": (0.001, 0.001, 1000.0),
    "REP 103's minus one": (-1.0, 0.0, 0.0),
    "five nines": (99999.0, 99999.0, 99999.0),
    "a million": (1e6, 1e6, 1e6),
    "infinite": (np.inf, np.inf, np.inf),
    "NaN": (np.nan, 0.1, 0.1),
    "nothing": (0.0, 0.0, 0.0),
}


@pytest.mark.parametrize("kind", ["Odometry", "PoseWithCovarianceStamped"])
@pytest.mark.parametrize("name", DRIVERS)
def test_a_covariance_that_says_that_nobody_knows_is_none(name, kind, tmp_path):
    """And the others of the recording are not used either, which the remarks tell."""
    full = np.eye(6)
    full[[0, 1, 5], [0, 1, 5]] = DRIVERS[name]
    good = np.zeros((6, 6))
    good[np.ix_([0, 1, 5], [0, 1, 5])] = COV
    said = [bags.uncertain_pose(k, np.eye(4), covariance=cov) for k, cov in enumerate([good, full])]
    if kind == "Odometry":
        said = [
            bags.Said(o.topic, bags.odometry(0, np.eye(4)).kind, o.fields, o.time) for o in said
        ]
    motion = read_bag_motion(write_bag(tmp_path / "a.bag", said), "/amcl_pose")
    assert motion.covs is None
    (remark,) = motion.report.remarks
    assert "/amcl_pose: without covariances: 1 of 2 say that nobody knows" in remark
    assert "of pose 2)" in remark
    known = read_bag_motion(write_bag(tmp_path / "b.bag", said[:1]), "/amcl_pose")
    np.testing.assert_array_equal(known.covs, [COV])


def test_velocities_that_say_nothing_are_refused(tmp_path):
    still = [odometry(k, se3.from_se2(np.zeros(3))) for k in range(2)]
    motion = read_bag_motion(write_bag(tmp_path / "still.bag", still))
    np.testing.assert_array_equal(motion.commands().velocities, np.zeros((2, 2)))
    moving = [odometry(k, se3.from_se2(np.array([k, 0.0, 0]))) for k in range(2)]
    with pytest.raises(CorruptLog, match=r"moving\.bag: /odom holds velocities of 0 while the"):
        read_bag_motion(write_bag(tmp_path / "moving.bag", moving)).commands()


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
