"""Drawings of the chapter: the rail, moved worlds, invented information, the real recordings."""

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import ScalarFormatter

from explorables.figures import drawn
from explorables.figures.maps import dots
from explorables.figures.style import MEANING, AxesRow, band, ellipses, label
from robot_perception.chapters.monobot import figures
from robot_perception.chapters.monobot.figures import MEASUREMENTS, Runs
from robot_perception.gating import chi_squared_quantile
from robot_perception.geometry import act


def _note(ax: Axes, x: float, y: float, text: str, colour: str, **style: float | str) -> None:
    """Write a label at a place in the axes rather than in the data."""
    label(ax, x, y, text, colour, transform=ax.transAxes, **{"fontsize": 9, **style})


# The rail ----------------------------------------------------------------------------------------

ROWS = ("position (m)", "vehicle error (m)", "landmark error (m)", "gain")


@drawn(
    name="three-references",
    alt="Three columns, four rows. Without a reference the landmark error freezes at a "
    "tenth of a metre inside a wide constant band; with an anchor or a camera band and "
    "error shrink to zero.",
    caption="The paper's Figs 4, 5 and 6 rebuilt: the same world, the same first measurement. "
    "Bands: ±2σ as the filter states them. Uncoloured: truth; blue: every third measurement "
    "alone. With a reference the wide bands are gone. The landmark's gain falls to zero all the "
    "same.",
    rows=4,
    cols=3,
    width=8.0,
    height=7.2,
    gridspec_kw={"hspace": 0.16},
)
def side_by_side(axes: np.ndarray, results: Mapping[str, Runs], run: int) -> np.ndarray:
    """Draw one run of studies by title, a column each, all bands ±2σ, on common scales."""
    for column, (name, result) in zip(axes.T, results.items(), strict=True):
        figures.one_run(column[[0, 2, 1, 3]], result, run)
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


@drawn(
    name="first-error-left",
    alt="Share of the variance left against measurements, both logarithmic: level at two thirds "
    "without a reference, falling to a hundredth and below with a camera or an anchor, "
    "roughly like one over the number of measurements.",
    caption="Share of the first error's variance that is left after k measurements, in the worlds "
    "of the paper's Figs 4 to 6. Dashed: 1/k. The anchor's curve is steepest around measurement "
    "20, where the robot passes close to the anchor and so measures it best.",
    height=3.2,
    gridspec_kw={"right": 0.79},
)
def remaining(ax: Axes, shares: Mapping[str, np.ndarray]) -> Axes:
    """Draw the shares by reference, from the first measurement on, on log scales."""
    meanings = ("plain", "anchored", "external")
    for (name, share), meaning in zip(shares.items(), meanings, strict=True):
        k = np.arange(1, len(share))
        ax.loglog(k, share[1:], color=MEANING[meaning])
        label(ax, 1.1 * k[-1], share[-1], name, MEANING[meaning], va="center", fontsize=9)
    law = MEANING["expected"]
    ax.loglog(k, 1 / k, color=law, linestyle="--", linewidth=1.2)
    label(ax, 12, 0.11, "1/k", law, fontweight=400)
    ax.set(xlim=(1, 1.1 * k[-1]), ylim=(None, 1.5))
    ax.set(xlabel=MEASUREMENTS, ylabel="share of the variance")
    ax.minorticks_off()
    return ax


def fan_and_gains(axes: AxesRow, result: Runs) -> AxesRow:
    """Draw landmark errors of many runs and the gains, cleared first, on scales that compare."""
    for ax in axes:
        ax.clear()
    figures.error_fan.on(axes[0], result)
    figures.gains(axes[1], result)
    for ax, limits in zip(axes, ((-0.5, 0.5), (-0.5, 1.0)), strict=True):
        ax.set_ylim(*limits)
        ax.locator_params(nbins=5)
    return axes


# The plane ---------------------------------------------------------------------------------------

_ROBOT = np.array([[0.35, 0.0], [-0.2, 0.2], [-0.2, -0.2], [0.35, 0.0]])


def moved_world(ax: Axes, world: SimpleNamespace) -> Axes:
    """Draw a world before (grey) and after (blue) it was moved, on axes cleared first.

    A measurement that no longer fits is a magenta line: from where it asks a known thing to be, to
    where that is.
    """
    ax.clear()
    ax.grid(visible=False)
    known = np.broadcast_to(world.anchors, world.misses.shape)
    old, new, error = MEANING["world"], MEANING["moved world"], MEANING["error"]
    both = (
        (world.poses, world.landmarks, known, old, 0.35),
        (world.moved_poses, world.moved_landmarks, world.misses, new, 1.0),
    )
    for poses, landmarks, seen, colour, alpha in both:
        points = np.concatenate([np.tile(landmarks, (len(poses), 1, 1)), seen], axis=1)
        ends = np.broadcast_to(poses[:, None, :2], points.shape)
        rays = _strokes(ends.reshape(-1, 2), points.reshape(-1, 2))
        ax.plot(*rays, color=colour, lw=0.6, alpha=alpha)
    for poses, landmarks, _, colour, _ in both:
        outline = act(poses, np.tile(_ROBOT, (len(poses), 1, 1)))
        outline = np.concatenate([outline, np.full((len(poses), 1, 2), np.nan)], axis=1)
        ax.plot(*outline.reshape(-1, 2).T, color=colour, lw=1.6)
        ax.plot(*landmarks.T, "o", color=colour, markersize=6)
    gaps = [world.misses.reshape(-1, 2), world.moved_poses[: len(world.fixes), :2]]
    places = [known.reshape(-1, 2), world.fixes]
    ax.plot(*_strokes(np.vstack(gaps), np.vstack(places)), color=error, lw=2.0)
    anchor, sensor = MEANING["anchor"], MEANING["position sensor"]
    ax.plot(*world.anchors.T, "s", color=anchor, markersize=9)
    ax.plot(*world.fixes.T, "+", color=sensor, markersize=10, markeredgewidth=2)
    heading = f", heading {np.degrees(world.radians):.0f}°" if world.radians > 1e-9 else ""
    colour = MEANING["agreement"] if world.residual < 1e-9 else error
    _note(ax, 0.02, 0.96, f"largest residual {world.metres:.2f} m{heading}", colour, fontsize=11)
    legend = [("● the world", old), ("● moved", new)]
    legend += [("■ anchor", anchor)] if len(world.anchors) else []
    legend += [("+ position sensor", sensor)] if len(world.fixes) else []
    for i, (text, colour) in enumerate(legend):
        label(ax, 0.98, 0.05 + 0.06 * i, text, colour, transform=ax.transAxes, ha="right")
    ax.set(xlim=(-2.6, 8.1), ylim=(-3.7, 6.4), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.locator_params(nbins=5)
    return ax


def _strokes(starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return the coordinates (2, 3n) of separate strokes as one path."""
    return np.stack([starts, ends, np.full(starts.shape, np.nan)], axis=1).reshape(-1, 2).T


@drawn(
    name="claimed-information",
    alt="Information about the turn relative to the start, logarithmic: the plain "
    "filter's rises to more than ten times within two rounds, the other two stay at "
    "one.",
    caption=lambda gains: (
        "What each filter claims to know about the turn of the world about the anchor, over "
        f"what it knew at the start; {len(gains['ideal'])} runs, median and "
        "central 80 %. Who told it?"
    ),
)
def claimed_information(ax: Axes, gains: Mapping[str, np.ndarray]) -> Axes:
    """Draw the information that the three filters claim: medians, and the central 80 %.

    It is by filter, runs × beliefs, over that of the start.
    """
    ax.axhline(1, color=MEANING["expected"], linewidth=0.8)
    top = max(np.quantile(values, 0.9, axis=0).max() for values in gains.values())
    styles = zip(("-", "-", "--"), (1.6 * top, 0.55, 1.6), strict=True)
    for (name, values), (line, place) in zip(gains.items(), styles, strict=True):
        colour = MEANING[name]
        k = np.arange(values.shape[1])
        low, middle, high = np.quantile(values, [0.1, 0.5, 0.9], axis=0)
        band(ax, k, low, high, colour)
        ax.semilogy(k, middle, color=colour, linestyle=line)
        label(ax, 0.97 * k[-1], place, name, colour, ha="right")
    ax.minorticks_off()
    ax.set(xlim=(0, k[-1]), xlabel="steps", ylabel="information, over the start's")
    ax.set_ylim(0.3, 3 * top)
    return ax


@drawn(
    name="honest-heading",
    alt="Three panels: the plain filter's stated deviation falls to a quarter of the "
    "error it makes; those of first estimates and of the ideal filter stay above it.",
    caption="Heading: what each filter states (coloured, 1σ) and the error it makes (magenta, "
    "root mean square over the runs). Two of them know that they do not know: their Jacobians "
    "belong together.",
    cols=3,
    width=7.4,
    height=3.0,
    gridspec_kw={"wspace": 0.3},
)
def heading_honesty(axes: AxesRow, curves: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> AxesRow:
    """Draw for each filter the heading's stated deviation and the error made, °, by step."""
    top = 1.25 * max(each.max() for both in curves.values() for each in both)
    made = MEANING["error"]
    for ax, (name, (stated, errors)) in zip(axes, curves.items(), strict=True):
        colour, k = MEANING[name], np.arange(1, stated.size + 1)
        band(ax, k, np.zeros(k.size), stated, colour)
        ax.plot(k, stated, color=colour)
        ax.plot(k, errors, color=made)
        ax.set(xlim=(0, k[-1]), ylim=(0, top), xlabel="steps", title=name)
        ax.locator_params(nbins=4)
        ax.set_ylabel("heading, 1σ (°)")
        label(ax, 0.95, 0.9, "error made", made, ha="right", transform=ax.transAxes)
        label(ax, 0.95, 0.08, "stated", colour, ha="right", transform=ax.transAxes)
    return axes


# Five robots -------------------------------------------------------------------------------------

ANCHORS = ("no anchor", "one anchor", "two anchors")
"""Names of runs by how many landmarks their filter knows."""
REACH = float(np.sqrt(chi_squared_quantile(0.95, 2)))
"""Radius of an ellipse that holds a point of the plane with 95 %, in deviations."""


def robot_path(ax: Axes, found: Any, robot: int, anchors: int) -> Axes:
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
    ax.set_title(f"robot {robot}, {ANCHORS[anchors]}: {error:.2f} m")
    words = (("broad: motion capture", truth), ("dotted: wheels alone", wheels))
    words += (("path by the filter", path), ("landmarks, 95 %", post))
    words += (("+ surveyed", truth), ("■ anchor", anchor))[: 2 if anchors else 1]
    for i, (text, tint) in enumerate(words):
        _note(ax, 0.02, 0.97 - 0.045 * i, text, tint)
    ax.set(xlim=(-2.6, 7.6), ylim=(-6.6, 7.9), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.locator_params(nbins=6)
    return ax


@drawn(
    name="robot-2-errors",
    alt="Position and heading error of robot 2 with one anchor: the heading error grows to "
    "one side and leaves the band of two standard deviations within minutes.",
    caption="Robot 2 with one anchor: errors against motion capture, bands 2σ as the filter states "
    "them. The heading leaves its band first and takes the position with it.",
    rows=2,
    height=5.0,
)
def error_bands(axes: AxesRow, found: Any, robot: int, anchors: int) -> AxesRow:
    """Draw errors of position and heading of one robot beside two deviations of the filter."""
    one, colour = found.robots[robot], MEANING["robot"]
    minutes, units = one.times / 60, np.array([1, np.rad2deg(1.0)])
    errors, reach = (units * one.errors[anchors]).T, (2 * units * one.sigmas[anchors]).T
    for ax, error, sigma, lowest in zip(axes, errors, reach, (0, -1), strict=True):
        ax.set_xlim(0, minutes[-1])
        band(ax, minutes, lowest * sigma, sigma, colour)
        ax.plot(minutes, error, color=colour, linewidth=1.3)
    upper, lower = axes
    upper.set(ylim=(0, 1.6), ylabel="position error (m)")
    upper.set_title(f"robot {robot}, {ANCHORS[anchors]}; band: 2σ of the filter")
    lower.axhline(0, color=MEANING["expected"], linewidth=0.8)
    lower.set(ylim=(-40, 40), ylabel="heading error (°)", xlabel="time (min)")
    return axes


@drawn(
    name="robot-2-nees",
    alt="NEES of robot 2 over a quarter of an hour, logarithmic: without an anchor and with one "
    "it stays above the grey region, with two it is inside most of the time.",
    caption="Robot 2: normalised squared error of the pose. Grey: where a consistent filter is 95 "
    "% of the time.",
    height=3.6,
)
def nees_over_time(ax: Axes, found: Any, robot: int) -> Axes:
    """Draw the normalised error squared of one robot's pose, for no, one and two anchors."""
    one, grey = found.robots[robot], MEANING["expected"]
    minutes, limit = one.times / 60, chi_squared_quantile(0.95, 3)
    band(ax, minutes, 0.05 + 0 * minutes, limit + 0 * minutes, grey)
    tints = (MEANING[name] for name in ("plain", "anchored", "two anchors"))
    for k, (words, tint) in enumerate(zip(ANCHORS, tints, strict=True)):
        ax.semilogy(minutes, np.maximum(one.nees[k], 0.05), color=tint, linewidth=1.3)
        label(ax, 0.99, 0.94 - 0.08 * k, words, tint, transform=ax.transAxes, ha="right")
    label(ax, 0.3, 0.09, "95 % of a consistent filter", grey, fontsize=9)
    ax.set(xlim=(0, minutes[-1]), ylim=(0.05, 400), xlabel="time (min)", ylabel="NEES of the pose")
    ax.yaxis.set_major_formatter(ScalarFormatter())
    ax.set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    ax.minorticks_off()
    return ax


# The park ----------------------------------------------------------------------------------------


@drawn(
    name="victoria-park",
    alt="Drive through a park. The map with Jacobians at the latest estimates is turned "
    "against the one with first estimates by several degrees and has the smaller ellipses; the "
    "trees of the batch optimum lie inside the ellipses of the other.",
    caption="The same measurements, filtered twice; ellipses 95 %. Crosses: trees of the batch "
    "optimum. Dots: satellite fixes.",
    height=6.2,
)
def park_map(ax: Axes, found: Any) -> Axes:
    """Draw the drive through the park: satellite fixes, and the filter with two linearisations."""
    tints, truth = (MEANING["plain"], MEANING["first estimates"]), MEANING["truth"]
    for i, ((name, run), colour) in enumerate(zip(found.runs.items(), tints, strict=True)):
        ax.plot(*run.path.T, color=colour, linewidth=1.1)
        ellipses(ax, run.trees, run.tree_covs, colour, deviations=REACH)
        _note(ax, 0.98, 0.085 - 0.05 * i, f"Jacobians at the {name} estimates", colour, ha="right")
    dots(ax, found.fixes, truth, 1.8)
    best = MEANING["ideal"]
    ax.plot(*found.trees.T, "+", color=best, markersize=5)
    _note(ax, 0.02, 0.86, "+ trees of the optimum", best)
    _note(ax, 0.02, 0.96, "dots: satellite fixes", truth)
    _note(ax, 0.02, 0.91, "ellipses: trees, 95 %", truth)
    low, high = found.fixes.min(axis=0), found.fixes.max(axis=0)
    ax.set(xlim=(low[0] - 60, high[0] + 30), ylim=(low[1] - 60, high[1] + 100))
    ax.set(xlabel="east (m)", ylabel="north (m)", aspect="equal")
    return ax


@drawn(
    name="park-step-times",
    alt="Time of a step with trees in sight grows with the map, to some tens of microseconds; a "
    "step without a tree costs a few, whatever the map.",
    caption="Median time of one step in the park, by the size of the map. A step in which nothing "
    "is seen touches the robot's three rows of the covariance only.",
    height=3.0,
)
def step_times(ax: Axes, found: Any) -> Axes:
    """Draw the time a step took against the number of landmarks in the map."""
    named = (("trees in sight", MEANING["landmark"]), ("none in sight", MEANING["odometry"]))
    for values, (words, colour) in zip(found.microseconds, named, strict=True):
        ax.plot(found.sizes, values, "o-", color=colour, markersize=5)
        label(ax, found.sizes[0], values[0] + 5, words, colour, ha="left")
    ax.set(xlabel="landmarks in the map", ylabel="time of a step (µs)")
    ax.set(xlim=(0, 160), ylim=(0, 1.15 * found.microseconds.max()))
    return ax


# The building ------------------------------------------------------------------------------------


@drawn(
    name="intel-paths",
    alt="Path through the building: corrected poses as a closed ring of corridors, the wheels bent "
    "far away from it, the blind filter close to it at first and then astray, the told filter "
    "near it.",
    caption="The building by four estimates; green dots: corners and columns.",
    width=5.0,
    height=5.6,
)
def building_paths(ax: Axes, found: Any) -> Axes:
    """Draw the way through the building: corrected, by wheels, by the filter, blind and told."""
    dots(ax, found.spots, MEANING["landmark"], 3.0, alpha=0.3)
    paths = (
        ("corrected", "corrected poses", "truth", 2.4),
        ("calibrated", "wheels, calibrated", "odometry", 0.9),
        ("blind", "filter, blind", "names unknown", 0.9),
        ("told", "filter, told", "names known", 1.1),
    )
    for i, (name, words, meaning, width) in enumerate(paths):
        ax.plot(*found.ways[name].T, color=MEANING[meaning], linewidth=width, alpha=0.9)
        _note(ax, 0.02 + 0.55 * (i // 2), 0.97 - 0.05 * (i % 2), words, MEANING[meaning])
    every = np.concatenate(list(found.ways.values()))
    (left, low), (right, high) = every.min(axis=0) - 2, every.max(axis=0) + 2
    ax.set(xlim=(left, right), ylim=(low, high + 6), xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal")
    return ax


@drawn(
    name="intel-loops",
    alt="Error across loops on a logarithmic axis: wheels above ten metres, the blind "
    "filter scattered from three to twenty, the filter told its matches about two, "
    "corrected poses at five centimetres.",
    caption="Relative error between scans on both sides of a loop, each dot one set of choices "
    "for corners, gates and noise. Lines: 95 % intervals of single paths. What would you have "
    "reported, the best dot or all of them?",
    height=3.6,
)
def loop_errors(ax: Axes, found: Any) -> Axes:
    """Draw the error across loops: of wheels with intervals, and of every choice of the filter."""
    groups = {
        "odometry": ("wheels\nraw", "odometry"),
        "calibrated": ("calibrated", "odometry"),
        "blind": ("filter\nblind", "names unknown"),
        "told": ("filter\ntold", "names known"),
        "corrected": ("corrected", "truth"),
    }
    for place, (name, (_, meaning)) in enumerate(groups.items()):
        colour, values = MEANING[meaning], found.errors[name][:, 1, 0]
        spread = np.linspace(-0.25, 0.25, len(values)) if len(values) > 1 else 0.0
        ax.semilogy(place + spread, values, "o", color=colour, markersize=6)
        if name in found.ends:
            ax.semilogy([place, place], found.ends[name][:, 1, 0], color=colour, linewidth=2)
    ax.set_xticks(range(len(groups)), [words for words, _ in groups.values()])
    ax.set(xlim=(-0.5, len(groups) - 0.5), ylim=(0.02, 40), ylabel="error across a loop (m)")
    ax.set_yticks([0.05, 0.2, 1, 5, 20], ["0.05", "0.2", "1", "5", "20"])
    ax.minorticks_off()
    return ax
