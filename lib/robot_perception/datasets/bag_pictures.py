"""Pictures in ROS bags: as films, and as pairs of a stereo camera with its calibration."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.datasets import bags
from robot_perception.datasets.bags import Bag, Topics
from robot_perception.datasets.calibrations import Calibration, rectified_pair
from robot_perception.datasets.logs import CorruptLog, ReadReport, as_path
from robot_perception.datasets.pictures import LARGEST, CorruptImage, decode, upper_bits
from robot_perception.datasets.video import Film
from robot_perception.extras import needing

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
KINDS = (IMAGE, COMPRESSED)
INFO = "sensor_msgs/msg/CameraInfo"
RAW = {  # by the encoding: bytes of a pixel, and what OpenCV calls the step to red, green, blue
    "mono8": (1, None),
    "8UC1": (1, None),
    "mono16": (2, None),
    "16UC1": (2, None),
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
TOLERANCE = 0.01  # s between the two pictures of a pair

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
        for k, message in enumerate(bag.messages(topic, KINDS)):
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
        """When the left pictures were taken, s since 1970."""
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
    as `read_image` does; pictures in the pattern of Bayer get colours.

    Parameters
    ----------
    path
        The bag, as `is_bag` describes it.
    topic
        Of ``sensor_msgs/Image`` or ``sensor_msgs/CompressedImage``, or several of which one is;
        needed where several topics do.

    Raises
    ------
    CorruptLog
        If it is no bag or a damaged one, no topic or more than one will do, or the clock was set
        back.
    CorruptImage
        If the first picture is damaged, or of a kind that is none of grey values or colours, such
        as depths; while reading, if another one is, or has another size.
    FileNotFoundError
        If there is none.
    """
    path, topic = as_path(path), bags.check_topic(topic)
    with bags.opened(path) as bag:
        name = bag.choose(KINDS, topic)
        places, times, remarks = _places(bag, name)
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
    path: str | Path, topic: Topics = None, *, tolerance: float = TOLERANCE
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
        The two topics of pictures; needed where there are more than two with such a calibration.
    tolerance
        Most time between the two pictures of a pair, s.

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
    with bags.opened(path) as bag:
        names, infos = _eyes(bag, topic)
        found = [_places(bag, name) for name in names]
        calibration = _calibration(path, names, infos)
        (first, left, _), (second, right, _) = found
        mine, theirs = _matched(left, right, 1e9 * tolerance)
        if not len(mine):
            raise CorruptLog(
                f"{path}: no picture of {names[0]} has one of {names[1]} within"
                f" {tolerance:g} s (tolerance)"
            )
        remarks = [remark for _, _, remarks in found for remark in remarks]
        for name, times in zip(names, (left, right), strict=True):
            if alone := len(times) - len(mine):
                remarks.append(f"{name}: {alone} pictures without a partner left out")
        report = bag.report(dict.fromkeys(names, len(mine)), remarks)
    eyes = []
    pieces = zip(names, infos, (first, second), (left, right), (mine, theirs), strict=True)
    for name, info, places, times, rows in pieces:
        chosen = tuple(places[row] for row in rows)
        size = _size(path, name, chosen[0])
        if size != (info.width, info.height):
            raise CorruptImage(
                f"{path}: pictures of {name} have {size[0]} x {size[1]} px, their CameraInfo says"
                f" {info.width} x {info.height}"
            )
        bends = _straighten(path, name, info)
        eyes.append(BagPictures(path, name, chosen, times[rows] / 1e9, size, straighten=bends))
    return BagStereo(*eyes, calibration, report)


def _places(bag: Bag, topic: str) -> tuple[tuple[int, ...], np.ndarray, list[str]]:
    """Return which messages of a topic are used, their times, ns, and sentences on the others."""
    marks = [(stamp, logged) for stamp, logged, _ in bag.messages(topic, KINDS)]
    times, kept, remarks = bags.rising(bag.path, topic, *zip(*marks, strict=True))
    return tuple(np.flatnonzero(kept).tolist()), times[kept], remarks


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


def _eyes(bag: Bag, wanted: Topics) -> tuple[tuple[str, str], tuple[Any, Any]]:
    """Return the topics of the left and the right pictures, and what is known of the cameras."""
    named = bag.candidates(KINDS, wanted)
    every = [name for name, kinds in bag.topics.items() if {*KINDS} & {*kinds}]
    topics = named if wanted else every
    infos = {name: info for name in topics if (info := _info(bag, name)) is not None}
    left, right = ([n for n in infos if (_P(infos[n])[0, 3] < 0) == side] for side in (False, True))
    if len(left) != 1 or len(right) != 1:
        without = [name for name in topics if name not in infos]
        told = [", ".join(some) or "none" for some in (left, right, without)]
        raise CorruptLog(
            f"{bag.path}: a topic of left and one of right pictures are needed, with their"
            f" CameraInfo; left may be {told[0]}, right {told[1]}, without CameraInfo are {told[2]}"
            " (topic=…, in a script --topic twice)"
        )
    names = left[0], right[0]
    return names, (infos[names[0]], infos[names[1]])


def _info(bag: Bag, topic: str) -> Any:
    """Return the CameraInfo beside a topic of pictures; nothing if there is none."""
    parts = topic.split("/")
    beside = ("/".join([*parts[:-up], "camera_info"]) for up in (1, 2))
    name = next((name for name in beside if INFO in bag.topics.get(name, ())), None)
    if name is None:
        return None
    infos = [message.content for message in bag.messages(name, (INFO,))]
    if any(not np.array_equal(_P(info), _P(infos[0])) for info in infos):
        raise CorruptLog(f"{bag.path}: the calibration in {name} changes")
    return infos[0]


def _matrix(info: Any, name: str) -> np.ndarray:
    """Return a matrix of a CameraInfo, whose name is in small letters in ROS 2."""
    values = getattr(info, name, None)
    values = getattr(info, name.lower()) if values is None else values
    return np.asarray(values, dtype=float)


def _P(info: Any) -> np.ndarray:
    return _matrix(info, "P").reshape(3, 4)


def _calibration(path: Path, names: tuple[str, str], infos: tuple[Any, Any]) -> Calibration:
    """Return the calibration of a rectified pair."""
    found = rectified_pair(*map(_P, infos))
    if found is None:
        raise CorruptLog(
            f"{path}: the matrices P of {names[0]} and {names[1]} are not those of a rectified pair"
        )
    return found


def _straighten(path: Path, topic: str, info: Any) -> Straighten | None:
    """Return what rectifies the pictures of a topic; nothing if they are."""
    D, K, R = (_matrix(info, name) for name in "DKR")
    K, R, P = K.reshape(3, 3), R.reshape(3, 3), _P(info)[:, :3]
    if "rect" in topic or (not D.any() and np.array_equal(K, P) and np.allclose(R, np.eye(3))):
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
    if message.__msgtype__ == COMPRESSED:
        if "compressedDepth" in message.format:
            raise CorruptImage(f"{which} holds depths, not grey values")
        return decode(which, np.asarray(message.data).tobytes(), colour=True)
    width, height, encoding = message.width, message.height, message.encoding
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
    if encoding in ("mono16", "16UC1"):
        deep = pixels.view(">u2" if message.is_bigendian else "<u2")[..., 0]
        return upper_bits(which, deep.astype(np.int64))
    if code is None:
        return pixels if depth == 3 else pixels[..., 0]
    with needing():
        import cv2

    return cv2.cvtColor(pixels if depth > 1 else pixels[..., 0], getattr(cv2, code))
