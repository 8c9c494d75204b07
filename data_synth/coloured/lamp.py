"""A reddish Lambertian rectangle that revolves about a lamp above a table."""

import numpy as np

from data_synth.coloured.canvas import covered, inside, lay, place_at, shadow, texture
from data_synth.coloured.filming import LIGHTS, camera_or_default, film, one_of, start, wave
from data_synth.coloured.sequences import HEIGHT, WIDTH, Camera, LampSequence

__all__ = ["rectangle"]

_POINTS = 80
_FOCAL = 300.0  # pixels
_AWAY, _SLANT = 2.0, np.deg2rad(20)  # of the table: m, and off the camera's axis
_LAMP_HIGH, _CARD_HIGH = 0.42, 0.18  # above the table, m
_SIDES = np.array([0.40, 0.28])  # of the rectangle, m
_ORBIT, _OFF = 0.52, 0.19  # radius, and what the lamp stands off its middle, m
LAMP_LIGHT = 0.55 * np.array([1.0, 0.70, 0.40])  # at 1 m, shares of full light
AMBIENT = np.array([0.05, 0.065, 0.10])
CARD = np.array([0.52, 0.12, 0.085])  # colour of the rectangle
_MIDDLE = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
_RING = 2 * np.pi * np.arange(48) / 48
_RING = np.stack([np.cos(_RING), np.sin(_RING)], axis=1)


def rectangle(
    *,
    rng: np.random.Generator,
    frames: int = 120,
    light: str = "changing",
    camera: Camera | None = None,
) -> LampSequence:
    """Return a reddish Lambertian rectangle that revolves about a lamp above a table.

    A place of the rectangle at distance r from the lamp, whose light comes in at the angle α off
    its normal, sends ``albedo · (lamp · cos α / r² + ambient)`` into the camera, of which the
    sensor loses what is more than full light. The lamp is warm, the ambient light cold.

    Parameters
    ----------
    rng
        Source of the path, the table and the noise.
    frames
        How many; the rectangle goes round the lamp once in sixty.
    light
        ``"steady"`` gives the rectangle everywhere the light of its first place.
    camera
        That films; by default as :class:`~data_synth.coloured.Camera` is.
    """
    motion, ground, noise = start(rng, frames, 3)
    one_of("light", light, LIGHTS)
    camera = camera_or_default(camera)
    right, far = np.array([1.0, 0, 0]), np.array([0, -np.cos(_SLANT), np.sin(_SLANT)])
    up = np.array([0, -np.sin(_SLANT), -np.cos(_SLANT)])
    middle = np.array([0, 0, _AWAY])
    first, sense = motion.uniform(0, 2 * np.pi), motion.choice([-1, 1])
    aside = motion.uniform(0, 2 * np.pi)
    lamp = middle + _LAMP_HIGH * up + _OFF * (np.cos(aside) * right + np.sin(aside) * far)
    nod, sway = wave(0.6, (30, 90), rng=motion), wave(0.4, (40, 120), rng=motion)
    spin, lift = wave(0.7, (40, 120), rng=motion), wave(0.07, (40, 120), rng=motion)

    def frame(time: float) -> tuple[np.ndarray, np.ndarray]:
        """Centre (3,), and the axes (3, 3) along the sides and off the face."""
        turned = first + sense * 2 * np.pi * time / 60
        out = np.cos(turned) * right + np.sin(turned) * far
        along = np.cos(turned) * far - np.sin(turned) * right
        tip = 0.35 + nod(time)  # towards the lamp
        axes = [along, np.cos(tip) * out + np.sin(tip) * up, np.cos(tip) * up - np.sin(tip) * out]
        axes = _about(axes, sway(time), (1, 2))
        centre = middle + _ORBIT * out + (_CARD_HIGH + lift(time)) * up
        return centre, np.stack(_about(axes, spin(time), (0, 1)))

    def corners(time: float) -> np.ndarray:
        centre, axes = frame(time)
        halves = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * _SIDES / 2
        return centre + halves @ axes[:2]

    rays = np.stack(
        [*(np.mgrid[:HEIGHT, :WIDTH][::-1] - np.reshape(_MIDDLE, (2, 1, 1))) / _FOCAL,
         np.ones((HEIGHT, WIDTH))], axis=-1,
    )  # fmt: skip

    def shone(normal: np.ndarray, point: np.ndarray, box: tuple) -> np.ndarray:
        """The lamp's light on a plane, seen through the pixels of a box."""
        places = rays[box] * (normal @ point / (rays[box] @ normal))[..., None]
        ways = lamp - places
        squares = (ways**2).sum(axis=-1)
        return (ways @ normal).clip(0, None)[..., None] / squares[..., None] ** 1.5 * LAMP_LIGHT

    def received(time: float, box: tuple) -> np.ndarray:
        centre, axes = frame(time)
        return shone(axes[2], centre, box) + AMBIENT

    def at_centre(time: float) -> np.ndarray:
        centre, axes = frame(time)
        way = lamp - centre
        return LAMP_LIGHT * max(float(way @ axes[2]), 0.0) / float(way @ way) ** 1.5 + AMBIENT

    everywhere = (slice(0, HEIGHT), slice(0, WIDTH))
    paint_of_table = _table(ground)
    cold = (paint_of_table * AMBIENT).astype(np.float32)
    warm = (paint_of_table * shone(up, middle, everywhere)).astype(np.float32)
    shade = lamp + 0.05 * (_RING[:, :1] * right + _RING[:, 1:] * far)

    def outline(time: float) -> np.ndarray:
        return _seen(_sides(corners(time), _POINTS // 4))

    def paint(time: float, _: int) -> np.ndarray:
        ways = _sides(corners(time), 4) - lamp
        drop = (middle - lamp) @ up / (ways @ up)  # from the lamp through the edge to the table
        lit = np.ones((HEIGHT, WIDTH), dtype=np.float32)
        shadow(lit, _seen(lamp + drop[:, None] * ways), np.zeros(2), 2.0, 1.0)
        canvas = cold + warm * lit[..., None]
        box, cover = inside(outline(time))
        if cover.size:
            came = received(time, box) if light == "changing" else at_centre(0.0)
            lay(canvas, box, cover, (CARD * came).astype(np.float32))
        box, cover = inside(_seen(shade))
        lay(canvas, box, cover, np.array([0.02, 0.02, 0.02], dtype=np.float32))
        return canvas

    times = range(frames)
    masks = np.stack([covered(outline(t)) for t in times]) & ~covered(_seen(shade))
    return LampSequence(
        frames=film(camera, paint, frames, rng=noise),
        masks=masks,
        extra=np.zeros_like(masks),
        outlines=np.stack([outline(t) for t in times]),
        light=np.stack([at_centre(t if light == "changing" else 0.0) for t in times]),
        corners=np.stack([corners(t) for t in times]),
        lamp=lamp,
    )


def _seen(places: np.ndarray) -> np.ndarray:
    return _MIDDLE + _FOCAL * places[:, :2] / places[:, 2:]


def _sides(corners: np.ndarray, parts: int) -> np.ndarray:
    share = np.arange(parts)[:, None] / parts
    ends = np.roll(corners, -1, axis=0)
    return np.concatenate([a + share * (b - a) for a, b in zip(corners, ends, strict=True)])


def _about(axes: list, angle: float, pair: tuple[int, int]) -> list:
    """Turn two axes about the third."""
    i, j = pair
    axes = list(axes)
    cos, sin = np.cos(angle), np.sin(angle)
    axes[i], axes[j] = cos * axes[i] + sin * axes[j], cos * axes[j] - sin * axes[i]
    return axes


def _table(rng: np.random.Generator) -> np.ndarray:
    """Paint (height, width, 3) of a wooden table with papers and reddish cards on it."""
    rows = np.mgrid[:HEIGHT, :WIDTH][0]
    grain = 0.5 * texture(40, 4, rng=rng) + 0.5 * np.sin(rows / 3.1 + 1.5 * texture(90, 2, rng=rng))
    paint = np.array([0.30, 0.21, 0.13]) * (1 + 0.18 * grain.clip(-2, 2))[..., None]
    for colour in ([0.45, 0.44, 0.40], [0.34, 0.13, 0.09], [0.16, 0.20, 0.16], [0.30, 0.08, 0.06]):
        sides = rng.uniform((18, 14), (40, 30))
        card = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * sides / 2
        spot = rng.uniform((20, 20), (WIDTH - 20, HEIGHT - 20))
        lay(paint, *inside(place_at(card, rng.uniform(0, np.pi), spot)), np.array(colour))
    return paint
