"""Relations files: hand-verified relative poses between scans."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from robot_perception.datasets import logs
from robot_perception.datasets.logs import ReadReport, Tally

COLUMNS = 8


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
            Times are equal when they are equal rounded to so many decimals.

        Returns
        -------
        relations : (matched,)
            Which relations have both scans.
        scans : (matched, 2)
            Which scans those are.
        """
        scale = 10.0**decimals
        ticks, first = np.unique(np.rint(times * scale), return_index=True)
        if not ticks.size:
            return np.empty(0, dtype=int), np.empty((0, 2), dtype=int)
        wanted = np.rint(self.times * scale)
        place = np.minimum(np.searchsorted(ticks, wanted), ticks.size - 1)
        found = (ticks[place] == wanted).all(axis=1)
        return np.flatnonzero(found), first[place[found]]


def read_relations(
    path: str | Path, *, strict: bool = False, allow_truncated: bool = False
) -> Relations:
    """Read a relations file, plain or gzip.

    A line is ``t1 t2 x y z roll pitch yaw``: the pose at t2 seen from the pose at t1. A line that
    cannot be read is left out, counted and reported (under the keyword ``relation``).

    Parameters
    ----------
    path
        The file.
    strict
        Raise at the first line that cannot be read.
    allow_truncated
        Accept a damaged gzip file and return the complete lines before the damage.

    Returns
    -------
    Relations
        The relations in the order of the file.

    Raises
    ------
    CorruptLog
        If the file is empty, damaged, not what its name says, or holds no relation; with
        ``strict``, at the first bad line.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    R. Kuemmerle, B. Steder, C. Dornhege, M. Ruhnke, G. Grisetti, C. Stachniss and A. Kleiner, "On
    measuring the accuracy of SLAM algorithms", Autonomous Robots 27, 2009,
    doi:10.1007/s10514-009-9155-6.
    """
    recording = logs.read_recording(path)
    tally = Tally(recording.path, strict)
    rows = []
    for number, tokens in logs.text_lines(recording, tally):
        row = _parse(tokens)
        if isinstance(row, str):
            tally.skip(number, row)
            continue
        tally.kept["relation"] += 1
        rows.append(row)
    report = logs.close(recording, tally, allow_truncated=allow_truncated, what="relation")
    table = np.array(rows)
    return Relations(table[:, :2], table[:, 2:], report)


def _parse(tokens: list[bytes]) -> Float[np.ndarray, "8"] | str:
    """Return the values of a line, or the reason why it is no relation."""
    problem = logs.wrong_length(tokens, COLUMNS)
    if problem:
        return problem
    row = logs.numbers(tokens)
    if row is None:
        return logs.NOT_NUMBERS
    return row if np.isfinite(row).all() else logs.NOT_FINITE
