"""A real head that turns: what fixed and adapted models and OpenCV's CamShift make of it.

Once from the first picture to the last, and once from many pictures on for a few seconds each: one
start says more of its picture than of a tracker.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int64, UInt8

from robot_perception.chapters.head_tracking.heads import (
    GIVES_UP,
    OFF,
    SEARCHING,
    Track,
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
    "adapted fast": Variant(replace(SEARCHING, rate=0.1), depth=False),
    "fixed": Variant(_FIXED, depth=False),
    "adapted, gives up": Variant(replace(SEARCHING, gives_up=GIVES_UP), depth=False),
    "fixed, gives up": Variant(replace(_FIXED, gives_up=GIVES_UP), depth=False),
    "by highest score": Variant(replace(SEARCHING, size="score"), depth=False),
}
"""With the size searched, as the recording is of one camera; the rules of the rendered heads."""
LONG = 120
"""Pictures that are followed from each of many starts."""
APART = 10
"""Pictures from one of these starts to the next."""
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
    ellipses : (variants, n, 4)
        Centre (column, row), half width and half height, px.
    marked : (n, 4)
        The same of the marked boxes.
    frames : (k, height, width, 3)
        The pictures ``shown``, red, green and blue.
    shown : (k,)
        Which they are.
    starts : (s,)
        Pictures from which the trackers start anew, for ``LONG`` pictures each.
    missed : (variants, s)
        Share of these pictures in which the overlap is below ``OFF``.
    """

    variants: tuple[str, ...]
    iou: Float[np.ndarray, "variants n"]
    ellipses: Float[np.ndarray, "variants n 4"]
    marked: Float[np.ndarray, "n 4"]
    frames: UInt8[np.ndarray, "k height width 3"] = field(repr=False)
    shown: Int64[np.ndarray, " k"]
    starts: Int64[np.ndarray, " s"]
    missed: Float[np.ndarray, "variants s"]

    def table(self) -> Table:
        """Return losses by tracker, over the whole recording and over many starts."""
        rows = {
            name: [float(x) for x in ((iou < OFF).mean(), some.mean(), some.min(), some.max())]
            for name, iou, some in zip(self.variants, self.iou, self.missed, strict=True)
            if name != "adapted, gives up"
        }
        columns = {
            "missed": f"share of all pictures in which the overlap is below {OFF:g}",
            "over the starts": "the same share, mean over the starts",
            "least": "at the best start",
            "most": "at the worst start",
        }
        about = f"{self.iou.shape[1]} pictures of one recording, and {len(self.starts)} starts of "
        return Table(rows, columns, f"{about}{LONG} pictures each, {APART} apart", "tracker")


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

    def followed(first: int, last: int) -> dict[str, Track]:
        told = start(frames[first], marked[first])
        part = frames[first:last]
        found = {name: follow(part, told, variant) for name, variant in SEARCHED.items()}
        return found | {"CamShift": camshift(part, marked[first])}

    whole, starts = followed(0, len(frames)), range(0, len(frames) - LONG + 1, APART)
    missed = [
        [(overlaps(track, truth[k : k + LONG]) < OFF).mean() for track in again.values()]
        for k in starts
        for again in (followed(k, k + LONG),)
    ]
    return Girl(
        tuple(whole),
        np.array([overlaps(track, truth) for track in whole.values()]),
        np.array([track.ellipses for track in whole.values()]),
        marked,
        frames[list(SHOWN)],
        np.array(SHOWN),
        np.array(starts),
        np.array(missed).T,
    )


GIRL = Recording("head_girl", girl, Girl, "head-girl")
