"""Figures of the chapter "Which landmark is this?"."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from explorables.figures import drawn
from explorables.figures.charts import curve
from explorables.figures.style import MEANING, ImageAxes, image_axes, label
from robot_perception.chapters.sift_association.recordings import Chosen, Pair
from studies.intervals import Interval
from studies.tables import Table


def tint(model: str) -> str:
    """Return the colour of what decides; with the log-determinant it is that without."""
    return MEANING[model.partition(",")[0]]


@drawn(
    name="sift-rooms",
    alt="Two camera pictures side by side: rooms with the same windows and cabinets. Lines join "
    "points of the right picture with points of the left one.",
    caption="Two rooms of our building, as the robot's left eye sees them. A line joins a point of "
    "the second room with the point of the first whose descriptor is nearest to its own; dots: all "
    "such points, every sixth with its line.",
    axes=lambda found: image_axes(found.image),
)
def hero(ax: ImageAxes, found: Any) -> None:
    """Draw features of the right picture, and which of the left one Euclid takes them for."""
    ax.clear()
    lines = np.stack([found.there, found.here], axis=2)
    for k, (ends, right) in enumerate(zip(lines, found.right, strict=True)):
        colour = MEANING["right" if right else "wrong"]
        ax.plot(*ends, "o", color=colour, markersize=2.5)
        if k % 6 == 0:  # all lines would hide the pictures
            ax.plot(*ends, color=colour, linewidth=0.9)


@drawn(
    name="sift-descriptor",
    alt="Three panels of one feature: a grey patch of 16 by 16 pixels; the same with an arrow for "
    "the gradient at each; and 4 by 4 cells, each with a star of eight rays, long where the "
    "arrows of the cell point.",
    caption="From a patch to 128 numbers. (a) What lies round one feature of the picture, turned "
    "upright. (b) Its gradients. (c) The descriptor: for each of 16 cells, how much "
    "gradient points in each of eight directions.",
    cols=3,
    width=7.4,
    height=2.7,
    gridspec_kw={"left": 0.01, "right": 0.99, "bottom": 0.02, "top": 0.9, "wspace": 0.08},
)
def descriptor(axes: np.ndarray, patch: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Draw a patch (18, 18), its gradients, and its descriptor (128,) as stars."""
    inner, turn = patch[1:-1, 1:-1], 2 * np.pi * np.arange(8) / 8
    u, v = (patch[1:-1, 2:] - patch[1:-1, :-2]), (patch[2:, 1:-1] - patch[:-2, 1:-1])
    longest, places = np.hypot(u, v).max(), np.arange(16)
    for ax, title in zip(axes, ("the patch", "its gradients", "128 numbers"), strict=True):
        ax.set(xlim=(-0.5, 15.5), ylim=(15.5, -0.5), aspect="equal", xticks=[], yticks=[])
        ax.grid(visible=False)
        ax.set_title(title)
    for ax, strength in zip(axes, (1.0, 0.35, 0.0), strict=True):
        if strength:
            ax.imshow(inner, cmap="gray", alpha=strength, interpolation="nearest")
    columns, rows = np.meshgrid(places, places)
    _rays(axes[1], columns, rows, 1.4 * u / longest, 1.4 * v / longest)
    cells = numbers.reshape(4, 4, 8) / numbers.max()
    for r, c in np.ndindex(4, 4):
        long = 2.1 * cells[r, c]
        _rays(axes[2], 4 * c + 1.5, 4 * r + 1.5, long * np.cos(turn), -long * np.sin(turn))
    for edge in (3.5, 7.5, 11.5):
        axes[2].axvline(edge, color=MEANING["expected"], linewidth=0.8)
        axes[2].axhline(edge, color=MEANING["expected"], linewidth=0.8)
    return axes


def _rays(ax: Axes, x: Any, y: Any, along: np.ndarray, down: np.ndarray) -> None:
    """Draw lines from places by so much, as one path."""
    ends = np.full((3, 2, along.size), np.nan)
    ends[0] = np.ravel(x + 0 * along), np.ravel(y + 0 * down)
    ends[1] = np.ravel(x + along), np.ravel(y + down)
    ax.plot(*np.moveaxis(ends, 0, -1).reshape(2, -1), color=MEANING["kept"], linewidth=1.2)


def view(found: Any) -> Figure:
    """Draw the features that are found again, the larger the farther their descriptors moved."""
    fig, ax = image_axes(found.image)
    near, all_sizes = found.distances <= 200, (2 + found.distances / 30) ** 2
    for rows, name in ((near, "right"), (~near, "wrong")):
        at, sizes = found.pixels[rows].T, all_sizes[rows]
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
    angles = [float(name.rstrip("°")) for name in table.rows]
    cells = [table[name, "distance"] for name in table.rows]
    curve(ax, angles, cells, MEANING["readings"])
    lines = ("truth", "nearest other landmark"), ("look-alike", "look-alike, same viewpoint")
    for value, (name, text) in zip((other, alike), lines, strict=True):
        ax.axhline(value.estimate, color=MEANING[name], linestyle="--", linewidth=1.2)
        label(ax, 59, value.estimate + 8, text, MEANING[name], ha="right")
    ax.set(xlabel="viewpoint (°)", ylabel="distance of descriptors", xlim=(0, 60), ylim=(0, 350))


@drawn(
    name="sift-invariant",
    alt="Three panels: the share of the features that are recognised against turn, nearness and "
    "light. SIFT loses a sixth by a turn, a third by the distance, and most in bright light; what "
    "lacks SIFT's remedy against the change falls to nearly nothing.",
    caption="Share of the features that are recognised after a change. Green: SIFT. Magenta: the "
    "same features with descriptors that lack what SIFT does against this change: they are not "
    "turned upright, are of patches of one size, or are the grey values. Bands: 95 % over albums "
    "of pictures.",
    cols=3,
    width=8.0,
    height=3.0,
)
def invariant(axes: np.ndarray, found: Mapping[str, tuple[Sequence, list, list]]) -> None:
    """Draw shares over levels of a change: of SIFT, and of what lacks its remedy."""
    for ax, (words, (levels, sift, worse)) in zip(axes, found.items(), strict=True):
        curve(ax, levels, sift, MEANING["right"])
        curve(ax, levels, worse, MEANING["wrong"])
        ax.set(xlabel=words, ylim=(0, 1))
    axes[0].set_ylabel("share recognised")


@drawn(
    name="sift-rules",
    alt="Share of right matches against the threshold: between 88 and 97 percent, falling with the "
    "threshold, and higher within two rows than in any row but at the last threshold.",
    caption="Matches that are right, by threshold and number of rows, over twenty buildings.",
    height=3.6,
)
def right_by_rules(ax: Axes, table: Table) -> None:
    """Draw the share of right matches by threshold, within two rows and within all."""
    *thresholds, _ = table.columns
    ticks = range(len(table.columns))
    lines = (2.0, "±2 rows", "right", "bottom", "left"), (240.0, "any row", "wrong", "top", "right")
    for rows, text, colour, va, ha in lines:
        values = [100 * table[f"{rows}", name].estimate for name in table.columns]
        ax.plot(ticks, values, "o-", color=MEANING[colour], markersize=4)
        middle = values[len(values) // 2]
        label(ax, len(values) / 2, middle, text, MEANING[colour], va=va, ha=ha)
    ax.set_xticks(ticks, [*thresholds, "none"])
    ax.set(xlabel="threshold of the descriptors", ylabel="right matches (%)")
    ax.set(xlim=(-0.3, len(ticks) - 0.7), ylim=(80, 100), yticks=range(80, 101, 5))


@drawn(
    name="sift-gains",
    alt="Points gained over the Euclidean distance to the means by tracked frames: raw variances "
    "rise from far below zero to near it, in the right panel they stay below; shrunk and pooled "
    "stay near zero.",
    caption="What the Mahalanobis distance gains over the Euclidean distance to the same means, on "
    "frames that made no class; bands: 95 % intervals over ten buildings, for a track that leads "
    "straight on over four.",
    cols=2,
    height=4.0,
)
def gains(
    axes: np.ndarray, found: Mapping[str, Mapping[str, list[Interval]]], tracked: Sequence[int]
) -> None:
    """Draw what variances gain over Euclid by tracked frames: by panel, by name."""
    for ax, (title, lines) in zip(axes, found.items(), strict=True):
        ax.axhline(0, color=MEANING["Euclid"], linewidth=1.0)
        for name, cells in lines.items():
            curve(ax, tracked, cells, MEANING[name], label=name)
        ax.set(
            xlabel="tracked frames p",
            ylabel="gain over Euclid (points)",
            xlim=(0, 32),
            ylim=(-30, 5),
        )
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
    tracked = np.array([int(name) for name in table.rows])
    measured = [table[name, "measured"].estimate for name in table.rows]
    laws = {int(name): table[name, "law"] for name in table.rows}
    finite = {p: law for p, law in laws.items() if not isinstance(law, str)}
    ax.plot(tracked, measured, "o-", color=MEANING["raw"], label="measured")
    ax.plot(list(finite), list(finite.values()), "o-", color=MEANING["expected"], label="law")
    ax.axhline(128, color=MEANING["truth"], linewidth=1.0, linestyle=":")
    ax.set_yscale("log")
    ax.set(xlabel="tracked frames p", ylabel="mean L of the right class", xlim=(0, 32))
    ax.legend()


def table_state(axes: np.ndarray, state: Any, tracked: Sequence[int]) -> None:
    """Draw the errors of Euclid and of a model, and the share of right ones over tracked frames."""
    above, below = axes
    for ax in axes:
        ax.clear()
    first, means = "Euclid, first view", "Euclid"
    models = (first, means, state.model)
    like, good = (np.array([at[name] for name in models]) for at in (state.like, state.share))
    above.barh(range(3), like, color=MEANING["look-alike"], height=0.6)
    above.barh(range(3), 100 - good - like, left=like, color=MEANING["wrong"], height=0.6)
    label(above, 49, 0, "a look-alike", MEANING["look-alike"], ha="right", va="center")
    label(above, 49, 1, "another", MEANING["wrong"], ha="right", va="center")
    above.set_yticks(range(3), ["first views", "means", "variances"])
    above.set(xlim=(0, 50), ylim=(2.6, -0.6), xlabel="assigned wrong (%)")
    for name, values in state.right.items():
        mine = name in models
        how = (2.2, 3, tint(name)) if mine else (0.8, 1, MEANING["expected"])
        words = dict(zip(("linewidth", "zorder", "color"), how, strict=True))
        below.plot(tracked, values, "--" if name == first else "-", **words)
    dot = state.share[state.model]
    below.plot(state.p, dot, "o", color=tint(state.model), markersize=8, zorder=4)
    below.set(xlim=(0, 32), ylim=(50, 100.5), xlabel="tracked frames p", ylabel="right (%)")


@drawn(
    name="sift-new",
    alt="Precision against recall of new landmarks for four distances.",
    caption="Precision, the share of the descriptors called new that are new, against recall, "
    "the share of the new ones that are called new, as the threshold moves. Dots: largest "
    "harmonic mean of the two.",
    height=3.8,
)
def new_landmarks(ax: Axes, curves: Mapping[str, Any]) -> None:
    """Draw precision against recall of "new landmark"."""
    for name, one in curves.items():
        ax.plot(100 * one.recall, 100 * one.precision, color=tint(name), label=name)
        best = one.best
        ax.plot(100 * one.recall[best], 100 * one.precision[best], "o", color=tint(name))
    ax.set(xlabel="recall of new landmarks (%)", ylabel="precision (%)")
    ax.set(xlim=(0, 100), ylim=(40, 100))
    ax.legend()
