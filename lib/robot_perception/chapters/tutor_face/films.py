"""The film of the chapter: a face that looks away, and the window in which it is looked for."""

from collections.abc import Iterator, Sequence
from types import SimpleNamespace

import numpy as np
from matplotlib.figure import Figure

from explorables.figures import figure
from explorables.figures.films import film
from explorables.figures.maps import picture, square
from explorables.figures.style import MEANING
from explorables.media import Shown

FPS = 8.0


def followed_face(steps: Sequence[SimpleNamespace], poster: int) -> Shown:
    """Show each picture, the face, the filter's box, its window, and the share that is searched."""
    return film(
        frames(steps),
        fps=FPS,
        name="tutor-film",
        poster=poster,
        alt="A person moves before a wall and looks away now and then. A solid square stays on the "
        "face, also while it looks away; a dashed frame round it widens then and shrinks again.",
        caption="Dotted: the face. Solid: where the filter has it. Dashed: the window in which the "
        "detector looks. Curve: the share of the picture that is searched; shaded where that "
        "search finds no face.",
    )


def frames(steps: Sequence[SimpleNamespace]) -> Iterator[Figure]:
    """Yield the pictures of the film, all on one figure."""
    share = np.array([step.searched for step in steps])
    missed = np.array([step.missed for step in steps])
    fig, (top, below) = figure(2, width=4.8, height=5.0)
    top.set_position((0.0, 0.29, 1.0, 0.71))
    below.set_position((0.14, 0.11, 0.83, 0.14))
    for k, step in enumerate(steps):
        top.clear()
        picture(top, step.frame)
        square(top, step.truth, MEANING["truth"], linewidth=3.0, linestyle=":")
        if step.box is not None:
            square(top, step.box, MEANING["estimate"], linewidth=2.4)
        square(top, step.window, MEANING["camera"], linewidth=1.6, linestyle="--")
        below.clear()
        times = np.arange(k + 1)
        below.fill_between(times, 0, 1, where=missed[: k + 1], step="mid",
                           color=MEANING["expected"], alpha=0.3, linewidth=0)  # fmt: skip
        below.plot(times, share[: k + 1], color=MEANING["camera"])
        below.set(xlim=(0, len(steps) - 1), ylim=(0, 1.02), xlabel="picture", ylabel="searched")
        yield fig
