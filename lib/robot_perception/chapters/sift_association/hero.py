"""Two places of one building that carry the same print: what a nearest descriptor makes of them."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from jaxtyping import Bool, Float, UInt8

from data_synth import stereo
from data_synth.stereo import Rig
from data_synth.textured_building import drive, make_textured_building
from robot_perception.chapters.sift_association.views import APART, Places, place
from robot_perception.landmarks import Euclidean, Features, detect
from robot_perception.teaching.recorded import recorded

GAP = 10
"""Between the two pictures, px."""
NEAR = 200.0
"""Of descriptors, whose length is 512: within that they are taken for one landmark's."""
FAR_AWAY = 5.0
"""How far apart the robot stands at the two places, at least, m."""


@dataclass(frozen=True, eq=False, slots=True)
class Hero:
    """Two pictures side by side, which features of the right one (``here``) are taken for which of
    the left one (``there``), px, and which of these pairs show the same place; here none can.
    """

    image: UInt8[np.ndarray, "height width"]
    here: Float[np.ndarray, "n 2"]
    there: Float[np.ndarray, "n 2"]
    right: Bool[np.ndarray, " n"]
    metres: float


@recorded("association-doors")
def doors(seed: int = 1, count: int = 60) -> Hero:
    """Return the two places along a drive that look most alike."""
    world, path, own = np.random.default_rng(seed).spawn(3)
    building, rig = make_textured_building(rng=world), Rig()
    poses = drive(building, rng=path, poses=count)
    images = list(stereo.left_frames(building.scene, rig, poses, rng=own))
    seen = [detect(image) for image in images]
    spots = [place(building.scene, rig, *of) for of in zip(poses, seen, strict=True)]
    metres = np.linalg.norm(poses[:, None, :2] - poses[:, :2], axis=-1)
    pairs = [pair for pair in combinations(range(count), 2) if metres[pair] > FAR_AWAY]
    i, j = max(pairs, key=lambda pair: _alike(*(spots[k] for k in pair)))
    rows, others = _matches(seen[j], seen[i])
    here, there = spots[j][rows], spots[i][others]
    apart = np.linalg.norm(here["points"] - there["points"], axis=1)
    return Hero(
        np.hstack([images[i], np.full((rig.size[1], GAP), 255, dtype=np.uint8), images[j]]),
        seen[j].pixels[rows] + np.array([rig.size[0] + GAP, 0.0]),
        seen[i].pixels[others],
        (apart < APART) & (here["carriers"] == there["carriers"]),
        float(metres[i, j]),
    )


def _matches(here: Features, there: Features) -> tuple[np.ndarray, np.ndarray]:
    """Return which features of one picture are within reach of one of the other."""
    nearest = Euclidean(there.descriptors.astype(float)).two_nearest(here.descriptors)
    others = nearest.within(NEAR**2, ratio=0.8)
    rows = np.flatnonzero(others >= 0)
    return rows, others[rows]


def _alike(one: Places, two: Places) -> int:
    """Count features that show the same spot of the same print, and not the same place."""
    one, two = (places[places["carriers"] >= 0] for places in (one, two))
    gaps = np.linalg.norm(one["spots"][:, None] - two["spots"], axis=-1)
    alike = (gaps < APART) & (one["pictures"][:, None] == two["pictures"])
    ratio = np.abs(np.log2(one["sizes"][:, None] / two["sizes"]))
    away = np.linalg.norm(one["points"][:, None] - two["points"], axis=-1)
    return int((alike & (ratio < 0.5) & (away > 1.0)).any(axis=1).sum())
