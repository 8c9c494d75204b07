"""Figures of the chapter "Two arms, one camera"."""

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from explorables.figures import drawn, figure
from explorables.figures.charts import bars, curve
from explorables.figures.maps import picture
from explorables.figures.style import MEANING, label
from robot_perception.chapters.arm_likelihoods.figures import outline
from studies.intervals import Interval
from studies.tables import Table

_PHOTO = {"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.99}
_MIDDLE = np.array([0.0, -0.12, 1.9])
_TURN = np.radians(35.0)
"""Angle by which the stick figure is turned, so that depth shows."""


def seen(ax: Axes, state: SimpleNamespace) -> None:
    """Draw a picture with the outline of the estimate and the true joints.

    The state has the ``image``, the ``points`` of the estimate's silhouette and which are
    ``visible``, and the true joints in the picture, ``sticks``, px.
    """
    picture(ax, state.image)
    outline(ax, state.points, state.visible, MEANING["estimate"])
    for arm in state.sticks:
        ax.plot(*arm[:3].T, "-", color=MEANING["right"], linewidth=1.6)
        ax.plot(*arm[1:3].T, "o", color=MEANING["right"], markersize=4)


def sticks(ax: Axes, state: SimpleNamespace) -> None:
    """Draw both arms in space, turned about the vertical: the truth and the estimate.

    The state has the ``true`` shoulders, elbows, wrists and fingertips and the estimated
    ``joints``, m.
    """
    for joints, meaning in ((state.true, "right"), (state.joints, "estimate")):
        off = joints - _MIDDLE
        u = off[..., 0] * np.cos(_TURN) - off[..., 2] * np.sin(_TURN)
        ax.plot(u[:, 0], -off[:, 0, 1], "-", color=MEANING["expected"], linewidth=3.0)
        for arm in range(2):
            ax.plot(u[arm], -off[arm, :, 1], "-o", color=MEANING[meaning], markersize=4,
                    linewidth=2.4)  # fmt: skip
    ax.set(xlim=(-0.9, 0.9), ylim=(-0.75, 0.75), aspect="equal")
    ax.axis("off")


def errors(ax: Axes, state: SimpleNamespace) -> None:
    """Draw how far off both wrists are over the film, and where it stands.

    The state says how far off the ``wrists`` are in each picture, which one it is by its ``time``,
    and how ``near`` a wrist is that counts as held, px.
    """
    for arm, style in enumerate(("-", "--")):
        ax.plot(np.minimum(state.wrists[:, arm], 99), style, color=MEANING["error"], linewidth=1.8)
    ax.axhline(state.near, color=MEANING["expected"], linestyle=":", linewidth=1.4)
    ax.axvline(state.time, color=MEANING["truth"], linewidth=1.2)
    ax.set(xlim=(0, len(state.wrists) - 1), ylim=(0, 100), xlabel="picture", ylabel="off (px)")


def card(ax: Axes, state: SimpleNamespace) -> Axes:
    """Draw outline and joints on the axes of the hero's picture."""
    seen(ax, state)
    return ax


@drawn(
    name="arms-hero",
    alt="A person points to the side. Points follow the outlines of both arms, lines their true "
    "joints.",
    caption="Points: the outlines of the estimate. Lines: the true shoulders, elbows and wrists.",
    width=5.6,
    height=4.2,
    gridspec_kw=_PHOTO,
)
def hero(ax: Axes, state: SimpleNamespace) -> Axes:
    """Draw somebody who points, and where the tracker has the arms."""
    return card(ax, state)


@drawn(
    name="arms-counts",
    alt="Error of the angles against the number of particles: it falls and levels off.",
    caption="Mean error of the eight angles against the number of particles, auxiliary filter, "
    "two draws a film. Band: 95 % over films.",
    height=3.0,
)
def counts(ax: Axes, particles: Sequence[int], errors: Sequence[Interval]) -> Axes:
    """Draw errors by number of particles."""
    curve(ax, particles, errors, MEANING["estimate"])
    ax.set(xscale="log", xlabel="particles", ylabel="error of the angles (°)", ylim=(0, None))
    ax.set_xticks(particles, [str(n) for n in particles])
    return ax


@drawn(
    name="arms-ablation",
    alt="A bar for each set of cues: the share of the time that an arm is held in clutter.",
    caption="Share of the time in which an arm is held, by what the tracker uses; gestures before "
    "clutter. Lines: 95 % over films.",
    height=3.2,
    gridspec_kw={"left": 0.4, "right": 0.97, "bottom": 0.15, "top": 0.98},
)
def ablation(ax: Axes, table: Table, column: str) -> Axes:
    """Draw the recorded shares by set of cues."""
    found = {name: table[name, column] for name in table.rows}
    bars(ax, found, MEANING["agreement"], "share of the time")
    return ax


@drawn(
    name="arms-resampling",
    alt="Two clouds of points on a picture of a person, one at each hand. In each a few points are "
    "much larger than the others.",
    caption="Small dots: both wrists of each of the four hundred particles after it has moved. "
    "Large dots: the same, by weight.",
    width=5.6,
    height=4.2,
    gridspec_kw=_PHOTO,
)
def resampling(
    ax: Axes, image: np.ndarray, wrists: Float[np.ndarray, "m 2 2"], weights: np.ndarray
) -> Axes:
    """Draw the wrists of all particles by their weight."""
    picture(ax, image)
    for arm in range(2):
        ax.scatter(*wrists[:, arm].T, s=3, color=MEANING["particles"], alpha=0.6, linewidths=0)
        ax.scatter(*wrists[:, arm].T, s=400 * weights, color=MEANING["estimate"], linewidths=0)
    return ax


@drawn(
    name="arms-ray",
    alt="Seen from above, a camera below and a shoulder two metres before it. Two rays leave the "
    "shoulder: where the arm points, and where the robot says that it points, with a wedge about "
    "the second one.",
    caption="The raised arm of the first figure, seen from above; the camera looks upwards in this "
    "drawing. Rays of three metres: where the arm points, and where the tracker says that it "
    "points. Wedge: the mean error over all films, to both sides of the tracker's ray.",
    height=3.9,
)
def ray(ax: Axes, shoulder: np.ndarray, true: np.ndarray, told: np.ndarray, error: float) -> Axes:
    """Draw two directions (3,) from a shoulder (3,) from above, and an error of so many degrees.

    All are given in the frame of the camera, which is drawn at its place.
    """
    u, w = shoulder[0], shoulder[2]
    level = np.hypot(told[0], told[2])
    turns = np.arctan2(told[2], told[0]) + np.radians(error) * np.linspace(-1, 1, 21)
    ends = [u, w] + 3 * level * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    ax.fill(*np.vstack([[u, w], ends]).T, color=MEANING["estimate"], alpha=0.15, linewidth=0)
    for way, meaning, name in ((true, "right", "truth"), (told, "estimate", "tracker")):
        end = u + 3 * way[0], w + 3 * way[2]
        ax.plot([u, end[0]], [w, end[1]], color=MEANING[meaning], linewidth=2.2)
        above = way[2] >= max(true[2], told[2])
        place = u + 2.5 * way[0], w + 2.5 * way[2] + (0.24 if above else -0.3)
        label(ax, *place, name, MEANING[meaning], ha="left" if above else "right")
    ax.plot(u, w, "o", color=MEANING["truth"], markersize=6)
    label(ax, u, w + 0.3, "shoulder", MEANING["truth"], ha="center")
    eye = np.array([[0.0, 0.0], [-0.3, 0.45], [0.3, 0.45]])
    ax.fill(*eye.T, facecolor="none", edgecolor=MEANING["expected"], linewidth=2.0)
    label(ax, 0.0, -0.25, "the camera", MEANING["expected"], ha="center")
    ax.set(xlim=(-1.5, 3.7), ylim=(-0.55, 2.6), aspect="equal")
    ax.set(xlabel="to the side (m)", ylabel="from the camera (m)")
    return ax


def following(axes: np.ndarray, state: SimpleNamespace) -> None:
    """Draw a picture, both stick figures, and the errors over the film; axes cleared first."""
    left, right, below = axes
    for ax in axes:
        ax.clear()
    seen(left, state)
    sticks(right, state)
    errors(below, state)


def laid_out() -> tuple[Figure, np.ndarray]:
    """Return a figure with a picture, and a stick figure and a curve below; for telephones, too."""
    fig, axes = figure(3, width=4.8, height=5.3)
    left, right, below = axes
    left.set_position((0.0, 0.32, 1.0, 0.68))
    right.set_position((0.0, 0.02, 0.40, 0.29))
    below.set_position((0.52, 0.11, 0.45, 0.19))
    return fig, axes
