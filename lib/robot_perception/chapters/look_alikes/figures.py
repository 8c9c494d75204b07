"""Drawings of the chapter: paths of filters that were told wrong names."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.charts import Interval, strip
from explorables.figures.style import MEANING, AxesRow, label
from robot_perception.chapters.visual_slam.figures import WIDE, ground

ENDS = 0.1, 20.0
"""Errors between which a drive is drawn, m."""

GATED = {
    "ten particles": "ten particles, no gate",
    "ten particles, gate": "ten particles, gate of 30 cm",
    "one filter": "one filter, no gate",
    "one filter, gate": "one filter, gate of its own",
}
"""Names of paths, by the filter that is chosen."""


class Line(NamedTuple):
    """A line of a forest plot: its name, a ratio with its interval, and the limit it is held to."""

    name: str
    found: Interval
    limit: float | None = None


@drawn(
    name="look-pulled",
    alt="Floor plan with the true path and two others: the dashed one stays near the true path, "
    "the dotted one jumps about and cuts through walls.",
    caption="Sixteen of a hundred names are wrong. Dotted: the path by one filter of the pose and "
    "all landmarks. Dashed: the best of ten particles, with the same names. Solid: the true path.",
    width=6.4,
    height=4.4,
)
def pulled(ax: Axes, one: Any, ten: Any, walls: np.ndarray) -> Axes:
    """Draw the path of one hypothesis beside that of the best of ten."""
    ground(ax, walls, one.truth, WIDE)
    ax.plot(*one.path.T, color=MEANING["error"], linewidth=1.6, linestyle=":")
    ax.plot(*ten.path.T, color=MEANING["robot"], linewidth=1.4, linestyle="--")
    return ax


@drawn(
    name="look-drives",
    alt="Two rows of dots on one axis. One filter: between four and eleven metres off. Ten "
    "particles: mostly below one metre. A ring in each row marks the drive that is shown.",
    caption="How far the paths of both filters are off. Dots: twenty drives through ten other "
    "buildings with as many wrong names. Rings: the drive that is shown.",
    width=6.4,
    height=1.9,
)
def drives(ax: Axes, errors: Mapping[str, Sequence[float]], shown: Mapping[str, float]) -> Axes:
    """Draw where the drive that is shown lies among those that are scored."""
    return strip(ax, errors, shown, "path off by (m, root mean square)")


def followed(ax: Axes, state: Any, walls: np.ndarray) -> Axes:
    """Draw one path and the truth, on axes cleared first."""
    ax.clear()
    ground(ax, walls, state.truth, WIDE)
    ax.plot(*state.path.T, color=MEANING["robot"], linewidth=1.4, linestyle="--")
    x, y = state.path[-1].tolist()
    ax.plot(x, y, "o", color=MEANING["robot"], markersize=6)
    label(ax, x, y + 0.5, "the end", MEANING["robot"], ha="center")
    label(ax, 0.0, 8.6, f"{GATED[state.follower]}: {state.error:.1f} m off", MEANING["robot"])
    label(ax, 16.6, 4.2, "true path", MEANING["truth"], ha="right")
    return ax


def drives_of(ax: Axes, state: Any) -> Axes:
    """Draw ten drives, each by the error of the wheels alone and that of a filter."""
    ax.clear()
    ax.plot(ENDS, ENDS, color=MEANING["expected"], linewidth=1.4, linestyle="--")
    ax.fill_between(ENDS, ENDS, ENDS[1], color=MEANING["wrong"], alpha=0.1, linewidth=0)
    for right, marker in ((True, "o"), (False, "x")):
        some = state.right == right
        colour = MEANING["right" if right else "wrong"]
        ax.plot(state.wheels[some], state.off[some], marker, color=colour, markersize=9,
                markeredgewidth=2.2, linestyle="none")  # fmt: skip
    ax.text(0.52, 17.5, "lost: farther off than the wheels", va="top", color=MEANING["wrong"])
    gate = {"none": "no gate", "its own": "gate of its own"}.get(
        state.gate, f"gate of {state.gate}"
    )
    ax.set_title(f"{state.filter}, {gate}, {state.share} % wrong")
    ax.text(2.34, 0.17, "● map right", color=MEANING["right"], ha="right")
    ax.text(2.34, 0.115, "✕ map wrong", color=MEANING["wrong"], ha="right")
    ax.set(xscale="log", yscale="log", xlim=(0.5, 2.4), ylim=ENDS)
    ax.set(xlabel="the wheels alone are off by (m)", ylabel="the filter is off by (m)")
    ax.set_xticks([0.5, 1, 2], ["0.5", "1", "2"])
    ax.set_yticks([0.2, 0.5, 1, 2, 5, 10], ["0.2", "0.5", "1", "2", "5", "10"])
    ax.minorticks_off()
    return ax


def ratios(
    axes: AxesRow, matches: Mapping[str, Sequence[Line]], paths: Mapping[str, Sequence[Line]]
) -> AxesRow:
    """Draw ratios as dots with their intervals, in groups of lines, a drawing for each measure."""
    rows = []
    heads = "wrong matches over those with Euclid", "path error over that with Euclid"
    for ax, groups, head in zip(axes, (matches, paths), heads, strict=True):
        row, named, across = 0.0, False, ax.get_yaxis_transform()
        for group, lines in groups.items():
            ax.text(0.0, row, group, transform=across, fontweight="bold", va="center")
            for name, found, limit in lines:
                ax.text(0.0, row + 0.95, name, transform=across, fontsize=9.5, va="center")
                row += 1.8
                ax.plot([found.low, found.high], [row, row], color=MEANING["truth"], linewidth=1.6)
                ax.plot(found.estimate, row, "o", color=MEANING["truth"], markersize=6)
                if limit:
                    stroke = [row - 0.4, row + 0.4]
                    ax.plot([limit] * 2, stroke, color=MEANING["error"], linewidth=2.4)
                    if not named:
                        x = 0.96 * min(limit, found.low)
                        label(ax, x, row, "limit", MEANING["error"], ha="right", va="center")
                    named = True
            row += 1.6
        rows.append(row)
        ax.axvline(1.0, color=MEANING["expected"], linewidth=1.0, zorder=0)
        ax.set(xscale="log", xlabel=head, xlim=(0.26, 2.1), yticks=[])
        ax.set_xticks([0.3, 0.5, 0.7, 1, 1.4, 2], ["0.3", "0.5", "0.7", "1", "1.4", "2"])
        ax.minorticks_off()
    for ax in axes:
        ax.set_ylim(max(rows) - 0.5, -0.8)
    return axes


DOTS = (
    "Dots: ratios of means over the buildings; bars: 95 % intervals. At 1 there is no difference. "
    "Short strokes: the limit of a claim, below which the ratio should lie. "
)


@drawn(
    name="look-one-plan",
    alt="Two drawings of dots with intervals. Shares of wrong matches: those of eq. (9) lie above "
    "one in both gates, against single descriptors below. Errors of the path lie near one, even "
    "with names that are told.",
    caption=DOTS + "Each line names a distance, which is compared with Euclid's to the mean "
    "descriptor, unless the line names another. Shrunk: variances drawn towards those of all "
    "landmarks. Names told: the renderer names the landmarks.",
    cols=2,
    width=7.4,
    height=4.4,
)
def one_plan(
    axes: AxesRow, matches: Mapping[str, Sequence[Line]], paths: Mapping[str, Sequence[Line]]
) -> AxesRow:
    """Draw what distances do in the buildings of one plan."""
    return ratios(axes, matches, paths)


@drawn(
    name="look-ten-plans",
    alt="Two drawings of dots with intervals. Shares of wrong matches lie at one or above. Errors "
    "of the path: names that are told lie far below one, the distances about one.",
    caption=DOTS
    + "Where there are no look-alikes, each thing that hangs or stands has a picture of "
    "its own.",
    cols=2,
    width=7.4,
    height=4.9,
)
def ten_plans(
    axes: AxesRow, matches: Mapping[str, Sequence[Line]], paths: Mapping[str, Sequence[Line]]
) -> AxesRow:
    """Draw what distances do on ten plans, with look-alikes and without."""
    return ratios(axes, matches, paths)


@drawn(
    name="look-long-tracks",
    alt="Two drawings of dots with intervals, of slow drives. Shares of wrong matches lie at one "
    "or above. Errors of the path: names that are told lie far below one, eq. (9) just below.",
    caption=DOTS + "The robot drives four times as slowly, and a landmark is made of 24 "
    "descriptors.",
    cols=2,
    width=7.4,
    height=2.7,
)
def long_tracks(
    axes: AxesRow, matches: Mapping[str, Sequence[Line]], paths: Mapping[str, Sequence[Line]]
) -> AxesRow:
    """Draw what distances do with long tracks."""
    return ratios(axes, matches, paths)
