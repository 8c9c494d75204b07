"""Drawings of the chapter: two filters close up, all of them at a glance, and wrong names."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.maps import dots
from explorables.figures.style import MEANING, AxesRow, band, ellipses, label
from robot_perception.gating import chi_squared_quantile
from studies.rows import Rows
from studies.tables import Table

NEAR = 2.5  # m to each side of the true place
REGION = float(np.sqrt(chi_squared_quantile(0.95, 2)))  # deviations that hold 95 % of a plane


@drawn(
    name="world-close",
    alt="Close-up of a place on the floor: the large ellipse of B holds the true place; the "
    "smaller one of A lies beside it and does not.",
    caption="Two thirds of the way round a loop of posts, seen from the robot. Cross: the robot. "
    "Ellipses: the regions that hold it with 95 % probability, as A and B state them.",
    width=5.2,
    height=4.2,
)
def close(ax: Axes, found: Any, names: tuple[str, str]) -> Axes:
    """Draw what particles and a Kalman filter believe round the true place, on cleared axes."""
    ax.clear()
    dots(ax, found.cloud - found.truth, MEANING["robot"], size=2.0)
    both = zip(names, ("robot", "plain"), (found.crowd, found.kalman), strict=True)
    for name, meaning, (place, cov) in both:
        off, colour = place - found.truth, MEANING[meaning]
        ellipses(ax, off[None], cov[None], colour, deviations=REGION, width=1.8, corners=48)
        ax.plot(*off, "o", color=colour, markersize=5)
        way, va = (1, "bottom") if meaning == "robot" else (-1, "top")
        end = off[1] + way * (REGION * np.sqrt(cov[1, 1]) + 0.12)
        label(ax, off[0], np.clip(end, -2.2, 2.2), name, colour, ha="center", va=va)
    ax.plot(0, 0, "+", color=MEANING["truth"], markersize=14, markeredgewidth=2.2)
    ax.set(xlim=(-NEAR, NEAR), ylim=(-NEAR, NEAR), xlabel="off in x (m)", ylabel="off in y (m)")
    ax.set_title(f"{found.along:.0f} m driven")
    ax.set_aspect("equal", adjustable="box")
    return ax


LEFTWARDS = ("50 particles",)
"""Filters whose names stand before their marks, where those of others are in the way."""


@drawn(
    name="world-who",
    alt="Scatter of filters by error of the path and share of the drive outside: Kalman filters "
    "low, particles high; the fewer, the higher.",
    caption="All filters on the same drives, start turned by 3°: crowds of particles, and the "
    "Kalman filter, plain, anchored, and with first estimates. Error of the path, and share of "
    "the drive at which the robot is outside the filter's 95 % region. Bars: 95 % over the "
    "drives. Dashed: 5 %, an honest filter. Dotted: the error of the best fit of all measurements.",
    height=4.0,
)
def who(ax: Axes, table: Table) -> Axes:
    """Draw the filters of a table by "path (m)" and "outside"; others have no "outside"."""
    for name in table.rows:
        path, outside = table[name, "path (m)"], table[name, "outside"]
        if outside is None or name == "ideal":  # which lies on that of first estimates
            continue
        colour = MEANING["robot"] if "particles" in name else MEANING[name]
        ax.plot([path.low, path.high], [outside.estimate] * 2, color=colour, linewidth=1.4)
        ax.plot([path.estimate] * 2, [outside.low, outside.high], color=colour, linewidth=1.4)
        ax.plot(path.estimate, outside.estimate, "o", color=colour, markersize=6)
        y = outside.estimate
        if name in LEFTWARDS:
            label(ax, path.low, y, f"{name}  ", colour, ha="right", va="center")
        else:
            label(ax, path.high, y, f"  {name}", colour, ha="left", va="center")
    ax.axhline(0.05, color=MEANING["expected"], linewidth=1.0, linestyle="--")
    floor = table["best fit of all", "path (m)"].estimate
    ax.axvline(floor, color=MEANING["expected"], linewidth=1.0, linestyle=":")
    ax.set(xlabel="error of the path (m)", ylabel="share of the drive outside")
    ax.set(xlim=(0.1, 1.9), ylim=(-0.03, 1.05))
    return ax


@drawn(
    name="world-witness",
    alt="Two panels: error of the position along the path with a band of two deviations. Taken for "
    "independent the error lies far above a band that is hardly to be seen; intersected it lies "
    "inside a wide band or just above it.",
    caption="One drive with landmarks that leave the state after fifty revisions. Their later "
    "readings are taken for independent in one drawing, and intersected in the other. Line: the "
    "error of the position. Band: two deviations (2σ), as the filter states them. The titles count "
    "how long the pose is outside its 95 % region, which reaches a little beyond the band.",
    rows=2,
    height=4.6,
    sharex=True,
)
def witnesses(axes: AxesRow, *found: Any) -> AxesRow:
    """Draw the errors of two drives with what the filters state, a panel each."""
    for ax, one in zip(axes, found, strict=True):
        heard(ax, one)
        ax.set_xlabel("")
    axes[-1].set_xlabel("driven (m)")
    return axes


def heard(ax: Axes, one: Any) -> Axes:
    """Draw the error along a path and the stated band, on axes cleared first."""
    ax.clear()
    along = np.linspace(0, one.length, len(one.off))
    band(ax, along, np.zeros(len(along)), one.stated, MEANING["robot"], alpha=0.2)
    ax.plot(along, one.off, color=MEANING["error"], linewidth=1.8)
    label(ax, 2.0, 1.25, "band: 2σ, as stated", MEANING["robot"])
    label(ax, 2.0, 0.9, "line: the error", MEANING["error"])
    ax.set(xlabel="driven (m)", ylabel="off (m)", ylim=(0, 1.6), xlim=(0, one.length))
    ax.set_title(f"{one.rule}: outside for {one.outside:.0%}")
    return ax


@drawn(
    name="world-names",
    alt="Error of the path against the number of wrong names, logarithmic. One Kalman filter leaps "
    "at the first wrong name; particles rise slowly, many above few; with a gate all stay level, "
    "the Kalman filter lowest.",
    caption="Median error of the path against the number of sightings, of some four hundred, "
    "that have a wrong name. M: number of particles. Solid: every name is believed. Dashed: names "
    "pass a gate. Dotted: the wheels alone, and the best fit with right names.",
    height=4.4,
    gridspec_kw={"right": 0.7},
)
def misnamed(ax: Axes, rows: Rows, ends: Rows) -> Axes:
    """Draw the median errors by the number of wrong names, between wheels and best fit."""
    counts, colours = rows.levels("count"), ("Kalman", "external", "robot")
    last = {}
    for name, meaning in zip(("Kalman", "10 particles", "200 particles"), colours, strict=True):
        for gate, style in (("", "o-"), (", gate", "o--")):
            off = [rows.median("path", filter=f"{name}{gate}", count=count) for count in counts]
            ax.plot(range(len(counts)), off, style, color=MEANING[meaning], markersize=4)
            last[f"{name}{gate}"] = off[-1], MEANING[meaning]
    for name, measure in (("wheels", "wheels"), ("best fit", "optimum")):
        off = ends.median(measure)
        ax.axhline(off, color=MEANING["expected"], linewidth=1.0, linestyle=":")
        last[name] = off, MEANING["expected"]
    low = 0.0
    for name, (off, colour) in sorted(last.items(), key=lambda one: one[1][0]):
        low = max(off, 1.28 * low)  # so that no label covers the one below
        short = name.replace("10 particles", "M = 10").replace("200 particles", "M = 200")
        label(ax, len(counts) - 0.85, low, short, colour, va="center")
    ax.set_yscale("log")
    ax.set_yticks([0.3, 1, 3, 10], ["0.3", "1", "3", "10"])
    ax.minorticks_off()
    ax.set_xticks(range(len(counts)), [f"{count}" for count in counts])
    ax.set_xlim(-0.25, len(counts) - 0.9)
    ax.set(xlabel="wrong names", ylabel="error of the path (m)")
    return ax


def walked(ax: Axes, found: Any) -> Axes:
    """Draw a path beside the true one among the posts, on axes cleared first."""
    ax.clear()
    ax.plot(*found.posts.T, "o", color=MEANING["truth"], markersize=3)
    ax.plot(*found.truth.T, color=MEANING["truth"], linewidth=1.0, linestyle="--")
    ax.plot(*found.path.T, color=MEANING["robot"], linewidth=1.6)
    ax.set_title(f"{found.filter}: {found.off:.2f} m off")
    ax.set(xlim=(-16, 36), ylim=(-14, 30), xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal", adjustable="box")
    return ax
