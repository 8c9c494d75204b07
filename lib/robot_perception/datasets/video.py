"""Films, frame by frame."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from jaxtyping import UInt8

from robot_perception import checks
from robot_perception.datasets.images import CorruptImage
from robot_perception.datasets.logs import as_path
from robot_perception.extras import needing
from robot_perception.files import destination, written

CODECS = {".mp4": "mp4v", ".avi": "MJPG"}
"""By the ending of a film's name, what OpenCV writes without more being installed."""

SMALLEST = 16
"""Least height and width of a film that is written, px: some encoders fail below 8."""


def read_video(path: str | Path) -> Iterator[UInt8[np.ndarray, "height width 3"]]:
    """Yield the frames of a film.

    Parameters
    ----------
    path
        The file, of any format that OpenCV reads.

    Yields
    ------
    (height, width, 3)
        Red, green and blue.

    Raises
    ------
    CorruptImage
        If the file is no film, or ends before as many frames as it promises.
    FileNotFoundError
        If there is no such file.
    """
    with needing():
        import cv2

    path = as_path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no such film: {path}")
    film = cv2.VideoCapture(str(path))
    promised = int(film.get(cv2.CAP_PROP_FRAME_COUNT))
    if not film.isOpened() or promised < 1:
        raise CorruptImage(f"{path}: no film, or a damaged one")
    return _frames(film, path, promised)


def _frames(film, path: Path, promised: int) -> Iterator[np.ndarray]:
    """Yield the frames of an open film, as many as it promises."""
    for k in range(promised):
        there, frame = film.read()
        if not there:
            raise CorruptImage(f"{path}: the film ends after {k} of {promised} frames")
        yield np.ascontiguousarray(frame[..., ::-1])


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
        Frames in a second.
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
        If OpenCV cannot write such a film, there is no such folder, or the file is there and must
        not be.
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
    return count
