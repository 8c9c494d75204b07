"""Laser scans in ROS bags, and in clouds of points that lie in a plane."""

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from robot_perception.checks import flag, instance
from robot_perception.datasets import bags
from robot_perception.datasets.bag_motion import (
    MOTIONS,
    BagMotion,
    motion_in,
    motion_topics,
    moves_by_speeds,
)
from robot_perception.datasets.bag_transforms import Frames, frame_name
from robot_perception.datasets.bags import Bag, Meaning, Topics
from robot_perception.datasets.logs import CorruptLog, LaserLog, ReadReport
from robot_perception.datasets.tracks import Track
from robot_perception.geometry import se2, wrap_angle
from studies.files import reading

SCAN, ECHOES = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/MultiEchoLaserScan"
OLD_CLOUD = "sensor_msgs/msg/PointCloud"
CLOUDS = "sensor_msgs/msg/PointCloud2", OLD_CLOUD
SCANS = Meaning("scans", (SCAN, ECHOES, *CLOUDS))
LONGEST_GAP = 0.5  # s between two poses of the robot
ONE_CLOCK = 1.0  # s: delays that differ by more are told by two clocks, or one is very late
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
    delay
        Usual time from measuring to recording, as the clocks of both show it, s.
    report
        What became of all messages of the bag.
    """

    times: Float[np.ndarray, " scans"]
    ranges: Float[np.ndarray, "scans beams"]
    angles: Float[np.ndarray, " beams"]
    frame: str
    topic: str
    farthest: float
    delay: float
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
    do; 720 beams then take the nearest points in their direction. Of several echoes the first is
    taken.

    Parameters
    ----------
    path
        The bag, as `is_bag` describes it.
    topic
        Of ``LaserScan``, ``MultiEchoLaserScan``, ``PointCloud2`` or ``PointCloud``, or several of
        which one is; needed where several topics do. A cloud that is not flat does not.

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
        return _scans_in(bag, _scan_topic(bag, topic))


def read_bag_log(
    path: str | Path, topic: Topics = None, *, still: bool = False, way: Track | None = None
) -> LaserLog:
    """Read laser scans from a ROS bag with the poses that they were taken from.

    The poses are those of the robot, as `read_bag_motion` finds them, at the times of the scans,
    between two of them by straight lines, and of the scanner's place on the robot, where the bag
    tells it (``tf_static``, or a transform that never changes); a scanner that hangs upside down is
    turned. Scans at whose time there is no pose within half a second are skipped and counted.

    Where scans and poses were measured by two clocks, as of a scanner that counts from when it was
    switched on, both are put on the clock of the recording, and the remarks say so.

    Parameters
    ----------
    path
        The bag, as `is_bag` describes it.
    topic
        Of the scans, as `read_bag_scans` takes it; several may name that of the poses, too.
    still
        Whether a robot of which the bag tells neither poses nor speeds is taken to stand still; its
        scanner is the origin.
    way
        Poses of the robot from elsewhere, in place of those of the bag.

    Returns
    -------
    LaserLog
        Its report has remarks, if the scanner's place is unknown for one.

    Raises
    ------
    CorruptLog
        As of `read_bag_scans` and `read_bag_motion`; if there is no pose at the time of a scan, or
        the scanner is not level.
    FileNotFoundError
        If there is none.
    """
    topic, still = bags.check_topic(topic), flag("still", still)
    if way is not None:
        instance("way", way, Track)
    with bags.opened(path) as bag:
        frames, name = Frames(bag), _scan_topic(bag, topic)
        scans = _scans_in(bag, name)
        if way is not None:
            return _driven(bag, frames, scans, way, "way", frames.body(scans.frame))
        named = () if isinstance(topic, str) else topic
        found, told = motion_topics(bag, named, frames)
        if still and not found:
            return _standing(bag, scans)
        source = bag.only(MOTIONS, found, named=told)
        scans, motion = _on_one_clock(bag, frames, scans, motion_in(bag, source, frames))
        return _driven(bag, frames, scans, motion.track(), source, motion.body, motion.report)


def _scan_topic(bag: Bag, wanted: Topics) -> str:
    """Return the topic of the scans that are meant."""
    return bag.choose(SCANS, wanted, lambda topic: _is_flat(bag, topic))


def _remarked(scans: BagScans, remark: str) -> BagScans:
    remarks = (*scans.report.remarks, remark)
    return replace(scans, report=replace(scans.report, remarks=remarks))


def _standing(bag: Bag, scans: BagScans) -> LaserLog:
    """Return scans of a robot that stands still."""
    if speeds := moves_by_speeds(bag):
        raise CorruptLog(
            f"{bag.path}: no poses, but by {speeds} the robot moves; they must come from elsewhere"
            " (way=…, in people.py POSES)"
        )
    still = "the bag holds neither poses nor speeds: the robot is taken to stand still"
    return LaserLog(
        scans.ranges,
        scans.angles,
        np.zeros((len(scans.ranges), 3)),
        np.zeros((len(scans.ranges), 3)),
        scans.times,
        scans.farthest,
        _remarked(scans, still).report,
    )


def _on_one_clock(
    bag: Bag, frames: Frames, scans: BagScans, motion: BagMotion
) -> tuple[BagScans, BagMotion]:
    """Return scans and poses as they are, or on the clock of the recording if theirs are two.

    They are two if their times are apart, or one was recorded before it was measured.
    """
    if abs(scans.delay - motion.delay) <= ONE_CLOCK:
        return scans, motion
    both = scans, motion
    told = " and ".join(f"{one.topic} {bags.span(one.times)}" for one in both)
    if bags.gap(scans.times, motion.times) <= 0 and min(one.delay for one in both) > -ONE_CLOCK:
        late = " and ".join(f"{one.topic} {one.delay:.3f} s" for one in both)
        remark = (
            f"recorded after they were measured: {late}; if these are two clocks, poses are off"
        )
        return _remarked(scans, remark), motion
    scans = _scans_in(bag, scans.topic, recorded=True)
    motion = motion_in(bag, motion.topic, frames, recorded=True)
    if bags.gap(scans.times, motion.times) > 0:
        raise CorruptLog(f"{bag.path}: {told} have no time in common, nor when they were recorded")
    remark = f"two clocks, {told}: both were put on that of the recording"
    return _remarked(scans, remark), motion


def _driven(
    bag: Bag,
    frames: Frames,
    scans: BagScans,
    track: Track,
    source: str,
    body: str,
    also: ReadReport | None = None,
) -> LaserLog:
    """Return scans with the poses that they were taken from, and what else became of the bag."""
    T, remarks = frames.mount(body, scans.frame), [*scans.report.remarks]
    kept = dict(also.kept) if also else {}
    remarks += also.remarks if also else ()
    if T is None:
        T = np.eye(4)
        remarks.append(
            f"the bag does not say where {scans.frame!r} is on {body!r}: taken to be the same place"
        )
    ranges, angles, place = _levelled(bag.path, scans, T)
    robot, covered = track.at(scans.times, longest_gap=LONGEST_GAP)
    if not covered.any():
        raise CorruptLog(
            f"{bag.path}: no pose of {source} ({bags.span(track.times)}) at the time of a scan of"
            f" {scans.topic} ({bags.span(scans.times)})"
        )
    if lost := np.count_nonzero(~covered):
        remarks.append(f"{scans.topic}: {lost} scans skipped, no pose of {source} at their time")
    return LaserLog(
        ranges[covered],
        angles,
        se2.compose(robot[covered], place),
        robot[covered],
        scans.times[covered],
        scans.farthest,
        bag.report({scans.topic: int(covered.sum())} | kept, remarks),
    )


def _scans_in(bag: Bag, topic: str, *, recorded: bool = False) -> BagScans:
    """Read the scans of a topic of an open bag."""
    stamps, logged, contents = zip(*bag.messages(topic, SCANS.kinds), strict=True)
    told = bags.rising(bag.path, topic, stamps, logged, recorded=recorded)
    contents = [content for content, good in zip(contents, told.kept, strict=True) if good]
    names = sorted({frame_name(content.header.frame_id) for content in contents})
    if len(names) > 1:
        raise CorruptLog(f"{bag.path}: {topic} holds scans of several frames: {', '.join(names)}")
    found = [
        _read(f"{bag.path}: scan {number} of {topic}", content)
        for number, content in enumerate(contents, start=1)
    ]
    ranges, angles, good, more = _on_the_same_beams(topic, found)
    return BagScans(
        told.times[told.kept][good] / 1e9,
        ranges,
        angles,
        names[0],
        topic,
        max(
            (float(one.range_max) for one in contents if hasattr(one, "range_max")), default=np.inf
        ),
        told.delay / 1e9,
        bag.report({topic: int(good.sum())}, [*told.remarks, *more]),
    )


def _read(which: str, content: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the readings of a message and the directions of their beams, rising."""
    read = _of_cloud if content.__msgtype__ in CLOUDS else _of_scan
    return read(which, content)


def _is_flat(bag: Bag, topic: str) -> bool:
    """Tell whether the first message of a topic is a scan, or a cloud as flat as one."""
    content = bag.first(topic, SCANS)
    if content.__msgtype__ in CLOUDS:
        try:
            _of_cloud(topic, content)
        except CorruptLog:
            return False
    return True


def _of_scan(which: str, scan: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the readings of a scan and the directions of its beams, rising."""
    first, step = float(scan.angle_min), float(scan.angle_increment)
    nearest, farthest = float(scan.range_min), float(scan.range_max)
    readings = scan.ranges
    if scan.__msgtype__ == ECHOES:
        readings = [one.echoes[0] if len(one.echoes) else np.nan for one in readings]
    ranges = np.array(readings, dtype=float)
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
    if cloud.__msgtype__ == OLD_CLOUD:
        return np.array([[at.x, at.y, at.z] for at in cloud.points]).reshape(-1, 3)
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
