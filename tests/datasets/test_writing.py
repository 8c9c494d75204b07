"""What is written can be read again, by our readers or by hand; a file is whole or not there."""

import csv
import re

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from robot_perception import datasets
from robot_perception.geometry import se2, se3
from studies.files import written
from tests.unchecked import unchecked

RNG = np.random.default_rng(1)
PLANAR = np.column_stack([RNG.normal(0, 9, (20, 2)), RNG.uniform(-3, 3, 20)])
POSES = se3.from_se2(PLANAR)
TIMES = np.cumsum(RNG.uniform(0.01, 0.2, 20)) + 1.4e9
POINTS = RNG.normal(0, 5, (4, 3))


def test_tum_holds_the_turn_in_space(tmp_path):
    """Quaternion by hand: a half angle about the axis, the scalar last."""
    roll = se3.exp(np.array([[1.0, 2, 3, 0.6, 0, 0], [1, 2, 3, 0, 0, 0]]))
    datasets.write_tum(tmp_path / "way.tum", np.array([0.0, 1.0]), roll)
    first, second = np.loadtxt(tmp_path / "way.tum")
    np.testing.assert_allclose(first[4:], [np.sin(0.3), 0, 0, np.cos(0.3)], atol=1e-8)
    np.testing.assert_allclose(second, [1, 1, 2, 3, 0, 0, 0, 1], atol=1e-8)


def test_kitti_is_three_rows_of_four(tmp_path):
    datasets.write_kitti(tmp_path / "poses.txt", POSES)
    rows = np.loadtxt(tmp_path / "poses.txt")
    np.testing.assert_allclose(rows.reshape(-1, 3, 4), POSES[:, :3], atol=1e-8)


def test_kitti_goes_through_the_reader_of_the_benchmark(tmp_path):
    from PIL import Image

    for side in ("image_0", "image_1"):
        (tmp_path / side).mkdir()
        for k in range(len(POSES)):
            Image.new("L", (4, 3), k).save(tmp_path / side / f"{k:06}.png")
    (tmp_path / "calib.txt").write_text(
        "P0: 9 0 8 0 0 9 7 0 0 0 1 0\nP1: 9 0 8 -4.5 0 9 7 0 0 0 1 0"
    )
    datasets.write_kitti(tmp_path / "poses.txt", POSES)
    drive = datasets.read_kitti(tmp_path)
    np.testing.assert_allclose(drive.poses, POSES, atol=1e-8)
    for told in (drive.calibration, datasets.read_calibration(tmp_path / "calib.txt")):
        assert (told.focal, told.centre, told.baseline) == ((9.0, 9.0), (8.0, 7.0), 0.5)


@pytest.mark.parametrize("coloured", [False, True])
def test_ply_has_a_header_that_counts(tmp_path, coloured):
    colours = np.array([[0, 1, 2], [255, 254, 253], [9, 9, 9], [7, 8, 9]], dtype=np.uint8)
    datasets.write_ply(tmp_path / "map.ply", POINTS, colours if coloured else None)
    head, _, body = (tmp_path / "map.ply").read_text().partition("end_header\n")
    assert head.startswith("ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\n")
    assert head.count("property") == (6 if coloured else 3)
    rows = np.loadtxt(body.splitlines())
    np.testing.assert_allclose(rows[:, :3], POINTS, atol=1e-6)
    if coloured:
        np.testing.assert_array_equal(rows[:, 3:], colours)


def test_mot_counts_pixels_from_one_and_sorts_by_frame(tmp_path):
    frames, identities = np.array([2, 1, 2]), np.array([7, 7, 3])
    boxes = np.array([[0.0, 4, 10, 20], [5, 6, 7, 8], [1, 2, 3, 4]])
    datasets.write_mot(tmp_path / "a.txt", frames, identities, boxes=boxes)
    text = "1,7,6,7,7,8,1,-1,-1,-1\n2,3,2,3,3,4,1,-1,-1,-1\n2,7,1,5,10,20,1,-1,-1,-1\n"
    assert (tmp_path / "a.txt").read_text() == text
    sure = np.array([0.5, 0.25, 1.0])
    datasets.write_mot(tmp_path / "b.txt", frames, identities, points=POINTS[:3], confidences=sure)
    rows = np.loadtxt(tmp_path / "b.txt", delimiter=",")
    np.testing.assert_array_equal(rows[:, 2:6], -1)
    np.testing.assert_allclose(rows[:, 6], [0.25, 1.0, 0.5])
    np.testing.assert_allclose(rows[:, 7:], POINTS[[1, 2, 0]], rtol=1e-5)


FINITE = st.floats(-1e100, 1e100)
WORDS = st.text(st.characters(exclude_categories=["Cs", "Cc"], include_characters="\t\n\r"))


def told(text: str) -> str:
    """Return a text as a table keeps it: line feeds for line breaks, no blanks at its ends."""
    return re.sub("\r\n?", "\n", text).strip(" \t\n")


@given(
    st.lists(
        st.tuples(FINITE, st.integers(-(2**63) + 1024, 2**63 - 1025), WORDS.filter(told)),
        min_size=1,
        max_size=5,
    ),
    WORDS.filter(lambda name: told(name) not in ("", "x", "k")),
)
@example([(0.0, 0, "0")], ";\r0")
@example([(0.0, 0, "0")], "a\n;b")
def test_whatever_is_written_to_a_table_is_read_back(tmp_path_factory, rows, name):
    path = tmp_path_factory.mktemp("columns") / "a.csv"
    x, k, texts = zip(*rows, strict=True)
    datasets.write_columns(path, {name: list(texts), "x": np.array(x), "k": np.array(k)})
    limits = {"x": np.inf, "k": np.inf}
    found = datasets.read_columns(path, limits, integers=["k"], texts=[told(name)])
    assert found["x"].tolist() == list(x)
    assert found["k"].tolist() == list(k)
    assert found[told(name)].tolist() == [told(text) for text in texts]
    with path.open(newline="") as file:  # another reader sees as many cells
        assert {len(row) for row in csv.reader(file)} == {3}


@pytest.mark.parametrize("text", ["=1+1", "+1", "-2", "@SUM(A1)", "=HYPERLINK(0)", "'=1", "''=1"])
def test_no_text_is_a_formula_to_a_spreadsheet(tmp_path, text):
    datasets.write_columns(tmp_path / "a.csv", {text: [text], "x": [-1.5]})
    with (tmp_path / "a.csv").open(newline="") as file:
        assert [row[0] for row in csv.reader(file)] == [f"'{text}"] * 2
    found = datasets.read_columns(tmp_path / "a.csv", {"x": 9}, texts=[text])
    assert (found["x"].tolist(), found[text].tolist()) == ([-1.5], [text])


def test_whole_numbers_of_any_length_are_kept(tmp_path):
    frames = [1403715274512143104, 10**30]
    datasets.write_columns(tmp_path / "a.csv", {"frame": frames})
    assert (tmp_path / "a.csv").read_text() == f"frame\n{frames[0]}\n{frames[1]}\n"
    datasets.write_columns(tmp_path / "b.csv", {"frame": frames[:1]})
    limits = {"frame": np.inf}
    found = datasets.read_columns(tmp_path / "b.csv", limits, integers=["frame"])
    assert found["frame"].tolist() == frames[:1]
    datasets.write_mot(tmp_path / "a.txt", np.array(frames[:1]), np.array([2**62 + 1]))
    assert (tmp_path / "a.txt").read_text() == f"{frames[0]},{2**62 + 1},-1,-1,-1,-1,1,-1,-1,-1\n"


PLACES = st.lists(st.floats(-6e6, 6e6), min_size=6, max_size=6)


def table_of(path, **how):
    return np.atleast_2d(np.loadtxt(path, **how))


@given(PLACES, st.floats(0, 2e9), st.floats(-3.1, 3.1))
def test_no_place_and_no_time_loses_its_decimals(tmp_path_factory, places, since, heading):
    """To a millionth of a metre far from the origin, and to a microsecond after 1970."""
    folder = tmp_path_factory.mktemp("places")
    points = np.reshape(places, (2, 3))
    times = since + np.array([0, 0.123457])
    poses = se3.from_se2(np.column_stack([points[:, :2], [heading] * 2]))
    near = {"rtol": 0, "atol": 1e-6}
    datasets.write_columns(folder / "a.csv", {"time_s": times, "x_m": points[:, 0]})
    found = datasets.read_columns(folder / "a.csv", {"time_s": np.inf, "x_m": 1e8})
    np.testing.assert_array_equal([*found.values()], [times, points[:, 0]])
    datasets.write_tum(folder / "a.tum", times, poses)
    track = datasets.read_track(folder / "a.tum")
    np.testing.assert_allclose(track.times, times, **near)
    np.testing.assert_allclose(track.poses[:, :2], points[:, :2], **near)
    np.testing.assert_allclose(track.poses[:, 2], heading, **near)
    datasets.write_kitti(folder / "kitti.txt", poses)
    np.testing.assert_allclose(
        table_of(folder / "kitti.txt").reshape(-1, 3, 4), poses[:, :3], **near
    )
    datasets.write_ply(folder / "a.ply", points)
    np.testing.assert_allclose(table_of(folder / "a.ply", skiprows=7), points, **near)
    ids, boxes = np.array([1, 2]), np.column_stack([points, points[:, 0]])
    datasets.write_mot(folder / "mot.txt", ids, ids, points=points, boxes=boxes)
    table = table_of(folder / "mot.txt", delimiter=",")
    np.testing.assert_allclose(table[:, 7:], points, **near)
    np.testing.assert_allclose(table[:, 2:6] - [1, 1, 0, 0], boxes, **near)


def test_what_is_written_of_nothing_has_no_rows(tmp_path):
    none = np.zeros(0, int)
    datasets.write_columns(tmp_path / "a.csv", {"x": [], "note": none})
    datasets.write_tum(tmp_path / "a.tum", np.zeros(0), np.zeros((0, 4, 4)))
    datasets.write_kitti(tmp_path / "a.txt", np.zeros((0, 4, 4)))
    datasets.write_ply(tmp_path / "a.ply", np.zeros((0, 3)))
    datasets.write_mot(tmp_path / "mot.txt", none, none, boxes=np.zeros((0, 4)))
    assert (tmp_path / "a.csv").read_text() == "x,note\n"
    assert "element vertex 0\n" in (tmp_path / "a.ply").read_text()
    for name in ("a.tum", "a.txt", "mot.txt"):
        assert (tmp_path / name).read_text() == ""


def test_words_are_asked_for_by_name(tmp_path):
    (tmp_path / "a.csv").write_text("x,sensor\n1,eye\n2,\n")
    with pytest.raises(datasets.CorruptLog, match="line 3: sensor is empty"):
        datasets.read_columns(tmp_path / "a.csv", {"x": 9}, texts=["sensor"])
    with pytest.raises(datasets.CorruptLog, match="no column of texts kind"):
        datasets.read_columns(tmp_path / "a.csv", {"x": 9}, texts=["kind"])
    (tmp_path / "a.csv").write_text("x,sensor,sensor\n1,eye,ear\n")
    with pytest.raises(datasets.CorruptLog, match="column sensor is there twice"):
        datasets.read_columns(tmp_path / "a.csv", {"x": 9}, texts=["sensor"])


@pytest.mark.parametrize("name", ["film.mp4", "film.avi"])
@pytest.mark.parametrize("shape", [(48, 64), (47, 63)])
def test_a_film_is_read_as_it_was(tmp_path, name, shape):
    """Nearly, as films are compressed; an odd side is made even by repeating its last line."""
    ramp = np.add.outer(np.arange(shape[0]), np.arange(shape[1]))[..., None]
    frames = [np.add(ramp, [k, 40, 90]).astype(np.uint8) for k in range(5)]
    assert datasets.write_video(tmp_path / name, iter(frames), rate=10) == 5
    found = list(datasets.read_video(tmp_path / name))
    assert [frame.shape for frame in found] == [(48, 64, 3)] * 5
    for frame, again in zip(frames, found, strict=True):
        difference = again[: shape[0], : shape[1]].astype(float) - frame
        assert np.abs(difference).mean() < 4


def test_an_interrupted_film_leaves_what_was_there(tmp_path):
    (tmp_path / "film.avi").write_text("old")

    def frames():
        yield np.zeros((16, 16, 3), np.uint8)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        datasets.write_video(tmp_path / "film.avi", frames(), rate=5, overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["film.avi"]
    assert (tmp_path / "film.avi").read_text() == "old"


def test_a_file_appears_when_all_of_it_is_written(tmp_path):
    with written(tmp_path / "a.txt") as beside:
        beside.write_text("new")
        assert beside.suffix == ".txt"
        assert not (tmp_path / "a.txt").exists()
    assert (tmp_path / "a.txt").read_text() == "new"
    with pytest.raises(FileNotFoundError, match=r"none is no folder: cannot write a\.txt there"):
        datasets.write_ply(tmp_path / "none" / "a.txt", POINTS)


WRITE = {
    "columns": lambda to, **how: datasets.write_columns(to, {"a": [1.0]}, **how),
    "tum": lambda to, **how: datasets.write_tum(to, TIMES, POSES, **how),
    "kitti": lambda to, **how: datasets.write_kitti(to, POSES, **how),
    "ply": lambda to, **how: datasets.write_ply(to, POINTS, **how),
    "mot": lambda to, **how: datasets.write_mot(to, np.array([1]), np.array([1]), **how),
    "plan": lambda to, **how: datasets.write_plan(to, way=POINTS[:, :2], **how),
    "video": lambda to, **how: datasets.write_video(to, iter([FRAME] * 2), rate=5, **how),
}


@pytest.mark.parametrize("kind", WRITE)
def test_no_writer_takes_the_place_of_a_file_without_leave(kind, tmp_path):
    assert set(WRITE) == {name[6:] for name in dir(datasets) if name.startswith("write_")}
    file = tmp_path / "out.avi"
    file.write_text("mine")
    with pytest.raises(FileExistsError, match=r"out\.avi is there already; overwrite=True"):
        WRITE[kind](file)
    assert file.read_text() == "mine"
    WRITE[kind](file, overwrite=True)
    assert file.read_bytes() != b"mine"


FRAME = np.zeros((16, 16, 3), np.uint8)


@pytest.mark.parametrize(
    ("write", "message"),
    [
        (lambda to: datasets.write_tum(to, TIMES[::-1], POSES), "times must rise"),
        (lambda to: datasets.write_tum(to, TIMES[:3], POSES), "poses must be .3, 4, 4. for times"),
        (lambda to: datasets.write_tum(to, TIMES, 2 * POSES), "poses must have the last row"),
        (lambda to: datasets.write_kitti(to, POSES[:, :3]), "poses must be .k, 4, 4., got"),
        (lambda to: datasets.write_ply(to, POINTS * np.nan), "points must be finite"),
        (lambda to: datasets.write_ply(to, POINTS, POINTS), "colours must be an array of bytes"),
        (
            lambda to: datasets.write_mot(to, np.array([1, 1]), np.array([4, 4])),
            "identities must be once in a frame, got 4 twice in 1",
        ),
        (
            lambda to: datasets.write_mot(to, np.array([0]), np.array([4])),
            "frames must be at least",
        ),
        (lambda to: datasets.write_columns(to, {}), "columns must be one at least"),
        (lambda to: datasets.write_columns(to, {"a": [1.0], "b": []}), "columns must be of one le"),
        (
            lambda to: datasets.write_columns(to, {"a": ["x\0y"]}),
            r"columns\['a'\] must have texts without control characters, got 'x\\x00y'",
        ),
        (lambda to: datasets.write_columns(to, {"a\ud800": [1]}), "columns must have texts with"),
        (lambda to: datasets.write_columns(to, {"a": [np.nan]}), "columns.*must be finite"),
        (lambda to: datasets.write_video(to, [FRAME], rate=9), "ending of path must be one of"),
        (lambda to: datasets.write_video(f"{to}.avi", [], rate=9), "frames must be one at least"),
        (lambda to: datasets.write_video(f"{to}.avi", [FRAME], rate=0), "rate must be positive"),
        (
            lambda to: datasets.write_video(f"{to}.avi", [FRAME, FRAME[1:]], rate=9),
            r"frames must be \(16, 16, 3\), got \(15, 16, 3\)",
        ),
        (lambda to: datasets.write_video(f"{to}.avi", [FRAME * 1.0], rate=9), "arrays of bytes"),
        (lambda to: datasets.write_video(f"{to}.avi", [FRAME[:4]], rate=9), "sides of 16 px, got"),
    ],
)
def test_wrong_arguments_leave_no_file(tmp_path, write, message):
    with unchecked(), pytest.raises((ValueError, TypeError), match=message):
        write(str(tmp_path / "file"))
    assert not list(tmp_path.iterdir())


def test_a_pose_in_the_plane_keeps_its_frame(tmp_path):
    """Written from its first pose on, a trajectory begins at the origin."""
    datasets.write_tum(tmp_path / "a.tum", TIMES, se3.between(POSES[:1], POSES))
    found = datasets.read_track(tmp_path / "a.tum").poses
    np.testing.assert_allclose(found[:, :2], se2.between(PLANAR[:1], PLANAR)[:, :2], atol=1e-8)
