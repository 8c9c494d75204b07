"""Which landmark is it: by which distance, and in whose map?"""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float, Int

from robot_perception.chapters.visual_slam import drives, frontend
from robot_perception.chapters.visual_slam.drives import Options
from robot_perception.chapters.visual_slam.frontend import Seen
from robot_perception.landmarks.metrics import METRICS
from robot_perception.slam.visual import Looks, Newcomers

# The limits --------------------------------------------------------------------------------------

EUCLID, FIRST, RAW, SHRUNK = METRICS


def limits() -> dict[str, float]:
    """Return by metric the limit that as many right pairs pass as the filter's own one.

    Right pairs are those of `right_pairs` in the buildings of `frontend.CHOOSING`.
    """
    found = [right_pairs(frontend.seen(building=k)) for k in frontend.CHOOSING]
    distances = {name: np.concatenate([own[name] for own in found]) for name in METRICS}
    share = np.mean(distances[EUCLID] <= Options().limit)
    return {name: float(np.quantile(own, share)) for name, own in distances.items()}


def right_pairs(seen: Seen) -> dict[str, Float[np.ndarray, "pairs"]]:
    """Return by metric how unlike a track is that shows the place of an earlier one."""
    rows = beginnings(seen)
    shown = seen.descriptors[rows].astype(float)
    means = shown.mean(axis=1)
    squares = ((shown - means[:, None]) ** 2).sum(axis=1)
    looks = Looks(shown[:, 0], means, squares, np.full(len(rows), rows.shape[1]))
    made = rows[:, -1]
    before = seen.frames[rows[:, 0]][:, None] > seen.frames[made]
    gaps = np.where(before, drives.apart(seen, made, made), np.inf)
    new = np.flatnonzero(np.isfinite(gaps).any(axis=1))
    old, asked = gaps[new].argmin(axis=1), Newcomers(made[new], means[new], looks)
    return {name: metric(asked)[np.arange(len(new)), old] for name, metric in METRICS.items()}


def beginnings(seen: Seen) -> Int[np.ndarray, "tracks frames"]:
    """Return the points by which each stable track was looked up, those of its first frames."""
    lengths = np.bincount(seen.tracks)
    starts = np.cumsum(lengths) - lengths
    first = starts[lengths > Options().stable][:, None] + np.arange(Options().stable + 1)
    return np.lexsort((seen.frames, seen.tracks))[first]
