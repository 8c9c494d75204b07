"""What a ROS robot recorded of its motion: odometry, poses, and where its sensors are mounted."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from robot_perception.checks import check_covariance
from robot_perception.datasets import bags
from robot_perception.datasets.bags import Bag, Topics
from robot_perception.datasets.commands import LARGEST, Commands
from robot_perception.datasets.logs import CorruptLog, ReadReport
from robot_perception.datasets.tracks import Track

ODOMETRY = "nav_msgs/msg/Odometry"
POSES: dict[str, Callable[[Any], Any]] = {  # by the type of a message, how its pose is found
    ODOMETRY: lambda message: message.pose.pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": lambda message: message.pose.pose,
    "geometry_msgs/msg/PoseStamped": lambda message: message.pose,
}
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
PLANE = np.ix_([0, 1, 5], [0, 1, 5])  # of x, y, z and turns about them: x, y and heading
UNIT = 1e-3  # by how much the length of a quaternion may be off
LEAST_UP = 1e-6  # cosine between the axis up and that of the robot
STILL = 1e-6  # m, and of a rotation matrix: a transform that changes less does not move

Placed = dict[str, tuple[str, Float[np.ndarray, "4 4"]]]
"""By the name of a frame, that of its parent, and the motion from the parent to it."""


@dataclass(frozen=True, eq=False, slots=True)
class BagMotion:
    """Poses and velocities of a robot from a ROS bag.

    Parameters
    ----------
    times : (k,)
        s since 1970, rising.
    poses : (k, 4, 4)
        Rigid motions ``T_world_body``, m.
    covs : (k, 3, 3), optional
        Covariances of x, y (m) and heading (rad), where all messages have them.
    velocities : (k, 2), optional
        Forward speed in m/s and turn rate in rad/s of the body; odometry has them, poses do not.
    world, body
        Names of the two frames; the second is empty where the messages do not name it.
    topic
        Where it was found.
    report
        What became of all messages of the bag.
    """

    times: Float[np.ndarray, " k"]
    poses: Float[np.ndarray, "k 4 4"]
    covs: Float[np.ndarray, "k 3 3"] | None
    velocities: Float[np.ndarray, "k 2"] | None
    world: str
    body: str
    topic: str
    report: ReadReport

    def is_flat(self) -> bool:
        """Tell whether all poses are in the plane: of no height, and upright."""
        return bool(
            (np.abs(self.poses[:, 2, 3]) <= STILL).all() & (self.poses[:, 2, 2] >= 1 - STILL).all()
        )

    def track(self) -> Track:
        """Return position and heading in the plane; height, roll and pitch are left out.

        Raises
        ------
        CorruptLog
            If the body lies on its side, as the optical frame of a camera does.
        """
        R = self.poses[:, :3, :3]
        on_side = R[:, 2, 2] < LEAST_UP
        if on_side.any():
            k = int(np.argmax(on_side))
            raise CorruptLog(
                f"{self.report.path}: pose {k + 1} of {self.topic} turns the robot onto its side,"
                " so that it has no heading in the plane"
            )
        headings = np.arctan2(R[:, 1, 0], R[:, 0, 0])
        planar = np.column_stack([self.poses[:, :2, 3], headings])
        return Track(self.times, planar, self.covs, self.report)

    def commands(self) -> Commands:
        """Return the velocities, each held until the next.

        Raises
        ------
        CorruptLog
            If there are none, one is beyond 50 m/s or 20 rad/s, or all are 0 while the robot moves.
        """
        path = self.report.path
        if self.velocities is None:
            raise CorruptLog(f"{path}: {self.topic} holds poses without velocities")
        moved = np.ptp(self.poses, axis=0).max(initial=0.0) > STILL
        if moved and not self.velocities.any():
            raise CorruptLog(f"{path}: {self.topic} holds velocities of 0 while the robot moves")
        for name, values in zip(("speed_m_s", "turn_rate_rad_s"), self.velocities.T, strict=True):
            farthest = np.abs(values).max(initial=0.0)
            if farthest > LARGEST[name]:
                raise CorruptLog(
                    f"{path}: {name} of {self.topic} reaches {farthest:g}, beyond {LARGEST[name]}"
                )
        return Commands(self.times, self.velocities, self.report)


def read_bag_motion(path: str | Path, topic: Topics = None) -> BagMotion:
    """Read the motion of a robot from a ROS bag.

    Messages are ``nav_msgs/Odometry``, ``geometry_msgs/PoseWithCovarianceStamped`` or
    ``geometry_msgs/PoseStamped``; if no topic is named, the first of these types that is there.
    Those whose time stamp does not lie after the one before are skipped, and counted.

    Parameters
    ----------
    path
        The bag, as `is_bag` describes it.
    topic
        Its name, or several of which one holds such messages; needed where several topics do.

    Raises
    ------
    CorruptLog
        If it is no bag or a damaged one, no topic or more than one will do, the clock was set back,
        or a message holds no pose.
    FileNotFoundError
        If there is none.
    """
    topic = bags.check_topic(topic)
    with bags.opened(path) as bag:
        name = bag.choose(tuple(POSES), topic)
        return motion_in(bag, name)


def motion_in(bag: Bag, topic: str) -> BagMotion:
    """Read the motion from a topic of an open bag."""
    messages = list(bag.messages(topic, tuple(POSES)))
    stamps, logged, contents = zip(*messages, strict=True)
    times, kept, remarks = bags.rising(bag.path, topic, stamps, logged)
    contents = [content for content, good in zip(contents, kept, strict=True) if good]
    poses = [POSES[content.__msgtype__](content) for content in contents]
    T = _matrices(bag.path, topic, poses)
    covs, more = _covariances(topic, contents)
    twists, odometry = None, [one for one in contents if one.__msgtype__ == ODOMETRY]
    if len(odometry) == len(contents):
        both = [(one.twist.twist.linear, one.twist.twist.angular) for one in odometry]
        values = np.array([[v.x, v.y, w.z] for v, w in both])
        _check_finite(bag.path, topic, values)
        twists = values[:, [0, 2]]
        if sideways := np.count_nonzero(np.abs(values[:, 1]) > 1e-3):
            remarks.append(f"{topic}: {sideways} messages with a speed to the side, left out")
    return BagMotion(
        times[kept] / 1e9,
        T,
        covs,
        twists,
        _frame(contents[0].header.frame_id),
        _frame(getattr(contents[0], "child_frame_id", "")),
        topic,
        bag.report({topic: len(contents)}, [*remarks, *more]),
    )


def mount(bag: Bag, body: str, sensor: str) -> Float[np.ndarray, "4 4"] | None:
    """Return where a sensor is mounted, ``T_body_sensor``; nothing if the bag does not tell.

    The transforms that do not move are looked at: those of ``tf_static``, and those of other topics
    that are the same whenever they are told.

    Parameters
    ----------
    bag
        It is open.
    body, sensor
        Names of their frames.
    """
    if body == sensor:
        return np.eye(4)
    placed = _placed(bag)
    above_body, above_sensor = _ancestors(placed, body), _ancestors(placed, sensor)
    for name, T in above_sensor.items():
        if name in above_body:
            return np.linalg.inv(above_body[name]) @ T
    return None


def _matrices(path: Path, topic: str, poses: list[Any]) -> Float[np.ndarray, "k 4 4"]:
    """Return poses of messages as rigid motions."""
    from scipy.spatial.transform import Rotation  # the other readers do without

    at = np.array([[one.position.x, one.position.y, one.position.z] for one in poses])
    turn = [one.orientation for one in poses]
    turns = np.array([[q.x, q.y, q.z, q.w] for q in turn])
    _check_finite(path, topic, np.hstack([at, turns]))
    off = np.abs(np.linalg.norm(turns, axis=1) - 1) > UNIT
    if off.any():
        k = int(np.argmax(off))
        raise CorruptLog(f"{path}: pose {k + 1} of {topic} has no quaternion of unit length")
    T = np.zeros((len(poses), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = Rotation.from_quat(turns).as_matrix(), at, 1
    return T


def _check_finite(path: Path, topic: str, values: Float[np.ndarray, "k n"]) -> None:
    bad = ~np.isfinite(values).all(axis=1)
    if bad.any():
        raise CorruptLog(f"{path}: message {np.argmax(bad) + 1} of {topic} is NaN or infinite")


def _covariances(
    topic: str, contents: list[Any]
) -> tuple[Float[np.ndarray, "k 3 3"] | None, list[str]]:
    """Return the covariances in the plane, if all are told, and a sentence if they are none."""
    both = [getattr(content.pose, "covariance", None) for content in contents]
    if any(cov is None for cov in both):
        return None, []
    covs = np.array([np.reshape(cov, (6, 6))[PLANE] for cov in both])
    if not covs.any(axis=(1, 2)).all():  # 0 says that nobody knows
        return None, []
    try:
        check_covariance("covariances", covs)
    except ValueError as error:
        return None, [f"{topic}: without its covariances, which are none ({error})"]
    return covs, []


def _placed(bag: Bag) -> Placed:
    """Return the transforms of a bag that do not move."""
    placed: Placed = {}
    moving = set()
    for topic, kinds in bag.topics.items():
        if not {*TRANSFORMS} & {*kinds}:
            continue
        for message in bag.messages(topic, TRANSFORMS):
            for one in message.content.transforms:
                T = _matrix(one.transform)
                parent, child = _frame(one.header.frame_id), _frame(one.child_frame_id)
                known = placed.setdefault(child, (parent, T))
                if known[0] != parent or not np.abs(known[1] - T).max() <= STILL:
                    moving.add(child)
    return {child: place for child, place in placed.items() if child not in moving}


def _matrix(transform: Any) -> Float[np.ndarray, "4 4"]:
    """Return a transform as a rigid motion; one that is none moves for ever."""
    from scipy.spatial.transform import Rotation

    at, q = transform.translation, transform.rotation
    T, turn = np.eye(4), np.array([q.x, q.y, q.z, q.w])
    if not abs(np.linalg.norm(turn) - 1) < UNIT:
        return np.full((4, 4), np.nan)
    T[:3, :3], T[:3, 3] = Rotation.from_quat(turn).as_matrix(), [at.x, at.y, at.z]
    return T


def _ancestors(placed: Placed, frame: str) -> dict[str, Float[np.ndarray, "4 4"]]:
    """Return the frames above a frame and itself, each with the motion from it to the frame."""
    T, found = np.eye(4), {}
    while frame not in found:
        found[frame] = T
        if frame in placed:
            frame, step = placed[frame]
            T = step @ T
    return found


def _frame(name: str) -> str:
    return name.lstrip("/")
