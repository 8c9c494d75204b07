"""Motion that a ROS robot recorded: odometry, poses, and where its sensors are mounted."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from robot_perception.checks import check_covariance
from robot_perception.datasets import bags
from robot_perception.datasets.bag_transforms import (
    STILL,
    TREES,
    Frames,
    check_finite,
    frame_name,
    rigid_motions,
)
from robot_perception.datasets.bags import Bag, Meaning, Topics
from robot_perception.datasets.commands import LARGEST, Commands
from robot_perception.datasets.logs import CorruptLog, ReadReport
from robot_perception.datasets.tracks import Track

ODOMETRY = "nav_msgs/msg/Odometry"
TWIST = "geometry_msgs/msg/Twist"
POSES: dict[str, Callable[[Any], Any]] = {  # by the type of a message, how its pose is found
    ODOMETRY: lambda message: message.pose.pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": lambda message: message.pose.pose,
    "geometry_msgs/msg/PoseStamped": lambda message: message.pose,
    "geometry_msgs/msg/TransformStamped": lambda message: message.transform,
}
TWISTS: dict[str, Callable[[Any], Any]] = {  # by the type of a message, how its speeds are found
    ODOMETRY: lambda message: message.twist.twist,
    "geometry_msgs/msg/TwistWithCovarianceStamped": lambda message: message.twist.twist,
    "geometry_msgs/msg/TwistStamped": lambda message: message.twist,
    TWIST: lambda message: message,
}
MOTIONS = Meaning("poses", (*POSES, *TREES.kinds))
SPEEDS = Meaning("speeds", tuple(TWISTS))
PLANE = np.ix_([0, 1, 5], [0, 1, 5])  # of x, y, z and turns about them: x, y and heading
UNKNOWN = 9e4, 9e4, (2 * np.pi) ** 2  # m², m², rad²: who writes such variances knows nothing
SIDEWAYS = 1e-3  # m/s
LEAST_UP = 1e-6  # cosine between the axis up and that of the robot


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
        Where it was found; of a tree of frames, with the two that were taken.
    delay
        Usual time from measuring to recording, as the clocks of both show it, s.
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
    delay: float
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
        return _commands(self.times, self.velocities, self.topic, self.report)


def read_bag_motion(path: str | Path, topic: Topics = None) -> BagMotion:
    """Read the motion of a robot from a ROS bag.

    Messages are ``nav_msgs/Odometry``, ``PoseStamped``, ``PoseWithCovarianceStamped`` or
    ``TransformStamped`` of ``geometry_msgs``, or a tree of frames (``tf2_msgs/TFMessage``), whose
    motion of the robot's body in the frame above it is taken. Messages whose time stamp does not
    lie after the one before are skipped, and counted.

    Covariances that say that nobody knows (0, less, not finite, or beyond 300 m or a turn) are left
    out, and the remarks tell it.

    Parameters
    ----------
    path
        The bag, as `is_bag` describes it.
    topic
        Its name, or several of which one holds such messages; needed where several topics do. The
        frames of a tree may follow it, such as ``/tf:map.base_link``.

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
        frames = Frames(bag)
        found, named = motion_topics(bag, topic, frames)
        return motion_in(bag, bag.only(MOTIONS, found, named=named), frames)


def read_bag_commands(path: str | Path, topic: Topics = None) -> Commands:
    """Read the speeds of a robot from a ROS bag, each held until the next.

    Messages are ``nav_msgs/Odometry``, or ``Twist``, ``TwistStamped`` or
    ``TwistWithCovarianceStamped`` of ``geometry_msgs``; a ``Twist`` counts from when it was
    recorded.

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
        a number is not finite or beyond 50 m/s or 20 rad/s, or all of odometry are 0 while the
        robot moves.
    FileNotFoundError
        If there is none.
    """
    topic = bags.check_topic(topic)
    with bags.opened(path) as bag:
        name = bag.choose(SPEEDS, topic)
        if ODOMETRY in bag.topics[name]:
            return motion_in(bag, name, Frames(bag)).commands()
        times, contents, remarks, _ = _messages(bag, name, SPEEDS)
        speeds, sideways = _speeds(bag.path, name, contents)
        report = bag.report({name: len(contents)}, [*remarks, *sideways])
        return _commands(times, speeds, name, report)


def motion_topics(bag: Bag, wanted: Topics, frames: Frames) -> tuple[list[str], bool]:
    """Return the topics that may be meant by a motion, and whether they were named.

    Those of trees of frames have the two frames in their names, after a colon. Where no topic is
    named, a single pose does not count, as of a goal, nor what a tree tells if another topic does.

    Raises
    ------
    CorruptLog
        If a topic that is named is not there, or holds no motion.
    """
    named = [(name, two) for name, two in bag.named(wanted) if bag.holds(name, MOTIONS)]
    several = bag.candidates(MOTIONS, wanted, lambda name: bag.counts[name] > 1)
    candidates = named or [(name, "") for name in several]
    found = [name for name, _ in candidates if not bag.holds(name, TREES)]
    told = [] if named else [_frames_in(bag.first(name, MOTIONS)) for name in found]
    for name, two in candidates:
        if bag.holds(name, TREES):
            pairs = [frames.two(name, two)] if two else frames.motions(name)
            known = (any(_are_same(frames, pair, other) for other in told) for pair in pairs)
            new = [pair for pair, is_known in zip(pairs, known, strict=True) if not is_known]
            found += [f"{name}:{parent}.{child}" for parent, child in new]
    return found, bool(named)


def motion_in(bag: Bag, topic: str, frames: Frames, *, recorded: bool = False) -> BagMotion:
    """Read the motion from a topic of an open bag.

    Parameters
    ----------
    bag
        It is open.
    topic
        One of those of `motion_topics`.
    frames
        Of the bag.
    recorded
        Whether to put the times on the clock of the recording.
    """
    name, _, two = topic.partition(":")
    if two:
        parent, child = frames.two(name, two)
        times, T, delay, remarks = frames.motion(name, parent, child, recorded=recorded)
        report = bag.report({name: bag.counts[name]}, remarks)
        return BagMotion(times, T, None, None, parent, child, topic, delay, report)
    times, contents, remarks, delay = _messages(bag, topic, MOTIONS, recorded)
    poses = [POSES[content.__msgtype__](content) for content in contents]
    T = rigid_motions(bag.path, topic, np.array([_place(one) for one in poses]))
    covs, more = _covariances(topic, contents)
    twists, odometry = None, [one for one in contents if one.__msgtype__ == ODOMETRY]
    if len(odometry) == len(contents):
        twists, sideways = _speeds(bag.path, topic, contents)
        more += sideways
    return BagMotion(
        times,
        T,
        covs,
        twists,
        *_frames_in(contents[0]),
        topic,
        delay,
        bag.report({topic: len(contents)}, [*remarks, *more]),
    )


def moves_by_speeds(bag: Bag) -> str:
    """Return a topic of an open bag that says that its robot moves, or nothing."""
    for name in bag.topics:
        if bag.holds(name, SPEEDS):
            contents = [message.content for message in bag.messages(name, SPEEDS.kinds)]
            if _speeds(bag.path, name, contents)[0].any():
                return name
    return ""


def _messages(
    bag: Bag, topic: str, meaning: Meaning, recorded: bool = False
) -> tuple[Float[np.ndarray, " k"], list[Any], list[str], float]:
    """Return the messages of a topic that are kept, their times and delay, s, and remarks."""
    stamps, logged, contents = zip(*bag.messages(topic, meaning.kinds), strict=True)
    told = bags.rising(bag.path, topic, stamps, logged, recorded=recorded)
    kept = [content for content, good in zip(contents, told.kept, strict=True) if good]
    return told.times[told.kept] / 1e9, kept, told.remarks, told.delay / 1e9


def _frames_in(content: Any) -> tuple[str, str]:
    """Return the frames that a message names, the second one empty if it does not."""
    world, body = content.header.frame_id, getattr(content, "child_frame_id", "")
    return frame_name(world), frame_name(body)


def _are_same(frames: Frames, one: tuple[str, str], other: tuple[str, str]) -> bool:
    """Tell whether the frames of two motions are the same, or fixed to each other."""
    return all(frames.are_fixed(a, b) for a, b in zip(one, other, strict=True))


def _place(pose: Any) -> list[float]:
    """Return position and quaternion of a pose or a transform."""
    at = pose.position if hasattr(pose, "position") else pose.translation
    q = pose.orientation if hasattr(pose, "orientation") else pose.rotation
    return [at.x, at.y, at.z, q.x, q.y, q.z, q.w]


def _speeds(
    path: Path, topic: str, contents: list[Any]
) -> tuple[Float[np.ndarray, "k 2"], list[str]]:
    """Return forward speeds and turn rates, and a sentence on speeds to the side."""
    twists = [TWISTS[content.__msgtype__](content) for content in contents]
    values = np.array([[one.linear.x, one.linear.y, one.angular.z] for one in twists])
    check_finite(path, topic, values)
    count = np.count_nonzero(np.abs(values[:, 1]) > SIDEWAYS)
    told = [f"{topic}: {count} messages with a speed to the side, left out"] if count else []
    return values[:, [0, 2]], told


def _commands(
    times: Float[np.ndarray, " k"],
    velocities: Float[np.ndarray, "k 2"],
    topic: str,
    report: ReadReport,
) -> Commands:
    """Return commands, or raise `CorruptLog` if one is beyond what a robot does."""
    for name, values in zip(("speed_m_s", "turn_rate_rad_s"), velocities.T, strict=True):
        farthest = np.abs(values).max(initial=0.0)
        if farthest > LARGEST[name]:
            told = f"{name} of {topic} reaches {farthest:g}, beyond {LARGEST[name]}"
            raise CorruptLog(f"{report.path}: {told}")
    return Commands(times, velocities, report)


def _covariances(
    topic: str, contents: list[Any]
) -> tuple[Float[np.ndarray, "k 3 3"] | None, list[str]]:
    """Return the covariances in the plane, if all are told, and a sentence if some are none."""
    both = [getattr(getattr(content, "pose", None), "covariance", None) for content in contents]
    if any(cov is None for cov in both):
        return None, []
    covs = np.array([np.reshape(cov, (6, 6))[PLANE] for cov in both])
    variances = np.diagonal(covs, axis1=1, axis2=2)
    if not covs.any():
        return None, []
    known = covs.any(axis=(1, 2)) & ((variances >= 0) & (variances < UNKNOWN)).all(axis=1)
    if not known.all():
        k = int(np.argmin(known))
        told = f"{np.count_nonzero(~known)} of {len(known)} say that nobody knows"
        variance = ", ".join(f"{value:g}" for value in variances[k])
        return None, [
            f"{topic}: without covariances: {told} (variances {variance} of pose {k + 1})"
        ]
    try:
        check_covariance("covariances", covs)
    except ValueError as error:
        return None, [f"{topic}: without its covariances, which are none ({error})"]
    return covs, []
