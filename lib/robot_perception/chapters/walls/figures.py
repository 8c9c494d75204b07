"""Figures of the chapter "Walls from laser scans"."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

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
    label,
)


def lines(ax: Axes, ends: np.ndarray, colour: str, width: float = 2.0, **kwargs: object) -> None:
    """Draw segments given by their ends (segments, 2, 2)."""
    ax.add_collection(LineCollection(ends, colors=colour, linewidths=width, **kwargs))


def dots(ax: Axes, points: np.ndarray, colour: str = BLUE, size: float = 1.3) -> None:
    """Draw many points as one path: small as SVG, and the same in every renderer."""
    pen = np.full((len(points), 3, 2), np.nan)
    pen[:, 0] = points
    pen[:, 1] = points + np.array([1e-3, 0.0])
    (drawn,) = ax.plot(*pen.reshape(-1, 2).T, color=colour, linewidth=size)
    drawn.set_solid_capstyle("round")
    drawn.get_path().should_simplify = False


def plan(ax: Axes, points: np.ndarray, *, margin: float = 0.4) -> Axes:
    """Make axes a map in metres that holds all points, without distortion."""
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal", adjustable="box")
    ax.set_xlabel("x (m)")
    ax.set_ylabel("y (m)")
    return ax


def raw_scan(ax: Axes, angles: np.ndarray, ranges: np.ndarray) -> Axes:
    """Draw the readings of a scan as the scanner gives them: range against direction."""
    ax.plot(np.rad2deg(angles), ranges, ".", color=BLUE, markersize=2.5)
    ax.set_xlabel("direction of the beam (°)")
    ax.set_ylabel("range (m)")
    ax.set_xlim(-92, 92)
    ax.set_xticks([-90, -45, 0, 45, 90])
    ax.set_ylim(0, None)
    return ax


def scan_chain(
    ax: Axes,
    points: np.ndarray,
    *,
    kept: np.ndarray | None = None,
    walls: np.ndarray | None = None,
    truth: np.ndarray | None = None,
) -> Axes:
    """Draw the readings of one scan, the chain kept of them, its walls, and the true faces."""
    if truth is not None:
        lines(ax, truth, FAINT, 5.0, zorder=0)
    dots(ax, points, BLUE, 1.8)
    if kept is not None:
        ax.plot(*points[kept].T, "-", color=ORANGE, linewidth=1.4)
        ax.plot(*points[kept].T, "o", color=ORANGE, markersize=4.5)
    if walls is not None:
        lines(ax, walls, GREEN, 3.0)
    ax.plot(0, 0, marker=(3, 0, -90), color=RED, markersize=9)
    return plan(ax, np.vstack([points, [[0, 0]]]))


def one_split(ax: Axes, chain: np.ndarray, step: object, *, done: np.ndarray | None = None) -> Axes:
    """Draw one call of the recursion: chord, farthest vertex and its distance."""
    i, j, f = step.i, step.j, step.f
    inner = chain[i : j + 1]
    for part, colour, width in ((chain, FAINT, 0.8), (inner, BLUE, 1.0)):
        ax.plot(*part.T, "-", color=colour, linewidth=width)
        dots(ax, part, colour, 2 * width)
    if done is not None:
        ax.plot(*chain[done].T, "o", color=ORANGE, markersize=5)
    chord = chain[[i, j]]
    ax.plot(*chord.T, "-", color=ORANGE, linewidth=1.8)
    along = chord[1] - chord[0]
    squared = along @ along
    if f != i and squared > 0:
        foot = chord[0] + along * ((chain[f] - chord[0]) @ along) / squared
        colour = RED if step.split else GREEN
        ax.plot(*np.stack([chain[f], foot]).T, "--", color=colour, linewidth=1.6)
        ax.plot(*chain[f], "o", color=colour, markersize=7)
    return plan(ax, chain)


def stretched(ax: Axes) -> Axes:
    """Let a map fill its axes: for zigzags, which are far longer than high."""
    ax.set_aspect("auto")
    return ax


def recursion_state(
    ax: Axes, chain: np.ndarray, calls: Sequence[object], *, stretch: bool = False
) -> Axes:
    """Draw the latest call of the recursion, what all calls kept, and what they have cost."""
    last, cost = calls[-1], sum(call.j - call.i - 1 for call in calls)
    done = [0, len(chain) - 1, *(call.f for call in calls if call.split)]
    one_split(ax, chain, last, done=done)
    verdict = "split" if last.split else "near enough"
    ax.set_title(f"farthest {last.d:.2f} m: {verdict}; {cost} distances so far")
    return stretched(ax) if stretch else ax


def scan_state(ax: Axes, look: object) -> Axes:
    """Draw one scan with the chain kept of it and the true faces behind."""
    scan_chain(ax, look.points, kept=look.kept, truth=look.truth)
    ax.set_title(f"{len(look.kept)} vertices, {len(look.segments)} walls")
    return ax


def map_state(ax: Axes, state: object, least: int, extent: np.ndarray) -> Axes:
    """Draw the map after some scans: walls seen at least so often, on axes that hold ``extent``."""
    found = state.walls.seen_in(least)
    wall_map(ax, state.points, found.ends, state.way)
    plan(ax, extent, margin=0.6)
    ax.set_title(f"{state.scans} scans, {len(found)} walls")
    return ax


def growth(ax: Axes, curves: dict[str, tuple[np.ndarray, np.ndarray, str]]) -> Axes:
    """Draw steps against vertices on logarithmic axes, each curve labelled at its end."""
    for name, (sizes, counts, colour) in curves.items():
        ax.loglog(sizes, counts, "o-", color=colour, markersize=4.5)
        label(ax, sizes[-1] * 1.25, counts[-1], name, colour)
    ax.set_xlabel("vertices n")
    ax.set_ylabel("elementary steps")
    ax.set_xlim(right=max(s[-1] for s, _, _ in curves.values()) * 40)
    return ax


def guide(ax: Axes, sizes: np.ndarray, values: np.ndarray) -> Axes:
    """Draw a theoretical curve as a thin dashed line."""
    ax.loglog(sizes, values, "--", color=MUTED, linewidth=1.0)
    return ax


def two_hulls(ax: Axes, chain: np.ndarray, tag: int, hulls: Sequence[np.ndarray], f: int) -> Axes:
    """Draw a chain with the hulls of its two halves, its chord and the vertex farthest from it."""
    for hull, colour in zip(hulls, (PURPLE, TEAL), strict=True):
        ring = np.append(hull, hull[0])
        ax.fill(*chain[ring].T, color=colour, alpha=0.12, linewidth=0)
        ax.plot(*chain[ring].T, "-", color=colour, linewidth=1.4)
        ax.plot(*chain[hull].T, "o", color=colour, markersize=4)
    ax.plot(*chain.T, ".-", color=BLUE, markersize=3, linewidth=0.9)
    ax.plot(*chain[[0, -1]].T, "-", color=ORANGE, linewidth=1.8)
    ax.plot(*chain[f], "o", color=RED, markersize=8)
    ax.plot(*chain[tag], "s", color=INK, markersize=7)
    return plan(ax, chain)


def crossing(ax: Axes, example: object, kept: np.ndarray) -> Axes:
    """Draw a chain that crosses itself, its crossing edges, and the vertices kept of it."""
    chain = example.chain
    ax.plot(*chain.T, "-", color=BLUE, linewidth=1.0)
    for edge in np.unique(example.edges):
        ax.plot(*chain[edge : edge + 2].T, "-", color=RED, linewidth=2.6)
    ax.plot(*chain[kept].T, "o", color=ORANGE, markersize=5)
    lost = np.setdiff1d(example.plain, kept)
    ax.plot(*chain[lost].T, "x", color=INK, markersize=9, markeredgewidth=2.2)
    return plan(ax, chain)


def kept_by_scale(ax: Axes, counts: dict[str, np.ndarray]) -> Axes:
    """Draw the vertices kept of one scan against its scale, by the right and the printed rule."""
    scale = counts["scale"]
    ax.semilogx(scale, counts["distance"], "o-", color=BLUE)
    ax.semilogx(scale, counts["printed"], "s-", color=RED)
    label(ax, scale[1], counts["printed"][0] + 14, "as printed", RED, ha="left")
    label(ax, scale[-2] * 0.8, counts["distance"][-2], "as a distance", BLUE, ha="right")
    ax.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
    ax.minorticks_off()
    ax.set_xlabel("enlargement of the scan")
    ax.set_ylabel("vertices kept")
    ax.set_ylim(0, None)
    return ax


def search_range(ax: Axes, found: object, *, reach: float = 0.35) -> Axes:
    """Draw a wall hypothesis with the band in which another look at the same wall may lie.

    The scale across the wall is enlarged.
    """
    centred = found.points - found.middle
    along, across = centred @ found.direction, (centred @ found.normal) * 100
    band(ax, found.along, -100 * found.half_width, 100 * found.half_width, GREEN)
    ax.axhline(0, color=GREEN, linewidth=1.8)
    ax.plot(along, across, ".", color=BLUE, markersize=5)
    ax.set_xlim(found.along[0], found.along[-1])
    ax.set_ylim(-100 * reach, 100 * reach)
    ax.set_xlabel("along the wall (m)")
    ax.set_ylabel("across the wall (cm)")
    far, near = 100 * found.half_width[0], 100 * found.half_width.min()
    ax.set_title(f"99 % band: ±{far:.1f} cm at 3 m, ±{near:.1f} cm at best")
    return ax


def gate_study(left: Axes, right: Axes, study: object) -> tuple[Axes, Axes]:
    """Draw walls, precision and missed length of maps against the roughness of their gate."""
    place = np.arange(len(study.roughness))
    left.plot(place, study.walls, "o-", color=PURPLE)
    left.set_ylabel("walls in the map")
    left.set_ylim(0, None)
    right.plot(place, 100 * study.precision, "o-", color=GREEN)
    right.plot(place, 100 * study.missed, "s-", color=RED)
    label(right, 0.1, 84, "precision", GREEN, ha="left")
    label(right, 0.1, 22, "length missed", RED, ha="left")
    right.set_ylabel("share of length (%)")
    right.set_ylim(0, 104)
    for ax in (left, right):
        ax.set_xticks(place, [f"{100 * r:g}" for r in study.roughness])
        ax.set_xlabel("roughness of the gate (cm)")
    return left, right


def chi_square(ax: Axes, values: np.ndarray) -> Axes:
    """Draw the distribution of normalised squared errors beside χ² with two degrees of freedom."""
    edges = np.linspace(0, 12, 37)
    ax.hist(values, edges, density=True, color=GREEN, alpha=0.35)
    x = np.linspace(0, 12, 200)
    ax.plot(x, np.exp(-x / 2) / 2, color=INK, linewidth=1.4)
    label(ax, 3.2, 0.16, "χ², two degrees", INK)
    label(ax, 3.2, 0.26, "fitted lines", GREEN)
    ax.set_xlabel("normalised squared error")
    ax.set_ylabel("density")
    ax.set_xlim(0, 12)
    return ax


def wall_map(
    ax: Axes,
    points: np.ndarray,
    walls: np.ndarray,
    way: np.ndarray,
    *,
    truth: np.ndarray | None = None,
) -> Axes:
    """Draw a map in the colours of the paper's Fig. 1b: readings blue, walls green, way red."""
    dots(ax, points)
    if truth is not None:
        lines(ax, truth, INK, 0.7)
    lines(ax, walls, GREEN, 1.6)
    ax.plot(*way.T, "-", color=RED, linewidth=1.0)
    return plan(ax, points, margin=0.6)


def directions(ax: Axes, centres: np.ndarray, share: np.ndarray, colour: str = GREEN) -> Axes:
    """Draw the share of wall length by direction, modulo a right angle."""
    ax.bar(centres, 100 * share, width=4.4, color=colour, alpha=0.8)
    ax.axhline(100 / len(centres), color=MUTED, linewidth=1.2, linestyle="--")
    ax.set_xlabel("direction of the wall modulo 90° (°)")
    ax.set_ylabel("share of length (%)")
    ax.set_xlim(0, 90)
    ax.set_xticks([0, 15, 30, 45, 60, 75, 90])
    return ax
