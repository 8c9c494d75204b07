"""Figures of the chapter "What a likelihood looks like"."""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from explorables.figures import drawn, figure
from explorables.figures.maps import picture
from explorables.figures.style import MEANING, label
from robot_perception.chapters.arm_likelihoods import scene
from robot_perception.chapters.arm_likelihoods.scene import AWAY, AWAYS, BEND, BENDS, Glance

_AXES = {"left": 0.005, "right": 0.975, "bottom": 0.14, "top": 0.85, "wspace": 0.24}
_HALF = 2.5
"""Half a step of the sweep, degrees."""
_EXTENT = (
    np.degrees(AWAYS[0]) - _HALF, np.degrees(AWAYS[-1]) + _HALF,
    np.degrees(BENDS[0]) - _HALF, np.degrees(BENDS[-1]) + _HALF,
)  # fmt: skip


def outline(
    ax: Axes, points: Float[np.ndarray, "n 2"], visible: Bool[np.ndarray, " n"], colour: str
) -> None:
    """Draw the points of a silhouette, hidden ones small."""
    ax.scatter(*points[visible].T, s=9, color=colour, linewidths=0)
    ax.scatter(*points[~visible].T, s=2, color=colour, linewidths=0)


def scale(ax: Axes, ends: tuple[float, float], ticks: Sequence[float], unit: str) -> None:
    """Draw what grey values mean, above a map: the first end is black, the second white."""
    bar = ax.inset_axes((0.3, 1.03, 0.7, 0.05))  # the letter stands beside it
    bar.imshow(np.linspace(0, 1, 64)[None], cmap="gray", vmin=0, vmax=1, origin="lower",
               extent=(0, 1, 0, 1), aspect="auto", interpolation="nearest")  # fmt: skip
    places = [(tick - ends[0]) / (ends[1] - ends[0]) for tick in ticks]
    bar.set(yticks=[], xlim=(0, 1), ylim=(0, 1))
    bar.set_xticks(places, [f"{tick:g}{unit}" for tick in ticks])
    bar.xaxis.tick_top()
    for text, place in zip(bar.get_xticklabels(), places, strict=True):
        text.set_ha("left" if place == 0 else "right" if place == 1 else "center")
    bar.grid(visible=False)


def surface(ax: Axes, heights: Float[np.ndarray, "aways bends"], true: np.ndarray) -> None:
    """Draw a likelihood over the sweep, 1 at its highest; a ring marks the true pose, degrees."""
    ax.imshow(heights.T, cmap="gray", vmin=0, vmax=1, extent=_EXTENT, origin="lower",
              aspect="auto", interpolation="nearest")  # fmt: skip
    ax.plot(*true, "o", markersize=12, markerfacecolor="none", color=MEANING["right"],
            markeredgewidth=2.0)  # fmt: skip
    ax.set(
        xlabel="arm lifted by (°)", ylabel="elbow bent by (°)", xlim=_EXTENT[:2], ylim=_EXTENT[2:]
    )
    ax.grid(visible=False)
    scale(ax, (0.0, 1.0), (0, 0.5, 1), "")


def card(ax: Axes) -> Axes:
    """Draw the true silhouette on the axes of the picture that is shown."""
    of = scene.shown()
    outline(ax, *scene.outline(of, of.angles), MEANING["estimate"])
    return ax


@drawn(
    name="likelihoods-hero",
    alt="A person before a cluttered wall, hands before the body, with the outlines of cones on "
    "the arms. Beside it two grey maps: the first has many bright spots, the second one bright "
    "spot, at the ring that marks the true pose.",
    caption="(a) The model on the true pose. (b), (c) How likely other angles of one "
    "arm are, by its outline alone and by all cues, as shares of the highest likelihood. Ring: "
    "the truth.",
    cols=3,
    width=7.6,
    height=2.9,
    gridspec_kw={"left": 0.005, "right": 0.98, "bottom": 0.18, "top": 0.77, "wspace": 0.36},
)
def hero(axes: np.ndarray, heights: Mapping[str, Float[np.ndarray, "aways bends"]]) -> None:
    """Draw the picture and two surfaces, by their titles."""
    of = scene.shown()
    picture(axes[0], of.image)
    card(axes[0])
    true = np.degrees(of.angles[[AWAY, BEND]])
    for ax, (title, height) in zip(axes[1:], heights.items(), strict=True):
        surface(ax, height, true)
        ax.set_title(title)


@drawn(
    name="likelihoods-bumps",
    alt="Two curves over the angle of an arm: the share of contour points on an edge jumps up and "
    "down all along, by much; the one from distances trembles, too, but by little, and rises to "
    "its peak at the true angle.",
    caption="Two scores of an arm that is turned by up to 45° to either side of its true angle, "
    "which is 0°. Each is scaled from its lowest value, 0, to its highest, 1.",
    height=3.0,
)
def bumps(
    ax: Axes, turns: Float[np.ndarray, " steps"], found: Mapping[str, Float[np.ndarray, " steps"]]
) -> Axes:
    """Draw both scores of the arm that is turned."""
    degrees = np.degrees(turns)
    for name, colour, meaning in (("edges", "raw", "points on an edge"),
                                  ("distances", "smoothed", "distance to edges")):  # fmt: skip
        score = found[name]
        ax.plot(degrees, (score - score.min()) / np.ptp(score), color=MEANING[colour],
                linewidth=1.5)  # fmt: skip
        label(ax, -44, 1.25 if name == "edges" else 1.08, meaning, MEANING[colour], ha="left")
    ax.set(xlabel="turned by (°)", ylabel="scaled score", xlim=(-45, 45), ylim=(0, 1.4))
    return ax


@drawn(
    name="likelihoods-field",
    alt="A person before a cluttered wall, a ring on one hand, and a grey map of the same size "
    "that is dark but for a few bright spots, on hands and face above all.",
    caption="(a) The picture. (b) The likelihood that a square of 8 px shows what the square at "
    "the ring shows, as a share of that of the most similar place.",
    cols=2,
    width=7.4,
    height=3.2,
    gridspec_kw={"left": 0.005, "right": 0.995, "bottom": 0.01, "top": 0.86, "wspace": 0.03},
)
def field(axes: np.ndarray, alike: SimpleNamespace) -> None:
    """Draw how alike all places of a picture are to one of them."""
    picture(axes[0], alike.image)
    x, y, heights = alike.columns, alike.rows, alike.likelihood
    axes[1].imshow(heights, cmap="gray", vmin=0, vmax=1, interpolation="nearest", origin="upper",
                   extent=(x[0] - 2, x[-1] + 2, y[-1] + 2, y[0] - 2))  # fmt: skip
    axes[1].set(xlim=(-0.5, 319.5), ylim=(239.5, -0.5), xticks=[], yticks=[])
    axes[1].grid(visible=False)
    scale(axes[1], (0.0, 1.0), (0, 0.5, 1), "")
    for ax in axes:
        ax.plot(*alike.place, "o", markersize=17, markerfacecolor="none", color=MEANING["right"],
                markeredgewidth=2.0)  # fmt: skip


@drawn(
    name="likelihoods-hidden",
    alt="A person before a bare wall. Round points follow an arm. Crosses show another pose in "
    "which most of it is hidden.",
    caption="Points: the true pose of one arm. Crosses: a pose that hides most of this arm; small "
    "marks are hidden points. By eq. (2), summed over visible points, the hidden pose is better.",
    width=5.6,
    height=4.2,
    gridspec_kw={"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.99},
)
def hidden(ax: Axes, of: Glance, state: Float[np.ndarray, " 8"]) -> Axes:
    """Draw a true pose and a hidden one that is preferred."""
    picture(ax, of.image)
    half = of.model.points // 2
    for pose, colour, marker in ((of.angles, "right", "o"), (state, "wrong", "X")):
        points, visible = scene.outline(of, pose)
        for which, size in ((visible, 36), (~visible, 8)):
            at = points[:half][which[:half]]
            ax.scatter(*at.T, s=size, marker=marker, color=MEANING[colour],
                       edgecolors=MEANING["truth"], linewidths=0.8)  # fmt: skip
    return ax


@drawn(
    name="likelihoods-straight",
    alt="Two lines over the turn of the upper arm: for a bent elbow a V that rises to many pixels, "
    "for a straight one a flat line at zero.",
    caption="The largest motion of a point of the contour in the picture, as the upper arm turns "
    "about its axis.",
    height=2.8,
)
def straight(
    ax: Axes, turns: Float[np.ndarray, " turns"], moves: Mapping[float, Float[np.ndarray, " turns"]]
) -> Axes:
    """Draw how far the contour moves as the upper arm turns, by the bend of the elbow."""
    for bend, moved in moves.items():
        colour = "information" if bend else "unobservable"
        name = f"elbow bent by {np.degrees(bend):.0f}°" if bend else "straight arm"
        ax.plot(turns, moved, color=MEANING[colour], linewidth=2.0)
        label(ax, *((45, 22.0) if bend else (86, 2.2)), name, MEANING[colour], ha="right")
    ax.set(xlabel="turned about its axis by (°)", ylabel="moves by (px)", xlim=(-90, 90))
    return ax


def dragging(axes: np.ndarray, state: SimpleNamespace) -> None:
    """Draw the dragged arm in the picture, and the surface of the mix; axes cleared first."""
    left, right = axes
    for ax in axes:
        ax.clear()
    picture(left, state.image)
    outline(left, *state.outline, MEANING["estimate"])
    surface(right, state.surface, state.true)
    right.plot(*state.at, "x", markersize=9, markeredgewidth=2.4, color=MEANING["estimate"])


def gaining(axes: np.ndarray, state: SimpleNamespace) -> None:
    """Draw the smaller of both distances, and the surface; axes cleared first."""
    left, right = axes
    for ax in axes:
        ax.clear()
    left.imshow(-state.distance, cmap="gray", vmin=-12, vmax=0, interpolation="nearest")
    left.set(xticks=[], yticks=[])
    left.grid(visible=False)
    scale(left, (12.0, 0.0), (0, 6, 12), " px")
    surface(right, state.surface, state.true)


def two() -> tuple[Figure, np.ndarray]:
    """Return the axes of an explorer: the picture, and a surface beside it."""
    return figure(1, 2, width=7.8, height=3.5, gridspec_kw=_AXES)
