"""Charts of what studies find: curves and bars with their intervals, states and arrows."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch

from robot_perception.evaluation.intervals import Interval
from robot_perception.teaching.figures.style import MEANING, band


def curve(
    ax: Axes, x: Sequence[float], found: Sequence[Interval], colour: str, line: str = "-o",
    **words: Any,
) -> None:  # fmt: skip
    """Draw estimates over x as a line with marks, and their intervals as a band."""
    band(ax, np.array(x), *np.array([(of.low, of.high) for of in found]).T, colour)
    ax.plot(x, [of.estimate for of in found], line, color=colour, markersize=4, **words)


def bars(ax: Axes, found: Mapping[str, Interval], colour: str, xlabel: str) -> None:
    """Draw a bar from 0 to 1 for each share, the first on top, and its interval as a line."""
    for k, of in enumerate(found.values()):
        ax.barh(k, of.estimate, color=colour, height=0.6)
        ax.plot([of.low, of.high], [k, k], color=MEANING["mean"], linewidth=1.4)
    ax.set_yticks(range(len(found)), list(found))
    ax.set(xlim=(0, 1.0), ylim=(len(found) - 0.4, -0.6), xlabel=xlabel)


class Arrow(NamedTuple):
    """An arrow from a state to another one, as it is drawn."""

    source: str
    target: str
    bend: float = 0.12
    dashed: bool = False


def states(ax: Axes, places: Mapping[str, tuple[float, float]], arrows: Sequence[Arrow]) -> None:
    """Draw states as words in boxes at their places, and arrows between them."""
    ax.axis("off")
    for name, at in places.items():
        ax.text(*at, name, ha="center", va="center", fontsize=12, fontweight="bold",
                bbox={"boxstyle": "round,pad=0.35", "facecolor": "none",
                      "edgecolor": MEANING["mean"], "linewidth": 1.6})  # fmt: skip
    for arrow in arrows:
        ax.add_patch(FancyArrowPatch(
            places[arrow.source], places[arrow.target], arrowstyle="-|>", mutation_scale=13,
            color=MEANING["expected" if arrow.dashed else "mean"], shrinkA=21, shrinkB=21,
            linewidth=1.6, clip_on=False, linestyle="--" if arrow.dashed else "-",
            connectionstyle=f"arc3,rad={arrow.bend}",
        ))  # fmt: skip
