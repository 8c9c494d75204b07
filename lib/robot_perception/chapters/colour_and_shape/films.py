"""The four experiments as films: where the object is, and where trackers have it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import data_synth.coloured
from data_synth.coloured import Sequence
from robot_perception import appearance
from robot_perception.chapters.colour_and_shape import experiments
from robot_perception.chapters.colour_and_shape.experiments import CHOOSING, WORLDS, Config
from robot_perception.teaching.figures import figure
from robot_perception.teaching.figures.style import MEANING
from robot_perception.teaching.kept import kept

FRAMES = 61
EVERY = 2
"""Which of them a film shows."""
FPS = 6.0
WIDTH = 4.2
"""Of a frame, inches."""
SEED = CHOOSING[2]
"""Of the films that are shown, of those on which numbers were chosen; picked since all of them show
what a cue alone does not hold. The fused tracker loses the circle of the fourth."""
NAMES: Mapping[str, str] = MappingProxyType(
    {"fused": "fused", "shape": "edges alone", "colour, adapted": "colours adapted"}
)
"""What the figures call a tracker."""
LINES: Mapping[str, str] = MappingProxyType(
    {"truth": ":", "fused": "-", "edges alone": "--", "colours adapted": "-."}
)


@dataclass(frozen=True, eq=False, slots=True)
class Tracks:
    """Outlines and their overlap with the truth, by tracker, from the second frame on.

    Parameters
    ----------
    outlines
        Closed, px; for each tracker (n, points, 2).
    overlap
        Intersection over union with the truth; for each tracker (n,).
    """

    outlines: Mapping[str, Float[np.ndarray, "n points 2"]]
    overlap: Mapping[str, Float[np.ndarray, " n"]]


@cache
def filmed(world: str, seed: int = SEED) -> Sequence:
    """Return the film of an experiment."""
    return WORLDS[world](rng=np.random.default_rng(seed), frames=FRAMES)


def _followed(world: str, seed: int) -> Tracks:
    film, config = filmed(world, seed), Config()
    dynamics, shape = experiments.trained(world, config), film.frames.shape[1:3]
    outlines, overlap = {}, {}
    for tracker, name in NAMES.items():
        rng = np.random.default_rng(seed)
        steps = experiments.follow(tracker, film, dynamics, config.of(world), rng=rng)
        outlines[name] = np.array([found for found, _ in steps])
        pairs = zip(outlines[name], film.outlines[1:], strict=True)
        overlap[name] = np.array([experiments.overlap(*pair, shape) for pair in pairs])
    return Tracks(outlines, overlap)


@cache
def tracks(world: str, seed: int = SEED) -> Tracks:
    """Return what trackers make of the film of an experiment; kept on this computer."""
    code = (data_synth.coloured, appearance, experiments)
    return kept(_followed, Tracks, world, seed, code=code)


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
    for k in range(1, FRAMES, EVERY):
        rows, width = (1, WIDTH) if len(worlds) == 1 else (2, 1.6 * WIDTH)
        size = {"width": width, "height": 0.75 * width}
        edges = {"left": 0, "right": 1, "bottom": 0, "top": 1, "wspace": 0.02, "hspace": 0.02}
        fig, axes = figure(rows, rows, gridspec_kw=edges, **size)
        for ax, world in zip(np.ravel(axes), worlds, strict=True):
            film, found = filmed(world, seed), tracks(world, seed)
            picture(ax, film.frames[k])
            for name in reversed(names):
                outline(ax, found.outlines[name][k - 1], name)
            outline(ax, film.outlines[k], "truth", linewidth=1.4)
        yield fig


def picture(ax: Axes, image: np.ndarray) -> Axes:
    """Show an image on axes without scales."""
    ax.imshow(image, interpolation="nearest")
    ax.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5))
    ax.set_xticks([])
    ax.set_yticks([])
    ax.spines[:].set_visible(False)
    ax.grid(visible=False)
    return ax
