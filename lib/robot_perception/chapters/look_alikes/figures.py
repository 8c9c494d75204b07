"""Drawings of the chapter: paths of filters that were told wrong names."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.charts import strip
from explorables.figures.style import MEANING, label
from robot_perception.chapters.visual_slam.figures import WIDE, ground


@drawn(
    name="look-pulled",
    alt="Floor plan with the true path and two others: the dashed one stays near the true path, "
    "the dotted one jumps about and cuts through walls.",
    caption="Sixteen of a hundred names are wrong. Dotted: the path by one filter of the pose and "
    "all landmarks. Dashed: the best of ten particles, with the same names. Solid: the true path.",
    width=6.4,
    height=4.4,
)
def pulled(ax: Axes, one: Any, ten: Any, walls: np.ndarray) -> Axes:
    """Draw the path of one hypothesis beside that of the best of ten."""
    ground(ax, walls, one.truth, WIDE)
    ax.plot(*one.path.T, color=MEANING["error"], linewidth=1.6, linestyle=":")
    ax.plot(*ten.path.T, color=MEANING["robot"], linewidth=1.4, linestyle="--")
    return ax


@drawn(
    name="look-drives",
    alt="Two rows of dots on one axis. One filter: between five and ten metres off. Ten particles: "
    "mostly below one metre. A ring in each row marks the drive that is shown, at its left end.",
    caption="Dots: ten other buildings with as many wrong names, each by how far the path is off. "
    "Rings: the drive that is shown.",
    width=6.4,
    height=1.9,
)
def drives(ax: Axes, errors: Mapping[str, Sequence[float]], shown: Mapping[str, float]) -> Axes:
    """Draw where the drive that is shown lies among those that are scored."""
    return strip(ax, errors, shown, "path off by (m, root mean square)")


def followed(ax: Axes, state: Any, walls: np.ndarray) -> Axes:
    """Draw one path and the truth, on axes cleared first."""
    ax.clear()
    ground(ax, walls, state.truth, WIDE)
    ax.plot(*state.path.T, color=MEANING["robot"], linewidth=1.4, linestyle="--")
    x, y = state.path[-1].tolist()
    ax.plot(x, y, "o", color=MEANING["robot"], markersize=6)
    label(ax, x, y + 0.5, "the end", MEANING["robot"], ha="center")
    return ax
