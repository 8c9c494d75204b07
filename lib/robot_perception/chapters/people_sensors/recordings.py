"""Real pedestrians: what of a street is taken for skin."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Bool, UInt8

from robot_perception.datasets import read_video
from robot_perception.people.skin import SkinModel, SkinRules
from studies.tables import Table

EVERY = 10  # of so many frames one is used
MOVED = 30.0  # a pixel moves if it differs from the median picture by more than that, of 255; ours
SHOWN = 6  # which of the frames used is shown


@dataclass(frozen=True, eq=False, slots=True)
class Pedestrians:
    """Detections of skin in a real street by a model from rendered pictures.

    One frame (blue, green and red), what of it is taken for skin, and what is not as in the median
    picture; over all frames used, how many pixels are taken for skin, move, are both, and all.
    """

    frame: UInt8[np.ndarray, "height width 3"] = field(metadata={"webp": 60})
    skin: Bool[np.ndarray, "height width"]
    moving: Bool[np.ndarray, "height width"]
    pixels: int
    moves: int
    both: int
    total: int

    def table(self) -> Table:
        """Return how much of what moves and of what stands still is taken for skin."""
        still = (self.pixels - self.both) / max(self.total - self.moves, 1)
        rows = {
            "what moves": (self.moves / self.total, self.both / max(self.moves, 1)),
            "what stands still": (1 - self.moves / self.total, still),
        }
        columns = {
            "of the picture": "its share of all pixels of the frames used",
            "taken for skin": "which share of it is taken for skin",
        }
        return Table(rows, columns, "every tenth frame", "pixels")


def pedestrians(folder: Path, model: SkinModel) -> Pedestrians:
    """Look for skin in a video of a street."""
    (file,) = folder.glob("*.avi")
    frames = np.array([frame[..., ::-1] for frame in read_video(file)][::EVERY])
    prior = SkinRules().prior
    skin = model.log_ratio(frames) > np.log((1 - prior) / prior)
    moving = np.abs(frames - np.median(frames, axis=0)).max(axis=-1) > MOVED
    counts = (int(some.sum()) for some in (skin, moving, skin & moving))
    return Pedestrians(frames[SHOWN], skin[SHOWN], moving[SHOWN], *counts, skin.size)
