"""Drawings of the chapter: sizes of a head, particles and how near they come, films that are lost.

What they draw is made in the notebook: a namespace with the names that a drawing reads.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.maps import picture
from explorables.figures.style import MEANING, label
from studies.rows import Rows

_TURN = np.linspace(0, 2 * np.pi, 73)
_PHOTO = {"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.91}
_OF = ("paper", "robot", "agreement")
"""Meanings of colours of the rules, in the order in which sizes are handed in."""


def _ring(ax: Axes, now: Any, size: float, colour: str, **kwargs: object) -> None:
    """Draw an upright ellipse round the true middle, so many times the true size."""
    (u, v), half = now.middle, size * now.true
    ax.plot(u + half * np.cos(_TURN), v + 1.2 * half * np.sin(_TURN), color=colour, **kwargs)


@drawn(
    name="parts-head",
    alt="A rendered room with a head. Ellipse A is a dot inside the head, B is six times as large "
    "as the head, and C lies on it.",
    caption="The last frame of a film of ten seconds. Dashed: the true head. A, B, C: the size by "
    "three rules; the middle is told.",
    width=5.2,
    height=4.0,
    gridspec_kw=_PHOTO,
)
def heads(ax: Axes, now: Any, sizes: Mapping[str, float]) -> Axes:
    """Draw a frame with the true head and the ellipses of some rules, each with its name."""
    picture(ax, now.image)
    _ring(ax, now, 1.0, MEANING["truth"], linestyle="--", linewidth=1.4)
    u, v = now.middle
    for (name, size), meaning in zip(sizes.items(), _OF, strict=False):
        colour, half = MEANING[meaning], 1.2 * size * now.true
        _ring(ax, now, size, colour, linewidth=2.2)
        letter = {"fontsize": 14 if len(name) == 1 else 10}
        if size < 0.5:  # within the head: the name stands below that
            label(ax, u, v + 1.2 * now.true + 12, name, colour, ha="center", **letter)
        elif v - half > 20:
            label(ax, u, v - half - 8, name, colour, ha="center", **letter)
        else:
            label(ax, 12, 12, name, colour, **letter)
    return ax


def sized(ax: Axes, now: Any) -> Axes:
    """Draw a frame with the true head and the ellipse of one rule, on axes cleared first."""
    ax.clear()
    picture(ax, now.image)
    _ring(ax, now, 1.0, MEANING["truth"], linestyle="--", linewidth=1.4)
    _ring(ax, now, now.size, MEANING["estimate"], linewidth=2.4)
    ax.set_title(f"{now.size:.2f} times the head")
    return ax


@drawn(
    name="parts-courses",
    alt="Size over true size against frames, on a logarithmic scale: one line falls to a fifth, "
    "one rises to five, three stay at one.",
    caption="Size over the true size, median of sixty films. Three rules keep the size; their "
    "lines lie on one another near 1.",
    height=3.4,
)
def courses(ax: Axes, rows: Rows, strays: Mapping[str, str]) -> Axes:
    """Draw the median size over frames by each rule; those that stray have a name."""
    for name in rows.levels("measure"):
        frames = rows.levels("frame")
        median = [np.median(rows.where(measure=name).of("size", frame=k)) for k in frames]
        colour = MEANING[strays.get(name, "expected")]
        ax.plot(frames, median, color=colour, linewidth=2.2)
        if name in strays:
            label(ax, frames[4], median[4] * (1.6 if median[4] > 1 else 0.66), name, colour)
    label(ax, frames[4], 1.35, "the other three", MEANING["expected"])
    ax.set(yscale="log", ylim=(0.1, 10), xlabel="frame", ylabel="size over the true one")
    ax.set_yticks([0.2, 0.5, 1, 2, 5], ["0.2", "0.5", "1", "2", "5"])
    return ax


def reached(ax: Axes, now: Any) -> Axes:
    """Draw the error and the nearest particle by the number of particles, on axes cleared first."""
    ax.clear()
    for name, meaning, values in (
        ("error of the tracker", "robot", now.error),
        ("nearest particle", "expected", now.nearest),
    ):
        ax.plot(now.counts, values, "o-", color=MEANING[meaning], linewidth=2.2)
        above = meaning == "robot"
        end = values.max() + 0.4 if above else values.min() - 0.4
        label(ax, now.counts[-1], end, name, MEANING[meaning], ha="right")
    ax.set(xscale="log", ylim=(-0.6, 5.6), xlabel="particles", ylabel="distance from the truth (σ)")
    ax.set_xticks(now.counts, [f"{n}" for n in now.counts])
    ax.minorticks_off()
    return ax


def gated(ax: Axes, now: Any) -> Axes:
    """Draw what each gate loses to one event and to the other, a mark a threshold, on cleared axes.

    A ring marks the threshold that is chosen.
    """
    ax.clear()
    places = {"score": ("robot", -3, -0.1), "change": ("readings", 2, 0.03)}  # beside a mark
    for name, curve in now.curves.items():
        meaning, mark, up = places[name]
        ax.plot(*curve.T, "o-", color=MEANING[meaning], linewidth=2.0)
        label(ax, curve[mark, 0] + 0.03, curve[mark, 1] + up, f"by {name}", MEANING[meaning])
    for (name, (x, y)), aside in zip(now.ends.items(), (-0.06, 0.04), strict=True):
        ax.plot(x, y, "s", color=MEANING["rule"])
        label(ax, x + aside, y + 0.06, name, MEANING["rule"])
    ring = {"markersize": 16, "fillstyle": "none", "markeredgewidth": 2.4}
    ax.plot(now.light, now.stops, "o", color=MEANING["rule"], **ring)
    ax.set(xlim=(0, 1), ylim=(0, 1))
    ax.set(xlabel="share lost as the light fails", ylabel="share lost where somebody stops")
    ax.set_title(f"of all films {(now.light + now.stops) / 2:.0%} are lost")
    return ax
