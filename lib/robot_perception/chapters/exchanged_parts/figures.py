"""Drawings of the chapter: sizes of a head, distances of faces, guesses and what they are worth.

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
_ROWS = 10
"""Rows of the drawing of shares: eight coordinates, their product, and all at once."""
_OF = ("paper", "robot", "agreement", "readings", "anchor")
"""Meanings of colours of the rules, in the order in which sizes are handed in."""


def _ring(ax: Axes, now: Any, size: float, colour: str, **kwargs: object) -> None:
    """Draw an upright ellipse round the true middle, so many times the true size."""
    (u, v), half = now.middle, size * now.true
    ax.plot(u + half * np.cos(_TURN), v + 1.2 * half * np.sin(_TURN), color=colour, **kwargs)


@drawn(
    name="parts-head",
    alt="A rendered room with a head. One ellipse is a dot inside the head, one lies on it, and "
    "one is six times as large.",
    caption="The last frame of a film of ten seconds. Dashed: the true head. Its middle is told; "
    "the size follows the colours, by three rules.",
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
        if size < 0.5:  # within the head: the name stands below that
            label(ax, u, v + 1.2 * now.true + 12, name, colour, ha="center")
        elif v - half > 20:
            label(ax, u, v - half - 8, name, colour, ha="center")
        else:
            label(ax, 12, 12, name, colour)
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
    caption="Sizes over the true ones, medians of sixty films. Three rules keep the size; their "
    "lines cannot be told apart.",
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


def apart(ax: Axes, now: Any) -> Axes:
    """Draw distances of one's own pictures and of strangers', on axes cleared first."""
    ax.clear()
    rng = np.random.default_rng(0)
    rows = ((1, "own", "agreement", now.own), (0, "strangers", "robot", now.strange))
    for y, name, meaning, found in rows:
        x = np.sqrt(np.ravel(found)) / np.sqrt(now.limit)
        ax.plot(x, y + rng.uniform(-0.2, 0.2, x.size), "o", markersize=3, color=MEANING[meaning])
        label(ax, 0.03, y + 0.36, name, MEANING[meaning])
    ax.axvline(1, color=MEANING["rule"], linestyle="--")
    label(ax, 1.03, 1.36, "the limit", MEANING["rule"])
    ax.set(xlim=(0, 2.6), ylim=(-0.5, 1.6), xlabel="distance from the class, over the limit")
    ax.set_yticks([])
    ax.set_title(f"{(now.strange <= now.limit).mean():.0%} of the strangers are let in")
    return ax


def reached(ax: Axes, now: Any) -> Axes:
    """Draw the error and the nearest guess by the number of guesses, on axes cleared first."""
    ax.clear()
    for name, meaning, values in (
        ("error of the tracker", "robot", now.error),
        ("nearest guess", "expected", now.nearest),
    ):
        ax.plot(now.counts, values, "o-", color=MEANING[meaning], linewidth=2.2)
        above = meaning == "robot"
        end = values.max() + 0.4 if above else values.min() - 0.4
        label(ax, now.counts[-1], end, name, MEANING[meaning], ha="right")
    ax.set(xscale="log", ylim=(-0.6, 5.6), xlabel="guesses", ylabel="error (deviations)")
    ax.set_xticks(now.counts, [f"{n}" for n in now.counts])
    ax.minorticks_off()
    return ax


def counted(ax: Axes, now: Any) -> Axes:
    """Draw shares that count by coordinate, their product, and that of all, on cleared axes."""
    ax.clear()
    shares = (*now.alone, now.product, now.whole)
    names = (
        *(f"no. {k + 1}" for k in range(len(now.alone))),
        "product",
        "all",
    )
    colours = [MEANING["readings"]] * len(now.alone) + [MEANING["expected"], MEANING["robot"]]
    rows = _ROWS - np.arange(len(shares))  # from above; trackers of few numbers leave some free
    ax.barh(rows, shares, color=colours, left=1e-4, height=0.7)
    ax.set(xscale="log", xlim=(1e-4, 1.5), xlabel="share of the guesses that counts")
    ax.set_ylim(0.3, _ROWS + 0.7)
    ax.set_yticks(rows, names)
    ax.grid(visible=False, axis="y")
    return ax


@drawn(
    name="parts-trade",
    alt="Share of the films lost to who stops against share lost as the light goes. The curve of "
    "each gate runs from never learning, lost in the dark, to always learning, lost to who stops.",
    caption="Shares of the films. Each mark is a threshold; the best place is at the bottom left. "
    "Lines lead from the least threshold to the greatest, and on to a model that always learns.",
    width=5.2,
    height=4.2,
)
def trade(ax: Axes, rows: Rows, events: tuple[str, str], gates: Mapping[str, str]) -> Axes:
    """Draw what each gate loses to one event and to the other, a mark for each threshold."""

    def lost(gate: str, threshold: float) -> list[float]:
        return [rows.of("lost", event=e, gate=gate, threshold=threshold).mean() for e in events]

    never, always = lost("never", -1.0), lost("always", 1.0)
    places = ("robot", -3, -0.1), ("readings", 2, 0.03)  # beside a mark of each line
    for (gate, name), (meaning, mark, up) in zip(gates.items(), places, strict=True):
        thresholds = rows.where(gate=gate).levels("threshold")
        x, y = np.array([never, *(lost(gate, t) for t in thresholds), always]).T
        ax.plot(x, y, "o-", color=MEANING[meaning], linewidth=2.0)
        label(ax, x[mark] + 0.03, y[mark] + up, name, MEANING[meaning])
    for name, (x, y), aside in (("never", never, -0.06), ("always", always, 0.04)):
        ax.plot(x, y, "s", color=MEANING["rule"])
        label(ax, x + aside, y + 0.06, name, MEANING["rule"])
    ax.set(xlim=(0, 1), ylim=(0, 1), xlabel="lost as the light goes", ylabel="lost to who stops")
    return ax
