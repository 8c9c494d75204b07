"""The film of the chapter: the same drive with names unknown and known, as the maps grow."""

from collections.abc import Iterator, Mapping
from types import SimpleNamespace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from explorables.figures import figure
from explorables.figures.films import film
from explorables.figures.maps import lines, plan
from explorables.figures.style import MEANING, label
from explorables.media import Shown

FPS = 8
EVERY = 8
"""Steps of 20 cm from one frame to the next."""
WIDTH, HEIGHT = 7.0, 2.4
PLACES = (0.01, 0.01, 0.485, 0.88), (0.505, 0.01, 0.485, 0.88)
"""Places of both maps in the frame of the film: left, bottom, width, height."""


def both_maps(maps: Mapping[str, SimpleNamespace]) -> Shown:
    """Show how two maps of one drive grow; the poster is the last frame: one is closed."""
    return film(
        frames(maps),
        fps=FPS,
        name="loop-film",
        poster=len(steps_of(next(iter(maps.values())))) - 1,
        alt="Two maps of one drive grow round a courtyard, side by side, and both bend. When the "
        "robot comes back to the first corridor, the right path jumps home; the left one draws the "
        "corridor a second time beside the first.",
        caption="The same drive, the same readings (blue) and the same wheels; where names are "
        "known, the filter is told which landmark is which. Broad grey: the true floor. Red: the "
        "path as it was believed on the way; dashed: the true one; magenta: the error now.",
    )


def steps_of(built: SimpleNamespace) -> list[int]:
    """Return the steps of the drive that are shown."""
    last = len(built.truth) - 1
    return [*range(0, last, EVERY), last]


def frames(maps: Mapping[str, SimpleNamespace]) -> Iterator[Figure]:
    """Yield the frames of the film, all drawn on one figure."""
    fig, axes = figure(1, 2, width=WIDTH, height=HEIGHT)
    for ax, place in zip(axes, PLACES, strict=True):
        ax.set_position(place)
    for step in steps_of(next(iter(maps.values()))):
        for ax, (title, built) in zip(axes, maps.items(), strict=True):
            grown(ax, built, step, title)
        yield fig


def grown(ax: Axes, built: SimpleNamespace, step: int, title: str) -> Axes:
    """Draw path, readings and error of the position until a step, on axes cleared first."""
    ax.clear()
    truth, path = built.truth[: step + 1, :2], built.path[: step + 1, :2]
    lines(ax, built.faces, MEANING["truth"], 3.0, alpha=0.25, zorder=0)
    readings = built.readings[built.steps <= step]
    ax.plot(*readings.T, "o", color=MEANING["readings"], markersize=0.9)
    ax.plot(*truth.T, color=MEANING["truth"], linewidth=1.0, linestyle="--")
    ax.plot(*path.T, color=MEANING["robot"], linewidth=1.6)
    ends = np.stack([truth[-1], path[-1]])
    ax.plot(*ends.T, color=MEANING["error"], linewidth=2.2)
    ax.plot(*ends[1], "o", color=MEANING["error"], markersize=5)
    plan(ax, built.faces.reshape(-1, 2), margin=4.0)
    ax.set_axis_off()
    off = float(np.hypot(*(ends[1] - ends[0])))
    middle = float(np.mean(ax.get_xlim()))
    label(
        ax,
        middle,
        ax.get_ylim()[1],
        f"{title}: {off:.1f} m off",
        MEANING["truth"],
        ha="center",
        fontsize=12.5,
    )
    return ax
