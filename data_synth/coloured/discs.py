"""Circles that move about and change colour at random."""

import numpy as np

from data_synth._checks import number, whole
from data_synth.coloured.canvas import covered, inside, lay, texture
from data_synth.coloured.filming import camera_or_default, film, linear, start
from data_synth.coloured.sequences import HEIGHT, WIDTH, Camera, Sequence

__all__ = ["circles"]

_POINTS = 80
_DARKEST, _BRIGHTEST = 0.12, 0.95  # of a circle's colour, in the image


def circles(
    *,
    rng: np.random.Generator,
    frames: int = 120,
    others: int = 4,
    colour_step: float = 0.03,
    camera: Camera | None = None,
) -> Sequence:
    """Return circles that bounce about and change colour at random; one of them is the target.

    Colours walk at random; those of the others too, so that they meet the target's. Circles pass
    before and behind each other.

    Parameters
    ----------
    rng
        Source of places, colours and noise.
    frames
        How many.
    others
        Circles beside the target.
    colour_step
        How far a colour walks from frame to frame at most, shares of the image's range; 0 keeps
        the colours.
    camera
        That films; by default as :class:`~data_synth.coloured.Camera` is.

    Returns
    -------
    Sequence
        Its ``light`` is the colour of the target, which shines by itself.
    """
    motion, colours, ground, noise = start(rng, frames, 4)
    whole("others", others, 0, 20)
    number("colour_step", colour_step, 0.0, 0.5)
    camera = camera_or_default(camera)
    count, target = others + 1, (others + 1) // 2  # about half of the others pass before it
    radii = motion.uniform(17, 26, count)
    radii[target] = motion.uniform(28, 34)
    first = motion.uniform(0, 1, (count, 2)) * (WIDTH, HEIGHT)
    angle, speed = motion.uniform(0, 2 * np.pi, count), motion.uniform(1.5, 3.5, count)
    pace = speed[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    walks = np.stack([_colour_walk(frames + 1, colour_step, colours) for _ in range(count)])
    back = linear((0.55 + 0.05 * texture(24, 4, rng=ground))[..., None] * np.ones(3))
    grain = 1 + 0.05 * np.stack([texture(6, 2, rng=ground) for _ in range(count)])[..., None]
    ring = 2 * np.pi * np.arange(_POINTS) / _POINTS
    ring = np.stack([np.cos(ring), np.sin(ring)], axis=1)

    def outline(k: int, time: float) -> np.ndarray:
        room = np.array([WIDTH, HEIGHT]) - 1 - 2 * radii[k]
        way = (first[k] + pace[k] * time) % (2 * room)
        return radii[k] + np.minimum(way, 2 * room - way) + radii[k] * ring

    def colour(k: int, time: float) -> np.ndarray:
        at = min(max(time, 0.0), frames - 1.0)
        low = int(at)
        return linear(walks[k, low] + (at - low) * (walks[k, low + 1] - walks[k, low]))

    def paint(time: float, _: int) -> np.ndarray:
        canvas = back.copy()
        for k in range(count):
            box, cover = inside(outline(k, time))
            lay(canvas, box, cover, colour(k, time) * grain[k][box])
        return canvas

    masks = np.stack([covered(outline(target, t)) for t in range(frames)])
    for t in range(frames):
        for k in range(target + 1, count):
            masks[t] &= ~covered(outline(k, t))
    return Sequence(
        frames=film(camera, paint, frames, rng=noise),
        masks=masks,
        extra=np.zeros_like(masks),
        outlines=np.stack([outline(target, t) for t in range(frames)]),
        light=np.stack([colour(target, t) for t in range(frames)]),
    )


def _colour_walk(count: int, step: float, rng: np.random.Generator) -> np.ndarray:
    """Colours (count, 3); the pace of the walk changes at random too."""
    colours = np.empty((count, 3))
    colours[0] = rng.uniform(_DARKEST, _BRIGHTEST, 3)
    pace = rng.standard_normal(3)
    for k in range(1, count):
        pace = 0.85 * pace + 0.5 * rng.standard_normal(3)
        move = step * pace / max(1.0, float(np.linalg.norm(pace)))
        free = colours[k - 1] + move
        out = (free < _DARKEST) | (free > _BRIGHTEST)
        pace[out] *= -1
        colours[k] = np.where(out, colours[k - 1] - move, free).clip(_DARKEST, _BRIGHTEST)
    return colours
