"""Drawings of the monobot with an anchor or a camera: Figs 4, 5 and 6 side by side."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from robot_perception.chapters.monobot import figures
from robot_perception.chapters.monobot.figures import MEASUREMENTS, AxesRow
from robot_perception.chapters.monobot.rail import Result
from robot_perception.teaching.figures.style import MEANING, label

REFERENCES = ("plain", "anchored", "external")
"""What the studies of Figs 4, 5 and 6 mean, in the order of `rails.FIGURES`."""

ROWS = ("position (m)", "vehicle error (m)", "landmark error (m)", "gain")


def side_by_side(axes: np.ndarray, results: Mapping[str, Result], run: int) -> np.ndarray:
    """Draw one run of several studies, a column for each, with common scales in each row.

    Parameters
    ----------
    axes : ndarray of Axes, shape (4, studies)
        Rows: path and landmark, vehicle error, landmark error, gains; all bands are ±2σ.
    results
        Studies with one landmark, by title.
    run
        Number of the run.
    """
    for column, (name, result) in zip(axes.T, results.items(), strict=True):
        figures.trajectory(column[0], result, run)
        figures.vehicle_error(column[1], result, run)
        figures.landmark_error(column[2], result, run)
        figures.gains(column[3], result)
        column[0].set_title(name)
    for row, what in zip(figures.common_scales(axes), ROWS, strict=True):
        for ax in row:
            ax.set(xlabel="", ylabel=what)
            ax.locator_params(nbins=4)
    for ax in axes[:-1].flat:
        ax.tick_params(labelbottom=False)
    for ax in axes[-1]:
        ax.set_xlabel(MEASUREMENTS)
    return axes


def remaining(ax: Axes, shares: Mapping[str, np.ndarray]) -> Axes:
    """Draw the share of the first error's variance left after each measurement, on log scales.

    Parameters
    ----------
    ax
        Where to draw.
    shares
        By name of the study, from the first measurement (share 1) on.
    """
    for (name, share), meaning in zip(shares.items(), REFERENCES, strict=True):
        colour = MEANING[meaning]
        k = np.arange(1, len(share))
        ax.loglog(k, share[1:], color=colour)
        label(ax, 1.1 * k[-1], share[-1], name, colour, va="center", fontsize=9)
    law = MEANING["expected"]
    ax.loglog(k, 1 / k, color=law, linestyle="--", linewidth=1.2)
    label(ax, 12, 0.11, "1/k", law, fontweight=400)
    ax.set(
        xlim=(1, 1.1 * k[-1]), ylim=(None, 1.5), xlabel=MEASUREMENTS, ylabel="share of the variance"
    )
    ax.minorticks_off()
    return ax


def fan_and_gains(axes: AxesRow, result: Result, *, reach: float) -> AxesRow:
    """Draw the landmark errors of many runs and the gains, on two axes that are cleared first.

    Parameters
    ----------
    axes
        Two.
    result
        The study.
    reach
        Half the height of the error axis, m: the same for all settings, so that they compare.
    """
    for ax in axes:
        ax.clear()
    figures.error_fan.on(axes[0], result)
    figures.gains(axes[1], result)
    axes[0].set_ylim(-reach, reach)
    axes[1].set_ylim(-0.5, 1.0)
    for ax in axes:
        ax.locator_params(nbins=5)
    return axes
