"""Fig. 11: samples of a frame with their clouds of colours and their segmentations."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, UInt8

from robot_perception.appearance.colour_shape import ColourShapeTracker
from robot_perception.chapters.colour_and_shape.experiments import (
    CHOOSING,
    filmed,
    rules_of,
    trained,
)


@dataclass(frozen=True, eq=False, slots=True)
class Samples:
    """Some samples of one frame, the best first.

    Parameters
    ----------
    image : (height, width, 3)
        The frame, red, green, blue.
    clouds : (k, n, 3)
        Their colours, coordinates of the colour space.
    blobs : (k, height, width)
        What they take for the object.
    outlines : (k, points, 2)
        Their snakes, px.
    weights : (k,)
        π over the greatest.
    """

    image: UInt8[np.ndarray, "h w 3"]
    clouds: Float[np.ndarray, "k n 3"]
    blobs: Bool[np.ndarray, "k h w"]
    outlines: Float[np.ndarray, "k points 2"]
    weights: Float[np.ndarray, " k"]


def run(world: str, frame: int, count: int, *, rng: np.random.Generator) -> Samples:
    """Return samples of a frame, spread from the best to the worst that found a piece."""
    film = filmed(world, CHOOSING[0], frame)
    tracker = ColourShapeTracker(trained(world), rules_of(world))
    state = tracker.start(film.frames[0], film.outlines[0], rng=rng)
    for image in film.frames[1:-1]:
        state, _ = tracker.step(state, image, rng=rng)
    _, info = tracker.step(state, film.frames[-1], rng=rng)
    order = np.argsort(info.rho, kind="stable")[: max(np.isfinite(info.rho).sum(), 1)]
    shown = order[np.linspace(0, len(order) - 1, count).round().astype(int)]
    weights = info.weights[shown] / max(info.weights.max(), np.finfo(float).tiny)
    clouds = tracker.warped(state, info.states[shown])
    return Samples(film.frames[-1], clouds, info.blobs[shown], info.outlines[shown], weights)
