"""Drawings of the monobot with an anchor or a camera: Figs 4, 5 and 6 side by side."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from robot_perception.chapters.monobot.figures import (
    LOOKS,
    AxesRow,
    error_band,
    error_fan,
    gains_of,
    trajectory,
)
from robot_perception.teaching.figures.style import BLUE, COLOURS, MUTED, ORANGE, label

ROWS = ("position (m)", "vehicle error (m)", "landmark error (m)", "gain")


def side_by_side(axes: np.ndarray, panels: Mapping[str, Mapping[str, np.ndarray]]) -> np.ndarray:
    """Draw one run of several studies, a column for each, with common scales in each row.

    Parameters
    ----------
    axes : ndarray of Axes, shape (4, studies)
        Rows: path and landmark, vehicle error, landmark error, gains; all bands are ±2σ.
    panels : mapping of str to mapping
        By title: ``position`` (looks,), ``means`` and ``deviations`` (looks, 2), ``landmark``,
        ``looks`` (looks, 1) and ``gains`` (steps, 2) of vehicle and landmark.
    """
    for column, (name, one) in zip(axes.T, panels.items(), strict=True):
        position, means, deviations = one["position"], one["means"], one["deviations"]
        landmark, sightings = one["landmark"], one["position"] + one["looks"][:, 0]
        path, place = (means[:, 0], deviations[:, 0]), (means[:, 1], deviations[:, 1])
        trajectory(column[0], position, *path, landmark, *place, sightings)
        error_band(column[1], (means[:, 0] - position)[:, None], deviations[:, 0], BLUE, ROWS[1])
        error_band(column[2], means[:, 1:2] - landmark, deviations[:, 1], ORANGE, ROWS[2])
        gains_of(column[3], *one["gains"].T)
        column[0].set_title(name)
    for row, what in zip(axes, ROWS, strict=True):
        limits = np.array([ax.get_ylim() for ax in row])
        for ax in row:
            ax.set(ylim=(limits[:, 0].min(), limits[:, 1].max()), xlabel="", ylabel="")
            ax.locator_params(nbins=4)
        row[0].set_ylabel(what)
    for ax in axes[:-1].flat:
        ax.tick_params(labelbottom=False)
    for ax in axes[:, 1:].flat:
        ax.tick_params(labelleft=False)
    for ax in axes[-1]:
        ax.set_xlabel(LOOKS)
    return axes


def remaining(ax: Axes, shares: Mapping[str, np.ndarray]) -> Axes:
    """Draw which share of the first error's variance is left, look by look, on two log scales.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    shares : mapping of str to ndarray, shape (looks,)
        By name of the study, from the first look (share 1) on.
    """
    for (name, share), colour in zip(shares.items(), COLOURS, strict=False):
        k = np.arange(1, len(share))
        ax.loglog(k, share[1:], color=colour)
        label(ax, 1.1 * k[-1], share[-1], name, colour, va="center", fontsize=9)
    ax.loglog(k, 1 / k, color=MUTED, linestyle="--", linewidth=1.2)
    label(ax, 12, 0.11, "1/k", MUTED, fontweight=400)
    ax.set(xlim=(1, 1.1 * k[-1]), ylim=(None, 1.5), xlabel=LOOKS, ylabel="share of the variance")
    ax.minorticks_off()
    return ax


def fan_and_gains(
    axes: AxesRow,
    errors: np.ndarray,
    deviations: np.ndarray,
    gains: np.ndarray,
    *,
    reach: float,
) -> AxesRow:
    """Draw the landmark errors of many runs and the gains, on two axes that are cleared first.

    Parameters
    ----------
    axes : sequence of Axes
        Two.
    errors : ndarray, shape (runs, looks)
        Estimate minus truth, m.
    deviations : ndarray, shape (looks,)
        Stated deviation, m.
    gains : ndarray, shape (steps, 2)
        Gains of vehicle and landmark on the landmark's innovation.
    reach : float
        Half the height of the error axis, m: the same for all settings, so that they compare.
    """
    for ax in axes:
        ax.clear()
    error_fan(axes[0], errors, deviations)
    gains_of(axes[1], *gains.T)
    axes[0].set_ylim(-reach, reach)
    axes[1].set_ylim(-0.5, 1.0)
    for ax in axes:
        ax.locator_params(nbins=5)
    return axes
