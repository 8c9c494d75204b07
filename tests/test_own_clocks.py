"""Two files of the scripts of "Your own data": each has its own unit of time and its own topic."""

from pathlib import Path

import numpy as np
import pytest

from robot_perception.datasets import read_video, write_columns, write_tum
from robot_perception.geometry import se3
from tests.datasets import bags
from tests.test_own_bags import play

SPAN = 0.1 * np.arange(40)  # s
POSES = np.stack([SPAN, np.sin(SPAN), 0.1 * SPAN], axis=1)
HIGH = se3.from_se2(POSES, 1.0)
HIGH[:, 2, 3] += np.cos(SPAN)
UNITS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}


def track(path: Path, unit: str, since: float = 0.0) -> None:
    columns = dict(zip(("x_m", "y_m", "heading_rad"), POSES.T, strict=True))
    write_columns(path, {"time_s": (since + SPAN) * UNITS[unit], **columns}, overwrite=True)


def space_track(path: Path, unit: str, since: float = 0.0) -> None:
    write_tum(path, (since + SPAN) * UNITS[unit], HIGH, overwrite=True)


def commands(path: Path, unit: str, since: float = 0.0) -> None:
    columns = {"speed_m_s": np.ones(40), "turn_rate_rad_s": np.full(40, 0.1)}
    write_columns(path, {"time_s": (since + SPAN) * UNITS[unit], **columns}, overwrite=True)


def observations(path: Path, unit: str, since: float = 0.0) -> None:
    columns = {"landmark": np.ones(39, int), "range_m": 4 - SPAN[1:], "bearing_rad": 0 * SPAN[1:]}
    write_columns(path, {"time_s": (since + SPAN[1:]) * UNITS[unit], **columns}, overwrite=True)


def detections(path: Path, unit: str, since: float = 0.0) -> None:
    names = "distance_m", "direction_rad", "distance_sigma_m", "direction_sigma_rad"
    numbers = dict(zip(names, np.tile([[2.0], [0.1], [0.05], [0.03]], 40), strict=True))
    columns = {"time_s": (since + SPAN) * UNITS[unit], "sensor": np.full(40, "laser"), **numbers}
    write_columns(path, columns, overwrite=True)


def scans(path: Path, unit: str, since: float = 0.0) -> None:
    how = {"angle_min": -1.0, "angle_increment": 0.01, "range_min": 0.05, "range_max": 9.0}
    ranges = np.full((40, 200), 3.0)
    ranges[:, [95, 96, 97, 105, 106, 107]] = 1.5
    np.savez(path, stamp=(since + SPAN) * UNITS[unit], ranges=ranges, **how)


TWO = {  # scripts with two files that have times: the words, and what writes each
    "judge.py": (["judge.py", "a.csv", "b.csv"], track, track),
    "judge.py in space": (["judge.py", "a.tum", "b.tum"], space_track, space_track),
    "ekf_slam.py": (
        ["ekf_slam.py", "polar", "a.csv", "b.csv", "out", "--force"],
        commands,
        observations,
    ),
    "people.py": (
        ["people.py", "detections", "a.csv", "out", "b.csv", "--force"],
        detections,
        track,
    ),
    "people.py by legs": (
        ["people.py", "legs", "a.npz", "out", "b.csv", "--force"],
        scans,
        track,
    ),
}


def files(words: list[str]) -> list[str]:
    return sorted(word for word in words if word[:2] in ("a.", "b."))


def error(said: str) -> str:
    """Return the line of what a script said that is its error."""
    (line,) = [line for line in said.splitlines() if line.startswith("Error: ")]
    return line


@pytest.mark.parametrize("since", [0.0, 1.7e9], ids=["from 0", "from 1970"])
@pytest.mark.parametrize("units", [("s", "ms"), ("ns", "s")], ids="-".join)
@pytest.mark.parametrize("name", TWO)
def test_each_of_two_files_has_its_own_unit_of_time(name, units, since, tmp_path):
    """The numbers tell it, or one option for each file; a wrong option ends in one that works."""
    words, *write = TWO[name]
    names = files(words)
    for put, file in zip(write, names, strict=True):
        put(tmp_path / file, "s", since)
    expected = play(tmp_path, *words)
    for put, file, unit in zip(write, names, units, strict=True):
        put(tmp_path / file, unit, since)
    told = "".join(
        f"{file}: its times are read in {unit}, as their size tells\n"
        for file, unit in zip(names, units, strict=True)
        if unit != "s"
    )
    assert sorted(play(tmp_path, *words).splitlines()) == sorted((told + expected).splitlines())
    given = [word for unit in units for word in ("--time-unit", unit)]
    assert play(tmp_path, *words, *given) == expected
    for unit in units:
        said = error(play(tmp_path, *words, "--time-unit", unit, code=1))
        assert said.endswith(f"{' '.join(given)} would help")


@pytest.mark.parametrize("name", TWO)
def test_two_clocks_are_told_with_what_they_span(name, tmp_path):
    words, first, second = TWO[name]
    names = files(words)
    first(tmp_path / names[0], "s", 0.0)
    second(tmp_path / names[1], "s", 1.7e9)
    said = error(play(tmp_path, *words, code=1))
    assert "no time in common: " in said
    assert f"{names[0]} from 0.000 to 3.900 s" in said
    assert f"{names[1]} from 1700000000." in said
    assert "one clock counts from 1970, the other does not" in said


# Topics ------------------------------------------------------------------------------------------


def drive(topic: str, off: float, high: float = 0.0) -> list[bags.Said]:
    moved = se3.from_se2(POSES + np.array([off, 0.0, 0.0]), high)
    moved[:, 2, 3] += high * SPAN
    return [
        bags.odometry(t, T, topic=topic, cov=0.01 * np.eye(3))
        for t, T in zip(SPAN, moved, strict=True)
    ]


@pytest.mark.parametrize("high", [0.0, 1.0], ids=["plane", "space"])
def test_an_estimate_is_judged_by_the_truth_of_its_own_bag(high, tmp_path):
    bags.write_bag(tmp_path / "run.bag", [*drive("/odom", 0.2, high), *drive("/truth", 0.0, high)])
    bags.write_bag(tmp_path / "odom.bag", drive("/odom", 0.2, high))
    bags.write_bag(tmp_path / "truth.bag", drive("/truth", 0.0, high))
    two = ["--topic", "/odom", "--topic", "/truth"]
    one = play(tmp_path, "judge.py", "run.bag", "run.bag", *two)
    assert "ATE: 0.200 m" in one
    assert play(tmp_path, "judge.py", "odom.bag", "truth.bag", *two) == one
    told = play(tmp_path, "judge.py", "odom.bag", "truth.bag")
    assert told == f"poses of /odom\nposes of /truth\n{one}"
    said = play(tmp_path, "judge.py", "run.bag", "run.bag", code=1)
    assert "2 topics hold poses: /odom (Odometry, 40 messages), /truth (Odometry, 40 mess" in said
    assert "of two files one for each" in said
    for file, given in (("run.bag", ["--topic", "/odom"]), ("odom.bag", [])):
        said = play(tmp_path, "judge.py", file, file, *given, code=1)
        assert f"{file} would be judged by itself: --topic for the estimate, then truth" in said
    said = play(tmp_path, "judge.py", "run.bag", "run.bag", *two, "--topic", "/odom", code=1)
    assert "--topic may be given once, or 2 times in the order of the files" in said


def test_topics_of_two_bags_are_each_looked_for_where_they_are(tmp_path):
    """The scans of one bag, and the poses of another one."""
    ranges = np.full(200, 3.0)
    ranges[[95, 96, 97, 105, 106, 107]] = 1.5
    seen = [
        bags.scan(t, ranges, topic=topic, angles=(-1.0, 0.01))
        for t in SPAN
        for topic in ("/front", "/rear")
    ]
    bags.write_bag(tmp_path / "scans.bag", seen)
    bags.write_bag(tmp_path / "way.bag", [*drive("/odom", 0.0), *drive("/truth", 0.0)])
    words = ["people.py", "legs", "scans.bag", "out", "way.bag", "--force"]
    said = play(tmp_path, *words, "--topic", "/front", "--topic", "/truth")
    assert "without a pose: 0" in said
    assert "stand still" not in said
    said = play(tmp_path, *words, "--topic", "/front", "--topic", "/none", code=1)
    assert "topic '/none' is not in scans.bag or way.bag" in said


# Robots that stand still, and nights --------------------------------------------------------------


@pytest.mark.parametrize("kind", ["detections", "legs"])
def test_that_a_robot_is_taken_to_stand_still_is_told(kind, tmp_path):
    name = {"detections": "a.csv", "legs": "a.npz"}[kind]
    {"detections": detections, "legs": scans}[kind](tmp_path / name, "s")
    said = play(tmp_path, "people.py", kind, name, "out")
    assert "no POSES: the robot is taken to stand still" in said


def test_a_night_between_two_readings_makes_no_film_of_a_night(tmp_path):
    rows = [(t, "laser", 2.0, 0.1, 0.05, 0.03) for day in (0.0, 36000.0) for t in day + SPAN]
    names = "time_s,sensor,distance_m,direction_rad,distance_sigma_m,direction_sigma_rad"
    text = "\n".join([names, *(",".join(map(str, row)) for row in rows)])
    (tmp_path / "seen.csv").write_text(text)
    play(tmp_path, "people.py", "detections", "seen.csv", "out")
    count = sum(1 for _ in read_video(tmp_path / "out.mp4"))
    assert 80 <= count <= 80 + 60
