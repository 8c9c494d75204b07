"""Drawings of particles in the corridor, of their weights, and of how they are resampled."""

from collections.abc import Mapping
from types import SimpleNamespace

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from explorables.figures import band, drawn
from explorables.figures.charts import curve
from explorables.figures.style import MEANING, AxesRow, label
from robot_perception.chapters.one_belief.figures import BELOW, corridor, filled
from studies.intervals import Interval

AREA = 1500.0
"""Area of all discs together, square points."""
NAMES = {
    "exact": "expected",
    "condensation": "particles",
    "auxiliary": "at worst",
    "importance": "intersection",
}
"""Meanings of the filters' colours elsewhere."""


def bubbles(
    ax: Axes, samples: Float[np.ndarray, "n"], weights: Float[np.ndarray, "n"], height: float
) -> None:
    """Draw particles as discs at a height, with areas as their weights."""
    some = weights > 1e-6
    pen = {"color": MEANING["particles"], "alpha": 0.45, "linewidth": 0, "clip_on": True}
    ax.scatter(samples[some], np.full(some.sum(), height), s=AREA * weights[some], **pen)


def _lost(ax: Axes, found: Mapping[str, Mapping[float, Interval]]) -> Axes:
    """Draw the share of lost drives by the deviation of the sensor, a line a filter."""
    for name, shares in found.items():
        curve(ax, list(shares), list(shares.values()), MEANING[NAMES[name]], label=name)
    ax.set_xscale("log")
    ax.set(xlabel="error of the sensor (m)", ylabel="share of drives lost", ylim=(0, 0.5))
    ax.set_xticks([0.02, 0.05, 0.1, 0.2, 0.5, 1.0], ["0.02", "0.05", "0.1", "0.2", "0.5", "1"])
    ax.minorticks_off()
    ax.legend(loc="upper center")
    return ax


@drawn(
    name="guesses-sharper",
    alt="Share of drives lost by the error of the sensor. With the exact belief it falls all the "
    "way as the sensor gets better. With two hundred particles it falls as well, down to one of "
    "two or three decimetres, and then rises steeply.",
    caption="Share of drives that end more than half a metre off, by the error of the sensor, with "
    "95 % intervals. The same drives, followed by a list of all places (exact) and by two hundred "
    "particles.",
    height=3.4,
)
def sharper(ax: Axes, found: Mapping[str, Mapping[float, Interval]]) -> Axes:
    """Draw how a better sensor loses the robot."""
    return _lost(ax, found)


@drawn(
    name="guesses-mended",
    alt="The share of drives lost by the error of the sensor, for three filters and the exact "
    "belief. Condensation rises steeply as the sensor gets better, the auxiliary filter less so, "
    "and importance sampling stays close to the exact belief.",
    caption="Share of drives that end more than half a metre off, by the error of the sensor, with "
    "95 % intervals: a list of all places (exact), and three filters with two hundred particles, "
    "on the same drives.",
    height=3.4,
)
def mended(ax: Axes, found: Mapping[str, Mapping[float, Interval]]) -> Axes:
    """Draw the share of lost drives of all filters."""
    return _lost(ax, found)


def crowd(ax: Axes, now: SimpleNamespace) -> Axes:
    """Draw the exact belief, how the particles' weights are spread, and the particles."""
    ax.clear()
    filled(ax, now.places, now.exact, MEANING["expected"], "exact")
    ax.stairs(now.heights, now.edges, color=MEANING["particles"], linewidth=1.8, label="particles")
    corridor(ax, now.world, now.top, now.robot)
    bubbles(ax, now.samples, now.weights, -0.5 * BELOW * now.top)
    ax.set(
        ylabel="density (1/m)", title=f"worth {now.effective:.0f} of {len(now.samples)} particles"
    )
    ax.legend(loc="upper right")
    return ax


@drawn(
    name="guesses-step",
    alt="Four rows of discs over the corridor. Weighted particles; the heavy ones repeated and the "
    "light ones gone; all moved by a metre and scattered; weighted anew by the next measurement.",
    caption="One step. Discs: forty particles, with areas as their weights. Curve: the exact "
    "belief at the start and at the end. Forty are too few: humps far along the "
    "corridor get hardly any weight.",
    rows=4,
    height=6.4,
)
def step(axes: AxesRow, told: SimpleNamespace) -> AxesRow:
    """Draw particles before a step, drawn, moved, and weighed."""
    rows = zip(axes, told.crowds, told.exact, told.titles, strict=True)
    for ax, (samples, weights), exact, title in rows:
        if exact is not None:
            filled(ax, told.places, exact, MEANING["expected"])
        corridor(ax, told.world, told.top)
        bubbles(ax, samples, weights, 0.45 * told.top)
        ax.set_title(title)
        ax.set_yticks([])
        if ax is not axes[-1]:
            ax.set_xlabel("")
    return axes


def weighted(ax: Axes, now: SimpleNamespace) -> Axes:
    """Draw what is wanted, what particles were drawn from, and the weighted particles."""
    ax.clear()
    filled(ax, now.places, now.f, MEANING["expected"], "wanted, f")
    ax.plot(now.places, now.g, "--", color=MEANING["at worst"], label="drawn from, g")
    corridor(ax, now.world, now.top)
    bubbles(ax, now.samples, now.weights, -0.5 * BELOW * now.top)
    ax.plot(now.centre, 0, "o", color=MEANING["at worst"], markersize=9)
    ax.set(ylabel="density (1/m)")
    ax.set_title(f"worth {now.effective:.0f}; beyond 11 m: {now.told:.0%}, exactly {now.true:.0%}")
    ax.legend(loc="upper left")
    return ax


def comb(axes: AxesRow, now: SimpleNamespace) -> AxesRow:
    """Draw the sum of the weights as stairs with the points on it, and how often each is drawn."""
    above, below = axes
    above.clear()
    below.clear()
    n = len(now.weights)
    sums = np.concatenate([[0.0], np.cumsum(now.weights)])
    above.stairs(sums[1:], np.arange(n + 1) - 0.5, color=MEANING["expected"], linewidth=1.8)
    for point, particle in zip(now.points, now.drawn, strict=True):
        ends = [-0.5, particle - 0.5]
        above.plot(ends, [point, point], color=MEANING["particles"], linewidth=1.0)
        above.plot(particle - 0.5, point, ">", color=MEANING["particles"], markersize=5)
    above.set(xlim=(-0.5, n - 0.5), ylim=(0, 1.02), ylabel="sum of the weights")
    above.set_title(f"{now.scheme}: off by {now.off:.1f} at most")
    band(below, np.arange(n), np.zeros(n), np.zeros(n), MEANING["expected"])
    below.bar(np.arange(n), n * now.weights, color=MEANING["expected"], alpha=0.35, width=0.8)
    below.plot(np.arange(n), now.counts, "o", color=MEANING["particles"])
    label(below, n - 0.6, 6.2, "bars: expected; dots: drawn", MEANING["mean"], ha="right")
    below.set(xlim=(-0.5, n - 0.5), ylim=(0, 7), xlabel="particle", ylabel="times drawn")
    for ax in axes:
        ax.set_xticks(range(n), [str(k + 1) for k in range(n)])
    return axes
