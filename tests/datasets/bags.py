"""Writes ROS bags of every kind: what a robot would have recorded of known numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation

from robot_perception.geometry import se3

SQLITE, MCAP = StoragePlugin.SQLITE3, StoragePlugin.MCAP
KINDS = {  # by the name of the bag: how it is packed
    "plain.bag": None,
    "bz2.bag": Writer1.CompressionFormat.BZ2,
    "lz4.bag": Writer1.CompressionFormat.LZ4,
    "sqlite": (SQLITE, CompressionMode.NONE),
    "sqlite_file": (SQLITE, CompressionMode.FILE),
    "sqlite_message": (SQLITE, CompressionMode.MESSAGE),
    "mcap": (MCAP, CompressionMode.NONE),
    "mcap_chunks": (MCAP, CompressionMode.STORAGE),
}
STORES = {1: get_typestore(Stores.ROS1_NOETIC), 2: get_typestore(Stores.ROS2_HUMBLE)}
STORES[1].register(
    get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage")
)
for kind, fields in {  # parts of films, by packages that are no part of ROS
    "foxglove_msgs/msg/CompressedVideo": "string frame_id\nuint8[] data\nstring format",
    "ffmpeg_image_transport_msgs/msg/FFMPEGPacket": "string encoding\nuint8[] data",
    "theora_image_transport/msg/Packet": "uint8[] data",
}.items():
    for store in STORES.values():
        store.register(get_types_from_msg(fields, kind))
START = 1_700_000_000 * 10**9  # ns


@dataclass(frozen=True)
class Said:
    """A message: its topic, its type, its fields by name, when it was measured and recorded, s."""

    topic: str
    kind: str
    fields: dict[str, Any]
    time: float
    logged: float | None = None
    frame: str = ""


def nanoseconds(time: float) -> int:
    return START + round(time * 1e9)


def write_bag(path: Path, messages: Sequence[Said]) -> Path:
    """Write messages as the kind of bag that the name stands for, and return where it is."""
    ros = 1 if path.suffix == ".bag" else 2
    store, packing = STORES[ros], KINDS.get(path.name, KINDS["plain.bag" if ros == 1 else "mcap"])
    if ros == 1:
        writer = Writer1(path)
        if packing:
            writer.set_compression(packing)
    else:
        writer = Writer2(path, version=9, storage_plugin=packing[0])
        writer.set_compression(packing[1], CompressionFormat.ZSTD)
    with writer:
        topics = {}
        for one in sorted(messages, key=lambda one: one.time if one.logged is None else one.logged):
            place = one.topic, one.kind
            if place not in topics:
                topics[place] = writer.add_connection(*place, typestore=store)
            message = made(ros, one.kind, one.fields, one.time, one.frame)
            pack = store.serialize_ros1 if ros == 1 else store.serialize_cdr
            logged = one.time if one.logged is None else one.logged
            writer.write(topics[place], nanoseconds(logged), pack(message, one.kind))
    return path


def made(ros: int, kind: str, fields: dict[str, Any], time: float | None, frame: str) -> Any:
    """Return a message of a type; fields that are not told are 0."""
    store = STORES[ros]
    values = {}
    for name, (form, of) in store.fielddefs[kind][1]:
        given = fields.get(name, fields.get(name.lower()))
        if name == "header" and time is not None:
            values[name] = header(ros, time, frame)
        elif given is not None and not isinstance(given, dict):
            values[name] = given
        elif form.name == "NAME":
            values[name] = made(ros, of, given or {}, None, "")
        elif form.name == "BASE":
            values[name] = "" if of[0] == "string" else of[0].startswith("float") * 0.0 or 0
        else:
            element, count = of
            values[name] = np.zeros(count or 0, element[1][0]) if element[0].name == "BASE" else []
    return store.types[kind](**values)


def header(ros: int, time: float, frame: str) -> Any:
    types = STORES[ros].types
    seconds, rest = divmod(nanoseconds(time), 10**9) if np.isfinite(time) else (0, 0)
    stamp = types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=rest)
    extra = {"seq": 0} if ros == 1 else {}
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **extra)


# Types of messages -------------------------------------------------------------------------------


def scan(time, ranges, *, topic="/scan", frame="laser", angles=(-1.0, 0.5), logged=None, **more):
    """Return a laser scan, whose angles are the first and the step."""
    fields = {
        "angle_min": angles[0],
        "angle_max": angles[0] + angles[1] * (len(ranges) - 1),
        "angle_increment": angles[1],
        "range_min": 0.1,
        "range_max": 8.0,
        "ranges": np.array(ranges, np.float32),
    }
    return Said(topic, "sensor_msgs/msg/LaserScan", fields | more, time, logged, frame)


def pose_fields(T: np.ndarray) -> dict[str, Any]:
    x, y, z, w = Rotation.from_matrix(T[:3, :3]).as_quat().tolist()
    at = dict(zip("xyz", T[:3, 3].tolist(), strict=True))
    return {"position": at, "orientation": {"x": x, "y": y, "z": z, "w": w}}


def odometry(time, T, *, topic="/odom", speed=0.0, turn=0.0, cov=None, body="base_link", **more):
    """Return odometry at a pose (4, 4), with a planar covariance (3, 3)."""
    full = np.zeros((6, 6))
    full[np.ix_([0, 1, 5], [0, 1, 5])] = 0 if cov is None else cov
    fields = {
        "child_frame_id": body,
        "pose": {"pose": pose_fields(T), "covariance": full.ravel()},
        "twist": {"twist": {"linear": {"x": speed}, "angular": {"z": turn}}},
    }
    return Said(topic, "nav_msgs/msg/Odometry", fields, time, more.get("logged"), "odom")


def stamped_pose(time, T, *, topic="/pose", frame="map", **more):
    fields = {"pose": pose_fields(T)}
    return Said(topic, "geometry_msgs/msg/PoseStamped", fields, time, more.get("logged"), frame)


def uncertain_pose(time, T, *, topic="/amcl_pose", frame="map", covariance=None):
    """Return a pose with a covariance (6, 6)."""
    full = np.zeros((6, 6)) if covariance is None else covariance
    fields = {"pose": {"pose": pose_fields(T), "covariance": full.ravel()}}
    return Said(topic, "geometry_msgs/msg/PoseWithCovarianceStamped", fields, time, None, frame)


def moved_frame(time, T, *, topic="/vicon", frame="world", body="robot"):
    """Return a transform that is no part of a tree, as motion capture sends it."""
    at, turn = pose_fields(T).values()
    fields = {"child_frame_id": body, "transform": {"translation": at, "rotation": turn}}
    return Said(topic, "geometry_msgs/msg/TransformStamped", fields, time, None, frame)


def twist(time, speed, turn, *, kind="TwistStamped", topic="/cmd_vel", side=0.0, logged=None):
    """Return speeds by one of the three types that hold nothing else."""
    both = {"linear": {"x": speed, "y": side}, "angular": {"z": turn}}
    deep = {"Twist": both, "TwistStamped": {"twist": both}}.get(kind, {"twist": {"twist": both}})
    return Said(topic, f"geometry_msgs/msg/{kind}", deep, time, logged, "base_link")


def echoes(time, readings, *, topic="/echoes", frame="laser", angles=(-1.0, 0.5), ros=2, **more):
    """Return a scan with several readings of each beam, or none."""
    kind = "sensor_msgs/msg/LaserEcho"
    several = [made(ros, kind, {"echoes": np.array(one, np.float32)}, None, "") for one in readings]
    fields = scan(time, [0.0] * len(readings), angles=angles, **more).fields
    fields |= {"ranges": several, "intensities": []}
    return Said(topic, "sensor_msgs/msg/MultiEchoLaserScan", fields, time, None, frame)


def transform(time, parent, child, T, *, topic="/tf_static", ros=2):
    """Return a message with one transform of frames."""
    at, turn = pose_fields(T).values()
    fields = {"child_frame_id": child, "transform": {"translation": at, "rotation": turn}}
    one = made(ros, "geometry_msgs/msg/TransformStamped", fields, time, parent)
    return Said(topic, "tf2_msgs/msg/TFMessage", {"transforms": [one]}, time)


def image(time, data, encoding, *, topic="/camera/image_raw", step=None, **more):
    """Return a picture, whose data are its bytes by rows."""
    high, wide = data.shape[:2]
    rows = np.ascontiguousarray(data).reshape(high, data[0].size).view(np.uint8)
    fields = {"height": high, "width": wide, "encoding": encoding, "step": rows.shape[1]}
    if step:
        rows, fields["step"] = np.pad(rows, [(0, 0), (0, step - rows.shape[1])]), step
    fields |= {"data": rows.ravel(), "is_bigendian": more.pop("is_bigendian", 0)}
    return Said(topic, "sensor_msgs/msg/Image", fields, time, frame="camera", **more)


def compressed(time, content, form="jpeg", *, topic="/camera/image_raw/compressed"):
    fields = {"format": form, "data": np.frombuffer(content, np.uint8)}
    return Said(topic, "sensor_msgs/msg/CompressedImage", fields, time, frame="camera")


def camera_info(time, P, size, *, topic="/camera/camera_info", **more):
    """Return the calibration of a camera by its matrix P (3, 4) and size (width, height)."""
    P = np.asarray(P, dtype=float)
    fields = {
        "width": size[0],
        "height": size[1],
        "distortion_model": "plumb_bob",
        "d": np.zeros(5),
        "k": P[:, :3].ravel(),
        "r": np.eye(3).ravel(),
        "p": P.ravel(),
    }
    return Said(topic, "sensor_msgs/msg/CameraInfo", fields | more, time, frame="camera")


def cloud(time, points, *, topic="/points", big=False, padded=0, names="xyz", ros=2):
    """Return a cloud of points (n, 3), in single precision, with bytes between them."""
    order = ">f4" if big else "<f4"
    step = 4 * len(names) + padded
    raw = np.zeros((len(points), step), np.uint8)
    packed = np.ascontiguousarray(points, dtype=order).view(np.uint8)
    raw[:, : packed.shape[1]] = packed
    kind = "sensor_msgs/msg/PointField"
    pieces = [
        made(ros, kind, {"name": n, "offset": 4 * k, "datatype": 7, "count": 1}, None, "")
        for k, n in enumerate(names)
    ]
    fields = {
        "height": 1,
        "width": len(points),
        "fields": pieces,
        "is_bigendian": big,
        "point_step": step,
        "row_step": step * len(points),
        "data": raw.ravel(),
        "is_dense": True,
    }
    return Said(topic, "sensor_msgs/msg/PointCloud2", fields, time, frame="laser")


def old_cloud(time, points, *, topic="/cloud", ros=2):
    """Return a cloud of points (n, 3) by the type before PointCloud2."""
    kind = "geometry_msgs/msg/Point32"
    some = [
        made(ros, kind, dict(zip("xyz", one, strict=True)), None, "") for one in points.tolist()
    ]
    return Said(topic, "sensor_msgs/msg/PointCloud", {"points": some}, time, frame="laser")


# A robot's recording -----------------------------------------------------------------------------

P = np.array([[50.0, 0, 16, 0], [0, 50, 12, 0], [0, 0, 1, 0]])
RIGHT = P - np.array([0, 0, 0, 5.0]) * (np.arange(3) == 0)[:, None]  # 0.1 m to the right
GREY = (np.arange(24 * 32).reshape(24, 32) % 251).astype(np.uint8)
COLOUR = np.stack([GREY, GREY[::-1], GREY[:, ::-1]], axis=-1)
TIMES = 0.1 * np.arange(5)
POSES = np.column_stack([TIMES, 0.5 * TIMES, 3.0 + TIMES])  # the heading wraps
COV = np.array([[0.02, 0.01, 0], [0.01, 0.03, 0], [0, 0, 0.001]])
RANGES = [[1.0, 2.0, np.inf, 9.0, np.nan], [0.05, 0.0, -np.inf, 8.0, 0.5]]
READ = [[1.0, 2.0, np.inf, np.inf, np.nan], [np.nan, np.nan, np.nan, 8.0, 0.5]]


def drive() -> list[Said]:
    """Odometry at five times, and a scan at each but the first, 10 ms before."""
    moved = [
        odometry(time, se3.from_se2(pose), speed=1.1, turn=1.0, cov=COV)
        for time, pose in zip(TIMES, POSES, strict=True)
    ]
    return moved + [scan(TIMES[k] - 0.01, RANGES[k % 2]) for k in range(1, 5)]


def eyes(**more) -> list[Said]:
    """Three rectified pairs, of which the right one is 2 ms late."""
    said = []
    for time in TIMES[:3]:
        for side, matrix, late in (("left", P, 0.0), ("right", RIGHT, 0.002)):
            picture = GREY + round(10 * time) + (side == "right")
            said += [
                image(time + late, picture, "mono8", topic=f"/{side}/image_rect"),
                camera_info(time, matrix, (32, 24), topic=f"/{side}/camera_info", **more),
            ]
    return said


def seconds(times) -> np.ndarray:
    return START / 1e9 + np.asarray(times)
