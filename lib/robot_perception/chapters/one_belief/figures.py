"""Drawings of the corridor, and of what is believed of a place in it.

What they draw is made in the notebook: a namespace with the names that a drawing reads. ``world``
has the length of the corridor, its doors and half the width of a door, m.
"""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from explorables.figures import band, drawn, label
from explorables.figures.style import MEANING, AxesRow

BELOW = 0.2
"""The strip with the corridor is so high, as a share of the height of what is above it."""
DEVIATIONS = 2.0
"""All bands reach so far, standard deviations."""
HIGH, HIGHEST = 1.15, 1.3
"""Heights of the drawings of densities, 1/m."""


def corridor(ax: Axes, world: Any, top: float, robot: float | None = None) -> None:
    """Draw the corridor below the curves, with its doors, and the robot where it stands (m)."""
    ax.axhline(0, color=MEANING["truth"], linewidth=1.0)
    for door in world.doors:
        ends = [door - world.half, door + world.half]
        ax.plot(ends, [0, 0], color=MEANING["landmark"], linewidth=7, solid_capstyle="butt")
    if robot is not None:
        middle = -0.5 * BELOW * top
        ax.plot(robot, middle, marker=(3, 0, -90), color=MEANING["truth"], markersize=11)
    ax.set(xlim=(0, world.length), ylim=(-BELOW * top, top), xlabel="place in the corridor (m)")
    ax.set_xticks(range(0, int(world.length) + 1, 5))
    ax.set_yticks(
        [tick for tick in (0.0, 0.2, 0.5, 1.0, 2.0, 4.0) if top / 5 < tick < top or not tick]
    )


def filled(
    ax: Axes, x: Float[np.ndarray, "n"], y: Float[np.ndarray, "n"], colour: str, name: str = ""
) -> None:
    """Draw a curve over places, filled down to zero."""
    band(ax, x, np.zeros_like(y), y, colour)
    ax.plot(x, y, color=colour, label=name or None)


@drawn(
    name="belief-story",
    alt="Three drawings of the corridor. After the first word three equal humps stand at the three "
    "doors. After rolling they have moved by three metres and are wider. After the second word "
    "one tall hump stands at the door in the middle.",
    caption="What the robot believes of its place, after each step: density by place. Bars on the "
    "floor: the doors. Triangle: where the robot is, which it does not know.",
    rows=3,
    height=5.8,
)
def story(axes: AxesRow, told: SimpleNamespace) -> AxesRow:
    """Draw the beliefs after a word, a motion and a word."""
    for ax, belief, robot, title in zip(axes, told.beliefs, told.robot, told.titles, strict=True):
        filled(ax, told.places, belief, MEANING["estimate"])
        corridor(ax, told.world, HIGH, robot)
        ax.set(title=title, ylabel="1/m")
        if ax is not axes[-1]:
            ax.set_xlabel("")
    return axes


def _before(ax: Axes, x: np.ndarray, y: np.ndarray, name: str) -> None:
    """Draw what was believed before, dashed."""
    ax.plot(x, y, color=MEANING["expected"], linestyle="--", label=name)


def doors(ax: Axes, now: SimpleNamespace) -> Axes:
    """Draw what is expected after a motion, and what is believed after the second word."""
    ax.clear()
    _before(ax, now.places, now.expected, "before the word")
    filled(ax, now.places, now.belief, MEANING["estimate"], "after it")
    corridor(ax, now.world, HIGHEST, now.robot)
    ax.set(ylabel="density (1/m)", title=f"“{now.word}”: {now.share:.0%} near the robot")
    ax.legend(loc="upper left")
    return ax


@drawn(
    name="belief-two-doors",
    alt="After one word the belief has three humps, and the Gaussian with its mean and deviation "
    "is one wide hump whose middle is in front of a wall. After two words and a measurement of the "
    "laser belief and Gaussian are nearly the same narrow hump.",
    caption="Densities by place: a belief (filled), and the Gaussian of its mean and variance "
    "(dashed). After one word the Gaussian is highest in front of a wall; after the laser the two "
    "nearly agree.",
    rows=2,
    height=4.6,
)
def summaries(axes: AxesRow, told: SimpleNamespace) -> AxesRow:
    """Draw beliefs, each with the Gaussian of its mean and variance."""
    for ax, belief, gaussian, title, top in zip(
        axes, told.beliefs, told.gaussians, told.titles, (0.4, 1.8), strict=True
    ):
        filled(ax, told.places, belief, MEANING["estimate"])
        ax.plot(told.places, gaussian, "--", color=MEANING["Kalman"])
        corridor(ax, told.world, top)
        ax.set(title=title, ylabel="1/m")
    axes[0].set_xlabel("")
    return axes


def product(ax: Axes, now: SimpleNamespace) -> Axes:
    """Draw a belief, what a measurement says, and their product, as densities."""
    ax.clear()
    ax.plot(now.x, now.measurement, color=MEANING["second opinion"], label="measurement")
    filled(ax, now.x, now.posterior, MEANING["estimate"], "product")
    # dashed, for it may lie on the measurement
    ax.plot(now.x, now.prior, "--", color=MEANING["first opinion"], label="belief before")
    ax.set(xlim=(now.x[0], now.x[-1]), ylim=(-0.12, 1.7))
    ax.plot(now.z, 0, "^", color=MEANING["second opinion"], markersize=10)
    ax.set(xlabel="place in the corridor (m)", ylabel="density (1/m)")
    ax.set_title(f"K = {now.gain:.2f}, deviation {now.deviation:.2f} m")
    ax.legend(loc="upper left")
    return ax


def _errors(ax: Axes, steps: Sequence[int], mean: np.ndarray, sigma: np.ndarray, name: str) -> None:
    """Draw errors and the band that a filter states, about its own error."""
    band(ax, steps, mean - DEVIATIONS * sigma, mean + DEVIATIONS * sigma, MEANING[name])
    ax.plot(steps, mean, color=MEANING[name])


@drawn(
    name="belief-run",
    alt="Errors of thirty measurements scatter by some four decimetres about zero. The estimate's "
    "error stays within two decimetres or so, and its band, wide at first, soon keeps one width "
    "and nearly always holds zero.",
    caption="One drive. Dots: error of each measurement. Line: error of the estimate; band: 2σ as "
    "the filter states it. The true place is at zero.",
    height=3.2,
)
def run(ax: Axes, told: SimpleNamespace) -> Axes:
    """Draw the error of measurements and of the filter."""
    steps = np.arange(1, len(told.x) + 1)
    ax.plot(steps, told.z - told.x, "o", color=MEANING["readings"], markersize=4)
    _errors(ax, steps, told.means - told.x, np.sqrt(told.variances), "estimate")
    ax.axhline(0, color=MEANING["truth"], linewidth=1.2)
    ax.set(xlabel="measurements", ylabel="error (m)", xlim=(1, steps[-1]), ylim=(-1.3, 1.3))
    return ax


@drawn(
    name="belief-lag",
    alt="While the robot is pushed, the filter of places falls behind by almost two metres and "
    "its band does not hold zero. The filter of place and speed falls behind at first, catches up "
    "within some steps, and overshoots when the robot is stopped.",
    caption="Somebody pushes the robot from step 6 to step 26 (shaded). Errors of two filters, "
    "with 2σ as each states it: one knows places alone, the other speed as well. The true place is "
    "at zero.",
    height=3.4,
)
def lag(ax: Axes, told: SimpleNamespace) -> Axes:
    """Draw the errors of two filters while the robot is pushed."""
    steps = np.arange(1, len(told.x) + 1)
    ax.axvspan(*told.pushed, color=MEANING["expected"], alpha=0.13, linewidth=0)
    for name, (mean, variance) in told.filters.items():
        _errors(ax, steps, mean - told.x, np.sqrt(variance), name)
    ax.axhline(0, color=MEANING["truth"], linewidth=1.2)
    label(ax, 34.5, -1.75, "place alone", MEANING["Kalman"], ha="right", va="top")
    label(ax, 34.5, 1.3, "place and speed", MEANING["estimate"], ha="right")
    ax.set(xlabel="measurements", ylabel="error (m)", xlim=(1, steps[-1]), ylim=(-2.6, 2.0))
    return ax


def bearing(ax: Axes, now: SimpleNamespace) -> Axes:
    """Draw a belief, the exact one after a bearing, and the one of the extended filter."""
    ax.clear()
    _before(ax, now.x, now.prior, "before")
    filled(ax, now.x, now.exact, MEANING["truth"], "exact")
    ax.plot(now.x, now.extended, color=MEANING["Kalman"], label="extended filter")
    corridor(ax, now.world, HIGHEST, now.robot)
    place, height = now.lamp[0], 0.92 * HIGHEST
    ax.plot(place, height, "*", color=MEANING["anchor"], markersize=12)
    ax.plot([now.robot, place], [0, height], ":", color=MEANING["anchor"], linewidth=1.2)
    ax.plot(now.believed, 0, "o", color=MEANING["expected"], markersize=8)
    ax.set_title(f"filter's mean: off by {now.off:.1f} exact deviations")
    ax.set_ylabel("scaled to height 1")
    ax.legend(loc="upper left")
    return ax


@drawn(
    name="belief-bearings",
    alt="The deviation of the filter falls from a metre to about a decimetre as the robot passes "
    "the lamp, and grows again beyond it. Zero hardly ever leaves the band.",
    caption="One drive past the lamp (dotted: where it hangs). Thick line: error of the extended "
    "filter; band: 2σ as it states it. Dashed: 2σ of the exact belief. Thin line: the true place.",
    height=3.2,
)
def passing(ax: Axes, told: SimpleNamespace) -> Axes:
    """Draw the error of the extended filter by place, and the width of the exact belief."""
    ax.axvline(told.lamp[0], linestyle=":", color=MEANING["anchor"], linewidth=1.6)
    _errors(ax, told.x, told.means - told.x, np.sqrt(told.variances), "Kalman")
    for side in (-DEVIATIONS, DEVIATIONS):
        edge = told.exact_means - told.x + side * told.exact_deviations
        ax.plot(told.x, edge, "--", color=MEANING["truth"], linewidth=1.0)
    ax.axhline(0, color=MEANING["truth"], linewidth=1.2)
    ax.set(xlabel="place in the corridor (m)", ylabel="error (m)")
    ax.set(xlim=(told.x[0], told.x[-1]), ylim=(-2.2, 2.2))
    return ax
