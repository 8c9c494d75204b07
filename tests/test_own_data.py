"""The scripts of "Your own data", on files of known worlds, and the page's own examples."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from data_synth import laser
from data_synth.building import drive
from data_synth.posts import glimpse, make_posts
from data_synth.wheels import LARGE, roll
from robot_perception.datasets import read_mrclam, read_track
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.evaluation.trajectories import absolute_error
from robot_perception.slam.planar import Odometry, Velocity, compound, dead_reckoning
from robot_perception.streams import hold
from tests.datasets import writing
from tests.datasets.here import recording
from tests.unchecked import unchecked

BOOK = Path(__file__).parents[1] / "book"
SCRIPTS = BOOK / "own_data"
PAGE = (BOOK / "your_own_data.md").read_text("utf-8")
EXAMPLES = dict(re.findall(r"```\{code-block\} text\n:caption: (.*)\n\n([^`]*)```", PAGE))
CONSOLES = re.findall(r"```\{code-block\} console\n([^`]*)```", PAGE)
NUMBER = re.compile(r"-?\d+\.?\d*")
EVERY = 0.25  # s between the observations of the drive round the posts


def run(folder: Path, script: str, *words: str) -> str:
    """Run a script as a reader does and return what it prints."""
    command = [sys.executable, SCRIPTS / script, *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def numbers(text: str, label: str) -> list[float]:
    """Return the numbers of the line that begins with a label."""
    (line,) = (line for line in text.splitlines() if line.strip().startswith(label))
    return [float(number) for number in NUMBER.findall(line.partition(label)[2])]


def table(path: Path, names: str, columns: list[np.ndarray]) -> None:
    np.savetxt(path, np.column_stack(columns), "%.9f", ",", header=names, comments="")


# The page ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("script", sorted(path.name for path in SCRIPTS.glob("*.py")))
def test_scripts_are_short_and_on_the_page(script):
    lines = (SCRIPTS / script).read_text("utf-8").splitlines()
    assert sum(map(bool, lines)) <= 40
    assert f"```{{literalinclude}} own_data/{script}\n" in PAGE
    assert f"{{download}}`{script} <own_data/{script}>`" in PAGE


def test_the_page_prints_what_the_scripts_print(tmp_path):
    """All its commands, one after the other, on its files; without the recording of a building."""
    for name, text in EXAMPLES.items():
        (tmp_path / name).write_text(text)
    printed = [play(tmp_path, console) for console in CONSOLES if "fr079" not in console]
    assert len(printed) == len(CONSOLES) - 1 == 3
    assert (tmp_path / "drive.tum").stat().st_size


def test_the_page_prints_the_walls_of_freiburg(tmp_path):
    name = "fr079_graph.log.gz"
    (tmp_path / name).symlink_to(recording("carmen_fr079", name))
    play(tmp_path, *(console for console in CONSOLES if name in console))


def play(folder: Path, console: str) -> None:
    """Run the commands of a console and compare its text, numbers to a fiftieth."""
    for part in console.split("$ python ")[1:]:
        (script, *words), expected = part.split("\n")[0].split(), part.partition("\n")[2]
        found = run(folder, script, *words)
        assert NUMBER.sub("#", found) == NUMBER.sub("#", expected)
        pairs = (list(map(float, NUMBER.findall(text))) for text in (found, expected))
        np.testing.assert_allclose(*pairs, rtol=0.02, atol=0.002)


# EKF-SLAM ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def posts(tmp_path_factory):
    """A drive round posts at 1 m/s: the commands, what was seen, and the truth."""
    folder = tmp_path_factory.mktemp("posts")
    world = make_posts(40.0, rng=np.random.default_rng(1))
    poses = drive(world, step=EVERY, beyond=4.0)
    times = EVERY * np.arange(len(poses))
    forward, left, turn = roll(poses, LARGE, rng=np.random.default_rng(2)).increments.T
    speeds = np.stack([np.hypot(forward, left) / np.sinc(turn / (2 * np.pi)), turn]) / EVERY
    table(
        folder / "commands.csv",
        "turn_rate_rad_s,time_s,speed_m_s",
        [np.append(speeds[1], 0), times, np.append(speeds[0], 0)],
    )
    seen = glimpse(world.landmarks, poses, sigma=0.05, reach=6.0, rng=np.random.default_rng(3))
    when = np.repeat(times, [len(ids) for ids, _ in seen])
    ids, (x, y) = np.concatenate([ids for ids, _ in seen]), np.vstack([p for _, p in seen]).T
    for kind, names, values in (
        ("points", "x_m,y_m", [x, y]),
        ("polar", "range_m,bearing_rad", [np.hypot(x, y), np.arctan2(y, x)]),
    ):
        table(folder / f"{kind}-named.csv", f"time_s,{names},landmark", [when, *values, ids])
        table(folder / f"{kind}-nameless.csv", f"time_s,{names}", [when, *values])
    table(folder / "truth.csv", "time_s,x_m,y_m,heading_rad", [times, *poses.T])
    motions = [Velocity(*speed, EVERY, np.zeros((2, 2))) for speed in speeds.T.tolist()]
    lost = absolute_error(dead_reckoning(poses[0], motions), poses, aligned=False)
    return folder, world.landmarks, poses, lost


@pytest.mark.parametrize("names", ["named", "nameless"])
@pytest.mark.parametrize("kind", ["polar", "points"])
def test_ekf_slam_finds_way_and_landmarks(posts, kind, names):
    """Far nearer than the wheels alone; and a second script judges it as we do."""
    folder, landmarks, poses, lost = posts
    out = f"{kind}-{names}-run"
    said = run(folder, "ekf_slam.py", kind, "commands.csv", f"{kind}-{names}.csv", out)
    track = read_track(folder / f"{out}.csv")
    error = absolute_error(track.poses, poses[1:], aligned=False)
    assert error < lost / 5
    found = np.loadtxt(folder / f"{out}_map.csv", delimiter=",", skiprows=1)
    apart = np.hypot(*(found[:, None, 1:] - landmarks).transpose(2, 0, 1))
    assert apart.min(axis=1).max() < 0.5
    assert sorted(apart.argmin(axis=1)) == list(range(len(landmarks)))
    if names == "named":
        np.testing.assert_array_equal(apart.argmin(axis=1), found[:, 0])
    assert len(found) == len(landmarks)
    assert f"steps: {len(poses) - 1}, " in said
    judged = run(folder, "judge.py", f"{out}.csv", "truth.csv")
    assert numbers(judged, "ATE:")[0] == pytest.approx(error, abs=0.0005)
    low, high = average_bounds(3, 1)
    assert low < numbers(judged, "NEES:")[0] < high


def test_ekf_slam_of_a_real_robot(tmp_path):
    """The first robot of the UTIAS recording, with the script's constants as they are."""
    robot = read_mrclam(recording("utias_mrclam_6")).robots[1]
    times, speeds = robot.commands.times, robot.commands.velocities
    table(tmp_path / "commands.csv", "time_s,speed_m_s,turn_rate_rad_s", [times, *speeds.T])
    seen, names = robot.landmarks, "time_s,landmark,range_m,bearing_rad"
    table(tmp_path / "seen.csv", names, [seen.times, seen.subjects, *seen.values.T])
    said = run(tmp_path, "ekf_slam.py", "polar", "commands.csv", "seen.csv", "run")
    assert f"observed={len(seen.times)}, " in said
    track = read_track(tmp_path / "run.csv")
    truth, covered = robot.truth.at(track.times, longest_gap=0.5)
    increments, _ = compound(hold(times, speeds, track.times), np.zeros(2))
    lost = dead_reckoning(np.zeros(3), [Odometry(row, np.zeros((3, 3))) for row in increments])
    error, wheels = (
        absolute_error(poses[covered], truth[covered], aligned=True)
        for poses in (track.poses, lost)
    )
    assert error < wheels / 5


# Walls -------------------------------------------------------------------------------------------

CORNERS = np.array([[-2.0, -1.5], [4.0, -1.5], [4.0, 2.5], [-2.0, 2.5]])


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    """A room of 6 by 4 metres, scanned by a robot that drives and turns: as array and as logs."""
    folder = tmp_path_factory.mktemp("room")
    faces = np.stack([CORNERS, np.roll(CORNERS, -1, axis=0)], axis=1)
    k = np.arange(24)
    poses = np.stack([-1 + k / 8, 0.3 * np.sin(k), 0.5 * k - 3], axis=1)
    scanner = laser.Scanner(max_range=5.0)
    ranges = laser.scan(faces, poses, scanner, rng=np.random.default_rng(1)).ranges
    assert np.isinf(ranges).any()
    np.save(folder / "ranges.npy", ranges)
    np.savetxt(folder / "ranges.csv", ranges, "%.17g", ",")
    table(folder / "poses.csv", "time_s,x_m,y_m,heading_rad", [k, *poses.T])
    poses = np.round(poses, 9)
    logged = np.where(np.isinf(ranges), 81.91, ranges)
    rows = list(zip(logged, poses, poses, k.tolist(), strict=True))
    writing.write(folder / "carmen.log.gz", [writing.flaser(*row) for row in rows])
    field = {"start": -np.pi / 2, "resolution": np.pi / 360}
    lines = [
        line
        for number, row in enumerate(rows)
        for line in (writing.vertex(number, row[1]), writing.robotlaser(*row, **field))
    ]
    writing.write(folder / "graph.log", lines)
    return folder, int(np.isinf(ranges).sum())


@pytest.mark.parametrize(
    "words",
    [
        ("array", "ranges.npy", "poses.csv"),
        ("array", "ranges.csv", "poses.csv"),
        ("carmen", "carmen.log.gz"),
        ("graph", "graph.log"),
    ],
    ids=lambda words: words[1],
)
def test_walls_are_those_of_the_room(room, words):
    folder, nothing = room
    said = run(folder, "walls.py", *words, "walls.csv")
    found = np.loadtxt(folder / "walls.csv", delimiter=",", skiprows=1)
    assert len(found) == 4
    ends = found[:, :4].reshape(-1, 2, 2)
    corner = np.hypot(*(ends[:, :, None] - CORNERS).transpose(3, 0, 1, 2))
    assert corner.min(axis=2).max() < 0.1
    for (x, y), (u, v) in ends:
        across = [abs(c - side) for side in (-2, 4) for c in (x, u)]
        upward = [abs(c - side) for side in (-1.5, 2.5) for c in (y, v)]
        offsets = [max(pair) for pair in (across[:2], across[2:], upward[:2], upward[2:])]
        assert min(offsets) < 0.02
    assert numbers(said, "readings:") == [24 * 361, nothing]
    assert numbers(said, "scans:")[1:] == [4, pytest.approx(20, abs=0.5)]


# Rank --------------------------------------------------------------------------------------------


def test_ranks_are_those_of_theory(tmp_path):
    """Seven states: one anchor leaves the turn about it open, a measured position nothing."""
    for sensors, rank, unseen in (
        ("landmarks", 4, "shift in x, shift in y, turn about the robot"),
        ("landmarks anchor", 6, "turn about the anchor"),
        ("landmarks anchor anchor2", 7, "nothing"),
        ("distances position", 7, "nothing"),
        ("position", 3, "4 directions that are no motion of the whole world"),
    ):
        said = run(tmp_path, "rank.py", *sensors.split())
        assert said.count(f": rank {rank} of 7\n") == 2
        assert said.count(f"cannot be observed: {unseen}\n") == 2


# NEES and trajectory errors ----------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1.0, 0.25], ids=["consistent", "overconfident"])
def test_nees_is_inside_its_bounds_if_the_covariances_are_right(tmp_path, scale):
    """Errors drawn from the covariances; at a quarter of them the NEES is four times as high."""
    rng, count = np.random.default_rng(4), 400
    times = 0.1 * np.arange(count)
    truth = np.stack([times, np.sin(times), np.arctan(np.cos(times))], axis=1)
    roots = 0.05 * rng.normal(size=(count, 3, 3)) + 0.1 * np.eye(3)
    errors = (roots @ rng.normal(size=(count, 3, 1)))[..., 0]
    covs = scale * roots @ roots.mT
    names = "time_s,x_m,y_m,heading_rad"
    upper = [covs[:, i, j] for i, j in zip(*np.triu_indices(3), strict=True)]
    table(tmp_path / "truth.csv", names, [times, *truth.T])
    names += ",cov_xx,cov_xy,cov_xh,cov_yy,cov_yh,cov_hh"
    poses = truth + errors + [0, 0, 2 * np.pi]  # another turn is the same heading
    table(tmp_path / "run.csv", names, [times, *poses.T, *upper])
    said = run(tmp_path, "judge.py", "run.csv", "truth.csv")
    low, high = average_bounds(3, count)
    assert low < numbers(said, "NEES:")[0] * scale < high
    share = np.mean(
        np.sum(np.linalg.solve(roots, errors[..., None]) ** 2, axis=(1, 2)) < 7.815 * scale
    )
    assert f"{share:.1%} of the poses lie inside" in said
    assert numbers(said, "poses:") == [count, count]
    assert numbers(said, "ATE:")[0] == pytest.approx(
        np.sqrt(np.mean(np.sum(errors[:, :2] ** 2, axis=1))), abs=0.0005
    )


# Bad input ---------------------------------------------------------------------------------------

FILES = EXAMPLES | {
    "degrees.csv": "time_s,landmark,range_m,bearing_rad\n0.5,3,3.6,16\n",
    "half.csv": "time_s,landmark,range_m,bearing_rad\n0.5,3.5,3.6,0.1\n",
    "early.csv": "time_s,landmark,range_m,bearing_rad\n-0.5,3,3.6,0.1\n",
    "twice.csv": "time_s,landmark,range_m,bearing_rad\n0.5,3,3.6,0.1\n0.5,3,3.6,0.1\n",
    "hole.csv": "time_s,landmark,range_m,bearing_rad\n0.5,3,nan,0.1\n",
    "falling.csv": "time_s,speed_m_s,turn_rate_rad_s\n1,1,0\n0,1,0\n",
    "mm.csv": "2000,2001,2002\n",
    "one.csv": "2,2.1,2.2\n",
    "later.csv": "time_s,x_m,y_m,heading_rad\n100,0,0,0\n101,1,0,0\n",
}


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("ekf_slam.py", r"EKF-SLAM on a robot's log: python ekf_slam.py polar\|points"),
        ("ekf_slam.py sonar commands.csv observations.csv d", "polar"),
        ("ekf_slam.py polar none.csv observations.csv d", "No such file.*none.csv"),
        ("ekf_slam.py points commands.csv observations.csv d", "observations.csv, .* column x_m"),
        ("ekf_slam.py polar commands.csv truth.csv d", "truth.csv, line 1: no column range_m"),
        ("ekf_slam.py polar commands.csv degrees.csv d", "line 2: bearing_rad is '16', beyond 7"),
        ("ekf_slam.py polar commands.csv half.csv d", "line 2: landmark is '3.5', not a whole"),
        ("ekf_slam.py polar commands.csv hole.csv d", "line 2: range_m is 'nan', not a finite"),
        ("ekf_slam.py polar commands.csv early.csv d", "no observation falls between"),
        ("ekf_slam.py polar commands.csv twice.csv d", r"got twice: \[3\]"),
        ("ekf_slam.py polar falling.csv observations.csv d", "times must not fall, got 1.0"),
        ("ekf_slam.py polar commands.csv observations.csv no/d", "no is no folder"),
        ("walls.py array mm.csv poses.csv w.csv", "no reading is below 80 m; are they in metres"),
        ("walls.py array one.csv poses.csv w.csv", "have a pose for each scan, got 1 and 2"),
        ("walls.py array one.csv none.csv w.csv", "No such file.*none.csv"),
        ("walls.py carmen one.csv w.csv", "one.csv, line 1: does not begin with a keyword"),
        ("walls.py graph none.log w.csv", "No such file.*none.log"),
        ("walls.py graph", "Walls from scans: python walls.py"),
        ("rank.py", "What your sensors cannot tell you"),
        ("rank.py landmarks gps", "no sensor gps; there are landmarks, anchor"),
        ("judge.py commands.csv truth.csv", "commands.csv, line 1: no column x_m"),
        ("judge.py later.csv truth.csv", "the paths are empty"),
        ("judge.py truth.csv none.csv", "No such file.*none.csv"),
        ("judge.py truth.csv", "python judge.py ESTIMATE TRUTH"),
    ],
)
def test_bad_input_ends_with_one_line(command, message, tmp_path, monkeypatch):
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    script, *words = command.split()
    monkeypatch.setattr(sys, "argv", [script, *words])
    with unchecked(), pytest.raises(SystemExit, match=message) as end:
        runpy.run_path(str(SCRIPTS / script), run_name="__main__")
    assert "\n" not in str(end.value)


def test_bad_input_shows_no_traceback(tmp_path):
    command = [sys.executable, SCRIPTS / "judge.py", "none.csv", "none.csv"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr == "[Errno 2] No such file or directory: 'none.csv'\n"
