"""Figures of the chapter "A head by its colours"."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from robot_perception.appearance.head_ellipse import Ellipse
from robot_perception.chapters.head_tracking import incremental, scene
from robot_perception.chapters.head_tracking.heads import GATES, GIVES_UP, OFF, RATES, RULES, pair
from robot_perception.chapters.head_tracking.recordings import Girl
from robot_perception.chapters.head_tracking.scene import Followed, HeadColours, Sizes
from robot_perception.teaching.figures import drawn
from robot_perception.teaching.figures.style import MEANING, label
from robot_perception.teaching.recordings import Read
from robot_perception.teaching.tables import Table

_TURN = np.linspace(0, 2 * np.pi, 73)
_PHOTOS = {"left": 0.01, "right": 0.99, "bottom": 0.02, "top": 0.86, "wspace": 0.06}


def ring(ax: Axes, ellipse: Float[np.ndarray, " 4"], colour: str, **kwargs: object) -> None:
    """Draw an ellipse of centre, half width and half height."""
    u, v, a, b = ellipse
    ax.plot(u + a * np.cos(_TURN), v + b * np.sin(_TURN), color=colour, **kwargs)


def picture(ax: Axes, image: np.ndarray) -> None:
    """Show a picture on axes without scales."""
    ax.imshow(image, interpolation="nearest")
    ax.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5))
    ax.set_xticks([])
    ax.set_yticks([])
    ax.grid(visible=False)


def _near(ax: Axes, ellipse: Float[np.ndarray, " 4"]) -> None:
    """Show of a picture what lies round a place."""
    u = np.clip(ellipse[0], 80, 240)
    v = np.clip(ellipse[1], 60, 180)
    ax.set(xlim=(u - 80, u + 80), ylim=(v + 60, v - 60))


@drawn(
    name="head-hero",
    alt="Three cut-outs of a rendered film with a man's head. At first two ellipses lie on the "
    "head. In frames 100 and 140 the light has changed, and the dashed blue one has slid off.",
    caption="A rendered head in changing light, at the start and after seven and nine seconds. "
    "Dashed: the tracker that keeps the colours of the first frame. Solid: the one that adapts.",
    cols=3,
    width=7.4,
    height=2.2,
    gridspec_kw=_PHOTOS,
)
def hero(axes: np.ndarray) -> None:
    """Draw some pictures of a film with the ellipses of the fixed and of the adapted model."""
    film, at = scene.filmed(scene.LIGHT), scene.SHOWN
    for ax, k in zip(axes, at, strict=True):
        picture(ax, film.frames[k])
        _near(ax, film.ellipses[k])
        card(ax, k, linewidth=2.4)
        ax.set_title(f"frame {k}")


def card(ax: Axes, at: int, linewidth: float = 3.0) -> Axes:
    """Draw the ellipses of the fixed and of the adapted model on the axes of a picture."""
    for rate, name, line in ((0.0, "fixed model", "--"), (RULES.rate, "adapted model", "-")):
        ellipse = scene.ellipses(scene.LIGHT, rate)[at]
        ring(ax, ellipse, MEANING[name], linewidth=linewidth, linestyle=line)
    return ax


def tracked(axes: np.ndarray, state: Followed) -> None:
    """Draw overlap by picture, and below it the light; axes cleared first."""
    top, bottom = axes
    pictures = np.arange(len(state.iou))
    top.clear()
    for iou, name in ((state.fixed, "fixed model"), (state.iou, "adapted model")):
        line = "--" if name == "fixed model" else "-"
        top.plot(pictures, iou, line, color=MEANING[name], label=name.split()[0], linewidth=1.8)
    top.axhline(OFF, color=MEANING["expected"], linewidth=1.0)
    label(
        top,
        float(pictures[-1]),
        OFF - 0.03,
        "off the head",
        MEANING["expected"],
        ha="right",
        va="top",
    )
    top.set(xlim=(0, pictures[-1]), ylim=(0, 1), xlabel="frame", ylabel="overlap with the head")
    top.set_title(
        f"missed: fixed {state.missed(state.fixed):.0%}, adapted {state.missed(state.iou):.0%}"
    )
    top.legend(loc="upper right", ncols=2)
    bottom.clear()
    bottom.plot(pictures, state.light, color=MEANING["light"], label="light")
    bottom.plot(pictures, state.visible, ":", color=MEANING["truth"], label="visible")
    bottom.set(xlim=(0, pictures[-1]), ylim=(0, 1.6), xlabel="frame", ylabel="share")
    bottom.legend(loc="upper right", ncols=2)


def looked(axes: np.ndarray, state: HeadColours) -> None:
    """Draw the picture, the colours of the head in it and in the first; axes cleared first."""
    left, right = axes
    left.clear()
    picture(left, state.image)
    right.clear()
    for points, name, size in ((state.first, "fixed model", 7), (state.now, "adapted model", 7)):
        words = "frame 0" if name == "fixed model" else "this frame"
        right.scatter(*points.T, s=size, color=MEANING[name], alpha=0.6, linewidths=0, label=words)
    right.set(xlim=(0, 765), ylim=(-110, 60), xlabel="R + G + B", ylabel="G − R")
    right.legend(loc="upper left")
    coarse, finer, rgb = (state.common[k] for k in ("opponent", "opponent, finer cells", "RGB"))
    left.set_title(f"coarse {coarse:.0%}")
    right.set_title(f"finer {finer:.0%}, RGB {rgb:.0%}")


@drawn(
    name="head-size",
    alt="Score against size: as printed, it is 1 for all ellipses smaller than the head and "
    "falls beyond; with shares it peaks at the head's size.",
    caption="Score of ellipses round the middle of the head, by size. As printed, every ellipse "
    "inside the head gets full marks. If shares are compared, the peak is at the size of the "
    "head.",
    height=3.0,
)
def by_size(ax: Axes, found: Sizes) -> Axes:
    """Draw the score of an ellipse against its size, with both ways to divide."""
    for scores, name, words in (
        (found.printed, "paper", "eq. 28, pixels"),
        (found.by_shares, "right", "shares"),
    ):
        ax.plot(found.half_widths, scores, color=MEANING[name], label=words)
    ax.axvline(found.true, color=MEANING["truth"], linestyle="--", linewidth=1.2)
    label(ax, float(found.true) + 0.4, 0.05, "the head", MEANING["truth"])
    ax.set(xlabel="half width of the ellipse (px)", ylabel="intersection φ", ylim=(0, 1.05))
    ax.set_xlim(found.half_widths[0], found.half_widths[-1])
    ax.legend(loc="lower left")
    return ax


@drawn(
    name="head-step",
    alt="An ellipse of pixels and the same ellipse one pixel further right: the left rim is "
    "subtracted, the right rim is added, and the rest is shared.",
    caption="Two adjacent ellipses. Left rim: subtracted. Right rim: added. The rest is shared.",
    width=4.2,
    height=4.4,
)
def step_aside(ax: Axes, half_width: int = 10) -> Axes:
    """Draw the pixels of two adjacent ellipses: those they share, those that leave and enter."""
    size = 2 * half_width + 5, round(2.4 * half_width) + 5
    before = Ellipse(half_width + 2, size[1] // 2, half_width).mask(size)
    after = Ellipse(half_width + 3, size[1] // 2, half_width).mask(size)
    for mask, name, words in (
        (before & after, "expected", "shared"),
        (before & ~after, "error", "subtracted"),
        (after & ~before, "agreement", "added"),
    ):
        v, u = np.nonzero(mask)
        faint = 0.25 if words == "shared" else 1.0
        ax.scatter(u, v, s=26, marker="s", color=MEANING[name], alpha=faint, linewidths=0)
        ax.scatter([], [], s=26, marker="s", color=MEANING[name], label=words, alpha=faint)
    ax.set(aspect="equal", xlabel="column", ylabel="row", ylim=(size[1] + 0.5, -6.5))
    ax.set_xlim(-1.5, size[0] + 0.5)
    ax.legend(loc="upper center", ncols=3, columnspacing=0.8, handletextpad=0.1)
    return ax


@drawn(
    name="head-work",
    alt="Numbers added up in a search against size, both axes logarithmic: counted anew the line "
    "rises twice as steeply as the incremental one. With all cells summed at every candidate both "
    "lie higher, and the incremental one is nearly level.",
    caption="Numbers added up in a search of ± 8 pixels. Counted anew they grow with the area, "
    "incrementally with the circumference. Dotted: if eq. 28 is summed over all cells each time, "
    "that sum outweighs the pixels.",
    height=3.0,
)
def work(ax: Axes, half_widths: Sequence[int]) -> Axes:
    """Draw how many numbers a search adds up against the size, in full and incrementally."""
    for cells, line in ((0, "o-"), (incremental.REACHED, "o:")):
        counts = np.array([incremental.additions(w, 8, cells) for w in half_widths])
        for k, (name, words) in enumerate((("plain", "counted anew"), ("right", "incremental"))):
            label_ = f"{words}, eq. 28 summed" if cells else words
            ax.plot(half_widths, counts[:, k], line, color=MEANING[name], label=label_)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xticks(list(half_widths), [str(w) for w in half_widths])
    ax.set(xlabel="half width of the ellipse (px)", ylabel="numbers added in a search")
    ax.set_ylim(5e3, 5e7)
    ax.minorticks_off()
    ax.legend(loc="upper left")
    return ax


@drawn(
    name="head-grid",
    alt="Three panels, missed share against threshold, a line for each a; where others pass the "
    "lines fall with the threshold towards that of the fixed model, where only the light changes "
    "the thresholds make less of a difference.",
    caption="How often the head is missed, by threshold, over all films that are scored. Solid: "
    "never given up. Dotted: a = 0.02, given up below a score of 0.45. Dashed: the fixed model.",
    cols=3,
    width=7.4,
    height=2.6,
)
def grid(axes: np.ndarray, table: Table) -> None:
    """Draw the missed share against the threshold, by a and scene."""
    ways = [(rate, 0.0, "-", mark) for rate, mark in zip(RATES, "o^s", strict=True)]
    for ax, scene_ in zip(axes, table.columns, strict=True):
        ax.axhline(table["fixed", scene_], color=MEANING["fixed model"], linestyle="--")
        for rate, floor, line, mark in (*ways, (RULES.rate, GIVES_UP, ":", "o")):
            missed = [table[pair(rate, gate, floor), scene_] for gate in GATES]
            style = {"color": MEANING["adapted model"], "markersize": 4, "linewidth": 1.4}
            ax.plot(GATES, missed, line + mark, label=None if floor else f"a = {rate:g}", **style)
        ax.set(xlabel="threshold", ylabel="missed", ylim=(0, 1), title=scene_)
    axes[0].legend(loc="upper left")


@drawn(
    name="head-girl",
    alt="Four frames of a girl: three times her face, at last the back of her head. The ellipse "
    "of the fixed model stays on or near the marked head; that of the one adapted fast has left "
    "it in the last two.",
    caption=lambda read, shown: (
        "Thin: the marked head. Dashed: the fixed model. Solid: the "
        "one adapted fast. " + read.note.replace("`", "")
    ),
    cols=4,
    width=7.4,
    height=1.8,
    gridspec_kw=_PHOTOS,
)
def girl(axes: np.ndarray, read: Read[Girl], shown: Sequence[int]) -> None:
    """Draw some pictures of the recording with the marked head and two trackers."""
    result = read.result
    for ax, k in zip(axes, shown, strict=True):
        at = int(result.shown[k])
        picture(ax, result.frames[k])
        ring(ax, result.marked[at], MEANING["truth"], linewidth=1.6)
        for name, meaning, line in (
            ("fixed", "fixed model", "--"),
            ("adapted fast", "adapted model", "-"),
        ):
            ellipse = result.ellipses[result.variants.index(name), at]
            ring(ax, ellipse, MEANING[meaning], linewidth=2.0, linestyle=line)
        ax.set_title(f"frame {at + 1}")


@drawn(
    name="head-girl-overlap",
    alt="Overlap by frame of four trackers: the model adapted fast falls to zero before frame "
    "100 and stays there; CamShift loses the head again and again; the fixed and the slowly "
    "adapted model go up and down and seldom fall below 0.2.",
    caption="Overlap with the marked head in each frame of the recording, started on the first. "
    "Thin: adapted slowly.",
    height=3.0,
)
def girl_overlap(ax: Axes, result: Girl) -> Axes:
    """Draw overlap by picture of the trackers that the text speaks of."""
    pictures = np.arange(1, result.iou.shape[1] + 1)
    for name, meaning, line, width in (
        ("CamShift", "CamShift", ":", 1.6),
        ("fixed", "fixed model", "--", 1.6),
        ("adapted", "adapted model", "-", 0.8),
        ("adapted fast", "adapted model", "-", 1.6),
    ):
        iou = result.iou[result.variants.index(name)]
        ax.plot(pictures, iou, line, color=MEANING[meaning], label=name, linewidth=width)
    ax.set(xlabel="frame", ylabel="overlap with the marked head", ylim=(0, 1))
    ax.set_xlim(1, pictures[-1])
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 0.99), ncols=4, columnspacing=1.2)
    return ax
