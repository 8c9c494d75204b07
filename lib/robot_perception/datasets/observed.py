"""Observations in tables of one's own: landmarks, and people."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception.checks import instance, instances
from robot_perception.datasets.logs import CorruptLog, ReadReport
from robot_perception.datasets.tables import Rows, read_rows

DETECTION = {  # the columns, and the largest numbers in them
    "time_s": np.inf,
    "distance_m": 200,
    "direction_rad": 7,
    "distance_sigma_m": 20,
    "direction_sigma_rad": 7,
}


@dataclass(frozen=True, eq=False, slots=True)
class LandmarkTable:
    """Observations of landmarks in the order of their times.

    Parameters
    ----------
    times : (m,)
        s, never falling.
    landmarks : (m,)
        Which landmark each is of; -1 where nobody knows.
    values : (m, d)
        What was measured, a column each.
    report
        What became of every line.
    """

    times: Float[np.ndarray, " m"]
    landmarks: Int[np.ndarray, " m"]
    values: Float[np.ndarray, "m d"]
    report: ReadReport


@dataclass(frozen=True, eq=False, slots=True)
class DetectionTable:
    """Detections of people, in the order of the file.

    Parameters
    ----------
    times : (m,)
        s.
    sensors : (m,)
        Their names.
    values : (m, 4)
        Distance, m, direction, rad, and their standard deviations.
    seen : (m,)
        Whether somebody was seen; otherwise the sensor looked and saw nobody.
    report
        What became of every line.
    """

    times: Float[np.ndarray, " m"]
    sensors: np.ndarray
    values: Float[np.ndarray, "m 4"]
    seen: Bool[np.ndarray, " m"]
    report: ReadReport


def read_landmarks(
    path: str | Path, measured: Mapping[str, float], *, time_unit: str = "s"
) -> LandmarkTable:
    """Read observations of landmarks from CSV, plain or gzip, and bring them into order.

    Parameters
    ----------
    path
        CSV with the columns ``time_s`` and those of ``measured``, and perhaps ``landmark``, a whole
        number, -1 for one that nobody knows. Rows may be in any order.
    measured : name -> largest magnitude
        What was measured, such as ``range_m``, which must be positive, and ``bearing_rad``.
    time_unit
        What the file counts time in: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``.

    Raises
    ------
    CorruptLog
        As `read_columns`; also at the first line that has no range, or names a landmark that was
        seen already at its time.
    FileNotFoundError
        If there is no such file.
    """
    limits, name = dict(instance("measured", measured, Mapping)), ["landmark"]
    limits |= {"time_s": np.inf, "landmark": 1e9}
    rows = read_rows(path, limits, optional=name, integers=name, time_unit=time_unit)
    times = rows.columns["time_s"]
    landmarks = rows.columns.get("landmark", np.full(len(times), -1))
    rows.check(landmarks < -1, lambda k: f"landmark must be at least -1, got {landmarks[k]}")
    if "range_m" in measured:
        rows.check_positive("range_m")
    first = {}
    for row, key in enumerate(zip(times.tolist(), landmarks.tolist(), strict=True)):
        if key[1] != -1 and key in first:
            before = f"at {key[0]:.15g} s it was seen already, in line {rows.numbers[first[key]]}"
            raise CorruptLog(f"{rows.path}, line {rows.numbers[row]}: landmark {key[1]}: {before}")
        first[key] = row
    order, values = np.argsort(times, kind="stable"), [rows.columns[one] for one in measured]
    report = _report(rows, "observation", bool((np.diff(times) < 0).any()))
    return LandmarkTable(times[order], landmarks[order], np.column_stack(values)[order], report)


def read_detections(
    path: str | Path, sensors: Collection[str] | None = None, *, time_unit: str = "s"
) -> DetectionTable:
    """Read where sensors saw people from CSV, plain or gzip.

    Parameters
    ----------
    path
        CSV with the columns ``time_s, sensor, distance_m, direction_rad, distance_sigma_m,
        direction_sigma_rad``; a negative distance says that the sensor looked and saw nobody.
    sensors
        Which sensors there may be; if left out, any.
    time_unit
        What the file counts time in: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``.

    Raises
    ------
    CorruptLog
        As `read_columns`; also at the first line whose standard deviations are not positive, or
        whose sensor is another.
    FileNotFoundError
        If there is no such file.
    """
    rows = read_rows(path, DETECTION, texts=["sensor"], time_unit=time_unit)
    times, *values = (rows.columns[name] for name in DETECTION)
    names = rows.columns["sensor"]
    if sensors is not None:
        known = instances("sensors", sensors, str)
        told = f"none of the sensors {', '.join(known)}"
        rows.check(~np.isin(names, known), lambda k: f"sensor is {str(names[k])!r}, {told}")
    seen = values[0] >= 0
    for name in ("distance_sigma_m", "direction_sigma_rad"):
        rows.check_positive(name, seen)
    report = _report(rows, "detection", False)
    return DetectionTable(times, names, np.column_stack(values), seen, report)


def _report(rows: Rows, what: str, sorted_anew: bool) -> ReadReport:
    remark = f"{rows.path.name}: rows were brought into the order of their times"
    remarks = (remark,) if sorted_anew else ()
    return ReadReport(rows.path, {what: len(rows.numbers)}, {}, "rows", remarks)
