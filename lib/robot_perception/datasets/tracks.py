"""Trajectories: poses with times, read from the formats in which a filter's run is written."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception.checks import array, check_covariance, number
from robot_perception.datasets import limits
from robot_perception.datasets.bags import Topics, check_topic, is_bag
from robot_perception.datasets.limits import Check
from robot_perception.datasets.logs import LONG, CorruptLog, Lines, ReadReport
from robot_perception.datasets.poses import POSE, headings, layout, read_poses
from robot_perception.datasets.tables import Rows, read_rows
from robot_perception.fields import checked
from robot_perception.geometry import wrap_angle

LARGEST = {"time_s": np.inf, "x_m": limits.FARTHEST, "y_m": limits.FARTHEST, "heading_rad": np.inf}
LEVEL = 1.0  # m: no robot in the plane that hardly moves has heights that differ by so much
COVARIANCE = ("cov_xx", "cov_xy", "cov_xh", "cov_yy", "cov_yh", "cov_hh")


def _some(name: str, poses: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "k 3"]:
    """Return poses, one at least."""
    if not len(poses):
        raise ValueError(f"{name} must be one at least, got none")
    return poses


@dataclass(frozen=True, eq=False, slots=True)
class Track:
    """Poses of a robot, estimated or by motion capture.

    Parameters
    ----------
    times : (k,)
        s, never falling.
    poses : (k, 3)
        x, y in m and heading in rad; one at least.
    covs : (k, 3, 3), optional
        Their covariances.
    report
        What became of all lines, or of the messages of a ROS bag, if that is known.

    Raises
    ------
    ValueError
        If there is no pose, or the times fall.
    """

    times: Annotated[Float[np.ndarray, " k"], limits.in_order]
    poses: Annotated[Float[np.ndarray, "k 3"], _some]
    covs: Float[np.ndarray, "k 3 3"] | None = None
    report: ReadReport | None = None
    __post_init__ = checked

    def at(
        self, times: Float[np.ndarray, " m"], *, longest_gap: float
    ) -> tuple[Float[np.ndarray, "m 3"], Bool[np.ndarray, " m"]]:
        """Return the poses at given times, positions by straight lines, headings by the short way.

        Parameters
        ----------
        times : (m,)
            s, in any order.
        longest_gap
            A gap between two poses that is longer than this, in s, is not bridged.

        Returns
        -------
        poses : (m, 3)
            NaN where not covered: nothing is extrapolated.
        covered : (m,)
            Whether a time lies on the track and in no longer gap.

        Raises
        ------
        ValueError
            If a time is not finite or the gap is not positive.
        """
        before, after, share, covered = neighbours(self.times, times, longest_gap)
        step = self.poses[after] - self.poses[before]
        step[:, 2] = wrap_angle(step[:, 2])
        poses = self.poses[before] + share[:, None] * step
        poses[:, 2] = wrap_angle(poses[:, 2])
        poses[~covered] = np.nan
        return poses, covered


def neighbours(
    own: Float[np.ndarray, " k"], times: Float[np.ndarray, " m"], longest_gap: float
) -> tuple[
    Int[np.ndarray, " m"], Int[np.ndarray, " m"], Float[np.ndarray, " m"], Bool[np.ndarray, " m"]
]:
    """Return between which poses of a track times lie, how far along, and whether it covers them.

    Parameters
    ----------
    own : (k,)
        Times of the track, s, rising.
    times : (m,)
        s, in any order.
    longest_gap
        A gap between two poses that is longer than this, in s, is not bridged.

    Returns
    -------
    before, after : (m,)
        Numbers of the poses.
    share : (m,)
        0 at the one before, 1 at the one after.
    covered : (m,)
        Whether a time lies on the track and in no longer gap.

    Raises
    ------
    ValueError
        If a time is not finite or the gap is not positive.
    """
    times = array("times", times, ("m",))
    if not number("longest_gap", longest_gap, finite=False) > 0:
        raise ValueError(f"longest_gap must be positive, got {longest_gap}")
    after = np.minimum(np.maximum(np.searchsorted(own, times), 1), len(own) - 1)
    before = np.maximum(after - 1, 0)  # of a track of one pose, that pose
    gap = own[after] - own[before]
    exact = (times == own[before]) | (times == own[after])
    between = (times > own[before]) & (times < own[after])
    share = np.divide(times - own[before], gap, out=np.zeros_like(times), where=gap > 0)
    return before, after, share, exact | (between & (gap <= longest_gap))


def read_track(path: str | Path, *, time_unit: str = "s", topic: Topics = None) -> Track:
    """Read a trajectory from a text file, plain or gzip, or from a ROS bag.

    CSV has columns ``time_s, x_m, y_m, heading_rad`` and may have the covariances ``cov_xx, cov_xy,
    cov_xh, cov_yy, cov_yh, cov_hh``, as `History.to_csv` of the planar filter writes them; other
    columns are left out. Of poses in space, as `read_space_track` finds them by the names of
    columns or as TUM and EuRoC write them, the plane takes the position and the heading: height,
    roll and pitch are left out, as of a bag, which `read_bag_motion` reads.

    Parameters
    ----------
    path
        The file.
    time_unit
        What it counts time in: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``. Bags tell.
    topic
        Of a bag, where several would do.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, lacks a column, the covariances are none, or times are in
        another unit; at the first line that cannot be read, does not come after the one before, has
        a place or a heading in another unit, or a quaternion that is not of unit length or turns
        the robot onto its side. If the places of a TUM file reach farther in z than in x and y, as
        a camera's do whose z is ahead.
    FileNotFoundError
        If there is no such file.
    """
    limits.per_second(time_unit)
    topic = check_topic(topic)
    if is_bag(path):
        from robot_perception.datasets.bag_motion import read_bag_motion  # which makes tracks

        return read_bag_motion(path, topic).track()
    found = layout(path)
    if found.kind == "KITTI":
        lines = Lines(path)
        told = ": 12 are a pose of KITTI, in space; read_space_track reads it"
        raise lines.error(LONG + told * (len(next(lines.rows())) == 12))
    if found.kind != "plane":
        times, places, turns, report = read_poses(path, found, time_unit, (UPRIGHT,))
        _check_level(report.path, places)
        poses = np.column_stack([places[:, :2], headings(turns)])
        return Track(times, poses, report=report)
    largest = LARGEST | dict.fromkeys(COVARIANCE, np.inf)
    rows = read_rows(path, largest, optional=COVARIANCE, time_unit=time_unit)
    rows.check_order("time_s", "times", rising=True)
    poses = np.column_stack([rows.columns[name] for name in POSE[1:]])
    for reason, is_bad in limits.no_headings(2):
        rows.check(is_bad(poses), partial(_of_heading, poses, reason))
    return Track(rows.columns["time_s"], poses, _covariances(rows))


def _of_heading(poses: Float[np.ndarray, "k 3"], reason: str, row: int) -> str:
    return f"heading_rad is {poses[row, 2]:g}, {reason}"


def _check_level(path: Path, places: Float[np.ndarray, "k 3"]) -> None:
    """Raise ``CorruptLog`` if a path is no drive in the plane, but rises more than it goes."""
    x, y, z = np.ptp(places, axis=0)
    if z > max(x, y, LEVEL):
        raise CorruptLog(
            f"{path}: its places reach {z:.3f} m in z, farther than in x and y, as a camera's do"
            " whose z is ahead; read_space_track keeps all three"
        )


def _covariances(rows: Rows) -> Float[np.ndarray, "k 3 3"] | None:
    missing = [name for name in COVARIANCE if name not in rows.columns]
    if len(missing) == len(COVARIANCE):
        return None
    if missing:
        raise CorruptLog(f"{rows.path}: some covariances are there, but no column {missing[0]}")
    covs = np.empty((len(rows.numbers), 3, 3))
    for name, i, j in zip(COVARIANCE, *np.triu_indices(3), strict=True):
        covs[:, i, j] = covs[:, j, i] = rows.columns[name]
    if fault := _fault(covs):
        first = next(k for k, cov in enumerate(covs) if _fault(cov))
        raise CorruptLog(f"{rows.path}, line {rows.numbers[first]}: {fault}")
    return covs


def _fault(covs: Float[np.ndarray, "... 3 3"]) -> str:
    """Return why matrices are no covariances; nothing if they are."""
    try:
        check_covariance("covariances", covs)
    except ValueError as error:
        return str(error)
    return ""


UPRIGHT: Check = (
    "its quaternion qx qy qz qw turns the robot onto its side",
    lambda rows: np.hypot(rows[:, 4], rows[:, 5]) > np.sqrt(0.5),
)
