"""Pictures in ROS bags: as films, and as pairs of a stereo camera with its calibration."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple, final

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.datasets import bags
from robot_perception.datasets.bags import Bag, Meaning, Topics
from robot_perception.datasets.calibrations import Calibration, rectified_pair
from robot_perception.datasets.logs import CorruptLog, ReadReport, as_path
from robot_perception.datasets.pictures import LARGEST, CorruptImage, decode
from robot_perception.datasets.video import Film
from robot_perception.extras import needing

COMPRESSED = "sensor_msgs/msg/CompressedImage"
PICTURES = Meaning("pictures", ("sensor_msgs/msg/Image", COMPRESSED))
INFO = "sensor_msgs/msg/CameraInfo"
RAW = {  # by the encoding: bytes of a pixel, and what OpenCV calls the step to red, green, blue
    "mono8": (1, None),
    "8UC1": (1, None),
    "mono16": (2, None),
    "rgb8": (3, None),
    "bgr8": (3, "COLOR_BGR2RGB"),
    "8UC3": (3, "COLOR_BGR2RGB"),
    "rgba8": (4, "COLOR_RGBA2RGB"),
    "bgra8": (4, "COLOR_BGRA2RGB"),
    "8UC4": (4, "COLOR_BGRA2RGB"),
    "bayer_rggb8": (1, "COLOR_BayerRGGB2RGB"),
    "bayer_bggr8": (1, "COLOR_BayerBGGR2RGB"),
    "bayer_gbrg8": (1, "COLOR_BayerGBRG2RGB"),
    "bayer_grbg8": (1, "COLOR_BayerGRBG2RGB"),
    "yuv422": (2, "COLOR_YUV2RGB_UYVY"),
    "uyvy": (2, "COLOR_YUV2RGB_UYVY"),
    "yuv422_yuy2": (2, "COLOR_YUV2RGB_YUY2"),
    "yuyv": (2, "COLOR_YUV2RGB_YUY2"),
}
DEPTHS = re.compile(r"(16U|16S|32F|64F)C1|compressedDepth", re.IGNORECASE)
"""Encodings of depths, by the ROS enhancement proposal 118, and of disparities."""
FILMS = re.compile(r"h\.?26[45]|hevc|avc|av1|vp[89]|mpeg-?[124]|theora", re.IGNORECASE)
"""Formats of parts of films, none of which is a picture alone."""
STARTS = b"\0\0\0\1", b"\0\0\1"  # of such a part, whatever its format says
VIDEO = Meaning(
    "parts of a film",
    (
        "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
        "foxglove_msgs/msg/CompressedVideo",
        "theora_image_transport/msg/Packet",
    ),
)
REPUBLISH = "each is known only after those before; play the bag, and let image_transport republish"
RECTIFIED = re.compile(r"(^|[/_])rect")  # in the names of topics
TOLERANCE = 0.01  # s between the two pictures of a pair
LATEST = 1.0  # s: pictures that are farther apart are no pair by any tolerance
LONGEST_BASELINE = 10.0  # m
SIDES = ("left", "right"), ("infra1", "infra2"), ("cam0", "cam1"), ("/l/", "/r/")  # in names
NAME_TWO = "(topic=…, in a script --topic twice, the left one first)"
GIVE_BASELINE = "(baseline=…, in stereo_slam.py --baseline, and both topics, the left one first)"
GIVE_ALL = "(calibration=…, in stereo_slam.py CALIBRATION)"

Straighten = Callable[[UInt8[np.ndarray, "..."]], UInt8[np.ndarray, "..."]]


@final
@dataclass(frozen=True, eq=False, slots=True)
class BagPictures:
    """Pictures of a topic of a ROS bag, each read when it is asked for.

    Indexing reads one picture; going through all is much faster than asking for each.

    Parameters
    ----------
    path
        The bag.
    topic
        Where they are.
    places
        Which of the messages of the topic they are, counted from 0, rising.
    times : (k,)
        When each was taken, s since 1970, rising.
    size
        Width and height, px.
    colour
        Whether to keep the colours.
    straighten
        What is done to each, for a lens that bends lines; nothing if there is none.
    """

    path: Path
    topic: str
    places: tuple[int, ...]
    times: Float[np.ndarray, " k"]
    size: tuple[int, int]
    colour: bool = False
    straighten: Straighten | None = None

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, at: int) -> UInt8[np.ndarray, "..."]:
        """Read one picture."""
        return next(self._read([self.places[at]]))

    def __iter__(self) -> Iterator[UInt8[np.ndarray, "..."]]:
        return self._read(self.places)

    def _read(self, places: Sequence[int]) -> Iterator[UInt8[np.ndarray, "..."]]:
        for place, picture in _stored(self.path, self.topic, places):
            size = picture.shape[1::-1]
            if size != self.size:
                raise CorruptImage(
                    f"{self.path}: picture {place + 1} of {self.topic} has {size[0]} x {size[1]}"
                    f" px, the first one {self.size[0]} x {self.size[1]}"
                )
            yield self._as_asked(picture)

    def _as_asked(self, picture: np.ndarray) -> UInt8[np.ndarray, "..."]:
        """Return a picture straight, with or without colours."""
        picture = self.straighten(picture) if self.straighten else picture
        if self.colour == (picture.ndim == 3):
            return picture
        import cv2

        return cv2.cvtColor(picture, cv2.COLOR_GRAY2RGB if self.colour else cv2.COLOR_RGB2GRAY)


def _stored(path: Path, topic: str, places: Sequence[int]) -> Iterator[tuple[int, np.ndarray]]:
    """Yield some messages of a topic, as places and pixels."""
    with bags.opened(path) as bag:
        wanted = iter(places)
        place = next(wanted)
        for k, message in enumerate(bag.messages(topic, PICTURES.kinds)):
            if k == place:
                yield k, _decoded(f"{path}: picture {k + 1} of {topic}", message.content)
                place = next(wanted, None)
                if place is None:
                    return


def _size(path: Path, topic: str, place: int) -> tuple[int, int]:
    """Return width and height of one picture."""
    return next(_stored(path, topic, [place]))[1].shape[1::-1]


@final
@dataclass(frozen=True, eq=False, slots=True)
class BagStereo:
    """Rectified pairs of pictures from a ROS bag, each read when it is asked for.

    Parameters
    ----------
    left, right
        As many pictures of one size, in grey.
    calibration
        Of the cameras.
    report
        What became of all messages of the bag.
    """

    left: BagPictures
    right: BagPictures
    calibration: Calibration
    report: ReadReport

    @property
    def times(self) -> Float[np.ndarray, " k"]:
        """Times of the left pictures, s since 1970."""
        return self.left.times

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        return self.left.size

    def __len__(self) -> int:
        return len(self.left)

    def __getitem__(self, at: int) -> tuple[UInt8[np.ndarray, "..."], UInt8[np.ndarray, "..."]]:
        """Read one pair."""
        return self.left[at], self.right[at]

    def __iter__(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        return zip(self.left, self.right, strict=True)


def read_bag_film(path: str | Path, topic: Topics = None) -> Film:
    """Read the pictures of a topic of a ROS bag as a film.

    Those whose time stamp does not lie after the one before are skipped, and told in the remarks.
    The rate is that of the middle of all steps in time. Of sixteen bits the upper eight are taken,
    as `read_image` does; pictures in the pattern of Bayer get colours. Whether they are depths is
    told by their encoding alone: ``16UC1`` and ``32FC1`` are, ``mono16`` are grey values.

    Parameters
    ----------
    path
        The bag, as `is_bag` describes it.
    topic
        Of ``sensor_msgs/Image`` or ``sensor_msgs/CompressedImage``, or several of which one is;
        needed where several topics do. Depths do not.

    Raises
    ------
    CorruptLog
        If it is no bag or a damaged one, no topic or more than one will do, or the clock was set
        back.
    CorruptImage
        If the first picture is damaged, or of a kind that is none of grey values or colours, such
        as depths or parts of a film; while reading, if another one is, or has another size.
    FileNotFoundError
        If there is none.
    """
    path, topic = as_path(path), bags.check_topic(topic)
    with bags.opened(path) as bag:
        named = any(bag.holds(name, PICTURES) for name, _ in bag.named(topic))
        name = bag.only(PICTURES, _candidates(bag, topic), named=named)
        places, times, remarks = _places(bag, name)
        remarks = [*bag.remarks, *remarks]
    size = _size(path, name, places[0])
    pictures = BagPictures(path, name, places, times / 1e9, size, colour=True)
    step = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    seconds = pictures.times.tolist()
    return Film(
        path,
        pictures.size,
        1e9 / step if step else None,
        len(pictures),
        zip(range(1, len(pictures) + 1), seconds, pictures, strict=True),
        remarks,
    )


def read_bag_stereo(
    path: str | Path,
    topic: Topics = None,
    *,
    tolerance: float = TOLERANCE,
    baseline: float | None = None,
    calibration: Calibration | None = None,
) -> BagStereo:
    """Read the pictures of a stereo camera from a ROS bag, with its calibration.

    The two ``sensor_msgs/CameraInfo`` beside the pictures, such as ``/left/camera_info`` of
    ``/left/image_raw``, tell which is the right one and the distance of the two: the last number
    in the first row of its ``P`` is minus focal length times baseline. Pictures of topics without
    ``rect`` in their name are rectified by it, as ROS does. The second picture of a pair is the one
    nearest in time to the first; those without partner are left out, and told in the remarks.

    Parameters
    ----------
    path
        The bag, as `is_bag` describes it.
    topic
        The two topics of pictures, the left one first; needed where there are more than two with
        such a calibration.
    tolerance
        Most time between the two pictures of a pair, s.
    baseline
        Distance of the right camera from the left, m, if ``CameraInfo`` does not tell it.
    calibration
        Of the cameras, whose pictures then are taken to be rectified.

    Raises
    ------
    CorruptLog
        If it is no bag or a damaged one, the topics are not those of one stereo camera, the clock
        was set back, or no two pictures are from one time.
    CorruptImage
        If a first picture is damaged or of another size than the calibration says; while reading,
        if another one is.
    FileNotFoundError
        If there is none.
    """
    path, topic = as_path(path), bags.check_topic(topic)
    checks.not_negative("tolerance", tolerance)
    if baseline is not None:
        checks.positive("baseline", baseline)
    if calibration is not None:
        checks.instance("calibration", calibration, Calibration)
    with bags.opened(path) as bag:
        eyes = _eyes(bag, topic, baseline, calibration)
        names = eyes.names
        found = [_places(bag, name) for name in names]
        (first, left, _), (second, right, _) = found
        mine, theirs = _matched(left, right, 1e9 * tolerance)
        if not len(mine):
            raise CorruptLog(f"{path}: {_apart(names, left / 1e9, right / 1e9, tolerance)}")
        remarks = [*eyes.remarks, *(remark for _, _, remarks in found for remark in remarks)]
        for name, times in zip(names, (left, right), strict=True):
            if alone := len(times) - len(mine):
                remarks.append(f"{name}: {alone} pictures without a partner left out")
        report = bag.report(dict.fromkeys(names, len(mine)), remarks)
    pictures = []
    pieces = zip(names, eyes.infos, (first, second), (left, right), (mine, theirs), strict=True)
    for name, info, places, times, rows in pieces:
        chosen, bends = tuple(places[row] for row in rows), None
        size = _size(path, name, chosen[0])
        if info is not None:
            if size != (info.width, info.height):
                raise CorruptImage(
                    f"{path}: pictures of {name} have {size[0]} x {size[1]} px, their CameraInfo"
                    f" says {info.width} x {info.height}"
                )
            bends = _straighten(path, name, info)
        pictures.append(BagPictures(path, name, chosen, times[rows] / 1e9, size, straighten=bends))
    return BagStereo(*pictures, eyes.calibration, report)


def _places(bag: Bag, topic: str) -> tuple[tuple[int, ...], np.ndarray, list[str]]:
    """Return which messages of a topic are used, their times, ns, and sentences on the others."""
    marks = [(stamp, logged) for stamp, logged, _ in bag.messages(topic, PICTURES.kinds)]
    told = bags.rising(bag.path, topic, *zip(*marks, strict=True))
    return tuple(np.flatnonzero(told.kept).tolist()), told.times[told.kept], told.remarks


def _candidates(bag: Bag, wanted: Topics) -> list[str]:
    """Return the topics of the pictures that may be meant; depths are not."""
    films = [name for name in bag.topics if bag.holds(name, VIDEO)]
    if films and not any(bag.holds(name, PICTURES) for name in bag.topics):
        kind = bags.short(bag.topics[films[0]][0])
        told = f"no pictures, but {films[0]} holds parts of a film ({kind})"
        raise CorruptLog(f"{bag.path}: {told}: {REPUBLISH}")
    return bag.candidates(PICTURES, wanted, lambda topic: not _has_depths(bag, topic))


def _has_depths(bag: Bag, topic: str) -> bool:
    """Tell whether the first picture of a topic holds depths, by its encoding."""
    return bool(DEPTHS.search(_encoding(bag.first(topic, PICTURES))))


def _encoding(message: Any) -> str:
    return message.format if message.__msgtype__ == COMPRESSED else message.encoding


def _matched(
    left: np.ndarray, right: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return which times of both sides, ns, make pairs: each is the other's nearest, and near."""
    nearest = _nearest(right, left)
    mutual = _nearest(left, right)[nearest] == np.arange(len(left))
    good = np.flatnonzero(mutual & (np.abs(right[nearest] - left) <= tolerance))
    return good, nearest[good]


def _nearest(times: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return which of times, rising, is nearest to each that is wanted."""
    after = np.clip(np.searchsorted(times, wanted), 1, max(len(times) - 1, 1))
    if len(times) == 1:
        return np.zeros(len(wanted), dtype=int)
    return after - (wanted - times[after - 1] <= times[after] - wanted)


def _apart(names: tuple[str, str], left: np.ndarray, right: np.ndarray, tolerance: float) -> str:
    """Return why no two pictures, taken at these times, s, make a pair."""
    near = np.abs(left - right[_nearest(right, left)]).min()
    both = f"{names[0]} ({bags.span(left)}) and {names[1]} ({bags.span(right)})"
    if near > LATEST:
        return f"no pictures of {both} are from one time: their clocks differ"
    told = f"no pictures of {both} are within {tolerance:g} s of each other"
    return f"{told}, the nearest {near:.4g} s (tolerance=…, in stereo_slam.py APART)"


class _Eyes(NamedTuple):
    """Topics of the left and the right pictures, what is known of the cameras, and remarks."""

    names: tuple[str, str]
    infos: tuple[Any, Any]
    calibration: Calibration
    remarks: list[str]


def _eyes(
    bag: Bag, wanted: Topics, baseline: float | None, calibration: Calibration | None
) -> _Eyes:
    """Return the two eyes of a stereo camera."""
    topics = _candidates(bag, wanted)
    named = {name for name, _ in bag.named(wanted)}
    infos = {name: info for name in topics if (info := _info(bag, name)) is not None}
    if calibration is not None:
        names, known = _sides(bag, topics, named), calibration
        remarks = ["the calibration is the given one, by which the pictures are taken as rectified"]
        infos = dict.fromkeys(names)
    elif baseline is not None:
        names, remarks = _sides(bag, [*infos], named), []
        left, right = (_P(infos[name]) for name in names)
        moved = left[:, :3] @ np.array([[1, 0, 0, -baseline], [0, 1, 0, 0], [0, 0, 1, 0]])
        known = rectified_pair(np.column_stack([left[:, :3], np.zeros(3)]), moved)
        if known is None or not _are_alike(left, right):
            raise CorruptLog(f"{bag.path}: {_unlike(dict(zip(names, (left, right), strict=True)))}")
    else:
        P = {name: _P(info) for name, info in infos.items()}
        rights = [name for name in P if P[name][0, 3] < 0]  # it is -fx · baseline
        every = [(a, b, rectified_pair(P[a], P[b])) for a in P for b in rights]
        pairs = [(a, b, known) for a, b, known in every if known is not None]
        if len(pairs) != 1:
            raise CorruptLog(f"{bag.path}: {_no_pair(topics, infos, bool(pairs))}")
        *names, known = pairs[0]
        remarks = []
    if known.baseline > LONGEST_BASELINE:
        told = f"the baseline of {names[1]} would be {known.baseline:g} m: in millimetres?"
        raise CorruptLog(f"{bag.path}: {told} {GIVE_BASELINE}")
    if not {*names} <= named:
        remarks.insert(0, f"pictures of {names[0]} (left) and {names[1]} (right)")
    return _Eyes(tuple(names), tuple(infos[name] for name in names), known, remarks)


def _sides(bag: Bag, topics: list[str], named: set[str]) -> tuple[str, str]:
    """Return the left and the right one of two topics: as they are named, or by their words."""
    if len(topics) == 2 and {*topics} <= named:
        return topics[0], topics[1]
    pairs = [
        (a, b)
        for a in topics
        for b in topics
        for left, right in SIDES
        if b == a.replace(left, right) != a
    ]
    if len(pairs) == 1:
        return pairs[0]
    told = ", ".join(topics) or "none"
    raise CorruptLog(
        f"{bag.path}: which pictures are left and right? There may be {told} {NAME_TWO}"
    )


def _no_pair(topics: list[str], infos: dict[str, Any], several: bool) -> str:
    """Return why no two topics, or more than two, are those of one stereo camera."""
    P = {name: _P(info) for name, info in infos.items()}
    left, right = ([n for n in P if (P[n][0, 3] < 0) == side] for side in (False, True))
    if several or len(P) < 2:
        without = [name for name in topics if name not in infos]
        told = [", ".join(some) or "none" for some in (left, right, without)]
        return (
            "a topic of left and one of right pictures are needed, with their CameraInfo; left may"
            f" be {told[0]}, right {told[1]}, without CameraInfo are {told[2]}"
            f" {NAME_TWO if several else GIVE_ALL}"
        )
    alike = [two for two in combinations(P, 2) if _are_alike(*(P[name] for name in two))]
    if not alike:
        return _unlike(
            {name: P[name] for name in [*left[:1], *right[:1], *left[1:], *right[1:]][:2]}
        )
    if any(P[name][1, 3] for name in P):
        return "the cameras stand one above the other (Ty in P), not side by side"
    shifts = ", ".join(f"{P[name][0, 3]:g} of {name}" for name in P)
    told = f"Tx in CameraInfo's P is {shifts}"
    if any(P[name][0, 3] > 0 for name in P):
        return f"{told}; of a right camera it is below 0, -fx · baseline {GIVE_BASELINE}"
    if left and right:
        return _unlike({name: P[name] for name in (left[0], right[0])})
    if not left:
        return f"{told}: all are right cameras, of a left one it is 0 {GIVE_BASELINE}"
    return f"{told}: nothing tells the baseline {GIVE_BASELINE}"


def _are_alike(left: np.ndarray, right: np.ndarray) -> bool:
    """Tell whether two cameras see alike, as those that were rectified together do."""
    return bool(left[0, 0] > 0 and np.allclose(left[:, :3], right[:, :3]))


def _unlike(P: dict[str, np.ndarray]) -> str:
    """Return why the matrices of cameras, by their topics, are not those of a rectified pair."""
    if blank := [name for name in P if not P[name][0, 0] > 0]:
        return f"P in CameraInfo of {' and '.join(blank)} is 0: not calibrated {GIVE_ALL}"
    left, right = P.values()
    places = {"fx": (0, 0), "fy": (1, 1), "cx": (0, 2), "cy": (1, 2)}
    told = [
        f"{name} {left[at]:g} and {right[at]:g}"
        for name, at in places.items()
        if left[at] != right[at]
    ]
    return (
        f"the matrices P of {' and '.join(P)} are not those of a rectified pair:"
        f" {', '.join(told) or 'other numbers differ'} {GIVE_ALL}"
    )


def _info(bag: Bag, topic: str) -> Any:
    """Return the CameraInfo beside a topic of pictures; nothing if there is none."""
    parts = topic.split("/")
    beside = ("/".join([*parts[:-up], "camera_info"]) for up in (1, 2))
    name = next((name for name in beside if INFO in bag.topics.get(name, ())), None)
    if name is None:
        return None
    infos = [message.content for message in bag.messages(name, (INFO,))]
    if any(not np.array_equal(_P(info), _P(infos[0]), equal_nan=True) for info in infos):
        raise CorruptLog(f"{bag.path}: the calibration in {name} changes")
    return infos[0]


def _matrix(info: Any, name: str) -> np.ndarray:
    """Return a matrix of a CameraInfo, whose name is in small letters in ROS 2."""
    values = getattr(info, name, None)
    values = getattr(info, name.lower()) if values is None else values
    return np.asarray(values, dtype=float)


def _P(info: Any) -> np.ndarray:
    return _matrix(info, "P").reshape(3, 4)


def _straighten(path: Path, topic: str, info: Any) -> Straighten | None:
    """Return what rectifies the pictures of a topic; nothing if they are."""
    D, K, R = (_matrix(info, name) for name in "DKR")
    K, R, P = K.reshape(3, 3), R.reshape(3, 3), _P(info)[:, :3]
    if RECTIFIED.search(topic) or (
        not D.any() and np.array_equal(K, P) and np.allclose(R, np.eye(3))
    ):
        return None
    with needing():
        import cv2

    size, single = (info.width, info.height), cv2.CV_32FC1
    if info.distortion_model in ("plumb_bob", "rational_polynomial"):
        maps = cv2.initUndistortRectifyMap(K, D, R, P, size, single)
    elif info.distortion_model in ("equidistant", "fisheye"):
        maps = cv2.fisheye.initUndistortRectifyMap(K, D[:4], R, P, size, single)
    else:
        raise CorruptLog(
            f"{path}: pictures of {topic} are not rectified, and their lens is of the unknown model"
            f" {info.distortion_model!r}"
        )
    return lambda picture: cv2.remap(picture, *maps, cv2.INTER_LINEAR)


def _decoded(which: str, message: Any) -> UInt8[np.ndarray, "..."]:
    """Return the pixels of a message: grey values, or red, green and blue."""
    encoding = _encoding(message)
    if DEPTHS.search(encoding):
        raise CorruptImage(f"{which} holds depths ({encoding!r}), not grey values")
    if message.__msgtype__ == COMPRESSED:
        return _unpacked(which, np.asarray(message.data).tobytes(), encoding)
    width, height = message.width, message.height
    if encoding not in RAW:
        known = ", ".join(RAW)
        raise CorruptImage(f"{which} is encoded as {encoding!r}, which is none of {known}")
    depth, code = RAW[encoding]
    rows = np.asarray(message.data, dtype=np.uint8)
    if not 0 < width * height <= LARGEST:
        raise CorruptImage(f"{which} has {width} x {height} px, not from 1 to {LARGEST}")
    if message.step < width * depth or rows.size < message.step * height:
        raise CorruptImage(
            f"{which} is damaged: {rows.size} bytes for {width} x {height} px of {depth} bytes"
        )
    rows = rows[: message.step * height].reshape(height, message.step)[:, : width * depth]
    pixels = np.ascontiguousarray(rows).reshape(height, width, depth)
    if encoding == "mono16":
        deep = pixels.view(">u2" if message.is_bigendian else "<u2")[..., 0]
        return (deep >> 8).astype(np.uint8)
    return _coloured(pixels if depth > 1 else pixels[..., 0], code)


def _unpacked(which: str, content: bytes, form: str) -> UInt8[np.ndarray, "..."]:
    """Return the pixels of a compressed message."""
    if FILMS.search(form) or content.startswith(STARTS):
        raise CorruptImage(f"{which} is a part of a film ({form!r}), not a picture: {REPUBLISH}")
    pixels = decode(which, content, colour=True, may_be_depths=False)
    before, _, packed = form.partition(";")
    if before.startswith("bayer") and before in RAW and "bgr8" not in packed:
        return _coloured(pixels[..., 0], RAW[before][1])
    return pixels


def _coloured(pixels: np.ndarray, code: str | None) -> UInt8[np.ndarray, "..."]:
    """Return pixels in red, green and blue by what OpenCV calls the step there, if it takes one."""
    if code is None:
        return pixels
    with needing():
        import cv2

    return cv2.cvtColor(pixels, getattr(cv2, code))
