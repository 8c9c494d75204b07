"""Figures of the chapter "Colour and shape": films, colours, samples, one iteration, snakes."""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace

import numpy as np
from jaxtyping import Float, UInt8
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from data_synth.coloured import Sequence as Film
from explorables.figures import drawn
from explorables.figures.style import MEANING, label, on_plate
from robot_perception.appearance.affine_snake import area
from robot_perception.chapters.colour_and_shape.films import LINES, outline, picture

LOST = 0.2
"""Overlap below which an outline is no longer on the object."""
STEPS = {
    "a": "samples with their weights",
    "b": "drawn, some more than once",
    "c": "moved by A",
    "d": "scattered by B",
    "e": "weighed by the frame",
}


def _near(ax: Axes, points: np.ndarray, half: float = 60.0) -> None:
    """Show of a picture what lies round some points."""
    u, v = (points.min(axis=0) + points.max(axis=0)) / 2
    u, v = np.clip(u, 4 / 3 * half, 319 - 4 / 3 * half), np.clip(v, half, 239 - half)
    ax.set(xlim=(u - 4 / 3 * half, u + 4 / 3 * half), ylim=(v + half, v - half))


# The experiments ---------------------------------------------------------------------------------

_PHOTOS = {
    "left": 0.01,
    "right": 0.99,
    "bottom": 0.02,
    "top": 0.94,
    "wspace": 0.04,
    "hspace": 0.14,
}


@drawn(
    name="shape-four",
    alt="A frame of each of four films: a circle, a rectangle under a lamp, a beetle, a snail. "
    "The red outline lies on the true one in all; the purple one has slid off all but the "
    "circle; the olive one runs round the whole frame, or lies on another card.",
    caption="Frame 50 of four films. Dotted: the truth. Red: colour and shape fused. Purple, "
    "dashed: edges alone. Olive, dash-dotted: colours adapted without a check, which take in the "
    "whole frame in three. The films were picked to show where one cue fails. The subject is "
    "that of the paper's Fig. 13.",
    rows=2,
    cols=2,
    width=7.0,
    height=5.6,
    gridspec_kw=_PHOTOS,
)
def hero(
    axes: np.ndarray,
    films: Mapping[str, Film],
    tracks: Mapping[str, Mapping[str, np.ndarray]],
    at: int = 50,
) -> None:
    """Draw a frame of each experiment with the true outline and those of three trackers."""
    for ax, (world, film) in zip(axes.ravel(), films.items(), strict=True):
        picture(ax, film.frames[at])
        for name in reversed(tracks[world]):
            outline(ax, tracks[world][name][at - 1], name)
        outline(ax, film.outlines[at], "truth", linewidth=1.4)
        ax.set_title(world)
        height, width = film.frames[at].shape[:2]
        if area(tracks[world]["colours adapted"][at - 1]) > 0.9 * height * width:
            colour = MEANING["colours adapted"]
            label(ax, 0.03 * width, 0.94 * height, "colours: the whole frame", colour)


@drawn(
    name="shape-overlap",
    alt="Overlap by frame in each film: the fused tracker stays above 0.75; edges alone fall in "
    "three films, adapted colours in all four.",
    caption="Overlap (IoU) with the true outline by frame, in the same films. Below the line the "
    "outline counts as lost. On the circle the line of the fused tracker hides that of edges "
    "alone.",
    rows=2,
    cols=2,
    width=7.4,
    height=5.6,
)
def overlaps(axes: np.ndarray, found: Mapping[str, Mapping[str, np.ndarray]]) -> None:
    """Draw the overlap with the truth against the frame, by tracker, one experiment an axes."""
    for ax, (world, by_name) in zip(axes.ravel(), found.items(), strict=True):
        for name, values in by_name.items():
            k = np.arange(1, len(values) + 1)
            ax.plot(k, values, LINES[name], color=MEANING[name], label=name, linewidth=2.0)
        ax.axhline(LOST, color=MEANING["expected"], linewidth=1.0)
        label(ax, 0.5, LOST - 0.06, "lost", MEANING["expected"])
        ax.set(xlabel="frame", ylabel="overlap with the object", ylim=(0, 1.03))
        ax.set_xlim(0, k[-1])
        ax.set_title(world)
    axes[0, 0].legend(loc="center left", bbox_to_anchor=(0.0, 0.42))


@drawn(
    name="shape-samples-many",
    alt="Overlap against the number of samples, 1 to 50, in four films of each kind. Most films "
    "overlap far with any number; one or two of each kind only with many. With fifty samples all "
    "lie near 0.8 or above.",
    caption="Overlap of the fused tracker against the number of samples. Thin: each of four films "
    "of a kind. Thick: their mean.",
    rows=2,
    cols=2,
    width=7.4,
    height=5.0,
)
def many(axes: np.ndarray, found: Mapping[str, Mapping[int, np.ndarray]]) -> None:
    """Draw the overlap of the fused tracker in each film against the number of samples, by kind."""
    for ax, (world, cells) in zip(axes.ravel(), found.items(), strict=True):
        counts, films = list(cells), np.array([*cells.values()])
        ax.plot(counts, films, color=MEANING["fused"], linewidth=0.9, alpha=0.6)
        ax.plot(counts, films.mean(axis=1), "o-", color=MEANING["fused"], linewidth=2.4)
        ax.set_xscale("log")
        ax.set_xticks(counts, [str(count) for count in counts])
        ax.minorticks_off()
        ax.set(xlabel="samples N", ylabel="mean overlap", ylim=(0, 1.03))
        ax.set_title(world)


# Colours -----------------------------------------------------------------------------------------


@drawn(
    name="shape-path",
    alt="Two cut-outs of a reddish card, light and dark; and its mean colour, blue against red: a "
    "narrow path between dark and bright red, travelled to and fro.",
    caption="(a), (b) A card that goes round a lamp. (c) Its mean colour in each frame, blue "
    "against red, from 0 to 255, each point in the colour itself; rings mark the frames shown. It "
    "is the subject of the paper's Fig. 8.",
    cols=3,
    width=7.4,
    height=2.7,
    gridspec_kw={"left": 0.02, "right": 0.98, "wspace": 0.36},
)
def path(axes: Sequence[Axes], film: Film, at: Sequence[int]) -> None:
    """Draw some frames of a film, and in the last axes the way of the target's mean colour."""
    *pictures, ax = axes
    for panel, k in zip(pictures, at, strict=True):
        picture(panel, film.frames[k])
        _near(panel, film.outlines[k])
        panel.set_title(f"frame {k}")
    means = [image[mask].mean(axis=0) for image, mask in zip(film.frames, film.masks, strict=True)]
    colours = np.round(means).astype(np.uint8)
    red, _, blue = colours.T.astype(float)
    ax.plot(red, blue, color=MEANING["expected"], linewidth=0.8)
    ink = on_plate(ax)
    ax.scatter(red, blue, s=34, c=colours / 255, linewidths=0, zorder=3)
    for k in at:
        ax.plot(red[k], blue[k], "o", markersize=10, fillstyle="none", color=ink)
        where = {"xytext": (8, -10), "textcoords": "offset points"}
        ax.annotate(str(k), (red[k], blue[k]), color=ink, fontsize=10, **where)
    ax.set(xlim=_room(red, 0.15), ylim=_room(blue, 0.15), xlabel="red", ylabel="blue")
    ax.set_title("mean colour")


@drawn(
    name="shape-samples",
    alt="Three clouds of dark reddish colours, ever wider, and below what has these colours: the "
    "beetle with a leaf, the same with its legs, and the beetle with stones and shadow. The "
    "third weighs 0.",
    caption="Three samples of one frame: (a) the best, (b) a middling one, (c) the worst. Above: "
    "their colours. Below: the piece that has these colours, with the affine snake on it and all "
    "else faded. Weights are relative to the greatest. As in the paper's Fig. 11.",
    rows=2,
    cols=3,
    width=7.4,
    height=4.6,
    gridspec_kw=_PHOTOS | {"left": 0.09, "wspace": 0.52, "hspace": 0.34},
)
def samples(axes: Sequence[Sequence[Axes]], found: SimpleNamespace) -> None:
    """Draw colours of samples in the opponent space, one a column; below, what has such colours."""
    everything = _rgb(found.clouds.reshape(-1, 3))
    left, right = _room(everything.sum(axis=1))
    low, high = _room(everything[:, 1] - everything[:, 0])
    for above, below, cloud, blob, points, weight in zip(
        *axes, found.clouds, found.blobs, found.outlines, found.weights, strict=True
    ):
        colours = _rgb(cloud)
        x, y = colours.sum(axis=1), colours[:, 1] - colours[:, 0]
        on_plate(above)
        above.scatter(x, y, s=16, c=np.clip(colours, 0, 255) / 255, linewidths=0)
        above.set(xlim=(left, right), ylim=(low, high), xlabel="R + G + B", ylabel="G − R")
        above.set_title(f"weight {weight:.2f}")
        faded = 110 + found.image.astype(float) * 0.2
        shown = np.where(blob[..., None], found.image, faded)
        picture(below, np.round(shown).astype(np.uint8))
        _near(below, found.outlines[0], 62.0)
        closed = np.vstack([points, points[:1]])
        below.plot(*closed.T, color=MEANING["affine snake"], linewidth=2.2)


def _room(values: Float[np.ndarray, " n"], share: float = 0.08) -> tuple[float, float]:
    """Return limits with some room on both sides of values."""
    spare = share * np.ptp(values)
    return float(values.min() - spare), float(values.max() + spare)


def _rgb(opponent: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """Return red, green and blue of coordinates of the opponent space; beyond 0 … 255 as well."""
    blue_green, green_red = 511 * opponent[:, :2].T - 255
    green = (766 * opponent[:, 2] - blue_green + green_red) / 3
    return np.stack([green - green_red, green, green + blue_green], axis=-1)


# One iteration -----------------------------------------------------------------------------------

_TOP = {"a": 4.0, "b": 3.0, "c": 2.0, "d": 1.0, "e": 0.0}


def _sizes(weights: np.ndarray) -> np.ndarray:
    """Return areas of points, as large together for few samples as for many."""
    return np.clip(2400 * weights / weights.sum(), 3, 300)


def _joined(ax: Axes, start: np.ndarray, end: np.ndarray, top: float) -> None:
    """Draw where samples come from; fainter the more they are."""
    gap = np.full(len(start), np.nan)
    x = np.stack([start, end, gap], axis=1).ravel()
    y = np.tile([top - 0.12, top - 0.88, np.nan], len(start))
    faint = float(np.clip(12 / len(start), 0.15, 0.8))
    ax.plot(x, y, color=MEANING["expected"], linewidth=0.8, alpha=faint)


def iterated(ax: Axes, found: SimpleNamespace, step: str) -> None:
    """Draw an iteration up to one of its steps, each below the one before; axes cleared first."""
    ax.clear()
    even = np.ones(len(found.start))
    rows = {
        "a": (found.start, found.start_weights),
        "b": (found.start[found.ancestors], even),
        "c": (found.drifted, even),
        "d": (found.moved, even),
        "e": (found.moved, found.weights),
    }
    last = None
    for name, (places, weights) in rows.items():
        if name > step:
            break
        top = _TOP[name]
        if last is not None and name != "e":
            _joined(ax, found.start[found.ancestors] if name == "b" else last, places, top + 1)
        size = _sizes(weights)
        ax.scatter(
            places,
            np.full(len(places), top),
            s=size,
            color=MEANING["estimate"],
            alpha=0.45,
            linewidths=0,
            zorder=3,
        )
        label(ax, 1.0, top + 0.4, STEPS[name], MEANING["expected"], ha="right")
        last = places
    if step == "e":
        ax.fill_between(
            found.grid,
            -0.75,
            -0.75 + 0.6 * found.likelihood,
            color=MEANING["readings"],
            alpha=0.25,
            linewidth=0,
        )
        label(ax, 0.02, -0.55, "fit to the frame", MEANING["readings"])
    ax.set(xlim=(0, 1), ylim=(-0.8, 4.6), xlabel="brightness")
    ax.set_yticks(list(_TOP.values()), [f"({name})" for name in _TOP])
    ax.grid(visible=False)


def tried(ax: Axes, state: SimpleNamespace) -> None:
    """Draw the overlap by frame for a number of samples and a noise; axes cleared first."""
    ax.clear()
    k = np.arange(1, len(state.overlap) + 1)
    every = state.every.reshape(-1, len(k)).T
    ax.plot(k, every, color=MEANING["expected"], linewidth=1.2, alpha=0.6)
    ax.plot(k, state.overlap, color=MEANING["fused"], linewidth=2.6)
    ax.axhline(LOST, color=MEANING["expected"], linewidth=1.0)
    label(ax, 1.2, LOST - 0.06, "lost", MEANING["expected"])
    label(ax, 8.0, float(state.still[7]) + 0.03, "no noise", MEANING["expected"])
    ax.set(xlim=(1, k[-1]), ylim=(0, 1.03), xlabel="frame", ylabel="overlap with the circle")
    ax.set_title(f"on average {state.overlap.mean():.2f}")


# Snakes ------------------------------------------------------------------------------------------

HALF = 80.0
"""Half the width of what is shown round the shell, px; the height is three quarters of it."""

SLID = (2, 5, 12)
"""Steps of a snake that are drawn between its start and its end."""


def segmented(case: SimpleNamespace) -> UInt8[np.ndarray, "height width 3"]:
    """Return the frame with the blob as it is, its neck tinted, and all else faded."""
    faded = 110 + case.image.astype(float) * 0.2
    picture = np.where(case.blob[..., None], case.image, faded)
    neck = case.blob & case.neck
    tint = 255 * np.array(to_rgb(MEANING["neck"]))
    picture[neck] = 0.4 * picture[neck] + 0.6 * tint
    return np.round(picture).astype(np.uint8)


def near_shell(ax: Axes, case: SimpleNamespace) -> None:
    """Show of the axes of a picture what lies round the shell."""
    height, width = case.neck.shape
    u = np.clip(case.truth[:, 0].mean(), HALF - 0.5, width - 0.5 - HALF)
    v = np.clip(case.truth[:, 1].mean(), 0.75 * HALF - 0.5, height - 0.5 - 0.75 * HALF)
    ax.set(xlim=(u - HALF, u + HALF), ylim=(v + 0.75 * HALF, v - 0.75 * HALF))


def _closed(ax: Axes, points: np.ndarray, colour: str, **kwargs: object) -> None:
    """Draw a closed outline."""
    ax.plot(*np.vstack([points, points[:1]]).T, color=colour, **kwargs)


def slid(ax: Axes, state: SimpleNamespace) -> None:
    """Draw a snake from its start over some steps to its end, on the axes of the segmented frame.

    They are cleared first.
    """
    ax.clear()
    fit, colour = state.fit, MEANING[f"{state.snake} snake"]
    _closed(ax, fit.iterates[0], MEANING["truth"], linestyle="--", linewidth=1.4)
    for step in SLID:
        if step < len(fit.iterates) - 1:
            _closed(ax, fit.iterates[step], colour, linewidth=0.9, alpha=0.6)
    _closed(ax, fit.outline, colour, linewidth=2.4)
    near_shell(ax, state.case)
    words = f"overlap {state.overlap:.2f}, neck {state.swallowed:.0%}"
    label(ax, 0.03, 0.93, words, colour, transform=ax.transAxes, fontsize=12)


@drawn(
    name="shape-signs",
    alt="Weight against the ratio of areas: with the printed sign it is least where the area is "
    "right, with the other sign it is greatest there.",
    caption="Weight of a segmentation against its area, the two other scores being 1; here all μ "
    "are 1 and σ is 0.5. As printed, the right area gets the least weight.",
    height=3.0,
)
def signs(ax: Axes, ratios: np.ndarray, weights: Mapping[str, np.ndarray]) -> None:
    """Draw the weight of a segmentation against its area, with both signs."""
    looks = (("paper", "--"), ("right", "-"))
    for (sign, values), (meaning, line) in zip(weights.items(), looks, strict=True):
        ax.plot(ratios, values, line, color=MEANING[meaning], label=sign)
    ax.axvline(1, color=MEANING["expected"], linewidth=1.0)
    ax.set_xscale("log", base=2)
    ax.set_xticks([0.25, 0.5, 1, 2, 4], ["¼", "½", "1", "2", "4"])
    ax.set(xlabel="area found / area predicted", ylabel="weight", xlim=(0.25, 4), ylim=(0, 1.05))
    ax.legend(loc="lower left")
