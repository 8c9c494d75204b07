"""Outlines of closed form, affine maps of them, and their pictures."""

import numpy as np
from jaxtyping import Float

from robot_perception.appearance.segmentation import boundary, filled

SHAPE = (240, 320)
MIDDLE = np.array([160.0, 120.0])


def pear(count: int = 80, lobes: float = 0.15) -> Float[np.ndarray, "n 2"]:
    """Return an outline with three lobes on an ellipse, about the origin: no symmetry at all."""
    t = 2 * np.pi * np.arange(count) / count
    r = 1 + lobes * np.cos(3 * t + 0.3)
    return np.stack([45 * r * np.cos(t), 28 * r * np.sin(t)], axis=-1)


def turned(angle_deg: float, scale: float = 1.0) -> Float[np.ndarray, "2 2"]:
    """Return the matrix of a turn and a change of size."""
    c, s = np.cos(np.deg2rad(angle_deg)), np.sin(np.deg2rad(angle_deg))
    return scale * np.array([[c, -s], [s, c]])


def edges_of(outline: Float[np.ndarray, "n 2"]) -> np.ndarray:
    """Return the edges of the filled outline."""
    return boundary(filled(outline, SHAPE))


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    """Return intersection over union of two outlines' insides."""
    first, second = filled(a, SHAPE), filled(b, SHAPE)
    return float((first & second).sum() / (first | second).sum())
