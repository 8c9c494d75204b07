"""Figures of the chapter "What a likelihood looks like"."""

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.axes import Axes

from robot_perception.chapters.arm_likelihoods import views
from robot_perception.chapters.arm_likelihoods.scene import AWAY, AWAYS, BEND, BENDS
from robot_perception.chapters.arm_likelihoods.summing import FINE
from robot_perception.teaching.figures import drawn
from robot_perception.teaching.figures.maps import picture
from robot_perception.teaching.figures.style import MEANING, label

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


def surface(ax: Axes, heights: Float[np.ndarray, "aways bends"], true: np.ndarray) -> None:
    """Draw a likelihood over the sweep; a ring marks the true pose, degrees."""
    ax.imshow(heights.T, cmap="gray", vmin=0, vmax=1, extent=_EXTENT, origin="lower",
              aspect="auto", interpolation="nearest")  # fmt: skip
    ax.plot(*true, "o", markersize=12, markerfacecolor="none", color=MEANING["right"],
            markeredgewidth=2.0)  # fmt: skip
    ax.set(xlabel="arm lifted by (°)", ylabel="elbow (°)", xlim=_EXTENT[:2], ylim=_EXTENT[2:])
    ax.grid(visible=False)


def card(ax: Axes) -> Axes:
    """Draw the true silhouette on the axes of the picture that is shown."""
    of = views.shown()
    outline(ax, *views.outline(of, of.angles), MEANING["estimate"])
    return ax


@drawn(
    name="likelihoods-hero",
    alt="A person before a cluttered wall, hands before the body, with the outlines of cones on "
    "the arms. Beside it two grey maps: the first has many bright spots, the second one bright "
    "spot, at the ring that marks the true pose.",
    caption="Left: the model on the true pose. Middle and right: how likely other angles of one "
    "arm are, by its outline alone and by all cues. Bright: likely. Ring: the truth.",
    cols=3,
    width=7.6,
    height=2.7,
    gridspec_kw={"left": 0.005, "right": 0.98, "bottom": 0.19, "top": 0.89, "wspace": 0.36},
)
def hero(axes: np.ndarray) -> None:
    """Draw the picture and two surfaces."""
    of = views.shown()
    picture(axes[0], of.image)
    card(axes[0])
    true = np.degrees(of.angles[[AWAY, BEND]])
    for ax, mix, title in zip(axes[1:], ("shape", "all"), ("by its outline", "by all cues"),
                              strict=True):  # fmt: skip
        surface(ax, views.height(mix), true)
        ax.set_title(title)


@drawn(
    name="likelihoods-bumps",
    alt="Two curves over the angle of an arm: the share of contour points on an edge jumps up and "
    "down all along, by much; the one from distances trembles, too, but by little, and rises to "
    "its peak at the true angle.",
    caption="An arm is turned by up to 45° to either side of its true angle. Both scores are drawn "
    "from their lowest to their highest value.",
    height=3.0,
)
def bumps(ax: Axes) -> Axes:
    """Draw both scores of the arm that is turned."""
    found, degrees = views.bumpy(), np.degrees(FINE)
    for name, colour, meaning in (("edges", "raw", "points on an edge"),
                                  ("distances", "smoothed", "distance to edges")):  # fmt: skip
        ax.plot(degrees, found[name], color=MEANING[colour], linewidth=1.5)
        label(ax, -44, 1.16 if name == "edges" else 1.06, meaning, MEANING[colour], ha="left")
    ax.set(xlabel="turned by (°)", ylabel="score", xlim=(-45, 45), ylim=(0, 1.25))
    return ax


@drawn(
    name="likelihoods-field",
    alt="A person before a cluttered wall, and a grey map of the same size that is dark but for a "
    "few bright spots.",
    caption="Left: the picture. Right: how much a square of 8 px looks like the hand did at rest. "
    "Bright: alike. Rings: the true hands.",
    cols=2,
    width=7.4,
    height=2.9,
    gridspec_kw={"left": 0.005, "right": 0.995, "bottom": 0.01, "top": 0.99, "wspace": 0.03},
)
def field(axes: np.ndarray) -> None:
    """Draw the likelihood of the hand's colours over the picture."""
    of, (values, columns, rows) = views.shown(), views.hand_field()
    picture(axes[0], of.image)
    axes[1].imshow(values, cmap="gray", vmin=0, vmax=1, interpolation="nearest", origin="upper",
                   extent=(columns[0] - 2, columns[-1] + 2, rows[-1] + 2, rows[0] - 2))  # fmt: skip
    axes[1].set(xlim=(-0.5, 319.5), ylim=(239.5, -0.5), xticks=[], yticks=[])
    axes[1].grid(visible=False)
    joints = of.model.joints(of.angles[None])[0]
    for u, v in of.model.pixels(joints[:, 2:].mean(axis=1)):
        for ax in axes:
            ax.plot(u, v, "o", markersize=17, markerfacecolor="none", color=MEANING["right"],
                    markeredgewidth=2.0)  # fmt: skip


@drawn(
    name="likelihoods-hidden",
    alt="A person before a bare wall. Round points follow an arm. Crosses show another pose in "
    "which most of it is hidden.",
    caption="Points: the true pose. Crosses: a pose that hides the arm; small ones are hidden. By "
    "eq. (2), summed over visible points, the hidden pose is the better one.",
    width=5.6,
    height=4.2,
    gridspec_kw={"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.99},
)
def hidden(ax: Axes) -> Axes:
    """Draw a true pose and a hidden one that is preferred."""
    of, state, _ = views.hidden()
    picture(ax, of.image)
    half = of.model.points // 2
    for pose, colour, marker in ((of.angles, "right", "o"), (state, "wrong", "X")):
        points, visible = views.outline(of, pose)
        for which, size in ((visible, 36), (~visible, 8)):
            at = points[:half][which[:half]]
            ax.scatter(*at.T, s=size, marker=marker, color=MEANING[colour],
                       edgecolors=MEANING["truth"], linewidths=0.8)  # fmt: skip
    return ax


@drawn(
    name="likelihoods-straight",
    alt="Two lines over the turn of the upper arm: for a bent elbow a V that rises to many pixels, "
    "for a straight one a flat line at zero.",
    caption="How far a point of the contour moves at most when the upper arm turns about its axis.",
    height=2.8,
)
def straight(ax: Axes) -> Axes:
    """Draw how far the contour moves as the upper arm turns."""
    for bend, colour, name in ((0.3, "information", "elbow bent by 17°"),
                               (0.0, "unobservable", "straight arm")):  # fmt: skip
        turns, moved = views.straight(bend)
        ax.plot(turns, moved, color=MEANING[colour], linewidth=2.0)
        label(ax, 86, 20.0 if bend else 2.2, name, MEANING[colour], ha="right")
    ax.set(xlabel="turned about its axis by (°)", ylabel="moves by (px)", xlim=(-90, 90))
    return ax


def dragging(axes: np.ndarray, state: views.Dragged) -> None:
    """Draw the dragged arm in the picture, and the surface of the mix; axes cleared first."""
    left, right = axes
    for ax in axes:
        ax.clear()
    picture(left, state.image)
    outline(left, state.points, state.visible, MEANING["estimate"])
    surface(right, state.surface, np.array(state.true))
    right.plot(*state.at, "x", markersize=9, markeredgewidth=2.4, color=MEANING["estimate"])


def gaining(axes: np.ndarray, state: views.Gained) -> None:
    """Draw the smaller of both distances, and the surface; axes cleared first."""
    left, right = axes
    for ax in axes:
        ax.clear()
    left.imshow(-state.distance, cmap="gray", vmin=-5, vmax=0, interpolation="nearest")
    left.set(xticks=[], yticks=[])
    left.grid(visible=False)
    surface(right, state.surface, np.array(state.true))
