"""The four experiments as films: where the object is, and where trackers have it."""

from collections.abc import Iterator, Mapping

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from data_synth.coloured import Sequence
from explorables.figures import figure
from explorables.figures.films import film
from explorables.figures.style import MEANING
from explorables.media import Shown

EVERY = 2
"""Frames from one that a film shows to the next."""
FPS = 6.0
WIDTH = 4.2
"""Width of a frame, inches."""
LINES = {"truth": ":", "fused": "-", "edges alone": "--", "colours adapted": "-."}
Tracks = Mapping[str, Float[np.ndarray, "frames points 2"]]
"""Outlines by tracker, from the second frame on."""


def outline(ax: Axes, points: Float[np.ndarray, "n 2"], name: str, **kwargs: object) -> Axes:
    """Draw the closed outline of a tracker, or the true one, in its colour and line."""
    closed = np.vstack([points, points[:1]])
    options = {"linewidth": 2.2} | kwargs
    ax.plot(*closed.T, color=MEANING[name], linestyle=LINES[name], **options)
    return ax


def frames(films: Mapping[str, Sequence], tracks: Mapping[str, Tracks]) -> Iterator[Figure]:
    """Yield every second frame of one film, or of all side by side, with outlines."""
    length = len(next(iter(films.values())).frames)
    rows, width = (1, WIDTH) if len(films) == 1 else (2, 1.6 * WIDTH)
    edges = {"left": 0, "right": 1, "bottom": 0, "top": 1, "wspace": 0.02, "hspace": 0.02}
    for k in range(1, length, EVERY):
        fig, axes = figure(rows, rows, gridspec_kw=edges, width=width, height=0.75 * width)
        for ax, (world, seen) in zip(np.ravel(axes), films.items(), strict=True):
            picture(ax, seen.frames[k])
            for name in reversed(tracks[world]):
                outline(ax, tracks[world][name][k - 1], name)
            outline(ax, seen.outlines[k], "truth", linewidth=1.4)
        yield fig


def four(films: Mapping[str, Sequence], tracks: Mapping[str, Tracks]) -> Shown:
    """Return the films of all experiments side by side."""
    return film(
        frames(films, tracks),
        fps=FPS,
        name="shape-films",
        poster=24,
        alt="Four films at once. The red outline stays on the circle, the card, the beetle "
        "and the shell of the snail; the olive one leaves each of them within seconds.",
        caption="The same films, four seconds each, slowed down. Dotted: the truth. Red: fused. "
        "Olive: colours adapted without a check.",
    )


def lost(film_of_circles: Sequence, track: np.ndarray, poster: int) -> Shown:
    """Return a film that the fused tracker loses; it opens where the outline goes astray."""
    return film(
        frames({"circles": film_of_circles}, {"circles": {"fused": track}}),
        fps=FPS,
        name="shape-lost",
        poster=poster,
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
