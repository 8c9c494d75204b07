"""Figures of the chapter "Two opinions, one belief"."""

import numpy as np
from matplotlib.axes import Axes

from robot_perception.chapters.covariance_intersection import explorers, rumour
from robot_perception.chapters.covariance_intersection.explorers import Fused, Weighed
from robot_perception.chapters.covariance_intersection.rumour import Result
from robot_perception.teaching.figures.style import MEANING, band, ellipses, label

REACH = 2.3
"""Half the width of the explorer of two Gaussians, standard deviations of one unit."""


def heard(ax: Axes, result: Result, rule: str, run: int = 0) -> Axes:
    """Draw one run: the belief after each reading with 2σ, and where the person is."""
    ax.clear()
    times = np.arange(1, result.config.readings + 1)
    mean, sigma = 100 * result.errors[rule][run], 100 * result.stated[rule]
    band(ax, times, mean - 2 * sigma, mean + 2 * sigma, MEANING[rule])
    ax.plot(times, mean, color=MEANING[rule])
    ax.axhline(0, color=MEANING["truth"], linewidth=1.2)
    label(ax, times[-1], 3, "where the person is", MEANING["truth"], ha="right", va="bottom")
    ax.set(xlabel="readings heard", ylabel="distance, off by (cm)")
    ax.set(xlim=(1, times[-1]), ylim=(-30, 90))
    return ax


def rumours(ax: Axes, result: Result) -> Axes:
    """Draw true over stated variance against the number of readings, by rule."""
    ax.clear()
    times = np.arange(1, result.config.readings + 1)
    ax.plot(times, np.ones(len(times)), color=MEANING["expected"], linewidth=1.0)
    styles = zip(rumour.RULES, ("-", "-", "--"), strict=True)
    for rule, line in styles:
        ax.plot(times, result.ratio(rule), line, color=MEANING[rule], label=rule)
    ax.set_yscale("log")
    ax.set(xlabel="readings heard", ylabel="true / stated variance")
    ax.set(xlim=(1, times[-1]), ylim=(0.2, 30))
    ax.legend(loc="upper left")
    return ax


def two_opinions(ax: Axes, state: Fused) -> Axes:
    """Draw two beliefs, the stated covariance of the fused one, and the true one."""
    ax.clear()
    centre = np.zeros((1, 2))
    for belief, name in (
        (explorers.FIRST, "first opinion"),
        (explorers.SECOND, "second opinion"),
    ):
        ellipses(ax, centre, belief.cov[None], MEANING[name], deviations=1.0, corners=96)
    ellipses(
        ax,
        centre,
        state.stated[None],
        MEANING[state.rule],
        deviations=1.0,
        corners=96,
        width=2.2,
    )
    ellipses(ax, centre, state.true[None], MEANING["truth"], deviations=1.0, corners=96, fill=0.15)
    ax.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), aspect="equal")
    ax.set_title(f"true / stated variance: up to {state.ratio:.2f}")
    ax.set(xlabel="first number", ylabel="second number")
    return ax


def areas(ax: Axes, state: Weighed) -> Axes:
    """Draw the area of the fused ellipse against the weight of the camera."""
    ax.clear()
    ax.plot(state.omegas, state.areas, color=MEANING["intersection"])
    ax.axhline(1, color=MEANING["first opinion"], linewidth=1.0)
    label(ax, 0.02, 1.04, "sonar alone", MEANING["first opinion"], va="bottom")
    for omega, name, text in (
        (state.printed, "equation 4", "eq. 4"),
        (state.least, "intersection", "best"),
    ):
        ax.plot(omega, state.area(omega), "o", color=MEANING[name], markersize=8, label=text)
    ax.set_yscale("log")
    ax.set(xlabel="ω, the weight of the camera", ylabel="area over the sonar's")
    ax.set(xlim=(0, 1), ylim=(0.05, 12))
    ax.legend(loc="lower right")
    return ax


def certainty(ax: Axes, times: np.ndarray, values: np.ndarray, person: float) -> Axes:
    """Draw the weight of a hypothesis over time and the threshold above which it is a person."""
    ax.plot(times, values, color=MEANING["estimate"])
    ax.axhline(person, color=MEANING["expected"], linestyle="--", linewidth=1.2)
    label(ax, times[-1], person + 0.03, "a person", MEANING["expected"], ha="right", va="bottom")
    ax.set(xlabel="time (s)", ylabel="weight", xlim=(0, times[-1]), ylim=(0, 1))
    return ax
