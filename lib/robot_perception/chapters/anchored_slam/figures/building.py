"""Drawings of the loop: maps of the building, errors, consistency, and the states of explorers."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from robot_perception.chapters.walls.figures import dots, lines, plan
from robot_perception.teaching.figures.style import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    MUTED,
    ORANGE,
    PURPLE,
    RED,
    TEAL,
    band,
    ellipses,
    label,
)

AxesRow = Sequence[Axes] | np.ndarray

TINTS = {
    "plain": RED,
    "anchored": ORANGE,
    "external": GREEN,
    "first estimates": BLUE,
    "anchored, first estimates": TEAL,
    "true Jacobians": PURPLE,
}
"""The colour of each filter; the same in all pictures."""


def tint(variant: str) -> str:
    """Return the colour of a filter; variants of the rule share the ink's."""
    return TINTS.get(variant, INK)


def map_of(
    ax: Axes,
    faces: np.ndarray,
    truth: np.ndarray,
    readings: np.ndarray,
    path: np.ndarray,
    title: str,
    *,
    anchor: np.ndarray | None = None,
) -> Axes:
    """Draw the readings where the filter believed the robot to be, over the true plan.

    Parameters
    ----------
    ax
        Where to draw.
    faces : ndarray, shape (faces, 2, 2)
        The true plan, m.
    truth, path : ndarray, shape (steps, 3)
        True and estimated path.
    readings : ndarray, shape (points, 2)
        Readings in the world of the filter, m.
    title
        What the filter is.
    anchor : ndarray, shape (2,), optional
        The known landmark, m.
    """
    lines(ax, faces, FAINT, 3.0, zorder=0)
    dots(ax, readings, BLUE, 1.1)
    ax.plot(*truth[:, :2].T, color=MUTED, linewidth=1.0, linestyle="--")
    ax.plot(*path[:, :2].T, color=ORANGE, linewidth=1.6)
    ends = np.stack([truth[-1, :2], path[-1, :2]])
    ax.plot(*ends.T, color=RED, linewidth=2.2)
    ax.plot(*path[-1, :2], "o", color=RED, markersize=5)
    if anchor is not None:
        ax.plot(*anchor, "P", color=INK, markersize=9)
    off = np.hypot(*(ends[1] - ends[0]))
    ax.set_title(f"{title}: {off:.2f} m off at the end")
    plan(ax, np.vstack([faces.reshape(-1, 2), readings]))
    ax.locator_params(nbins=5)
    return ax


def two_maps(axes: AxesRow, maps: Any) -> AxesRow:
    """Draw Fig. 7 again: one panel for each filter of `Maps`."""
    for ax, (name, path) in zip(axes, maps.paths.items(), strict=True):
        anchor = maps.anchor if name.startswith("anchored") else None
        map_of(ax, maps.faces, maps.poses, maps.readings[name], path, name, anchor=anchor)
    return axes


def nees_along(
    ax: Axes, along: np.ndarray, nees: Mapping[str, np.ndarray], low: float, high: float
) -> Axes:
    """Draw the average NEES of the pose along the way, one line for each filter.

    Parameters
    ----------
    ax
        Where to draw.
    along : ndarray, shape (k,)
        Distance driven, m.
    nees : mapping of str to ndarray, shape (k,)
        Averages over runs, by filter.
    low, high
        95 % band of χ² of such an average.
    """
    # logarithms on a plain axis: a logarithmic one takes twice as long to draw
    ends = np.log10([low, high])
    band(ax, along[[0, -1]], ends[[0, 0]], ends[[1, 1]], MUTED)
    for name, values in nees.items():
        ax.plot(along, np.log10(values), color=tint(name))
    top = max(max(v.max() for v in nees.values()), 2 * high)
    ticks = [t for t in (1, 3, 10, 30, 100, 300, 1000, 3000) if t < 1.4 * top]
    ax.set(xlim=(0, along[-1]), ylim=(np.log10(0.5), np.log10(1.4 * top)))
    ax.set(xlabel="way (m)", ylabel="average NEES")
    ax.set_yticks(np.log10(ticks), [str(t) for t in ticks])
    ax.locator_params(axis="x", nbins=4)
    _names(ax, {name: np.log10(values[-1]) for name, values in nees.items()})
    return ax


def errors_along(ax: Axes, along: np.ndarray, error: Mapping[str, np.ndarray]) -> Axes:
    """Draw the error of the position along the way, one line for each filter.

    Parameters
    ----------
    ax
        Where to draw.
    along : ndarray, shape (k,)
        Distance driven, m.
    error : mapping of str to ndarray, shape (k,)
        Root mean square over runs, m.
    """
    for name, values in error.items():
        ax.plot(along, values, color=tint(name))
    top = 1.1 * max(values.max() for values in error.values())
    ax.set(xlim=(0, along[-1]), ylim=(0, top), xlabel="way (m)", ylabel="position error (m)")
    ax.locator_params(nbins=4)
    return ax


def _names(ax: Axes, ends: Mapping[str, float]) -> None:
    """Write each name at the right end of its line, apart from the next."""
    low, high = ax.get_ylim()
    place = low
    for name, value in sorted(ends.items(), key=lambda item: item[1]):
        place = max(value, place + 0.085 * (high - low))
        label(ax, 1.02 * ax.get_xlim()[1], place, name, tint(name), fontsize=9)


def growth(axes: AxesRow, curves: Any) -> AxesRow:
    """Draw a state of the explorer of noise and loop length on two axes, cleared first."""
    for ax in axes:
        ax.clear()
    errors_along(axes[0], curves.along, curves.error)
    nees_along(axes[1], curves.along, curves.nees, curves.low, curves.high)
    return axes


def end_errors(
    axes: AxesRow, studies: Mapping[str, Mapping[str, tuple[float, float, float]]]
) -> AxesRow:
    """Draw the errors at the loop end as dots with intervals, a panel for each level of noise.

    Parameters
    ----------
    axes
        One for each level of noise, one above the other.
    studies : mapping of str to mapping of str to (estimate, low, high)
        By noise and by filter, m.
    """
    values = np.array([row for rows in studies.values() for row in rows.values()])
    low, high = 0.7 * values.min(), 1.4 * values.max()
    ticks = [t for t in (0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10) if low <= t <= high]
    for ax, (noise, rows) in zip(axes, studies.items(), strict=True):
        for k, (name, (mean, least, most)) in enumerate(rows.items()):
            ax.plot([least, most], [k, k], color=tint(name), linewidth=2.4)
            ax.plot(mean, k, "o", color=tint(name), markersize=7)
        ax.set_yticks(range(len(rows)), list(rows))
        ax.set_xscale("log")
        ax.set(xlim=(low, high), ylim=(len(rows) - 0.5, -0.5))
        ax.set_xticks(ticks, [f"{t:g}" for t in ticks])
        ax.minorticks_off()
        ax.set_title(f"{noise} noise of the wheels")
    axes[-1].set_xlabel("error at the loop end (m)")
    return axes


def nailed(axes: AxesRow, state: Any) -> AxesRow:
    """Draw a state of the explorer of anchors: map with ellipses, and errors along the way."""
    for ax in axes:
        ax.clear()
    here, there = axes
    here.plot(*state.poses[:, :2].T, color=MUTED, linewidth=1.0, linestyle="--")
    here.plot(*state.posts.T, "o", color=MUTED, markersize=3)
    ellipses(here, state.places, state.covs, BLUE)
    if len(state.anchors):
        here.plot(*state.anchors.T, "P", color=ORANGE, markersize=10)
    plan(here, state.posts, margin=3.0)
    here.locator_params(nbins=4)
    there.plot(state.along, state.error, color=BLUE)
    there.plot(state.along, state.heading / 10, color=PURPLE)
    top = 1.8
    there.set(xlim=(0, state.along[-1]), ylim=(0, top), xlabel="way (m)", ylabel="error")
    there.locator_params(nbins=4)
    label(there, 0.02 * state.along[-1], 0.93 * top, "position (m)", BLUE)
    label(there, 0.02 * state.along[-1], 0.83 * top, "heading (10°)", PURPLE)
    return axes


def moment(ax: Axes, state: Any, variant: str) -> Axes:
    """Draw what a filter believes at one moment, with 2σ ellipses, on axes cleared first."""
    ax.clear()
    ax.plot(*state.posts.T, "o", color=MUTED, markersize=3)
    ax.plot(*state.truth[:, :2].T, color=MUTED, linewidth=1.0, linestyle="--")
    ax.plot(*state.path[:, :2].T, color=tint(variant), linewidth=1.6)
    ellipses(ax, state.landmarks, state.covs, BLUE, width=1.1)
    ellipses(ax, state.path[-1:, :2], state.pose_cov[None], tint(variant), width=2.2)
    heading = np.degrees(state.path[-1, 2]) - 90
    ax.plot(*state.path[-1, :2], marker=(3, 0, heading), color=tint(variant), markersize=9)
    off = np.hypot(*(state.path[-1, :2] - state.truth[-1, :2]))
    ax.set_title(f"{variant}: {state.along:.0f} m driven, {off:.2f} m off")
    ax.set(xlim=(-11, 30), ylim=(-7, 22), xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal", adjustable="box")
    ax.locator_params(nbins=5)
    return ax
