"""Figures of the chapter "Is it you?"."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from robot_perception.chapters.tutor_face import views
from robot_perception.chapters.tutor_face.detecting import TURNS
from robot_perception.evaluation.intervals import Interval
from robot_perception.teaching.figures import drawn
from robot_perception.teaching.figures.style import MEANING, band
from robot_perception.teaching.tables import Table

_PHOTO = {"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.99}


def picture(ax: Axes, image: np.ndarray) -> None:
    """Show a picture on axes without scales."""
    most = 255 if image.dtype == np.uint8 else 1.0
    ax.imshow(image, cmap="gray", vmin=0, vmax=most, interpolation="nearest")
    ax.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5))
    ax.set_xticks([])
    ax.set_yticks([])
    ax.grid(visible=False)


def square(ax: Axes, box: Float[np.ndarray, " 4"], colour: str, **kwargs: object) -> None:
    """Draw the outline of a box."""
    left, top, wide, high = box
    u = left + wide * np.array([0, 1, 1, 0, 0])
    v = top + high * np.array([0, 0, 1, 1, 0])
    ax.plot(u, v, color=colour, **kwargs)


def card(ax: Axes, met: views.Met) -> Axes:
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
    "that it does not know who that is. A picture in which it is right.",
    width=5.2,
    height=3.9,
    gridspec_kw=_PHOTO,
)
def hero(ax: Axes) -> Axes:
    """Draw two people of whom the robot knows one."""
    met = views.met()
    picture(ax, met.image)
    return card(ax, met)


@drawn(
    name="tutor-turns",
    alt="Share of faces found against the turn of the head: nearly all up to 15 degrees, less at "
    "30, few at 60.",
    caption="Share of the faces that the cascade finds, by the turn of the head. Bands: 95 %.",
    height=2.8,
)
def turns(ax: Axes, table: Table) -> Axes:
    """Draw the recorded rate by the turn of the head."""
    row: list[Interval] = list(table.rows["found"])
    band(ax, np.array(TURNS), *(np.array([getattr(of, end) for of in row]) for end in
                                ("low", "high")), MEANING["camera"])  # fmt: skip
    ax.plot(TURNS, [of.estimate for of in row], "-o", color=MEANING["camera"], markersize=4)
    ax.set(xlabel="turn of the head (°)", ylabel="found", xlim=(0, TURNS[-1]), ylim=(0, 1.02))
    return ax


@drawn(
    name="tutor-space",
    alt="Five small pictures: a mean face, and four eigenimages that look like ghosts of faces lit "
    "from different sides.",
    caption="The mean face of the gallery, and the four directions in which it varies most.",
    cols=5,
    width=7.6,
    height=1.7,
    gridspec_kw={"left": 0.01, "right": 0.99, "bottom": 0.02, "top": 0.84, "wspace": 0.06},
)
def space(axes: np.ndarray) -> None:
    """Draw the mean face and the first eigenimages."""
    gallery = views.space(20)
    picture(axes[0], gallery.mean)
    axes[0].set_title("Ψ")
    for k, (ax, image) in enumerate(zip(axes[1:], gallery.images, strict=False)):
        picture(ax, 0.5 + 0.5 * image / np.abs(image).max())
        ax.set_title(f"u{k + 1}")


def asking(axes: np.ndarray, state: views.Asked) -> None:
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
