"""CARMEN logs: one ``FLASER`` line per laser scan."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from robot_perception.datasets import logs
from robot_perception.datasets.logs import LaserLog, Tally

KEYWORD = b"FLASER"
POSE_VALUES = 6  # lx ly lth ox oy oth
TAIL = POSE_VALUES + 3  # ... t host t


@dataclass(frozen=True, eq=False, slots=True)
class _Scan:
    readings: Float[np.ndarray, " beams"]
    pose: Float[np.ndarray, "6"]
    time: float


def read_carmen_log(
    path: str | Path,
    *,
    max_range: float | None = None,
    field_of_view: tuple[float, float] | None = None,
    strict: bool = False,
    allow_truncated: bool = False,
) -> LaserLog:
    """Read the laser scans of a CARMEN log, plain or gzip.

    A scan is the line ``FLASER n r1 … rn lx ly ltheta ox oy otheta t host t``: readings, laser
    pose, robot pose by odometry. A line that cannot be read is left out, counted and reported.

    Parameters
    ----------
    path
        The file.
    max_range
        Readings of at least this many metres mean "no return" and become ``inf``. Without it the
        largest reading of the log decides (see `logs.no_return_threshold`): 80 m for SICK logs in
        centimetres (Intel, Freiburg, SENA), 50 m for logs that end at 50 to 52 m (ACES, FHW,
        Acapulco), 32.759 m for SICK logs in millimetres (Orebro).
    field_of_view
        Directions of the first and last beam in rad. Without it, scans must have 180, 181, 360 or
        361 beams, whose directions are conventional (see `logs.beam_angles`).
    strict
        Raise at the first line that cannot be read.
    allow_truncated
        Accept a damaged gzip file and return the complete scans before the damage. Its checksum
        cannot be verified.

    Returns
    -------
    LaserLog
        The scans in the order of the file.

    Raises
    ------
    CorruptLog
        If the file is empty, damaged, not what its name says, or holds no scan; with ``strict``,
        at the first bad line.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    Carnegie Mellon Robot Navigation Toolkit (CARMEN), log file format of the logger module.
    """
    recording = logs.read_recording(path)
    tally = Tally(recording.path, strict)
    scans: list[_Scan] = []
    angles = None
    for number, tokens in logs.keyword_lines(recording, tally, frozenset({KEYWORD})):
        scan = _parse(tokens)
        if isinstance(scan, str):
            tally.skip(number, scan)
            continue
        beams = scan.readings.size
        if angles is None:
            angles = logs.beam_angles(beams, field_of_view)
            if angles is None:
                tally.skip(number, logs.UNKNOWN_FIELD)
                continue
        if beams != angles.size:
            tally.skip(number, logs.OTHER_BEAMS)
            continue
        tally.kept["FLASER"] += 1
        scans.append(scan)
    report = logs.close(recording, tally, allow_truncated=allow_truncated, what="FLASER")
    ranges, max_range = logs.mark_no_returns(np.array([scan.readings for scan in scans]), max_range)
    poses = np.array([scan.pose for scan in scans])
    times = np.array([scan.time for scan in scans])
    return LaserLog(ranges, angles, poses[:, :3], poses[:, 3:], times, max_range, report)


def _parse(tokens: list[bytes]) -> _Scan | str:
    """Return the scan, or the reason why the line is none."""
    beams = logs.positive_integer(tokens[1:2])
    if beams is None:
        return logs.BAD_COUNT
    problem = logs.wrong_length(tokens, 2 + beams + TAIL)
    if problem:
        return problem
    values = logs.numbers(tokens[2:-2])  # without host and the logger's own clock
    if values is None:
        return logs.NOT_NUMBERS
    if logs.bad_readings(values[:beams]):
        return logs.BAD_READING
    if not np.isfinite(values).all():
        return logs.NOT_FINITE
    return _Scan(values[:beams], values[beams:-1], float(values[-1]))
