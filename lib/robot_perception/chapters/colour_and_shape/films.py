"""The four experiments as films: where the object is, and where trackers have it."""

from collections.abc import Iterator
from itertools import product

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from data_synth.coloured import Sequence
from robot_perception.chapters.colour_and_shape import experiments
from robot_perception.chapters.colour_and_shape.experiments import (
    CHOOSING,
    WORLDS,
    filmed,
    rules_of,
    trained,
)
from robot_perception.teaching.figures import figure
from robot_perception.teaching.figures.films import film
from robot_perception.teaching.figures.style import MEANING
from robot_perception.teaching.media import Shown
from robot_perception.teaching.recorded import recorded

FRAMES = 60
"""That are tracked."""
EVERY = 2
"""Which of them a film shows."""
FPS = 6.0
WIDTH = 4.2
"""Of a frame, inches."""
SEED = CHOOSING[2]
"""Of the films that are shown, of those on which numbers were chosen; picked since all of them show
where a cue alone fails."""
CROSSED = 2012
"""Seed of a film of circles that is lost, a scored one: those of `CHOOSING` are held."""
NAMES = {"fused": "fused", "edges alone": "shape", "colours adapted": "colour, adapted"}
"""The trackers by what the figures call them."""
LINES = {"truth": ":", "fused": "-", "edges alone": "--", "colours adapted": "-."}


SHOWN = (*product(WORLDS, NAMES, (SEED,)), ("circles", "fused", CROSSED))
"""Experiment, tracker and seed of the outlines that the page shows."""


def shown(world: str, seed: int = SEED) -> Sequence:
    """Return the film of an experiment."""
    return filmed(world, seed, FRAMES)


@recorded("shape-tracks", SHOWN)
def track(world: str, name: str, seed: int = SEED) -> Float[np.ndarray, "frames points 2"]:
    """Return the outlines of a tracker in the film of an experiment, from the second frame on."""
    seen, rng = shown(world, seed), np.random.default_rng(seed)
    found = experiments.follow(NAMES[name], seen, trained(world), rules_of(world), rng=rng)
    return np.array(list(found))


def overlap(world: str, name: str, seed: int = SEED) -> Float[np.ndarray, " frames"]:
    """Return how far these outlines overlap with the truth."""
    return experiments.scored(track(world, name, seed), shown(world, seed))


def outline(ax: Axes, points: Float[np.ndarray, "n 2"], name: str, **kwargs: object) -> Axes:
    """Draw the closed outline of a tracker, or the true one, in its colour and line."""
    closed = np.vstack([points, points[:1]])
    options = {"linewidth": 2.2} | kwargs
    ax.plot(*closed.T, color=MEANING[name], linestyle=LINES[name], **options)
    return ax


def frames(
    *worlds: str, seed: int = SEED, names: tuple[str, ...] = ("fused", "colours adapted")
) -> Iterator[Figure]:
    """Yield every second frame of one experiment, or of all side by side, with outlines."""
    for k in range(1, FRAMES + 1, EVERY):
        rows, width = (1, WIDTH) if len(worlds) == 1 else (2, 1.6 * WIDTH)
        size = {"width": width, "height": 0.75 * width}
        edges = {"left": 0, "right": 1, "bottom": 0, "top": 1, "wspace": 0.02, "hspace": 0.02}
        fig, axes = figure(rows, rows, gridspec_kw=edges, **size)
        for ax, world in zip(np.ravel(axes), worlds, strict=True):
            seen = shown(world, seed)
            picture(ax, seen.frames[k])
            for name in reversed(names):
                outline(ax, track(world, name, seed)[k - 1], name)
            outline(ax, seen.outlines[k], "truth", linewidth=1.4)
        yield fig


def four() -> Shown:
    """Return the films of all experiments side by side."""
    return film(
        frames(*WORLDS),
        fps=FPS,
        name="shape-films",
        alt="Four films side by side. The red outline stays on the circle, the card, the beetle "
        "and the shell of the snail; the olive one leaves each of them within seconds.",
        caption="The same films, four seconds each, slowed down. Dotted: the truth. Red: fused. "
        "Olive: colours adapted without a check.",
    )


def lost() -> Shown:
    """Return a film that the fused tracker loses."""
    return film(
        frames("circles", seed=CROSSED, names=("fused",)),
        fps=FPS,
        name="shape-lost",
        alt="A smaller, light blue circle moves across the target; the red outline first holds "
        "both, then jumps onto the smaller circle and leaves with it.",
        caption="A film that the fused tracker loses. Dotted: the truth. Red: fused.",
    )


def picture(ax: Axes, image: np.ndarray) -> Axes:
    """Show an image on axes without scales."""
    ax.imshow(image, interpolation="nearest")
    ax.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5))
    ax.set_xticks([])
    ax.set_yticks([])
    ax.spines[:].set_visible(False)
    ax.grid(visible=False)
    return ax
