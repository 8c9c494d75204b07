"""Two real photographs: a wall seen from two sides, and an aloe that is turned and brought closer.

No recording of a ceiling was found. The wall's first picture is warped step by step towards the
second; the last picture is the second itself. The aloe is one photograph, moved by us.
"""

from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from robot_perception.ceiling.contours import find_contours, find_edges
from robot_perception.ceiling.patterns import WindowRules, interest_windows, make_pattern
from robot_perception.ceiling.tracker import PatternTracker
from robot_perception.chapters.pattern_tracking.scene import RULES, SIGMAS
from robot_perception.datasets import read_depth_pair, read_plane_pair
from robot_perception.geometry import homographies
from studies.stored.recordings import Recording
from studies.tables import Table

STEPS = 16
"""Steps from the first picture to the last."""
NEAR = 5.0
"""A pattern is held that is no further off, px; ours, one σ of the walk."""
WINDOWS = WindowRules(most=12, rival=0.9)
"""Rules for as many patterns as are distinctive, up to twelve: paint repeats more than ceilings."""
BORDER = 40.0
SWING = np.array([30.0, -20.0, np.deg2rad(20.0), 0.3])
"""Motion of the aloe: moved, turned and brought closer, as the wall's patterns may be by theirs."""


@dataclass(frozen=True, eq=False, slots=True)
class Real:
    """Patterns in a photograph, and where they are taken to be in the end.

    Parameters
    ----------
    first, last : (height, width)
        The pictures.
    places : (n, 2)
        Middles of the patterns in the first, px.
    found, truth : (n, 4)
        In the last: as tracked, and as known; of the truth the scale is that of areas.
    off : (steps, n)
        Distance from the truth in each picture, px.
    """

    first: UInt8[np.ndarray, "height width"] = field(metadata={"webp": 60})
    last: UInt8[np.ndarray, "height width"] = field(metadata={"webp": 60})
    places: Float[np.ndarray, "n 2"]
    found: Float[np.ndarray, "n 4"]
    truth: Float[np.ndarray, "n 4"]
    off: Float[np.ndarray, "steps n"]

    @property
    def held(self) -> np.ndarray:
        """Mask of the patterns that are where they must be in the last picture."""
        return self.off[-1] <= NEAR

    def row(self) -> list[float]:
        """Return patterns, those held, and the median error of these in the last picture, px."""
        return [len(self.places), int(self.held.sum()), float(np.median(self.off[-1][self.held]))]


@dataclass(frozen=True, eq=False, slots=True)
class Photographs:
    """Both of them."""

    wall: Real
    aloe: Real

    def table(self) -> Table:
        """Return how many patterns are held."""
        rows = {"wall, to its second picture": self.wall.row(), "aloe, moved": self.aloe.row()}
        columns = {
            "patterns": "chosen in the first picture",
            "held": f"of these, within {NEAR:g} px in the last",
            "error": "of these, median, px",
        }
        return Table(rows, columns, f"one pair and one photograph, {STEPS} steps", "photograph")


def photographs(folder: Path) -> Photographs:
    """Track patterns of both photographs, always with the same draws."""
    pair = read_plane_pair(folder)
    halfway = [np.eye(3) + k / STEPS * (pair.homography - np.eye(3)) for k in range(1, STEPS + 1)]
    films = [_warped(pair.first, H) for H in halfway[:-1]]
    wall = tracked(pair.first, [*films, pair.second], halfway)
    aloe = cv2.resize(read_depth_pair(folder).left, None, fx=0.5, fy=0.5,
                      interpolation=cv2.INTER_AREA)  # fmt: skip
    moves = [similarity(k / STEPS * SWING, aloe.shape) for k in range(1, STEPS + 1)]
    return Photographs(wall, tracked(aloe, [_warped(aloe, H) for H in moves], moves))


def similarity(move: Float[np.ndarray, " 4"], shape: tuple[int, ...]) -> Float[np.ndarray, "3 3"]:
    """Return the motion of a picture by (x, y, θ, s - 1) about its middle."""
    c, s = (1 + move[3]) * np.cos(move[2]), (1 + move[3]) * np.sin(move[2])
    turn, middle = np.array([[c, -s], [s, c]]), (np.array(shape[::-1]) - 1) / 2
    H = np.eye(3)
    H[:2, :2], H[:2, 2] = turn, middle + move[:2] - turn @ middle
    return H


def _warped(image: np.ndarray, H: np.ndarray) -> np.ndarray:
    return cv2.warpPerspective(image, H, image.shape[::-1], borderMode=cv2.BORDER_REPLICATE)


def tracked(first: np.ndarray, pictures: list[np.ndarray], motions: list[np.ndarray]) -> Real:
    """Choose patterns that stay in view, and follow them to the last picture."""
    edges = find_edges(first)
    contours = find_contours(edges)
    windows = interest_windows(edges, contours, WINDOWS)
    windows = [w for w in windows if _stays(np.array(w.centre), motions, first.shape)]
    places, rng = np.array([w.centre for w in windows]), np.random.default_rng(12)
    found, off = [], []
    for place in places:
        tracker = PatternTracker(make_pattern(first, tuple(place.tolist())), RULES)
        state, errors = tracker.start(np.array([*place, 0.0, 1.0])), []
        for image, H in zip(pictures, motions, strict=True):
            state, info = tracker.step(state, image, rng=rng)
            errors.append(np.hypot(*(info.pose - carried(place, H))[:2]))
        found.append(info.pose)
        off.append(errors)
    truth = np.array([carried(place, motions[-1]) for place in places])
    return Real(first, pictures[-1], places, np.array(found), truth, np.array(off).T)


def _stays(place: np.ndarray, motions: list[np.ndarray], shape: tuple[int, ...]) -> bool:
    """Tell whether a place keeps off the border in every picture."""
    at = np.array([homographies.apply(H, place[None])[0] for H in motions])
    size = np.array(shape[::-1])
    return bool(((at >= BORDER) & (at <= size - 1 - BORDER)).all())


def carried(place: Float[np.ndarray, "2"], H: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, " 4"]:
    """Return where a motion takes a pattern: of its derivative there the turn and the area."""
    step = 0.5
    around = place + step * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    at, east, west, south, north = homographies.apply(H, around)
    J = np.column_stack([east - west, south - north]) / (2 * step)
    turn = np.arctan2(J[1, 0] - J[0, 1], J[0, 0] + J[1, 1])
    return np.array([*at, turn, np.sqrt(abs(np.linalg.det(J)))])


PHOTOGRAPHS = Recording("image_pairs", photographs, Photographs, "pattern-photographs")
PER_STEP = float(np.hypot(*(SWING[:2] / STEPS / SIGMAS[:2])))
"""Motion of the aloe from picture to picture, σ of the walk."""
