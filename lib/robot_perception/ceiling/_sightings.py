"""Checks and computations that the modules of a ceiling share."""

import math
from collections.abc import Mapping

import numpy as np

from robot_perception import checks
from robot_perception.geometry import se2, wrap_angle

LARGEST = 1e12
"""Largest distance on a ceiling, px or m."""
SIGMA_PX = 1.0
SIGMA_HEADING = 0.02
"""Standard deviations of a sighting, px and rad; our choice."""


def aligned(known: np.ndarray, seen: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return `align` of checked arguments."""
    share = a / a.sum()
    turn = known[:, 2] - seen[:, 2]
    P, p = share @ known[:, :2], share @ seen[:, :2]
    if len(known) == 1:
        angle = turn[0]  # to the last bit
    else:
        Q, q = known[:, :2] - P, seen[:, :2] - p
        sine = a @ (q[:, 0] * Q[:, 1] - q[:, 1] * Q[:, 0]) + b @ np.sin(turn)
        cosine = a @ (q * Q).sum(axis=1) + b @ np.cos(turn)
        most = a @ (np.abs(q) * np.abs(Q)).sum(axis=1) + b.sum()
        if not math.hypot(sine, cosine) > 1e-12 * most:
            raise ValueError("sightings and known poses must agree on a heading, got none")
        angle = math.atan2(sine, cosine)
    x, y = P - se2.rotation(angle) @ p
    return np.array([x, y, wrap_angle(angle)])


def shares(sigma_px: float, sigma_heading: float, scale: float) -> tuple[float, float]:
    """Return the weights of a position, 1/m², and of a heading, relative to each other."""
    sigma_px = checks.positive("sigma_px", sigma_px)
    sigma_heading = checks.positive("sigma_heading", sigma_heading)
    for name, sigma in (("sigma_px", sigma_px), ("sigma_heading", sigma_heading)):
        if not 1e-12 <= sigma <= LARGEST:
            raise ValueError(f"{name} must be from 1e-12 to 1e12, got {sigma:g}")
    return 1.0, (sigma_px * scale / sigma_heading) ** 2


def counts(weights: Mapping[str, float] | None, names: list[str]) -> np.ndarray:
    """Return the weights of some patterns."""
    if weights is None:
        return np.ones(len(names))
    named("weights", weights)
    given = {name: checks.number(f"weights[{name!r}]", w) for name, w in weights.items()}
    found = np.array([given.get(name, 1.0) for name in names])
    if (found < 0).any() or not found.sum() > 0:
        raise ValueError(f"weights must be positive or 0, not all 0, got {checks.shown(found)}")
    return found / checks.moderate("weights", found).max()


def metric(sighting: np.ndarray, centre: np.ndarray, scale: float) -> np.ndarray:
    """Return `in_camera` of checked arguments."""
    position = (sighting[..., :2] - centre) * scale
    return np.concatenate([position, wrap_angle(sighting[..., 2:3])], axis=-1)


def own(name: str, value: np.ndarray) -> np.ndarray:
    """Return a copy of moderate numbers, of double precision."""
    return checks.moderate(name, value, LARGEST).astype(float)


def sightings(name: str, value: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the sightings of one image, each four moderate numbers."""
    return {
        pattern: sighting(f"{name}[{pattern!r}]", pose, (4,))
        for pattern, pose in named(name, value).items()
    }


def named(name: str, value: Mapping) -> Mapping:
    """Return a mapping from names of patterns."""
    for key in checks.instance(name, value, Mapping):
        checks.instance(f"a name in {name}", key, str)
    return value


def sighting(name: str, value: np.ndarray, shape: tuple = (..., 4)) -> np.ndarray:
    """Return sightings as an array."""
    return checks.moderate(name, checks.array(name, value, shape), LARGEST)


def pose(name: str, value: np.ndarray, shape: tuple = (..., 3)) -> np.ndarray:
    """Return poses as an array."""
    return checks.moderate(name, checks.array(name, value, shape), LARGEST)


def centre(value: np.ndarray) -> np.ndarray:
    """Return a principal point."""
    return checks.moderate("centre", checks.array("centre", value, (2,)), LARGEST)


def scale(value: float) -> float:
    """Return Z/f."""
    return metres_per_px("scale", value)


def metres_per_px(name: str, value: float) -> float:
    """Return a scale of pictures."""
    found = checks.positive(name, value)
    if not 1e-9 <= found <= 1e9:
        raise ValueError(f"{name} must be positive, from 1e-9 to 1e9 m per px, got {found:g}")
    return found


def weights(name: str, value: np.ndarray, count: int) -> np.ndarray:
    """Return so many weights."""
    found = checks.moderate(name, checks.array(name, value, (count,), "known"), 1e30)
    if (found < 0).any():
        raise ValueError(f"{name} must not be negative, got {found.min():g}")
    return found
