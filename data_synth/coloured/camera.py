"""The camera that films coloured things, and the random numbers of its scenes."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from data_synth._checks import array, generator, number, whole

WIDTH, HEIGHT = 320, 240
_GAMMA = 1 / 2.2
_LEVELS = 1 << 16  # of light that the sensor tells apart


@dataclass(frozen=True, slots=True)
class Camera:
    """A colour camera; all values are ours.

    Parameters
    ----------
    read_noise
        Deviation of the noise in the dark, shares of full light.
    photon_noise
        Variance of the noise for a share of full light.
    blur
        Share of the time between frames that the shutter is open: motion within it blurs.
    parts
        How many moments stand for the time of an exposure.
    softness
        Deviation of the blur by the lens, pixels.
    """

    read_noise: float = 0.003
    photon_noise: float = 0.0003
    blur: float = 0.5
    parts: int = 4
    softness: float = 0.4

    def __post_init__(self) -> None:
        number("read_noise", self.read_noise, 0.0, 1.0)
        number("photon_noise", self.photon_noise, 0.0, 1.0)
        number("blur", self.blur, 0.0, 1.0)
        whole("parts", self.parts, 1, 64)
        number("softness", self.softness, 0.0, 10.0)

    def film(
        self, paint: Callable[[float, int], np.ndarray], frames: int, *, rng: np.random.Generator
    ) -> np.ndarray:
        """Return the frames (n, height, width, 3) of a scene, red, green and blue of 8 bits.

        Parameters
        ----------
        paint
            Gives the light (height, width, 3) that comes in at a time, shares of full light. Time
            runs by one from the middle of an exposure to that of the next. Its second argument is
            the number of the moment within the exposure.
        frames
            How many.
        rng
            Source of the noise.
        """
        if not callable(paint):
            raise TypeError(f"paint must be a function of a time and a number, got {paint!r:.60}")
        offsets = self.blur * ((np.arange(self.parts) + 0.5) / self.parts - 0.5)
        shots = []
        for k in range(whole("frames", frames, 1, 100_000)):
            light = sum(paint(float(k + offset), i) for i, offset in enumerate(offsets))
            shots.append(self.expose(light / self.parts, rng=rng))
        return np.stack(shots)

    def expose(self, light: np.ndarray, *, rng: np.random.Generator) -> np.ndarray:
        """Return the image (height, width, 3) of 8 bits that the camera makes of light.

        Parameters
        ----------
        light : (height, width, 3)
            Red, green and blue, shares of full light; more than 1 saturates.
        rng
            Source of the noise.
        """
        light = array("light", light, (None, None, 3)).astype(np.float32)
        if not light.size:
            raise ValueError(f"light must have a pixel, got {light.shape}")
        if self.softness > 0:
            light = cv2.GaussianBlur(light, (0, 0), self.softness)
        noise = generator(rng).standard_normal(light.shape, dtype=np.float32)
        variance = self.read_noise**2 + self.photon_noise * light.clip(0.0, None)
        level = ((light + noise * np.sqrt(variance)) * (_LEVELS - 1) + 0.5).clip(0, _LEVELS - 1)
        return _TABLE[level.astype(np.uint16)]


_TABLE = np.rint(255 * np.linspace(0.0, 1.0, _LEVELS) ** _GAMMA).astype(np.uint8)


def linear(colour: np.ndarray) -> np.ndarray:
    """Return red, green and blue of the image (…, 3), 0 to 1, as shares of full light."""
    return np.asarray(colour, dtype=np.float32) ** np.float32(1 / _GAMMA)


def children(rng: np.random.Generator, count: int) -> list[np.random.Generator]:
    """Return generators, so that what one part of a scene draws leaves the other parts alone."""
    return [np.random.default_rng(seed) for seed in generator(rng).integers(2**63, size=count)]


def wave(
    reach: float, periods: tuple[float, float], *, rng: np.random.Generator
) -> Callable[[float], float]:
    """Return a smooth random function of time: sines, never further from 0 than ``reach``.

    Parameters
    ----------
    reach
        Sum of the amplitudes.
    periods
        Shortest and longest, frames.
    """
    periods = np.geomspace(periods[1], periods[0], 3) * rng.uniform(0.85, 1.15, 3)
    phases = rng.uniform(0, 2 * np.pi, 3)
    heights = reach * np.array([0.5, 0.3, 0.2])
    return lambda time: float(heights @ np.sin(2 * np.pi * time / periods + phases))
