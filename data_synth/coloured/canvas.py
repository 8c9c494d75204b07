"""Painting light on an image: outlines, strokes, random textures, leaves and stones."""

import cv2
import numpy as np

from data_synth._kernels import kernel
from data_synth.coloured.sequences import HEIGHT, WIDTH

__all__: tuple[str, ...] = ()  # for the worlds alone

_LINES = 4  # on which the area of an outline is measured, a row of pixels
Box = tuple[slice, slice]


def inside(outline: np.ndarray, margin: int = 1) -> tuple[Box, np.ndarray]:
    """Return the box of the image round an outline, and the share of each pixel in it.

    Parameters
    ----------
    outline : (n, 2)
        Column and row, closed; where it goes round twice counts once.
    margin
        Pixels added to the box.
    """
    low = np.floor(outline.min(axis=0)).astype(int) - margin
    high = np.ceil(outline.max(axis=0)).astype(int) + margin + 1
    left, top = low.clip(0, (WIDTH, HEIGHT))
    right, bottom = high.clip((left, top), (WIDTH, HEIGHT))
    cover = np.zeros((bottom - top, right - left), dtype=np.float32)
    _fill(np.ascontiguousarray(outline, dtype=float), left, top, _LINES, cover)
    return (slice(top, bottom), slice(left, right)), cover


@kernel()
def _fill(outline, left, top, lines, cover):
    """Add the share of each pixel that lies inside, exact along a line, lines by their middles."""
    n = len(outline)
    xs, turns = np.empty(n), np.empty(n, dtype=np.int64)
    for line in range(cover.shape[0] * lines):
        y = top - 0.5 + (line + 0.5) / lines
        count = 0
        for i in range(n):
            j = (i + 1) % n
            x0, y0, x1, y1 = outline[i, 0], outline[i, 1], outline[j, 0], outline[j, 1]
            if (y0 <= y) != (y1 <= y):
                x = x0 + (y - y0) * (x1 - x0) / (y1 - y0)
                turn = 1 if y1 > y0 else -1
                k = count
                while k > 0 and xs[k - 1] > x:
                    xs[k], turns[k] = xs[k - 1], turns[k - 1]
                    k -= 1
                xs[k], turns[k] = x, turn
                count += 1
        winding = 0
        for k in range(count - 1):
            winding += turns[k]
            if winding == 0:
                continue
            begin = min(float(cover.shape[1]), max(0.0, xs[k] - left + 0.5))
            end = min(float(cover.shape[1]), max(0.0, xs[k + 1] - left + 0.5))
            for column in range(int(begin), int(np.ceil(end))):
                share = min(end, column + 1.0) - max(begin, float(column))
                if share > 0:
                    cover[line // lines, column] += share / lines


def covered(outline: np.ndarray) -> np.ndarray:
    """Return the pixels (height, width) of which the most part lies inside an outline (n, 2)."""
    found = np.zeros((HEIGHT, WIDTH), dtype=bool)
    box, cover = inside(outline)
    found[box] = cover > 0.5
    return found


def stroke(points: np.ndarray, widths: np.ndarray) -> tuple[Box, np.ndarray]:
    """Return the box round a line of straight pieces with round ends, and each pixel's share.

    Parameters
    ----------
    points : (n, 2)
        Column and row.
    widths : (n,)
        Of the line at the points, pixels.
    """
    reach = float(np.max(widths)) / 2 + 1
    low = np.floor(points.min(axis=0) - reach).astype(int)
    high = np.ceil(points.max(axis=0) + reach).astype(int) + 1
    left, top = low.clip(0, (WIDTH, HEIGHT))
    right, bottom = high.clip((left, top), (WIDTH, HEIGHT))
    cover = np.zeros((bottom - top, right - left), dtype=np.float32)
    _draw(np.asarray(points, dtype=float), np.asarray(widths, dtype=float), left, top, cover)
    return (slice(top, bottom), slice(left, right)), cover


@kernel()
def _draw(points, widths, left, top, cover):
    """Raise each pixel to the share that the nearest place of a piece gives it."""
    for k in range(len(points) - 1):
        x, y = points[k, 0] - left, points[k, 1] - top
        dx, dy = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
        long = max(dx * dx + dy * dy, 1e-12)
        reach = max(widths[k], widths[k + 1]) / 2 + 1
        for row in range(
            int(min(cover.shape[0], max(0.0, min(y, y + dy) - reach))),
            min(cover.shape[0], int(min(cover.shape[0], max(-2.0, max(y, y + dy) + reach))) + 2),
        ):
            for column in range(
                int(min(cover.shape[1], max(0.0, min(x, x + dx) - reach))),
                min(
                    cover.shape[1], int(min(cover.shape[1], max(-2.0, max(x, x + dx) + reach))) + 2
                ),
            ):
                along = min(max(((column - x) * dx + (row - y) * dy) / long, 0.0), 1.0)
                away = np.hypot(column - x - along * dx, row - y - along * dy)
                half = ((1 - along) * widths[k] + along * widths[k + 1]) / 2
                share = min(max(half - away + 0.5, 0.0), 1.0)
                cover[row, column] = max(cover[row, column], share)


def lay(canvas: np.ndarray, box: Box, cover: np.ndarray, colour: np.ndarray) -> None:
    """Lay a colour, one (3,) or one a pixel of the box, over a canvas (height, width, 3)."""
    part = canvas[box]
    part += cover[..., None] * (colour - part)


def shadow(
    canvas: np.ndarray, outline: np.ndarray, shift: np.ndarray, soft: float, deep: float
) -> None:
    """Darken a canvas (height, width) or (height, width, 3) below the shifted outline, whose edge
    is soft, by the share ``deep``.
    """
    box, cover = inside(outline + shift, margin=int(3 * soft) + 1)
    if cover.size:
        left = 1 - deep * cv2.GaussianBlur(cover, (0, 0), soft)
        canvas[box] *= left if canvas.ndim == 2 else left[..., None]


def shifted(image: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Return an image (height, width) moved by columns and rows; what comes in is 0."""
    return cv2.warpAffine(image, np.column_stack([np.eye(2), shift]), image.shape[::-1])


def texture(
    cell: float, octaves: int, *, rng: np.random.Generator, size: tuple[int, int] = (HEIGHT, WIDTH)
) -> np.ndarray:
    """Return smooth noise (rows, columns), mean 0, deviation 1, of cells in pixels and finer."""
    total = np.zeros(size, dtype=np.float32)
    for octave in range(octaves):
        step = max(cell / 2**octave, 1.0)
        grid = rng.standard_normal((int(size[0] / step) + 3, int(size[1] / step) + 3))
        fine = cv2.resize(grid.astype(np.float32), None, fx=step, fy=step, interpolation=2)
        total += fine[: size[0], : size[1]] * 0.6**octave
    return (total - total.mean()) / total.std()


def round_outline(
    waves: int, rough: float, *, rng: np.random.Generator, points: int = 72
) -> np.ndarray:
    """Return an irregular round outline (points, 2) of radius about 1: a stone."""
    angle = np.arange(points) * 2 * np.pi / points
    radius = np.ones(points)
    for k in range(2, waves + 2):
        radius += rough / k * np.sin(k * angle + rng.uniform(0, 2 * np.pi))
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def leaf_outline(length: float, width: float, points: int = 40) -> np.ndarray:
    """Return a pointed outline (points, 2) along the first axis, its middle at the origin."""
    along = np.linspace(-1, 1, points // 2, endpoint=False)
    half = width / 2 * (1 - along**2) * (1 - 0.35 * along)
    upper = np.stack([along * length / 2, half], axis=1)
    return np.concatenate([upper, -upper])


def turn(points: np.ndarray, angle: float) -> np.ndarray:
    """Return points (n, 2) turned from the first axis to the second."""
    cos, sin = np.cos(angle), np.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]])


def place_at(points: np.ndarray, angle: float, place: np.ndarray) -> np.ndarray:
    """Return points (n, 2) turned and then moved."""
    return turn(points, angle) + place
