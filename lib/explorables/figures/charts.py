"""Charts of what studies find: curves and bars with their intervals, states and arrows."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from explorables.figures.style import GROUND, INK, MEANING, MUTED, band


class Interval(Protocol):
    """A value with the ends of its interval."""

    @property
    def estimate(self) -> float:
        """Return the value."""

    @property
    def low(self) -> float:
        """Return the lower end."""

    @property
    def high(self) -> float:
        """Return the upper end."""


def curve(
    ax: Axes, x: Sequence[float], found: Sequence[Interval], colour: str, line: str = "-o",
    **words: Any,
) -> None:  # fmt: skip
    """Draw estimates over x as a line with marks, and their intervals as a band."""
    band(ax, np.array(x), *np.array([(of.low, of.high) for of in found]).T, colour)
    ax.plot(x, [of.estimate for of in found], line, color=colour, markersize=4, **words)


def bars(ax: Axes, found: Mapping[str, Interval | str], colour: str, xlabel: str) -> None:
    """Draw a bar from 0 to 1 for each share, the first on top, and its interval as a line.

    What is no share, as of an order that nobody came to, is written.
    """
    for k, of in enumerate(found.values()):
        if isinstance(of, str):
            ax.text(0.01, k, of, va="center")
            continue
        ax.barh(k, of.estimate, color=colour, height=0.6)
        ax.plot([of.low, of.high], [k, k], color=MEANING["mean"], linewidth=1.4)
    ax.set_yticks(range(len(found)), list(found))
    ax.set(xlim=(0, 1.0), ylim=(len(found) - 0.4, -0.6), xlabel=xlabel)


class Arrow(NamedTuple):
    """An arrow from a state to another one, as it is drawn; its text stands on its middle."""

    source: str
    target: str
    bend: float = 0.12
    text: str = ""
    dashed: bool = False


def states(ax: Axes, places: Mapping[str, tuple[float, float]], arrows: Sequence[Arrow]) -> None:
    """Draw states as words in boxes at their places, in inches, and arrows between them."""
    ax.axis("off")
    ax.set_aspect("equal")
    boxes = {}
    for name, (x, y) in places.items():
        wide, high = 0.1 * len(name) + 0.2, 0.34
        boxes[name] = ax.add_patch(FancyBboxPatch(
            (x - wide / 2, y - high / 2), wide, high, boxstyle="round,pad=0,rounding_size=0.08",
            facecolor="none", edgecolor=MEANING["mean"], linewidth=1.6,
        ))  # fmt: skip
        ax.text(x, y, name, ha="center", va="center", fontsize=11, fontweight="bold")
    for arrow in arrows:
        ends = np.array([places[arrow.source], places[arrow.target]])
        ax.add_patch(FancyArrowPatch(
            *map(tuple, ends.tolist()), arrowstyle="-|>", mutation_scale=13,
            patchA=boxes[arrow.source], patchB=boxes[arrow.target], shrinkA=1, shrinkB=1,
            color=MEANING["expected" if arrow.dashed else "mean"], linewidth=1.6, clip_on=False,
            linestyle="--" if arrow.dashed else "-", connectionstyle=f"arc3,rad={arrow.bend}",
        ))  # fmt: skip
        (x, y), (dx, dy) = ends.mean(axis=0), np.diff(ends, axis=0)[0]
        if arrow.text:
            ax.text(x + arrow.bend * dy / 2, y - arrow.bend * dx / 2, arrow.text, ha="center",
                    va="center", fontsize=10.5, bbox={
                        "facecolor": GROUND, "edgecolor": "none", "pad": 1.0})  # fmt: skip


def strip(
    ax: Axes, drawn: Mapping[str, Sequence[float]], shown: Mapping[str, float], xlabel: str
) -> Axes:
    """Draw a row of dots for each name, and a ring where the one that is shown lies among them.

    Parameters
    ----------
    ax
        Axes.
    drawn
        Values by the name of their row.
    shown
        By the same names the value of the run that a page shows.
    xlabel
        What the values are.

    Raises
    ------
    KeyError
        If a row has no value that is shown.
    """
    for row, (name, values) in enumerate(drawn.items()):
        level = np.full(len(values), float(row))
        ax.plot(values, level, "o", color=MUTED, alpha=0.7, markersize=6)
        ring = {"fillstyle": "none", "markersize": 13, "markeredgewidth": 2.0}
        ax.plot([shown[name]], [row], "o", color=INK, **ring)
        ax.text(1.0, row - 0.25, name, transform=ax.get_yaxis_transform(), ha="right", va="bottom")
    ax.set(xlabel=xlabel, yticks=[], xlim=(0, None), ylim=(len(drawn) - 0.6, -0.9))
    return ax
