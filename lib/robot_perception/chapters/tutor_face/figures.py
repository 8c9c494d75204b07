"""Figures of the chapter "Is it you?".

What they draw is made in the notebook: a namespace with the names that a drawing reads.
"""

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.charts import curve
from explorables.figures.maps import picture, square
from explorables.figures.style import MEANING
from robot_perception.companion.faces.eigenfaces import Eigenfaces
from studies.intervals import Interval

_PHOTO = {"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.99}


def card(ax: Axes, met: SimpleNamespace) -> Axes:
    """Draw the faces that were found on the axes of a picture."""
    for box, name in zip(met.boxes, met.names, strict=True):
        colour = MEANING["wrong" if name is None else "right"]
        square(ax, box, colour, linewidth=3.0, linestyle="--" if name is None else "-")
    return ax


@drawn(
    name="tutor-hero",
    alt="Two people before a cluttered wall. A solid square marks one face, a dashed one the "
    "other.",
    caption="Both faces are found. Solid: the robot says that it is its tutor. Dashed: it says "
    "that it does not know who that is. We chose a picture in which it is right.",
    width=5.2,
    height=3.9,
    gridspec_kw=_PHOTO,
)
def hero(ax: Axes, met: SimpleNamespace) -> Axes:
    """Draw two people of whom the robot knows one."""
    picture(ax, met.image)
    return card(ax, met)


@drawn(
    name="tutor-turns",
    alt="Share of faces found against the turn of the head: nearly all up to 15 degrees, less at "
    "30, few at 60.",
    caption="Share of the faces that the cascade finds, by the turn of the head. Band: 95 %. Faces "
    "from the front are nearly all found; turned by 45°, more are missed than found.",
    height=2.8,
)
def turns(ax: Axes, degrees: Sequence[int], found: Sequence[Interval]) -> Axes:
    """Draw the rate by the turn of the head."""
    curve(ax, degrees, found, MEANING["camera"])
    ax.set(
        xlabel="turn of the head (°)", ylabel="share found", xlim=(0, degrees[-1]), ylim=(0, 1.02)
    )
    return ax


@drawn(
    name="tutor-space",
    alt="Five small pictures: a mean face, and four eigenimages that look like ghosts of faces, "
    "with other hair and other light.",
    caption="The mean face Ψ of the gallery, and the first four eigenimages, the directions in "
    "which the gallery varies most. Adding an eigenimage to a face brightens what is bright in it, "
    "and darkens what is dark: hair against skin in the first, the sides of the face in the next.",
    cols=5,
    width=7.6,
    height=1.7,
    gridspec_kw={"left": 0.01, "right": 0.99, "bottom": 0.02, "top": 0.84, "wspace": 0.06},
)
def space(axes: np.ndarray, gallery: Eigenfaces) -> None:
    """Draw the mean face and the first eigenimages."""
    picture(axes[0], gallery.mean)
    axes[0].set_title("Ψ")
    for k, (ax, image) in enumerate(zip(axes[1:], gallery.images, strict=False)):
        picture(ax, 0.5 + 0.5 * image / np.abs(image).max())
        ax.set_title(f"u{'₁₂₃₄'[k]}")


def asking(axes: np.ndarray, state: SimpleNamespace) -> None:
    """Draw a face, what eigenimages make of it, and its distances; axes cleared first."""
    left, middle, right = axes
    for ax in axes:
        ax.clear()
    picture(left, state.face)
    left.set_title("the face")
    picture(middle, state.rebuilt.clip(0, 1))
    middle.set_title("rebuilt")
    places = np.arange(len(state.distances))
    colours = [MEANING["right" if state.named == k else "expected"] for k in places]
    right.bar(places, state.distances, width=0.6, color=colours)
    right.axhline(state.most, color=MEANING["wrong"], linewidth=1.8, linestyle="--")
    right.set(xlim=(-0.6, 2.6), ylim=(0, 6.5), ylabel="distance", xlabel="tutor")
    right.set_xticks(places, [f"{k + 1}" for k in places])
    named = "nobody" if state.named is None else f"tutor {state.named + 1}"
    right.set_title(f"taken for {named}")


@drawn(
    name="tutor-window",
    alt="Two pictures of a film. In the first a tight dashed frame surrounds a face that looks to "
    "the camera. In the second the face looks away, and the frame is much wider.",
    caption="(a) A face that was found in the picture before. (b) The same face when it has not "
    "been found for some pictures. Cross: the predicted middle of the face, and three standard "
    "deviations to each side. Dashed: the window in which the detector looks, which is wider by "
    "the face and a margin. Dotted: the true face. The cross has grown, and the window with it.",
    cols=2,
    width=7.6,
    height=2.9,
    gridspec_kw={**_PHOTO, "wspace": 0.03},
)
def window(axes: np.ndarray, steps: Sequence[SimpleNamespace]) -> None:
    """Draw what is predicted of a face, and where it is looked for."""
    for ax, step in zip(axes, steps, strict=True):
        picture(ax, step.frame)
        belief = step.expected.belief
        (u, v), reach = belief.mean[:2], 3 * np.sqrt(np.diag(belief.cov)[:2])
        square(ax, step.truth, MEANING["truth"], linewidth=2.6, linestyle=":")
        square(ax, step.window, MEANING["camera"], linewidth=2.0, linestyle="--")
        ax.plot([u - reach[0], u + reach[0]], [v, v], color=MEANING["estimate"], linewidth=2.4)
        ax.plot([u, u], [v - reach[1], v + reach[1]], color=MEANING["estimate"], linewidth=2.4)


@drawn(
    name="tutor-weights",
    alt="(a) A face with some hundred dots on it, the largest in its middle. (b) Two densities "
    "against the distance from the detection: both fall, the detections' faster than the walk's. "
    "(c) The correction, smallest next to the detection and near two far from it.",
    caption="One step of the filter. (a) Its particles, larger with their weight π. (b) At each "
    "particle the density f of the walk (filled) and g of the detections (open), each as a share "
    "of its largest value, against the distance of the particle's middle from the nearest "
    "detection. (c) The correction f / (α g + (1 − α) f), which multiplies the likelihood. Near "
    "the detection, where g is large, it is small.",
    cols=3,
    width=7.8,
    height=2.6,
    gridspec_kw={"left": 0.01, "right": 0.99, "bottom": 0.19, "top": 0.97, "wspace": 0.28},
)
def weights(axes: np.ndarray, one: SimpleNamespace) -> None:
    """Draw particles, the two densities at them, and the correction of their weights."""
    left, middle, right = axes
    picture(left, one.image)
    share = one.weights / one.weights.max()
    left.scatter(*one.particles[:, :2].T, s=2 + 40 * share, color=MEANING["estimate"], linewidths=0)
    u, v = one.particles[:, :2].T
    left.set(xlim=(u.min() - 15, u.max() + 15), ylim=(v.max() + 25, v.min() - 25))
    middle.plot(one.off, one.f / one.f.max(), "o", color=MEANING["estimate"], markersize=3,
                label="f")  # fmt: skip
    middle.plot(one.off, one.g / one.g.max(), "o", color=MEANING["camera"], markersize=4,
                fillstyle="none", label="g")  # fmt: skip
    middle.set(xlabel="from the detection (px)", ylabel="f, g over their largest", ylim=(0, 1.05))
    middle.legend(loc="upper right")
    right.plot(one.off, one.correction, "o", color=MEANING["estimate"], markersize=3)
    right.set(xlabel="from the detection (px)", ylabel="correction", ylim=(0, None))
