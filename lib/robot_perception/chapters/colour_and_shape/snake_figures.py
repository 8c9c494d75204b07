"""Figures of the snakes on the snail, and of the sign of the area's score."""

import numpy as np
from jaxtyping import UInt8
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from robot_perception.appearance.affine_snake import SnakeFit
from robot_perception.chapters.colour_and_shape import area_sign
from robot_perception.chapters.colour_and_shape.snake_explorers import Slid
from robot_perception.chapters.colour_and_shape.snakes import SNAKES, Case, Grid, Measures, Result
from robot_perception.teaching.figures.style import MEANING, label

HALF = 80.0
"""Half the width of what is shown round the shell, px; the height is three quarters of it."""

STEPS = (2, 5, 12)
"""Steps of a snake that are drawn between its start and its end."""


def segmented(case: Case) -> UInt8[np.ndarray, "height width 3"]:
    """Return the frame with the blob as it is, its neck tinted, and all else faded."""
    faded = 110 + case.image.astype(float) * 0.2
    picture = np.where(case.blob[..., None], case.image, faded)
    neck = case.blob & case.neck
    tint = 255 * np.array(to_rgb(MEANING["neck"]))
    picture[neck] = 0.4 * picture[neck] + 0.6 * tint
    return np.round(picture).astype(np.uint8)


def near(ax: Axes, case: Case) -> Axes:
    """Show of the axes of a picture what lies round the shell."""
    height, width = case.neck.shape
    u = np.clip(case.truth[:, 0].mean(), HALF - 0.5, width - 0.5 - HALF)
    v = np.clip(case.truth[:, 1].mean(), 0.75 * HALF - 0.5, height - 0.5 - 0.75 * HALF)
    ax.set(xlim=(u - HALF, u + HALF), ylim=(v + 0.75 * HALF, v - 0.75 * HALF))
    return ax


def outline(ax: Axes, points: np.ndarray, colour: str, **kwargs: object) -> Axes:
    """Draw a closed outline."""
    ax.plot(*np.vstack([points, points[:1]]).T, color=colour, **kwargs)
    return ax


def beginning(ax: Axes, case: Case) -> Axes:
    """Draw the outline of the frame before, and the edges of the segmentation."""
    v, u = np.nonzero(case.edges)
    ax.plot(u, v, ".", color=MEANING["expected"], markersize=2.5)
    outline(ax, case.start, MEANING["truth"], linestyle="--")
    return near(ax, case)


def sliding(ax: Axes, case: Case, fit: SnakeFit, snake: str) -> Axes:
    """Draw a snake from its start over some steps to its end."""
    colour = MEANING[f"{snake} snake"]
    outline(ax, fit.iterates[0], MEANING["truth"], linestyle="--", linewidth=1.4)
    for step in STEPS:
        if step < len(fit.iterates) - 1:
            outline(ax, fit.iterates[step], colour, linewidth=0.9, alpha=0.6)
    outline(ax, fit.outline, colour, linewidth=2.4)
    return near(ax, case)


def slid(ax: Axes, state: Slid) -> Axes:
    """Draw a state of the explorer on the axes of the segmented frame, cleared first."""
    ax.clear()
    sliding(ax, state.case, state.fit, state.snake)
    words = f"overlap {state.overlap:.2f}, neck {state.swallowed:.0%}"
    colour = MEANING[f"{state.snake} snake"]
    label(ax, 0.03, 0.93, words, colour, transform=ax.transAxes, fontsize=12)
    return ax


def _shares(ax: Axes, values: np.ndarray, colour: str, name: str) -> None:
    ordered = np.sort(values)
    share = np.arange(1, len(ordered) + 1) / len(ordered)
    ax.step(np.r_[0, ordered, 1], np.r_[0, share, 1], where="post", color=colour, label=name)


def swallowed(ax: Axes, result: Result) -> Axes:
    """Draw in what share of the cases a snake holds no more than so much of the neck."""
    for snake in SNAKES:
        measures: Measures = result.snakes[snake]
        _shares(ax, measures.swallowed, MEANING[f"{snake} snake"], f"{snake} snake")
    ax.set(xlabel="share of the neck inside", ylabel="share of the cases")
    ax.set(xlim=(0, 1), ylim=(0, 1.02))
    ax.legend(loc="lower right")
    return ax


def stiffness(ax: Axes, found: Grid) -> Axes:
    """Draw the mean overlap against the rigidity, at the least elasticity, by snake."""
    for row, snake in enumerate(SNAKES):
        colour = MEANING[f"{snake} snake"]
        ax.plot(found.rigidities, found.overlap[row, 0], "o-", color=colour, label=f"{snake} snake")
    ax.set_xscale("log")
    ax.set(xlabel="rigidity β", ylabel="mean overlap with the shell", ylim=(0.7, 1))
    ax.legend(loc="lower right")
    return ax


def signs(ax: Axes, config: area_sign.Config) -> Axes:
    """Draw the weight of a segmentation against its area, with both signs."""
    ratios = np.geomspace(0.25, 4, 97)
    for sign, meaning, line in (("printed", "paper", "--"), ("turned round", "right", "-")):
        weights = area_sign.curve(ratios, config, sign)
        ax.plot(ratios, weights, line, color=MEANING[meaning], label=sign)
    ax.axvline(1, color=MEANING["expected"], linewidth=1.0)
    ax.set_xscale("log", base=2)
    ax.set_xticks([0.25, 0.5, 1, 2, 4], ["¼", "½", "1", "2", "4"])
    ax.set(xlabel="area found / area predicted", ylabel="weight", xlim=(0.25, 4), ylim=(0, 1.05))
    ax.legend(loc="lower left")
    return ax
