"""Pictures whose contents are known to a fraction of a pixel, for the tests of the ceiling."""

from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np

FINER = 8
SIZE = (320, 240)
Shape = tuple[str, np.ndarray | tuple[float, float, float], int]


def drawn(
    shapes: Sequence[Shape], *, ground: int | np.ndarray = 200, size: tuple[int, int] = SIZE
) -> np.ndarray:
    """Draw polygons ("area", corners, grey) and discs ("disc", (u, v, radius), grey).

    They are drawn finer and averaged: a pixel has the mean grey of its square.
    """
    width, height = size
    fine = np.empty((height * FINER, width * FINER), np.uint8)
    fine[:] = cv2.resize(ground, fine.shape[::-1]) if isinstance(ground, np.ndarray) else ground
    v, u = (np.arange(n * FINER) / FINER - 0.5 + 0.5 / FINER for n in (height, width))
    for kind, where, grey in shapes:
        if kind == "disc":
            x, y, radius = where
            columns, rows = (np.flatnonzero(np.abs(n) <= radius) for n in (u - x, v - y))
            part = np.ix_(rows, columns)
            inside = (u[columns] - x) ** 2 + (v[rows, None] - y) ** 2 <= radius**2
            fine[part] = np.where(inside, grey, fine[part])
        else:
            corners = (np.asarray(where) + 0.5) * FINER - 0.5
            cv2.fillPoly(fine, [np.rint(corners * 16).astype(np.int32)], grey, cv2.LINE_8, 4)
    return cv2.resize(fine, size, interpolation=cv2.INTER_AREA)


def rectangle(u: float, v: float, wide: float, high: float, turned: float = 0.0) -> np.ndarray:
    """Return the corners of a rectangle from its centre, sides and angle, rad."""
    corners = 0.5 * np.array([[-wide, -high], [wide, -high], [wide, high], [-wide, high]])
    cos, sin = np.cos(turned), np.sin(turned)
    return corners @ np.array([[cos, sin], [-sin, cos]]) + (u, v)


def smooth(seed: int, width: float = 5.0, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Return a random smooth field of greys."""
    noise = np.random.default_rng(seed).normal(size=size[::-1])
    field = cv2.GaussianBlur(noise, (0, 0), width)
    return cv2.normalize(field, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)


@lru_cache
def cluttered(seed: int, number: int = 40, *, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Return a picture full of rectangles and discs of many greys on an uneven ground."""
    rng = np.random.default_rng(seed)
    shapes: list[Shape] = []
    for _ in range(number):
        u, v = rng.uniform(0, size)
        grey = int(rng.integers(20, 236))
        if rng.random() < 0.75:
            corners = rectangle(u, v, *rng.uniform(10, 50, 2), rng.uniform(0, np.pi))
            shapes.append(("area", corners, grey))
        else:
            shapes.append(("disc", (u, v, rng.uniform(6, 18)), grey))
    return drawn(shapes, ground=100 + smooth(seed, 20.0, size) // 3, size=size)


def moved(
    image: np.ndarray, pose: Sequence[float], middle: Sequence[float], border: int = 128
) -> np.ndarray:
    """Return a picture in which what was round a point is seen at a place (x, y, θ, s)."""
    x, y, theta, scale = pose
    cos, sin = scale * np.cos(theta), scale * np.sin(theta)
    A = np.array([[cos, -sin], [sin, cos]])
    M = np.column_stack([A, np.array([x, y]) - A @ middle])
    return cv2.warpAffine(image, M, image.shape[::-1], flags=cv2.INTER_CUBIC, borderValue=border)
