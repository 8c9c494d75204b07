"""Messages of one meaning, whatever their type: one is taken and named, of several all are told."""

import io
from itertools import combinations

import numpy as np
import pytest
from PIL import Image

from robot_perception.datasets import (
    CorruptLog,
    read_bag_film,
    read_bag_motion,
    read_bag_scans,
    read_commands,
    read_film,
)
from robot_perception.datasets.bags import share_topics
from robot_perception.geometry import se3
from tests.datasets import bags
from tests.datasets.bags import COLOUR, POSES, TIMES, seconds, write_bag

PLACES = [se3.from_se2(pose) for pose in POSES]
WAY = list(zip(TIMES, PLACES, strict=True))
SQUARE = np.array([[1.0, 0, 0], [0, 2, 0], [-3, 0, 0]])
SPEEDS = np.array([[0.5, 0.1], [0.4, -0.2], [0.0, 0.3]])
PNG = io.BytesIO()
Image.fromarray(COLOUR).save(PNG, "png")


def speeds(kind: str) -> list[bags.Said]:
    return [
        bags.twist(t, *pair, kind=kind, topic=f"/{kind}")
        for t, pair in zip(TIMES, SPEEDS.tolist(), strict=False)
    ]


def wheels() -> list[bags.Said]:
    return [
        bags.odometry(t, np.eye(4), speed=v, turn=w)
        for t, (v, w) in zip(TIMES, SPEEDS.tolist(), strict=False)
    ]


MEANINGS = {  # what is read, its topics with the messages of each, and what they all tell
    "poses": (
        read_bag_motion,
        {
            "/odom": [bags.odometry(*one) for one in WAY],
            "/pose": [bags.stamped_pose(*one) for one in WAY],
            "/amcl_pose": [bags.uncertain_pose(*one) for one in WAY],
            "/vicon": [bags.moved_frame(*one) for one in WAY],
            "/tf:map.base_link": [
                bags.transform(t, "map", "base_link", T, topic="/tf") for t, T in WAY
            ],
        },
        lambda found: (found.times, found.poses),
        (seconds(TIMES), PLACES),
    ),
    "scans": (
        read_bag_scans,
        {
            "/scan": [bags.scan(t, [1.0, 2.0, 3.0], angles=(-1.5, 1.5)) for t in TIMES],
            "/echoes": [
                bags.echoes(t, [[1.0, 7.0], [2.0], [3.0]], angles=(-1.5, 1.5)) for t in TIMES
            ],
            "/points": [bags.cloud(t, SQUARE) for t in TIMES],
            "/cloud": [bags.old_cloud(t, SQUARE) for t in TIMES],
        },
        lambda found: (found.times, np.sort(found.ranges)[:, :3]),
        (seconds(TIMES), [[1.0, 2.0, 3.0]] * len(TIMES)),
    ),
    "pictures": (
        read_bag_film,
        {
            "/camera/image_raw": [bags.image(t, COLOUR, "rgb8") for t in TIMES],
            "/camera/image_raw/compressed": [
                bags.compressed(t, PNG.getvalue(), "rgb8; png compressed bgr8") for t in TIMES
            ],
        },
        lambda film: (np.array([*film]), film.times),
        ([COLOUR] * len(TIMES), seconds(TIMES)),
    ),
    "speeds": (
        lambda path, topic=None: read_commands(path, topic=topic),
        {"/odom": wheels()}
        | {
            f"/{kind}": speeds(kind)
            for kind in ("Twist", "TwistStamped", "TwistWithCovarianceStamped")
        },
        lambda found: (found.times, found.velocities),
        (seconds(TIMES[:3]), SPEEDS),
    ),
}
SINGLE = [(meaning, topic) for meaning, (_, topics, *_) in MEANINGS.items() for topic in topics]
PAIRS = [
    (meaning, *two)
    for meaning, (_, topics, *_) in MEANINGS.items()
    for two in combinations(topics, 2)
]


def remarks(found) -> list[str]:
    return [*(found.report.remarks if hasattr(found, "report") else found.remarks)]


@pytest.mark.parametrize(("meaning", "topic"), SINGLE)
def test_each_type_tells_the_same_and_what_is_taken_is_named(meaning, topic, tmp_path):
    read, topics, told, expected = MEANINGS[meaning]
    path = write_bag(tmp_path / "one", topics[topic])
    for wanted, named in ((None, False), (topic, True), ([topic], True)):
        found = read(path, wanted)
        assert (f"{meaning} of {topic}" in remarks(found)) != named
        for values, known in zip(told(found), expected, strict=True):
            np.testing.assert_allclose(values, known, atol=1e-6)


@pytest.mark.parametrize(("meaning", "one", "other"), PAIRS)
def test_no_type_goes_before_another(meaning, one, other, tmp_path):
    read, topics, *_ = MEANINGS[meaning]
    path = write_bag(tmp_path / "two", [*topics[one], *topics[other]])
    with pytest.raises(CorruptLog, match=f"2 topics hold {meaning}: ") as error:
        read(path)
    assert f"{one} (" in str(error.value)
    assert f"{other} (" in str(error.value)
    for topic in (one, other):
        assert not any(f"{meaning} of" in remark for remark in remarks(read(path, topic)))


def test_what_would_not_do_is_not_among_several(tmp_path):
    """Depths are no pictures, a cloud that is not flat is no scan, a single pose is no motion."""
    high = np.array([[1.0, 0, 0], [1.0, 0, 2.0]])
    said = [bags.image(t, COLOUR[..., 0], "mono8", topic="/grey") for t in TIMES]
    said += [bags.image(t, np.zeros((9, 9), "<u2"), "16UC1", topic="/depth") for t in TIMES]
    said += [*MEANINGS["scans"][1]["/scan"], *(bags.cloud(t, high) for t in TIMES)]
    said += [*wheels(), bags.stamped_pose(0, np.eye(4), topic="/goal")]
    path = write_bag(tmp_path / "robot", said)
    assert read_bag_motion(path).report.remarks == ("poses of /odom",)
    assert read_film(path).remarks == ["pictures of /grey"]
    assert read_bag_scans(path).report.remarks == ("scans of /scan",)
    assert "speeds of /odom" in read_commands(path).report.remarks


def test_of_what_would_not_do_alone_the_reason_is_told(tmp_path):
    high = np.array([[1.0, 0, 0], [1.0, 0, 2.0]])
    with pytest.raises(CorruptLog, match=r"heights from 0\.00 to 2\.00 m, not a scan"):
        read_bag_scans(write_bag(tmp_path / "cloud", [bags.cloud(0, high)]))
    path = write_bag(tmp_path / "poses", [bags.stamped_pose(*one) for one in WAY])
    with pytest.raises(CorruptLog, match=r"no topic holds speeds \(Odometry, .*it has /pose \(Po"):
        read_commands(path)


# Topics of two files ------------------------------------------------------------------------------


def test_topics_are_shared_out_among_bags(tmp_path):
    one = write_bag(tmp_path / "one.bag", [bags.odometry(0, np.eye(4)), bags.scan(0, [1.0])])
    two = write_bag(tmp_path / "two.bag", [bags.stamped_pose(0, np.eye(4)), bags.scan(0, [1.0])])
    (tmp_path / "a.csv").write_text("1\n")
    shared = share_topics(["/scan", "odom", "/pose"], one, two)
    assert shared == (("/scan", "odom"), ("/scan", "/pose"))
    assert share_topics(["/scan", "/odom"], one, None) == (("/scan", "/odom"),) * 2
    assert share_topics(["/scan", "/no"], one, tmp_path / "a.csv") == (("/scan", "/no"),) * 2
    assert share_topics([], one, two) == ((), ())
    with pytest.raises(CorruptLog, match=r"topic '/no' is not in .*one\.bag or .*two\.bag"):
        share_topics(["/scan", "/no"], one, two)
