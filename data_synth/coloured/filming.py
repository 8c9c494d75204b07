"""Filming: the light of a scene made into images, its switches and its random numbers."""

import math
from collections.abc import Callable

import cv2
import numpy as np

from data_synth._checks import generator, instance, whole
from data_synth._kernels import kernel
from data_synth.coloured.sequences import HEIGHT, WIDTH, Camera

__all__: tuple[str, ...] = ()  # for the worlds alone

LIGHTS = ("changing", "steady")
_GAMMA = 1 / 2.2


def film(
    camera: Camera,
    paint: Callable[[float, int], np.ndarray],
    count: int,
    *,
    rng: np.random.Generator,
) -> np.ndarray:
    """Return the frames (count, height, width, 3) of a scene, red, green and blue of 8 bits.

    ``paint`` gives the light (height, width, 3) that comes in at a time, shares of full light. Time
    runs by one from the middle of an exposure to that of the next. Its second argument is the
    number of the moment within the exposure.
    """
    offsets = camera.blur * ((np.arange(camera.parts) + 0.5) / camera.parts - 0.5)
    images = np.empty((count, HEIGHT, WIDTH, 3), dtype=np.uint8)
    for k in range(count):
        light = np.zeros((HEIGHT, WIDTH, 3), dtype=np.float32)
        for i, offset in enumerate(offsets):
            light += paint(float(k + offset), i)
        light /= camera.parts
        if camera.softness > 0:
            light = cv2.GaussianBlur(light, (0, 0), camera.softness)
        noise = rng.standard_normal(light.shape, dtype=np.float32)
        images[k] = _expose(light, noise, camera.read_noise, camera.photon_noise, _TABLE)
    return images


_TABLE = np.rint(255 * np.linspace(0.0, 1.0, 1 << 16) ** _GAMMA).astype(np.uint8)


@kernel()
def _expose(light, noise, read, photon, table):
    """Values of 8 bits of light with noise; what is more than full light is lost."""
    image = np.empty(light.shape, dtype=np.uint8)
    last = len(table) - 1
    for row in range(light.shape[0]):
        for column in range(light.shape[1]):
            for channel in range(3):
                value = light[row, column, channel]
                value += noise[row, column, channel] * np.sqrt(
                    read * read + photon * max(value, 0.0)
                )
                image[row, column, channel] = table[int(min(1.0, max(0.0, value)) * last + 0.5)]
    return image


def linear(colour: np.ndarray) -> np.ndarray:
    """Return red, green and blue of the image (…, 3), 0 to 1, as shares of full light."""
    return np.asarray(colour, dtype=np.float32) ** np.float32(1 / _GAMMA)


def wave(
    reach: float, periods: tuple[float, float], *, rng: np.random.Generator
) -> Callable[[float], float]:
    """Return a smooth random function of time: sines, never further from 0 than ``reach``, of
    periods from the shortest to the longest, frames.
    """
    lengths = np.geomspace(periods[1], periods[0], 3) * rng.uniform(0.85, 1.15, 3)
    phases = rng.uniform(0, 2 * np.pi, 3)
    sines = list(zip((0.5, 0.3, 0.2), 2 * np.pi / lengths, phases, strict=True))
    return lambda time: reach * sum(a * math.sin(w * time + phase) for a, w, phase in sines)


def one_of(name: str, value: object, words: tuple[str, ...]) -> None:
    """Refuse what is none of the words."""
    if not isinstance(value, str) or value not in words:
        raise ValueError(f"{name} must be one of {', '.join(words)}, got {value!r:.60}")


def camera_or_default(camera: Camera | None) -> Camera:
    """Return the camera, or the usual one."""
    return Camera() if camera is None else instance("camera", camera, Camera)


def start(rng: np.random.Generator, frames: int, count: int) -> list[np.random.Generator]:
    """Return generators for the parts of a scene, so that switching one off leaves the others."""
    generator(rng)
    whole("frames", frames, 1, 2000)
    return [np.random.default_rng(seed) for seed in rng.integers(2**63, size=count)]
