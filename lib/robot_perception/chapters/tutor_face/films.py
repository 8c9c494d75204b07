"""The film of the chapter: a face that looks away, and the window in which it is looked for."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from robot_perception.chapters.tutor_face import figures as draw
from robot_perception.chapters.tutor_face import views
from robot_perception.teaching.figures import figure
from robot_perception.teaching.figures.films import film
from robot_perception.teaching.figures.style import MEANING
from robot_perception.teaching.media import Shown

FPS = 8.0


def followed() -> Shown:
    """Show the picture, the face, the filter's box, its window, and the share that is searched."""
    seen = views.filmed()[1]
    return film(
        frames(),
        fps=FPS,
        name="tutor-film",
        poster=int((~seen.seen).argmax()),
        alt="A person moves before a wall and looks away now and then. A solid square stays on the "
        "face, also while it looks away; a dashed frame round it widens then and shrinks again.",
        caption="Dotted: the face. Solid: where the filter has it. Dashed: the window in which the "
        "detector looks. Below: the share of the picture that is searched; shaded where that "
        "search finds no face.",
    )


def frames() -> Iterator[Figure]:
    """Yield the pictures of the film, all on one figure."""
    pictures, seen = views.filmed()
    fig, (top, below) = figure(2, width=4.8, height=5.0)
    top.set_position((0.0, 0.29, 1.0, 0.71))
    below.set_position((0.14, 0.11, 0.83, 0.14))
    for k, image in enumerate(pictures):
        top.clear()
        draw.picture(top, image)
        draw.square(top, seen.truth[k], MEANING["truth"], linewidth=3.0, linestyle=":")
        if np.isfinite(seen.boxes[k]).all():
            draw.square(top, seen.boxes[k], MEANING["estimate"], linewidth=2.4)
        draw.square(top, seen.windows[k], MEANING["camera"], linewidth=1.6, linestyle="--")
        below.clear()
        gaps = seen.missed[: k + 1]
        below.fill_between(np.arange(k + 1), 0, 1, where=gaps, step="mid",
                           color=MEANING["expected"], alpha=0.3, linewidth=0)  # fmt: skip
        below.plot(np.arange(k + 1), seen.share[: k + 1], color=MEANING["camera"])
        below.set(xlim=(0, len(pictures) - 1), ylim=(0, 1.02), xlabel="picture", ylabel="searched")
        yield fig
