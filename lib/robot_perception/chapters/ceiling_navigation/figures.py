"""Figures of the chapter "A robot that remembers the ceiling".

Plans are drawn as one sees them who looks up: x to the right, y downwards. What they draw is made
in the notebook: a namespace with the names that a drawing reads.
"""

from collections.abc import Mapping
from types import SimpleNamespace

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.charts import bars
from explorables.figures.style import MEANING, label
from robot_perception.chapters.ceiling_navigation.scene import HALF, Plan
from robot_perception.geometry import se2
from studies.tables import Table

_BARE = {"left": 0.01, "right": 0.99, "bottom": 0.02, "top": 0.88, "wspace": 0.05}
_TRIANGLE = np.array([[0.28, 0.0], [-0.14, 0.13], [-0.14, -0.13], [0.28, 0.0]])
_SQUARE = np.array([[0, 0], [1, 0], [1, 1], [-1, 1], [-1, -1], [1, -1], [1, 0]])
_WINDOW = 32.0
"""Half the side of a pattern's window, px."""


def photo(ax: Axes, image: np.ndarray) -> None:
    """Show a picture of the camera on axes without scales."""
    ax.imshow(image, cmap="gray", vmin=0, vmax=255)
    ax.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5))
    _bare(ax)


def ceiling(ax: Axes, plan: Plan) -> None:
    """Show a piece of ceiling in metres, as one sees it who looks up."""
    ax.imshow(plan.image, cmap="gray", vmin=0, vmax=255, extent=plan.extent)
    left, right, bottom, top = plan.extent
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    _bare(ax)


def _bare(ax: Axes) -> None:
    ax.set_xticks([])
    ax.set_yticks([])
    ax.grid(visible=False)


def scale_bar(ax: Axes, x: float, y: float, length: float) -> None:
    """Draw a line of some metres on a plan without scales, and say how long it is."""
    ax.plot([x, x + length], [y, y], color=MEANING["expected"], linewidth=2.0)
    across = {"textcoords": "offset points", "ha": "center", "va": "bottom"}
    middle = (x + length / 2, y)
    ax.annotate(f"{length:g} m", middle, (0, 3), color=MEANING["expected"], **across)


def triangle(ax: Axes, pose: Float[np.ndarray, "3"], colour: str, **kwargs: object) -> None:
    """Draw a robot as a triangle that points ahead."""
    points = se2.compose(pose, np.column_stack([_TRIANGLE, np.zeros(4)]))
    ax.plot(points[:, 0], points[:, 1], color=colour, **kwargs)


def view(ax: Axes, pose: Float[np.ndarray, "3"], colour: str, **kwargs: object) -> None:
    """Draw the outline of what the camera sees of the ceiling."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * HALF
    points = se2.compose(pose, np.column_stack([corners, np.zeros(5)]))
    ax.plot(points[:, 0], points[:, 1], color=colour, **kwargs)


def windows(ax: Axes, sightings: Mapping[str, Float[np.ndarray, "4"]], colour: str) -> None:
    """Draw the windows of patterns in a picture, and a stroke that tells their headings."""
    for x, y, angle, size in sightings.values():
        cos, sin = np.cos(angle) * size, np.sin(angle) * size
        u, v = (_WINDOW * _SQUARE @ np.array([[cos, sin], [-sin, cos]])).T
        ax.plot(x + u, y + v, color=colour, linewidth=1.8)


SETS = {"the rest as printed": "rest as printed (cm)", "the rest ours": "rest ours (cm)"}
"""Columns of the table of exchanged rules, by their titles."""


@drawn(
    name="nav-correction",
    alt="Three pictures of the same piece of ceiling: askew as the tilted camera sees it, and "
    "twice upright and alike: corrected, and as a camera in the robot's frame sees it.",
    caption="(a) A camera tilted by 6° and 8° and 18 cm beside the robot's middle. (b) "
    "Its picture, corrected by eq. 1, without the corners that it does not see. (c) What a "
    "camera in the robot's frame would have seen.",
    cols=3,
    width=7.4,
    height=2.1,
    gridspec_kw=_BARE,
)
def corrected(axes: np.ndarray, found: SimpleNamespace) -> None:
    """Draw a picture before and after its correction, and the ideal one."""
    names = "as it is mounted", "corrected", "the robot's own"
    for ax, image, words in zip(
        axes, (found.raw, found.corrected, found.ideal), names, strict=True
    ):
        photo(ax, image)
        ax.set_title(words)


@drawn(
    name="nav-mosaic",
    alt="A ring of ceiling composed of many pictures, with lamps, vents and signs. Triangles "
    "stand round the ring on a line, the true path, or within some centimetres of it.",
    caption="The counterpart of the paper's Fig. 9, by our rules, as it was chained. The ceiling, "
    "composed of what the camera saw, each picture laid where the robot located itself. Squares: "
    "patterns. Triangles: the robot in its mosaic, every two metres. Line: where it was in truth.",
    width=6.2,
    height=5.0,
    gridspec_kw={"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.99},
)
def mosaic(ax: Axes, shown: Plan, run: SimpleNamespace) -> Axes:
    """Draw the mosaic of a loop with true and estimated places of the robot."""
    ceiling(ax, shown)
    ax.plot(*run.true[:, :2].T, color=MEANING["taught path"], linewidth=2.2)
    there = np.array([*run.patterns.values()])
    ax.plot(*there[:, :2].T, "s", color=MEANING["ceiling pattern"], markersize=4, fillstyle="none")
    way = np.hypot(*np.diff(run.true[:, :2], axis=0).T).sum()
    for pose in run.told[:: round(2.0 * len(run.told) / way)]:
        triangle(ax, pose, MEANING["robot"], linewidth=1.8)
    return ax


@drawn(
    name="nav-loop",
    alt="Three plans of the loop. In the first the path by the mosaic as printed leaves the true "
    "one by up to more than a metre and does not close; in the second it leaves it by centimetres; "
    "in the third, adjusted, the two lie on each other.",
    caption="The loop (a) by the mosaic as printed, (b) by ours as it was chained, (c) by ours "
    "adjusted, over the true path (thin). Strokes lead from where a pattern is to where the mosaic "
    "has it. Above: root mean square error of the patterns.",
    cols=3,
    width=7.6,
    height=2.7,
    gridspec_kw={"left": 0.02, "right": 0.98, "bottom": 0.03, "top": 0.88, "wspace": 0.06},
)
def loops(axes: np.ndarray, runs: Mapping[str, SimpleNamespace]) -> None:
    """Draw the loop and the patterns by three mosaics, over the truth."""
    for ax, (words, run) in zip(axes, runs.items(), strict=True):
        meaning = "adjusted" if "adjusted" in words else "chained"
        ax.plot(*run.true[:, :2].T, color=MEANING["truth"], linewidth=1.0)
        ax.plot(*run.told[:, :2].T, color=MEANING[meaning], linewidth=2.2)
        for name, true in run.born.items():
            ends = np.array([true, run.patterns[name]])
            ax.plot(*ends[:, :2].T, color=MEANING["error"], linewidth=1.6)
        ax.set_title(f"{words}: {100 * run.apart:.0f} cm")
        ax.set(xlim=(-6.0, 6.0), ylim=(5.0, -5.0), aspect="equal")
        _bare(ax)
        scale_bar(ax, -0.9, 0.0, 2.0)


@drawn(
    name="nav-noise",
    alt="Error of the position against the distance of the pattern: by one pattern it rises from "
    "under two to four centimetres; by three together it is a level line near one centimetre.",
    caption="Error of the robot's position from noisy sightings (1 px, 1.1°), by the distance of "
    "the one pattern from the optical axis; dots are simulated. Dashed: the mean of the poses from "
    "three patterns. Level line: one pose fitted to the three.",
    height=3.0,
)
def noise(ax: Axes, law: np.ndarray, dots: Mapping[float, float], several: float, mean: float):
    """Draw the error of a pose (m) against the distance of its pattern."""
    ax.plot(np.linspace(0, 2, len(law)), 100 * law, color=MEANING["expected"])
    for at, error in dots.items():
        ax.plot(at, 100 * error, "o", color=MEANING["estimate"])
    ax.axhline(100 * several, color=MEANING["pooled"])
    ax.axhline(100 * mean, color=MEANING["pooled"], linestyle="--")
    label(ax, 1.95, 100 * several - 0.4, "three together", MEANING["pooled"], ha="right")
    label(ax, 1.95, 100 * mean - 0.4, "mean of three", MEANING["pooled"], ha="right")
    label(ax, 1.15, 3.4, "one pattern", MEANING["expected"], ha="right")
    ax.set(
        xlim=(0, 2),
        ylim=(0, 5),
        xlabel="distance of the pattern (m)",
        ylabel="error of the position (cm)",
    )
    ax.set_xticks([0, 1, 2])
    ax.set_yticks([1, 2, 3, 4, 5])
    return ax


@drawn(
    name="nav-rules",
    alt="Bars of the robot's error by the rule that is exchanged. With the rest as printed the bar "
    "of looks is shortest and that of means longest; with the rest ours all are short.",
    caption="Error of the robot after five metres if one rule comes from the other set; none: no "
    "rule does. (a) All others as printed. (b) All others ours. Lines: 95 %, over ceilings. Mind "
    "the two scales.",
    cols=2,
    width=8.2,
    height=3.4,
    gridspec_kw={"wspace": 0.75, "left": 0.2, "right": 0.98, "bottom": 0.16, "top": 0.9},
)
def rules(axes: np.ndarray, table: Table) -> None:
    """Draw the error by the rule that is exchanged, the others as printed and ours."""
    for ax, (title, column) in zip(axes, SETS.items(), strict=True):
        found = {name.replace("that ", "that\n"): table[name, column] for name in table.rows}
        bars(ax, found, MEANING["error"], "error of the robot (cm)")
        ax.set(xlim=(0, 1.05 * max(of.high for of in found.values())), title=title)


@drawn(
    name="nav-conditions",
    alt="Three plans of a path with a whole circle. With many key images the robot drives the "
    "circle; with key images that share no pattern it does not leave its place; without the "
    "threshold on turning it drives nearly straight on and leaves the circle out.",
    caption="(a) A taught path with a whole circle (broad), its key images (dots), and what a "
    "robot makes of them (thin), by exact sightings. (b) Successive key images share no pattern: "
    "the robot stays where it is. (c) They share one, and may be turned as they like.",
    cols=3,
    width=7.4,
    height=1.95,
    gridspec_kw=_BARE | {"top": 0.84},
)
def conditions(axes: np.ndarray, true: np.ndarray, found: Mapping[str, tuple]) -> None:
    """Draw a path and what is driven of it, by how its key images were chosen."""
    for ax, (words, (keys, path)) in zip(axes, found.items(), strict=True):
        ax.plot(*true[:, :2].T, color=MEANING["taught path"], linewidth=4.5, alpha=0.35)
        ax.plot(*path[:, :2].T, color=MEANING["robot"], linewidth=1.8)
        ax.plot(*keys[:, :2].T, "o", color=MEANING["key image"], markersize=5)
        ax.set_title(words)
        ax.set(xlim=(-1.8, 1.8), ylim=(1.8, -0.5), aspect="equal")
        _bare(ax)
        scale_bar(ax, -1.7, 1.65, 0.5)


def servoed(axes: np.ndarray, state: SimpleNamespace) -> None:
    """Draw a path driven again, and the heading on the way; axes cleared first."""
    top, below = axes
    top.clear()
    top.plot(*state.taught[:, :2].T, color=MEANING["taught path"], linewidth=4.5, alpha=0.35)
    top.plot(*state.path[:, :2].T, color=MEANING["robot"], linewidth=1.8)
    top.set(xlim=(-4.2, 4.2), ylim=(1.2, -1.2), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    top.set_title(f"{state.status}: {100 * state.off:.0f} cm off, {state.swings:.1f} rad per m")
    below.clear()
    seconds = 0.1 * np.arange(len(state.path))
    below.plot(seconds, np.rad2deg(state.path[:, 2]), color=MEANING["heading"], linewidth=1.6)
    below.set(xlim=(0, 28), ylim=(-120, 120), xlabel="time (s)", ylabel="heading (°)")


def quotients(ax: Axes, state: SimpleNamespace) -> None:
    """Draw a robot, two patterns, and where two readings put the second; axes cleared first."""
    ax.clear()
    view(ax, state.robot, MEANING["expected"], linewidth=1.0)
    triangle(ax, state.robot, MEANING["robot"], linewidth=2.0)
    for pose, meaning, words in (
        (state.pair[0], "anchor", "reference"),
        (state.right, "right", "new, by A⁻¹ B"),
        (state.wrong, "wrong", "new, by B A⁻¹"),
    ):
        points = se2.compose(pose, np.column_stack([0.2 * _SQUARE, np.zeros(len(_SQUARE))]))
        ax.plot(*points[:, :2].T, color=MEANING[meaning], linewidth=2.0, label=words)
    ax.set(xlim=(-3.2, 4.0), ylim=(3.4, -2.8), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    ax.legend(loc="lower center", ncols=2, columnspacing=1.0)
    ax.set_title(f"B A⁻¹ is {state.off:.1f} m off")


def filmed(axes: np.ndarray, plan: Plan, found: SimpleNamespace, image: np.ndarray, k: int) -> None:
    """Draw the camera's picture with its patterns, and the plan beside it; axes cleared first."""
    left, right = axes
    left.clear()
    photo(left, image)
    windows(left, found.sightings[k], MEANING["ceiling pattern"])
    words = f"{0.1 * k:4.1f} s, key image {min(found.key[k] + 1, len(found.keys))}"
    left.set_title(words, fontsize=15)  # the film is wide, and read on telephones
    right.clear()
    ceiling(right, plan)
    right.plot(*found.taught[:, :2].T, color=MEANING["taught path"], linewidth=2.4)
    keys = found.taught[list(found.keys)]
    right.plot(*keys[:, :2].T, "o", color=MEANING["key image"], markersize=5)
    right.plot(*found.driven[: k + 1, :2].T, color=MEANING["truth"], linewidth=1.6)
    triangle(right, found.driven[k], MEANING["truth"], linewidth=2.0)
    triangle(right, found.estimated[k], MEANING["robot"], linewidth=2.0)
