"""The film of the chapter: a pattern that moves, is covered, and jumps."""

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
from matplotlib.figure import Figure

from explorables.figures import figure
from explorables.figures.films import film
from explorables.figures.style import MEANING
from explorables.media import Shown
from robot_perception.chapters.pattern_tracking import figures as draw

FPS = 6.0


def followed_sign(seen: SimpleNamespace) -> Shown:
    """Show picture, particles, truth and estimate, and below them the error."""
    return film(
        frames(seen),
        fps=FPS,
        name="pattern-film",
        poster=seen.covered[0] + 2,
        alt="A sign swings over a crowded picture; a solid frame stays on the dotted one, also "
        "while half of the sign is covered. Then the sign jumps: the solid frame stays behind, and "
        "the error rises.",
        caption="Dotted: the pattern. Solid: the estimate. Dots: the particles after the picture. "
        "Below: the mean error of the four coordinates. Half of the pattern is covered in the "
        "shaded pictures; at the mark it jumps by six σ.",
    )


def frames(seen: SimpleNamespace) -> Iterator[Figure]:
    """Yield the pictures of the film, all on one figure."""
    fig, (top, below) = figure(2, width=4.8, height=5.2)
    top.set_position((0.0, 0.31, 1.0, 0.69))
    below.set_position((0.13, 0.11, 0.84, 0.15))
    count, off = len(seen.images), seen.off
    for k, image in enumerate(seen.images):
        top.clear()
        draw.picture(top, image)
        draw.card(top, seen, k)
        below.clear()
        ends = seen.covered[0], seen.covered[-1]
        below.axvspan(*ends, color=MEANING["expected"], alpha=0.2, linewidth=0)
        below.axvline(seen.jump, color=MEANING["expected"], linewidth=1.0)
        below.plot(np.arange(k + 1), off[: k + 1], color=MEANING["error"])
        below.set(xlim=(0, count - 1), ylim=(0, 5), xlabel="picture", ylabel="error (σ)")
        yield fig
