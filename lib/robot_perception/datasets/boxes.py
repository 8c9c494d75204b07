"""Boxes that somebody drew round a thing in each picture of a sequence."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int64

from robot_perception.checks import integers
from robot_perception.datasets.logs import CorruptLog, as_path
from robot_perception.datasets.tables import read_rows

LIMITS = {"frame": 1e6, "x": 1e5, "y": 1e5, "w": 1e5, "h": 1e5}


@dataclass(frozen=True, eq=False, slots=True)
class Boxes:
    """A box in each picture of a sequence.

    Parameters
    ----------
    numbers : (n,)
        Of the pictures, rising.
    boxes : (n, 4)
        Column and row of the first pixel inside, counted from 0, width and height, px.
    """

    numbers: Int64[np.ndarray, " n"]
    boxes: Float[np.ndarray, "n 4"]

    @property
    def centres(self) -> Float[np.ndarray, "n 2"]:
        """Columns and rows of the boxes' middles, px; centres of pixels are whole numbers."""
        return self.boxes[:, :2] + (self.boxes[:, 2:] - 1) / 2


def read_boxes(path: str | Path, numbers: Sequence[int] | None = None) -> Boxes:
    """Read boxes from a CSV file with columns ``frame, x, y, w, h``, plain or gzip.

    In the file columns and rows are counted from 1, as the benchmark of Wu, Lim and Yang does.

    Parameters
    ----------
    path
        The file.
    numbers
        Of the pictures that must have a box each, such as those of an `ImageSequence`.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, lacks a column, has a number that cannot be read, a box
        without width or height, frames that do not rise, or not those of ``numbers``.
    FileNotFoundError
        If there is no such file.
    """
    path = as_path(path)
    if numbers is not None:
        numbers = integers("numbers", numbers, ("n",))
    rows = read_rows(path, LIMITS, integers=("frame",))
    rows.check_order("frame", "frames", rising=True)
    columns, frames = rows.columns, rows.columns["frame"]
    boxes = np.stack([columns["x"] - 1, columns["y"] - 1, columns["w"], columns["h"]], axis=1)
    flat = (boxes[:, 2:] <= 0).any(axis=1)
    rows.check(flat, lambda k: f"the box of frame {frames[k]} has no area")
    if numbers is not None and not np.array_equal(frames, numbers):
        alone = np.setxor1d(frames, numbers)
        what = f"such as {alone[0]}" if alone.size else "in another order"
        raise CorruptLog(f"{path}: frames are not those of numbers, {what}")
    return Boxes(frames, boxes)
