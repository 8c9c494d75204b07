"""Trees of frames: which motion of a robot they tell, and what on the robot does not count."""

import numpy as np
import pytest

from robot_perception.datasets import CorruptLog, read_bag_log, read_bag_motion
from robot_perception.geometry import se2, se3
from tests.datasets import bags
from tests.datasets.bags import scan, seconds, write_bag

TIMES = 0.1 * np.arange(11)
MOVED = np.column_stack([TIMES, 0.2 * TIMES, 3.0 + TIMES])  # in the frame of the odometry
DRIFT = np.column_stack([0.5 * TIMES, -TIMES, 0 * TIMES])  # of that frame in the map


def told(parent, child, poses, times=TIMES, **more) -> list[bags.Said]:
    """Return what a tree tells of a frame that moves."""
    how = {"topic": "/tf"} | more
    pairs = zip(times, poses, strict=True)
    return [bags.transform(t, parent, child, se3.from_se2(pose), **how) for t, pose in pairs]


def fixed(parent, child, pose=(0.0, 0.0, 0.0), **more) -> list[bags.Said]:
    return [bags.transform(0, parent, child, se3.from_se2(np.array(pose)), **more)]


WHEELS = [
    one
    for side in ("left", "right")
    for one in told("base_link", f"wheel_{side}", np.column_stack([0 * TIMES, 0 * TIMES, TIMES]))
]
ONE = {  # trees that tell one motion: what they hold, the motion, and where it ends
    "a robot": (told("odom", "base_link", MOVED), "odom.base_link"),
    "with wheels that turn": ([*told("odom", "base_link", MOVED), *WHEELS], "odom.base_link"),
    "with a footprint": (
        [*told("odom", "base_footprint", MOVED), *fixed("base_footprint", "base_link")],
        "odom.base_footprint",
    ),
    "with a footprint that is told again and again": (
        [
            *told("odom", "base_footprint", MOVED),
            *told("base_footprint", "base_link", 0 * MOVED),
        ],
        "odom.base_footprint",
    ),
    "in a map that is fixed": (
        [*told("odom", "base_link", MOVED), *fixed("map", "odom")],
        "odom.base_link",
    ),
    "with slashes": (told("/odom", "/base_link", MOVED), "odom.base_link"),
    "with a prefix": (told("r1/odom", "r1/base_link", MOVED), "r1/odom.r1/base_link"),
    "without a known name": (told("world", "drone", MOVED), "world.drone"),
    "without a known name, with a camera": (
        [*told("world", "drone", MOVED), *fixed("drone", "camera")],
        "world.drone",
    ),
}


@pytest.mark.parametrize("name", ONE)
def test_a_tree_alone_is_a_motion(name, tmp_path):
    said, frames = ONE[name]
    motion = read_bag_motion(write_bag(tmp_path / "tree", said))
    assert motion.topic == f"/tf:{frames}"
    assert (motion.world, motion.body) == tuple(frames.split("."))
    np.testing.assert_allclose(motion.times, seconds(TIMES), atol=1e-6)
    np.testing.assert_allclose(motion.poses, se3.from_se2(MOVED), atol=1e-9)
    assert motion.report.remarks == (f"poses of /tf:{frames}",)
    assert motion.report.kept["/tf"] == len([one for one in said if one.topic == "/tf"])


NONE = {
    "nothing moves": fixed("base_link", "laser"),
    "only the wheels do": WHEELS,
    "only those of a robot that is bolted down": [*fixed("map", "base_link"), *WHEELS],
    "it hangs from two others": [
        *told("odom", "base_link", MOVED),
        *told("map", "base_link", MOVED, TIMES + 0.05),
    ],
}


@pytest.mark.parametrize("name", NONE)
def test_some_trees_tell_no_motion(name, tmp_path):
    path = write_bag(tmp_path / "tree", NONE[name])
    with pytest.raises(CorruptLog, match=r"no topic holds poses .*; it has /tf"):
        read_bag_motion(path)


def chain(**more) -> list[bags.Said]:
    return [*told("map", "odom", DRIFT, **more), *told("odom", "base_link", MOVED)]


SEVERAL = {
    "odometry that is corrected": (chain(), "/tf:odom.base_link", "/tf:map.base_link"),
    "two robots": (
        [*told("map", "a/base_link", MOVED), *told("map", "b/base_link", DRIFT)],
        "/tf:map.a/base_link",
        "/tf:map.b/base_link",
    ),
    "two trees": (
        [*told("odom", "base_link", MOVED), *told("odom", "base_link", DRIFT, topic="/truth")],
        "/tf:odom.base_link",
        "/truth:odom.base_link",
    ),
    "frames of any names": (
        [*told("world", "drone", MOVED), *told("drone", "arm", DRIFT)],
        "/tf:world.drone",
        "/tf:drone.arm",
    ),
}


@pytest.mark.parametrize("name", SEVERAL)
def test_several_motions_are_told_and_each_can_be_named(name, tmp_path):
    said, *names = SEVERAL[name]
    path = write_bag(tmp_path / "tree", said)
    with pytest.raises(CorruptLog, match=r"topics hold poses: .*say which") as error:
        read_bag_motion(path)
    for one in names:
        assert f"{one} (TFMessage, " in str(error.value)
        assert read_bag_motion(path, one).topic == one


def test_a_motion_along_several_frames_is_their_product(tmp_path):
    """The upper frame is told more seldom, at other times: between them it moves on a line."""
    few = slice(None, None, 3)
    said = [*told("map", "odom", DRIFT[few], TIMES[few]), *told("odom", "base_link", MOVED)]
    motion = read_bag_motion(write_bag(tmp_path / "a", said), "/tf:map.base_link")
    expected = se3.compose(se3.from_se2(DRIFT), se3.from_se2(MOVED))[:10]
    np.testing.assert_allclose(motion.times, seconds(TIMES[:10]), atol=1e-6)
    np.testing.assert_allclose(motion.poses, expected, atol=1e-6)
    assert motion.report.remarks == (
        "/tf:map.base_link: 1 poses skipped, frames above are not told at their time",
    )
    said = [*told("map", "odom", DRIFT, TIMES + 60), *told("odom", "base_link", MOVED)]
    with pytest.raises(CorruptLog, match=r"the frames of /tf:map\.base_link are never told"):
        read_bag_motion(write_bag(tmp_path / "b", said), "/tf:map.base_link")


def test_what_is_fixed_on_the_way_is_part_of_it(tmp_path):
    said = [*fixed("map", "odom", (1.0, 2.0, 0.5)), *told("odom", "base_link", MOVED)]
    said += fixed("base_link", "camera", (0.1, 0.0, 0.3))
    motion = read_bag_motion(write_bag(tmp_path / "a", said), "/tf:map.camera")
    first, last = (np.array(pose) for pose in ((1.0, 2.0, 0.5), (0.1, 0.0, 0.3)))
    expected = se2.compose(se2.compose(first, MOVED), last)
    np.testing.assert_allclose(motion.poses, se3.from_se2(expected), atol=1e-9)


def test_a_quaternion_and_its_negative_are_one_place(tmp_path):
    said = [*told("odom", "base_link", MOVED), *told("base_link", "laser", 0 * MOVED)]
    for k, one in enumerate(said[len(MOVED) :]):
        one.fields["transforms"][0].transform.rotation.w *= (-1) ** k
    said += [scan(t, [1.0, 2.0]) for t in TIMES]
    log = read_bag_log(write_bag(tmp_path / "a", said))
    assert not any("taken to be the same place" in remark for remark in log.report.remarks)
    np.testing.assert_allclose(se2.between(log.poses, MOVED), 0, atol=1e-6)


def test_what_odometry_tells_too_does_not_count(tmp_path):
    """Also where it names a frame that is fixed to the robot's body; a map does count."""
    wheels = [bags.odometry(t, se3.from_se2(pose)) for t, pose in zip(TIMES, MOVED, strict=True)]
    for k, tree in enumerate((ONE["a robot"][0], ONE["with a footprint"][0])):
        motion = read_bag_motion(write_bag(tmp_path / f"{k}", [*wheels, *tree]))
        assert motion.topic == "/odom"
    with pytest.raises(
        CorruptLog, match=r"2 topics hold poses: /odom \(Odometry.*, /tf:map.base_link \(TF"
    ):
        read_bag_motion(write_bag(tmp_path / "map", [*wheels, *chain()]))


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        (
            "/tf:map.base_link",
            "/tf does not tell where 'base_link' is in 'map'; it tells odom.base",
        ),
        ("/tf:base_link", "'base_link' names no two frames of /tf, which tells odom.base_link"),
        ("/tf:odom.hand", "'odom.hand' names no two frames of /tf, which tells odom.base_link"),
        ("/no:odom.base_link", "topic '/no' is not in this bag"),
    ],
)
def test_frames_that_are_not_there_are_named_with_those_that_are(wanted, message, tmp_path):
    path = write_bag(tmp_path / "tree", told("odom", "base_link", MOVED))
    with pytest.raises(CorruptLog, match=message):
        read_bag_motion(path, wanted)


# The scans of a robot that a tree moves -----------------------------------------------------------


def test_scans_are_taken_along_a_tree_alone(tmp_path):
    said = [*told("odom", "base_link", MOVED), *fixed("base_link", "laser", (0.2, 0.1, 0.4))]
    said += [scan(t, [1.0, 2.0]) for t in TIMES]
    log = read_bag_log(write_bag(tmp_path / "a", said), still=True)
    expected = se2.compose(MOVED, np.array([0.2, 0.1, 0.4]))
    np.testing.assert_allclose(se2.between(log.poses, expected), 0, atol=1e-6)
    assert log.report.remarks == ("scans of /scan", "poses of /tf:odom.base_link")


def test_only_a_robot_that_nothing_moves_stands_still(tmp_path):
    scans = [scan(t, [1.0, 2.0]) for t in TIMES]
    still = [bags.twist(t, 0.0, 0.0) for t in TIMES]
    for k, said in enumerate(([], still, fixed("base_link", "laser"))):
        log = read_bag_log(write_bag(tmp_path / f"{k}", [*scans, *said]), still=True)
        assert not log.poses.any()
        assert "the robot is taken to stand still" in log.report.remarks[-1]
    moves = [bags.twist(t, 0.3, 0.0) for t in TIMES]
    with pytest.raises(CorruptLog, match="no poses, but by /cmd_vel the robot moves"):
        read_bag_log(write_bag(tmp_path / "moves", [*scans, *moves]), still=True)
    with pytest.raises(CorruptLog, match="no topic holds poses"):
        read_bag_log(write_bag(tmp_path / "none", scans))
