"""The scripts of "Your own data", on files of known worlds, and the page's own examples.

Each script runs from end to end in `make test`; longer recordings and films in `make test-all`.
"""

import contextlib
import io
import re
import runpy
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from PIL import Image

from data_synth import ceiling, coloured, laser, stereo, textured_building
from data_synth.arms.gestures import ArmScene, film_arms
from data_synth.building import drive
from data_synth.companion.face_films import FaceScene, film_faces
from data_synth.companion.faces import make_identity
from data_synth.companion.hall import make_hall
from data_synth.companion.visits import Stance, make_visitor, see
from data_synth.people import LASER_ANGLES, make_people_office, make_session, readings
from data_synth.people.staging import rig as rig_with
from data_synth.people.world import Wander
from data_synth.posts import glimpse, make_posts
from data_synth.wheels import LARGE, roll
from data_synth.wheels import Odometry as Report
from robot_perception.appearance.segmentation import filled
from robot_perception.arms.body_model import BodyModel
from robot_perception.book import tutor_following
from robot_perception.cameras import Pinhole
from robot_perception.chapters.tutor_following.scene import CAMERA
from robot_perception.companion.boxes import overlap
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.companion.interaction import paper_table
from robot_perception.datasets import (
    read_boxes,
    read_columns,
    read_kitti,
    read_leg_scans,
    read_mrclam,
    read_space_track,
    read_track,
    read_video,
    write_video,
)
from robot_perception.evaluation import spatial
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.evaluation.trajectories import absolute_error
from robot_perception.geometry import se2, se3
from robot_perception.people import legs
from robot_perception.slam.planar import Odometry, Velocity, compound, dead_reckoning
from robot_perception.streams import hold
from tests.datasets import writing
from tests.datasets.here import recording
from tests.datasets.space import write_path
from tests.unchecked import unchecked

BOOK = Path(__file__).parents[1] / "book"
SCRIPTS = BOOK / "own_data"
PAGE = (BOOK / "your_own_data.md").read_text("utf-8")
EXAMPLES = dict(re.findall(r"```\{code-block\} text\n:caption: (.*)\n\n([^`]*)```", PAGE))
CONSOLES = re.findall(r"```\{code-block\} console\n([^`]*)```", PAGE)
NUMBER = re.compile(r"-?\d+\.?\d*")
LONGER = (
    "arms.py",
    "ceiling.py",
    "faces.py",
    "judge.py",
    "following.py",
    "people.py",
    "stereo_slam.py",
    "track.py",
)  # they draw, or judge paths in the plane and in space
RECORDED = {  # what a console of the page runs on: the data set, and its file or folder
    "fr079_graph.log.gz": ("carmen_fr079", "fr079_graph.log.gz"),
    "kitti_stereo_straight": ("kitti_stereo_straight", None),
    "positive_1.npz": ("leg_scans", "positive_1.npz"),
    "head_girl/img": ("head_girl", None),
}
EVERY = 0.25  # s between the observations of the drive round the posts


def run(folder: Path, script: str, *words: str) -> str:
    """Run a script, one of the page or a copy, in this process and return what it prints."""
    printed = io.StringIO()
    file = folder / script if (folder / script).exists() else SCRIPTS / script
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(printed),
        mock.patch.object(sys, "argv", [script, *words]),
        pytest.raises(SystemExit) as end,
    ):
        runpy.run_path(str(file), run_name="__main__")
    assert not end.value.code, printed.getvalue()
    return printed.getvalue()


def run_alone(folder: Path, script: str, *words: str) -> str:
    """Run a script of the page as a reader does, in a process of its own."""
    command = [sys.executable, SCRIPTS / script, *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def changed(folder: Path, script: str, **constants: str) -> None:
    """Copy a script with other values of constants that stand on one line."""
    text = (SCRIPTS / script).read_text("utf-8")
    for name, value in constants.items():
        text, count = re.subn(rf"^{name} = .*$", f"{name} = {value}", text, flags=re.MULTILINE)
        assert count == 1
    (folder / script).write_text(text, "utf-8")


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
    most = dict.fromkeys(LONGER, 150)
    most |= {"stereo_slam.py": 170, "people.py": 180}  # which localise, and tell who walks, too
    assert sum(map(bool, lines)) <= most.get(script, 70)
    assert f":::{{dropdown}} The script\n```{{literalinclude}} own_data/{script}\n" in PAGE
    assert f"{{download}}`{script} <own_data/{script}>`" in PAGE


def test_the_page_prints_what_the_scripts_print(tmp_path):
    """All its commands, one after the other, on its files; without those on recordings."""
    for name, text in EXAMPLES.items():
        (tmp_path / name).write_text(text)
    own = [console for console in CONSOLES if not any(name in console for name in RECORDED)]
    for console in own:
        play(tmp_path, console)
    assert len(own) == len(CONSOLES) - len(RECORDED) == 4
    assert (tmp_path / "drive.tum").stat().st_size


@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=[pytest.mark.slow] * one.startswith("kitti")) for one in RECORDED],
)
def test_the_page_prints_what_recordings_give(name, tmp_path):
    place(tmp_path, name)
    rtol = 0.02 if name.endswith(".gz") else 0.1  # pictures are rounded otherwise elsewhere
    play(tmp_path, *(console for console in CONSOLES if name in console), rtol=rtol)


def place(folder: Path, name: str) -> None:
    """Put a recording where a reader has it; skip the test if it is not here."""
    target = recording(*RECORDED[name])
    (folder / name.partition("/")[0]).symlink_to(target)


def play(folder: Path, console: str, rtol: float = 0.02) -> None:
    """Run the commands of a console and compare its text, numbers to a fiftieth."""
    for part in console.split("$ python ")[1:]:
        (script, *words), expected = part.split("\n")[0].split(), part.partition("\n")[2]
        found = run_alone(folder, script, *words)
        assert NUMBER.sub("#", found) == NUMBER.sub("#", expected)
        pairs = (list(map(float, NUMBER.findall(text))) for text in (found, expected))
        np.testing.assert_allclose(*pairs, rtol=rtol, atol=0.002)


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
    said = run(folder, "walls.py", *words, "walls.csv", "--force")
    assert said.endswith("written: walls.csv, walls.svg\n")
    drawn = (folder / "walls.svg").read_text("utf-8")
    assert drawn.count("<polyline ") == 5  # four walls and the way
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


DRIVEN = np.linspace(0, 80, 81)


def camera_drives(folder: Path, name: str, scale: float, kind: str = "TUM") -> None:
    """Write the path of a camera that drives ahead, along its z axis, and turns to the right."""
    poses = se3.exp(np.linspace([0, 0, 0, 0, 0, 0], [0, 0, 80, 0, 0.4, 0], 81))
    poses[:, :3, 3] *= scale
    write_path(folder / name, kind, DRIVEN, poses)


@pytest.mark.parametrize("kind", ["TUM", "KITTI", "EuRoC", "space"])
def test_a_camera_is_judged_in_space(tmp_path, kind):
    """Twice too large, an estimate is metres off; with its scale free it is right."""
    camera_drives(tmp_path, "estimate", 2.0, kind)
    camera_drives(tmp_path, "truth", 1.0, kind)
    found, true = (read_space_track(tmp_path / name).poses for name in ("estimate", "truth"))
    for alignment in spatial.ALIGNMENTS:
        said = run(tmp_path, "judge.py", "estimate", "truth", "--align", alignment)
        moved, _ = spatial.align_poses(found, true, alignment)
        error = spatial.absolute_error(moved[:, :3, 3], true[:, :3, 3])
        assert numbers(said, "ATE:")[0] == pytest.approx(error, abs=0.0005)
        assert (error < 1e-9) == (alignment == "sim3")
        assert numbers(said, "poses:") == [81, 81, 81]
    assert "scale 0.5000" in said


def test_the_truth_in_space_is_taken_between_its_poses_if_asked_for(tmp_path):
    camera_drives(tmp_path, "truth", 1.0)
    rows = np.loadtxt(tmp_path / "truth")
    np.savetxt(tmp_path / "later", rows + 0.3 * np.eye(8)[0])
    changed(tmp_path, "judge.py", GAP="1.5")
    said = run(tmp_path, "judge.py", "later", "truth", "--interpolate")
    assert numbers(said, "poses:") == [81, 81, 80]
    assert numbers(said, "ATE:")[0] == pytest.approx(0.3, abs=0.01)  # m, at 1 m/s
    changed(tmp_path, "judge.py", NEAR="0.31")
    assert numbers(run(tmp_path, "judge.py", "later", "truth"), "ATE:") == [0.0]


def test_a_path_in_the_plane_beside_one_in_space_leaves_out_its_height_and_says_so(tmp_path):
    names = "time_s,x_m,y_m,heading_rad"
    table(tmp_path / "run.csv", names, [DRIVEN, DRIVEN, 0 * DRIVEN, 0 * DRIVEN])
    lifted = se3.from_se2(np.stack([DRIVEN, 0 * DRIVEN, 0 * DRIVEN], axis=1), 3.0)
    write_path(tmp_path / "truth.tum", "TUM", DRIVEN, lifted)
    said = run(tmp_path, "judge.py", "run.csv", "truth.tum")
    assert "in the plane, as run.csv: heights and tilts of truth.tum are left out" in said
    assert numbers(said, "ATE:") == [0.0]


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("kind", ["plane", "TUM"])
def test_a_short_drive_has_no_error_over_a_distance(tmp_path, kind, count):
    times = 0.4 * np.arange(count)
    poses = np.stack([0.3 * np.arange(count), 0 * times, 0 * times], axis=1)
    if kind == "plane":
        table(tmp_path / "run", "time_s,x_m,y_m,heading_rad", [times, *poses.T])
    else:
        write_path(tmp_path / "run", kind, times, se3.from_se2(poses))
    said = run(tmp_path, "judge.py", "run", "run")
    assert "relative error over 1 m: none (distance must be from 0 to" in said
    assert "nan" not in said
    assert numbers(said, "ATE:") == [0.0]


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


# SLAM with a stereo camera -----------------------------------------------------------------------

TICK = 0.1  # between pictures, s


def write_wheels(path: Path, report: Report) -> np.ndarray:
    """Write what wheels report as commands; return the path by them alone."""
    forward, left, turn = report.increments.T
    speeds = np.stack([np.hypot(forward, left) / np.sinc(turn / (2 * np.pi)), turn]) / TICK
    times, speeds = TICK * np.arange(len(turn) + 1), np.hstack([speeds, np.zeros((2, 1))])
    table(path, "time_s,speed_m_s,turn_rate_rad_s", [times, *speeds])
    return reckoned(report)


def reckoned(report: Report) -> np.ndarray:
    motions = [Odometry(row, np.zeros((3, 3))) for row in report.increments]
    return dead_reckoning(np.zeros(3), motions)


def usual_error(path: np.ndarray, *, rng: np.random.Generator) -> float:
    """Return the usual error of the wheels on a path: root mean square of many drives."""
    drives = [reckoned(roll(path, LARGE, rng=rng)) for _ in range(50)]
    return float(
        np.sqrt(np.mean([absolute_error(alone, path, aligned=False) ** 2 for alone in drives]))
    )


@pytest.fixture(scope="module")
def corridor(tmp_path_factory):
    """Forty rendered pairs of a drive in a building, as pictures, and the true path."""
    folder = tmp_path_factory.mktemp("corridor")
    world = textured_building.make_textured_building(rng=np.random.default_rng(11))
    path = textured_building.drive(world, rng=np.random.default_rng(12))[:40]
    rig = stereo.Rig()
    pairs = stereo.frames(world.scene, rig, path, rng=np.random.default_rng(13))
    for side in ("image_l", "image_r"):
        (folder / side).mkdir()
    for k, pair in enumerate(pairs):
        Image.fromarray(pair.left).save(folder / f"image_l/{k}.png")
        Image.fromarray(pair.right).save(folder / f"image_r/{k}.png")
    f, (u, v) = rig.focal_px, rig.centre_px
    shifts = 0, -f * rig.baseline
    lines = [f"P{k}: {f} 0 {u} {shift} 0 {f} {v} 0 0 0 1 0\n" for k, shift in enumerate(shifts)]
    (folder / "calib.txt").write_text("".join(lines))
    changed(
        folder,
        "stereo_slam.py",
        PAIRS="landmarks.StereoRules(disparities=(2.0, np.inf))",
        FILTER="visual.Options(particles=100, stable=5)",
        WHEELS="np.array([0.07, 0.07]) ** 2",
    )
    return folder, se2.between(path[:1], path)


@pytest.mark.parametrize(
    "wheels", [True, pytest.param(False, marks=pytest.mark.slow)], ids=["wheels", "pictures alone"]
)
def test_stereo_slam_knows_the_way_better_than_wheels(corridor, wheels):
    """Than these do, or than they usually would; all files hold the same trajectory and map."""
    folder, path = corridor
    words = ["wheels.csv"] * wheels
    report = roll(path, LARGE, rng=np.random.default_rng(2))
    lost = absolute_error(write_wheels(folder / "wheels.csv", report), path, aligned=False)
    said = run(folder, "stereo_slam.py", ".", "run", *words, "--force")
    assert f"pairs: 40, motion: {'wheels' if wheels else 'stereo'}, guessed: 0\n" in said
    track = read_track(folder / "run.tum")
    np.testing.assert_allclose(track.times, TICK * np.arange(40))
    error = absolute_error(track.poses, path, aligned=False)
    assert error < (lost if wheels else usual_error(path, rng=np.random.default_rng(3)))
    rows = np.loadtxt(folder / "run_kitti.txt").reshape(-1, 3, 4)
    np.testing.assert_allclose(rows[:, 2, 3], track.poses[:, 0], atol=1e-6)  # z ahead
    np.testing.assert_allclose(rows[:, 0, 3], -track.poses[:, 1], atol=1e-6)  # x to the right
    header, _, points = (folder / "run.ply").read_text().partition("end_header\n")
    places = np.loadtxt(points.splitlines())
    count = numbers(said, "driven:")[1]
    assert f"element vertex {count:.0f}\n" in header
    assert len(places) == count
    walls = np.abs(places[:, 1] + 0.0)
    assert np.median(walls) < 2.5  # of a corridor of 2.2 m, some seen through doors
    frames = list(read_video(folder / "run.mp4"))
    assert len(frames) == 40
    assert frames[0].shape == (360, 840, 3)


@pytest.mark.slow
def test_a_robot_finds_its_place_in_the_map_of_another_drive(corridor, capsys):
    """On a line beside the first; where the map lies is where that drive began."""
    folder, _ = corridor
    run(folder, "stereo_slam.py", ".", "made", "--force")
    world = textured_building.make_textured_building(rng=np.random.default_rng(11))
    path = textured_building.drive(world, rng=np.random.default_rng(12))
    later = path[4:40:4] + np.array([0.0, 0.1, 0.02])
    other = folder / "later"
    for side in ("image_l", "image_r"):
        (other / side).mkdir(parents=True, exist_ok=True)
    for k, pair in enumerate(
        stereo.frames(world.scene, stereo.Rig(), later, rng=np.random.default_rng(14))
    ):
        Image.fromarray(pair.left).save(other / f"image_l/{k}.png")
        Image.fromarray(pair.right).save(other / f"image_r/{k}.png")
    (other / "calib.txt").write_text((folder / "calib.txt").read_text())
    said = run(folder, "stereo_slam.py", "later", "there", "--map", "made_map.npz", "--force")
    assert numbers(said, "pairs:")[0] == 9
    assert numbers(said, "pairs:")[1] >= 6
    track = read_track(folder / "there.tum")
    truth = se2.between(path[:1], later)
    assert np.hypot(*(track.poses - truth)[4:, :2].T).max() < 0.5
    (folder / "none.npz").write_bytes(b"no map")
    with pytest.raises(AssertionError):
        run(folder, "stereo_slam.py", "later", "there", "--map", "none.npz", "--force")
    assert "no map of this script" in capsys.readouterr().err


@pytest.mark.slow
def test_stereo_slam_of_a_car(tmp_path):
    """On real pictures as KITTI has them, with simulated wheels, as the recording has none."""
    folder, known = downloaded(tmp_path), read_kitti(recording("kitti_stereo_straight")).poses
    mount = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
    poses = mount @ se3.between(known[:1], known) @ mount.T
    truth = np.column_stack([poses[:, :2, 3], np.arctan2(poses[:, 1, 0], poses[:, 0, 0])])
    alone = write_wheels(tmp_path / "wheels.csv", roll(truth, LARGE, rng=np.random.default_rng(1)))
    lost = absolute_error(alone, truth, aligned=False)
    for words, share, since in ((["wheels.csv"], 1.0, 0.0), ([], 0.5, 7.0)):
        np.savetxt(folder / "times.txt", times := 0.1 * np.arange(25) + since)
        run(tmp_path, "stereo_slam.py", str(folder), "run", *words, "--force")
        track = read_track(tmp_path / "run.tum")
        np.testing.assert_allclose(track.times, times, atol=1e-6)
        assert absolute_error(track.poses, truth, aligned=False) < share * lost


def downloaded(folder: Path) -> Path:
    """Lay a recording out as KITTI's odometry is downloaded."""
    there, sequence = recording("kitti_stereo_straight"), folder / "00"
    sequence.mkdir()
    for ours, theirs in (("image_l", "image_0"), ("image_r", "image_1")):
        (sequence / theirs).symlink_to(there / ours)
    rows = (there / "calib.txt").read_text().split("\n")
    (sequence / "calib.txt").write_text(f"P0: {rows[0]}\nP1: {rows[1]}\n")
    return sequence


# People ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def visit(tmp_path_factory):
    """Three people round a robot that drives through an office for half a minute."""
    folder = tmp_path_factory.mktemp("visit")
    office = make_people_office(rng=np.random.default_rng(1), distractors=False)
    session = make_session(
        office,
        rng=np.random.default_rng(2),
        duration=30.0,
        robot="drives",
        act=Wander(leaves=0.0, reach=2.5),
    )
    robot = "time_s,x_m,y_m,heading_rad"
    table(folder / "robot.csv", robot, [session.times, *session.robot.T])
    return folder, session


def followed(path: Path, session, reach: float, sector: float = np.pi) -> np.ndarray:
    """Return how far the nearest track is from each person in reach and sector, m."""
    found = read_columns(path, dict.fromkeys(("time_s", "x_m", "y_m"), np.inf))
    gaps = []
    for time in np.arange(5.0, session.times[-1], 0.2):
        now, rows = session.at(float(time)), np.abs(found["time_s"] - time) < 0.101
        tracks = np.stack([found["x_m"], found["y_m"]], axis=-1)[rows]
        x, y = se2.act(se2.inverse(now.robot), now.positions).T
        near = (np.hypot(x, y) < reach) & (np.abs(np.arctan2(y, x)) < sector)
        for place in now.positions[near & now.present]:
            gaps.append(np.hypot(*(tracks - place).T).min(initial=np.inf))
    return np.array(gaps)


def test_people_by_detections_of_any_sensors(visit):
    """Two sensors, one of which the script has never heard of until its name joins."""
    folder, session = visit
    rng, rows = np.random.default_rng(3), []
    for sensor, every, (r_sigma, phi_sigma), misses in (
        ("laser", 0.2, (0.05, 0.03), 0.2),
        ("thermal eye", 0.5, (0.6, 0.05), 0.3),
    ):
        for time in np.arange(every, session.times[-1], every):
            now = session.at(float(time))
            there = se2.act(se2.inverse(now.robot), now.positions[now.present])
            seen = there[rng.random(len(there)) > misses]
            r = np.abs(np.hypot(*seen.T) + rng.normal(0, r_sigma, len(seen)))
            phi = np.arctan2(*seen.T[::-1]) + rng.normal(0, phi_sigma, len(seen))
            polar = zip(r, phi, strict=True) if len(seen) else [(-1, 0)]
            rows += [(time, sensor, *pair, r_sigma, phi_sigma) for pair in polar]
    names = "time_s,sensor,distance_m,direction_rad,distance_sigma_m,direction_sigma_rad"
    text = "\n".join([names, *(",".join(map(str, row)) for row in rows)])
    (folder / "seen.csv").write_text(text)
    known = (SCRIPTS / "people.py").read_text("utf-8")
    joined = known.replace(
        '    "sonar": ', '    "thermal eye": SensorRules(0.2, 4.0),\n    "sonar": '
    )
    (folder / "more.py").write_text(joined)
    said = run(folder, "more.py", "detections", "seen.csv", "run", "robot.csv")
    assert numbers(said, "readings:")[1] == 0
    gaps = followed(folder / "run.csv", session, np.inf)
    assert np.median(gaps) < 0.15
    assert np.mean(gaps < 0.5) > 0.9
    mot = np.loadtxt(folder / "run_mot.txt", delimiter=",")
    found = read_columns(folder / "run.csv", {"x_m": 1e3, "person": 1e3})
    assert mot.shape == (len(found["x_m"]), 10)
    np.testing.assert_allclose(np.sort(mot[:, 7]), np.sort(found["x_m"]), atol=1e-3)
    assert sum(1 for _ in read_video(folder / "run.mp4")) == pytest.approx(300, abs=5)


def test_people_by_their_legs(visit):
    """In the rendered scans of a laser: whoever is in front of it is followed most of the time."""
    folder, session = visit
    scans = list(readings(session, rig_with(("laser",)), rng=np.random.default_rng(4)))
    scans = [scan for scan in scans if hasattr(scan, "ranges") and len(scan.ranges) == 181]
    np.savez(
        folder / "scans.npz",
        stamp=np.array([scan.time for scan in scans]),
        ranges=np.stack([np.where(np.isfinite(s.ranges), s.ranges, 0.0) for s in scans]),
        angle_min=LASER_ANGLES[0],
        angle_increment=np.diff(LASER_ANGLES)[0],
        range_min=0.01,
        range_max=30.0,
    )
    run(folder, "people.py", "legs", "scans.npz", "legs", "robot.csv")
    gaps = followed(folder / "legs.csv", session, 3.0, 1.3)
    assert len(gaps) > 30
    assert np.median(gaps) < 0.1
    assert np.mean(gaps < 0.3) > 0.8
    lines = [  # the same as a CARMEN log, which knows the poses itself
        writing.flaser(
            np.where(np.isfinite(scan.ranges), scan.ranges, 81.91), pose, pose, scan.time
        )
        for scan in scans
        for pose in [session.at(scan.time).robot]
    ]
    writing.write(folder / "scans.log", lines)
    run(folder, "people.py", "legs", "scans.log", "log")
    gaps = followed(folder / "log.csv", session, 3.0, 1.3)
    assert np.median(gaps) < 0.1
    assert np.mean(gaps < 0.3) > 0.8


def test_people_in_a_real_hall(tmp_path):
    """Marked pairs of legs have a track on them."""
    place(tmp_path, name := "positive_1.npz")
    run(tmp_path, "people.py", "legs", name, "run")
    known = read_leg_scans(tmp_path / name)
    found = read_columns(tmp_path / "run.csv", dict.fromkeys(("time_s", "x_m", "y_m"), np.inf))
    tracks, gaps = np.stack([found["x_m"], found["y_m"]], axis=-1), []
    for k in np.unique(known.scans_of_legs):
        marked = known.legs[known.scans_of_legs == k]
        there = tracks[np.abs(found["time_s"] - known.times[k]) < 1e-3]
        for middle in marked[legs.pairs(marked)].mean(axis=1):
            gaps.append(np.hypot(*(there - middle).T).min(initial=np.inf))
    assert np.mean(np.array(gaps) < 0.3) > 0.8


@pytest.mark.parametrize("rule", ["WalkRules()", "None"])
def test_where_nobody_walks_there_is_nobody(rule, tmp_path):
    """A scanner that is driven through a room without people, the first twenty seconds."""
    with np.load(recording("leg_scans", "negative_2_left.npz")) as known:
        parts = {name: known[name] for name in known.files}
    parts |= {name: parts[name][:150] for name in ("stamp", "ranges")}
    np.savez(tmp_path / "room.npz", **parts)
    changed(tmp_path, "people.py", WALK=rule)
    said = run(tmp_path, "people.py", "legs", "room.npz", "room")
    assert 5 < numbers(said, "the scanner moves, by its scans:")[0] < 20
    rows = (tmp_path / "room.csv").read_text().splitlines()
    if rule == "None":
        assert numbers(said, "detections:")[1] > 20
        assert len(rows) > 500
    else:
        assert ", people: nobody\n" in said
        assert numbers(said, "tracks that never walked 0.8 m, left out:")[0] > 20
        assert len(rows) == 1


# A thing in a film -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "least"), [("ellipse", 0.6), ("camshift", 0.5), ("shape", 0.9)], ids=lambda x: str(x)
)
def test_track_keeps_to_what_it_is_shown(kind, least, tmp_path):
    """Overlap with the true outline, on average over two seconds; box and outline tell the same."""
    rng = np.random.default_rng(1)
    scene = coloured.HeadScene(light="steady", others=0, turns=False, tilts=False)
    film = (
        coloured.snail(rng=rng, frames=30)
        if kind == "shape"
        else coloured.head(rng=rng, frames=30, scene=scene)
    )
    write_video(tmp_path / "film.avi", film.frames, rate=15)
    table(tmp_path / "outline.csv", "u_px,v_px", [*film.outlines[0].T])
    said = run(tmp_path, "track.py", kind, "film.avi", "outline.csv", "run")
    assert numbers(said, "pictures:")[:2] == [30, 0]
    rows = np.loadtxt(tmp_path / "run_outlines.csv", delimiter=",", skiprows=1)
    shape, shares = film.frames.shape[1:3], []
    for k, truth in enumerate(film.outlines):
        both = filled(truth, shape), filled(rows[rows[:, 0] == k + 1, 1:], shape)
        shares.append((both[0] & both[1]).sum() / (both[0] | both[1]).sum())
    assert np.mean(shares) > least
    boxes = read_boxes(tmp_path / "run.csv", range(1, 31))
    low, high = (f(rows[rows[:, 0] == 30, 1:], axis=0) for f in (np.min, np.max))
    np.testing.assert_allclose(boxes.centres[-1], (low + high) / 2, atol=1)
    np.testing.assert_allclose(boxes.boxes[-1, 2:], high - low + 1, atol=1)
    *last, sure = numbers(said, "last box:")
    assert last == boxes.boxes[-1].tolist()
    told = read_columns(tmp_path / "run.csv", {"certainty": 1, "lost": 1})
    assert sure == pytest.approx(told["certainty"][-1], abs=0.006)
    assert told["certainty"].min() > 0.3
    assert len(list(read_video(tmp_path / "run.mp4"))) == 30


@pytest.mark.parametrize("box", ["10,6,20,24", "11,5,21,25", "10,6,21,24"])
def test_a_box_comes_out_as_it_went_in(box, tmp_path):
    """In the first picture, whose box is told, whether its sides are odd or even."""
    rng = np.random.default_rng(1)
    write_video(tmp_path / "film.avi", rng.integers(0, 256, (1, 48, 64, 3), np.uint8), rate=5)
    for kind in ("ellipse", "camshift", "shape"):
        said = run(tmp_path, "track.py", kind, "film.avi", box, "run", "--force")
        (found,) = read_boxes(tmp_path / "run.csv").boxes
        *last, _ = numbers(said, "last box:")  # and how sure it is
        assert found.tolist() == last == [float(k) for k in box.split(",")]


def test_what_has_slid_beside_a_real_head_is_called_lost(tmp_path):
    """Backwards from where a large box holds much of the blinds, which it keeps to."""
    folder = recording("head_girl")
    marked = read_boxes(folder / "groundtruth_rect.csv").boxes[249:99:-1]
    (tmp_path / "img").mkdir()
    for k, number in enumerate(range(250, 100, -1)):
        (tmp_path / "img" / f"{k}.jpg").symlink_to(folder / "img" / f"{number:04}.jpg")
    box = ",".join(f"{value:g}" for value in marked[0])
    told = {}
    for least in ("0.3", "0.0"):
        changed(tmp_path, "track.py", SURE=f"CertaintyRules(least={least})")
        said = run(tmp_path, "track.py", "ellipse", "img", box, "run", "--force")
        told[least] = read_columns(
            tmp_path / "run.csv", {"x": 999, "y": 999, "w": 999, "h": 999, "lost": 1}
        )
        assert numbers(said, "pictures:")[1] == told[least]["lost"].sum()
    x, y, w, h = (told["0.3"][name] for name in "xywh")
    middles = np.stack([x - 1 + w / 2, y - 1 + h / 2], axis=-1)
    inside = (middles >= marked[:, :2]) & (middles <= marked[:, :2] + marked[:, 2:])
    beside = ~inside.all(axis=1)
    assert beside.sum() > 50
    assert told["0.3"]["lost"][beside].mean() > 0.6
    assert not told["0.0"]["lost"].any()


def test_track_of_a_real_head(tmp_path):
    """The girl's head in the first forty pictures, by both trackers of heads."""
    folder = recording("head_girl")
    (tmp_path / "img").mkdir()
    for file in sorted((folder / "img").glob("*.jpg"))[:40]:
        (tmp_path / "img" / file.name).symlink_to(file)
    marked = read_boxes(folder / "groundtruth_rect.csv").boxes[:40]
    for kind in ("ellipse", "camshift"):
        run(tmp_path, "track.py", kind, "img", "56,20,31,45", "run", "--force")
        boxes = read_boxes(tmp_path / "run.csv").boxes
        low = np.maximum(boxes[:, :2], marked[:, :2])
        high = np.minimum(*((b[:, :2] + b[:, 2:]) for b in (boxes, marked)))
        both = (high - low).clip(0).prod(axis=1)
        areas = boxes[:, 2:].prod(axis=1) + marked[:, 2:].prod(axis=1)
        assert np.mean(both / (areas - both)) > 0.4


# A ceiling ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def below(tmp_path_factory):
    """A film below a ceiling, dark for three pictures at first and four on the way; the truth."""
    folder, mount = tmp_path_factory.mktemp("below"), ceiling.Mount()
    plane = ceiling.make_ceiling("varied", rng=np.random.default_rng(3), side=8.0)
    camera, step = ceiling.CeilingCamera(plane, mount), np.array([0.05, 0.0, 0.02])
    poses = [np.zeros(3)]
    while len(poses) < 36:
        poses.append(se2.compose(poses[-1], step))
    film = np.array([camera.image(pose) for pose in poses])
    film[[0, 1, 2, 20, 21, 22, 23]] = 30
    write_video(folder / "below.avi", np.repeat(film[..., None], 3, axis=-1), rate=20)
    return folder, plane, mount, np.array(poses)


@pytest.mark.parametrize("unit", ["px", pytest.param("m", marks=pytest.mark.slow)])
def test_ceiling_is_that_of_the_film(below, unit):
    """Way, patterns and picture, from the place of the first; two pixels are 25 mm.

    The first picture after the dark is less exact: its patterns were found anew, by contours.
    """
    folder, plane, mount, poses = below
    scale = mount.height / mount.focal
    if unit == "m":
        changed(folder, "ceiling.py", **{"HEIGHT, FOCAL": f"{mount.height}, {mount.focal}"})
    said = run(folder, "ceiling.py", "below.avi", unit)
    pictures, empty, blind = numbers(said, "pictures:")
    assert (pictures, empty) == (36, 3)
    assert blind == 4
    way = read_track(folder / f"{unit}.tum")
    rows = np.rint(way.times * 20).astype(int)  # by the film's own clock
    assert len(rows) == pictures - empty - blind
    assert "piece" not in said
    seen = read_columns(folder / f"{unit}_pictures.csv", {"frame": 99, "time_s": 9, "piece": 1})
    np.testing.assert_array_equal(seen["frame"], rows + 1)
    np.testing.assert_allclose(seen["time_s"], way.times)
    assert {*range(3, 20), *range(24, 36)} <= {*rows}
    factor = np.array([scale, scale, 1]) if unit == "px" else np.ones(3)
    found = se2.between(way.poses[0] * factor, way.poses * factor)
    away = found - se2.between(poses[3], poses[rows])
    assert (np.hypot(*away[:, :2].T) < np.where(rows == 24, 4, 2) * scale).all()
    assert np.abs(away[:, 2]).max() < np.deg2rad(1.5)
    length = np.hypot(*np.diff(way.poses[:, :2], axis=0).T).sum()
    assert numbers(said, "way:")[0] == pytest.approx(length, abs=0.01)
    known = read_columns(folder / f"{unit}.csv", {f"x_{unit}": np.inf, f"y_{unit}": np.inf})
    places = np.stack([*known.values()], axis=-1)
    assert not places[0].any()
    assert len(places) == numbers(said, "patterns:")[0]
    picture = np.asarray(Image.open(folder / f"{unit}.png")).astype(float)
    shown = (picture != 255).any(axis=-1) & (np.ptp(picture, axis=-1) == 0)  # nothing drawn there
    assert shown.mean() > 0.4
    u, v, step = numbers(said, "first pixel:")
    assert step == pytest.approx(scale if unit == "m" else 1.0, rel=1e-3)
    corner = np.array([u, v]) / step
    origin = se2.compose(poses[3], se2.inverse(way.poses[0] * factor))  # the mosaic's, in the world
    lens = replace(mount, size=picture.shape[1::-1], centre=tuple(-corner))
    truth = ceiling.CeilingCamera(plane, lens).image(origin)
    away = np.abs(picture[..., 0] - truth)[shown]
    assert np.median(away) < 3
    assert away.mean() < 6


def test_a_film_of_a_ceiling_that_is_cut_off_ends_with_one_line(below):
    """Wherever it is cut; and there is no scale without both numbers."""
    folder, *_ = below
    whole = (folder / "below.avi").read_bytes()
    (folder / "cut.avi").write_bytes(whole[: 2 * len(whole) // 3])
    for name, numbers_given, said in (
        ("cut", "None, None", r"cut.avi: no whole film: it was cut, \d+ bytes are missing\n$"),
        ("below", "2.5, None", "HEIGHT and FOCAL are needed both, or none\n$"),
    ):
        changed(folder, "ceiling.py", **{"HEIGHT, FOCAL": numbers_given})
        command = [sys.executable, "ceiling.py", f"{name}.avi", "none"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 1
        assert re.search(said, done.stderr)
        assert "Traceback" not in done.stderr
        assert not list(folder.glob("none*"))


@pytest.mark.slow
def test_a_map_in_pieces_is_told_and_no_pose_goes_from_one_to_the_other(tmp_path):
    """The camera is carried off in the dark: two films in one, each right in its own frame.

    As a folder of pictures of which a second each was kept.
    """
    plane = ceiling.make_ceiling("varied", rng=np.random.default_rng(3), side=8.0)
    mount, step = ceiling.Mount(), np.array([0.05, 0.0, 0.02])
    camera, poses = ceiling.CeilingCamera(plane, mount), []
    for start, count in (((-2.0, -2.0, 0.0), 8), ((1.5, 1.0, 1.0), 14)):
        poses.append(np.array(start))
        for _ in range(count - 1):
            poses.append(se2.compose(poses[-1], step))
    (tmp_path / "film").mkdir()
    for k, pose in enumerate(poses[:8] + [None] * 6 + poses[8:]):
        dark = np.full(mount.size[::-1], 30, np.uint8)
        image = Image.fromarray(dark if pose is None else camera.image(pose))
        image.save(tmp_path / "film" / f"{2 * k + 10}.png")
    (tmp_path / "film" / "notes.txt").write_text("not a picture")
    changed(tmp_path, "ceiling.py", **{"HEIGHT, FOCAL": f"{mount.height}, {mount.focal}"})
    said = run(tmp_path, "ceiling.py", "film", "out")
    assert "files that are skipped: 1 (notes.txt)\n" in said
    assert "the mosaic is in 2 pieces: where one lies from another is not known\n" in said
    assert numbers(said, "piece 1: pictures")[:2] == [10, 24]
    first, last = numbers(said, "piece 2, drawn: pictures")[:2]
    assert (first, last) == (pytest.approx(39, abs=2), 64)  # in the first ones it is made
    names = {"frame": 99, "time_s": 9, "piece": 2, "x_m": 9, "y_m": 9, "heading_rad": 7}
    seen = read_columns(tmp_path / "out_pictures.csv", names)
    rows = ((seen["frame"] - 10) / 2).astype(int)
    np.testing.assert_allclose(seen["time_s"], 2 * rows / 30)
    found = np.stack([seen[name] for name in ("x_m", "y_m", "heading_rad")], axis=-1)
    truth = np.array([*poses[:8], *[np.zeros(3)] * 6, *poses[8:]])[rows]
    for piece in (1, 2):
        own = seen["piece"] == piece
        away = se2.between(found[own][0], found[own]) - se2.between(truth[own][0], truth[own])
        assert np.hypot(*away[:, :2].T).max() < 0.03
    way = read_track(tmp_path / "out.tum")
    np.testing.assert_allclose(way.poses, found[seen["piece"] == 2], atol=1e-6)
    patterns = read_columns(tmp_path / "out.csv", {"piece": 2, "x_m": 9, "y_m": 9})
    for piece in (1, 2):
        own = np.flatnonzero(patterns["piece"] == piece)
        assert patterns["x_m"][own[0]] == patterns["y_m"][own[0]] == 0
    width = np.asarray(Image.open(tmp_path / "out.png")).shape[1] * mount.height / mount.focal
    assert width < 5  # of the drawn piece alone


# Faces -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def visitors(tmp_path_factory):
    """A gallery of two people, by pictures of many days, and a film of both; the truth of it."""
    folder = tmp_path_factory.mktemp("visitors")
    people = [make_identity(np.random.default_rng(40 + k), tone=k) for k in range(2)]
    for name, who in zip(("ann", "bob"), people, strict=True):
        (folder / "gallery" / name).mkdir(parents=True)
        for k in range(14):  # as on other days
            scene = FaceScene(glances=0.0, light="changing")
            alone = film_faces(np.random.default_rng(k), 1, scene, (who,))
            Image.fromarray(alone.frames[0]).save(folder / "gallery" / name / f"{k}.png")
    Image.new("RGB", (60, 60)).save(folder / "gallery" / "bob" / "dark.png")
    (folder / "gallery" / "bob" / "notes.txt").write_text("of Tuesday")
    (folder / "gallery" / "read me.txt").write_text("all have agreed")
    both = film_faces(np.random.default_rng(2), 20, FaceScene(2, glances=0.0), tuple(people))
    write_video(folder / "both.avi", both.frames, rate=12)
    write_video(folder / "empty.avi", np.full((3, 60, 80, 3), 90, np.uint8), rate=10)
    return folder, both


def test_faces_are_where_they_are_and_most_are_named_rightly(visitors):
    folder, both = visitors
    said = run(folder, "faces.py", "gallery", "both.avi", "out")
    people, pictures, faceless, others = numbers(said, "gallery:")
    assert (people, faceless, others) == (2, 1, 2)
    assert pictures >= 20
    lines = [line.split(",") for line in (folder / "out.csv").read_text().splitlines()]
    assert lines[0] == ["frame", "time_s", "x", "y", "w", "h", "name", "distance"]
    assert len(lines) - 1 == numbers(said, "pictures:")[1] >= 20
    right = near = 0
    for frame, time, x, y, w, h, name, _ in lines[1:]:
        assert float(time) == pytest.approx((int(frame) - 1) / 12, abs=0.002)
        box = np.array([float(x) - 1, float(y) - 1, float(w), float(h)])
        same = overlap(box[None], both.boxes[int(frame) - 1])[0]
        near += same.max() > 0.4
        right += name == ("ann", "bob")[same.argmax()]
    assert near >= 0.9 * (len(lines) - 1)
    assert right >= 0.6 * (len(lines) - 1)
    film = read_video(folder / "out.mp4")
    assert film.rate == pytest.approx(12)
    assert sum(1 for _ in film) == 20


def test_a_film_without_faces_has_a_file_without_lines(visitors):
    folder, _ = visitors
    said = run(folder, "faces.py", "gallery", "empty.avi", "none")
    assert numbers(said, "pictures:") == [3, 0]
    assert (folder / "none.csv").read_text() == "frame,time_s,x,y,w,h,name,distance\n"


@pytest.mark.parametrize("name", ["Smith, Ann", "王 小明", "=1+1", "José", "  a'b\"c"])
def test_two_pictures_of_one_person_of_any_name_are_enough(visitors, name, tmp_path, monkeypatch):
    """The name in the table is that of the folder, on a console that lacks its letters, too."""
    folder, _ = visitors
    (tmp_path / "people" / name).mkdir(parents=True)
    (tmp_path / "people" / ".cache").mkdir()
    (tmp_path / "film").mkdir()
    for k in range(2):
        picture = Image.open(folder / "gallery" / "ann" / f"{k}.png")
        picture.save(tmp_path / "people" / name / f"{k}.bmp")
        picture.save(tmp_path / "film" / f"{k + 5}.webp", lossless=True)
    (tmp_path / "people" / name / "._0.bmp").write_bytes(b"what macOS leaves")
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    said = run(tmp_path, "faces.py", "people", "film", "out")
    assert numbers(said, "gallery:") == [1, 2, 0, 2]
    found = read_columns(tmp_path / "out.csv", {"frame": 9, "time_s": 9}, texts=("name",))
    assert list(found["name"]) == [name.strip()] * 2
    assert list(found["frame"]) == [5, 6]
    assert numbers(said, "1 ")[-1] == 2


# Arms --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pointing(tmp_path_factory):
    """A rendered person who points, dark for three pictures at first; the truth."""
    folder = tmp_path_factory.mktemp("pointing")
    shown = film_arms(np.random.default_rng(106), 20, ArmScene("pointing"))
    dark = np.zeros_like(shown.frames[:3])
    write_video(folder / "arms.avi", np.concatenate([dark, shown.frames]), rate=24)
    (folder / "arms").mkdir()
    for k, frame in enumerate(shown.frames):
        Image.fromarray(frame).save(folder / "arms" / f"{k}.png")
    return folder, shown


def wrists(path: Path, shown) -> tuple[np.ndarray, np.ndarray]:
    """Return the frames of a table of angles, and how far both wrists are from the truth, px."""
    lines = [line.split(",") for line in path.read_text().splitlines()]
    assert lines[0][:6] == [
        "frame", "time_s", "left_sideways_deg", "left_ahead_deg", "left_about_deg",
        "left_elbow_deg",
    ]  # fmt: skip
    assert len(lines[0]) == 19
    rows = np.array(lines[1:], dtype=float)
    camera = Pinhole((320.0, 320.0), (159.5, 119.5), (320, 240))
    model = BodyModel.from_face(shown.face, camera)
    found = model.pixels(model.joints(np.radians(rows[:, 2:10]))[:, :, 2])
    truth = shown.stage.pixels(shown.joints[:, :, 2])
    return rows[:, 0].astype(int), np.linalg.norm(found - truth[-len(rows) :], axis=-1)


def test_arms_are_where_they_are_from_the_first_face_on(pointing):
    """Both wrists by the angles that are written; the film begins black, and has its own rate."""
    folder, shown = pointing
    said = run(folder, "arms.py", "arms.avi", "0.29,0.25,0.17", "rest", "out")
    assert numbers(said, "pictures:") == [23, 3, 0]
    frames, off = wrists(folder / "out.csv", shown)
    assert frames.tolist() == list(range(4, 24))
    assert np.median(off) < 12
    film = read_video(folder / "out.mp4")
    assert film.rate == pytest.approx(24)
    assert sum(1 for _ in film) == 23


def test_a_face_that_is_given_is_taken(pointing):
    """In a folder of pictures, from the first one on."""
    folder, shown = pointing
    square = ",".join(f"{value:.1f}" for value in shown.face)
    words = "arms.py", "arms", "0.29,0.25,0.17", "rest", "told", "--face", square
    assert numbers(run(folder, *words), "pictures:") == [20, 0, 0]
    frames, off = wrists(folder / "told.csv", shown)
    assert frames.tolist() == list(range(20))
    assert np.median(off) < 12


# A tutor and his orders --------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ordering(tmp_path_factory):
    """Somebody comes, raises a hand, steps aside, and raises it again; a robot that stands there.

    As a folder of pictures and as a film with each picture twice, twenty in a second.
    """
    folder, rng = tmp_path_factory.mktemp("ordering"), np.random.default_rng(3)
    hall, who, sights = make_hall(rng), make_visitor(rng), []
    for k in range(76):
        up = np.clip((min(k - 19, 37 - k) if k < 44 else k - 61) / 5, 0, 1)
        there = Stance(6.1, 5.0 + 0.025 * min(max(k - 40, 0), 20), raised=float(up))
        people = [(who, there)] if k >= 5 else []
        sights.append(see(hall, CAMERA, np.array([4.0, 5.0, 0.0]), people, rng=rng))
    (folder / "pictures").mkdir()
    for k, sight in enumerate(sights):
        Image.fromarray(sight.image).save(folder / "pictures" / f"{k}.png")
    write_video(folder / "film.avi", np.repeat([s.image for s in sights], 2, axis=0), rate=20)
    return folder, sights, who


def test_a_robot_on_a_film_does_what_that_of_the_chapter_does(ordering):
    """Its states exactly, on the same pictures; and its places are those of the person."""
    folder, sights, _ = ordering
    said = run(folder, "following.py", "pictures", "out")
    robot = replace(
        tutor_following.companion("told whose face", None),
        faces=FaceDetector(scale=1.05, neighbours=2),
        face_tracking=None,
        recognise=lambda grey, box: "tutor",
    )
    state, rng, states = robot.start(), np.random.default_rng(0), []
    for sight in sights:
        state, _ = robot.step(state, sight.image, rng=rng)
        states.append(state.name)
    names = dict.fromkeys(("frame", "x", "y", "w", "h", "hands"), 1e3) | {"time_s": 1e3}
    found = read_columns(folder / "out.csv", names, texts=("state", "event", "name"))
    assert list(found["state"]) == states
    assert [*dict.fromkeys(states)] == ["wait", "identify", "idle", "follow", "halt"]
    events = [event for event in found["event"] if event != "none"]
    assert events == ["face", "tutor", "hand above", "open hand"]
    np.testing.assert_allclose(found["time_s"], np.arange(76) / 10)
    boxes = np.stack([found[name] for name in "xywh"], axis=-1) - [1, 1, 0, 0]
    for k, sight in enumerate(sights):
        if states[k] == "follow":
            assert overlap(boxes[k : k + 1], sight.boxes)[0, 0] > 0.5
        elif found["name"][k] == "tutor":
            assert overlap(boxes[k : k + 1], sight.faces)[0, 0] > 0.4
        else:
            assert found["name"][k] == "?"
            assert not boxes[k, 2:].any()
    up = np.array([len(s.hands) > 0 and np.isfinite(s.hands[0, 0]) for s in sights])
    assert found["hands"][~up].sum() == 0
    assert numbers(said, "pictures:") == [76, 76]
    counts = ", ".join(f"{name}: {states.count(name)}" for name in paper_table().states)
    assert f"states: {counts}\n" in said


@pytest.mark.slow
def test_of_a_faster_film_so_many_pictures_are_used_as_events_count(ordering):
    """By names of a gallery, one of them with a comma."""
    folder, _, who = ordering
    rng = np.random.default_rng(8)
    for name, somebody in (("Lee, Kim", who), ("bob", make_visitor(rng))):
        (folder / "tutors" / name).mkdir(parents=True)
        hall = make_hall(rng)
        for k in range(12):
            portrait = Image.fromarray(tutor_following.portrait(somebody, hall, rng).image)
            portrait.save(folder / "tutors" / name / f"{k}.png")
    said = run(folder, "following.py", "film.avi", "fast", "--gallery", "tutors")
    assert numbers(said, "pictures:") == [152, 76]
    found = read_columns(folder / "fast.csv", {"frame": 999}, texts=("state", "name"))
    assert list(found["frame"]) == list(range(1, 152, 2))
    assert {*found["name"]} <= {"?", "Lee, Kim"}
    assert {"idle", "follow"} <= {*found["state"]}
    film = read_video(folder / "fast.mp4")
    assert film.rate == pytest.approx(10)
    assert sum(1 for _ in film) == 76


@pytest.mark.slow
def test_who_is_too_near_to_be_seen_whole_is_not_followed(ordering):
    """Of the pictures only the upper part, with face and hand: the robot stays where it is."""
    folder, sights, _ = ordering
    (folder / "near").mkdir()
    for k, sight in enumerate(sights[:40]):
        Image.fromarray(sight.image[:120]).save(folder / "near" / f"{k}.png")
    said = run(folder, "following.py", "near", "near")
    assert numbers(said, "states:")[2:4] == [pytest.approx(31, abs=2), 0]


# Bad input ---------------------------------------------------------------------------------------

SEEN = "time_s,sensor,distance_m,direction_rad,distance_sigma_m,direction_sigma_rad"
FILES = EXAMPLES | {
    "degrees.csv": "time_s,landmark,range_m,bearing_rad\n0.5,3,3.6,16\n",
    "half.csv": "time_s,landmark,range_m,bearing_rad\n0.5,3.5,3.6,0.1\n",
    "early.csv": "time_s,landmark,range_m,bearing_rad\n-0.5,3,3.6,0.1\n",
    "nought.csv": "time_s,landmark,range_m,bearing_rad\n0.5,3,0,0\n",
    "beams.log": "FLASER 3 1 2 3 0 0 0 0 0 0 1 host 1\n",
    "twice.csv": "time_s,landmark,range_m,bearing_rad\n0.5,3,3.6,0.1\n0.5,3,3.6,0.1\n",
    "hole.csv": "time_s,landmark,range_m,bearing_rad\n0.5,3,nan,0.1\n",
    "falling.csv": "time_s,speed_m_s,turn_rate_rad_s\n1,1,0\n0,1,0\n",
    "mm.csv": "2000,2001,2002\n",
    "one.csv": "2,2.1,2.2\n",
    "still.tum": "".join(f"{k} 1 2 3 0 0 0 1\n" for k in range(3)),
    "later.tum": "".join(f"{k}.5 1 2 3 0 0 0 1\n" for k in range(3)),
    "two.txt": 2 * "1 0 0 0 0 1 0 0 0 0 1 0\n",
    "later.csv": "time_s,x_m,y_m,heading_rad\n100,0,0,0\n101,1,0,0\n",
    "sure.csv": f"{SEEN}\n1,laser,2,0.1,0,0\n",
    "radar.csv": f"{SEEN}\n1,radar,2,0.1,0.1,0.1\n",
    "nameless.csv": f"{SEEN}\n1,,2,0.1,0.1,0.1\n",
    "turned.csv": f"{SEEN}\n1,laser,2,90,0.1,0.1\n",
    "here.csv": f"{SEEN}\n1,laser,2,0.1,0.1,0.1\n",
    "flat.csv": "u_px,v_px\n1,1\n2,2\n3,3\n",
    "calib.txt": "9 0 8 0 0 9 8 0 0 0 1 0\n9 0 8 1 0 9 8 0 0 0 1 0\n",
}


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("ekf_slam.py", "points"),
        ("ekf_slam.py sonar commands.csv observations.csv d", "polar"),
        ("ekf_slam.py polar none.csv observations.csv d", "none.csv: no such file or folder"),
        ("ekf_slam.py points commands.csv observations.csv d", "observations.csv, .* column x_m"),
        ("ekf_slam.py polar commands.csv truth.csv d", "truth.csv, line 1: no column range_m"),
        ("ekf_slam.py polar commands.csv degrees.csv d", "line 2: bearing_rad is '16', beyond 7"),
        ("ekf_slam.py polar commands.csv half.csv d", "line 2: landmark is '3.5', not a whole"),
        ("ekf_slam.py polar commands.csv hole.csv d", "line 2: range_m is 'nan', not a finite"),
        ("ekf_slam.py polar commands.csv early.csv d", "no time in common: .* early.csv at -0.5"),
        (
            "ekf_slam.py polar commands.csv twice.csv d",
            r"twice\.csv, line \d: landmark 3: at",
        ),
        (
            "ekf_slam.py polar commands.csv nought.csv d",
            "nought.csv, line 2: range_m must",
        ),
        ("ekf_slam.py polar falling.csv observations.csv d", "falling.csv, line 3: times must not"),
        ("ekf_slam.py polar commands.csv observations.csv no/d", "no is no folder"),
        ("walls.py array mm.csv poses.csv w.csv", "no reading is below 80 m; are they in metres"),
        ("walls.py array one.csv poses.csv w.csv", "have a pose for each scan, got 1 and 2"),
        ("walls.py array one.csv none.csv w.csv", "none.csv: no such file or folder"),
        ("walls.py carmen one.csv w.csv", "one.csv, line 1: does not begin with a keyword"),
        (
            "walls.py carmen beams.log w.csv",
            r"beams\.log, line 1: no field of view is known for \d+ beams: --field first,last in",
        ),
        (
            "walls.py carmen beams.log w.csv --field 9",
            "'--field': 9: not two angles in degrees",
        ),
        (
            "walls.py carmen beams.log w.csv --field 0,400",
            "'--field': 0,400: an angle beyond",
        ),
        ("walls.py graph none.log w.csv", "none.log: no such file or folder"),
        ("walls.py graph", "Missing argument 'FILES...'"),
        ("rank.py", "distances"),
        ("rank.py landmarks gps", "'gps' is not one of 'landmarks', 'anchor'"),
        ("judge.py commands.csv truth.csv", "commands.csv, line 1: no column x_m"),
        (
            "judge.py later.csv truth.csv",
            "no time in common: later.csv from 100.000 to 101.000 s and truth.csv from 0.000",
        ),
        ("judge.py truth.csv truth.csv --align se3", "truth.csv is in the plane: --align and"),
        ("judge.py still.tum still.tum --align se3", "do not determine a rotation"),
        ("judge.py still.tum later.tum", "no pose of still.tum is at the time of one of later.tum"),
        ("judge.py two.txt still.tum", "two.txt has 2 poses and still.tum 3"),
        ("judge.py truth.csv none.csv", "none.csv: no such file or folder"),
        ("judge.py truth.csv", "Missing argument 'TRUTH'"),
        ("stereo_slam.py .", "Missing argument 'OUT'"),
        ("stereo_slam.py none out", "none: no such file or folder"),
        ("stereo_slam.py . out", "calib.txt: the matrices are not those of a rectified pair"),
        ("stereo_slam.py half out", "image_l: there is no such folder"),
        ("stereo_slam.py alone out", "image_l: 1 pictures of left have no partner: 1"),
        ("stereo_slam.py grey out --baseline 0.1", "--baseline is for a BAG; grey has a"),
        ("stereo_slam.py grey out", "left and right have 0 matches by descriptor"),
        ("people.py here.csv out", "'here.csv' is not one of 'detections', 'legs'"),
        ("people.py sonar here.csv out", "'sonar' is not one of"),
        ("people.py detections none.csv out", "none.csv: no such file or folder"),
        ("people.py detections commands.csv out", "line 1: no column distance_m and"),
        ("people.py detections radar.csv out", "radar.csv, line 2: sensor is 'radar', none of"),
        (
            "people.py detections sure.csv out",
            "sure.csv, line 2: distance_sigma_m must be",
        ),
        ("people.py detections nameless.csv out", "nameless.csv, line 2: sensor is empty"),
        ("people.py detections turned.csv out", "direction_rad is '90', beyond 7: is the unit"),
        (
            "people.py detections here.csv out later.csv",
            "no time in common: here.csv at 1.000 s and later.csv",
        ),
        (
            "people.py detections here.csv no/out",
            "no is no folder: cannot write no/out\\.\\w+ there",
        ),
        ("people.py legs none.npz out", "none.npz: no such file or folder"),
        ("people.py legs here.csv out", "here.csv, line 1: "),
        ("track.py ellipse film.avi 1,2,3,4", "Missing argument 'OUT'"),
        ("track.py head film.avi 1,2,3,4 out", "'head' is not one of 'ellipse'"),
        ("track.py ellipse none.avi 1,2,3,4 out", "none.avi: no such file or folder"),
        ("track.py ellipse here.csv 1,2,3,4 out", "here.csv: no film, or a damaged one: a text"),
        ("track.py ellipse grey 1,2,3,4 out", "grey: no file is a picture"),
        (
            "track.py ellipse film.avi 1,2,3 out",
            "'BOX': must be u,v,width,height or a file, got '1,2,3'",
        ),
        ("track.py shape film.avi 1,2,0,4 out", "BOX must have an area, got 0 by 4 px"),
        ("track.py shape film.avi flat.csv out", "outline"),
        (
            "track.py ellipse film.avi 900,900,9,9 out",
            "BOX must reach into the picture of 40 by 30 px",
        ),
        ("track.py camshift film.avi 9,9,9,9 no/out", "no is no folder: cannot write no/out.csv"),
        (
            "ceiling.py film.avi",
            "Missing argument 'OUT'",
        ),
        ("ceiling.py none.avi out", "none.avi: no such file or folder"),
        ("ceiling.py here.csv out", "here.csv: no film, or a damaged one: a text"),
        ("ceiling.py film.avi out", "film.avi: no picture has a distinctive window, as of a blank"),
        ("ceiling.py film.avi no/out", "no is no folder: cannot write no/out\\.\\w+ there"),
        ("arms.py film.avi 0.3,0.2,0.2", "Missing argument 'POSE'"),
        ("arms.py film.avi 0.3,0.2 rest out", "'LENGTHS': must be upper,fore,hand, got '0.3,0.2'"),
        (
            "arms.py film.avi 0.3,0.2,0.2 1,2 out",
            "'POSE': must be (sideways,ahead,about,elbow,?){2} or rest, got '1,2'",
        ),
        ("arms.py film.avi 0.3,0.2,a rest out", "'LENGTHS': must be upper,fore,hand"),
        ("arms.py none.avi 0.3,0.2,0.2 rest out", "none.avi: no such file or folder"),
        ("arms.py film.avi 0.3,0.2,0.2 rest out", "no picture shows a face; --face u,v,width,heig"),
        ("arms.py grey 0.3,0.2,0.2 rest out", "grey: no file is a picture"),
        ("arms.py film.avi 29,25,17 rest out", "LENGTHS must be from 0.02 to 1 m, got 29,25,17"),
        ("arms.py film.avi 0.3,0.2,-0.2 rest out", "LENGTHS must be from 0.02 to 1 m"),
        (
            "arms.py film.avi 0.3,0.2,0.2 999,0,0,0,0,0,0,0 out",
            "POSE must be, in degrees, -11 to 149, -23 to 86, -23 to 172, 0 to 143 for each arm",
        ),
        ("arms.py film.avi 0.3,0.2,0.2 rest out --face 1,2", "'--face': must be u,v,width,hei"),
        ("arms.py film.avi 0.3,0.2,0.2 rest out --face 30,2,20,20", "--face must lie in the pict"),
        ("arms.py film.avi 0.3,0.2,0.2 rest out --face 3,2,0,20", "--face must lie in the picture"),
        ("faces.py film.avi out", "out: no such file or folder"),
        ("faces.py none film.avi out", "none: no such file or folder"),
        ("faces.py grey/image_l film.avi out", "the gallery needs a folder for each person"),
        ("faces.py half film.avi out", "with a face each at least, got 0 of 1 of 'image_r'"),
        ("faces.py calib.txt film.avi out", "calib.txt: there is no such folder"),
        ("faces.py odd film.avi out", r"odd: 'a\\nb' is no name that can be written"),
        ("faces.py nobody film.avi out", r"nobody: '\?' stands for nobody; NOBODY may be another"),
        ("faces.py bare film.avi out", "bare/ann: no file is a picture"),
        ("following.py film.avi", "Missing argument 'OUT'"),
        ("following.py none.avi out", "none.avi: no such file or folder"),
        ("following.py here.csv out", "here.csv: no film, or a damaged one: a text"),
        ("following.py grey out", "grey: no file is a picture"),
        ("following.py film.avi out --gallery none", "none: no such file or folder"),
        ("following.py film.avi out --gallery half", "got 0 of 1 of 'image_r'"),
        ("following.py film.avi no/out", "no is no folder: cannot write no/out\\.\\w+ there"),
    ],
)
def test_bad_input_ends_with_one_line(command, message, tmp_path, monkeypatch, capsys):
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    for folder, left, right in (("half", 0, 1), ("alone", 2, 1), ("grey", 1, 1)):
        (tmp_path / folder).mkdir()
        matrices = "9 0 8 0 0 9 8 0 0 0 1 0\n9 0 8 -1 0 9 8 0 0 0 1 0\n"
        (tmp_path / folder / "calib.txt").write_text(matrices)
        for side, count in (("image_l", left), ("image_r", right)):
            for k in range(count):
                (tmp_path / folder / side).mkdir(exist_ok=True)
                Image.new("L", (40, 30), 90).save(tmp_path / folder / side / f"{k}.png")
    for name in ("odd/a\nb", "nobody/?", "bare/ann"):
        (tmp_path / name).mkdir(parents=True)
        Image.new("L", (40, 30)).save(
            tmp_path / name / (".1.png" if name == "bare/ann" else "1.png")
        )
    write_video(tmp_path / "film.avi", np.full((3, 30, 40, 3), 90, np.uint8), rate=5)
    monkeypatch.chdir(tmp_path)
    script, *words = command.split()
    monkeypatch.setattr(sys, "argv", [script, *words])
    with unchecked(), pytest.raises(SystemExit) as end:
        runpy.run_path(str(SCRIPTS / script), run_name="__main__")
    said = capsys.readouterr().err.splitlines()
    assert re.search(message, said[-1])
    assert end.value.code == (2 if said[0].startswith("Usage: ") else 1)
    assert not list(tmp_path.glob("**/*out*"))


RATES = ["0", "-1", "nan", "'10'", "None", "1e9"]
CONSTANTS = {  # of the scripts on films, what each cannot be
    ("arms.py", "FOCAL"): ["0", "-1.0", "'1'", "400.0", "None"],
    ("arms.py", "RATE"): RATES,
    ("arms.py", "RULES"): ["None", "400"],
    ("arms.py", "SEED"): ["-1", "1.5", "None"],
    ("ceiling.py", "HEIGHT, FOCAL"): [
        "0, 300", "-2.5, 300", "2.5, 0", "2.5, -300", "2.5, '300'", "'2.5', 300", "2500, 300",
        "2.5, 4", "None, 300", "2.5, None", "nan, 300", "2.5, nan",
    ],
    ("ceiling.py", "CENTRE"): ["(1,)", "'1, 2'", "(nan, 2)", "5"],
    ("ceiling.py", "CORRECTION"): ["3", "'none'"],
    ("ceiling.py", "WIDE"): ["0", "-320", "320.0", "'320'", "1_000_000"],
    ("ceiling.py", "EVERY"): ["0", "-1", "1.5", "None"],
    ("ceiling.py", "RATE"): RATES,
    ("ceiling.py", "RULES"): ["None"],
    ("ceiling.py", "SEED"): ["-1", "'1'"],
    ("faces.py", "RATE"): RATES,
    ("faces.py", "DETECTOR"): ["None"],
    ("faces.py", "COUNT"): ["0", "-1", "2.5"],
    ("faces.py", "ACCEPTED"): ["2", "-0.1", "95", "None"],
    ("faces.py", "EVEN"): ["1", "None"],
    ("faces.py", "NOBODY"): ["None", "3"],
    ("following.py", "PACE"): RATES,
    ("following.py", "RATE"): RATES,
    ("following.py", "WIDE"): ["0", "-640", "640.0", "1_000_000"],
    ("following.py", "FACES"): ["None"],
    ("following.py", "HANDS"): ["None"],
    ("following.py", "INTERACTION"): ["None"],
    ("following.py", "RULES"): ["None", "3"],
    ("following.py", "ACCEPTED"): ["2", "-0.1", "None"],
    ("following.py", "ANYBODY, NOBODY"): ["3, '?'", "'tutor', None"],
    ("following.py", "SEED"): ["-1", "1.5"],
    ("track.py", "RATE"): RATES,
}  # fmt: skip
WORDS = {
    "arms.py": "film.avi 0.3,0.2,0.2 rest out",
    "ceiling.py": "film.avi out",
    "faces.py": "people film.avi out",
    "following.py": "film.avi out",
    "track.py": "camshift film.avi 9,9,9,9 out",
}


@pytest.mark.parametrize(("script", "name"), CONSTANTS, ids=lambda word: word)
def test_a_constant_that_cannot_be_is_named_before_anything_is_computed(
    script, name, tmp_path, monkeypatch, capsys
):
    """As an error of one line. The film and the gallery are good enough to be opened."""
    write_video(tmp_path / "film.avi", np.full((3, 30, 40, 3), 90, np.uint8), rate=5)
    (tmp_path / "people" / "ann").mkdir(parents=True)
    Image.new("L", (40, 30), 90).save(tmp_path / "people" / "ann" / "1.png")
    monkeypatch.chdir(tmp_path)
    for value in CONSTANTS[script, name]:
        changed(tmp_path, script, **{name: value.replace("nan", "float('nan')")})
        monkeypatch.setattr(sys, "argv", [script, *WORDS[script].split()])
        with unchecked(), pytest.raises(SystemExit) as end:
            runpy.run_path(str(tmp_path / script), run_name="__main__")
        said = capsys.readouterr().err
        assert end.value.code == 1
        assert re.fullmatch(rf"Error: ({'|'.join(name.split(', '))}) .*must .*\n|Error: HEIGHT and"
                            r" FOCAL are needed both, or none\n", said), (value, said)  # fmt: skip
        assert not list(tmp_path.glob("out*"))


def test_bad_input_shows_no_traceback(tmp_path):
    command = [sys.executable, SCRIPTS / "judge.py", "none.csv", "none.csv"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.endswith("none.csv: no such file or folder\n")
    assert "Traceback" not in done.stderr
