"""Drawings of the chapter: maps of the building, errors, consistency, and explorers."""

from collections.abc import Mapping, Sequence
from textwrap import fill
from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.maps import dots, lines, plan
from explorables.figures.style import MEANING, AxesRow, band, ellipses, label
from robot_perception.evaluation.consistency import average_bounds
from studies.tables import Table

Found = Any
"""Errors and NEES along a path, by filter, or what surveyed posts do: as the notebook makes them,
which stores them as dataclasses of its own."""


def tint(variant: str) -> str:
    """Return the colour of a filter; variants of the rule share one."""
    return MEANING.get(variant, MEANING["rule"])


def _line(variant: str) -> str:
    """Return the line of a filter: two variants of the rule share a colour."""
    return "--" if variant.startswith("considered") else "-"


# The building ------------------------------------------------------------------------------------


@drawn(
    name="loop-map",
    alt="Map of a ring of corridors. The corridors are bent, and at the end of the loop the "
    "robot draws the first corridor a second time beside the first one.",
    caption="One drive round a building of ours. Broad grey: the true floor. Blue: laser readings, "
    "placed where the filter believed the robot to be at that moment. Green: its landmarks at the "
    "end. Red: estimated path; dashed: the true one; magenta: the error at the end.",
    width=6.4,
    height=4.6,
)
def built_map(ax: Axes, built: SimpleNamespace) -> Axes:
    """Draw Fig. 7 again, on axes cleared first: readings and map over the plan, path, end error."""
    ax.clear()
    truth, path, error = built.truth, built.path, MEANING["error"]
    lines(ax, built.faces, MEANING["truth"], 3.0, alpha=0.25, zorder=0)
    dots(ax, built.readings, size=1.1)
    ax.plot(*built.landmarks.T, "o", color=MEANING["landmark"], markersize=3.5)
    ax.plot(*truth[:, :2].T, color=MEANING["truth"], linewidth=1.0, linestyle="--")
    ax.plot(*path[:, :2].T, color=MEANING["robot"], linewidth=1.6)
    ends = np.stack([truth[-1, :2], path[-1, :2]])
    ax.plot(*ends.T, color=error, linewidth=2.2)
    ax.plot(*ends[1], "o", color=error, markersize=5)
    ax.plot(*built.anchors.T, "P", color=MEANING["anchor"], markersize=9)
    ax.set_title(f"{built.off:.2f} m off, {built.twice} landmarks twice")
    plan(ax, built.faces.reshape(-1, 2), margin=4.0)
    ax.locator_params(nbins=5)
    return ax


@drawn(
    name="loop-ends",
    alt="Position error at the loop end, logarithmic. With names unknown plain and anchored lie "
    "on top of each other above a metre and the external sensor at a decimetre; with names known "
    "all are at a few centimetres.",
    caption="Error at the loop end over fifty drives with large noise and an exact start: mean and "
    "95 % bootstrap interval. The axis is logarithmic.",
    rows=2,
    width=5.6,
    height=5.0,
    gridspec_kw={"left": 0.42},
)
def end_errors(axes: Sequence[Axes] | np.ndarray, studies: Mapping[str, Table]) -> AxesRow:
    """Draw the column "end (m)" of tables, by title, as dots with intervals, a panel each."""
    ends = {
        title: {name: table[name, "end (m)"] for name in table.rows}
        for title, table in studies.items()
    }
    values = [end for rows in ends.values() for end in rows.values()]
    low, high = 0.7 * min(v.low for v in values), 1.4 * max(v.high for v in values)
    ticks = [t for t in (0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10) if low <= t <= high]
    for ax, (title, rows) in zip(axes, ends.items(), strict=True):
        for k, (name, end) in enumerate(rows.items()):
            ax.plot([end.low, end.high], [k, k], color=tint(name), linewidth=2.4)
            ax.plot(end.estimate, k, "o", color=tint(name), markersize=7)
        ax.set_yticks(range(len(rows)), list(rows))
        ax.set_xscale("log")
        ax.set(xlim=(low, high), ylim=(len(rows) - 0.5, -0.5))
        ax.set_xticks(ticks, [f"{t:g}" for t in ticks])
        ax.minorticks_off()
        ax.set_title(title)
    axes[-1].set_xlabel("error at the loop end (m)")
    return axes


# The posts ---------------------------------------------------------------------------------------


def _places(steps: int) -> np.ndarray:
    """Return the steps of a drive at which curves are drawn."""
    return np.linspace(1, steps - 1, 60).astype(int)


@drawn(
    name="loop-nees",
    alt="Average NEES along the path: plain and anchored filters leave the grey band, "
    "first estimates and the ideal filter stay in it or near it.",
    caption="Average NEES of fifty drives along the path, logarithmic; grey: where 95 % of such "
    "averages lie if the filter is right. Who leaves the band, and when?",
    height=3.8,
    gridspec_kw={"right": 0.68},
)
def nees_along(ax: Axes, found: Found, most: float = 0.0, least: float = 1.5) -> Axes:
    """Draw the average NEES of the pose along the path and its 95 %, on axes from ``least``.

    They reach up to ``most`` or to the largest value.
    """
    # logarithms on a plain axis: a logarithmic one takes twice as long to draw
    low, high = average_bounds(3, found.runs)
    at = _places(1 + len(next(iter(found.nees.values()))))
    along, nees = found.step * at, {name: v[at - 1] for name, v in found.nees.items()}
    band(ax, along[[0, -1]], *np.log10([[low, low], [high, high]]), MEANING["expected"])
    for name, values in nees.items():
        ax.plot(along, np.log10(values), color=tint(name), linestyle=_line(name))
    top = max(most, max(v.max() for v in nees.values()), 2 * high)
    ticks = [t for t in (1, 3, 10, 30, 100, 300, 1000, 3000) if least < t < 1.4 * top]
    ax.set(xlim=(0, along[-1]), ylim=(np.log10(least), np.log10(1.4 * top)))
    ax.set(xlabel="path (m)", ylabel="average NEES")
    ax.set_yticks(np.log10(ticks), [str(t) for t in ticks])
    ax.locator_params(axis="x", nbins=4)
    _names(ax, {name: np.log10(values[-1]) for name, values in nees.items()})
    return ax


def _names(ax: Axes, ends: Mapping[str, float]) -> None:
    """Write each name, in short lines, at the right end of its curve, apart from the next."""
    low, high = ax.get_ylim()
    top = low
    for name, value in sorted(ends.items(), key=lambda item: item[1]):
        text = fill(name, 15)
        half = 0.0425 * (high - low) * (1 + 1.2 * text.count("\n"))
        place = max(value, top + half)
        end = 1.02 * ax.get_xlim()[1]
        label(ax, end, place, text, tint(name), fontsize=9, linespacing=1.5)
        top = place + half


@drawn(
    name="loop-rule",
    alt="Above, the errors along the path lie close together. Below, the average NEES with the "
    "rule climbs to several hundred after the first landmarks are frozen, the others stay near 3.",
    caption="The rule at fifty round the posts, eight runs. Above: root mean square error of the "
    "position. Below: average NEES, logarithmic; grey: the 95 % band if honest. Dashed: landmarks "
    "considered, not frozen.",
    rows=2,
    height=5.6,
    gridspec_kw={"right": 0.72},
)
def growth(
    axes: AxesRow, found: Found, reach: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> AxesRow:
    """Draw errors above and NEES below along the path, on two axes cleared first.

    The axes ``reach`` at least so far: path (m), error (m), NEES.
    """
    for ax in axes:
        ax.clear()
    at = _places(len(next(iter(found.rms.values()))))
    for name, values in found.rms.items():
        axes[0].plot(found.step * at, values[at], color=tint(name), linestyle=_line(name))
    far = max(reach[0], found.step * at[-1])
    top = 1.1 * max(reach[1], *(values[at].max() for values in found.rms.values()))
    axes[0].set(xlim=(0, far), ylim=(0, top))
    axes[0].set(xlabel="path (m)", ylabel="position error (m)")
    axes[0].locator_params(nbins=4)
    nees_along.on(axes[1], found, reach[2], 0.5)
    axes[1].set_xlim(0, far)
    return axes


def nailed(axes: AxesRow, found: Found) -> AxesRow:
    """Draw a state of the explorer of anchors: map with ellipses, and errors along the path."""
    for ax in axes:
        ax.clear()
    here, there = axes
    at = _places(len(found.rms))
    truth, robot, heading = MEANING["truth"], MEANING["robot"], MEANING["heading"]
    here.plot(*found.truth[:, :2].T, color=truth, linewidth=1.0, linestyle="--")
    here.plot(*found.posts.T, "o", color=truth, markersize=3)
    ellipses(here, found.centres, found.covs, robot)
    here.plot(*found.anchors.T, "P", color=MEANING["anchor"], markersize=10)
    plan(here, found.posts, margin=3.0)
    along, top = found.step * at, 1.8
    there.plot(along, found.rms[at], color=robot)
    there.plot(along, found.heading[at] / 10, color=heading)
    there.set(xlim=(0, along[-1]), ylim=(0, top), xlabel="path (m)", ylabel="error")
    there.set_title(f"over the whole drive {found.drive_error:.2f} m")
    for ax in axes:
        ax.locator_params(nbins=4)
    label(there, 0.02 * along[-1], 0.93 * top, "position (m)", robot)
    label(there, 0.02 * along[-1], 0.83 * top, "heading (10°)", heading)
    return axes


def moment(ax: Axes, found: SimpleNamespace) -> Axes:
    """Draw what a filter believes at one moment, with 2σ ellipses, on axes cleared first."""
    ax.clear()
    robot, truth = MEANING["robot"], MEANING["truth"]
    belief = found.belief
    ax.plot(*found.posts.T, "o", color=truth, markersize=3)
    ax.plot(*found.truth[:, :2].T, color=truth, linewidth=1.0, linestyle="--")
    ax.plot(*found.anchors.T, "P", color=MEANING["anchor"], markersize=9)
    ax.plot(*found.path[:, :2].T, color=robot, linewidth=1.6)
    ellipses(ax, belief.landmarks, belief.landmark_covs, MEANING["landmark"], width=1.1)
    ellipses(ax, found.path[-1:, :2], belief.pose_cov[None, :2, :2], robot, width=2.2)
    heading = np.degrees(found.path[-1, 2]) - 90
    ax.plot(*found.path[-1, :2], marker=(3, 0, heading), color=robot, markersize=9)
    ax.set_title(f"{found.way}: {found.along:.0f} m driven, {found.off:.2f} m off")
    ax.set(xlim=(-11, 30), ylim=(-7, 22), xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal", adjustable="box")
    ax.locator_params(nbins=5)
    return ax
