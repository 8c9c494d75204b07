"""Drawings of the real recordings: five robots, a park, a building."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import ScalarFormatter

from robot_perception.chapters.anchored_slam.intel import Building
from robot_perception.chapters.anchored_slam.mrclam import Robots
from robot_perception.chapters.anchored_slam.victoria import Park
from robot_perception.gating import chi_squared_quantile
from robot_perception.teaching.figures.maps import dots
from robot_perception.teaching.figures.style import MEANING, band, ellipses, label

ANCHOR_COLOURS = tuple(MEANING[name] for name in ("plain", "anchored", "two anchors"))
ANCHOR_WORDS = ("no anchor", "one anchor", "two anchors")
REACH = float(np.sqrt(chi_squared_quantile(0.95, 2)))
"""Of an ellipse that holds a point of the plane with 95 %, in deviations."""


def robot_path(ax: Axes, found: Robots, robot: int, anchors: int) -> Axes:
    """Draw path and map of one robot with 0 to 2 anchors beside motion capture, on clear axes."""
    ax.clear()
    ax.grid(visible=False)
    one, truth, wheels = found.robots[robot], MEANING["truth"], MEANING["odometry"]
    path, post, anchor = MEANING["robot"], MEANING["landmark"], MEANING["anchor"]
    ax.plot(*one.dead.T, ":", color=wheels, linewidth=1.2)
    ax.plot(*one.truth.T, color=truth, linewidth=4.5, alpha=0.2)
    ax.plot(*one.paths[anchors].T, color=path, linewidth=1.4)
    marks, covs = one.marks[anchors], one.mark_covs[anchors]
    seen = np.isfinite(marks).all(axis=1)
    ellipses(ax, marks[seen], covs[seen], post, deviations=REACH)
    ax.plot(*found.landmarks.T, "+", color=truth, markersize=8, markeredgewidth=1.6)
    ax.plot(*one.anchors[:anchors].T, "s", color=anchor, markersize=9)
    error = found.errors["lasting"].ate[list(found.robots).index(robot), anchors]
    ax.set_title(f"robot {robot}, {ANCHOR_WORDS[anchors]}: {error:.2f} m")
    words = (("broad: motion capture", truth), ("dotted: wheels alone", wheels))
    words += (("path by the filter", path), ("landmarks, 95 %", post))
    words += (("+ surveyed", truth), ("■ anchor", anchor))[: 2 if anchors else 1]
    for i, (text, tint) in enumerate(words):
        label(ax, 0.02, 0.97 - 0.045 * i, text, tint, transform=ax.transAxes, fontsize=9)
    ax.set(xlim=(-2.6, 7.6), ylim=(-6.6, 7.9), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.locator_params(nbins=6)
    return ax


def error_bands(upper: Axes, lower: Axes, found: Robots, robot: int, anchors: int) -> None:
    """Draw errors of position and heading of one robot beside two deviations of the filter."""
    one, colour = found.robots[robot], MEANING["robot"]
    minutes, units = one.times / 60, np.array([1, np.rad2deg(1.0)])
    errors, reach = (units * one.errors[anchors]).T, (2 * units * one.sigmas[anchors]).T
    for ax, error, sigma, lowest in zip((upper, lower), errors, reach, (0, -1), strict=True):
        ax.clear()
        ax.set_xlim(0, minutes[-1])
        band(ax, minutes, lowest * sigma, sigma, colour)
        ax.plot(minutes, error, color=colour, linewidth=1.3)
    upper.set(ylim=(0, 1.6), ylabel="position error (m)")
    upper.set_title(f"robot {robot}, {ANCHOR_WORDS[anchors]}; band: 2σ of the filter")
    lower.axhline(0, color=MEANING["expected"], linewidth=0.8)
    lower.set(ylim=(-40, 40), ylabel="heading error (°)", xlabel="time (min)")


def nees_over_time(ax: Axes, found: Robots, robot: int) -> Axes:
    """Draw the normalised error squared of one robot's pose, for no, one and two anchors."""
    one = found.robots[robot]
    minutes, limit = one.times / 60, chi_squared_quantile(0.95, 3)
    band(ax, minutes, 0.05 + 0 * minutes, limit + 0 * minutes, MEANING["expected"])
    for anchors, colour in enumerate(ANCHOR_COLOURS):
        ax.semilogy(minutes, np.maximum(one.nees[anchors], 0.05), color=colour, linewidth=1.3)
        place = 0.94 - 0.08 * anchors
        label(ax, 0.99, place, ANCHOR_WORDS[anchors], colour, transform=ax.transAxes, ha="right")
    label(ax, 0.3, 0.09, "95 % of a consistent filter", MEANING["expected"], fontsize=9)
    ax.set(xlim=(0, minutes[-1]), ylim=(0.05, 400), xlabel="time (min)", ylabel="NEES of the pose")
    ax.yaxis.set_major_formatter(ScalarFormatter())
    ax.set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    ax.minorticks_off()
    return ax


def park_map(ax: Axes, found: Park) -> Axes:
    """Draw the drive through the park: satellite fixes, and the filter with two linearisations."""
    tints, truth = (MEANING["plain"], MEANING["first estimates"]), MEANING["truth"]
    for i, ((name, run), colour) in enumerate(zip(found.runs.items(), tints, strict=True)):
        ax.plot(*run.path.T, color=colour, linewidth=1.1)
        ellipses(ax, run.trees, run.tree_covs, colour, deviations=REACH)
        label(ax, 0.98, 0.085 - 0.05 * i, f"Jacobians at the {name} estimates", colour, fontsize=9,
              transform=ax.transAxes, ha="right")  # fmt: skip
    dots(ax, found.fixes, truth, 1.8)
    best = MEANING["ideal"]
    ax.plot(*found.batch.trees.T, "+", color=best, markersize=5)
    label(ax, 0.02, 0.86, "+ trees of the optimum", best, fontsize=9, transform=ax.transAxes)
    label(ax, 0.02, 0.96, "dots: satellite fixes", truth, fontsize=9, transform=ax.transAxes)
    label(ax, 0.02, 0.91, "ellipses: trees, 95 %", truth, fontsize=9, transform=ax.transAxes)
    low, high = found.fixes.min(axis=0), found.fixes.max(axis=0)
    ax.set(xlim=(low[0] - 60, high[0] + 30), ylim=(low[1] - 60, high[1] + 100))
    ax.set(xlabel="east (m)", ylabel="north (m)", aspect="equal")
    return ax


def step_times(ax: Axes, found: Park) -> Axes:
    """Draw the time a step took against the number of landmarks in the map."""
    tints = MEANING["landmark"], MEANING["odometry"]
    for values, words, colour in zip(
        found.microseconds, ("trees in sight", "none in sight"), tints, strict=True
    ):
        ax.plot(found.sizes, values, "o-", color=colour, markersize=5)
        label(ax, found.sizes[0], values[0] + 5, words, colour, ha="left")
    ax.set(xlabel="landmarks in the map", ylabel="time of a step (µs)")
    ax.set(xlim=(0, 160), ylim=(0, 1.15 * found.microseconds.max()))
    return ax


def building_paths(ax: Axes, found: Building) -> Axes:
    """Draw the way through the building: corrected, by wheels, by the filter, blind and told."""
    dots(ax, found.spots, MEANING["landmark"], 3.0, alpha=0.3)
    drawn = (
        ("corrected", "corrected poses", "truth", 2.4),
        ("calibrated", "wheels, calibrated", "odometry", 0.9),
        ("blind", "filter, blind", "names unknown", 0.9),
        ("told", "filter, told", "names known", 1.1),
    )
    for i, (name, words, meaning, width) in enumerate(drawn):
        colour = MEANING[meaning]
        ax.plot(*found.ways[name].T, color=colour, linewidth=width, alpha=0.9)
        x, y = 0.02 + 0.55 * (i // 2), 0.97 - 0.05 * (i % 2)
        label(ax, x, y, words, colour, transform=ax.transAxes, fontsize=9)
    every = np.concatenate(list(found.ways.values()))
    (left, low), (right, high) = every.min(axis=0) - 2, every.max(axis=0) + 2
    ax.set(xlim=(left, right), ylim=(low, high + 6), xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal")
    return ax


def loop_errors(ax: Axes, found: Building) -> Axes:
    """Draw the error across loops: of wheels with intervals, and of every choice of the filter."""
    groups = {
        "odometry": ("wheels, raw", "odometry"),
        "calibrated": ("calibrated", "odometry"),
        "blind": ("filter, blind", "names unknown"),
        "told": ("filter, told", "names known"),
        "corrected": ("corrected", "truth"),
    }
    for place, (name, (_, meaning)) in enumerate(groups.items()):
        colour = MEANING[meaning]
        values = found.errors[name][:, 1, 0]
        spread = np.linspace(-0.25, 0.25, len(values)) if len(values) > 1 else 0.0
        ax.semilogy(place + spread, values, "o", color=colour, markersize=6)
        if name in found.ends:
            ax.semilogy([place, place], found.ends[name][:, 1, 0], color=colour, linewidth=2)
    ax.set_xticks(range(len(groups)), [words.replace(", ", "\n") for words, _ in groups.values()])
    ax.set(xlim=(-0.5, len(groups) - 0.5), ylim=(0.02, 40), ylabel="error across a loop (m)")
    ax.set_yticks([0.05, 0.2, 1, 5, 20], ["0.05", "0.2", "1", "5", "20"])
    ax.minorticks_off()
    return ax
