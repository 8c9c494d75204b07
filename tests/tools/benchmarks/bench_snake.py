"""Segmentations and affine snakes: against NumPy and the line-by-line version, and their limits."""

import numpy as np

from robot_perception.appearance import affine_snake as snakes
from robot_perception.appearance import segmentation
from tests.tools.benchmarks.harness import Row

SHAPE = (240, 320)


def _ellipse(points: int, u: float, v: float, size: float = 1.0) -> np.ndarray:
    t = 2 * np.pi * np.arange(points) / points
    return np.stack([u + 45 * size * np.cos(t), v + 28 * size * np.sin(t)], axis=-1)


def _fit() -> Row:
    """Return the row of a fit of 80 points in 40 steps, the distances of the edges included."""
    there, start = _ellipse(80, 160, 120), _ellipse(80, 166, 124, 1.15)
    edges = segmentation.boundary(segmentation.filled(there, SHAPE))
    rules = snakes.SnakeRules(steps=40)

    def agree() -> None:
        slow, quick = (rule(start, edges, rules) for rule in (snakes.step_by_step, fitted))
        np.testing.assert_allclose(quick.outline, slow.outline, atol=1e-7)

    fitted = snakes.affine_snake
    return Row(
        work="affine snake, 80 points, 40 steps, 320 × 240",
        ours=lambda: fitted(start, edges, rules),
        peer=lambda: snakes.step_by_step(start, edges, rules),
        peer_name="line by line",
        at_most=1e-3,
        agree=agree,
        inner=20,
    )


def _segmentation() -> Row:
    """Return the row of looking up 320 × 240 pixels in a histogram of 16³ bins."""
    rng = np.random.default_rng(0)
    index = rng.integers(0, 16**3, SHAPE).astype(np.int32)
    histogram = rng.integers(0, 2, 16**3).astype(float)

    def peer() -> np.ndarray:
        return (histogram > 0)[index]

    def agree() -> None:
        np.testing.assert_array_equal(segmentation.segment(index, histogram), peer())

    return Row(
        work="segmentation by a histogram, 16³ bins, 320 × 240",
        ours=lambda: segmentation.segment(index, histogram),
        peer=peer,
        peer_name="NumPy",
        agree=agree,
        inner=20,
    )


def _blob() -> Row:
    """Return the row of the steps from a segmentation to the edges of the object's blob."""
    rng = np.random.default_rng(1)
    near = _ellipse(80, 160, 120)
    mask = segmentation.filled(near, SHAPE) ^ (rng.random(SHAPE) < 0.05)

    def ours() -> np.ndarray:
        return segmentation.blob(segmentation.clean(mask), near).boundary()

    def agree() -> None:
        found = segmentation.blob(segmentation.clean(mask), near)
        true = segmentation.filled(near, SHAPE)
        assert (found.mask & true).sum() > 0.9 * (found.mask | true).sum()

    return Row(
        work="blob and its edges, a segmentation with 5 % noise, 320 × 240",
        ours=ours,
        at_most=2e-3,
        agree=agree,
        inner=20,
    )


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern segmentations and snakes."""
    return [_fit(), _segmentation(), _blob()]
