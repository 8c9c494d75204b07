"""Figures of the chapter "Where am I?"."""

from collections.abc import Iterator, Mapping, Sequence
from types import SimpleNamespace

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from explorables.figures import drawn, figure, film
from explorables.figures.charts import strip
from explorables.figures.maps import dots, lines, picture, plan
from explorables.figures.style import MEANING, AxesRow
from explorables.media import Shown

FLOOR = np.array([[-0.6, -5.6], [20.7, 7.8]])
"""Corners of the axes around the walls, m."""
CLOSE = np.array([2.9, 1.83])
"""Width and height of a close view, m."""


def where(ax: Axes, state: SimpleNamespace, stroke: float = 0.35) -> Axes:
    """Draw the plan with particles, estimate and truth, on axes cleared first; strokes in m."""
    ax.clear()
    lines(ax, state.plan, MEANING["truth"], 2.0, alpha=0.25, zorder=0)
    cloud(ax, state.particles, MEANING["estimate"], stroke)
    arrow(ax, state.truth, MEANING["truth"], "-")
    if state.pose is not None:
        arrow(ax, state.pose, MEANING["estimate"], "--" if not state.located else "-")
    plan(ax, FLOOR, margin=0.0)
    ax.set(xticks=[], yticks=[], xlabel="", ylabel="")
    return ax


def cloud(ax: Axes, particles: Float[np.ndarray, "n 3"], colour: str, stroke: float) -> None:
    """Draw poses as short strokes in the direction in which they look."""
    ahead = np.stack([np.cos(particles[:, 2]), np.sin(particles[:, 2])], axis=-1)
    ends = np.stack([particles[:, :2], particles[:, :2] + stroke * ahead], axis=1)
    lines(ax, ends, colour, 0.5 + 2 * stroke, alpha=0.6)


def arrow(ax: Axes, pose: Float[np.ndarray, "3"], colour: str, style: str) -> None:
    """Draw a robot as a square or a ring with a stroke in the direction in which it looks."""
    tip = pose[:2] + 1.1 * np.array([np.cos(pose[2]), np.sin(pose[2])])
    marker = "s" if colour == MEANING["truth"] else "o"
    ax.plot(*pose[:2], marker, color=colour, markersize=10, fillstyle="none", markeredgewidth=2.0)
    ax.plot(*np.stack([pose[:2], tip], axis=-1), style, color=colour, linewidth=2.0)


def _pictures(state: SimpleNamespace) -> str:
    return f"{state.seen or 'no'} picture{'' if state.seen == 1 else 's'}"


@drawn(
    name="mcl-hero",
    alt="Three drawings. In the first, a floor plan of a corridor with rooms, short strokes lie "
    "all over the plan and point in all directions. The others enlarge the two frames in it: after "
    "one picture the strokes lie close together, half a metre from the robot, after sixteen on it.",
    caption="5000 particles before the first picture, after one and after sixteen. The frames in "
    "the plan, with their numbers of pictures, are enlarged in the others. Strokes: 200 of "
    "the particles. Square: the robot. Ring: the mean of the heaviest cluster, its stroke dashed "
    "while the robot does not count as located. Lines: the walls, which the map does not know.",
    cols=3,
    width=8.4,
    height=1.95,
    gridspec_kw={"left": 0.005, "right": 0.995, "bottom": 0.01, "top": 0.87, "wspace": 0.05},
)
def hero(axes: AxesRow, states: Sequence[SimpleNamespace]) -> AxesRow:
    """Draw three moments of a search: all particles on the plan, then those about the robot."""
    whole, *parts = axes
    start, *later = states
    where(whole, SimpleNamespace(**vars(start) | {"pose": None}))
    whole.set_title("before the first picture")
    for ax, state in zip(parts, later, strict=True):
        where(ax, state, stroke=0.12)
        middle = (state.pose[:2] + state.truth[:2]) / 2
        low, high = middle - CLOSE / 2, middle + CLOSE / 2
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        off = np.hypot(*(state.pose - state.truth)[:2])
        ax.set_title(f"{_pictures(state)}: {off:.2f} m off")
        corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
        frame = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
        lines(whole, frame, MEANING["moved world"], 1.2)
        how = {"ha": "right", "va": "center", "size": 9.0, "color": MEANING["moved world"]}
        whole.text(low[0] - 0.2, middle[1], f"{state.seen}", **how)
        scale = high - 0.2
        ax.plot([scale[0] - 0.5, scale[0]], [scale[1]] * 2, color=MEANING["truth"], linewidth=2.0)
        ax.text(*scale - [0.25, 0.06], "0.5 m", ha="center", va="top", size=9.0)
    return axes


@drawn(
    name="mcl-drives",
    alt="A row of dots on one axis, nearly all below half a metre. A ring marks the start that "
    "is shown.",
    caption="Dots: forty starts in eight other buildings, each by how far the estimate is off "
    "after sixteen pictures in the direction of the first drive. Ring: the start that is shown.",
    width=6.4,
    height=1.5,
)
def drives(ax: Axes, ends: Mapping[str, Sequence[float]], shown: Mapping[str, float]) -> Axes:
    """Draw where the start that is shown lies among those that are scored."""
    return strip(ax, ends, shown, "estimate off by (m)")


def card(ax: Axes, state: SimpleNamespace) -> Axes:
    """Draw one moment for the book's first page."""
    return where(ax, state)


@drawn(
    name="mcl-map",
    alt="Floor plan with about a thousand dots along the walls that a drive passed.",
    caption="The map: its landmarks from above, laid on the plan by the best rigid motion. The "
    "robot knows places, covariances and descriptors, and no wall.",
    width=6.4,
    height=4.0,
)
def marks(
    ax: Axes, walls: Float[np.ndarray, "walls 2 2"], places: Float[np.ndarray, "n 2"]
) -> Axes:
    """Draw the landmarks over the plan."""
    lines(ax, walls, MEANING["truth"], 2.0, alpha=0.25, zorder=0)
    dots(ax, places, MEANING["landmark"], 1.8)
    return plan(ax, FLOOR, margin=0.0)


FPS = 3.0


def carried(moments: Sequence[SimpleNamespace]) -> Shown:
    """Show a robot that is carried away: its picture, and two filters."""
    return film(
        _frames(moments),
        fps=FPS,
        name="mcl-film",
        poster=len(moments) - 1,
        alt="Above, what the left eye sees. Below, two plans: particles gather at the robot in "
        "both. Then it is carried to another room. Without fresh particles they stay where they "
        "were; with them a second heap grows at the robot.",
        caption="Above: the left eye. Below: two filters, first the paper's, then one with 5 % "
        "fresh particles. Square: the robot. Strokes and ring: particles "
        "and estimate, dashed while the robot does not count as located. Half-way somebody carries "
        "the robot to another room.",
    )


def _frames(moments: Sequence[SimpleNamespace]) -> Iterator[Figure]:
    """Yield the pictures of the film, all on one figure."""
    fig, (top, left, right) = figure(3, width=6.6, height=5.0)
    top.set_position((0.28, 0.46, 0.44, 0.52))
    left.set_position((0.01, 0.02, 0.48, 0.42))
    right.set_position((0.51, 0.02, 0.48, 0.42))
    for moment in moments:
        top.clear()
        _photo(top, moment.image())
        for ax, state in ((left, moment.without), (right, moment.fresh)):
            where(ax, state)
        yield fig


def _photo(ax: Axes, image: Float[np.ndarray, "height width"]) -> None:
    picture(ax, image.round().clip(0, 255).astype(np.uint8))
    ax.axis("off")


@drawn(
    name="mcl-weights",
    alt="Two curves of a logarithm over the distance from the true place, both highest a quarter "
    "of a metre from it. One is a needle on flat ground with two low hills, one a broad hill.",
    caption="Logarithm of the weight of poses beside the true one. The needle: a match may be "
    "wrong; the low hills beside it are made by a few matches each. The broad hill: with a spread "
    "of 0.3 m as well.",
    height=3.2,
)
def slices(ax: Axes, aside: Float[np.ndarray, "n"], logs: Mapping[str, np.ndarray]) -> Axes:
    """Draw the logarithms of weights beside the truth, each above its own ground."""
    for name, meaning in (("a match may be wrong", "plain"), ("with added spread", "estimate")):
        ax.plot(aside, logs[name], color=MEANING[meaning], linewidth=2.0, label=name)
    ax.set(xlabel="to the left of the true place (m)", ylabel="log weight", xlim=(-2, 2))
    ax.set_ylim(top=max(logs["a match may be wrong"]) + 150)
    ax.legend(loc="upper left")
    return ax
