"""Real legs that others marked, and real pedestrians: what is found, and what is taken for it."""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, UInt8

from robot_perception.chapters.people_sensors import sessions
from robot_perception.datasets import LegScans, read_leg_scans, read_video
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, proportion
from robot_perception.people import legs
from robot_perception.people.legs import LegRules
from robot_perception.people.skin import SkinRules
from robot_perception.teaching.recordings import Recording
from robot_perception.teaching.tables import Table

MARKED = ("positive_1", "positive_2", "positive_3")
PAPER_REACH = 3.0  # below that leg pairs are found very well, says the paper, m
EMPTY = ("negative_2_left", "negative_2_right")
RULES = LegRules()
BOUNDS = (0.0, 1.0, 2.0, 3.0, 4.0, 5.0)
NEAR = 0.2  # a leg is found if one is reported within that of its mark, m; ours
BESIDE = 0.3  # a pair, if a person is reported within that of its middle, m; ours
THIRD = 3  # every third beam of the scanner of 0.35° gives about the paper's degree
FAR = 60.0  # stored where nothing came back, m


# Legs --------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class Legs:
    """What the detector makes of real scans, with all beams (fine) and with every third (coarse).

    How far away each marked leg is (m), and whether it is found; the same of marked pairs, two legs
    a step apart, and of the persons reported; persons reported in scans without people; and one
    scan with many legs (m and rad, ``FAR`` where nothing came back), the legs marked in it, and
    those that are found with every third beam (m).
    """

    distances: Float[np.ndarray, " legs"]
    fine: Bool[np.ndarray, " legs"]
    coarse: Bool[np.ndarray, " legs"]
    pairs: Float[np.ndarray, " pairs"]
    pairs_fine: Bool[np.ndarray, " pairs"]
    pairs_coarse: Bool[np.ndarray, " pairs"]
    persons_fine: Float[np.ndarray, " scans"]
    persons_coarse: Float[np.ndarray, " scans"]
    ranges: Float[np.ndarray, " beams"]
    angles: Float[np.ndarray, " beams"]
    marked: Float[np.ndarray, "k 2"]
    found: Float[np.ndarray, "m 2"]

    def table(self) -> Table:
        """Return the share found by distance, for both gaps between beams."""
        rows = {}
        for low, high in itertools.pairwise(BOUNDS):
            rows[f"{low:g} to {high:g} m"] = [
                _share(hits[(distances >= low) & (distances < high)])
                for distances, hits in (
                    (self.distances, self.coarse),
                    (self.distances, self.fine),
                    (self.pairs, self.pairs_coarse),
                    (self.pairs, self.pairs_fine),
                )
            ]
        columns = {
            f"{what}, {gap}": f"share of the marked {what} that are found, with beams so far apart"
            for what in ("legs", "pairs")
            for gap in ("1.05°", "0.35°")
        }
        return Table(rows, columns, "95 % interval by Wilson, as if they were independent", "away")

    @property
    def near(self) -> Interval:
        """Share of the pairs within the paper's 3 m that are found with every third beam."""
        return _share(self.pairs_coarse[self.pairs < PAPER_REACH])

    @property
    def nobody(self) -> tuple[Interval, Interval]:
        """Persons reported in a scan of nobody: with every third beam, and with all."""
        return bootstrap_mean(self.persons_coarse), bootstrap_mean(self.persons_fine)


def walkers(folder: Path) -> Legs:
    """Run the detector on the scans with marks, and on those of an empty floor."""
    with_legs, empty = (
        [read_leg_scans(folder / f"{name}.npz") for name in names] for names in (MARKED, EMPTY)
    )
    marked = [
        (scans, k, scans.legs[scans.scans_of_legs == k])
        for scans in with_legs
        for k in np.unique(scans.scans_of_legs).tolist()
    ]
    hits = [
        [_hits(_legs(scans, k, every), there, NEAR) for scans, k, there in marked]
        for every in (1, THIRD)
    ]
    middles = [there[legs.pairs(there, RULES)].mean(axis=1) for *_, there in marked]
    both = [
        [
            _hits(_persons_in(scans, k, every), middle, BESIDE)
            for (scans, k, _), middle in zip(marked, middles, strict=True)
        ]
        for every in (1, THIRD)
    ]
    scans, k, there = max(marked, key=lambda one: len(one[-1]))
    return Legs(
        np.concatenate([np.hypot(*there.T) for *_, there in marked]),
        *(np.concatenate(some) for some in hits),
        np.hypot(*np.concatenate(middles).T),
        *(np.concatenate(some) for some in both),
        *(_persons(empty, every) for every in (1, THIRD)),
        np.where(np.isfinite(scans.ranges[k]), scans.ranges[k], FAR),
        scans.angles,
        there,
        _legs(scans, k, THIRD),
    )


def _legs(scans: LegScans, k: int, every: int) -> Float[np.ndarray, "m 2"]:
    seen = legs.profiles(scans.ranges[k, ::every], scans.angles[::every], RULES)
    return seen.middles[legs.are_legs(seen, RULES)]


def _persons_in(scans: LegScans, k: int, every: int) -> Float[np.ndarray, "m 2"]:
    found = legs.detect(scans.ranges[k, ::every], scans.angles[::every], RULES)
    return sessions.points(found.mean)


def _persons(empty: Iterable[LegScans], every: int) -> Float[np.ndarray, " scans"]:
    counts = [
        len(_persons_in(scans, k, every)) for scans in empty for k in range(len(scans.ranges))
    ]
    return np.array(counts, dtype=float)


def _hits(found: np.ndarray, marked: np.ndarray, reach: float) -> Bool[np.ndarray, " marked"]:
    """Tell which marked places are found, each by one of its own within reach, m."""
    apart = np.hypot(*(marked[:, None] - found).transpose(2, 0, 1))
    return np.isin(np.arange(len(marked)), sessions.own(apart, reach)[0])


def _share(hits: np.ndarray) -> Interval:
    return proportion(int(hits.sum()), hits.size)


# Pedestrians -------------------------------------------------------------------------------------

EVERY = 10  # of so many frames one is used
MOVED = 30.0  # a pixel moves if it differs from the median picture by more than that, of 255; ours
SHOWN = 6  # which of the frames used is shown


@dataclass(frozen=True, eq=False, slots=True)
class Pedestrians:
    """What a model of skin from rendered pictures finds in a real street.

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


def pedestrians(folder: Path) -> Pedestrians:
    """Look for skin in a video of a street."""
    (file,) = folder.glob("*.avi")
    frames = np.array([frame[..., ::-1] for frame in read_video(file)][::EVERY])
    model, prior = sessions.skin_model(), SkinRules().prior
    skin = model.log_ratio(frames) > np.log((1 - prior) / prior)
    moving = np.abs(frames - np.median(frames, axis=0)).max(axis=-1) > MOVED
    counts = (int(some.sum()) for some in (skin, moving, skin & moving))
    return Pedestrians(frames[SHOWN], skin[SHOWN], moving[SHOWN], *counts, skin.size)


LEGS = Recording("leg_scans", walkers, Legs, "people-legs")
VIDEO = Recording("people_video", pedestrians, Pedestrians, "people-video")
