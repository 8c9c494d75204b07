"""Figures of the chapter "Walls from laser scans"."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int
from matplotlib.axes import Axes

from robot_perception.chapters.walls.crossings import Crossing
from robot_perception.chapters.walls.growth import Growth, Hulls
from robot_perception.chapters.walls.office import GateStudy, Growing, SearchRange
from robot_perception.chapters.walls.recordings import RecordedMap
from robot_perception.chapters.walls.splitting import KeptByScale, OneScan, Step
from robot_perception.teaching.figures.maps import dots, lines, plan
from robot_perception.teaching.figures.style import MEANING, band, label


def raw_scan(ax: Axes, scan: OneScan) -> Axes:
    """Draw the readings of a scan as the scanner gives them: range against direction."""
    ax.plot(np.rad2deg(scan.angles), scan.ranges, ".", color=MEANING["readings"], markersize=2.5)
    ax.set(xlabel="direction of the beam (°)", ylabel="range (m)", ylim=(0, None))
    ax.set(xlim=(-92, 92), xticks=[-90, -45, 0, 45, 90])
    return ax


def scan_walls(ax: Axes, scan: OneScan) -> Axes:
    """Draw the readings of one scan in the plane and the walls that are found."""
    _readings(ax, scan)
    lines(ax, scan.segments.ends, MEANING["walls"], 3.0)
    return ax


def scan_chain(ax: Axes, scan: OneScan, kept: Sequence[int] | Int[np.ndarray, " kept"]) -> Axes:
    """Draw the readings of one scan and the chain of the vertices kept of it."""
    _readings(ax, scan)
    ax.plot(*scan.points[kept].T, "o-", color=MEANING["kept"], linewidth=1.4, markersize=4.5)
    return ax


def scan_state(ax: Axes, scan: OneScan, extent: Float[np.ndarray, "n 2"]) -> Axes:
    """Draw one scan, the chain kept of it and the true faces, on axes that hold ``extent``."""
    lines(ax, scan.truth, MEANING["truth"], 5.0, alpha=0.2, zorder=0)
    scan_chain(ax, scan, scan.kept)
    ax.set_title(f"{len(scan.kept)} vertices, {len(scan.segments)} walls")
    return plan(ax, np.vstack([extent, [[0, 0]]]))


def _readings(ax: Axes, scan: OneScan) -> None:
    dots(ax, scan.points, size=1.8)
    ax.plot(0, 0, marker=(3, 0, -90), color=MEANING["robot"], markersize=9)
    plan(ax, np.vstack([scan.points, [[0, 0]]]))


def one_split(
    ax: Axes, chain: Float[np.ndarray, "n 2"], step: Step, kept: Sequence[int] = ()
) -> Axes:
    """Draw one call of the recursion: vertices kept, chord, farthest vertex and its distance.

    The farthest vertex is filled if the chain splits there, and hollow if it is near enough.
    """
    for part, alpha, width in ((chain, 0.35, 0.8), (chain[step.i : step.j + 1], 1.0, 1.0)):
        ax.plot(*part.T, "-", color=MEANING["readings"], linewidth=width, alpha=alpha)
        dots(ax, part, size=2 * width, alpha=alpha)
    ax.plot(*chain[list(kept)].T, "o", color=MEANING["kept"], markersize=5)
    chord = chain[[step.i, step.j]]
    ax.plot(*chord.T, "-", color=MEANING["kept"], linewidth=1.8)
    along = chord[1] - chord[0]
    if step.f != step.i and along.any():
        arm = chain[step.f] - chord[0]
        foot = chord[0] + along * (arm @ along) / (along @ along)
        colour = MEANING["error"]
        ax.plot(*np.stack([chain[step.f], foot]).T, "--", color=colour, linewidth=1.6)
        inside = colour if step.split else "none"
        ax.plot(*chain[step.f], "o", color=colour, markerfacecolor=inside, markersize=7)
    return plan(ax, chain)


def recursion_state(
    ax: Axes, chain: Float[np.ndarray, "n 2"], calls: Sequence[Step], *, stretch: bool = False
) -> Axes:
    """Draw the latest call of the recursion, what all calls kept, and what they have cost.

    A zigzag, which is far longer than high, is stretched to fill its axes.
    """
    last, cost = calls[-1], sum(call.j - call.i - 1 for call in calls)
    done = [0, len(chain) - 1, *(call.f for call in calls if call.split)]
    one_split(ax, chain, last, done).set_aspect("auto" if stretch else "equal")
    verdict = "split" if last.split else "near enough"
    ax.set_title(f"{last.d:.2f} m: {verdict}; {cost} distances")
    return ax


def kept_by_scale(ax: Axes, counts: KeptByScale) -> Axes:
    """Draw the vertices kept of one scan against its scale, by the right and the printed rule."""
    scales = counts.scales
    right, printed = MEANING["kept"], MEANING["paper"]
    ax.semilogx(scales, counts.distance, "o-", color=right)
    ax.semilogx(scales, counts.printed, "s-", color=printed)
    label(ax, scales[1], counts.printed[0] + 14, "as printed", printed, ha="left")
    label(ax, scales[-2] * 0.8, counts.distance[-2], "as a distance", right, ha="right")
    ax.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
    ax.minorticks_off()
    ax.set(xlabel="enlargement of the scan", ylabel="vertices kept", ylim=(0, None))
    return ax


def costs(ax: Axes, plain: Growth, hulls: Growth) -> Axes:
    """Draw steps against vertices on logarithmic axes; dashed: proportional to the vertices."""
    ax.loglog(plain.sizes, plain.sizes * 10.0, "--", color=MEANING["expected"], linewidth=1.0)
    for found, name in ((plain, "every vertex"), (hulls, "path hulls")):
        ax.loglog(found.sizes, found.costs, "o-", color=MEANING[name], markersize=4.5)
        label(ax, found.sizes[-1] * 1.25, found.costs[-1], name, MEANING[name])
    ax.set(xlabel="vertices n", ylabel="elementary steps")
    ax.set_xlim(right=max(plain.sizes[-1], hulls.sizes[-1]) * 40)
    return ax


def two_hulls(ax: Axes, found: Hulls) -> Axes:
    """Draw a chain with the hulls of its two halves, its chord and the vertex farthest from it."""
    chain = found.chain
    for hull, name in zip(found.corners, ("path hulls", "other hull"), strict=True):
        ring = chain[np.append(hull, hull[0])]
        ax.fill(*ring.T, color=MEANING[name], alpha=0.12, linewidth=0)
        ax.plot(*ring.T, "o-", color=MEANING[name], linewidth=1.4, markersize=4)
    ax.plot(*chain.T, ".-", color=MEANING["readings"], markersize=3, linewidth=0.9)
    ax.plot(*chain[[0, -1]].T, "-", color=MEANING["kept"], linewidth=1.8)
    ax.plot(*chain[found.farthest], "o", color=MEANING["error"], markersize=8)
    ax.plot(*chain[found.tag], "s", color=MEANING["tag"], markersize=7)
    return plan(ax, chain)


def crossing(ax: Axes, example: Crossing, kept: Int[np.ndarray, " kept"]) -> Axes:
    """Draw a chain that crosses itself, its crossing edges, and the vertices kept of it."""
    chain, lost = example.chain, np.setdiff1d(example.plain, kept)
    ax.plot(*chain.T, "-", color=MEANING["readings"], linewidth=1.0)
    for edge in np.unique(example.edges):
        ax.plot(*chain[edge : edge + 2].T, "-", color=MEANING["error"], linewidth=2.6)
    ax.plot(*chain[kept].T, "o", color=MEANING["kept"], markersize=5)
    ax.plot(*chain[lost].T, "x", color=MEANING["missed"], markersize=9, markeredgewidth=2.2)
    return plan(ax, chain)


def search_range(ax: Axes, found: SearchRange) -> Axes:
    """Draw a wall hypothesis with the band in which the same wall may lie in another scan.

    The scale across the wall is enlarged.
    """
    along, half = found.along, 100 * found.half_width
    band(ax, along, -half, half, MEANING["walls"])
    ax.axhline(0, color=MEANING["walls"], linewidth=1.8)
    ax.plot(*(found.readings * [1, 100]).T, ".", color=MEANING["readings"], markersize=5)
    ax.set(xlim=along[[0, -1]], xlabel="along the wall (m)")
    ax.set(ylim=(-40, 40), ylabel="across the wall (cm)")
    ax.set_title(f"±{half[0]:.1f} cm at 3 m, ±{half.min():.1f} cm at best")
    return ax


def chi_square(ax: Axes, values: Float[np.ndarray, " runs"]) -> Axes:
    """Draw the distribution of normalised squared errors beside χ² with two degrees of freedom."""
    fitted, law = MEANING["walls"], MEANING["expected"]
    ax.hist(values, np.linspace(0, 12, 37), density=True, color=fitted, alpha=0.35)
    x = np.linspace(0, 12, 200)
    ax.plot(x, np.exp(-x / 2) / 2, color=law, linewidth=1.4)
    label(ax, 3.2, 0.16, "χ², two degrees", law)
    label(ax, 3.2, 0.26, "fitted lines", fitted)
    ax.set(xlabel="normalised squared error", ylabel="density", xlim=(0, 12))
    return ax


def gate_study(left: Axes, right: Axes, study: GateStudy) -> tuple[Axes, Axes]:
    """Draw walls, precision and missed length of maps against the roughness of their gate."""
    place = np.arange(len(study.roughness))
    good, bad = MEANING["walls"], MEANING["error"]
    left.plot(place, study.walls, "o-", color=good)
    left.set(ylabel="walls in the map", ylim=(0, None))
    right.plot(place, 100 * study.precision, "o-", color=good)
    right.plot(place, 100 * study.missed, "s-", color=bad)
    label(right, 0.1, 84, "precision", good, ha="left")
    label(right, 0.1, 22, "length missed", bad, ha="left")
    right.set(ylabel="share of length (%)", ylim=(0, 104))
    for ax in (left, right):
        ax.set_xticks(place, [f"{100 * r:g}" for r in study.roughness])
        ax.set_xlabel("roughness of the gate (cm)")
    return left, right


def map_state(ax: Axes, state: Growing, least: int, extent: Float[np.ndarray, "n 2"]) -> Axes:
    """Draw the map after some scans: walls seen at least so often, on axes that hold ``extent``."""
    found = state.found.seen_in(least)
    _wall_map(ax, state.points, found.ends, state.way)
    ax.set_title(f"after {state.scans} scans: {len(found)} walls")
    return plan(ax, extent, margin=0.6)


def recorded_map(ax: Axes, found: RecordedMap) -> Axes:
    """Draw the map of a recording in the colours of the paper's Fig. 1b."""
    _wall_map(ax, found.points, found.ends, found.way)
    return plan(ax, found.points, margin=0.6)


def _wall_map(ax: Axes, points: np.ndarray, ends: np.ndarray, way: np.ndarray) -> None:
    """Draw readings blue, walls green and the way red, as in the paper's Fig. 1b."""
    dots(ax, points)
    lines(ax, ends, MEANING["walls"], 1.6)
    ax.plot(*way.T, "-", color=MEANING["robot"], linewidth=1.0)


def directions(ax: Axes, found: RecordedMap) -> Axes:
    """Draw the share of wall length by direction, modulo a right angle."""
    ax.bar(
        found.directions, 100 * found.direction_share, width=4.4, color=MEANING["walls"], alpha=0.8
    )
    even = 100 / len(found.directions)
    ax.axhline(even, color=MEANING["expected"], linewidth=1.2, linestyle="--")
    ax.set(xlabel="direction of the wall modulo 90° (°)", ylabel="share of length (%)")
    ax.set(xlim=(0, 90), xticks=[0, 15, 30, 45, 60, 75, 90])
    return ax
