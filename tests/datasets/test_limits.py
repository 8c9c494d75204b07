"""Numbers in other units are refused by all readers, with the unit that they look like."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import savemat

from robot_perception import datasets
from robot_perception.datasets import CorruptLog, limits
from robot_perception.datasets.logs import OtherUnit
from tests.datasets.formats.arrays import PLAIN
from tests.datasets.formats.mrclam import files as mrclam_files
from tests.datasets.formats.stereo import FORMATS
from tests.datasets.writing import flaser, robotlaser, vertex, write


def times_of(found):
    return found.times


@dataclass(frozen=True)
class Reader:
    """A reader of what a robot logs that was somewhere at some times.

    Parameters
    ----------
    read
        Reads it.
    put
        Writes times, as the file counts them, and poses (k, 3) to a folder; returns what to read.
    times
        The times of what was read, s; nothing if it reads none.
    """

    read: Callable[..., Any]
    put: Callable[[Path, list[float], list[list[float]]], Path]
    times: Callable[[Any], np.ndarray] | None = times_of


def rows(line, *head):
    """Write a line for each time and pose."""

    def put(folder, times, poses):
        made = [line(time, *pose) for time, pose in zip(times, poses, strict=True)]
        return write(folder / "a.csv", [text.encode() for text in (*head, *made)])

    return put


def carmen(folder, times, poses):
    made = [flaser([1.0] * 180, pose, pose, time) for time, pose in zip(times, poses, strict=True)]
    return write(folder / "a.log", made)


def graph(folder, times, poses):
    both = enumerate(zip(times, poses, strict=True))
    made = [(vertex(k, p), robotlaser([1.0, 2.0], p, p, t)) for k, (t, p) in both]
    return write(folder / "a.log", [line for pair in made for line in pair])


def mrclam(folder, times, poses):
    both = list(zip(times, poses, strict=True))
    files = mrclam_files(
        Odometry=[f"{time!r} 0.5 0.1".encode() for time in times],
        Measurement=[f"{time!r} 63 2.0 0.5".encode() for time in times],
        Groundtruth=[f"{time!r} {x!r} {y!r} {turn!r}".encode() for time, (x, y, turn) in both],
    )
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return folder


def legs(folder, times, _poses):
    ranges = np.ones((len(times), 3))
    np.savez(folder / "legs.npz", **PLAIN | {"stamp": times, "ranges": ranges})
    return folder / "legs.npz"


def matlab(*names):
    def put(folder, times, poses):
        savemat(folder / "a.mat", dict(zip(names, (times, *np.array(poses).T[:2]), strict=True)))
        return folder / "a.mat"

    return put


def kitti(folder, _times, poses):
    x, y, _ = poses[-1]
    FORMATS["kitti"].put(folder)
    write(folder / "poses.txt", [f"1 0 0 {x} 0 1 0 {y} 0 0 1 0".encode()] * 3)
    return folder


def columns(path, **how):
    return datasets.read_columns(path, {"time_s": np.inf, "x_m": 1e8}, **how)


def landmarks(path, **how):
    return datasets.read_landmarks(path, {"x_m": 1e8, "y_m": 1e8}, **how)


READERS = {
    "columns": Reader(
        columns,
        rows("{!r},{!r},{!r},{!r}".format, "time_s,x_m,y_m,no"),
        lambda found: found["time_s"],
    ),
    "CSV": Reader(
        datasets.read_track, rows("{!r},{!r},{!r},{!r}".format, "time_s,x_m,y_m,heading_rad")
    ),
    "TUM": Reader(datasets.read_track, rows("{!r} {!r} {!r} 0 0 0 0 1".format)),
    "TUM in space": Reader(datasets.read_space_track, rows("{!r} {!r} {!r} 0 1 0 0 0".format)),
    "CARMEN": Reader(datasets.read_carmen_log, carmen),
    "graph": Reader(datasets.read_graph_log, graph),
    "MRCLAM": Reader(datasets.read_mrclam, mrclam, lambda found: found.robots[2].truth.times),
    "legs": Reader(datasets.read_leg_scans, legs),
    "commands": Reader(
        datasets.read_commands,
        rows("{0!r},{1!r},{3!r}".format, "time_s,speed_m_s,turn_rate_rad_s"),
    ),
    "landmarks": Reader(
        landmarks,
        rows("{!r},{!r},{!r},{!r}".format, "time_s,x_m,y_m,no"),
    ),
    "detections": Reader(
        datasets.read_detections,
        rows(
            "{0!r},laser,{1!r},{3!r},1,1".format,
            "time_s,sensor,distance_m,direction_rad,distance_sigma_m,direction_sigma_rad",
        ),
    ),
    "relations": Reader(
        datasets.read_relations,
        rows("{0!r} {0!r} {1!r} {2!r} 0 0 0 {3!r}".format),
        lambda found: found.times[:, 1],
    ),
    "vehicle": Reader(datasets.read_vehicle, matlab("time", "speed", "steering")),
    "fixes": Reader(datasets.read_fixes, matlab("timeGps", "Lo_m", "La_m")),
    "chain": Reader(
        datasets.read_landmark_graph,
        rows(lambda k, x, y, turn: f"ODOMETRY {k} {k + 1} {x!r} {y!r} {turn!r} 1 0 0 1 0 1"),
        None,
    ),
    "sightings": Reader(
        datasets.read_landmark_graph,
        rows("LANDMARK 0 {0} {1!r} {2!r} 1 0 1".format, "ODOMETRY 0 1 0 0 0 1 0 0 1 0 1"),
        None,
    ),
    "KITTI": Reader(datasets.read_kitti, kitti, None),
}
TIMED = {name: reader for name, reader in READERS.items() if reader.times}
STEPS = 0.1 * np.arange(12)


def test_every_reader_that_takes_a_unit_of_time_is_in_the_table():
    there = {getattr(datasets, name) for name in datasets.__all__ if name.startswith("read_")}
    takes = {read for read in there if "time_unit" in inspect.signature(read).parameters}
    known = {reader.read for reader in TIMED.values()} - {columns, landmarks}
    assert takes == known | {datasets.read_columns, datasets.read_landmarks}


@pytest.mark.parametrize("since", [0.0, 1.7e9], ids=["from 0", "from 1970"])
@pytest.mark.parametrize("unit", limits.UNITS)
@pytest.mark.parametrize("reader", TIMED.values(), ids=TIMED)
def test_times_are_read_in_their_unit_and_refused_in_another(reader, unit, since, tmp_path):
    times = (np.round(since + STEPS, 6) * limits.UNITS[unit]).tolist()
    path = reader.put(tmp_path, times, [[0.5, 0.0, 0.25]] * len(times))
    found = reader.times(reader.read(path, time_unit=unit))
    np.testing.assert_allclose(found, since + STEPS, rtol=0, atol=1e-6)
    if unit != "s":
        hint = rf"\(time_unit='{unit}'\)"
        with pytest.raises(
            OtherUnit, match=rf"these times look like {limits.NAMES[unit]} {hint}"
        ) as error:
            reader.read(path, time_unit="s")
        assert error.value.unit == unit
    with pytest.raises(ValueError, match="time_unit must be one of 's', 'ms', 'us', 'ns', got 'h'"):
        reader.read(path, time_unit="h")


NOWHERE = "legs", "vehicle", "commands", "detections"
FAR = {name: READERS[name] for name in READERS if name not in NOWHERE}


@pytest.mark.parametrize("reader", FAR.values(), ids=FAR)
def test_places_may_be_those_of_utm_but_no_farther(reader, tmp_path):
    reader.read(reader.put(tmp_path, [0, 1], [[458074.604, 5429380.172, 0.0]] * 2))
    reader.put(tmp_path, [0, 1], [[0.0, 0.0, 0.0], [2e8, 0.0, 0.0]])
    path = reader.put(tmp_path, [0, 1], [[0.0, 0.0, 0.0], [-2e8, 0.0, 0.0]])
    with pytest.raises(CorruptLog, match=r"beyond 1e\+08"):
        reader.read(path)


DEGREES = {
    "right angles": [0, 90, 180],
    "small ones": [5.0, 6, 7, 8],
    "a wrap": [178.25, 179.75, -178.75],
    "a turn": np.arange(0, 130, 0.5).tolist(),
    "backwards": (-np.arange(0, 130, 0.5)).tolist(),
}
RADIANS = {
    "wrapped": [3.1, -3.1, -2.9],
    "wrapped late": [3.4, -3.4],
    "from 0 to a turn": [0.0, 6.28],
    "three turns": np.arange(0, 6 * np.pi, 0.3).tolist(),
    "whole": [0, 1, 2, 3, 4, 5, 6],
}
HEADED = {name: READERS[name] for name in ("CSV", "CARMEN", "graph", "MRCLAM")}


@pytest.mark.parametrize("headings", DEGREES.values(), ids=DEGREES)
@pytest.mark.parametrize("reader", HEADED.values(), ids=HEADED)
def test_headings_in_degrees_are_refused(reader, headings, tmp_path):
    poses = [[0.5, 0.0, float(heading)] for heading in headings]
    path = reader.put(tmp_path, (np.arange(len(poses)) / 10).tolist(), poses)
    with pytest.raises(CorruptLog, match=r"its heading is .*: are these degrees\?"):
        reader.read(path)


@pytest.mark.parametrize("headings", RADIANS.values(), ids=RADIANS)
@pytest.mark.parametrize("reader", HEADED.values(), ids=HEADED)
def test_headings_in_radians_are_read_wrapped_or_not(reader, headings, tmp_path):
    poses = [[0.5, 0.0, float(heading)] for heading in headings]
    reader.read(reader.put(tmp_path, (np.arange(len(poses)) / 10).tolist(), poses))


@given(
    st.floats(0.05, 2.0),
    st.integers(limits.READINGS, 50),
    st.sampled_from([0.0, -5.0, 1.7e9]),
    st.sampled_from([unit for unit in limits.UNITS if unit != "s"]),
)
def test_a_recording_is_none_in_any_other_unit(step, count, since, unit):
    times = since + step * np.arange(count)
    assert limits.time_fault(times, "s") == ""
    assert limits.time_fault(times * limits.UNITS[unit], unit) == ""
    assert f"look like {limits.NAMES[unit]}" in limits.time_fault(times * limits.UNITS[unit], "s")
    assert "s apart" in limits.time_fault(times, "ns") or since > 0


@pytest.mark.parametrize(
    ("times", "fault"),
    [
        (np.arange(20) * 1e-3, ""),
        ([5.0], ""),
        ([], ""),
        ([7.0] * 20, ""),
        (np.repeat(np.arange(20), 9) * 25.0, ""),
        ([0.0, 3600.0, 9 * 3600.0], ""),
        (np.arange(20) * 40.0, "its 20 times are 40 s apart; these times look like millisec"),
        (np.arange(20) * 1e-9, "its 20 times are 1e-09 s apart, which no recording does"),
        ([0.0, 8 * 86400.0], "its 2 times span 691200 s, more than a week; these times look like"),
        ([-2e10], "its times reach 2e+10 s; these times look like milliseconds"),
        ([1e30], "its times reach 1e+30 s, which no recording does"),
    ],
)
def test_the_limits_of_times(times, fault):
    assert limits.time_fault(np.array(times, float), "s").startswith(fault)
    assert fault or not limits.time_fault(np.array(times, float), "s")
