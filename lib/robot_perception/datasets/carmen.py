"""CARMEN logs: a line ``FLASER``, or ``ROBOTLASER1`` since 2007, for each laser scan."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from robot_perception.datasets import limits, logs
from robot_perception.datasets.logs import LaserLog, Lines

PLAIN, SCAN = b"FLASER", b"ROBOTLASER1"
TAIL = 9  # of FLASER: lx ly ltheta ox oy otheta t host t
HEADER = 9  # of ROBOTLASER1: keyword type start fov resolution maxrange accuracy mode n
LONG_TAIL = 14  # lx ly ltheta x y theta tv rv fs ss ta t host t


class RobotScan(NamedTuple):
    """A line ``ROBOTLASER1``.

    Parameters
    ----------
    field
        First angle and resolution, rad.
    readings : (beams,)
        m.
    tail
        The number of the line, and lx ly ltheta x y theta tv rv fs ss ta t.
    """

    field: tuple[float, float]
    readings: Float[np.ndarray, " beams"]
    tail: tuple[int, Float[np.ndarray, "12"]]


def read_carmen_log(
    path: str | Path,
    *,
    max_range: float | None = None,
    field_of_view: tuple[float, float] | None = None,
    timed: bool = True,
    time_unit: str = "s",
) -> LaserLog:
    """Read the laser scans of a CARMEN log, plain or gzip.

    A scan is the line ``FLASER n r1 … rn lx ly ltheta ox oy otheta t host t``: readings, laser
    pose, robot pose by odometry. In a log without such lines it is ``ROBOTLASER1 type start fov
    resolution maxrange accuracy mode n r1 … rn m [m values] lx ly ltheta x y theta tv rv fs ss ta t
    host t``, which tells where its beams point. Lines of other kinds are counted.

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
        Directions of the first and last beam in rad. Without it, scans of ``FLASER`` must have 180,
        181, 360 or 361 beams, whose directions are conventional (see `logs.beam_angles`).
    timed
        Whether the times of the scans must differ and be those of a recording. The Orebro log, for
        one, has no times: all are 0.
    time_unit
        What the file counts time in: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``.

    Returns
    -------
    LaserLog
        The scans in the order of the file.

    Raises
    ------
    CorruptLog
        If the file is empty, damaged, not what its name says, or holds no scan; at the first line
        that cannot be read, or whose numbers are in another unit.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    Carnegie Mellon Robot Navigation Toolkit (CARMEN), log file format of the logger module.
    """
    logs.check_reading(max_range, timed, time_unit)
    how = {"max_range": max_range, "timed": timed, "time_unit": time_unit}
    lines = Lines(path)
    readings, tails, others = [], [], []
    angles = np.empty(0)
    for words in lines.of(PLAIN, SCAN, needed=2):
        if words[0] == SCAN:
            others.append((lines.number, words))
            continue
        beams = lines.integer(words, 1, least=1)
        if not readings:
            known = logs.beam_angles(beams, field_of_view)
            if known is None:
                raise lines.error(f"no field of view is known for {beams} beams: {FIELD}")
            angles = known
        if beams != angles.size:
            raise lines.error(logs.OTHER_BEAMS)
        lines.expect(words, 2 + beams + TAIL)
        readings.append(lines.readings(words[2 : 2 + beams]))
        tail = lines.numbers(words[2 + beams : -2])  # without host and the logger's own clock
        tails.append((lines.number, tail))
    if readings:
        lines.pass_over(SCAN)
        return LaserLog(**logs.make_laser_log(lines, readings, angles, tails, **how))
    scans: list[RobotScan] = []
    for lines.number, words in others:
        scans.append(robot_scan(lines, words, scans[:1]))
    fields = laser_fields(lines, scans, **how)
    if field_of_view is not None:
        fields["angles"] = logs.beam_angles(scans[0].readings.size, field_of_view)
    return LaserLog(**fields)


FIELD = "field_of_view=(first, last), rad, tells it, in a script --field first,last in degrees"


def robot_scan(lines: Lines, words: list[bytes], first: list[RobotScan]) -> RobotScan:
    """Return the scan of a line ``ROBOTLASER1``, if its beams are those of the first scan."""
    end = HEADER + lines.integer(words, HEADER - 1, least=1)
    lines.expect(words, end + 1 + lines.integer(words, end) + LONG_TAIL)
    head = lines.numbers(words[1:HEADER])
    lines.check(head[None], [lines.number], limits.wide_angles(1, 3))
    tail = lines.numbers(words[end:-2])[2 - LONG_TAIL :]  # without host and the logger's own clock
    field = float(head[1]), float(head[3])
    scan = RobotScan(field, lines.readings(words[HEADER:end]), (lines.number, tail))
    for one in first:
        if scan.readings.size != one.readings.size:
            raise lines.error(logs.OTHER_BEAMS)
        if scan.field != one.field:
            raise lines.error("its first angle or resolution differs from the first scan's")
    return scan


def laser_fields(lines: Lines, scans: list[RobotScan], **how: Any) -> dict[str, Any]:
    """Return the fields of a `LaserLog` of such scans."""
    start, resolution = scans[0].field
    readings, tails = [scan.readings for scan in scans], [scan.tail for scan in scans]
    angles = start + resolution * np.arange(readings[0].size)
    return logs.make_laser_log(lines, readings, angles, tails, **how)
