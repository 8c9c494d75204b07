"""Figures of the chapter "Which landmark is this?"."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from robot_perception.chapters.sift_association import table1
from robot_perception.chapters.sift_association.explorers import View
from robot_perception.chapters.sift_association.hero import Hero
from robot_perception.chapters.sift_association.recordings import Chosen, Pair
from robot_perception.chapters.sift_association.threshold import Curve
from robot_perception.evaluation.intervals import Interval
from robot_perception.teaching.figures.style import MEANING, ImageAxes, label
from robot_perception.teaching.tables import Table

FREE_ROWS = 100.0
"""So many rows are no rule, px."""

FARTHEST = 350.0
"""Largest distance on the axes, of descriptors whose length is 512."""


def tint(model: str) -> str:
    """Return the colour of what decides; with the log-determinant it is that without."""
    return MEANING[model.partition(",")[0]]


def _line(model: str) -> str:
    return "--" if "," in model else "-"


# Pictures ----------------------------------------------------------------------------------------


def hero(ax: ImageAxes, found: Hero) -> ImageAxes:
    """Draw features of the right picture, and which of the left one Euclid takes them for.

    Every sixth pair has its line: all of them would hide the pictures.
    """
    ax.clear()
    for k, (here, there, right) in enumerate(
        zip(found.here, found.there, found.right, strict=True)
    ):
        ends, colour = np.stack([there, here]).T, MEANING["right" if right else "wrong"]
        ax.plot(*ends, "o", color=colour, markersize=2.5)
        if k % 6 == 0:
            ax.plot(*ends, color=colour, linewidth=0.9)
    return ax


def view(ax: ImageAxes, found: View) -> ImageAxes:
    """Draw the features that are found again, the larger the farther their descriptors moved."""
    ax.clear()
    near = found.distances <= 200
    for rows, name in ((near, "right"), (~near, "wrong")):
        sizes = (2 + found.distances[rows] / 30) ** 2
        at = found.pixels[rows].T
        ax.scatter(*at, sizes, facecolors="none", edgecolors=MEANING[name], linewidths=1.4)
    return ax


def pair(ax: ImageAxes, seen: Pair, found: Chosen) -> ImageAxes:
    """Draw each match from where it is left to where it is right, right and wrong ones."""
    ax.clear()
    ax.plot(*seen.pixels[found.others < 0].T, ".", color=MEANING["expected"], markersize=2)
    for right, name in ((True, "right"), (False, "wrong")):
        rows = np.flatnonzero((found.others >= 0) & (found.right == right))
        ends = np.full((len(rows), 3, 2), np.nan)  # one line with gaps: hundreds take a second
        ends[:, 0], ends[:, 1] = seen.pixels[rows], seen.others[found.others[rows]]
        ax.plot(*ends.reshape(-1, 2).T, color=MEANING[name], linewidth=0.9)
        ax.plot(*seen.pixels[rows].T, "o", color=MEANING[name], markersize=3)
    return ax


# Distances ---------------------------------------------------------------------------------------


def distance_by_angle(ax: Axes, table: Table, other: Interval, alike: Interval) -> Axes:
    """Draw the distance of a point's descriptors against the viewpoint, and what it meets."""
    angles = np.array([float(name.rstrip("°")) for name in table.rows])
    cells = [table[name, "distance"] for name in table.rows]
    ax.fill_between(
        angles,
        [c.low for c in cells],
        [c.high for c in cells],
        color=MEANING["readings"],
        alpha=0.2,
        linewidth=0,
    )
    ax.plot(angles, [c.estimate for c in cells], "o-", color=MEANING["readings"], markersize=4)
    for value, name, text in (
        (other, "truth", "nearest other landmark"),
        (alike, "look-alike", "look-alike, same viewpoint"),
    ):
        ax.axhline(value.estimate, color=MEANING[name], linestyle="--", linewidth=1.2)
        label(ax, 59, value.estimate + 8, text, MEANING[name], ha="right")
    ax.set(xlabel="viewpoint (°)", ylabel="distance of descriptors", xlim=(0, 60))
    ax.set(ylim=(0, FARTHEST))
    return ax


def right_by_rules(ax: Axes, table: Table, drawn: Mapping[str, str]) -> Axes:
    """Draw the share of right matches by threshold, a line for some numbers of rows."""
    thresholds = [float(name) for name in table.columns]
    for rows, colour in drawn.items():
        cells = [table[rows, name] for name in table.columns]
        values = [100 * cell.estimate for cell in cells]
        ax.plot(range(len(thresholds)), values, "o-", color=MEANING[colour], markersize=4)
        free = float(rows) >= FREE_ROWS
        place = {"va": "top", "ha": "right"} if free else {"va": "bottom", "ha": "left"}
        text = "any row" if free else f"±{rows} rows"
        label(ax, len(thresholds) / 2, values[len(values) // 2], text, MEANING[colour], **place)
    names = [f"{t:g}" for t in thresholds[:-1]] + ["none"]
    ax.set_xticks(range(len(thresholds)), names)
    ax.set(xlabel="threshold of the descriptors", ylabel="right matches (%)")
    ax.set(xlim=(-0.3, len(thresholds) - 0.7), ylim=(80, 100))
    return ax


def gains(axes: np.ndarray, table: Table, titles: Mapping[str, str]) -> np.ndarray:
    """Draw what estimates of the variance gain over Euclid by tracked frames, a panel for each end
    of the names of rows.
    """
    tracked = [int(name.removeprefix("p = ")) for name in table.columns]
    for ax, (end, title) in zip(axes, titles.items(), strict=True):
        ax.axhline(0, color=MEANING["Euclid"], linewidth=1.0)
        for name in (table1.RAW, "shrunk", "pooled"):
            cells = [table[f"{name}, {end}", column] for column in table.columns]
            lows, highs = [c.low for c in cells], [c.high for c in cells]
            ax.fill_between(tracked, lows, highs, color=tint(name), alpha=0.2, linewidth=0)
            ax.plot(tracked, [c.estimate for c in cells], "o-", color=tint(name), label=name)
        ax.set(xlabel="tracked frames p", ylabel="points over Euclid", xlim=(0, 32))
        ax.set(ylim=(-30, 5))
        ax.set_title(title)
    axes[0].legend(loc="lower right")
    return axes


def own_distance(ax: Axes, measured: Mapping[int, float], law: Mapping[int, float]) -> Axes:
    """Draw the mean L of the right class by tracked frames, measured and by the law."""
    for values, name, text in ((measured, "raw", "measured"), (law, "expected", "law")):
        finite = {p: v for p, v in values.items() if np.isfinite(v)}
        ax.plot(list(finite), list(finite.values()), "o-", color=MEANING[name], label=text)
    ax.axhline(128, color=MEANING["truth"], linewidth=1.0, linestyle=":")
    ax.set_yscale("log")
    ax.set(xlabel="tracked frames p", ylabel="mean L of the right class", xlim=(0, 32))
    ax.legend()
    return ax


# Table 1 -----------------------------------------------------------------------------------------


def table_state(axes: np.ndarray, p: int, model: str, right: Table, alike: Table) -> np.ndarray:
    """Draw the errors of Euclid and of a model, and the share of right ones over tracked frames."""
    above, below = axes
    for ax in axes:
        ax.clear()
    column = f"p = {p}"
    drawn = {"first views": table1.ONE_VIEW, "means": table1.EUCLID, "variances": model}
    for k, name in enumerate(drawn.values()):
        like = alike[name, column].estimate
        other = 100 - right[name, column].estimate - like
        above.barh(k, like, color=MEANING["look-alike"], height=0.6)
        above.barh(k, other, left=like, color=MEANING["wrong"], height=0.6)
    for k, (name, text) in enumerate({"look-alike": "a look-alike", "wrong": "another"}.items()):
        label(above, 49, k, text, MEANING[name], ha="right", va="center")
    above.set_yticks(range(len(drawn)), list(drawn))
    above.set(xlim=(0, 50), ylim=(2.6, -0.6), xlabel="assigned wrong (%)")
    for name in dict.fromkeys((*right.rows, table1.ONE_VIEW, table1.EUCLID, model)):
        mine = name in drawn.values()
        values = [right[name, f"p = {q}"].estimate for q in table1.TRACKED]
        below.plot(
            table1.TRACKED,
            values,
            "--" if name == table1.ONE_VIEW else "-",
            color=tint(name) if mine else MEANING["expected"],
            linewidth=2.2 if mine else 0.8,
            zorder=3 if mine else 1,
        )
    below.plot(p, right[model, column].estimate, "o", color=tint(model), markersize=8, zorder=4)
    below.set(xlim=(0, 32), ylim=(50, 100.5), xlabel="tracked frames p", ylabel="right (%)")
    return axes


# A new landmark ----------------------------------------------------------------------------------


def new_landmarks(ax: Axes, curves: Mapping[str, Curve]) -> Axes:
    """Draw precision against recall of "new landmark"."""
    for name, curve in curves.items():
        ax.plot(100 * curve.recall, 100 * curve.precision, color=tint(name), label=name)
        best = curve.best
        ax.plot(100 * curve.recall[best], 100 * curve.precision[best], "o", color=tint(name))
    ax.set(xlabel="recall of new landmarks (%)", ylabel="precision (%)")
    ax.set(xlim=(0, 100), ylim=(40, 100))
    ax.legend()
    return ax
