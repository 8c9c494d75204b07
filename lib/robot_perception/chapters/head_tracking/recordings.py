"""A real head that turns: what fixed and adapted models and OpenCV's CamShift make of it."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int64, UInt8

from robot_perception.chapters.head_tracking.heads import (
    OFF,
    SEARCHING,
    Variant,
    camshift,
    follow,
    overlaps,
    start,
)
from robot_perception.datasets import read_boxes, read_images
from robot_perception.teaching.recordings import Recording
from robot_perception.teaching.tables import Table

_FIXED = replace(SEARCHING, rate=0.0)
SEARCHED = {
    "adapted": Variant(SEARCHING, depth=False),
    "adapted slowly": Variant(replace(SEARCHING, rate=0.02, gate=0.6), depth=False),
    "fixed": Variant(_FIXED, depth=False),
    "fixed, one view": Variant(_FIXED, views=False, depth=False),
    "by highest score": Variant(replace(SEARCHING, size="score"), depth=False),
}
"""With the size searched, as the recording is of one camera; the rules of the rendered heads."""
SHOWN = (0, 60, 120, 180, 249)
"""Pictures that are shown."""


@dataclass(frozen=True, eq=False, slots=True)
class Girl:
    """What each tracker says of each picture, told of the first.

    Parameters
    ----------
    variants
        Names of the trackers.
    iou : (variants, n)
        Area that tracked ellipse and that of the marked box share, of the area of both.
    lost : (variants, n)
        Whether the tracker says that it has lost the head.
    ellipses : (variants, n, 4)
        Centre (column, row), half width and half height, px.
    marked : (n, 4)
        The same of the marked boxes.
    frames : (k, height, width, 3)
        The pictures ``shown``, red, green and blue.
    shown : (k,)
        Which they are.
    """

    variants: tuple[str, ...]
    iou: Float[np.ndarray, "variants n"]
    lost: Bool[np.ndarray, "variants n"]
    ellipses: Float[np.ndarray, "variants n 4"]
    marked: Float[np.ndarray, "n 4"]
    frames: UInt8[np.ndarray, "k height width 3"] = field(repr=False)
    shown: Int64[np.ndarray, " k"]

    def table(self) -> Table:
        """Return mean overlap and losses by tracker."""
        rows = {
            name: (float(iou.mean()), float((iou < OFF).mean()), float(lost.mean()))
            for name, iou, lost in zip(self.variants, self.iou, self.lost, strict=True)
        }
        columns = {
            "IoU": "mean overlap with the marked box's ellipse",
            "missed": f"share of the pictures in which it is below {OFF:g}",
            "says lost": "share of the pictures in which the tracker says it has lost the head",
        }
        return Table(rows, columns, f"{self.iou.shape[1]} pictures of one recording", "tracker")


def girl(folder: Path) -> Girl:
    """Follow the head through the recording."""
    pictures = read_images(folder / "img", "*.jpg", colour=True)
    boxes = read_boxes(folder / "groundtruth_rect.csv", pictures.numbers)
    frames = np.array(list(pictures))
    marked = np.hstack([boxes.centres, boxes.boxes[:, 2:] / 2])
    rows, columns = np.arange(frames.shape[1])[:, None], np.arange(frames.shape[2])
    truth = np.array(
        [((columns - u) / a) ** 2 + ((rows - v) / b) ** 2 <= 1 for u, v, a, b in marked]
    )
    first = start(frames[0], marked[0])
    found = {name: follow(frames, first, variant) for name, variant in SEARCHED.items()}
    found["CamShift"] = camshift(frames, marked[0])
    return Girl(
        tuple(found),
        np.array([overlaps(track, truth) for track in found.values()]),
        np.array([track.lost for track in found.values()]),
        np.array([track.ellipses for track in found.values()]),
        marked,
        frames[list(SHOWN)],
        np.array(SHOWN),
    )


GIRL = Recording("head_girl", girl, Girl, "head-girl")
