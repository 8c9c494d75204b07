"""ROS bags of every kind, and messages that no reader can use."""

from collections.abc import Callable
from functools import lru_cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from robot_perception import datasets
from robot_perception.datasets import CorruptImage, CorruptLog
from robot_perception.geometry import se2, se3, wrap_angle
from tests.datasets import bags
from tests.datasets.formats.declared import Damage, Format
from tests.datasets.writing import encoded

# Every kind of bag, and every kind of message -----------------------------------------------------

ON_ROBOT = np.array([0.2, 0.1, np.pi / 2])
SQUARE = np.array([[1, 0, 0], [0, 2, 0.01], [-3, 0, 0]])


def robot(ros: int) -> list[bags.Said]:
    """Return what a robot says by all types of messages."""
    more = [bags.transform(0, "base_link", "laser", se3.from_se2(ON_ROBOT), ros=ros)]
    more += [bags.compressed(time, encoded(bags.COLOUR), "png") for time in bags.TIMES]
    more += [bags.cloud(time, SQUARE, ros=ros) for time in bags.TIMES]
    more += [
        bags.stamped_pose(time, se3.from_se2(pose))
        for time, pose in zip(bags.TIMES, bags.POSES, strict=True)
    ]
    return [*bags.drive(), *bags.eyes(), *more]


@lru_cache
def stored(kind: str) -> dict[str, bytes]:
    """Return the files of the bag of a robot."""
    with TemporaryDirectory() as name:
        bags.write_bag(Path(name) / kind, robot(1 if kind.endswith(".bag") else 2))
        files = [path for path in Path(name).rglob("*") if path.is_file()]
        return {str(path.relative_to(name)): path.read_bytes() for path in files}


def put(folder: Path, kind: str) -> None:
    """Write the bag of a robot."""
    for name, inner in stored(kind).items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(inner)


class Frames:
    """A film of a bag that was read to its end."""

    def __init__(self, path: Path, topic: str) -> None:
        self.film = datasets.read_film(path, topic=topic)
        self.before = list(self.film.remarks)
        self.frames = np.array(list(self.film))


AT = bags.TIMES[1:] - 0.01
ALONG = np.column_stack([AT, 0.5 * AT, wrap_angle(AT + 3.0)])
LEFT_EYE, COMPRESSED = "/left/image_rect", "/camera/image_raw/compressed"
READERS = {  # by what is read: the reader, and what it must read
    "scans": (
        partial(datasets.read_bag_scans, topic="/scan"),
        {
            "times": bags.seconds(AT),
            "ranges": np.float32([bags.READ[1], bags.READ[0]] * 2),
            "angles": [-1, -0.5, 0, 0.5, 1],
            "frame": "laser",
            "topic": "/scan",
            "farthest": 8.0,
            "report.kept": {"/scan": 4},
            "report.others./odom": 5,
            "report.lines": 4 + 5 + 1 + 12 + 15,
        },
    ),
    "motion": (
        partial(datasets.read_bag_motion, topic="/odom"),
        {
            "times": bags.seconds(bags.TIMES),
            "poses": se3.from_se2(bags.POSES),
            "covs": [bags.COV] * 5,
            "velocities": [[1.1, 1.0]] * 5,
            "world": "odom",
            "body": "base_link",
            "topic": "/odom",
        },
    ),
    "poses": (
        partial(datasets.read_bag_motion, topic="/pose"),
        {"poses": se3.from_se2(bags.POSES), "covs": None, "velocities": None, "world": "map"},
    ),
    "track": (
        partial(datasets.read_track, topic="/odom"),
        {
            "times": bags.seconds(bags.TIMES),
            "poses": np.column_stack([bags.POSES[:, :2], wrap_angle(bags.POSES[:, 2])]),
            "covs": [bags.COV] * 5,
            "report.kept": {"/odom": 5},
        },
    ),
    "log": (
        partial(datasets.read_bag_log, topic=["/scan", "/odom"]),
        {
            "odometry": ALONG,
            "poses": se2.compose(ALONG, ON_ROBOT),
            "max_range": 8.0,
            "report.kept": {"/scan": 4, "/odom": 5},
            "report.remarks": (),
        },
    ),
    "film": (
        partial(Frames, topic=LEFT_EYE),
        {
            "film.size": (32, 24),
            "film.promised": 3,
            "before": [],
            "film.rate": np.array(10.0),
            "film.times": bags.seconds(bags.TIMES[:3]),
            "film.numbers": [1, 2, 3],
            "film.finished": True,
            "film.missing": 0,
            "frames": np.stack([np.dstack([bags.GREY + k] * 3) for k in range(3)]),
        },
    ),
    "compressed": (partial(Frames, topic=COMPRESSED), {"frames": np.stack([bags.COLOUR] * 5)}),
    "stereo": (
        datasets.read_bag_stereo,
        {
            "size": (32, 24),
            "calibration.focal": (50, 50),
            "calibration.baseline": np.array(0.1),
            "times": bags.seconds(bags.TIMES[:3]),
            "2.0": bags.GREY + 2,
            "2.1": bags.GREY + 3,
            "0.0": bags.GREY,
            "0.1": bags.GREY + 1,
            "report.kept": {"/left/image_rect": 3, "/right/image_rect": 3},
        },
    ),
}


def bag(kind: str, read, reads, *, costs: bool) -> Format:
    """Return the format of a kind of bag, by one reader."""
    return Format(
        read,
        partial(put, kind=kind),
        reads,
        form="bytes",
        file=kind if kind.endswith(".bag") else f"{kind}/{kind}.*",
        opens=kind,
        error=CorruptLog,
        empty="",
        costs=costs,
        atol=2e-6,
    )


# Messages that no reader can use ------------------------------------------------------------------


def content(said: list[bags.Said]) -> bytes:
    """Return the content of a ROS 1 bag."""
    with TemporaryDirectory() as folder:
        return bags.write_bag(Path(folder) / "a.bag", said).read_bytes()


def unusable(
    read: Callable, good: Callable[[], list[bags.Said]], reads, cases, error=CorruptLog
) -> Format:
    """Return the format of bags that one reader refuses for what was said."""

    def change(said: list[bags.Said]) -> Callable[[bytes], bytes]:
        return lambda _content: content(said)

    return Format(
        read,
        lambda folder: bags.write_bag(folder / "odd.bag", good()),
        reads,
        {name: Damage(change(said), f": {words}", error=error) for name, (said, words) in cases},
        form="bytes",
        file="odd.bag",
        empty="",
        atol=2e-6,
        costs=True,
    )


def broken(place: str, value: float) -> bags.Said:
    said = bags.odometry(0.0, np.eye(4))
    said.fields["pose"]["pose"][place]["w" if place == "orientation" else "x"] = value
    return said


SIDE = se3.exp(np.array([[0, 0, 0, -np.pi / 2, 0, 0]]))[0]
MOTIONS = {
    "NaN": ([broken("position", np.nan)], "message 1 of /odom is NaN or infinite"),
    "no quaternion": (
        [broken("orientation", 0.0)],
        "pose 1 of /odom has no quaternion of unit length",
    ),
    "an infinite speed": (
        [bags.odometry(0.0, np.eye(4), speed=np.inf)],
        "message 1 of /odom is NaN or infinite",
    ),
    "no poses": (
        [bags.Said("/battery", "std_msgs/msg/Float32", {"data": 1.0}, 0.0)],
        r".*/battery \(Float32, 1 message\)",
    ),
}
SCANS = {
    "two frames": (
        [bags.scan(0, [1], frame="a"), bags.scan(1, [1], frame="b")],
        ".*scans of several frames: a, b",
    ),
    "no step": (
        [bags.scan(0, [1, 1], angles=(0.0, 0.0))],
        "scan 1 of /scan has 2 beams from 0 rad in steps of 0",
    ),
    "NaN": (
        [bags.scan(0, [1, 1], angles=(np.nan, 0.1))],
        "scan 1 of /scan has 2 beams from nan rad",
    ),
    "no beams": ([bags.scan(0, [])], "scan 1 of /scan has 0 beams"),
    "no range": ([bags.scan(0, [1], range_max=0.0)], "scan 1 of /scan has ranges from 0.1 to 0 m"),
    "a high cloud": (
        [bags.cloud(0, np.array([[1, 0, 0], [1, 0, 2.0]]), ros=1)],
        ".*heights from 0.00 to 2.00 m, not a scan",
    ),
    "a cloud without heights": (
        [bags.cloud(0, np.ones((2, 2)), names="xy", ros=1)],
        "scan 1 of /points: a damaged cloud of points",
    ),
}


def png(pixels: np.ndarray) -> bytes:
    return cv2.imencode(".png", pixels)[1].tobytes()


DEPTHS = np.where(bags.GREY > 100, 2000 + bags.GREY.astype(np.uint16), 0).astype("<u2")
FULL = 1500 + bags.GREY.astype("<u2")  # nothing was left out
DEEP = {  # messages of depths and disparities: their encoding says it, whatever they hold
    "16UC1": bags.image(0, FULL, "16UC1"),
    "16UC1 with holes": bags.image(0, DEPTHS, "16UC1"),
    "16SC1": bags.image(0, FULL, "16SC1"),
    "32FC1": bags.image(0, FULL.astype("<f4"), "32FC1"),
    "64FC1": bags.image(0, FULL.astype("<f8"), "64FC1"),
    "compressed depths": bags.compressed(0, bytes(12) + png(FULL), "16UC1; compressedDepth png"),
    "of old": bags.compressed(0, bytes(12) + png(FULL), "16UC1; compressedDepth"),
    "by RVL": bags.compressed(0, b"x" * 99, "16UC1; compressedDepth rvl"),
    "metres": bags.compressed(0, bytes(12) + png(FULL), "32FC1; compressedDepth png"),
    "as a picture": bags.compressed(0, png(FULL), "16UC1; png compressed "),
    "as bytes": bags.compressed(0, png(bags.GREY), "16UC1; jpeg compressed "),
}
UNIT = b"\0\0\0\1\x67" + bytes(range(200))  # a part of H.264
PARTS = {
    "h264": bags.compressed(0, UNIT, "h264"),
    "H.264": bags.compressed(0, UNIT, "H.264"),
    "hevc": bags.compressed(0, UNIT, "hevc"),
    "h265": bags.compressed(0, UNIT, "h265; main"),
    "av1": bags.compressed(0, b"\x12\0" + UNIT, "av1"),
    "theora": bags.compressed(0, UNIT[1:], "theora"),
    "by its first bytes": bags.compressed(0, UNIT, ""),
    "by a wrong name": bags.compressed(0, UNIT[1:], "jpeg"),
}
PICTURES = (
    {
        f"depths, {name}": ([one], r"picture 1 of /camera/.* holds depths \('\d\d\w")
        for name, one in DEEP.items()
    }
    | {
        f"part of a film, {name}": (
            [one],
            f"picture 1 of /camera/.* is a part of a film \\('{one.fields['format']}'\\), not",
        )
        for name, one in PARTS.items()
    }
    | {
        name: ([one], f"picture 1 of /camera/.*{words}")
        for name, (one, words) in {
            "an encoding": (
                bags.image(0, bags.GREY, "8UC2"),
                "is encoded as '8UC2', which is none of mono8",
            ),
            "no picture": (bags.compressed(0, b"x"), "no picture, or a damaged one"),
            "nothing": (bags.compressed(0, b""), "empty"),
            "short rows": (
                bags.image(0, bags.GREY[:, :16], "bgr8", step=20),
                "is damaged: 480 bytes for 16 x 24 px of 3",
            ),
            "no columns": (bags.image(0, np.zeros((4, 0), np.uint8), "mono8"), "has 0 x 4 px"),
        }.items()
    }
    | {
        "another size": (
            [bags.image(k, bags.GREY[: 24 - 12 * k], "mono8") for k in range(2)],
            r"picture 2 of \S+ has 32 x 12 px, the first one 32 x 24",
        )
    }
)


def changed(topic: str, **fields) -> list[bags.Said]:
    """The pairs, with other fields in the calibration of one side."""
    said = bags.eyes()
    for one in said:
        if one.topic == topic:
            one.fields.update(fields)
    return said


STEREO = {
    "no CameraInfo": (
        [one for one in bags.eyes() if "info" not in one.topic],
        ".*left may be none, right none, without CameraInfo are /left/image_rect, /right/image_r",
    ),
    "one eye": (
        [one for one in bags.eyes() if "right" not in one.topic],
        ".*left may be /left/image_rect, right none",
    ),
    "another scale": (
        changed("/right/camera_info", p=(bags.RIGHT * [2, 1, 1, 1]).ravel()),
        ".*not those of a rectified pair: fx 50 and 100",
    ),
    "another size": (
        changed("/left/camera_info", width=64),
        ".*have 32 x 24 px, their CameraInfo says 64 x 24",
    ),
    "a calibration that changes": (
        [*bags.eyes(), bags.camera_info(9, 2 * bags.P, (32, 24), topic="/left/camera_info")],
        ".*the calibration in /left/camera_info changes",
    ),
    "an unknown lens": (
        [
            bags.Said(o.topic.replace("rect", "raw"), o.kind, o.fields, o.time)
            for o in changed("/left/camera_info", d=np.ones(5), distortion_model="mine")
        ],
        ".*their lens is of the unknown model 'mine'",
    ),
}
ANY = (CorruptLog, CorruptImage)

FORMATS = {
    f"bag_{kind.replace('.', '_')}_{name}": bag(kind, read, reads, costs=name != "track")
    for kind in bags.KINDS
    for name, (read, reads) in READERS.items()
} | {
    "messages_motion": unusable(
        datasets.read_bag_motion, bags.drive, READERS["motion"][1], MOTIONS.items(), CorruptLog
    ),
    "messages_on_side": unusable(
        datasets.read_track,
        bags.drive,
        {"covs": [bags.COV] * 5},
        {
            "a camera on its side": (
                [bags.odometry(0, np.eye(4)), bags.odometry(1, SIDE)],
                "pose 2 of /odom turns the robot onto its side",
            )
        }.items(),
    ),
    "messages_scans": unusable(
        datasets.read_bag_scans, bags.drive, {"frame": "laser", "farthest": 8.0}, SCANS.items()
    ),
    "messages_pictures": unusable(
        lambda path: list(datasets.read_bag_film(path)),
        lambda: [bags.image(0, bags.COLOUR, "rgb8")],
        {"0": bags.COLOUR},
        PICTURES.items(),
        CorruptImage,
    ),
    "messages_stereo": unusable(
        datasets.read_bag_stereo,
        bags.eyes,
        {"size": (32, 24), "2.0": bags.GREY + 2},
        STEREO.items(),
        ANY,
    ),
}
