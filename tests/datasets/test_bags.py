"""ROS bags: which topics are read, what is skipped is told, what is missing is named."""

import sqlite3
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
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
    read_leg_scans,
    read_track,
)
from robot_perception.geometry import se3
from tests.datasets import bags
from tests.datasets.bags import (
    COLOUR,
    COV,
    drive,
    eyes,
    odometry,
    scan,
    seconds,
    write_bag,
)
from tests.datasets.formats.bags import put

PROJECT = Path(__file__).parents[2] / "pyproject.toml"


@pytest.fixture
def bag(tmp_path) -> Path:
    """A bag with all types of messages."""
    put(tmp_path, "plain.bag")
    return tmp_path / "plain.bag"


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


def test_readers_of_one_topic_agree(bag):
    scans, legs = read_bag_scans(bag, "/scan"), read_leg_scans(bag, topic="/scan")
    assert str(scans.report).startswith(f"{bag.name}: 37 messages; read 4 /scan; other kinds 5 ")
    np.testing.assert_array_equal(
        legs.ranges, np.nan_to_num(scans.ranges, nan=np.inf, posinf=np.inf)
    )
    np.testing.assert_array_equal(legs.angles, scans.angles)
    assert (legs.sector, legs.report) == (None, scans.report)
    np.testing.assert_array_equal(read_bag_log(bag, ["/scan", "/odom"]).ranges, scans.ranges)
    motion = read_bag_motion(bag, "/odom")
    np.testing.assert_array_equal(motion.commands().times, motion.times)
    np.testing.assert_array_equal(motion.commands().velocities, motion.velocities)
    with pytest.raises(CorruptLog, match="/pose holds poses without velocities"):
        read_bag_motion(bag, "/pose").commands()
    (first, *_) = read_bag_film(bag, ["/camera/image_raw/compressed", "/scan"])
    np.testing.assert_array_equal(first, COLOUR)


def test_a_flat_cloud_is_a_scan(bag):
    scans = read_bag_scans(bag, "points")
    seen = np.flatnonzero(np.isfinite(scans.ranges[0]))
    np.testing.assert_allclose(np.rad2deg(scans.angles[seen]), [-180, 0, 90], atol=1e-9)
    np.testing.assert_allclose(scans.ranges[:, seen], [[3, 1, 2]] * 5)
    assert len(scans.angles) == 720
    assert scans.farthest == np.inf


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
    said = [odometry(k, np.eye(4)) for k in range(2)]
    nothing = read_bag_motion(write_bag(tmp_path / "nothing.bag", said), "/odom")
    assert nothing.covs is None
    assert not nothing.report.remarks
    wide = np.array([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    said = [odometry(0.0, np.eye(4), cov=wide)]
    wrong = read_bag_motion(write_bag(tmp_path / "wrong.bag", said), "/odom")
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
