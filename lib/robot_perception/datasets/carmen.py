"""CARMEN logs: one ``FLASER`` line per laser scan."""

from pathlib import Path

import numpy as np

from robot_perception.datasets import logs
from robot_perception.datasets.logs import LaserLog, Lines

TAIL = 9  # lx ly ltheta ox oy otheta t host t


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
    pose, robot pose by odometry. Lines of other kinds are counted.

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
    lines = Lines(path)
    readings, tails = [], []
    angles = np.empty(0)
    for words in lines.of(b"FLASER"):
        beams = lines.integer(words, 1, least=1)
        if not readings:
            known = logs.beam_angles(beams, field_of_view)
            if known is None:
                raise lines.error(f"no field of view is known for {beams} beams: give one")
            angles = known
        if beams != angles.size:
            raise lines.error(logs.OTHER_BEAMS)
        lines.expect(words, 2 + beams + TAIL)
        readings.append(lines.readings(words[2 : 2 + beams]))
        tail = lines.numbers(words[2 + beams : -2])  # without host and the logger's own clock
        tails.append((lines.number, tail))
    how = {"max_range": max_range, "timed": timed, "time_unit": time_unit}
    return LaserLog(**logs.make_laser_log(lines, readings, angles, tails, **how))
