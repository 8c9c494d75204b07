"""Figures of the chapter "Which landmark is this?"."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robot_perception.chapters.sift_association import table1
from robot_perception.chapters.sift_association import variances as law
from robot_perception.chapters.sift_association.hero import Hero
from robot_perception.chapters.sift_association.recordings import Chosen, Pair
from robot_perception.chapters.sift_association.threshold import Curve
from robot_perception.chapters.sift_association.viewpoint import View
from robot_perception.evaluation.intervals import Interval
from robot_perception.teaching.figures import drawn
from robot_perception.teaching.figures.style import MEANING, ImageAxes, band, image_axes, label
from robot_perception.teaching.tables import Table

ENDS = {
    table1.TESTS["again"]: "the viewpoints of the track",
    table1.TESTS["aside"] + table1.STRAIGHT: "straight on, then aside",
}
"""Panels of the gains: how names of the table's rows end, and titles."""


def tint(model: str) -> str:
    """Return the colour of what decides; with the log-determinant it is that without."""
    return MEANING[model.partition(",")[0]]


def _estimates(ax: Axes, x: np.ndarray, cells: list[Interval], name: str, **kwargs: Any) -> None:
    """Draw estimates with the band of their intervals, in the colour of a name."""
    lows, highs = (np.array([getattr(c, end) for c in cells]) for end in ("low", "high"))
    band(ax, x, lows, highs, MEANING[name], alpha=0.2)
    ax.plot(x, [c.estimate for c in cells], "o-", color=MEANING[name], **kwargs)


@drawn(
    name="sift-rooms",
    alt="Two camera pictures side by side: rooms with the same windows and cabinets. Lines join "
    "points of the right picture with points of the left one.",
    caption="Two rooms of our building, as the robot's left eye sees them. A line joins a point of "
    "the second room with the point of the first whose descriptor is nearest to its own; dots: all "
    "such points, every sixth with its line.",
    axes=lambda found: image_axes(found.image),
)
def hero(ax: ImageAxes, found: Hero) -> None:
    """Draw features of the right picture, and which of the left one Euclid takes them for."""
    ax.clear()
    lines = np.stack([found.there, found.here], axis=2)
    for k, (ends, right) in enumerate(zip(lines, found.right, strict=True)):
        colour = MEANING["right" if right else "wrong"]
        ax.plot(*ends, "o", color=colour, markersize=2.5)
        if k % 6 == 0:  # all lines would hide the pictures
            ax.plot(*ends, color=colour, linewidth=0.9)


def view(found: View) -> Figure:
    """Draw the features that are found again, the larger the farther their descriptors moved."""
    fig, ax = image_axes(found.image)
    near = found.distances <= 200
    for rows, name in ((near, "right"), (~near, "wrong")):
        sizes = (2 + found.distances[rows] / 30) ** 2
        at = found.pixels[rows].T
        ax.scatter(*at, sizes, facecolors="none", edgecolors=MEANING[name], linewidths=1.4)
    return fig


@drawn(
    name="sift-graf",
    alt="A painted wall with lines from features to where their matches lie in the other "
    "photograph, most of them right.",
    caption="Lowe's ratio of 0.8 on the wall. Each line leads to the place of the match in the "
    "other photograph; green: right within 2 px.",
    axes=lambda seen, found: image_axes(seen.first),
)
def matches(ax: ImageAxes, seen: Pair, found: Chosen) -> None:
    """Draw each match from where it is left to where it is right, right and wrong ones."""
    ax.clear()
    ax.plot(*seen.pixels[found.others < 0].T, ".", color=MEANING["expected"], markersize=2)
    for right, name in ((True, "right"), (False, "wrong")):
        rows = np.flatnonzero((found.others >= 0) & (found.right == right))
        ends = np.full((len(rows), 3, 2), np.nan)  # one line with gaps: hundreds take a second
        ends[:, 0], ends[:, 1] = seen.pixels[rows], seen.others[found.others[rows]]
        ax.plot(*ends.reshape(-1, 2).T, color=MEANING[name], linewidth=0.9)
        ax.plot(*seen.pixels[rows].T, "o", color=MEANING[name], markersize=3)


@drawn(
    name="sift-angle",
    alt="Distance between the descriptors of one point against the viewpoint: it rises from the "
    "level of look-alikes at 0 degrees to that of other landmarks near 60 degrees.",
    caption="Mean distance between the descriptors of one point, seen from straight ahead and "
    "from the side; a descriptor has length 512. Band: 95 % interval over sets of pictures.",
    height=3.8,
)
def distance_by_angle(ax: Axes, table: Table, other: Interval, alike: Interval) -> None:
    """Draw the distance of a point's descriptors against the viewpoint, and what it meets."""
    angles = np.array([float(name.rstrip("°")) for name in table.rows])
    cells = [table[name, "distance"] for name in table.rows]
    _estimates(ax, angles, cells, "readings", markersize=4)
    for value, name, text in (
        (other, "truth", "nearest other landmark"),
        (alike, "look-alike", "look-alike, same viewpoint"),
    ):
        ax.axhline(value.estimate, color=MEANING[name], linestyle="--", linewidth=1.2)
        label(ax, 59, value.estimate + 8, text, MEANING[name], ha="right")
    ax.set(xlabel="viewpoint (°)", ylabel="distance of descriptors", xlim=(0, 60), ylim=(0, 350))


@drawn(
    name="sift-rules",
    alt="Share of right matches against the threshold: between 88 and 97 percent, falling with the "
    "threshold, and highest within two rows.",
    caption="Matches that are right, by threshold and number of rows, over ten buildings.",
    height=3.6,
)
def right_by_rules(ax: Axes, table: Table) -> None:
    """Draw the share of right matches by threshold, within two rows and within all."""
    *thresholds, _ = table.columns
    ticks = range(len(table.columns))
    for rows, text, colour, va, ha in (
        ("2", "±2 rows", "right", "bottom", "left"),
        ("240", "any row", "wrong", "top", "right"),
    ):
        values = [100 * table[rows, name].estimate for name in table.columns]
        ax.plot(ticks, values, "o-", color=MEANING[colour], markersize=4)
        middle = values[len(values) // 2]
        label(ax, len(values) / 2, middle, text, MEANING[colour], va=va, ha=ha)
    ax.set_xticks(ticks, [*thresholds, "none"])
    ax.set(xlabel="threshold of the descriptors", ylabel="right matches (%)")
    ax.set(xlim=(-0.3, len(ticks) - 0.7), ylim=(80, 100))


@drawn(
    name="sift-gains",
    alt="Points gained over the Euclidean distance to the means by tracked frames: raw variances "
    "rise from far below zero to near it, in the right panel they stay below; shrunk and pooled "
    "stay near zero.",
    caption="What the Mahalanobis distance gains over the Euclidean distance to the same means, on "
    "frames that made no class; bands: 95 % intervals over ten buildings.",
    cols=2,
    height=4.0,
)
def gains(axes: np.ndarray, table: Table) -> None:
    """Draw what estimates of the variance gain over Euclid by tracked frames, on two tests."""
    tracked = np.array([int(name.removeprefix("p = ")) for name in table.columns])
    for ax, (end, title) in zip(axes, ENDS.items(), strict=True):
        ax.axhline(0, color=MEANING["Euclid"], linewidth=1.0)
        for name in (table1.RAW, "shrunk", "pooled"):
            cells = [table[f"{name}, {end}", column] for column in table.columns]
            _estimates(ax, tracked, cells, name, label=name)
        ax.set(xlabel="tracked frames p", ylabel="points over Euclid", xlim=(0, 32), ylim=(-30, 5))
        ax.set_title(title)
    axes[0].legend(loc="lower right")


@drawn(
    name="sift-law",
    alt="Mean Mahalanobis distance of a descriptor to its own class against tracked frames, "
    "logarithmic: the measured one lies far above the law and falls with the number of frames.",
    caption="Mean distance L of a descriptor to its own class, logarithmic. Dotted: 128, its "
    "value if mean and variance were known.",
    height=3.6,
)
def own_distance(ax: Axes, table: Table) -> None:
    """Draw the mean L of the right class by tracked frames, measured and by the law."""
    tracked = np.array([int(name.removeprefix("p = ")) for name in table.rows])
    measured = [table[name, "measured"].estimate for name in table.rows]
    expected = np.array([law.expected_distance(int(p)) for p in tracked])
    finite = np.isfinite(expected)
    ax.plot(tracked, measured, "o-", color=MEANING["raw"], label="measured")
    ax.plot(tracked[finite], expected[finite], "o-", color=MEANING["expected"], label="law")
    ax.axhline(law.LENGTH, color=MEANING["truth"], linewidth=1.0, linestyle=":")
    ax.set_yscale("log")
    ax.set(xlabel="tracked frames p", ylabel="mean L of the right class", xlim=(0, 32))
    ax.legend()


def table_state(axes: np.ndarray, p: int, model: str, right: Table, alike: Table) -> None:
    """Draw the errors of Euclid and of a model, and the share of right ones over tracked frames."""
    above, below = axes
    for ax in axes:
        ax.clear()
    column, models = f"p = {p}", (table1.ONE_VIEW, table1.EUCLID, model)
    like, good = (np.array([t[name, column].estimate for name in models]) for t in (alike, right))
    above.barh(range(3), like, color=MEANING["look-alike"], height=0.6)
    above.barh(range(3), 100 - good - like, left=like, color=MEANING["wrong"], height=0.6)
    label(above, 49, 0, "a look-alike", MEANING["look-alike"], ha="right", va="center")
    label(above, 49, 1, "another", MEANING["wrong"], ha="right", va="center")
    above.set_yticks(range(3), ["first views", "means", "variances"])
    above.set(xlim=(0, 50), ylim=(2.6, -0.6), xlabel="assigned wrong (%)")
    for name in right.rows:
        mine = name in models
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


@drawn(
    name="sift-new",
    alt="Precision against recall of new landmarks for four distances.",
    caption="Precision, the share of the descriptors called new that are new, against recall, "
    "the share of the new ones that are called new, as the threshold moves. Dots: largest "
    "harmonic mean of the two.",
    height=3.8,
)
def new_landmarks(ax: Axes, curves: Mapping[str, Curve]) -> None:
    """Draw precision against recall of "new landmark"."""
    for name, curve in curves.items():
        ax.plot(100 * curve.recall, 100 * curve.precision, color=tint(name), label=name)
        best = curve.best
        ax.plot(100 * curve.recall[best], 100 * curve.precision[best], "o", color=tint(name))
    ax.set(xlabel="recall of new landmarks (%)", ylabel="precision (%)")
    ax.set(xlim=(0, 100), ylim=(40, 100))
    ax.legend()
