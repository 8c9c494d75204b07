"""Stereo SIFT against the two OpenCV calls in it; matching of descriptors against OpenCV's matcher.

Descriptors are drawn like OpenCV's: gamma variates, rounded, of length 512 or so.
"""

import time

import cv2
import numpy as np

from robot_perception.cameras import Pinhole, StereoRig
from robot_perception.landmarks import Euclidean, Mahalanobis, observe
from tests.tools.benchmarks.harness import Row, Timing

QUERIES, CLASSES = 300, 1500


def stereo_pair() -> tuple[np.ndarray, np.ndarray]:
    """A wall of blots of all sizes, at a disparity of 12 px; some 200 features."""
    rng = np.random.default_rng(0)
    wall = np.zeros((240, 400), np.float32)
    for size in (2, 4, 8):
        blots = cv2.GaussianBlur(rng.standard_normal(wall.shape).astype(np.float32), (0, 0), size)
        wall += blots / blots.std()
    grey = np.clip(128 + 12 * wall, 0, 255).astype(np.uint8)
    return np.ascontiguousarray(grey[:, 20:340]), np.ascontiguousarray(grey[:, 32:352])


def descriptors(count: int, rng: np.random.Generator) -> np.ndarray:
    """Return descriptors that look like OpenCV's."""
    raw = rng.gamma(0.6, size=(count, 128))
    return np.rint(512 * raw / np.linalg.norm(raw, axis=1)[:, None]).astype(np.float32)


def _stereo() -> Row:
    left, right = stereo_pair()
    rig = StereoRig(Pinhole((300.0, 300.0), (159.5, 119.5), (320, 240)), 0.12)
    finder = cv2.SIFT_create(enable_precise_upscale=True)

    def agree() -> None:
        points = observe(left, right, rig)
        assert points.found == tuple(
            len(finder.detectAndCompute(image, None)[0]) for image in (left, right)
        )
        depth = points.points.mean[:, 2]
        assert np.median(np.abs(depth - 3.0)) < 0.05, np.median(depth)  # 300 px × 0.12 m / 12 px

    return Row(
        work="landmarks of a stereo pair of 320 × 240 px by SIFT, to points with covariance",
        ours=lambda: observe(left, right, rig),
        peer=lambda: [finder.detectAndCompute(image, None) for image in (left, right)],
        peer_name="two calls of OpenCV",
        ratio=1 / 1.2,
        agree=agree,
    )


def _matching() -> list[Row]:
    rng = np.random.default_rng(0)
    single = descriptors(CLASSES, rng)
    means = single.astype(float)  # as classes have them
    found = np.rint(means[rng.integers(CLASSES, size=QUERIES)] + rng.normal(0, 12, (QUERIES, 128)))
    found = np.maximum(found, 0).astype(np.float32)
    variances = rng.uniform(20.0, 400.0, means.shape)
    matcher = cv2.BFMatcher(cv2.NORM_L2)

    def agree() -> None:
        pairs = matcher.knnMatch(found, single, k=2)
        nearest = Euclidean(means).two_nearest(found)
        np.testing.assert_array_equal(
            nearest.classes, [[match.trainIdx for match in pair] for pair in pairs]
        )
        np.testing.assert_allclose(
            np.sqrt(nearest.distances), [[m.distance for m in pair] for pair in pairs], rtol=1e-5
        )

    def agree_mahalanobis() -> None:
        nearest = Mahalanobis(means, variances).two_nearest(found)
        apart = found[:, None] - means
        squared = (apart**2 / variances).sum(axis=-1)
        np.testing.assert_array_equal(nearest.classes, np.argsort(squared, axis=1)[:, :2])

    work = f"landmarks by descriptor, two nearest of {CLASSES} to each of {QUERIES}"
    return [
        Row(
            work=f"{work}, Euclidean",
            ours=lambda: Euclidean(means).two_nearest(found),
            peer=lambda: matcher.knnMatch(found, single, k=2),
            peer_name="OpenCV BFMatcher",
            ratio=5,
            agree=agree,
            repeats=15,
        ),
        Row(
            work=f"{work}, Mahalanobis",
            ours=lambda: Mahalanobis(means, variances).two_nearest(found),
            peer=lambda: Euclidean(means).two_nearest(found),
            peer_name="ours, Euclidean",
            ratio=1 / 3,
            agree=agree_mahalanobis,
            repeats=15,
        ),
    ]


def growth(sizes: tuple[int, ...] = (750, 1500, 3000, 6000)) -> Timing:
    """Return the exponent of the time of an association against the size of the map.

    The work is linear. The limit lies 0.2 above, as a large map leaves the processor's caches.
    """
    rng, samples = np.random.default_rng(0), []
    maps = [descriptors(size, rng).astype(float) for size in sizes]
    found = descriptors(QUERIES, rng)
    for _ in range(7):
        for means in maps:  # in turn, so that a busy spell hits all sizes
            begin = time.perf_counter()
            Mahalanobis(means, np.ones_like(means)).two_nearest(found)
            samples.append(time.perf_counter() - begin)
    seconds = np.median(np.reshape(samples, (-1, len(sizes))), axis=0)
    exponent = float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
    return Timing(
        work=f"landmarks by descriptor, map of {sizes[0]} to {sizes[-1]}: exponent {exponent:.2f}",
        ours_s=float(seconds[-1]),
        peer_s=None,
        peer_name="",
        target="exponent ≤ 1.2",
        reached=exponent <= 1.2,
    )


def rows() -> list[Row | Timing]:
    """Return the rows of the benchmark table that concern visual landmarks."""
    cv2.setNumThreads(1)  # one core, as for everything else
    return [_stereo(), *_matching(), growth()]
