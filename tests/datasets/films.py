"""Films for tests."""

from pathlib import Path

import cv2
import numpy as np


def write_film(path: Path, frames: np.ndarray) -> None:
    """Write frames (n, height, width, 3), red, green and blue, as a film."""
    size = frames.shape[2], frames.shape[1]
    film = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10, size)
    for frame in frames:
        film.write(np.ascontiguousarray(frame[..., ::-1]))
    film.release()
