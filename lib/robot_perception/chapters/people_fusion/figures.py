"""Drawings of the chapter: whom the committee knows in the room, and its rates."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.style import MEANING, label
from robot_perception.chapters.people_sensors.figures import (
    NAMES,
    Room,
    floor,
    from_above,
    overlay,
    people,
    polar,
    rims,
)
from robot_perception.geometry import se2
from robot_perception.people.aggregation import Hypotheses
from robot_perception.people.trajectories import trajectories
from studies.intervals import Interval

OF_THE_PAPER = 0.25, 0.93
"""Share of the hypotheses that are false, and of the people who are tracked."""


def aggregated(
    ax: Axes, hypotheses: Hypotheses, least: float, nobody: Bool[np.ndarray, " n"] | None = None
) -> None:
    """Draw hypotheses as bent 2σ ellipses: the heavier the stronger, persons of a weight filled.

    Persons that are ``nobody`` have a cross in the middle, not a dot.
    """
    colour = MEANING["estimate"]
    shapes = rims(hypotheses.mean, hypotheses.cov)
    crossed = np.zeros(len(hypotheses), dtype=bool) if nobody is None else nobody
    parts = zip(shapes, hypotheses.mean, hypotheses.weight, crossed, strict=True)
    for shape, mean, weight, cross in parts:
        person = weight > least
        if person:
            ax.fill(*shape.T, color=colour, alpha=0.25 * weight, linewidth=0)
            mark, size = ("x", 10) if cross else ("o", 4)
            ax.plot(*polar(*mean), mark, color=colour, markersize=size)
        width = 0.6 + 2.4 * weight
        ax.plot(*shape.T, color=colour, linewidth=width, linestyle="-" if person else ":")


@drawn(
    name="people-together",
    alt="A floor plan of a room with three people around a robot: wedges of a camera, ellipses "
    "of laser and sonars, and over each person one red ellipse on which they agree.",
    caption="The moment with which the chapter before began. Green wedges, orange and blue "
    "ellipses: what camera, laser and sonars report, 2σ. Red: the persons that the committee knows "
    "of by then, 2σ. Discs A, B and C: the people.",
    width=5.0,
    height=5.0,
)
def together(ax: Axes, scene: Any, persons: Hypotheses) -> Axes:
    """Draw all in one: people, the three sensors, and the persons they agree on."""
    aggregated(overlay(ax, scene, NAMES), persons, 0.0)
    return ax


@drawn(
    name="people-ways",
    alt="Paths around a robot: broad grey ones of three people, and thin red ones that follow "
    "them in pieces.",
    caption="Half a minute. Broad lines: the true paths of the people. Thin lines: the paths of "
    "hypotheses that count as persons, with a dot where one ends. A dot without a line: a "
    "hypothesis that hardly moved.",
    width=5.0,
    height=5.0,
)
def ways(ax: Axes, run: Any, room: Room) -> Axes:
    """Draw the ways of all persons, those who were static at last with a square, and the truth."""
    ax.clear()
    told = run.told
    start = se2.inverse(told.poses[0])
    floor(ax, room, 0.4)
    for way in np.moveaxis(told.places, 1, 0):
        ax.plot(*from_above(way).T, color=MEANING["truth"], linewidth=3.0, alpha=0.3)
    rows, persons, static = zip(*run.persons(), strict=True)
    still = {
        one
        for known, stays in zip(persons, static, strict=True)
        for one in known.identity[stays].tolist()
    }
    for way in trajectories(persons, told.poses[told.judged[list(rows)]]):
        points = from_above(se2.act(start, way.points))
        stays = way.identity in still
        colour = MEANING["wrong" if stays else "estimate"]
        ax.plot(*points.T, color=colour, linewidth=1.3)
        ax.plot(*points[-1], "s" if stays else "o", color=colour, markersize=5)
    return ax


Shares = Mapping[str, tuple[Interval, Interval]]
"""Shares of the people who are tracked, and of the hypotheses that are false, by name."""


@drawn(
    name="people-rooms",
    alt="Five rows, each with two dots: the share of hypotheses that are false, and that of the "
    "people who are tracked. Without table legs, wood and cork the first falls below the paper's "
    "line; the second rises where people who stop look at the robot, and stays below the paper's.",
    caption="The same system, with one thing about range, rooms or people changed at a time, and "
    "in the last row three of them. The smaller share of each row: hypotheses that are false. The "
    "larger: people who are tracked. Bars: 95 % over forty sessions. Dotted: the paper's two "
    "numbers.",
    height=4.2,
)
def rooms(ax: Axes, shares: Shares) -> Axes:
    """Draw what each change does to both shares."""
    for x, column in zip(OF_THE_PAPER, ("false", "tracked"), strict=True):
        ax.axvline(x, color=MEANING["paper"], linewidth=1.4, linestyle=":")
        label(ax, x - 0.01, -0.8, f"{column}: {x:.0%}", MEANING["paper"], ha="right")
    for row, (name, (tracked, false)) in enumerate(shares.items()):
        for share, meaning in ((false, "wrong"), (tracked, "right")):
            colour = MEANING[meaning]
            ax.plot([share.low, share.high], [row, row], color=colour, linewidth=1.8)
            ax.plot(share.estimate, row, "o", color=colour, markersize=6)
        label(ax, 0.01, row - 0.38, name, MEANING["world"])
    ax.set(xlim=(0, 1), ylim=(len(shares) - 0.5, -1.2), xlabel="share", yticks=[])
    return ax


def _paper(ax: Axes) -> None:
    """Mark the paper's two numbers, and make the axes of shares."""
    colour = MEANING["paper"]
    ax.plot(*OF_THE_PAPER, "D", color=colour, markersize=8)
    label(ax, OF_THE_PAPER[0], 0.972, "the paper", colour, ha="center")
    ax.set(xlim=(0, 0.6), ylim=(0.4, 1.01))
    ax.set(xlabel="hypotheses: share false", ylabel="people: share tracked")


# Explorers ---------------------------------------------------------------------------------------


def committee_at(ax: Axes, now: Any) -> Axes:
    """Draw the hypotheses of some sensors at a moment over the truth, on axes cleared first."""
    ax.clear()
    floor(ax, now.scene.room, 0.5)
    gone = zip(NAMES, now.missed, strict=False)
    words = [f"{name}?" if missed else name for name, missed in gone]
    people(ax, now.scene, strong=False, words=words)
    aggregated(ax, now.hypotheses, now.least, now.nobody)
    ax.set_title(f"{now.who}: {len(now.missed) - now.missed.sum()} of 3 found")
    return ax


def rules(ax: Axes, now: tuple[float, float], every: Sequence[tuple[float, float]]) -> Axes:
    """Draw the shares tracked and false under a choice of the rules, on axes cleared first."""
    ax.clear()
    tracked, false = np.array(every).T
    ax.plot(false, tracked, "o", color=MEANING["expected"], markersize=2.5)
    _paper(ax)
    ax.plot(now[1], now[0], "o", color=MEANING["estimate"], markersize=10)
    label(ax, now[1] + 0.03, now[0], "here", MEANING["estimate"])
    return ax
