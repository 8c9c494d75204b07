"""Drawings of the chapter: what sensors see, the film of a day, the ledger, the worth of systems.

What they draw is made in the notebook: dictionaries of arrays, and shares by name.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from explorables.figures import drawn, figure, film
from explorables.figures.maps import lines, picture
from explorables.figures.style import MEANING, label
from explorables.media import Shown
from robot_perception.geometry import se2
from studies.intervals import Interval

FPS = 4
ASKED = {
    "learn": ("stereo SLAM, walls,", "mosaic of the ceiling"),
    "find": ("Monte Carlo localisation",),
    "hall": ("key images of the ceiling",),
    "guide": ("laser, sonars, fisheye;", "the ceiling for the pose"),
    "tutor": ("face and link",),
    "follow": ("hand; head and trunk",),
    "halt": ("open hand",),
    "point": ("two arms",),
    "go": ("key images of the ceiling",),
}
"""Systems that are asked in an act, in two lines."""
_AHEAD = 0.6  # length of the line that says where a robot looks, m
_SHOWN = (1.5, 20.5, -0.4, 3.2)  # of the corridor: low and high x, low and high y, m
_TURN = np.linspace(0, 2 * np.pi, 25)
_VIEWS = {"left": 0.01, "right": 0.99, "bottom": 0.02, "top": 0.93, "wspace": 0.06, "hspace": 0.16}


@drawn(
    name="day-views",
    rows=2,
    cols=3,
    alt="Six views from one place of a corridor: a grey and a coloured picture with doors and "
    "posters, a painted ceiling with lamps, a round fisheye picture, a plan with the points of a "
    "laser along the walls, and one with the sectors of sonars.",
    caption="What each sensor reports from one place of the floor. Grey and coloured pictures: the "
    "left eye of the stereo pair, the camera ahead, the camera above, the fisheye. Plans: walls "
    "(green), the robot (red), and what laser and sonars measure (blue).",
    width=6.8,
    height=4.2,
    gridspec_kw=_VIEWS,
)
def views(axes: Sequence[Axes], seen: Mapping[str, Any]) -> Sequence[Axes]:
    """Draw what each sensor reports from one place."""
    flat = np.ravel(axes)
    for ax, name in zip(flat[:4], ("left eye", "ahead", "above", "fisheye"), strict=True):
        picture(ax, seen[name])
        ax.set_title(name)
    for ax, name, reach in zip(flat[4:], ("laser", "echoes"), (8.0, 3.0), strict=True):
        lines(ax, seen["walls"], MEANING["walls"], 1.0)
        bearings = np.linspace(*_spans(name), len(seen[name]))
        heard = np.isfinite(seen[name])
        ends = se2.act(seen["place"], _polar(seen[name][heard], bearings[heard]))
        ax.plot(*ends.T, "o", color=MEANING["readings"], markersize=1.5 if name == "laser" else 4)
        _robot(ax, seen["place"], MEANING["robot"])
        x, y = seen["place"][:2]
        ax.set(xlim=(x - reach / 2, x + reach), ylim=(y - reach / 2, y + reach / 2))
        ax.set_aspect("equal")
        ax.set_xticks([])
        ax.set_yticks([])
        ax.set_title("sonars" if name == "echoes" else name)
    return axes


def _spans(name: str) -> tuple[float, float]:
    """Return the first and the last direction of a sensor that measures ranges, rad."""
    return (-np.pi / 2, np.pi / 2) if name == "laser" else (-np.pi, np.pi * 7 / 8)


def _polar(ranges: np.ndarray, bearings: np.ndarray) -> np.ndarray:
    return np.column_stack([ranges * np.cos(bearings), ranges * np.sin(bearings)])


def _robot(ax: Axes, pose: np.ndarray, colour: str, **kwargs: object) -> None:
    """Draw a robot as a circle with a line ahead."""
    x, y, heading = pose
    ax.plot(x + 0.25 * np.cos(_TURN), y + 0.25 * np.sin(_TURN), color=colour, **kwargs)
    ax.plot(
        [x, x + _AHEAD * np.cos(heading)],
        [y, y + _AHEAD * np.sin(heading)],
        color=colour,
        **kwargs,
    )


def film_of(told: Mapping[str, Any], name: str | None = "day-film") -> Shown:
    """Show a day as a film: what the task's camera shows, the plan from above, and words."""
    failed = [act for act, right, _ in told["ends"] if not right]
    end = f"It needs help after: {', '.join(failed)}." if failed else "It needs no help."
    return film(
        frames(told),
        fps=FPS,
        name=name,
        poster=_poster(told),
        alt="A corridor from above, in which a robot goes to and fro, and a red one, where "
        "it takes itself to be, stays on it; above, what its camera shows: posters, the ceiling, "
        "people round it, a tutor who raises a hand and points. Words say act and state.",
        caption="A day of the robot, in nine acts. Picture: from the camera that the act uses. "
        "Plan: the corridor from above, with the robot, where it takes itself to be (red), and "
        f"people (blue). {end}",
    )


def _poster(told: Mapping[str, Any]) -> int:
    """Return the moment at which the robot has followed its tutor for a while."""
    follows = [k for k, act in enumerate(told["act"]) if act == "follow"]
    return follows[2 * len(follows) // 3] if follows else len(told["act"]) // 2


def frames(told: Mapping[str, Any]) -> Iterator[Figure]:
    """Yield the frames of the film, all drawn on one figure."""
    fig, (eye, words, above) = figure(1, 3, width=6.4, height=4.2)
    for ax, place in zip(
        (eye, words, above),
        ((0.02, 0.44, 0.42, 0.54), (0.47, 0.44, 0.5, 0.54), (0.02, 0.03, 0.96, 0.34)),
        strict=True,
    ):
        ax.set_position(place)
    first = np.concatenate([[0], np.cumsum(told["sizes"])])
    for k, (time, act) in enumerate(zip(told["time"], told["act"], strict=True)):
        shown = cv2.imdecode(told["jpeg"][first[k] : first[k + 1]], cv2.IMREAD_COLOR)
        eye.clear()
        picture(eye, shown[..., ::-1])
        eye.set_axis_off()
        words.clear()
        words.set_axis_off()
        words.set(xlim=(0, 1), ylim=(0, 1))
        minutes, seconds = divmod(int(time), 60)
        label(words, 0.0, 0.86, f"{minutes}:{seconds:02d}   act: {act}", MEANING["truth"])
        label(words, 0.0, 0.66, told["words"][k], MEANING["estimate"])
        for line, text in enumerate(ASKED[act]):
            label(words, 0.0, 0.44 - 0.16 * line, text, MEANING["expected"])
        corridor(above, told["walls"])
        there = told["people"][k]
        above.plot(*there.T, "o", color=MEANING["readings"], markersize=7)
        _robot(above, told["robot"][k], MEANING["truth"], linewidth=2.0)
        _robot(above, told["believed"][k], MEANING["estimate"], linewidth=1.2)
        yield fig


def corridor(ax: Axes, walls: np.ndarray) -> Axes:
    """Draw the corridor from above, on axes cleared first."""
    ax.clear()
    lines(ax, walls, MEANING["walls"], 1.0)
    low, high, south, north = _SHOWN
    ax.set(xlim=(low, high), ylim=(south, north))
    ax.set_aspect("equal")
    ax.set_axis_off()
    return ax


@drawn(
    name="day-ledger",
    alt="A row for each act, a column for each day: most squares are green, those of acts whose "
    "goals were missed are red, some are left empty where the act could not be tried.",
    caption="Acts and days. Green squares: the goal was reached; red crosses: it was missed, and "
    "somebody helped; empty: not tried. Behind each line: on how many of the days on which it was "
    "tried the goal was reached.",
    width=6.6,
    height=3.6,
)
def ledger(ax: Axes, found: np.ndarray, acts: Sequence[str]) -> Axes:
    """Draw which acts of which days reached their goals (acts, days); NaN where not tried."""
    for k, row in enumerate(found):
        good, bad = np.flatnonzero(row == 1), np.flatnonzero(row == 0)
        ax.plot(good, np.full(len(good), k), "s", color=MEANING["agreement"], markersize=11)
        ax.plot(bad, np.full(len(bad), k), "X", color=MEANING["estimate"], markersize=10)
        ax.text(found.shape[1] - 0.2, k, f"{len(good)} of {np.isfinite(row).sum()}", va="center")
    ax.set_yticks(range(len(acts)), acts)
    ax.set(ylim=(len(acts) - 0.5, -0.5), xlim=(-0.6, found.shape[1] + 4.5), xlabel="day")
    ax.set_xticks(range(0, found.shape[1], 5), range(1, found.shape[1] + 1, 5))
    ax.grid(visible=False)
    return ax


@drawn(
    name="day-worth",
    alt="For each of eight systems two dots with intervals: the share of the days with what asks "
    "it, above with the system, below without it.",
    caption="Share of the first five days on which all acts that use a system reach their goals: "
    "with the system (filled) and without it (open), with 95 % intervals over days.",
    width=6.4,
    height=4.2,
    gridspec_kw={"left": 0.25, "right": 0.97, "bottom": 0.14, "top": 0.97},
)
def worth(ax: Axes, found: Mapping[str, tuple[Interval, Interval, int]]) -> Axes:
    """Draw the share of good days with and without each system."""
    for k, (with_it, without, _) in enumerate(found.values()):
        for at, of, meaning, face in (
            (k - 0.14, with_it, "agreement", None),
            (k + 0.14, without, "estimate", "none"),
        ):
            colour = MEANING[meaning]
            ax.plot([of.low, of.high], [at, at], color=colour, linewidth=1.2)
            ax.plot(of.estimate, at, "o", color=colour, markersize=7, markerfacecolor=face)
    has, lacks = (of.estimate for of in next(iter(found.values()))[:2])
    label(ax, has, -0.42, "with it", MEANING["agreement"], ha="right" if has > 0.5 else "left")
    label(ax, lacks, 0.5, "without", MEANING["estimate"], ha="right" if lacks > 0.5 else "left")
    ax.set_yticks(range(len(found)), list(found))
    ax.set(ylim=(len(found) - 0.5, -0.8), xlim=(-0.03, 1.03), xlabel="share of the days")
    return ax


def blinded(ax: Axes, now: Any) -> Axes:
    """Draw the way of a robot that lacks a system, and where it took itself to be."""
    corridor(ax, now.walls).set_position((0.01, 0.01, 0.98, 0.86))
    for part in np.unique(now.steps[:, 0]):
        some = now.steps[now.steps[:, 0] == part]
        ax.plot(*some[:, 1:3].T, color=MEANING["truth"], linewidth=2.0)
        ax.plot(*some[:, 3:5].T, color=MEANING["estimate"], linewidth=1.4, linestyle="--")
        ax.plot(*some[-1, 1:3], "o", color=MEANING["truth"], markersize=6, clip_on=False)
        ax.plot(*some[-1, 3:5], "X", color=MEANING["estimate"], markersize=8, clip_on=False)
    good = sum(right for _, right, _ in now.ends)
    ax.set_title(f"{good} of {len(now.ends)} acts reach their goals")
    missed = [why for _, right, why in now.ends if not right]
    colour = MEANING["estimate"]
    ax.text(0, -0.1, "\n".join(missed), transform=ax.transAxes, va="top", color=colour)
    return ax
