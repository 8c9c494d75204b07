"""Pictures and descriptors of which everything is known."""

import cv2
import numpy as np

from robot_perception.landmarks import Features

COLUMNS, ROWS = 320, 240


def blob(u: float, v: float, sigma: float, size: tuple[int, int] = (COLUMNS, ROWS)) -> np.ndarray:
    """Return a picture of one bright spot."""
    x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    return np.rint(40 + 180 * np.exp(-((x - u) ** 2 + (y - v) ** 2) / 2 / sigma**2)).astype(
        np.uint8
    )


def texture(seed: int, size: tuple[int, int] = (COLUMNS, ROWS)) -> np.ndarray:
    """Return a picture of blots of many sizes."""
    rng, wall = np.random.default_rng(seed), np.zeros(size[::-1], np.float32)
    for sigma in (2, 4, 8):
        blots = cv2.GaussianBlur(rng.standard_normal(wall.shape).astype(np.float32), (0, 0), sigma)
        wall += blots / blots.std()
    return np.clip(128 + 25 * wall, 0, 255).astype(np.uint8)


def shifted(image: np.ndarray, u: float, v: float = 0.0) -> np.ndarray:
    """Return a picture whose content has moved, by parts of a pixel too."""
    move = np.array([[1.0, 0, u], [0, 1.0, v]])
    return cv2.warpAffine(
        image, move, image.shape[::-1], flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT
    )


def descriptors(count: int, rng: np.random.Generator) -> np.ndarray:
    """Return descriptors like OpenCV's: whole numbers of length 512 or so, many small."""
    raw = rng.gamma(0.6, size=(count, 128))
    raw *= 512 / np.linalg.norm(raw, axis=1)[:, None]
    return np.minimum(np.rint(raw), 255).astype(np.float32)


def features(pixels: np.ndarray, kinds: np.ndarray, seed: int = 0, noise: float = 0.0) -> Features:
    """Return features at pixels whose descriptors are of some kinds, with noise."""
    rng = np.random.default_rng(seed)
    kinds = np.asarray(kinds, dtype=int)
    table = descriptors(max(kinds, default=0) + 1, np.random.default_rng(17))
    found = table[kinds] + noise * rng.standard_normal((len(kinds), 128))
    n = len(kinds)
    return Features(
        np.reshape(np.asarray(pixels, dtype=float), (n, 2)),
        np.rint(np.clip(found, 0, 255)).astype(np.float32),
        np.full(n, 2.0),
        np.zeros(n),
    )
