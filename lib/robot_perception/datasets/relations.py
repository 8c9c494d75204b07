"""Relations files: hand-verified relative poses between scans."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from robot_perception.checks import array, whole
from robot_perception.datasets import limits
from robot_perception.datasets.logs import ReadReport, in_seconds, read_table


@dataclass(frozen=True, eq=False, slots=True)
class Relations:
    """Relative poses between the robot's (not the laser's) poses at pairs of times.

    Parameters
    ----------
    times : (relations, 2)
        Time stamps in s: of the reference, and of the pose seen from it.
    motions : (relations, 6)
        x, y, z in m and roll, pitch, yaw in rad of the second pose in the first one's frame.
    report
        What became of every line of the file.
    """

    times: Float[np.ndarray, "relations 2"]
    motions: Float[np.ndarray, "relations 6"]
    report: ReadReport

    @property
    def planar(self) -> Float[np.ndarray, "relations 3"]:
        """The motions' x, y (m) and yaw (rad)."""
        return self.motions[:, [0, 1, 5]]

    def match(
        self, times: Float[np.ndarray, " scans"], *, decimals: int = 3
    ) -> tuple[Int[np.ndarray, " matched"], Int[np.ndarray, "matched 2"]]:
        """Find the relations whose two times are both times of scans.

        Parameters
        ----------
        times : (scans,)
            Time stamps of the scans in s, in any order; of equal ones the first is taken.
        decimals
            Times are equal when they are equal rounded to so many decimals, at most 15.

        Returns
        -------
        relations : (matched,)
            Which relations have both scans.
        scans : (matched, 2)
            Which scans those are.
        """
        times = array("times", times, ("scans",))
        scale = 10.0 ** whole("decimals", decimals, 0, 15)
        ticks, first = np.unique(np.rint(times * scale), return_index=True)
        if not ticks.size:
            return np.empty(0, dtype=int), np.empty((0, 2), dtype=int)
        wanted = np.rint(self.times * scale)
        place = np.minimum(np.searchsorted(ticks, wanted), ticks.size - 1)
        found = (ticks[place] == wanted).all(axis=1)
        return np.flatnonzero(found), first[place[found]]


def read_relations(path: str | Path, *, time_unit: str = "s") -> Relations:
    """Read a relations file, plain or gzip.

    A line is ``t1 t2 x y z roll pitch yaw``: the pose at t2 seen from the pose at t1.

    Parameters
    ----------
    path
        The file.
    time_unit
        What it counts time in: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``.

    Returns
    -------
    Relations
        The relations in the order of the file.

    Raises
    ------
    CorruptLog
        If the file is empty, damaged, not what its name says, or holds no relation; at the first
        line that cannot be read, or whose numbers are in another unit.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    R. Kuemmerle, B. Steder, C. Dornhege, M. Ruhnke, G. Grisetti, C. Stachniss and A. Kleiner, "On
    measuring the accuracy of SLAM algorithms", Autonomous Robots 27, 2009,
    doi:10.1007/s10514-009-9155-6.
    """
    limits.per_second(time_unit)
    checks = limits.far_places(2, 3, 4), limits.wide_angles(5, 6, 7)
    table, report = read_table(path, "relation", 8, checks)
    times = in_seconds(report.path, table[:, :2], time_unit)
    return Relations(times, table[:, 2:], report)
