"""Scenes of closed form: round legs before a scanner, faces in the picture of a fisheye."""

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception.people.skin import SkinModel

LASER = np.deg2rad(np.arange(-90.0, 91.0))
SIZE, CENTRE, FOCAL = (160, 150), (80.0, 74.0), 45.0
SKIN, WALL = (110, 140, 200), (150, 150, 140)  # blue, green, red


def legs(
    middles: Float[np.ndarray, "k 2"], radius: float, angles: np.ndarray = LASER, far: float = 6.0
) -> Float[np.ndarray, " n"]:
    r"""Return the ranges to round legs before something round that is ``far`` away.

    .. math:: r = d \cos\alpha - \sqrt{a^2 - d^2 \sin^2\alpha}
    """
    ranges = np.full(angles.shape, far)
    for x, y in np.asarray(middles, float).reshape(-1, 2):
        d, away = np.hypot(x, y), angles - np.arctan2(y, x)
        inside = radius**2 - (d * np.sin(away)) ** 2
        hit = (inside > 0) & (np.cos(away) > 0)
        front = d * np.cos(away) - np.sqrt(np.maximum(inside, 0))
        ranges = np.where(hit, np.minimum(ranges, front), ranges)
    return ranges


def directions() -> tuple[Float[np.ndarray, "h w"], Float[np.ndarray, "h w"]]:
    """Return direction and elevation of every pixel."""
    u, v = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    radius = np.hypot(u - CENTRE[0], v - CENTRE[1])
    return np.arctan2(CENTRE[0] - u, v - CENTRE[1]), np.pi / 2 - radius / FOCAL


def picture(
    faces: list[tuple[float, float, float]], light: float = 1.0, colour: tuple = SKIN
) -> UInt8[np.ndarray, "h w 3"]:
    """Return a picture of round faces: direction, elevation and angular radius of each, rad."""
    phi, elevation = directions()
    image = np.zeros((*phi.shape, 3))
    image[:] = WALL
    for direction, height, radius in faces:
        aside = (phi - direction + np.pi) % (2 * np.pi) - np.pi
        image[np.hypot(aside * np.cos(height), elevation - height) < radius] = colour
    return np.round(image * light).astype(np.uint8)


def model() -> SkinModel:
    """Return what pixels of such pictures teach."""
    rng = np.random.default_rng(0)
    skin, wall = (
        np.clip(np.array(c) * rng.uniform(0.5, 1.2, (500, 1)) + rng.normal(0, 4, (500, 3)), 0, 255)
        for c in (SKIN, WALL)
    )
    return SkinModel.fit(skin.astype(np.uint8), wall.astype(np.uint8))
