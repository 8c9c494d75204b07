"""Figures of the chapter "Walls from laser scans".

What they draw is made in the notebook: a namespace with the names that a drawing reads.
"""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace as Found

import numpy as np
from jaxtyping import Float, Int
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.maps import dots, lines, plan
from explorables.figures.style import MEANING, band, label
from robot_perception.chapters.walls.recordings import RecordedMap


@drawn(
    alt="(a) Range against direction, a curve with arcs, steps and a few lone dots. (b) The "
    "same readings as points in the plane, lying on straight walls, each covered by a green "
    "segment.",
    caption=lambda scan: (
        f"One scan: {scan.ranges.size} readings as the scanner gives them (a), and in the "
        f"plane (b; the red triangle is the robot). Green: the {len(scan.segments)} walls "
        "found. Which readings do they leave out, and why?"
    ),
    cols=2,
    height=4.2,
)
def opening(axes: Sequence[Axes], scan: Found) -> None:
    """Draw one scan as the scanner gives it, and in the plane with its walls."""
    raw, plane = axes
    raw.plot(np.rad2deg(scan.angles), scan.ranges, ".", color=MEANING["readings"], markersize=2.5)
    raw.set(xlabel="direction of the beam (°)", ylabel="range (m)", ylim=(0, None))
    raw.set(xlim=(-92, 92), xticks=[-90, -45, 0, 45, 90])
    _readings(plane, scan)
    lines(plane, scan.segments.ends, MEANING["walls"], 3.0)


def scan_chain(ax: Axes, scan: Found, kept: Sequence[int] | Int[np.ndarray, " kept"]) -> Axes:
    """Draw the readings of one scan and the chain of the vertices kept of it."""
    _readings(ax, scan)
    ax.plot(*scan.points[kept].T, "o-", color=MEANING["kept"], linewidth=1.4, markersize=4.5)
    return ax


def scan_state(ax: Axes, scan: Found, extent: Float[np.ndarray, "n 2"]) -> Axes:
    """Draw one scan, the chain kept of it and the true faces, on axes that hold ``extent``."""
    ax.clear()
    lines(ax, scan.truth, MEANING["truth"], 5.0, alpha=0.2, zorder=0)
    scan_chain(ax, scan, scan.kept)
    ax.set_title(f"{len(scan.kept)} vertices, {len(scan.segments)} walls")
    return plan(ax, np.vstack([extent, [[0, 0]]]))


def viewed(ax: Axes, scan: Found, room: Float[np.ndarray, "faces 2 2"]) -> Axes:
    """Draw a scan from somewhere in the room, and the walls it gives, on axes cleared first."""
    ax.clear()
    lines(ax, room, MEANING["truth"], 5.0, alpha=0.2, zorder=0)
    dots(ax, scan.points + scan.place, size=1.8)
    lines(ax, scan.segments.ends + np.asarray(scan.place), MEANING["walls"], 3.0)
    ax.plot(*scan.place, marker=(3, 0, -90), color=MEANING["robot"], markersize=9)
    ax.set_title(f"{len(scan.segments)} walls")
    return plan(ax, np.array([[-0.5, -2.9], [5.0, 4.2]]), margin=0.0)


@drawn(
    alt="One scan, twice. (a) Splitting keeps vertices along the walls. (b) Hardly any.",
    caption="The same scan and the same ε, three deviations of the noise. (a) Vertices kept by "
    "splitting. (b) The fewest with which no reading is farther from its chord than ε.",
    cols=2,
    height=3.8,
)
def fewest(axes: Sequence[Axes], scan: Found, chains: Mapping[str, Sequence[int]]) -> None:
    """Draw the chains that two ways leave of one scan, an axes each."""
    for ax, (name, kept) in zip(axes, chains.items(), strict=True):
        scan_chain(ax, scan, kept).set_title(f"{name}: {len(kept) - 1} chords")


def _readings(ax: Axes, scan: Found) -> None:
    dots(ax, scan.points, size=1.8)
    ax.plot(0, 0, marker=(3, 0, -90), color=MEANING["robot"], markersize=9)
    plan(ax, np.vstack([scan.points, [[0, 0]]]))


@drawn(
    alt="The chain of one scan with the chord from its first to its last reading, and a dashed "
    "line from the farthest reading, a far corner of the room, square onto the line of the "
    "chord.",
    caption="The first question asked of the scan: which reading (magenta) lies farthest "
    "from the chord (orange)? It is a corner. Dashed: its distance.",
    width=4.0,
    height=4.0,
)
def one_split(
    ax: Axes, chain: Float[np.ndarray, "n 2"], step: Found, kept: Sequence[int] = ()
) -> Axes:
    """Draw one call of the recursion; its farthest vertex is filled if the chain splits there."""
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
    ax: Axes,
    chain: Float[np.ndarray, "n 2"],
    calls: Sequence[Found],
    *,
    stretch: bool = False,
) -> Axes:
    """Draw the latest call of the recursion, what all kept, and their cost; zigzags stretched."""
    ax.clear()
    last, cost = calls[-1], sum(call.j - call.i - 1 for call in calls)
    done = [0, len(chain) - 1, *(call.f for call in calls if call.split)]
    one_split.on(ax, chain, last, done).set_aspect("auto" if stretch else "equal")
    verdict = "split" if last.split else "near enough"
    ax.set_title(f"{last.d:.2f} m: {verdict}; {cost} distances")
    return ax


@drawn(
    alt="A zigzag of sixteen vertices, twice. First split: the farthest vertex from the first "
    "chord is the second vertex. Sixth split: the first seven vertices are kept, and the stretch "
    "that is left still holds all others.",
    caption="The worst line, at its first split and at its sixth. Orange: chord and vertices "
    "kept; magenta: the farthest vertex, each time the next one. Height and width have different "
    "scales, so right angles do not look right.",
    cols=2,
    height=3.4,
)
def worst_line(
    axes: Sequence[Axes], zigzag: Float[np.ndarray, "n 2"], splits: Sequence[Found]
) -> None:
    """Draw the first split of the worst case and its sixth."""
    for ax, count, name in zip(axes, (1, 6), ("first split", "sixth split"), strict=True):
        recursion_state(ax, zigzag, splits[:count], stretch=True).set_title(name)


@drawn(
    alt="(a) Vertices kept against the enlargement of the scan; flat for the printed rule, "
    "growing for a distance. (b) The scan with the vertices of the printed rule, which "
    "crowd on short pieces near edges.",
    caption="Both rules with ε = 0.08. (a) Vertices kept when the scan is enlarged. (b) The "
    "printed rule spends its vertices on the shortest chords, where noise looks steep.",
    cols=2,
    height=3.8,
)
def printed_rule(axes: Sequence[Axes], counts: Found, scan: Found, printed: Sequence[int]) -> None:
    """Draw the vertices kept at several scales, and those that the printed rule keeps."""
    ax, scales = axes[0], counts.scales
    right, printed_in = MEANING["kept"], MEANING["paper"]
    ax.semilogx(scales, counts.distance, "o-", color=right)
    ax.semilogx(scales, counts.printed, "s-", color=printed_in)
    label(ax, scales[1], counts.printed[0] + 14, "as printed", printed_in, ha="left")
    label(ax, scales[-2] * 0.8, counts.distance[-2], "as a distance", right, ha="right")
    ax.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
    ax.minorticks_off()
    ax.set(xlabel="enlargement of the scan", ylabel="vertices kept", ylim=(0, None))
    scan_chain(axes[1], scan, printed).set_title(f"as printed: {len(printed)} vertices")


@drawn(
    alt="Steps against vertices, both logarithmic. The plain algorithm rises twice as steeply as "
    "path hulls.",
    caption=lambda plain, hulls, times: (
        "Elementary steps on the worst line, counted. Dashed: proportional to n. In seconds, "
        f"recorded for 100\u202f000 vertices: {times['ours_s']:.2f} with path hulls, "
        f"{times['peer_s']:.1f} without (the package {times['peer']}, compiled)."
    ),
    height=3.6,
)
def costs(ax: Axes, plain: Found, hulls: Found, times: Mapping[str, object]) -> Axes:
    """Draw steps against vertices on logarithmic axes; dashed: proportional to the vertices."""
    ax.loglog(plain.sizes, plain.sizes * 10.0, "--", color=MEANING["expected"], linewidth=1.0)
    for found, name in ((plain, "every vertex"), (hulls, "path hulls")):
        ax.loglog(found.sizes, found.costs, "o-", color=MEANING[name], markersize=4.5)
        label(ax, found.sizes[-1] * 1.25, found.costs[-1], name, MEANING[name])
    ax.set(xlabel="vertices n", ylabel="elementary steps")
    ax.set_xlim(right=max(plain.sizes[-1], hulls.sizes[-1]) * 40)
    return ax


@drawn(
    alt="A wavy chain. A square in its middle, the tag, divides it; a violet hull wraps "
    "the left half, a green one the right half. The vertex farthest from the chord is a "
    "corner of one of the hulls.",
    caption="Two hulls that meet at the tag (square). The vertex farthest from the chord (magenta) "
    "is a corner of one of them. If the chain is split there, which of the two hulls can "
    "stay as it is?",
    height=3.0,
)
def two_hulls(ax: Axes, found: Found) -> Axes:
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


@drawn(
    alt="A curve that crosses itself: the vertices kept by the plain algorithm, and "
    "those kept by unchecked path hulls, with crosses where some of the former are missing.",
    caption="The same chain twice. Dots: vertices kept; magenta: edges that cross. Crosses: "
    "vertices that the plain algorithm keeps and path hulls miss.",
    cols=2,
    height=3.8,
)
def crossing(axes: Sequence[Axes], example: Found) -> None:
    """Draw a chain that crosses itself, and the vertices that both algorithms keep of it."""
    titles, chain = ("every vertex: {} kept", "path hulls: {} kept"), example.chain
    for ax, kept, title in zip(axes, (example.plain, example.hulls), titles, strict=True):
        lost = np.setdiff1d(example.plain, kept)
        ax.plot(*chain.T, "-", color=MEANING["readings"], linewidth=1.0)
        for edge in np.unique(example.edges):
            ax.plot(*chain[edge : edge + 2].T, "-", color=MEANING["error"], linewidth=2.6)
        ax.plot(*chain[kept].T, "o", color=MEANING["kept"], markersize=5)
        ax.plot(*chain[lost].T, "x", color=MEANING["missed"], markersize=9, markeredgewidth=2.2)
        plan(ax, chain).set_title(title.format(len(kept)))


def search_range(ax: Axes, found: Found) -> Axes:
    """Draw a wall hypothesis and the band in which the same wall may lie in another scan."""
    ax.clear()
    along, half = found.along, 100 * found.half_width
    band(ax, along, -half, half, MEANING["walls"])
    ax.axhline(0, color=MEANING["walls"], linewidth=1.8)
    ax.plot(*(found.readings * [1, 100]).T, ".", color=MEANING["readings"], markersize=5)
    ax.set(xlim=along[[0, -1]], xlabel="along the wall (m)")
    ax.set(ylim=(-40, 40), ylabel="across the wall (cm)")
    ax.set_title(f"±{half[0]:.1f} cm at 3 m, ±{half.min():.1f} cm at best")
    return ax


@drawn(
    alt="Histogram of the normalised squared errors of fitted lines; it follows the exponential "
    "curve of the χ² law.",
    caption=lambda values: (
        f"{values.size} fits to one wall. Their mean is {values.mean():.2f} ± "
        f"{values.std() / np.sqrt(values.size):.2f} (one standard error): the errors are as large "
        "as the covariance says."
    ),
    height=3.0,
)
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


@drawn(
    alt="Number of walls against the roughness of the gate, falling from a hundred to a "
    "few. The missed length is least in the middle; the precision falls beyond it.",
    caption="One drive, poses 2 cm wrong, six gates. (a) Walls in the map. (b) Precision, the "
    "share of the map's length that is real, and the share of the length reached that is missed. "
    "Without roughness one wall becomes many; with too much, different walls become one.",
    cols=2,
    height=3.2,
)
def gate_study(axes: Sequence[Axes], study: Found) -> None:
    """Draw walls, precision and missed length of maps against the roughness of their gate."""
    left, right = axes
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


def map_state(ax: Axes, state: Found, least: int, extent: Float[np.ndarray, "n 2"]) -> Axes:
    """Draw the map after some scans: walls seen at least so often, on axes that hold ``extent``."""
    ax.clear()
    found = state.found.seen_in(least)
    _wall_map(ax, state.points, found.ends, state.way)
    ax.set_title(f"after {state.scans} scans: {len(found)} walls")
    return plan(ax, extent, margin=0.6)


@drawn(
    alt="Map of a building: raw readings in blue, walls in green, the robot's path in red. "
    "Straight walls of a long corridor and of the rooms on both sides are covered by green "
    "segments.",
    caption="Freiburg 079, in the colours of the paper's Fig. 1b: blue the raw readings (thinned), "
    "green the walls, red the path of the robot.",
    height=3.1,
)
def freiburg(ax: Axes, found: RecordedMap) -> None:
    """Draw the map of the recording in the body of the chapter."""
    recorded_map(ax, found)


@drawn(
    alt="Map of a building: raw readings in blue, walls in green, the robot's path in red. "
    "Straight walls are covered by green segments; the curved wall is a polygon, with segments "
    "across each other.",
    caption="Intel Research Lab, in the colours of the paper's Fig. 1b: blue the raw readings "
    "(thinned), green the walls, red the path of the robot.",
    height=6.0,
)
def intel(ax: Axes, found: RecordedMap) -> None:
    """Draw the map of the further recording."""
    recorded_map(ax, found)


def recorded_map(ax: Axes, found: RecordedMap) -> Axes:
    """Draw the map of a recording in the colours of the paper's Fig. 1b."""
    _wall_map(ax, found.points, found.ends, found.way)
    ax.set_title(f"{found.used} scans, {found.walls} walls")
    return plan(ax, found.points, margin=0.6)


def _wall_map(ax: Axes, points: np.ndarray, ends: np.ndarray, way: np.ndarray) -> None:
    """Draw readings blue, walls green and the way red, as in the paper's Fig. 1b."""
    dots(ax, points)
    lines(ax, ends, MEANING["walls"], 1.6)
    ax.plot(*way.T, "-", color=MEANING["robot"], linewidth=1.0)


@drawn(
    alt="Share of wall length by direction modulo ninety degrees: one sharp peak.",
    caption="Aligned: share of the wall length within 5° of one pair of perpendicular "
    f"directions. Dashed: no preferred direction, which would align {10 / 90:.0%}.",
    height=3.0,
)
def aligned(ax: Axes, found: RecordedMap) -> None:
    """Draw the directions of walls under the share that is aligned."""
    directions(ax, found).set_title(f"{found.square:.0%} aligned")


@drawn(
    alt="Share of wall length by direction modulo ninety degrees for two buildings: one sharp "
    "peak each.",
    caption="Directions of the walls, modulo a right angle, by length. Dashed: no preference at "
    "all.",
    cols=2,
    height=3.2,
    sharey=True,
)
def two_directions(axes: Sequence[Axes], buildings: Mapping[str, RecordedMap]) -> None:
    """Draw the directions of the walls of buildings, an axes each."""
    for ax, (name, found) in zip(axes, buildings.items(), strict=True):
        directions(ax, found).set_title(name)


def directions(ax: Axes, found: RecordedMap) -> Axes:
    """Draw the share of wall length by direction, modulo a right angle."""
    shares = 100 * found.direction_share
    ax.bar(found.directions, shares, width=4.4, color=MEANING["walls"], alpha=0.8)
    even = 100 / len(found.directions)
    ax.axhline(even, color=MEANING["expected"], linewidth=1.2, linestyle="--")
    ax.set(xlabel="direction of the wall modulo 90° (°)", ylabel="share of length (%)")
    ax.set(xlim=(0, 90), xticks=[0, 15, 30, 45, 60, 75, 90])
    return ax
