"""Figures of the chapter "A head by its colours".

What they draw is made in the notebook: a namespace with the names that a drawing reads.
"""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.style import MEANING, label
from robot_perception.appearance.head_ellipse import Ellipse
from robot_perception.chapters.head_tracking.recordings import OFF, Girl
from studies.rows import Rows
from studies.stored.recordings import Read

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
def hero(axes: np.ndarray, shown: Sequence[SimpleNamespace]) -> None:
    """Draw some pictures of a film with the ellipses of the fixed and of the adapted model."""
    for ax, one in zip(axes, shown, strict=True):
        picture(ax, one.image)
        _near(ax, one.head)
        card(ax, one, linewidth=2.4)
        ax.set_title(f"frame {one.at}")


def card(ax: Axes, one: SimpleNamespace, linewidth: float = 3.0) -> Axes:
    """Draw the ellipses of the fixed and of the adapted model on the axes of a picture."""
    for name, line in (("fixed model", "--"), ("adapted model", "-")):
        ring(ax, one.rings[name], MEANING[name], linewidth=linewidth, linestyle=line)
    return ax


def tracked(axes: np.ndarray, state: SimpleNamespace) -> None:
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
        f"missed: fixed {state.missed['fixed']:.0%}, adapted {state.missed['adapted']:.0%}"
    )
    top.legend(loc="upper right", ncols=2)
    bottom.clear()
    bottom.plot(pictures, state.light, color=MEANING["light"], label="light on the head")
    bottom.plot(pictures, state.visible, ":", color=MEANING["truth"], label="visible part")
    bottom.set(xlim=(0, pictures[-1]), ylim=(0, 1.9), xlabel="frame", ylabel="factor, share")
    bottom.legend(loc="upper right", ncols=2)


def looked(axes: np.ndarray, state: SimpleNamespace) -> None:
    """Draw the picture, the colours of the head in it and in the first, and what they share."""
    left, right = axes
    for ax in axes:
        ax.clear()
    picture(left, state.image)
    for points, name, words in (
        (state.first, "fixed model", "frame 0"),
        (state.now, "adapted model", "this frame"),
    ):
        right.scatter(*points.T, s=7, color=MEANING[name], alpha=0.6, linewidths=0, label=words)
    right.set(xlim=(0, 765), ylim=(-110, 60), xlabel="R + G + B", ylabel="G − R")
    right.legend(loc="upper left")
    shared = {name: f"{share:.0%}" for name, share in state.common.items()}
    left.set_title(f"coarse {shared['opponent']}, finer {shared['opponent, finer cells']}")
    right.set_title(f"RGB {shared['RGB']}, rgb {shared['normalised rgb']}, HSI {shared['HSI']}")


@drawn(
    name="head-size",
    alt="Score against size: as printed, it is 1 for all ellipses smaller than the head and "
    "falls beyond; with shares it peaks at the head's size.",
    caption="Score of ellipses round the middle of the head, by size. As printed, every ellipse "
    "inside the head gets full marks. If shares are compared, the peak is at the size of the "
    "head.",
    height=3.0,
)
def by_size(ax: Axes, found: SimpleNamespace) -> Axes:
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
    caption="Two adjacent ellipses. The rim that is left behind is subtracted, the rim ahead is "
    "added. The rest is shared.",
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
def work(ax: Axes, half_widths: Sequence[int], carried: np.ndarray, summed: np.ndarray) -> Axes:
    """Draw how many numbers a search adds up against the size, in full and incrementally."""
    for counts, line, more in ((carried, "o-", ""), (summed, "o:", ", eq. 28 summed")):
        for k, (name, words) in enumerate((("plain", "counted anew"), ("right", "incremental"))):
            ax.plot(half_widths, counts[:, k], line, color=MEANING[name], label=words + more)
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
    alt="Panels of the missed share against the threshold, a line for each a. Where others pass "
    "the lines of the faster models fall as the threshold rises, and that of a = 0.1 ends below "
    "that of the fixed model; where nobody passes the threshold makes less of a difference.",
    caption=lambda rows, **_: (
        "How often the head is missed, by threshold, over the first "
        f"{len(rows.levels('film'))} of the films. (a) The light changes. (b) He turns his back, "
        "too. (c) Others pass as well. The key in (a) holds for all three. Dotted: a = 0.02, given "
        "up below a score of 0.45; no other tracker gives up."
    ),
    cols=3,
    width=7.4,
    height=3.6,
)
def grid(
    axes: np.ndarray, rows: Rows, *, lines: Mapping[str, Sequence[str]], gates: Sequence[float]
) -> None:
    """Draw the missed share against the threshold, by a and scene."""
    style = {"color": MEANING["adapted model"], "markersize": 4, "linewidth": 1.4}
    for ax, scene in zip(axes, rows.levels("scene"), strict=True):
        here = rows.where(scene=scene)
        fixed = here.of("missed", tracker="fixed").mean()
        ax.axhline(fixed, color=MEANING["fixed model"], linestyle="--", label="fixed")
        for (name, trackers), mark in zip(lines.items(), ("o-", "^-", "s-", "o:"), strict=True):
            missed = [here.of("missed", tracker=one).mean() for one in trackers]
            ax.plot(gates, missed, mark, label=name, **style)
        ax.set(xlabel="threshold", ylabel="missed (share of the frames)", ylim=(0, 1))
        ax.set_xticks(list(gates))
        ax.set_title(scene.rpartition(", ")[2])
    axes[0].legend(loc="upper left", handlelength=1.6)


@drawn(
    name="head-shine",
    alt="Three cut-outs of a rendered head: dull skin at first, then a bright spot on forehead "
    "and hair that grows.",
    caption="A head that begins to sweat under a white lamp: frames 0, 15 and 29 of two seconds. "
    "The light stays; skin and hair shine more and more.",
    cols=3,
    width=7.4,
    height=2.2,
    gridspec_kw=_PHOTOS,
)
def shine(axes: np.ndarray, images: Sequence[np.ndarray], heads: Sequence[np.ndarray]) -> None:
    """Draw some pictures of a head that shines more and more."""
    for ax, image, where in zip(axes, images, heads, strict=True):
        picture(ax, image)
        _near(ax, where)


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
    ax.set(xlabel="frame", ylabel="overlap with the head", ylim=(0, 1))
    ax.set_xlim(1, pictures[-1])
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 0.99), ncols=2, columnspacing=2.0)
    return ax
