"""Drawings of the real recordings: five robots, a park, a building.

Each takes the result of a `Recording` as it is computed or stored.
"""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import ScalarFormatter
from scipy import stats

from robot_perception.teaching.figures.maps import dots
from robot_perception.teaching.figures.style import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    MUTED,
    ORANGE,
    RED,
    band,
    ellipses,
    label,
)

Found = Mapping[str, np.ndarray | float]

ANCHOR_COLOURS = (RED, ORANGE, GREEN)
ANCHOR_WORDS = ("no anchor", "one anchor", "two anchors")
REACH = float(np.sqrt(stats.chi2.ppf(0.95, 2)))
"""Of an ellipse that holds a point of the plane with 95 %, in deviations."""


def robot_path(ax: Axes, found: Found, robot: int, anchors: int) -> Axes:
    """Draw path and map of one robot beside motion capture, on axes cleared first.

    Parameters
    ----------
    ax
        Where to draw.
    found
        Result of the study of five robots.
    robot
        Its number.
    anchors
        How many: 0, 1 or 2.
    """
    ax.clear()
    ax.grid(visible=False)
    row, colour = int(robot) - 1, ANCHOR_COLOURS[anchors]
    true, marks = found["truth"][row], found["marks"][row, anchors]
    ax.plot(*found["dead_path"][row].T, ":", color=MUTED, linewidth=1.2)
    ax.plot(*true.T, color=FAINT, linewidth=4.5)
    ax.plot(*found["paths"][row, anchors].T, color=colour, linewidth=1.4)
    ellipses(ax, marks, found["mark_covs"][row, anchors] / 1e4, colour, deviations=REACH)
    ax.plot(*found["landmarks"].T, "+", color=INK, markersize=8, markeredgewidth=1.6)
    known = found["landmarks"][found["anchors"][row][:anchors] - 6]  # subjects count from 6
    ax.plot(*known.T, "s", color=INK, markersize=9)
    way = 1  # errors that last
    ax.set_title(
        f"robot {int(robot)}, {ANCHOR_WORDS[anchors]}: {found['ate'][row, way, anchors]:.2f} m"
    )
    words = (("thick grey: motion capture", MUTED), ("dotted: wheels alone", MUTED))
    words += (("filter, 95 % ellipses", colour), ("+ surveyed, ■ anchor", INK))
    for i, (text, tint) in enumerate(words):
        label(ax, 0.02, 0.97 - 0.045 * i, text, tint, transform=ax.transAxes, fontsize=9)
    ax.set(xlim=(-2.6, 7.6), ylim=(-6.6, 7.9), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.locator_params(nbins=6)
    return ax


def error_bands(upper: Axes, lower: Axes, found: Found, robot: int, anchors: int) -> None:
    """Draw errors of position and heading of one robot beside two deviations of the filter."""
    row, colour = int(robot) - 1, ANCHOR_COLOURS[anchors]
    minutes = found["times"][row] / 60
    errors, sigmas = found["errors"][row, anchors].T, found["sigmas"][row, anchors].T
    degrees = np.rad2deg(1.0)
    for ax in (upper, lower):
        ax.clear()
        ax.set_xlim(0, minutes[-1])
    band(upper, minutes, 0 * minutes, 2 * sigmas[0], colour)
    upper.plot(minutes, errors[0], color=colour, linewidth=1.3)
    upper.set(ylim=(0, 1.6), ylabel="position error (m)")
    upper.set_title(f"robot {int(robot)}, {ANCHOR_WORDS[anchors]}; band: 2σ of the filter")
    band(lower, minutes, -2 * degrees * sigmas[1], 2 * degrees * sigmas[1], colour)
    lower.plot(minutes, degrees * errors[1], color=colour, linewidth=1.3)
    lower.axhline(0, color=INK, linewidth=0.8)
    lower.set(ylim=(-40, 40), ylabel="heading error (°)", xlabel="time (min)")


def nees_over_time(ax: Axes, found: Found, robot: int) -> Axes:
    """Draw the normalised error squared of one robot's pose, for no, one and two anchors."""
    row = int(robot) - 1
    minutes, limit = found["times"][row] / 60, stats.chi2.ppf(0.95, 3)
    band(ax, minutes, 0.05 + 0 * minutes, limit + 0 * minutes, MUTED)
    for anchors, colour in enumerate(ANCHOR_COLOURS):
        values = np.maximum(found["nees"][row, anchors], 0.05)
        ax.semilogy(minutes, values, color=colour, linewidth=1.3)
        place = 0.94 - 0.08 * anchors
        label(ax, 0.99, place, ANCHOR_WORDS[anchors], colour, transform=ax.transAxes, ha="right")
    label(ax, 0.3, 0.09, "95 % of a consistent filter", MUTED, fontsize=9)
    ax.set(xlim=(0, minutes[-1]), ylim=(0.05, 400), xlabel="time (min)", ylabel="NEES of the pose")
    ax.yaxis.set_major_formatter(ScalarFormatter())
    ax.set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    ax.minorticks_off()
    return ax


def park_map(ax: Axes, found: Found) -> Axes:
    """Draw the drive through the park: satellite fixes, and the filter with two linearisations."""
    for i, (words, colour) in enumerate((("latest estimates", RED), ("first estimates", BLUE))):
        ax.plot(*found["paths"][i].T, color=colour, linewidth=1.1)
        ellipses(ax, found["trees"][i], found["tree_covs"][i], colour, deviations=REACH)
        label(ax, 0.98, 0.085 - 0.05 * i, f"slopes at the {words}", colour, fontsize=9,
              transform=ax.transAxes, ha="right")  # fmt: skip
    dots(ax, found["fixes"], INK, 1.8)
    label(ax, 0.02, 0.96, "dots: satellite fixes", INK, fontsize=9, transform=ax.transAxes)
    label(ax, 0.02, 0.91, "ellipses: trees, 95 %", INK, fontsize=9, transform=ax.transAxes)
    low, high = found["fixes"].min(axis=0), found["fixes"].max(axis=0)
    ax.set(xlim=(low[0] - 60, high[0] + 30), ylim=(low[1] - 45, high[1] + 70))
    ax.set(xlabel="east (m)", ylabel="north (m)", aspect="equal")
    return ax


def step_times(ax: Axes, found: Found) -> Axes:
    """Draw the time a step took against the number of landmarks in the map."""
    for values, words, colour in zip(
        found["microseconds"], ("trees in sight", "none in sight"), (BLUE, MUTED), strict=True
    ):
        ax.plot(found["sizes"], values, "o-", color=colour, markersize=5)
        label(ax, found["sizes"][0], values[0] + 5, words, colour, ha="left")
    ax.set(xlabel="landmarks in the map", ylabel="time of a step (µs)")
    ax.set(xlim=(0, 160), ylim=(0, 1.15 * found["microseconds"].max()))
    return ax


def building_paths(ax: Axes, found: Found) -> Axes:
    """Draw the way through the building: corrected, by wheels, by the filter, blind and told."""
    dots(ax, found["spots"], FAINT, 3.0)
    ways = (
        ("way", "corrected poses", INK, 2.4),
        ("dead", "wheels, calibrated", MUTED, 0.9),
        ("blind_way", "filter, blind", RED, 0.9),
        ("told_way", "filter, told", GREEN, 1.1),
    )
    for i, (name, words, colour, width) in enumerate(ways):
        ax.plot(*found[name].T, color=colour, linewidth=width, alpha=0.9)
        x, y = 0.02 + 0.55 * (i // 2), 0.97 - 0.05 * (i % 2)
        label(ax, x, y, words, colour, transform=ax.transAxes, fontsize=9)
    every = np.concatenate([found[name] for name, *_ in ways])
    (left, low), (right, high) = every.min(axis=0) - 2, every.max(axis=0) + 2
    ax.set(xlim=(left, right), ylim=(low, high + 6), xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal")
    return ax


def loop_errors(ax: Axes, found: Found) -> Axes:
    """Draw the error across loops: of wheels with intervals, and of every choice of the filter."""
    groups = (
        ("wheels, raw", "odometry", MUTED),
        ("calibrated", "calibrated", MUTED),
        ("filter, blind", "blind", RED),
        ("filter, told", "told", GREEN),
        ("corrected", "corrected", INK),
    )
    for place, (_, name, colour) in enumerate(groups):
        values = np.atleast_1d(found[name][..., 1, 0])
        spread = 0.5 * (np.arange(len(values)) / max(len(values) - 1, 1) - 0.5)
        spread = spread if len(values) > 1 else np.zeros(1)
        ax.semilogy(place + spread, values, "o", color=colour, markersize=6)
        if f"{name}_low" in found:
            ends = found[f"{name}_low"][1, 0], found[f"{name}_high"][1, 0]
            ax.semilogy([place, place], ends, color=colour, linewidth=2)
    ax.set_xticks(range(len(groups)), [words.replace(", ", "\n") for words, *_ in groups])
    ax.set(xlim=(-0.5, len(groups) - 0.5), ylim=(0.02, 40), ylabel="error across a loop (m)")
    ax.set_yticks([0.05, 0.2, 1, 5, 20], ["0.05", "0.2", "1", "5", "20"])
    ax.minorticks_off()
    return ax
