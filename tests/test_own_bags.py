"""The scripts of "Your own data" on ROS bags: they give what they give on plain files."""

import re
import runpy
from contextlib import chdir
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from PIL import Image

from data_synth import ceiling, laser, stereo, textured_building
from data_synth.arms.gestures import ArmScene, film_arms
from data_synth.companion.face_films import FaceScene, film_faces
from data_synth.companion.faces import make_identity
from data_synth.companion.hall import make_hall
from data_synth.companion.visits import Stance, make_visitor, see
from robot_perception.chapters.tutor_following.scene import CAMERA
from robot_perception.datasets import read_video, write_columns, write_tum
from robot_perception.geometry import se2, se3
from tests.datasets import bags, writing
from tests.test_own_data import SCRIPTS, changed
from tests.unchecked import unchecked

START = bags.START / 1e9  # s: bags count from 1970
CORNERS = np.array([[-2.0, -1.5], [4.0, -1.5], [4.0, 2.5], [-2.0, 2.5]])
NAMES = ("drive.bag", "sqlite", "mcap")
BEAMS = np.deg2rad([-90.0, 0.5])  # the first, and the step
SIZE = 361


def play(folder: Path, script: str, *words: str, code: int = 0) -> str:
    """Run a script in a folder, one of the page or a copy there, and return what it prints.

    Without the last line, which names the files that it has written.
    """
    own = folder / script
    with unchecked(), chdir(folder):
        main = runpy.run_path(str(own if own.exists() else SCRIPTS / script))["main"]
        done = CliRunner().invoke(main, words)
    assert done.exit_code == code, done.output
    return re.sub(r"written: .*\n\Z", "", done.stdout) if code == 0 else done.output


def numbers(path: Path, skip: int = 1, **how) -> np.ndarray:
    return np.loadtxt(path, skiprows=skip, ndmin=2, **how)


def table(path: Path, times: np.ndarray, **columns: np.ndarray) -> Path:
    write_columns(path, {"time_s": times, **columns})
    return path


def same(folder: Path, plain: str, bag: str, *, times: bool = True, skip: int = 1, **how) -> None:
    """Compare two results, whose first column may be times on two clocks."""
    how = {"delimiter": ","} | how
    a, b = (numbers(folder / name, skip, **how) for name in (plain, bag))
    assert a.shape == b.shape
    assert len(a)
    a[:, 0] += START * times
    np.testing.assert_allclose(a, b, rtol=1e-5, atol=2e-5)


def before(ranges: np.ndarray, poses: np.ndarray, legs: np.ndarray) -> np.ndarray:
    """Return scans in which legs, discs of 5 cm, stand before whatever was seen."""
    angles = BEAMS[0] + BEAMS[1] * np.arange(SIZE)
    for leg in legs:
        x, y = se2.act(se2.inverse(poses), leg[None])[:, 0].T
        across = np.abs(np.hypot(x, y)[:, None] * np.sin(angles - np.arctan2(y, x)[:, None]))
        ahead = np.hypot(x, y)[:, None] * np.cos(angles - np.arctan2(y, x)[:, None])
        hit = (across < 0.05) & (ahead > 0)
        half = np.sqrt(np.maximum(0.05**2 - across**2, 0))
        ranges = np.where(hit, np.minimum(ranges, ahead - half), ranges)
    return ranges


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    """A room, scanned by a robot that drives: a CARMEN log, and what else a robot would record."""
    folder = tmp_path_factory.mktemp("room")
    faces = np.stack([CORNERS, np.roll(CORNERS, -1, axis=0)], axis=1)
    k = np.arange(24)
    poses = np.round(np.stack([-1 + k / 8, 0.3 * np.sin(k), 0.1 * k - 1], axis=1), 9)
    scanner = laser.Scanner(max_range=5.0)
    ranges = laser.scan(faces, poses, scanner, rng=np.random.default_rng(1)).ranges
    ranges = before(ranges, poses, np.array([[2.5, 0.5], [2.5, 0.75]]))
    ranges = ranges.astype(np.float32).astype(float)
    logged = np.where(np.isinf(ranges), 81.91, ranges)
    rows = zip(logged, poses, poses, (0.25 * k).tolist(), strict=True)
    writing.write(folder / "room.log", [writing.flaser(*row) for row in rows])
    said = [
        one
        for time, pose, scan in zip(0.25 * k, poses, ranges, strict=True)
        for one in (
            bags.odometry(time, se3.from_se2(pose)),
            bags.scan(time, scan, angles=BEAMS, range_min=0.01, range_max=30.0),
        )
    ]
    said.append(bags.scan(0, [1.0], topic="/rear"))
    for name in NAMES:
        on_it = bags.transform(
            0, "base_link", "laser", np.eye(4), ros=1 if name.endswith(".bag") else 2
        )
        bags.write_bag(folder / name, [*said, on_it])
    return folder


@pytest.mark.parametrize("name", NAMES)
def test_walls(room, name):
    plain = play(room, "walls.py", "carmen", "room.log", "plain.csv", "--force")
    topics = ["--topic", "/scan", "--topic", "/odom"]
    said = play(room, "walls.py", "bag", name, "bag.csv", "--force", *topics)
    assert said == plain
    same(room, "plain.csv", "bag.csv", times=False)


@pytest.mark.parametrize("name", NAMES)
def test_people_by_their_legs(room, name):
    changed(room, "people.py", WALK="None")  # the legs stand
    plain = play(room, "people.py", "legs", "room.log", "plain", "--force")
    topics = ["--topic", "/scan", "--topic", "/odom"]
    said = play(room, "people.py", "legs", name, "bag", "--force", *topics)
    assert said == plain
    same(room, "plain.csv", "bag.csv")
    way = play(room, "people.py", "legs", name, "way", name, "--force", *topics)
    assert way == plain


def test_what_is_wrong_with_a_bag_ends_with_one_line_and_what_is_left_out_is_told(room, tmp_path):
    said = play(room, "walls.py", "bag", "mcap", str(tmp_path / "a.csv"), code=1)
    assert (
        "2 topics hold scans: /rear (LaserScan, 1 message), /scan (LaserScan, 24 messages);"
        " say which" in said
    )
    assert len(said.splitlines()) == 1
    wall, legs = np.full((3, SIZE), 3.0), np.array([[1.5, 0.1], [1.5, -0.15]])
    seen = before(wall, np.zeros((3, 3)), legs)
    still = [bags.scan(0.1 * k, seen[k], angles=BEAMS) for k in range(3)]
    bags.write_bag(tmp_path / "still.bag", [*still, bags.scan(9, [1.0])])
    said = play(tmp_path, "people.py", "legs", "still.bag", "out")
    assert said.startswith(
        "scans of /scan\n/scan: 1 scans skipped, with beams of another step\n"
        "the bag holds neither poses nor speeds: the robot is taken to stand still\nreadings: 3, "
    )


@pytest.mark.parametrize("name", NAMES)
def test_ekf_slam_and_judge(name, tmp_path):
    """The commands, the estimate and the truth may each come from a bag."""
    times = 0.1 * np.arange(30)
    poses = np.stack([np.sin(times), 1 - np.cos(times), times], axis=1)
    places = np.array([[2.0, 1.0], [1.0, 3.0], [-1.0, 2.0]])
    speeds = {"speed_m_s": np.ones(30), "turn_rate_rad_s": np.ones(30)}
    table(tmp_path / "moves.csv", times, **speeds)
    near = np.array([se2.act(se2.inverse(pose), places) for pose in poses[1:]])
    near += np.random.default_rng(1).normal(0, 0.05, near.shape)
    seen = dict(zip(("x_m", "y_m"), near.reshape(-1, 2).T, strict=True))
    seen["landmark"] = np.tile([1, 2, 3], 29)
    when = np.repeat(times[1:], 3)
    table(tmp_path / "seen.csv", when, **seen)
    table(tmp_path / "later.csv", START + when, **seen)
    said = [
        bags.odometry(time, se3.from_se2(pose), speed=1.0, turn=1.0)
        for time, pose in zip(times, poses, strict=True)
    ]
    bags.write_bag(tmp_path / name, said)
    plain = play(tmp_path, "ekf_slam.py", "points", "moves.csv", "seen.csv", "plain")
    said = play(tmp_path, "ekf_slam.py", "points", name, "later.csv", "bag")
    assert said == f"speeds of /odom\n{plain}"
    same(tmp_path, "plain.csv", "bag.csv")
    same(tmp_path, "plain_map.csv", "bag_map.csv", times=False)
    table(
        tmp_path / "true.csv",
        times,
        **dict(zip(("x_m", "y_m", "heading_rad"), poses.T, strict=True)),
    )
    judged = play(tmp_path, "judge.py", "plain.csv", "true.csv")
    assert play(tmp_path, "judge.py", "bag.csv", name) == f"poses of /odom\n{judged}"
    assert "poses: 29, covered by the truth: 29\n" in judged


@pytest.mark.parametrize("name", NAMES)
def test_judge_in_space(name, tmp_path):
    """Poses with heights are judged with them, as those of a TUM file with the same numbers."""
    times = 0.1 * np.arange(40)
    path = se3.from_se2(np.stack([times, np.sin(times), times], axis=1))
    path[:, 2, 3] = np.cos(3 * times)
    off = path.copy()
    off[:, :3, 3] += np.random.default_rng(1).normal(0, 0.1, (40, 3))
    write_tum(tmp_path / "off.tum", START + times, off)
    write_tum(tmp_path / "path.tum", START + times, path)
    said = [bags.odometry(time, T) for time, T in zip(times, path, strict=True)]
    bags.write_bag(tmp_path / name, [*said, bags.odometry(0.1, path[1], topic="/other")])
    plain = play(tmp_path, "judge.py", "off.tum", "path.tum", "--align", "se3")
    of_bag = play(tmp_path, "judge.py", "off.tum", name, "--align", "se3", "--topic", "/odom")
    bare = "path.tum: no names of columns: read as TUM, time x y z qx qy qz qw\n"
    assert of_bag == plain.replace(bare, "") != plain
    assert "poses: 40, of the truth: 40, together: 40\n" in plain


@pytest.mark.parametrize("name", NAMES)
def test_stereo_slam(name, tmp_path):
    """Pictures, calibration, their times and the speeds of the wheels."""
    world = textured_building.make_textured_building(rng=np.random.default_rng(11))
    path = textured_building.drive(world, rng=np.random.default_rng(12))[:6]
    rig, times = stereo.Rig(), 0.1 * np.arange(6)
    f, (u, v) = rig.focal_px, rig.centre_px
    moves = se2.between(path[:-1], path[1:]) / 0.1
    speeds = np.vstack([moves[:, [0, 2]], [0, 0]])
    said, lines = [], []
    for side, shift in (("l", 0.0), ("r", -f * rig.baseline)):
        (tmp_path / f"image_{side}").mkdir()
        lines.append(f"P{'lr'.index(side)}: {f} 0 {u} {shift} 0 {f} {v} 0 0 0 1 0\n")
    for k, pair in enumerate(stereo.frames(world.scene, rig, path, rng=np.random.default_rng(13))):
        said.append(
            bags.odometry(times[k], se3.from_se2(path[k]), speed=speeds[k, 0], turn=speeds[k, 1])
        )
        for side, picture, line in (("l", pair.left, lines[0]), ("r", pair.right, lines[1])):
            Image.fromarray(picture).save(tmp_path / f"image_{side}/{k}.png")
            P = np.array(line.split()[1:], dtype=float).reshape(3, 4)
            size = picture.shape[1::-1]
            said += [
                bags.image(times[k], picture, "mono8", topic=f"/{side}/image_rect"),
                bags.camera_info(times[k], P, size, topic=f"/{side}/camera_info"),
            ]
    (tmp_path / "calib.txt").write_text("".join(lines))
    table(tmp_path / "wheels.csv", times, speed_m_s=speeds[:, 0], turn_rate_rad_s=speeds[:, 1])
    bags.write_bag(tmp_path / name, said)
    rules = "landmarks.StereoRules(disparities=(2.0, np.inf))"
    changed(tmp_path, "stereo_slam.py", PAIRS=rules)
    for wheels in ([], ["wheels.csv"]):
        plain = play(tmp_path, "stereo_slam.py", ".", "plain", *wheels, "--force")
        of_bag = [name] * len(wheels)
        said = play(tmp_path, "stereo_slam.py", name, "bag", *of_bag, "--force")
        eyes = "pictures of /l/image_rect (left) and /r/image_rect (right)\n"
        assert said == eyes + "speeds of /odom\n" * len(wheels) + plain
        same(tmp_path, "plain.tum", "bag.tum", skip=0, delimiter=" ")
        same(tmp_path, "plain.ply", "bag.ply", times=False, skip=10, delimiter=" ")


# Films -------------------------------------------------------------------------------------------


def square() -> list[np.ndarray]:
    """A red square that moves to the right."""
    film = np.full((12, 60, 80, 3), 80, np.uint8)
    for k, frame in enumerate(film):
        frame[20:40, 20 + k : 36 + k] = 200, 60, 40
    return [*film]


def ceiling_below() -> list[np.ndarray]:
    """A ceiling, seen by a camera that drives below it."""
    plane = ceiling.make_ceiling("varied", rng=np.random.default_rng(3), side=8.0)
    camera = ceiling.CeilingCamera(plane, ceiling.Mount())
    grey = [camera.image(np.array([0.05 * k, 0, 0.02 * k])) for k in range(12)]
    return [np.dstack([picture] * 3) for picture in grey]


def visitor() -> list[np.ndarray]:
    """Somebody before a robot that stands in a hall."""
    rng = np.random.default_rng(3)
    hall, who, place = make_hall(rng), make_visitor(rng), np.array([4.0, 5.0, 0.0])
    there = [(who, Stance(6.1, 5.0, raised=0.0))]
    return [see(hall, CAMERA, place, there, rng=rng).image for _ in range(8)]


def upper_body() -> list[np.ndarray]:
    """Somebody who points."""
    return [*film_arms(np.random.default_rng(106), 5, ArmScene("pointing")).frames]


def gallery(folder: Path) -> None:
    for k, name in enumerate(("ann", "bob")):
        (folder / "gallery" / name).mkdir(parents=True)
        who = make_identity(np.random.default_rng(40 + k), tone=k)
        for day in range(3):
            alone = film_faces(np.random.default_rng(day), 1, FaceScene(glances=0.0), (who,))
            Image.fromarray(alone.frames[0]).save(folder / "gallery" / name / f"{day}.png")


FILMS = {  # by the script: the pictures, the words before and after the film
    "track.py": (square, ["camshift"], ["20,20,16,20"]),
    "ceiling.py": (ceiling_below, [], []),
    "faces.py": (visitor, ["gallery"], []),
    "following.py": (visitor, [], []),
    "arms.py": (upper_body, [], ["0.29,0.25,0.17", "rest"]),
}


@pytest.mark.parametrize("script", FILMS)
def test_films(script, tmp_path):
    """Topics of pictures, as a folder with the same times in the names of its files."""
    make, before, after = FILMS[script]
    gallery(tmp_path)
    (tmp_path / "pictures").mkdir()
    said = [bags.image(0, np.zeros((9, 9), np.uint8), "mono8", topic="/depth")]
    for k, frame in enumerate(make()):
        time = bags.nanoseconds(0.1 * k)
        name = f"{time // 10**9}.{time % 10**9 // 1000:06d}.png"
        Image.fromarray(frame).save(tmp_path / "pictures" / name)
        said.append(bags.image(0.1 * k, frame[..., ::-1], "bgr8"))
    bags.write_bag(tmp_path / "mcap", said)
    plain = play(tmp_path, script, *before, "pictures", *after, "plain")
    named = ["--topic", "/camera/image_raw"]
    assert play(tmp_path, script, *before, "mcap", *after, "bag", *named) == plain
    results = sorted(path.name.removeprefix("plain") for path in tmp_path.glob("plain*"))
    assert len(results) > 1
    for ending in results:
        both = [tmp_path / f"{of}{ending}" for of in ("plain", "bag")]
        if ending.endswith(".csv"):
            a, b = map(pd.read_csv, both)
            other = [name for name in a.columns if name != "frame"]  # a folder's are in its names
            pd.testing.assert_frame_equal(a[other], b[other])
        elif ending.endswith(".mp4"):
            a, b = map(read_video, both)
            assert a.rate == pytest.approx(b.rate, rel=1e-4)
            np.testing.assert_array_equal([*a], [*b])
        else:
            assert both[0].read_bytes() == both[1].read_bytes()
    assert "2 topics hold pictures: /camera/image_raw (Image, " in play(
        tmp_path, script, *before, "mcap", *after, "lost", code=1
    )
