"""Real pictures: an aloe seen by two eyes, a wall of graffiti from two sides, and a car's drive."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from robot_perception.cameras import StereoRig
from robot_perception.datasets import read_depth_pair, read_kitti, read_plane_pair
from robot_perception.geometry import homographies, se3
from robot_perception.landmarks import (
    DescriptorClasses,
    Euclidean,
    Features,
    Mahalanobis,
    Sift,
    detect,
    floored_variances,
    follow,
    match_stereo,
    pooled_variances,
    predict_pixels,
    raw_variances,
    shrunk_variances,
)
from studies.stored.recordings import Recording
from studies.tables import Table

RIGHT_PX = 2.0
"""A match is right within so many pixels of the truth."""
MOST = Sift(most=700)
FAR = 1e6


@dataclass(frozen=True, eq=False, slots=True)
class Pair:
    """Two pictures with features, and where the features of the first are in the second.

    ``truth`` is ``FAR`` where nobody knows. Where the pair is not rectified, no row rule applies.
    """

    first: UInt8[np.ndarray, "height width"] = field(metadata={"webp": 60})
    pixels: Float[np.ndarray, "n 2"]
    others: Float[np.ndarray, "m 2"]
    descriptors: UInt8[np.ndarray, "n 128"]
    other_descriptors: UInt8[np.ndarray, "m 128"]
    truth: Float[np.ndarray, "n 2"]

    @property
    def known(self) -> Bool[np.ndarray, " n"]:
        """Mask of the features that have a known place in the other picture."""
        return self.truth[:, 0] < FAR / 2

    @property
    def there(self) -> Bool[np.ndarray, " n"]:
        """Mask of the features that have a feature of the other picture where they must be."""
        gaps = np.linalg.norm(self.truth[:, None] - self.others, axis=-1)
        return self.known & (gaps.min(axis=1) <= RIGHT_PX)


@dataclass(frozen=True, eq=False, slots=True)
class Chosen:
    """Feature of the second picture that each of the first is taken for, -1 for none."""

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
    others = Euclidean(pair.other_descriptors.astype(float))
    distances = np.sqrt(others.distances(pair.descriptors.astype(float)))
    distances[np.abs(pair.pixels[:, None, 1] - pair.others[:, 1]) > rows] = np.inf
    near = distances.argmin(axis=1)
    first, second = np.partition(distances, 1, axis=1)[:, :2].T
    good = (first <= threshold) & pair.known
    if ratio < 1:
        good &= first <= ratio * second
    gaps = np.linalg.norm(pair.others[near] - pair.truth, axis=1)
    return Chosen(np.where(good, near, -1), good & (gaps <= RIGHT_PX))


def aloe(folder: Path) -> Pair:
    """Find the features of the aloe, at half its size, and where they are by its disparities."""
    pair = read_depth_pair(folder)
    high, wide = pair.left.shape
    left, right = (
        cv2.resize(p, (wide // 2, high // 2), interpolation=cv2.INTER_AREA)
        for p in (pair.left, pair.right)
    )
    one, two = detect(left, MOST), detect(right, MOST)
    # pixel centres are whole: (u + 1/2) / 2 - 1/2
    at = np.rint(2 * one.pixels + 0.5).astype(int)[:, ::-1]
    shift = pair.disparity[*at.clip(0, np.array(pair.disparity.shape) - 1).T]
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
    looks = (side.descriptors.astype(np.uint8) for side in (one, two))
    return Pair(first, one.pixels, two.pixels, *looks, truth)


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
        rows = {name: row.tolist() for name, row in self.right.items()}
        return Table(rows, columns, about, "decided by")


VARIANCES = {
    "raw": raw_variances,
    "floored": partial(floored_variances, least=100.0),
    "shrunk": partial(shrunk_variances, strength=10.0),
    "pooled": pooled_variances,
}
"""Estimates as those of Table 1."""
MODELS = ("Euclid", *VARIANCES)


def kitti(folder: Path, tracked: tuple[int, ...] = (3, 5), gap: int = 3) -> RealTracks:
    """Track features of a drive, and assign later ones to the landmarks."""
    drive = read_kitti(folder)
    rig, poses = drive.calibration.rig(drive.frames.size), drive.poses
    pairs = [(detect(left, MOST), detect(right, MOST)) for left, right in drive.frames]
    lefts, points = [left for left, _ in pairs], [_points(*pair, rig) for pair in pairs]
    ahead = [
        _expected(at, se3.between(poses[k + 1], poses[k]), rig) for k, at in enumerate(points[:-1])
    ]
    counts = np.zeros((len(tracked), 2 + len(MODELS)), dtype=int)
    for count, p in zip(counts, tracked, strict=True):
        for end in range(p - 1, len(pairs) - gap):
            begin = end - p + 1
            stacks, at = _landmarks(lefts[begin : end + 1], ahead[begin:end], points[end])
            if len(stacks) > 1:
                moved = se3.act(se3.between(poses[end + gap], poses[end]), at)
                count += _assigned(stacks, moved, lefts[end + gap], rig)
    known, tests, *hits = counts.T
    right = dict(zip(MODELS, 100 * np.array(hits) / np.maximum(tests, 1), strict=True))
    return RealTracks(np.array(tracked), right, known, tests, gap)


def _points(left: Features, right: Features, rig: StereoRig) -> Float[np.ndarray, "n 3"]:
    """Return the points of the features of a left picture, m; infinite without a partner."""
    first, second = match_stereo(left, right).T
    measured = np.concatenate([left.pixels[first], right.pixels[second, :1]], axis=1)
    points = np.full((len(left), 3), np.inf)
    points[first] = rig.triangulate(measured, 0.5).mean
    return points


def _expected(points: np.ndarray, motion: np.ndarray, rig: StereoRig) -> Float[np.ndarray, "n 2"]:
    """Return where the features of a left picture are expected in the next, by depth and motion."""
    known = np.isfinite(points[:, 0])
    at = np.full((len(points), 2), np.inf)
    at[known] = predict_pixels(points[known], motion, rig.camera)
    return at


def _landmarks(
    part: list[Features], expected: list[np.ndarray], points: Float[np.ndarray, "n 3"]
) -> tuple[Float[np.ndarray, "n p 128"], Float[np.ndarray, "n 3"]]:
    """Return the descriptors of tracks over all frames, and their points in the last of them."""
    tracks = follow(part, predictions=expected)
    rows = [t.rows for t in tracks if len(t) == len(part)]
    rows = np.array(rows, dtype=int).reshape(-1, len(part))
    rows = rows[np.isfinite(points[rows[:, -1], 0])]
    looks = [frame.descriptors[own] for frame, own in zip(part, rows.T, strict=True)]
    return np.stack(looks, axis=1).astype(float), points[rows[:, -1]]


def _assigned(
    stacks: np.ndarray, points: np.ndarray, later: Features, rig: StereoRig
) -> Int[np.ndarray, " counts"]:
    """Return how many landmarks there are, later features of theirs, and those assigned right."""
    front = points[:, 2] > 0.5
    at = np.full((len(points), 2), FAR)
    at[front] = rig.camera.project(points[front])
    same = np.linalg.norm(later.pixels[:, None] - at, axis=-1) <= RIGHT_PX
    rows = np.flatnonzero(same.any(axis=1))
    mean, tests = stacks.mean(axis=1), later.descriptors[rows]
    squares = ((stacks - mean[:, None]) ** 2).sum(axis=1)
    classes = DescriptorClasses(mean, squares, np.full(len(mean), stacks.shape[1]))
    rules = Euclidean(mean), *(Mahalanobis(mean, f(classes)) for f in VARIANCES.values())
    named = (rule.two_nearest(tests).classes[:, 0] for rule in rules)
    return np.array([len(stacks), len(rows), *(same[rows, own].sum() for own in named)])


ALOE = Recording("image_pairs", aloe, Pair, store="association-aloe")
GRAF = Recording("image_pairs", graf, Pair, store="association-graf")
STRAIGHT, TURN = (
    Recording(f"kitti_stereo_{name}", kitti, RealTracks, store=f"association-{name}")
    for name in ("straight", "turn")
)
