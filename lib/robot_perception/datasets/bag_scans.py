"""Laser scans in ROS bags, and in clouds of points that lie in a plane."""

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from robot_perception.checks import flag
from robot_perception.datasets import bags
from robot_perception.datasets.bag_motion import ODOMETRY, BagMotion, motion_in, mount
from robot_perception.datasets.bags import Bag, Topics
from robot_perception.datasets.logs import CorruptLog, LaserLog, ReadReport
from robot_perception.files import reading
from robot_perception.geometry import se2, wrap_angle

SCAN, CLOUD = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/PointCloud2"
LONGEST_GAP = 0.5  # s between two poses of the odometry
LEVEL = np.cos(np.deg2rad(10.0))  # a scanner that is tilted by more measures no plan of the room
STEPS = 0.2  # by which share the step from beam to beam may be another for a scan to be resampled
FLAT = 0.05  # m: a cloud whose points are farther from one height is no scan
BEAMS = 720  # in a turn, into which a flat cloud is sorted
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}  # of PointField


@dataclass(frozen=True, eq=False, slots=True)
class BagScans:
    """Laser scans from a ROS bag.

    Parameters
    ----------
    times : (scans,)
        s since 1970, rising.
    ranges : (scans, beams)
        m; infinite where nothing came back, NaN where a reading is void.
    angles : (beams,)
        Directions of the beams in the frame of the scanner, rising, rad.
    frame
        Name of that frame.
    topic
        Where they were found.
    farthest
        What the scanner says is its range, m.
    report
        What became of all messages of the bag.
    """

    times: Float[np.ndarray, " scans"]
    ranges: Float[np.ndarray, "scans beams"]
    angles: Float[np.ndarray, " beams"]
    frame: str
    topic: str
    farthest: float
    report: ReadReport


def read_bag_scans(path: str | Path, topic: Topics = None) -> BagScans:
    """Read laser scans from a ROS bag.

    As REP 117 has it, and drivers before it: readings beyond the range of the scanner, infinite
    ones too, came back from nothing; NaN, minus infinity, 0 and others nearer than its least
    distance are void.

    Most scans decide where the beams point. Others of the same field, as of scanners that turn
    unevenly, are resampled: each beam takes the reading of the one that was nearest, which is half
    a step away at most. Scans whose steps differ by more than a fifth are skipped and counted, like
    those whose time stamp does not lie after the one before.

    A cloud of points is read where all lie at one height, as scans that were turned into clouds
    do; 720 beams then take the nearest points in their direction.

    Parameters
    ----------
    path
        The bag, as `is_bag` describes it.
    topic
        Of ``sensor_msgs/LaserScan`` or ``sensor_msgs/PointCloud2``, or several of which one is;
        needed where several topics do.

    Raises
    ------
    CorruptLog
        If it is no bag or a damaged one, no topic or more than one will do, the clock was set back,
        scans come from several frames, a scan is none, or a cloud is not flat.
    FileNotFoundError
        If there is none.

    References
    ----------
    Conley, "Informational distance measurements", ROS enhancement proposal 117, 2011.
    """
    topic = bags.check_topic(topic)
    with bags.opened(path) as bag:
        return _scans_in(bag, topic)


def read_bag_log(path: str | Path, topic: Topics = None, *, still: bool = False) -> LaserLog:
    """Read laser scans from a ROS bag with the poses that they were taken from.

    The poses are those of the odometry at the times of the scans, between two of them by straight
    lines, and of the scanner's place on the robot, where the bag tells it (``tf_static``, or a
    transform that never changes); a scanner that hangs upside down is turned. Scans at whose time
    there is no odometry within half a second are skipped and counted.

    Parameters
    ----------
    path
        The bag, as `is_bag` describes it.
    topic
        Of the scans, as `read_bag_scans` takes it; several may name that of the odometry, too.
    still
        Whether a robot without any odometry is taken to stand still; its scanner is the origin.

    Returns
    -------
    LaserLog
        Its report has remarks, if the scanner's place is unknown for one.

    Raises
    ------
    CorruptLog
        As of `read_bag_scans` and `read_bag_motion`; if there is no odometry at the time of a scan,
        or the scanner is not level.
    FileNotFoundError
        If there is none.
    """
    topic, still = bags.check_topic(topic), flag("still", still)
    with bags.opened(path) as bag:
        scans = _scans_in(bag, topic)
        named = () if isinstance(topic, str) else topic
        if still and not bag.candidates((ODOMETRY,), named):
            return _standing(scans)
        return _driven(bag, scans, motion_in(bag, bag.choose((ODOMETRY,), named)))


def _standing(scans: BagScans) -> LaserLog:
    """Return scans of a robot that stands still."""
    remark = "the bag holds no odometry: the robot is taken to stand still"
    return LaserLog(
        scans.ranges,
        scans.angles,
        np.zeros((len(scans.ranges), 3)),
        np.zeros((len(scans.ranges), 3)),
        scans.times,
        scans.farthest,
        replace(scans.report, remarks=(*scans.report.remarks, remark)),
    )


def _driven(bag: Bag, scans: BagScans, motion: BagMotion) -> LaserLog:
    """Return scans with the poses that they were taken from."""
    T = mount(bag, motion.body, scans.frame)
    remarks = [*scans.report.remarks, *motion.report.remarks]
    if T is None:
        T = np.eye(4)
        remarks.append(
            f"the bag does not say where {scans.frame!r} is on {motion.body!r}:"
            " taken to be the same place"
        )
    ranges, angles, place = _levelled(bag.path, scans, T)
    robot, covered = motion.track().at(scans.times, longest_gap=LONGEST_GAP)
    if not covered.any():
        raise CorruptLog(
            f"{bag.path}: no odometry of {motion.topic} at the time of a scan of {scans.topic}"
        )
    if lost := np.count_nonzero(~covered):
        remarks.append(f"{scans.topic}: {lost} scans skipped, no odometry at their time")
    kept = {scans.topic: int(covered.sum()), motion.topic: len(motion.times)}
    return LaserLog(
        ranges[covered],
        angles,
        se2.compose(robot[covered], place),
        robot[covered],
        scans.times[covered],
        scans.farthest,
        bag.report(kept, remarks),
    )


def _scans_in(bag: Bag, wanted: Topics) -> BagScans:
    """Read the scans of an open bag."""
    topic = bag.choose((SCAN, CLOUD), wanted)
    messages = list(bag.messages(topic, (SCAN, CLOUD)))
    stamps, logged, contents = zip(*messages, strict=True)
    times, kept, remarks = bags.rising(bag.path, topic, stamps, logged)
    contents = [content for content, good in zip(contents, kept, strict=True) if good]
    frames = sorted({content.header.frame_id.lstrip("/") for content in contents})
    if len(frames) > 1:
        raise CorruptLog(f"{bag.path}: {topic} holds scans of several frames: {', '.join(frames)}")
    found = []
    for number, content in enumerate(contents, start=1):
        read = _of_scan if content.__msgtype__ == SCAN else _of_cloud
        found.append(read(f"{bag.path}: scan {number} of {topic}", content))
    ranges, angles, good, more = _on_the_same_beams(topic, found)
    return BagScans(
        times[kept][good] / 1e9,
        ranges,
        angles,
        frames[0],
        topic,
        max((float(one.range_max) for one in contents if one.__msgtype__ == SCAN), default=np.inf),
        bag.report({topic: int(good.sum())}, [*remarks, *more]),
    )


def _of_scan(which: str, scan: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the readings of a scan and the directions of its beams, rising."""
    first, step = float(scan.angle_min), float(scan.angle_increment)
    nearest, farthest = float(scan.range_min), float(scan.range_max)
    ranges = np.array(scan.ranges, dtype=float)
    if not np.isfinite([first, step]).all() or not step or not ranges.size:
        raise CorruptLog(f"{which} has {ranges.size} beams from {first:g} rad in steps of {step:g}")
    if not farthest > max(nearest, 0.0):
        raise CorruptLog(f"{which} has ranges from {nearest:g} to {farthest:g} m")
    with np.errstate(invalid="ignore"):
        nothing, near = ranges > farthest, (ranges < nearest) | (ranges <= 0)
    ranges[nothing], ranges[near] = np.inf, np.nan
    angles = first + step * np.arange(ranges.size)
    return (ranges, angles) if step > 0 else (ranges[::-1], angles[::-1])


def _of_cloud(which: str, cloud: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the readings of a flat cloud and the directions of their beams."""
    with reading(which, "a damaged cloud of points", CorruptLog):
        points = _points(cloud)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) and np.abs(points[:, 2] - np.median(points[:, 2])).max() > FLAT:
        raise CorruptLog(
            f"{which} holds points at heights from {points[:, 2].min():.2f} to"
            f" {points[:, 2].max():.2f} m, not a scan: record a LaserScan, which the node"
            " pointcloud_to_laserscan makes of such clouds"
        )
    angles = 2 * np.pi * (np.arange(BEAMS) - BEAMS // 2) / BEAMS
    ranges = np.full(BEAMS, np.inf)
    beams = np.rint((np.arctan2(points[:, 1], points[:, 0]) - angles[0]) / (2 * np.pi) * BEAMS)
    distances = np.hypot(points[:, 0], points[:, 1])
    np.minimum.at(ranges, beams.astype(int) % BEAMS, np.where(distances > 0, distances, np.inf))
    return ranges, angles


def _points(cloud: Any) -> Float[np.ndarray, "n 3"]:
    """Return the points of a cloud, those that are not finite too."""
    order = ">" if cloud.is_bigendian else "<"
    fields = {field.name: field for field in cloud.fields if field.name in ("x", "y", "z")}
    layout = {
        "names": list(fields),
        "formats": [order + TYPES[field.datatype] for field in fields.values()],
        "offsets": [field.offset for field in fields.values()],
        "itemsize": cloud.point_step,
    }
    rows = np.asarray(cloud.data, dtype=np.uint8).reshape(cloud.height, cloud.row_step)
    rows = np.ascontiguousarray(rows[:, : cloud.width * cloud.point_step])
    table = rows.reshape(-1).view(np.dtype(layout))
    return np.column_stack([table[name].astype(float) for name in "xyz"])


def _on_the_same_beams(
    topic: str, found: list[tuple[np.ndarray, np.ndarray]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[str]]:
    """Return all scans on the beams of most, which scans these are, and sentences on the others."""
    kinds = Counter((len(angles), angles[0], angles[-1]) for _, angles in found)
    usual = kinds.most_common(1)[0][0]
    angles = next(beams for _, beams in found if (len(beams), beams[0], beams[-1]) == usual)
    ranges, resampled = np.full((len(found), len(angles)), np.nan), 0
    good = np.ones(len(found), dtype=bool)
    for k, (readings, beams) in enumerate(found):
        if (len(beams), beams[0], beams[-1]) == usual:
            ranges[k] = readings
        elif len(beams) > 1 and len(angles) > 1 and _alike(beams, angles):
            ranges[k] = _resampled(readings, beams, angles)
            resampled += 1
        else:
            good[k] = False
    remarks = []
    if resampled:
        remarks.append(f"{topic}: {resampled} scans with other beams, resampled to those of most")
    if not good.all():
        count = np.count_nonzero(~good)
        remarks.append(f"{topic}: {count} scans skipped, with beams of another step")
    return ranges[good], angles, good, remarks


def _alike(beams: np.ndarray, angles: np.ndarray) -> bool:
    return bool(abs((beams[1] - beams[0]) / (angles[1] - angles[0]) - 1) <= STEPS)


def _resampled(readings: np.ndarray, beams: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return for each direction the reading of the nearest beam, NaN where none is near."""
    step = beams[1] - beams[0]
    place = np.rint((angles - beams[0]) / step).astype(int)
    inside = (place >= 0) & (place < len(beams))
    return np.where(inside, readings[np.clip(place, 0, len(beams) - 1)], np.nan)


def _levelled(
    path: Path, scans: BagScans, T: Float[np.ndarray, "4 4"]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return readings and directions of a scanner that stands upright, and its place (x, y, h)."""
    R = T[:3, :3]
    if abs(R[2, 2]) < LEVEL:
        tilt = np.rad2deg(np.arccos(np.clip(abs(R[2, 2]), 0, 1)))
        raise CorruptLog(f"{path}: the scanner {scans.frame!r} is tilted by {tilt:.0f} degrees")
    place = np.array([T[0, 3], T[1, 3], wrap_angle(np.arctan2(R[1, 0], R[0, 0]))])
    if R[2, 2] > 0:
        return scans.ranges, scans.angles, place
    return scans.ranges[:, ::-1], -scans.angles[::-1], place
