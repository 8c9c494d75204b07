"""Real pictures: an aloe seen by two eyes, a wall of graffiti from two sides, and a car's drive."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from robot_perception.cameras import StereoRig
from robot_perception.chapters.sift_association import table1
from robot_perception.datasets import read_depth_pair, read_kitti, read_plane_pair
from robot_perception.geometry import homographies, se3
from robot_perception.landmarks import (
    DescriptorClasses,
    Euclidean,
    Features,
    Sift,
    detect,
    follow,
    match_stereo,
    predict_pixels,
)
from robot_perception.teaching.recordings import Recording
from robot_perception.teaching.tables import Table

RIGHT_PX = 2.0
"""A match is right within so many pixels of the truth."""

MOST = Sift(most=700)
FAR = 1e6


@dataclass(frozen=True, eq=False, slots=True)
class Pair:
    """Two pictures with features, and where the features of the first are in the second.

    ``truth`` is not finite where nobody knows, stored as ``FAR``. Where the pair is not rectified,
    no row rule applies.
    """

    first: UInt8[np.ndarray, "height width"] = field(metadata={"webp": 60})
    pixels: Float[np.ndarray, "n 2"]
    others: Float[np.ndarray, "m 2"]
    descriptors: UInt8[np.ndarray, "n 128"]
    other_descriptors: UInt8[np.ndarray, "m 128"]
    truth: Float[np.ndarray, "n 2"]

    @property
    def known(self) -> Bool[np.ndarray, " n"]:
        """Which of the features have a known place in the other picture."""
        return self.truth[:, 0] < FAR / 2

    @property
    def there(self) -> Bool[np.ndarray, " n"]:
        """Which of the features have a feature of the other picture where they must be."""
        gaps = np.linalg.norm(self.truth[:, None] - self.others, axis=-1)
        return self.known & (gaps.min(axis=1) <= RIGHT_PX)


@dataclass(frozen=True, eq=False, slots=True)
class Chosen:
    """Which feature of the second picture each of the first is taken for, -1 for none."""

    others: Int[np.ndarray, " n"]
    right: Bool[np.ndarray, " n"]

    @property
    def share(self) -> float:
        """Share of the matches of known features that are right; 1 if there is none."""
        taken = self.others >= 0
        return float(self.right[taken].mean()) if taken.any() else 1.0


def choose(pair: Pair, rows: float, threshold: float, ratio: float) -> Chosen:
    """Match the features whose truth is known, by row, distance and ratio of distances.

    The ratio is that of the nearest to the second nearest of those in the rows (Lowe); with 1 it
    never decides.
    """
    distances = _distances(pair)
    apart = np.abs(pair.pixels[:, None, 1] - pair.others[:, 1])
    distances = np.where(apart <= rows, distances, np.inf)
    order = np.argpartition(distances, 1, axis=1)[:, :2]
    two = np.take_along_axis(distances, order, axis=1)
    near = np.take_along_axis(order, two.argmin(axis=1)[:, None], axis=1)[:, 0]
    first, second = two.min(axis=1), two.max(axis=1)
    good = (first <= threshold) & pair.known
    if ratio < 1:
        good &= first <= ratio * second
    others = np.where(good, near, -1)
    gaps = np.linalg.norm(pair.others[near] - pair.truth, axis=1)
    return Chosen(others, good & (gaps <= RIGHT_PX))


def _distances(pair: Pair) -> Float[np.ndarray, "n m"]:
    nearest = Euclidean(pair.other_descriptors.astype(float))
    return np.sqrt(nearest.distances(pair.descriptors.astype(float)))


def aloe(folder: Path) -> Pair:
    """Find the features of the aloe, at half its size, and where they are by its disparities."""
    pair = read_depth_pair(folder)
    half = (pair.left.shape[1] // 2, pair.left.shape[0] // 2)
    left, right = (
        cv2.resize(p, half, interpolation=cv2.INTER_AREA) for p in (pair.left, pair.right)
    )
    one, two = detect(left, MOST), detect(right, MOST)
    # pixel centres are whole: (u + 1/2) / 2 - 1/2
    at = np.rint(2 * one.pixels + 0.5).astype(int)
    shift = pair.disparity[
        at[:, 1].clip(0, pair.disparity.shape[0] - 1), at[:, 0].clip(0, pair.disparity.shape[1] - 1)
    ]
    truth = one.pixels - np.stack([shift / 2, np.zeros(len(shift))], axis=1)
    return _pair(left, one, two, np.where((shift > 0)[:, None], truth, FAR))


def graf(folder: Path) -> Pair:
    """Find the features of the wall of graffiti, and where they are by its homography."""
    pair = read_plane_pair(folder)
    one, two = detect(pair.first, MOST), detect(pair.second, MOST)
    truth = homographies.apply(pair.homography, one.pixels)
    high, wide = pair.second.shape
    inside = ((truth >= 0) & (truth <= [wide - 1, high - 1])).all(axis=1)
    return _pair(pair.first, one, two, np.where(inside[:, None], truth, FAR))


def _pair(first: np.ndarray, one: Features, two: Features, truth: np.ndarray) -> Pair:
    return Pair(
        first,
        one.pixels,
        two.pixels,
        one.descriptors.astype(np.uint8),
        two.descriptors.astype(np.uint8),
        truth,
    )


@dataclass(frozen=True, eq=False, slots=True)
class RealTracks:
    """Table 1 on a drive of a car: shares of right assignments (%) by model and tracked frames.

    Frames are tracked and then, ``gap`` frames later, features are assigned to the classes. Right
    is who projects to the feature by stereo and the recorded poses.
    """

    tracked: Int[np.ndarray, " k"]
    right: Mapping[str, Float[np.ndarray, " k"]]
    landmarks: Int[np.ndarray, " k"]
    descriptors: Int[np.ndarray, " k"]
    gap: int

    def table(self) -> Table:
        """Return the shares."""
        columns = {f"p = {p}": "" for p in self.tracked}
        about = f"right assignments (%), {self.gap} frames after the track"
        return Table(
            {name: [float(v) for v in row] for name, row in self.right.items()},
            columns,
            about,
            "decided by",
        )


MODELS = (table1.EUCLID, "raw", "floored", "shrunk", "pooled")


def kitti(folder: Path, tracked: tuple[int, ...] = (3, 5), gap: int = 3) -> RealTracks:
    """Track features of a drive, and assign later ones to the landmarks."""
    drive = read_kitti(folder)
    pairs = [(detect(left, MOST), detect(right, MOST)) for left, right in drive.frames]
    rig = drive.calibration.rig(drive.frames.size)
    lefts = [left for left, _ in pairs]
    ahead = [_expected(pairs, rig, drive.poses, k) for k in range(len(pairs) - 1)]
    config = table1.Config()
    right: dict[str, list[float]] = {name: [] for name in MODELS}
    counts, numbers = [], []
    for p in tracked:
        hits: dict[str, int] = dict.fromkeys(MODELS, 0)
        tests = known = 0
        for end in range(p - 1, len(pairs) - gap):
            stacks, points = _landmarks(pairs, ahead, rig, end, p)
            if len(stacks) < 2:
                continue
            later = lefts[end + gap]
            moved = se3.act(se3.between(drive.poses[end + gap], drive.poses[end]), points)
            front = moved[:, 2] > 0.5
            at = np.full((len(moved), 2), FAR)
            at[front] = rig.camera.project(moved[front])
            gaps = np.linalg.norm(later.pixels[:, None] - at, axis=-1)
            same = gaps <= RIGHT_PX
            rows = np.flatnonzero(same.any(axis=1))
            mean = stacks.mean(axis=1)
            squares = ((stacks - mean[:, None]) ** 2).sum(axis=1)
            classes = DescriptorClasses(mean, squares, np.full(len(mean), p))
            for name in MODELS:
                found = table1.decide_by(name, classes, config).two_nearest(later.descriptors[rows])
                hits[name] += int(same[rows, found.classes[:, 0]].sum())
            tests, known = tests + len(rows), known + len(stacks)
        for name in MODELS:
            right[name].append(100 * hits[name] / max(tests, 1))
        counts.append(known)
        numbers.append(tests)
    return RealTracks(
        np.array(tracked),
        {name: np.array(row) for name, row in right.items()},
        np.array(counts),
        np.array(numbers),
        gap,
    )


def _points(
    pair: tuple[Features, Features], rig: StereoRig
) -> tuple[Int[np.ndarray, " n"], Float[np.ndarray, "n 3"]]:
    """Return the features of a left picture that have a partner, and their points, m."""
    left, right = pair
    first, second = match_stereo(left, right).T
    measured = np.concatenate([left.pixels[first], right.pixels[second, :1]], axis=1)
    return first, rig.triangulate(measured, 0.5).mean


def _expected(
    pairs: list[tuple[Features, Features]],
    rig: StereoRig,
    poses: Float[np.ndarray, "k 4 4"],
    k: int,
) -> Float[np.ndarray, "n 2"]:
    """Return where the features of a left picture are expected in the next, by depth and motion."""
    rows, points = _points(pairs[k], rig)
    at = np.full(pairs[k][0].pixels.shape, np.inf)
    at[rows] = predict_pixels(points, se3.between(poses[k + 1], poses[k]), rig.camera)
    return at


def _landmarks(
    pairs: list[tuple[Features, Features]],
    expected: list[Float[np.ndarray, "n 2"]],
    rig: StereoRig,
    end: int,
    p: int,
) -> tuple[Float[np.ndarray, "n p 128"], Float[np.ndarray, "n 3"]]:
    """Return the descriptors of tracks over p frames, and their points in the last of them."""
    begin = end - p + 1
    part = [left for left, _ in pairs[begin : end + 1]]
    tracks = follow(part, predictions=expected[begin:end])
    rows = np.array([t.rows for t in tracks if len(t) == p], dtype=int).reshape(-1, p)
    first, points = _points(pairs[end], rig)
    at = {int(row): k for k, row in enumerate(first)}
    rows = rows[np.array([int(row) in at for row in rows[:, -1]], dtype=bool)]
    stacks = np.stack([part[k].descriptors[rows[:, k]] for k in range(p)], axis=1).astype(float)
    return stacks, points[[at[int(row)] for row in rows[:, -1]]].reshape(-1, 3)


ALOE = Recording("image_pairs", aloe, Pair, store="association-aloe")
GRAF = Recording("image_pairs", graf, Pair, store="association-graf")
STRAIGHT, TURN = (
    Recording(f"kitti_stereo_{name}", partial(kitti), RealTracks, store=f"association-{name}")
    for name in ("straight", "turn")
)
