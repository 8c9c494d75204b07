"""Films and folders of pictures, frame by frame."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.checks import instance
from robot_perception.datasets.bags import Topics, check_topic, is_bag
from robot_perception.datasets.containers import counts_pictures, missing_bytes
from robot_perception.datasets.images import (
    ENDINGS,
    ImageSequence,
    count_gaps,
    first,
    name_gaps,
    read_images,
)
from robot_perception.datasets.logs import as_path
from robot_perception.datasets.pictures import LARGEST, READ, UNREAD, CorruptImage
from robot_perception.extras import needing
from studies.files import destination, written

CODECS = {".mp4": "mp4v", ".avi": "MJPG"}
"""Codecs by the ending of a film's name that OpenCV writes without more being installed."""

SMALLEST = 16
"""Least height and width of a film that is written, px: some encoders fail below 8."""

CONTROL = re.compile(rb"[\0-\x08\x0e-\x1a\x1c-\x1f]")  # bytes that no text has
TRIED = 30  # pictures at the beginning of a film, for its rate, and behind a damaged one
MOST = 2**31  # pictures of a film; a header that promises more does not know


@final
@dataclass(eq=False, slots=True)
class Film(Iterator[UInt8[np.ndarray, "height width 3"]]):
    """The pictures of a film or of a folder, once and in order: red, green and blue.

    Parameters
    ----------
    path
        The file or the folder.
    size
        Width and height of a picture, px.
    rate
        Pictures in a second; none if nothing tells.
    promised
        How many pictures the film says that it holds, which may be more than there are; none if it
        does not count them. Of a folder, how many there are.
    pictures
        Their numbers, their times (s, or none) and themselves, as they are read.
    remarks
        Sentences on what is not as it should be, for who started the program.
    skipped
        Files of the folder that are none of the pictures.
    numbers, times
        Of the pictures that were read so far: a film's count from 1, a folder's stand in the names
        of its files; times are in seconds, and there are none where nothing tells them.
    finished
        Whether all were read.
    composed
        Whether the numbers are put together from several, so that they count nothing.
    """

    path: Path
    size: tuple[int, int]
    rate: float | None
    promised: int | None
    pictures: Iterator[tuple[int, float | None, np.ndarray]]
    remarks: list[str]
    skipped: tuple[Path, ...] = ()
    numbers: list[int] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    finished: bool = False
    composed: bool = False

    def __next__(self) -> UInt8[np.ndarray, "height width 3"]:
        """Read the next picture."""
        if self.finished:
            raise StopIteration
        try:
            number, time, picture = next(self.pictures)
        except StopIteration:
            self.finished = True
            if self.missing:
                self.remarks.append(
                    f"the film promises {self.promised} pictures and holds {self.count}"
                )
            raise
        self.numbers.append(number)
        if time is not None:
            self.times.append(time)
        return picture

    @property
    def count(self) -> int:
        """Number of pictures read so far."""
        return len(self.numbers)

    @property
    def missing(self) -> int:
        """Number of pictures that were promised and are not there; 0 until all were read."""
        return max((self.promised or 0) - self.count, 0) if self.finished else 0

    def seconds(self, rate: float) -> Float[np.ndarray, " count"]:
        """Return when the pictures that were read were taken, s, or would have been.

        Parameters
        ----------
        rate
            Pictures in a second where nothing tells the times; they then begin with 0, and a number
            that is missing in a folder leaves a gap, unless numbers are put together from several.

        Raises
        ------
        ValueError
            If the rate is not positive and finite.
        """
        rate = checks.positive("rate", rate)
        if self.times:
            return np.array(self.times)
        counts = range(self.count) if self.composed else self.numbers
        return np.array([number - counts[0] for number in counts]) / rate


def read_film(path: str | Path, pattern: str | None = None, *, topic: Topics = None) -> Film:
    """Read a film, or a folder of pictures or a topic of a ROS bag as one.

    Parameters
    ----------
    path
        The file, as `read_video` reads it, or the folder, as `read_images` does, or the bag, as
        `read_bag_film` does. Where pictures are missing in a folder it goes on, and says so.
    pattern
        Which files of a folder they are, such as ``left*.jpg``; if none is given, all pictures.
    topic
        Of a bag, where several would do.

    Raises
    ------
    CorruptLog
        If the bag is damaged, or no topic or more than one would do.
    CorruptImage
        If the film or the names in the folder cannot be used; while reading, if a picture of a
        folder is damaged or has another size.
    FileNotFoundError
        If there is neither.
    """
    path, topic = as_path(path), check_topic(topic)
    if pattern is not None:
        instance("pattern", pattern, str)
    if is_bag(path):
        from robot_perception.datasets.bag_pictures import read_bag_film  # which makes films

        return read_bag_film(path, topic)
    if not path.is_dir():
        return read_video(path)
    sequence = read_images(path, pattern, colour=True, allow_gaps=True)
    times = sequence.times or (None,) * len(sequence)
    step = np.median(np.diff(sequence.times)) if sequence.times and len(sequence) > 1 else 0
    return Film(
        path,
        sequence.size,
        float(1 / step) if step else None,
        len(sequence),
        zip(sequence.numbers, times, sequence, strict=True),
        _remarks(sequence),
        sequence.skipped,
        composed=sequence.composed,
    )


def _remarks(sequence: ImageSequence) -> list[str]:
    """Return sentences on what a folder lacks and what was skipped in it."""
    remarks = list(sequence.remarks)
    if sequence.gaps:
        count = count_gaps(sequence.gaps)
        remarks.append(f"pictures that are missing: {count} ({name_gaps(sequence.gaps)})")
    if sequence.skipped:
        names = [path.name for path in sequence.skipped]
        remarks.append(f"files that are skipped: {len(names)} ({first(names)})")
    return remarks


def read_video(path: str | Path) -> Film:
    """Read a film to its end, whatever its header promises.

    It is turned as a telephone says that it was held. `Film.rate` is that of the header, unless the
    times of the first pictures contradict it. A film that was cut is refused where the file tells
    that: AVI, MP4, Matroska, WebM, ASF, FLV and MJPEG. Where the film counts its pictures (AVI,
    MP4, MXF), `Film.missing` has how many fewer there are, as a recorder dropped some. While it is
    read, a picture that cannot be decoded is an error if others follow it; some decoders hide it.

    Parameters
    ----------
    path
        The file, of any format that OpenCV reads. Lists of other files are none, and neither are
        single pictures.

    Raises
    ------
    CorruptImage
        If the file is no film, was cut, or its pictures have more than 2**26 pixels; while it is
        read, if a picture is damaged.
    FileNotFoundError
        If there is no such file.
    """
    with needing():
        import cv2

    path = as_path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no such film: {path}")
    with path.open("rb") as file:
        head = file.read(512)
    if head and not CONTROL.search(head) and not head.startswith(b"YUV4MPEG2"):
        raise CorruptImage(f"{path}: no film, or a damaged one: a text, such as a list of films")
    ending = path.suffix.lower()
    if ending in UNREAD:
        raise CorruptImage(f"{path}: a picture in {UNREAD[ending]}, which is not read; {READ}")
    if ending in ENDINGS and ending != ".gif":
        raise CorruptImage(f"{path}: a picture, and no film; read_film takes the folder of many")
    if lost := missing_bytes(path):
        raise CorruptImage(f"{path}: no whole film: it was cut, {lost} bytes are missing")
    film = _opened(path)
    promised, told = (film.get(p) for p in (cv2.CAP_PROP_FRAME_COUNT, cv2.CAP_PROP_FPS))
    shape, stamps = _beginning(film)
    if shape is None:
        raise CorruptImage(f"{path}: no film, or a damaged one")
    rate = None if head.startswith(b"\xff\xd8") else _rate(told, stamps)
    return Film(
        path,
        shape,
        rate,
        int(promised) if 0 < promised < MOST and counts_pictures(path) else None,
        _frames(path, rate),
        _shape_of_pixels(film),
    )


def _opened(path: Path):
    """Return OpenCV's film, which turns pictures as they were held."""
    import cv2

    backend = cv2.CAP_FFMPEG if cv2.videoio_registry.hasBackend(cv2.CAP_FFMPEG) else cv2.CAP_ANY
    film = cv2.VideoCapture(str(path.absolute()), backend)  # no protocol stands before a full path
    film.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1)
    pixels = film.get(cv2.CAP_PROP_FRAME_WIDTH) * film.get(cv2.CAP_PROP_FRAME_HEIGHT)
    if pixels > LARGEST:
        raise CorruptImage(f"{path}: frames of {pixels:.0f} px are more than the {LARGEST} allowed")
    return film


def _beginning(film) -> tuple[tuple[int, int] | None, list[float]]:
    """Return the size of the first picture, if there is one, and times of some, s, that rise."""
    import cv2

    there, picture = film.read()
    if not there:
        return None, []
    stamps = [film.get(cv2.CAP_PROP_POS_MSEC) / 1000]
    while len(stamps) < TRIED and film.grab():
        stamps.append(film.get(cv2.CAP_PROP_POS_MSEC) / 1000)
        if not stamps[-1] > stamps[-2]:  # of the last ones some formats do not know it
            stamps.pop()
            break
    return picture.shape[1::-1], stamps


def _rate(told: float, stamps: list[float]) -> float | None:
    """Return the rate that the header tells, or that of the first pictures where it is far off."""
    seen = (len(stamps) - 1) / (stamps[-1] - stamps[0]) if len(stamps) > 1 else told
    rate = told if seen / 1.25 < told < seen * 1.25 else seen
    return rate if 0 < rate < np.inf else None


def _frames(path: Path, rate: float | None) -> Iterator[tuple[int, float | None, np.ndarray]]:
    """Yield the numbers, the times and the frames of a film, to its end."""
    import cv2

    film, number, time = _opened(path), 0, None
    while True:
        there, frame = film.read()
        number += 1
        if not there:
            if any(film.grab() for _ in range(TRIED)):  # at the end there are none
                raise CorruptImage(f"{path}: picture {number} is damaged, and others follow it")
            return
        if rate is not None:
            stamp = film.get(cv2.CAP_PROP_POS_MSEC) / 1000
            time = stamp if time is None or stamp > time else time + 1 / rate
        yield number, time, np.ascontiguousarray(frame[..., ::-1])


def _shape_of_pixels(film) -> list[str]:
    """Return a sentence on pixels that are not square, if they are not."""
    import cv2

    wide, high = (film.get(p) for p in (cv2.CAP_PROP_SAR_NUM, cv2.CAP_PROP_SAR_DEN))
    if min(wide, high) > 0 and wide != high:
        return [f"pixels are not square but {wide:.0f} wide and {high:.0f} high"]
    return []


def write_video(
    path: str | Path,
    frames: Iterable[UInt8[np.ndarray, "height width 3"]],
    *,
    rate: float,
    overwrite: bool = False,
) -> int:
    """Write a film, whole or not at all, and return how many frames it has.

    Parameters
    ----------
    path
        The file, ``.mp4`` or ``.avi``, in a folder that exists.
    frames
        Red, green and blue, each (height, width, 3), all of one size; they are asked for one by
        one. One row or column is repeated where a side is odd, which films cannot be.
    rate
        Frames in a second, such as `Film.rate`.
    overwrite
        Whether the file may be there already.

    Raises
    ------
    TypeError
        If a frame does not hold bytes.
    ValueError
        If the name has another ending, there is no frame, one has another shape, or a side of less
        than 16 px.
    OSError
        If OpenCV cannot write such a film, not all of it could be written, there is no such folder,
        or the file is there and must not be.
    """
    with needing():
        import cv2

    path, rate = destination(path, overwrite=overwrite), checks.positive("rate", rate)
    codec = checks.one_of("the ending of path", path.suffix.lower(), CODECS)
    if not 0.01 <= rate <= 1000:
        raise ValueError(f"rate must be from 0.01 to 1000 frames in a second, got {rate:g}")
    film, count, shape = None, 0, ("height", "width", 3)
    with written(path) as beside:
        try:
            for frame in checks.iterable("frames", frames):
                if not isinstance(frame, np.ndarray) or frame.dtype != np.uint8:
                    raise TypeError(f"frames must be arrays of bytes, got {checks.shown(frame)}")
                checks.shaped("frames", frame, shape)
                if film is None:
                    shape = frame.shape
                    if min(shape[:2]) < SMALLEST:
                        raise ValueError(f"frames must have sides of {SMALLEST} px, got {shape}")
                    size = tuple(side + side % 2 for side in shape[1::-1])
                    kind = cv2.VideoWriter_fourcc(*CODECS[codec])
                    film = cv2.VideoWriter(str(beside), kind, rate, size)
                    if not film.isOpened():
                        raise OSError(f"{path}: OpenCV cannot write a film of {size} px")
                odd = [(0, side % 2) for side in shape[:2]]
                film.write(np.pad(frame[..., ::-1], [*odd, (0, 0)], mode="edge"))
                count += 1
        finally:
            if film is not None:
                film.release()
        if film is None:
            raise ValueError("frames must be one at least, got none")
        _check_written(path, beside, count)
    return count


def _check_written(path: Path, beside: Path, count: int) -> None:
    """Raise ``OSError`` unless a film that was written can be read to its end.

    OpenCV does not say when a disk is full.
    """
    there, film = 0, _opened(beside)
    while film.grab():
        there += 1
    if there != count or missing_bytes(beside):
        raise OSError(f"{path}: of {count} frames only {there} could be written; is the disk full?")
