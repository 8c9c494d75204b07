"""Pictures in ROS bags: encodings, pairs of two eyes, what is rectified, damage."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from scipy.spatial.transform import Rotation

from robot_perception import datasets
from robot_perception.datasets import (
    Calibration,
    CorruptLog,
    read_bag_film,
    read_bag_stereo,
)
from tests.datasets import bags
from tests.datasets.bags import (
    COLOUR,
    GREY,
    RIGHT,
    P,
    eyes,
    write_bag,
)
from tests.datasets.formats.bags import DEPTHS, FULL, png

# Pictures -----------------------------------------------------------------------------------------

MOSAIC = np.zeros((24, 32), np.uint8)  # of one colour: 200, 120, 40
MOSAIC[::2, ::2], MOSAIC[1::2, 1::2], MOSAIC[::2, 1::2], MOSAIC[1::2, ::2] = 200, 40, 120, 120
SHIFTS = {"rggb": (0, 0), "grbg": (0, 1), "gbrg": (1, 0), "bggr": (1, 1)}
ALPHA = np.full((24, 32, 1), 90, np.uint8)
EVEN = np.full((24, 32, 3), [180, 90, 60], np.uint8)
LUMA = cv2.cvtColor(EVEN, cv2.COLOR_RGB2YUV)[0, 0]
ENCODED = {  # by the encoding: the bytes, and what they show
    "mono8": (GREY, np.dstack([GREY] * 3)),
    "8UC1": (GREY, np.dstack([GREY] * 3)),
    "rgb8": (COLOUR, COLOUR),
    "bgr8": (COLOUR[..., ::-1], COLOUR),
    "8UC3": (COLOUR[..., ::-1], COLOUR),
    "rgba8": (np.dstack([COLOUR, ALPHA]), COLOUR),
    "bgra8": (np.dstack([COLOUR[..., ::-1], ALPHA]), COLOUR),
    "8UC4": (np.dstack([COLOUR[..., ::-1], ALPHA]), COLOUR),
    "mono16": (GREY.astype("<u2") * 256 + 7, np.dstack([GREY] * 3)),
    **{
        f"bayer_{name}8": (np.roll(MOSAIC, shift, (0, 1)), np.full_like(COLOUR, [200, 120, 40]))
        for name, shift in SHIFTS.items()
    },
}


@pytest.mark.parametrize("step", [None, 300])
@pytest.mark.parametrize("encoding", ENCODED)
def test_encodings(encoding, step, tmp_path):
    raw, shown = ENCODED[encoding]
    path = write_bag(tmp_path / "a.bag", [bags.image(0, raw, encoding, step=step)])
    film = read_bag_film(path)
    assert film.rate is None
    np.testing.assert_array_equal(next(film), shown)


@pytest.mark.parametrize("encoding", ["yuv422", "uyvy", "yuv422_yuy2", "yuyv"])
def test_packed_colours(encoding, tmp_path):
    y, u, v = LUMA.tolist()
    y = round(16 + 219 / 255 * y)
    u, v = (round(128 + 224 / 255 * (channel - 128)) for channel in _uv())
    pair = [y, u, y, v] if encoding in ("yuv422_yuy2", "yuyv") else [u, y, v, y]
    raw = np.tile(np.array(pair, np.uint8), (24, 16)).reshape(24, 32, 2)
    film = read_bag_film(write_bag(tmp_path / "a.bag", [bags.image(0, raw, encoding)]))
    assert np.abs(next(film).astype(int) - EVEN).max() <= 3


def _uv() -> tuple[float, float]:
    """Cb and Cr of EVEN by ITU-R BT.601."""
    r, g, b = EVEN[0, 0].astype(float)
    y = 0.299 * r + 0.587 * g + 0.114 * b
    return 128 + (b - y) / 1.772, 128 + (r - y) / 1.402


def test_sixteen_bits_with_the_first_byte_first(tmp_path):
    raw = (GREY.astype(int) * 256 + 7).astype(">u2")
    path = write_bag(tmp_path / "big.bag", [bags.image(0, raw, "mono16", is_bigendian=1)])
    np.testing.assert_array_equal(next(read_bag_film(path))[..., 0], GREY)


def test_jpeg_is_read_as_from_a_file(tmp_path):
    Image.fromarray(COLOUR).save(tmp_path / "a.jpg", quality=90)
    content = (tmp_path / "a.jpg").read_bytes()
    path = write_bag(tmp_path / "jpeg", [bags.compressed(0, content, "bgr8; jpeg compressed bgr8")])
    expected = datasets.read_image(tmp_path / "a.jpg", colour=True)
    np.testing.assert_array_equal(next(read_bag_film(path)), expected)


GREYS = {
    "mono16": bags.image(0, DEPTHS, "mono16"),
    "packed": bags.compressed(0, png(DEPTHS), "mono16; png compressed "),
}


@pytest.mark.parametrize("name", GREYS)
def test_grey_values_of_sixteen_bits_may_have_black_borders(name, tmp_path):
    film = read_bag_film(write_bag(tmp_path / "grey.bag", [GREYS[name]]))
    np.testing.assert_array_equal(next(film)[..., 0], DEPTHS >> 8)


@pytest.mark.parametrize("shift", SHIFTS)
def test_a_pattern_that_was_packed_gets_its_colours(shift, tmp_path):
    mosaic = np.roll(MOSAIC, SHIFTS[shift], (0, 1))
    for form, shown in (
        (f"bayer_{shift}8; png compressed ", np.full_like(COLOUR, [200, 120, 40])),
        (f"bayer_{shift}8; png compressed bgr8", np.dstack([mosaic] * 3)),
    ):
        path = write_bag(tmp_path / f"{len(form)}.bag", [bags.compressed(0, png(mosaic), form)])
        np.testing.assert_array_equal(next(read_bag_film(path)), shown)


@pytest.mark.parametrize("read", [read_bag_film, read_bag_stereo])
@pytest.mark.parametrize("name", ["odd.bag", "odd"])
@pytest.mark.parametrize(
    "kind",
    [
        "foxglove_msgs/msg/CompressedVideo",
        "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
        "theora_image_transport/msg/Packet",
    ],
)
def test_a_topic_of_parts_of_a_film_is_named(kind, name, read, tmp_path):
    """Where there are pictures as well, they are taken."""
    part = bags.Said("/camera/h264", kind, {"data": np.zeros(9, np.uint8)}, 0.0)
    path = write_bag(tmp_path / name, [part])
    short = kind.rpartition("/")[2]
    with pytest.raises(
        CorruptLog, match=rf"no pictures, but /camera/h264 holds parts of a film \({short}\)"
    ):
        read(path)
    both = write_bag(tmp_path / f"both_{name}", [part, *eyes()])
    assert len(read_bag_stereo(both)) == 3


# Stereo -------------------------------------------------------------------------------------------


def test_pairs_lie_near_in_time_and_others_are_told(tmp_path):
    said = [one for one in eyes() if not (one.topic == "/right/image_rect" and one.time < 0.1)]
    path = write_bag(tmp_path / "lost.bag", said)
    pairs = read_bag_stereo(path, ["/left/image_rect", "/right/image_rect"])
    np.testing.assert_array_equal([left[0, 0] for left, _ in pairs], [1, 2])
    assert pairs.report.remarks == ("/left/image_rect: 1 pictures without a partner left out",)
    with pytest.raises(CorruptLog, match=r"within 0\.001 s of each other, the nearest 0\.002 s"):
        read_bag_stereo(path, tolerance=0.001)
    with pytest.raises(ValueError, match="tolerance must not be negative"):
        read_bag_stereo(path, tolerance=-1)
    said = [replace(one, time=one.time + 9 * one.topic.startswith("/right/i")) for one in said]
    path = write_bag(tmp_path / "apart.bag", said)
    with pytest.raises(CorruptLog, match=r"/right/.* are from one time: their clocks differ$"):
        read_bag_stereo(path)


@given(
    left=st.lists(st.integers(0, 60), min_size=1, unique=True),
    right=st.lists(st.integers(0, 60), min_size=1, unique=True),
    tolerance=st.integers(0, 9),
)
def test_matches_are_mutual_nearest_and_none_is_used_twice(left, right, tolerance):
    from robot_perception.datasets.bag_pictures import _matched

    left, right = np.sort(left), np.sort(right)
    mine, theirs = _matched(left, right, tolerance)
    assert len(set(mine)) == len(mine)
    assert len(set(theirs)) == len(theirs)
    gaps = np.abs(left[:, None] - right)
    for i, j in zip(mine, theirs, strict=True):
        assert gaps[i, j] <= tolerance
        assert gaps[i, j] == gaps[i].min() == gaps[:, j].min()
    alone = np.delete(gaps, mine, axis=0)
    alone = np.delete(alone, theirs, axis=1)
    assert not (alone <= tolerance).any() or len(mine)  # the nearest two of all are always a pair


def test_raw_pictures_are_rectified(tmp_path):
    """A pattern bent by a lens is that of the straight camera again."""
    wide, high = 160, 120
    K = np.array([[100.0, 0, 80], [0, 100, 60], [0, 0, 1]])
    D, R = np.array([-0.25, 0.05, 0.001, -0.002, 0.0]), Rotation.from_euler("y", 3, degrees=True)
    matrix = np.column_stack([K, np.zeros(3)])
    rows, columns = np.mgrid[:high, :wide].astype(float)

    def pattern(u, v):
        return 128 + 60 * np.sin(u / 9) + 50 * np.cos(v / 7)

    seen = cv2.undistortPoints(
        np.stack([columns, rows], -1).reshape(-1, 1, 2), K, D, None, R.as_matrix(), K
    )
    bent = pattern(*seen.reshape(high, wide, 2).transpose(2, 0, 1)).round().astype(np.uint8)
    lens = {"d": D, "r": R.as_matrix().ravel(), "k": K.ravel()}
    said = []
    for side, shift in (("left", 0.0), ("right", -10.0)):
        of_side = matrix.copy()
        of_side[0, 3] = shift
        info = bags.camera_info(0, of_side, (wide, high), topic=f"/{side}/camera_info", **lens)
        said += [bags.image(0, bent, "mono8", topic=f"/{side}/image_raw"), info]
    pairs = read_bag_stereo(write_bag(tmp_path / "raw", said))
    assert pairs.calibration == Calibration((100.0, 100.0), (80.0, 60.0), 0.1) or (
        pairs.calibration.baseline == pytest.approx(0.1)
    )
    inner = np.s_[15:-15, 20:-20]
    for picture in pairs[0]:
        assert np.abs(picture[inner] - pattern(columns, rows)[inner]).max() < 2
    assert np.abs(bent[inner] - pattern(columns, rows)[inner]).max() > 20


def seen_by(left: np.ndarray, right: np.ndarray, sides=("infra1", "infra2")) -> list[bags.Said]:
    """Return one pair of rectified pictures with the matrices P of their cameras."""
    return [
        one
        for side, matrix in zip(sides, (left, right), strict=True)
        for one in (
            bags.image(0, GREY, "mono8", topic=f"/camera/{side}/image_rect_raw"),
            bags.camera_info(0, matrix, (32, 24), topic=f"/camera/{side}/camera_info"),
        )
    ]


def moved(Tx: float, Ty: float = 0.0) -> np.ndarray:
    matrix = P.copy()
    matrix[:2, 3] = Tx, Ty
    return matrix


GIVEN, WHOLE = {"baseline": 0.1}, {"calibration": Calibration((50.0, 50.0), (16.0, 12.0), 0.1)}
BLIND = {  # cameras that do not tell their baseline: P of both, what is said, and what helps
    "not calibrated": (
        0 * P,
        0 * P,
        "P in .* of .*infra1.* and .*infra2.* is 0: not calibrated",
        WHOLE,
    ),
    "one not calibrated": (
        P,
        0 * P,
        "P in .* of .*infra2/image_rect_raw is 0: not calibrated",
        WHOLE,
    ),
    "not finite": (np.nan * P, np.nan * P, "is 0: not calibrated", WHOLE),
    "each alone": (P, 1.1 * P, "not those of a rectified pair: fx 50 and 55, .*cx 16 and", WHOLE),
    "no baseline": (P, P, "Tx in .*P is 0 of .*, 0 of .*: nothing tells the baseline", GIVEN),
    "both the right one": (RIGHT, RIGHT, "Tx in .*P is -5 of .*, -5 of .*: all are right", GIVEN),
    "the other sign": (P, moved(5.0), "0 of .*, 5 of .*; of a right camera it is below 0", GIVEN),
    "swapped": (moved(5.0), P, "5 of .*, 0 of .*; of a right camera it is below 0", GIVEN),
    "millimetres": (P, moved(-5000.0), "the baseline of .*infra2.* would be 100 m: in mil", GIVEN),
}


@pytest.mark.parametrize("name", BLIND)
def test_why_a_stereo_camera_has_no_baseline_is_told_and_what_helps_does(name, tmp_path):
    left, right, message, given = BLIND[name]
    path = write_bag(tmp_path / "blind.bag", seen_by(left, right))
    with pytest.raises(CorruptLog, match=rf"blind\.bag: .*{message}") as error:
        read_bag_stereo(path)
    (what,) = given
    assert f"{what}=…" in str(error.value)
    pairs = read_bag_stereo(path, **given)
    found = pairs.calibration
    assert (found.focal, found.centre) == ((50.0, 50.0), (16.0, 12.0))
    assert found.baseline == pytest.approx(0.1)
    assert "/camera/infra1/image_rect_raw (left)" in pairs.report.remarks[0]
    np.testing.assert_array_equal(pairs[0], [GREY, GREY])


def test_cameras_one_above_the_other_are_told(tmp_path):
    path = write_bag(tmp_path / "high.bag", seen_by(P, moved(0.0, -5.0)))
    with pytest.raises(CorruptLog, match="the cameras stand one above the other"):
        read_bag_stereo(path)


def test_which_eye_is_which_is_told_by_the_words_or_the_order_of_the_topics(tmp_path):
    more = seen_by(P * 2, P * 2, ("color", "fisheye"))
    path = write_bag(tmp_path / "five.bag", [*seen_by(P, P), *more])
    assert read_bag_stereo(path, baseline=0.1).left.topic == "/camera/infra1/image_rect_raw"
    strange = write_bag(tmp_path / "strange.bag", seen_by(P, P, ("one", "two")))
    two = [f"/camera/{side}/image_rect_raw" for side in ("two", "one")]
    with pytest.raises(CorruptLog, match="which pictures are left and right"):
        read_bag_stereo(strange, baseline=0.1)
    pairs = read_bag_stereo(strange, two, baseline=0.1)
    assert [pairs.left.topic, pairs.right.topic] == two
    assert not any("(left)" in remark for remark in pairs.report.remarks)
    with pytest.raises(ValueError, match="baseline must be positive"):
        read_bag_stereo(strange, two, baseline=-0.1)


def test_depths_beside_a_stereo_camera_are_no_eye(tmp_path):
    depth = [bags.image(0, FULL, "16UC1", topic="/camera/depth/image_rect_raw")]
    depth += [bags.camera_info(0, P, (32, 24), topic="/camera/depth/camera_info")]
    path = write_bag(tmp_path / "depth.bag", [*seen_by(P, RIGHT), *depth])
    assert read_bag_stereo(path).left.topic == "/camera/infra1/image_rect_raw"


def test_a_topic_with_rect_inside_a_word_is_not_rectified(tmp_path):
    lens = {"d": np.array([-0.3, 0.1, 0.0, 0.0, 0.0])}
    said = []
    for side, matrix in (("left", P), ("right", RIGHT)):
        info = bags.camera_info(0, matrix, (32, 24), topic=f"/direct/{side}/camera_info", **lens)
        said += [bags.image(0, GREY, "mono8", topic=f"/direct/{side}/image_raw"), info]
    pairs = read_bag_stereo(write_bag(tmp_path / "direct.bag", said))
    assert not np.array_equal(pairs[0][0], GREY)


def test_the_two_topics_may_be_named(tmp_path):
    more = [bags.image(0, GREY, "mono8", topic="/depth/image_rect")]
    more += [bags.camera_info(0, P, (32, 24), topic="/depth/camera_info")]
    path = write_bag(tmp_path / "three.bag", [*eyes(), *more])
    with pytest.raises(CorruptLog, match="left may be /depth/image_rect, /left/image_rect, right"):
        read_bag_stereo(path)
    assert len(read_bag_stereo(path, ["/left/image_rect", "/right/image_rect"])) == 3
