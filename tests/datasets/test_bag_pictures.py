"""Pictures in ROS bags: encodings, pairs of two eyes, what is rectified, damage."""

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
    CorruptImage,
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
    "16UC1": (GREY.astype("<u2") * 256 + 7, np.dstack([GREY] * 3)),
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


DEPTHS = np.where(GREY > 100, 2000 + GREY.astype(np.uint16), 0).astype("<u2")


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (bags.image(0, GREY, "32FC1"), "is encoded as '32FC1', which is none of mono8"),
        (bags.image(0, DEPTHS, "16UC1"), "a picture of depths"),
        (bags.compressed(0, b"x", "16UC1; compressedDepth"), "holds depths, not grey values"),
        (bags.compressed(0, b"x"), "no picture, or a damaged one"),
        (bags.compressed(0, b""), "empty"),
        (bags.image(0, GREY[:, :16], "bgr8", step=20), "is damaged: 480 bytes for 16 x 24 px of 3"),
        (bags.image(0, np.zeros((4, 0), np.uint8), "mono8"), "has 0 x 4 px"),
    ],
)
def test_what_is_no_picture_is_named(said, message, tmp_path):
    with pytest.raises(CorruptImage, match=rf"odd\.bag: picture 1 of /camera/.*{message}"):
        read_bag_film(write_bag(tmp_path / "odd.bag", [said]))


def test_a_picture_of_another_size_ends_the_film(tmp_path):
    said = [bags.image(k, GREY[: 24 - 12 * k], "mono8") for k in range(2)]
    film = read_bag_film(write_bag(tmp_path / "grows.bag", said))
    next(film)
    with pytest.raises(
        CorruptImage, match=r"picture 2 of \S+ has 32 x 12 px, the first one 32 x 24"
    ):
        next(film)


# Stereo -------------------------------------------------------------------------------------------


def test_pairs_lie_near_in_time_and_others_are_told(tmp_path):
    said = [one for one in eyes() if not (one.topic == "/right/image_rect" and one.time < 0.1)]
    path = write_bag(tmp_path / "lost.bag", said)
    pairs = read_bag_stereo(path)
    np.testing.assert_array_equal([left[0, 0] for left, _ in pairs], [1, 2])
    assert pairs.report.remarks == ("/left/image_rect: 1 pictures without a partner left out",)
    with pytest.raises(CorruptLog, match=r"within 0\.001 s \(tolerance\)"):
        read_bag_stereo(path, tolerance=0.001)
    with pytest.raises(ValueError, match="tolerance must not be negative"):
        read_bag_stereo(path, tolerance=-1)


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


def changed(topic: str, **fields) -> list[bags.Said]:
    """The pairs, with other fields in the calibration of one side."""
    said = eyes()
    for one in said:
        if one.topic == topic:
            one.fields.update(fields)
    return said


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (
            [one for one in eyes() if "info" not in one.topic],
            "left may be none, right none, without",
        ),
        (
            [one for one in eyes() if "right" not in one.topic],
            "left may be /left/image_rect, right none",
        ),
        (
            changed("/right/camera_info", p=(RIGHT * [2, 1, 1, 1]).ravel()),
            "not those of a rectified pair",
        ),
        (changed("/left/camera_info", width=64), "have 32 x 24 px, their CameraInfo says 64 x 24"),
        (
            [*eyes(), bags.camera_info(9, 2 * P, (32, 24), topic="/left/camera_info")],
            "the calibration in /left/camera_info changes",
        ),
        (
            [
                bags.Said(o.topic.replace("rect", "raw"), o.kind, o.fields, o.time)
                for o in changed("/left/camera_info", d=np.ones(5), distortion_model="mine")
            ],
            "their lens is of the unknown model 'mine'",
        ),
    ],
)
def test_what_is_no_stereo_camera_is_named(said, message, tmp_path):
    with pytest.raises((CorruptLog, CorruptImage), match=rf"odd: .*{message}"):
        read_bag_stereo(write_bag(tmp_path / "odd", said))


def test_the_two_topics_may_be_named(tmp_path):
    more = [bags.image(0, GREY, "mono8", topic="/depth/image_rect")]
    more += [bags.camera_info(0, P, (32, 24), topic="/depth/camera_info")]
    path = write_bag(tmp_path / "three.bag", [*eyes(), *more])
    with pytest.raises(CorruptLog, match="left may be /depth/image_rect, /left/image_rect, right"):
        read_bag_stereo(path)
    assert len(read_bag_stereo(path, ["/left/image_rect", "/right/image_rect"])) == 3
