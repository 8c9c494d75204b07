"""Sprites laid over a picture, and the camera that takes it."""

import cv2
import numpy as np

from data_synth._checks import array
from data_synth.coloured.canvas import texture
from data_synth.coloured.filming import linear

__all__: tuple[str, ...] = ()  # for the worlds alone

_GAMMA = 2.2


def tint(name: str, value: object) -> tuple[float, float, float]:
    """Return how much light comes back, red, green and blue, each from 0 to 1."""
    found = array(name, value, (3,))
    if found.min() < 0 or found.max() > 1:
        raise ValueError(f"{name} must be from 0 to 1, got {found.tolist()}")
    return tuple(found.tolist())


def rows_and_columns(name: str, value: object, least: int, most: int) -> tuple[int, int]:
    """Return the size of a picture, px."""
    rows, columns = array(name, value, (2,)).tolist()
    for size in (rows, columns):
        if not (size.is_integer() and least <= size <= most):
            raise ValueError(f"{name} must be whole, {least} to {most}, got {(rows, columns)}")
    return int(rows), int(columns)


def lay(
    canvas: np.ndarray,
    sprite: np.ndarray,
    middle: tuple[float, float],
    height: float,
    *,
    angle: float = 0.0,
    light: np.ndarray | float = 1.0,
) -> np.ndarray:
    """Lay a sprite over a canvas, in place, and return how much of each pixel it covers.

    Parameters
    ----------
    canvas : (rows, columns, 3)
        Shares of full light.
    sprite : (h, w, 4)
        Shares of the light that come back, and how much each pixel covers, 0 to 1.
    middle
        Column and row where the middle of the sprite comes to lie.
    height
        Of the sprite in the canvas, pixels.
    angle
        By which it is turned, clockwise as seen, rad.
    light
        That falls on it: a number or one a channel.
    """
    rows, columns = sprite.shape[:2]
    scale = height / rows
    cover = sprite[..., 3:]
    dense = np.concatenate([sprite[..., :3] * cover, cover], axis=-1)
    if scale < 0.7:  # shrink by areas first, else fine detail turns into noise
        size = max(round(columns * scale), 1), max(round(rows * scale), 1)
        dense = cv2.resize(dense, size, interpolation=cv2.INTER_AREA)
    fine = height / dense.shape[0]
    cos, sin = fine * np.cos(angle), fine * np.sin(angle)
    turn = np.array([[cos, -sin], [sin, cos]])
    centre = (np.array(dense.shape[1::-1]) - 1) / 2
    reach = np.abs(turn) @ (np.array(dense.shape[1::-1]) / 2 + 1) + 1
    low = np.floor(np.array(middle) - reach).astype(int).clip(0, canvas.shape[1::-1])
    high = np.ceil(np.array(middle) + reach).astype(int).clip(low, canvas.shape[1::-1])
    covered = np.zeros(canvas.shape[:2], dtype=np.float32)
    if (high <= low).any():
        return covered
    shift = np.array(middle) - low - turn @ centre
    size = tuple(int(n) for n in high - low)
    warped = cv2.warpAffine(dense, np.column_stack([turn, shift]), size, flags=cv2.INTER_LINEAR)
    box = slice(low[1], high[1]), slice(low[0], high[0])
    canvas[box] *= 1 - warped[..., 3:]
    canvas[box] += warped[..., :3] * np.asarray(light, dtype=np.float32)
    covered[box] = warped[..., 3]
    return covered


def photograph(
    light: np.ndarray,
    *,
    rng: np.random.Generator,
    softness: float = 0.6,
    read_noise: float = 0.008,
    photon_noise: float = 0.0004,
) -> np.ndarray:
    """Return red, green and blue of 8 bits (rows, columns, 3) of light, with blur and noise."""
    seen = cv2.GaussianBlur(light, (0, 0), softness) if softness > 0 else light
    spread = np.sqrt(read_noise**2 + photon_noise * np.maximum(seen, 0))
    noisy = seen + spread * rng.standard_normal(seen.shape, dtype=np.float32)
    return np.rint(255 * noisy.clip(0, 1) ** (1 / _GAMMA)).astype(np.uint8)


def room(size: tuple[int, int], *, rng: np.random.Generator, clutter: int = 14) -> np.ndarray:
    """Return a wall (rows, columns, 3) with furniture, posters and books before it."""
    rows, columns = size
    wall = linear(np.array([0.62, 0.64, 0.60])) * rng.uniform(0.7, 1.1)
    fine, wide = texture(3, 2, rng=rng, size=size), texture(rows / 4, 3, rng=rng, size=size)
    paint = (wall * (1 + 0.03 * fine + 0.06 * wide)[..., None]).astype(np.float32)
    for _ in range(clutter):
        high, wide_ = rng.uniform(0.08, 0.6) * rows, rng.uniform(0.04, 0.3) * columns
        left, top = rng.uniform(-0.1, 0.95) * columns, rng.uniform(0, 0.9) * rows
        tone = _muted(rng)
        corners = np.array([[left, top], [left + wide_, top], [left + wide_, top + high],
                            [left, top + high]])  # fmt: skip
        cv2.fillConvexPoly(paint, np.rint(corners * 16).astype(np.int32), tone.tolist(),
                           cv2.LINE_AA, 4)  # fmt: skip
        if rng.uniform() < 0.5:  # a frame, or the edge of a board
            inner = corners + np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * rng.uniform(2, 6)
            other = _muted(rng)
            cv2.fillConvexPoly(paint, np.rint(inner * 16).astype(np.int32), other.tolist(),
                               cv2.LINE_AA, 4)  # fmt: skip
    grain = texture(2, 1, rng=rng, size=size)
    return (paint * (1 + 0.04 * grain)[..., None]).clip(0.004, 1).astype(np.float32)


def _muted(rng: np.random.Generator) -> np.ndarray:
    """Return the colour of a thing in a room, not as bright as a toy."""
    return linear(rng.uniform(0.15, 0.8) + rng.uniform(-0.12, 0.12, 3))
