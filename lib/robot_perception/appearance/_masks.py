"""Checks that masks and outlines share."""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks

Mask = Bool[np.ndarray, "height width"]
Outline = Float[np.ndarray, "n 2"]

THIN = 1e-3
"""Narrowest outline that has an area: its smallest spread over its largest."""


def check_mask(name: str, value: Any) -> Mask:
    """Return a mask that holds a pixel at least, its rows one after the other."""
    if not isinstance(value, np.ndarray) or value.dtype != bool:
        raise TypeError(f"{name} must be an array of True and False, got {checks.shown(value)}")
    if value.ndim != 2 or not value.size:
        raise ValueError(f"{name} must be (height, width), got {value.shape}")
    return np.ascontiguousarray(value)


def check_outline(name: str, value: Any) -> Outline:
    """Return the points of a closed outline, which must not lie on one line."""
    points = checks.array(name, value, ("n", 2))
    if len(points) < 3:
        raise ValueError(f"{name} must have 3 points at least, got {len(points)}")
    if np.abs(points).max() > 1e6:
        raise ValueError(f"{name} must be within a million pixels, got {np.abs(points).max():g}")
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if spread[1] <= THIN * spread[0]:
        raise ValueError(f"{name} must not lie on a line, got {checks.shown(points.tolist())}")
    return points
