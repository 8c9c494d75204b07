"""Fig. 11: samples of a frame with their clouds of colours and their segmentations; Fig. 8: a path.

Both are films of `experiments`, and seeds on which parameters were chosen.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float, UInt8

from robot_perception.appearance.colour_shape import ColourShapeTracker
from robot_perception.chapters.colour_and_shape.experiments import (
    CHOOSING,
    WORLDS,
    Config,
    shown_colours,
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
    scores : (k, 3)
        Affine similarity, area, quality.
    """

    image: UInt8[np.ndarray, "h w 3"] = field(metadata={"webp": 90})
    clouds: Float[np.ndarray, "k n 3"]
    blobs: Bool[np.ndarray, "k h w"]
    outlines: Float[np.ndarray, "k points 2"]
    weights: Float[np.ndarray, " k"]
    scores: Float[np.ndarray, "k 3"]


def run(
    world: str = "circles",
    frame: int = 12,
    count: int = 4,
    config: Config | None = None,
    *,
    rng: np.random.Generator,
) -> Samples:
    """Return samples of a frame, spread from the best to the worst that found a piece."""
    config = Config() if config is None else config
    film = WORLDS[world](rng=np.random.default_rng(CHOOSING[0]), frames=frame + 1)
    tracker = ColourShapeTracker(trained(world, config), config.of(world))
    state = tracker.start(film.frames[0], film.outlines[0], rng=rng)
    for image in film.frames[1:-1]:
        state, _ = tracker.step(state, image, rng=rng)
    _, info = tracker.step(state, film.frames[-1], rng=rng)
    order = np.argsort(info.rho, kind="stable")[: max(np.isfinite(info.rho).sum(), 1)]
    shown = order[np.linspace(0, len(order) - 1, count).round().astype(int)]
    weights = info.weights[shown] / max(info.weights.max(), np.finfo(float).tiny)
    clouds = tracker.warped(state, info.states[shown])
    return Samples(
        film.frames[-1],
        clouds,
        info.blobs[shown],
        info.outlines[shown],
        weights,
        info.scores[shown],
    )


@dataclass(frozen=True, eq=False, slots=True)
class Path:
    """How the colour of the rectangle changes.

    Parameters
    ----------
    colours : (n, 3)
        Mean colour in the image, red, green, blue of 8 bits.
    light : (n, 3)
        Of the light on its middle, shares of full light.
    """

    colours: UInt8[np.ndarray, "n 3"]
    light: Float[np.ndarray, "n 3"]


def path(world: str = "rectangle", seed: int = CHOOSING[0]) -> Path:
    """Return the path of a target's colour through a film, Fig. 8."""
    film = WORLDS[world](rng=np.random.default_rng(seed))
    return Path(shown_colours(film), film.light)
