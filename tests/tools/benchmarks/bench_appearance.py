"""Colours of heads: histograms of boxes, incremental scores against the full count, a step."""

import cv2
import numpy as np

from robot_perception.appearance import head_ellipse
from robot_perception.appearance.colour_histograms import box_histograms, histogram
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.head_ellipse import Ellipse, HeadTracker
from tests.tools.benchmarks.harness import Row

SIZE = (320, 240)
BOXES = 1000
PEER_BOXES = 17500
"""Histograms of 50×50 boxes that pftracker counts in a second."""


def picture() -> np.ndarray:
    """Return a picture whose colours change smoothly, with noise, as photographs do."""
    rng = np.random.default_rng(0)
    coarse = rng.integers(0, 256, (SIZE[1] // 16, SIZE[0] // 16, 3), dtype=np.uint8)
    smooth = cv2.resize(coarse, SIZE, interpolation=cv2.INTER_CUBIC)
    return np.clip(smooth + rng.normal(0, 4, smooth.shape), 0, 255).astype(np.uint8)


def _boxes() -> Row:
    image, binning = picture(), Binning("RGB", (8, 8, 8))
    index, rng = binning.index(image), np.random.default_rng(1)
    corners = rng.integers(0, np.subtract(SIZE, 50), (BOXES, 2))
    boxes = np.column_stack([corners, np.full((BOXES, 2), 50)])

    def peer() -> list[np.ndarray]:
        parts = (image[v : v + 50, u : u + 50] for u, v in corners)
        return [cv2.calcHist([part], [0, 1, 2], None, binning.bins, [0, 256] * 3) for part in parts]

    def agree() -> None:
        found = box_histograms(index, boxes, binning.count)
        np.testing.assert_array_equal(found, np.reshape(peer(), found.shape))

    return Row(
        work=f"colour histograms of {BOXES} boxes of 50×50, 8³ bins, from the image of bins",
        ours=lambda: box_histograms(index, boxes, binning.count),
        peer=peer,
        peer_name="cv2.calcHist",
        at_most=BOXES / (10 * PEER_BOXES),
        agree=agree,
    )


def _scores(half_width: int, ratio: float | None = None) -> Row:
    """Return the row of both kernels on the candidates of one size."""
    binning, radius = Binning("opponent"), 8
    across, down = head_ellipse._reaches(half_width)
    side, reach = 2 * radius + 1, radius + int(1.2 * half_width) + 2
    index = np.ascontiguousarray(
        binning.index(picture())[120 - reach : 121 + reach, 160 - reach : 161 + reach]
    )
    mask = Ellipse(reach, reach, half_width).mask((2 * reach + 1, 2 * reach + 1))
    most = (histogram(index, binning.count, mask) * head_ellipse.UNIT).astype(np.int64)
    found, full = (np.empty((side, side), dtype=np.int64) for _ in range(2))
    corner = reach - radius, reach - radius

    def ours() -> None:
        head_ellipse._slide(index, *corner, across, down, most, found)

    def peer() -> None:
        head_ellipse._count_each(index, *corner, across, down, most, full)

    def agree() -> None:
        ours()
        peer()
        np.testing.assert_array_equal(found, full)
        assert full[radius, radius] == mask.sum() * head_ellipse.UNIT

    return Row(
        work=f"scores of {side}×{side} ellipses, half width {half_width} px, incremental",
        ours=ours,
        peer=peer,
        peer_name="full count, compiled",
        ratio=ratio,
        agree=agree,
        inner=10,
    )


def _step() -> Row:
    tracker, image, head = HeadTracker(), picture(), Ellipse(160, 120, 25)
    state = tracker.start(image, head)

    def agree() -> None:
        after, info = tracker.step(state, image)
        assert np.hypot(after.ellipse.u - head.u, after.ellipse.v - head.v) <= 1
        assert info.adapted

    return Row(
        work="head tracking 320×240: one image, ±8 px, ±8 px, ±1 px, adapted",
        ours=lambda: tracker.step(state, image),
        at_most=1 / 30,
        agree=agree,
        inner=5,
    )


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern heads and their colours."""
    return [_boxes(), *(_scores(n, 5.0 if n == 20 else None) for n in (10, 20, 40)), _step()]
