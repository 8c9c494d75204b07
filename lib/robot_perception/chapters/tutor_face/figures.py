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
    caption="Share of the faces that the cascade finds, by the turn of the head. Bands: 95 %.",
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
    caption="The mean face of the gallery, and the four directions in which it varies most.",
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
        ax.set_title(f"u{k + 1}")


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
    caption="(a) A face that was found in the picture before. (b) One that has not been found "
    "for some pictures. Cross: three standard deviations of the predicted middle, to each side. "
    "Dashed: the window in which the detector looks, wider by the face and a margin. Dotted: the "
    "true face.",
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
    alt="(a) A picture with some hundred dots round a face, large ones in its middle. (b) Two "
    "clouds of densities over the column, the detections' narrower than the walk's. (c) The "
    "correction, at most two, smallest at the columns where the detections are.",
    caption="One step of the filter. (a) Its particles, larger with their weight π. (b) At "
    "each particle the density f of the walk (filled) and g of the detections (open), each as a "
    "share of its largest value. (c) The correction f / (α g + (1 − α) f), which multiplies "
    "the likelihood.",
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
    sizes = 2 + 40 * share
    left.scatter(*one.particles[:, :2].T, s=sizes, color=MEANING["estimate"], linewidths=0)
    u, v = one.particles[:, :2].T
    left.set(xlim=(u.min() - 45, u.max() + 45), ylim=(v.max() + 60, v.min() - 50))
    middle.plot(u, one.f / one.f.max(), "o", color=MEANING["estimate"], markersize=3, label="f")
    middle.plot(u, one.g / one.g.max(), "o", color=MEANING["camera"], markersize=4,
                fillstyle="none", label="g")  # fmt: skip
    middle.set(xlabel="column (px)", ylabel="f, g over their largest", ylim=(0, 1.05))
    middle.legend(loc="upper right")
    right.plot(u, one.correction, "o", color=MEANING["estimate"], markersize=3)
    right.set(xlabel="column (px)", ylabel="correction", ylim=(0, None))
