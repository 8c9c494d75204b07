"""Trajectories in space: poses of a camera or a robot, read from the formats of benchmarks.

SciPy's rotations are imported where poses are made: the other readers do without them.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks
from robot_perception.datasets import limits
from robot_perception.datasets.bag_motion import read_bag_motion
from robot_perception.datasets.bags import Topics, check_topic, is_bag
from robot_perception.datasets.limits import Check
from robot_perception.datasets.logs import ReadReport, read_table
from robot_perception.datasets.poses import are_no_rotations, layout, order, read_poses
from robot_perception.datasets.tracks import neighbours, read_track
from robot_perception.fields import checked

ROTATION: Check = ("its matrix of 3 × 3 is no rotation", are_no_rotations)


def _rising(name: str, times: Float[np.ndarray, " k"]) -> Float[np.ndarray, " k"]:
    """Return times that each lie after the one before."""
    if (np.diff(times) <= 0).any():
        raise ValueError(f"{name} must rise, got one that does not lie after the one before")
    return times


def _motions(name: str, poses: Float[np.ndarray, "k 4 4"]) -> Float[np.ndarray, "k 4 4"]:
    """Return rigid motions."""
    from robot_perception.geometry import se3

    return se3.checked(name, poses)


@dataclass(frozen=True, eq=False, slots=True)
class SpaceTrack:
    """Poses in space, estimated or by motion capture.

    Parameters
    ----------
    times : (k,)
        s, rising; nothing where the file has none.
    poses : (k, 4, 4)
        Rigid motions ``T_world_body``, m.
    report
        What became of all lines, or of the messages of a ROS bag, if that is known.

    Raises
    ------
    ValueError
        If a pose is no rigid motion.
    """

    times: Annotated[Float[np.ndarray, " k"], _rising] | None
    poses: Annotated[Float[np.ndarray, "k 4 4"], _motions]
    report: ReadReport | None = None
    __post_init__ = checked

    def __len__(self) -> int:
        return len(self.poses)

    def at(
        self, times: Float[np.ndarray, " m"], *, longest_gap: float
    ) -> tuple[Float[np.ndarray, "m 4 4"], Bool[np.ndarray, " m"]]:
        r"""Return the poses at given times.

        .. math::
            p = (1 - s)\, p_1 + s\, p_2, \qquad R = R_1 \exp\left(s \log(R_1^\top R_2)\right)

        Parameters
        ----------
        times : (m,)
            s, in any order.
        longest_gap
            A gap between two poses that is longer than this, in s, is not bridged.

        Returns
        -------
        poses : (m, 4, 4)
            NaN where not covered: nothing is extrapolated.
        covered : (m,)
            Whether a time lies on the track and in no longer gap.

        Raises
        ------
        ValueError
            If a time is not finite, the gap is not positive, or the track has no times.
        """
        from robot_perception.geometry import se3

        times = checks.array("times", times, ("m",))
        if self.times is None or not len(self):
            raise ValueError("times can be asked of a track with poses and times, got one without")
        before, after, share, covered = neighbours(self.times, times, longest_gap)
        first, last = self.poses[before], self.poses[after]
        turn = np.zeros((len(times), 6))
        turn[:, 3:] = share[:, None] * se3.log(se3.between(first, last))[:, 3:]
        poses = se3.compose(first, se3.exp(turn))
        poses[:, :3, 3] += share[:, None] * (last - first)[:, :3, 3]
        poses[~covered] = np.nan
        return poses, covered


def track_format(path: str | Path, *, topic: Topics = None) -> str:
    """Return the format of a trajectory, told by the names of its columns or else its first row.

    Parameters
    ----------
    path
        The file.
    topic
        Of a ROS bag, where several would do.

    Returns
    -------
    str
        ``"plane"`` where there are ``time_s`` and ``heading_rad``, ``"EuRoC"`` or ``"TUM"`` by
        their names or words like these, ``"space"`` where others name a time, a position and a
        quaternion. Without names ``"KITTI"`` (12 numbers a line), ``"TUM"`` (8, in any unit of
        time) or ``"EuRoC"`` (8 and what may follow between commas, times in whole nanoseconds).
        Files with other names are ``"plane"``, which `read_track` reads. A bag is ``"plane"`` if
        its poses have no heights and no tilts, else ``"space"``.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, or names some columns of a pose in space only.
    FileNotFoundError
        If there is no such file.
    """
    topic = check_topic(topic)
    if is_bag(path):
        return "plane" if read_bag_motion(path, topic).is_flat() else "space"
    return layout(path).kind


def read_space_track(path: str | Path, *, time_unit: str = "s", topic: Topics = None) -> SpaceTrack:
    """Read a trajectory in space, plain or gzip or from a ROS bag; `track_format` tells its format.

    * Columns by their names: ``time_s, x_m, y_m, z_m, qx, qy, qz, qw``, those of EuRoC or TUM, or
      words like these, in any order; others are left out.
    * Without names, which the report says: TUM, ``timestamp tx ty tz qx qy qz qw``, m; EuRoC,
      ``timestamp, x, y, z, qw, qx, qy, qz`` and what may follow, the times in whole nanoseconds;
      KITTI, a matrix of 3 × 4 by rows, m, without times.
    * CSV as `read_track` reads it lies in the plane z = 0.

    Quaternions and matrices may be rounded, to one decimal at least: they are made rotations.

    Parameters
    ----------
    path
        The file.
    time_unit
        What it counts time in, where neither names nor format tell: ``"s"``, ``"ms"``, ``"us"`` or
        ``"ns"``. Bags tell.
    topic
        Of a bag, where several would do.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, lacks a column, or times are in another unit; at the first
        line that cannot be read, does not come after the one before, holds no rotation, or a place
        in another unit.
    FileNotFoundError
        If there is no such file.
    """
    limits.per_second(time_unit)
    topic = check_topic(topic)
    if is_bag(path):
        motion = read_bag_motion(path, topic)
        return SpaceTrack(motion.times, motion.poses, motion.report)
    found = layout(path)
    if found.kind == "plane":
        return _read_plane(path, time_unit)
    if found.kind == "KITTI":
        return read_matrices(path)
    times, places, turns, report = read_poses(path, found, time_unit)
    return SpaceTrack(times, _poses(places, turns), report)


def read_matrices(path: str | Path) -> SpaceTrack:
    """Read poses as KITTI has them: a matrix of 3 × 4 by rows in each line, without times."""
    from scipy.spatial.transform import Rotation

    rows, report = read_table(path, "pose", 12, (ROTATION, limits.far_places(3, 7, 11)))
    matrices = rows.reshape(-1, 3, 4)
    nearest = Rotation.from_matrix(matrices[:, :, :3]).as_quat()
    remark = f"{report.path.name}: no names of columns: read as {order('KITTI')}"
    return SpaceTrack(None, _poses(matrices[:, :, 3], nearest), replace(report, remarks=(remark,)))


def _read_plane(path: str | Path, time_unit: str) -> SpaceTrack:
    from robot_perception.geometry import se3

    track = read_track(path, time_unit=time_unit)
    return SpaceTrack(track.times, se3.from_se2(track.poses))


def _poses(
    positions: Float[np.ndarray, "k 3"], quaternions: Float[np.ndarray, "k 4"]
) -> Float[np.ndarray, "k 4 4"]:
    """Return rigid motions of positions and quaternions x, y, z, w."""
    from scipy.spatial.transform import Rotation

    poses = np.zeros((len(positions), 4, 4))
    poses[:, :3, :3] = Rotation.from_quat(quaternions).as_matrix()
    poses[:, :3, 3], poses[:, 3, 3] = positions, 1
    return poses
