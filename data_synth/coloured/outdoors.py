"""Outdoors: sun, sky, passing clouds, shadows of leaves, and the ground that animals walk on."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from data_synth._kernels import kernel
from data_synth.coloured.canvas import (
    inside,
    lay,
    leaf_outline,
    place_at,
    round_outline,
    shadow,
    stroke,
    texture,
    turn,
)
from data_synth.coloured.filming import LIGHTS, one_of, wave
from data_synth.coloured.sequences import HEIGHT, WIDTH

__all__: tuple[str, ...] = ()  # for the worlds alone

SUN = np.array([0.42, 0.55, 0.72])  # where it stands: right, down, and up from the ground
SUN = SUN / np.linalg.norm(SUN)
HALF = (SUN + np.array([0, 0, 1])) / np.linalg.norm(SUN + np.array([0, 0, 1]))
WARM = np.array([1.75, 1.66, 1.50], dtype=np.float32)  # light of the sun
COLD = np.array([0.39, 0.42, 0.465], dtype=np.float32)  # and of the sky
LEVEL = WARM * np.float32(SUN[2])  # light of the sun on level ground
DROP = np.array([-0.42, -0.55]) / 0.72  # of a shadow, for each pixel of height
_FALLEN = np.array(  # colours of what lies about; those of beetle and snail are among them
    [
        [0.20, 0.075, 0.030],
        [0.30, 0.140, 0.045],
        [0.13, 0.050, 0.025],
        [0.38, 0.210, 0.075],
        [0.12, 0.160, 0.050],
        [0.24, 0.110, 0.040],
    ]
)


@dataclass(frozen=True, eq=False, slots=True)
class Weather:
    """The light of sun and sky, by time."""

    clouds: Callable[[float], float]
    leaves: np.ndarray
    wind: Callable[[float], float]
    steady: bool

    def strength(self, time: float) -> float:
        """Return that of the sun: clouds pass."""
        return 0.8 if self.steady else 0.62 + self.clouds(time)

    def sky(self, time: float) -> np.ndarray:
        """Return its light (3,), more when clouds hide the sun."""
        return COLD * (1.15 - 0.25 * self.strength(time))

    def sun(self, time: float) -> np.ndarray:
        """Return how much of the sun the clouds and the leaves above let through, a pixel."""
        if self.steady:
            return np.full((HEIGHT, WIDTH), self.strength(time), dtype=np.float32)
        shift = np.array([[1, 0, self.wind(time)], [0, 1, 0.6 * self.wind(time + 9)]])
        leaves = cv2.warpAffine(self.leaves, shift, (WIDTH, HEIGHT), borderMode=cv2.BORDER_REFLECT)
        return leaves * np.float32(self.strength(time))

    def at(self, place: np.ndarray, time: float) -> np.ndarray:
        """Return the light (3,) on the ground at a place in the image."""
        column, row = np.rint(place).astype(int)
        return self.sun(time)[row, column] * LEVEL + self.sky(time)


@kernel()
def lit_ground(paint, sun, low, sky):
    """Return the light that comes back from the ground: ``low`` is 0 in the shadow of what stands
    on it, which hides some of the sky too.
    """
    lit = np.empty_like(paint)
    for row in range(paint.shape[0]):
        for column in range(paint.shape[1]):
            free = low[row, column]
            for channel in range(3):
                came = sun[row, column] * free * LEVEL[channel]
                came += sky[channel] * (0.4 + 0.6 * free)
                lit[row, column, channel] = paint[row, column, channel] * came
    return lit


def make_weather(light: str, *, rng: np.random.Generator) -> Weather:
    """Return weather; ``light`` is changing or steady."""
    one_of("light", light, LIGHTS)
    leaves = 0.22 + 0.78 / (1 + np.exp(-(texture(70, 3, rng=rng) + 0.35) * 7))
    clouds, wind = wave(0.38, (35, 110), rng=rng), wave(9.0, (20, 70), rng=rng)
    return Weather(clouds, leaves.astype(np.float32), wind, light == "steady")


@kernel()
def shine(paint, normal, sun, sky, warm, towards, half, gloss, power, out):
    """Write the light that comes back from a shiny place: Lambert's law and Blinn's highlight."""
    facing = normal[0] * towards[0] + normal[1] * towards[1] + normal[2] * towards[2]
    glance = normal[0] * half[0] + normal[1] * half[1] + normal[2] * half[2]
    spark = sun * gloss * max(glance, 0.0) ** power if facing > 0 else 0.0
    sheen = gloss * 0.06 * (1 - normal[2]) ** 2
    for channel in range(3):
        came = sun * max(facing, 0.0) * warm[channel] + sky[channel]
        out[channel] = paint[channel] * came + spark * warm[channel] + sheen * sky[channel]


@dataclass(frozen=True, eq=False, slots=True)
class Path:
    """Round the image, now faster, now slower, now wider, now narrower."""

    first: float
    rate: float
    pauses: Callable[[float], float]
    wide: Callable[[float], float]
    high: Callable[[float], float]

    def way(self, time: float) -> float:
        """Return how far round, rad."""
        return self.first + self.rate * time + self.pauses(time)

    def place(self, time: float) -> np.ndarray:
        """Return the place (2,), pixels."""
        reach = np.array([88 + self.wide(time), 55 + self.high(time)])
        way = self.way(time)
        return np.array([WIDTH / 2, HEIGHT / 2]) + reach * (np.cos(way), np.sin(way))

    def heading(self, time: float) -> float:
        """Return where it goes, rad."""
        step = self.place(time + 0.05) - self.place(time - 0.05)
        return float(np.arctan2(step[1], step[0]))


def make_path(period: float, *, rng: np.random.Generator) -> Path:
    """Return a path that goes round once in a period, frames."""
    rate = 2 * np.pi / period * rng.choice([-1, 1])
    pauses = wave(0.12, (0.3 * period, 0.8 * period), rng=rng)
    sides = [wave(16.0, (0.5 * period, period), rng=rng) for _ in range(2)]
    return Path(rng.uniform(0, 2 * np.pi), rate, pauses, *sides)


def sand(*, rng: np.random.Generator) -> np.ndarray:
    """Return the paint (height, width, 3) of ground: grey sand, here and there moss."""
    fine, rough = texture(3, 2, rng=rng)[..., None], texture(90, 3, rng=rng)[..., None]
    soil = 1 / (1 + np.exp(-(rough - 0.7) * 6))
    paint = np.array([0.28, 0.30, 0.31]) * (1 - soil) + np.array([0.10, 0.13, 0.08]) * soil
    return (paint * (1 + 0.10 * fine + 0.08 * rough).clip(0.3, None)).astype(np.float32)


def scatter(ground: np.ndarray, leaves: int, stones: int, rng: np.random.Generator) -> None:
    """Lay leaves and stones with their shadows on the paint of the ground."""
    fine = texture(5, 3, rng=rng)
    for kind in rng.permutation([0] * leaves + [1] * stones):
        spot = rng.uniform((0, 0), (WIDTH, HEIGHT))
        paint = _FALLEN[rng.integers(len(_FALLEN))] * rng.uniform(0.8, 1.25)
        angle = rng.uniform(0, 2 * np.pi)
        if kind:
            size = rng.uniform(7, 20)
            shape = place_at(
                round_outline(4, 0.12, rng=rng) * (size, size * rng.uniform(0.6, 0.9)), angle, spot
            )
            if rng.uniform() < 0.5:
                paint = np.array([0.22, 0.20, 0.18]) * rng.uniform(0.6, 1.5)
        else:
            size = rng.uniform(30, 58)
            shape = place_at(leaf_outline(size, size * rng.uniform(0.35, 0.6)), angle, spot)
        shadow(ground, shape, DROP * size * 0.09, 1.5, 0.65)
        box, cover = inside(shape)
        if not cover.size:
            continue
        rows, columns = np.mgrid[box]
        away = np.stack([columns - spot[0], rows - spot[1]], axis=-1) / size
        slope = 1 + (0.45 if kind else 0.25) * (away @ (SUN[:2] / 0.7)) + 0.10 * fine[box]
        lay(ground, box, cover, paint * slope[..., None])
        if not kind:  # the veins
            tips = turn(np.array([[-size / 2, 0], [size / 2, 0]]), angle) + spot
            lay(ground, *stroke(tips, np.array([1.8, 0.8])), paint * 1.45)
            for along in np.linspace(-0.3, 0.3, 4):
                for side in (-1, 1):
                    ends = np.array([[along, 0], [along + 0.12, side * 0.14]]) * size
                    lay(ground, *stroke(turn(ends, angle) + spot, np.ones(2) * 0.7), paint * 1.25)
