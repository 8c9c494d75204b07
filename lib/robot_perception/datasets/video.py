"""Films, frame by frame."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from jaxtyping import UInt8

from robot_perception.datasets.images import CorruptImage
from robot_perception.datasets.logs import as_path


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
