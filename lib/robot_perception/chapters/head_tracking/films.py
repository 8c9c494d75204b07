"""The films of the chapter: a rendered and a real head, and where two trackers have it."""

from collections.abc import Iterator, Mapping
from types import SimpleNamespace

import numpy as np
from jaxtyping import Float, UInt8
from matplotlib.figure import Figure

from explorables.figures import figure
from explorables.figures.films import film
from explorables.figures.style import MEANING
from explorables.media import Shown
from robot_perception import datasets
from robot_perception.chapters.head_tracking import figures as draw
from robot_perception.chapters.head_tracking.recordings import Girl
from robot_perception.datasets import read_images

FPS = 7.5
WIDE, NARROW, HIGH = 4.6, 3.6, 1.12
"""Widths of the films, of pictures of 320 and of 128 px, and their height as a share of that."""
PLACES = (0.0, 0.33, 1.0, 0.67), (0.15, 0.135, 0.83, 0.15)
"""Places of the picture and of the overlap below it in the frame of a film."""
Rings = Mapping[str, Float[np.ndarray, "n 4"]]
LINES = {"truth": ":", "fixed model": "--", "adapted model": "-"}


def light(seen: SimpleNamespace) -> Shown:
    """Show the rendered head in changing light, with the fixed and the adapted model."""
    return film(
        frames(seen.images, seen.rings, seen.overlaps, 2, WIDE),
        fps=FPS,
        name="head-film",
        poster=55,
        alt="A man's head moves through a rendered room whose light grows dim, bright and "
        "coloured. A solid ellipse stays on or near the head; a dashed one slides off after "
        "seven seconds and ends on the door. Below, its overlap falls to zero.",
        caption="The first film of the explorer. Dotted: the head. Dashed: the model of the "
        "first frame. Solid: the adapted one. Below: the overlap (IoU) of each with the head: "
        "the area that both cover over the area that either covers.",
    )


def girl(dataset: str, result: Girl) -> Shown:
    """Show the girl with the fixed model and the one adapted fast, if the recording is here."""
    folder = datasets.find(dataset)
    if folder is None:
        words = f"The film needs the recording {dataset}, which is not on this machine."
        return Shown({"text/html": f"<p>{words}</p>", "text/plain": words})
    named = {"fixed model": "fixed", "adapted model": "adapted fast"}
    row = {meaning: result.variants.index(name) for meaning, name in named.items()}
    rings = {"truth": result.marked} | {k: result.ellipses[at] for k, at in row.items()}
    return film(
        frames(
            np.array(list(read_images(folder / "img", "*.jpg", colour=True))),
            rings,
            {k: result.iou[at] for k, at in row.items()},
            4,
            NARROW,
        ),
        fps=FPS,
        name="head-girl-film",
        poster=len(result.marked) // 8,
        alt="A girl turns round on a chair. A dashed ellipse stays on or near her head, face and "
        "hair; a solid one slides to her side within seconds and stays in the background.",
        caption="Every fourth frame of the recording. Dotted: the marked head. Dashed: the fixed "
        "model. Solid: the one adapted fast. Below: their overlap with the marked head.",
    )


def frames(
    pictures: UInt8[np.ndarray, "n height width 3"],
    rings: Rings,
    overlaps: Mapping[str, Float[np.ndarray, " n"]],
    every: int,
    width: float,
) -> Iterator[Figure]:
    """Yield some pictures with ellipses, below them the overlaps so far, all on one figure."""
    fig, (top, below) = figure(2, width=width, height=HIGH * width)
    for ax, place in zip((top, below), PLACES, strict=True):
        ax.set_position(place)
    for k in range(0, len(pictures), every):
        top.clear()
        draw.picture(top, pictures[k])
        for name, places in rings.items():
            draw.ring(top, places[k], MEANING[name], linestyle=LINES[name], linewidth=2.2)
        below.clear()
        for name, iou in overlaps.items():
            below.plot(iou[: k + 1], LINES[name], color=MEANING[name], linewidth=1.6)
        below.set(xlim=(0, len(pictures) - 1), ylim=(0, 1), xlabel="frame", ylabel="overlap")
        yield fig
