"""Figures of the chapter "Two opinions, one belief".

What they draw is made in the notebook: a namespace with the names that a drawing reads.
"""

from types import SimpleNamespace

import numpy as np
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.style import MEANING, AxesRow, band, ellipses, label
from robot_perception.fusion import covariance_intersection

REACH = 2.3
"""Half the width of the explorer of two Gaussians, standard deviations of one unit."""


@drawn(
    name="ci-hero",
    alt="The estimated distance stays about twenty centimetres off while its band shrinks; after "
    "a few measurements the true distance lies outside the band and stays there.",
    caption="Twenty simulated sonar measurements of one distance, fused one by one as if their "
    "errors were independent. In truth three quarters of the variance are one error, the same in "
    "all of them. Line: the estimate in a run that ends with an error of typical size (1σ). Band: "
    "2σ as the robot states it.",
    height=3.6,
)
def heard(ax: Axes, found: SimpleNamespace) -> Axes:
    """Draw a typical run: the belief after each reading with 2σ, and where the person is."""
    mean, sigma = 100 * found.errors["Kalman"][found.typical], 100 * found.stated["Kalman"]
    times = np.arange(1, len(mean) + 1)
    band(ax, times, mean - 2 * sigma, mean + 2 * sigma, MEANING["Kalman"])
    ax.plot(times, mean, color=MEANING["Kalman"])
    ax.axhline(0, color=MEANING["truth"], linewidth=1.2)
    label(ax, times[-1], -4, "where the person is", MEANING["truth"], ha="right", va="top")
    ax.set(xlabel="measurements fused", ylabel="error of the distance (cm)")
    ax.set(xlim=(1, times[-1]), ylim=(-30, 70))
    ax.set_xticks(_readings(times))
    return ax


def _readings(times: np.ndarray) -> list[int]:
    return [1, *range(5, len(times) + 1, 5)]


def rumours(ax: Axes, found: SimpleNamespace) -> Axes:
    """Draw true over stated variance against the number of readings, by rule."""
    ax.clear()
    times = np.arange(1, len(found.ratio["Kalman"]) + 1)
    honest = np.ones(len(times))
    ax.plot(times, honest, color=MEANING["expected"], linewidth=7, alpha=0.3, label="honest")
    styles = zip(found.ratio.items(), ("-", "-", "--"), strict=True)
    for (rule, ratio), line in styles:
        ax.plot(times, ratio, line, color=MEANING[rule], label=rule)
    ax.set_yscale("log")
    ax.set(xlabel="measurements fused", ylabel="true / stated variance")
    ax.set(xlim=(1, times[-1]), ylim=(0.2, 100))
    ax.set_xticks(_readings(times))
    ax.legend(loc="upper left", ncols=2)
    return ax


def two_opinions(ax: Axes, state: SimpleNamespace) -> Axes:
    """Draw two beliefs, the stated covariance of the fused one, and the true one."""
    ax.clear()
    first, second = state.beliefs
    rule = "Kalman" if state.omega is None else "intersection"
    for cov, colour, name, more in (
        (first.cov, MEANING["first opinion"], "first opinion", {}),
        (second.cov, MEANING["second opinion"], "second opinion", {}),
        (state.stated, MEANING[rule], "fused, as stated", {"width": 2.6}),
        (state.true, MEANING["truth"], "fused, true", {"fill": 0.15}),
    ):
        ellipses(ax, np.zeros((1, 2)), cov[None], colour, deviations=1.0, corners=96, **more)
        ax.lines[-1].set_label(name)
    ax.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), aspect="equal")
    ax.set_title(f"true / stated variance: up to {state.ratio:.2f}")
    ax.set(xlabel="first number", ylabel="second number")
    ax.set_xticks(range(-2, 3))
    ax.set_yticks(range(-2, 3))
    ax.legend(loc="upper right", handlelength=1.2)
    return ax


def weighed(axes: AxesRow, state: SimpleNamespace) -> AxesRow:
    """Draw the two beliefs and what two weights make of them, and the areas by weight."""
    plane, below = axes
    plane.clear()
    fused = [
        covariance_intersection(state.sonar, state.camera, w) for w in (state.printed, state.least)
    ]
    beliefs = {
        "first opinion": state.sonar,
        "second opinion": state.camera,
        "equation 4": fused[0],
        "intersection": fused[1],
    }
    for name, belief in beliefs.items():
        cov = np.diag([1, np.rad2deg(1)]) @ belief.cov @ np.diag([1, np.rad2deg(1)])
        width = 2.6 if belief in fused else 1.4
        ellipses(
            plane,
            np.zeros((1, 2)),
            cov[None],
            MEANING[name],
            deviations=1.0,
            width=width,
            corners=48,
        )
    plane.set(xlim=(-2.3, 2.3), ylim=(-13, 13))
    plane.set(xlabel="error in distance (m)", ylabel="error in direction (°)")
    label(plane, 0.25, 11, "the sonar", MEANING["first opinion"])
    label(plane, -1.9, 4.5, "the camera", MEANING["second opinion"])
    areas(below, state)
    return axes


def areas(ax: Axes, state: SimpleNamespace) -> Axes:
    """Draw the area of the fused ellipse against the weight of the camera."""
    ax.clear()
    ax.plot(state.omegas, state.areas, color=MEANING["intersection"])
    ax.axhline(1, color=MEANING["first opinion"], linewidth=1.0, label="sonar alone")
    for omega, name, text, size in (
        (state.printed, "equation 4", "ω of eq. 4", 12),
        (state.least, "intersection", "best ω", 7),
    ):
        dot = {"color": MEANING[name], "markersize": size, "label": text}
        ax.plot(omega, state.area(omega), "o", clip_on=False, zorder=3, **dot)
    ax.set_yscale("log")
    ax.set(xlabel="ω, the weight of the camera", ylabel="area / area of the sonar's")
    ax.set(xlim=(0, 1), ylim=(0.05, 12))
    ax.legend(loc="upper left")
    return ax


@drawn(
    name="ci-certainty",
    alt="The weight rises steeply, then ever more slowly towards one; after six seconds it falls "
    "on a straight line until the hypothesis is deleted.",
    caption="Weight of a hypothesis that sonar measurements match for six seconds and then no "
    "more, by the paper's eqs 5 and 6 with values of ours. Dashed: above one threshold it counts "
    "as a person, below the other it is deleted. Would the curve differ if all the measurements "
    "were one echo?",
    height=3.2,
)
def certainty(
    ax: Axes, times: np.ndarray, values: np.ndarray, person: float, threshold: float
) -> Axes:
    """Draw the weight of a hypothesis over time, and the two thresholds it is compared with."""
    ax.plot(times, values, color=MEANING["estimate"])
    for level, name, side in ((person, "a person", "bottom"), (threshold, "deleted", "top")):
        ax.axhline(level, color=MEANING["expected"], linestyle="--", linewidth=1.2)
        off = 0.02 if side == "bottom" else -0.05
        label(ax, times[-1] / 3, level + off, name, MEANING["expected"], va=side)
    ax.set(xlabel="time (s)", ylabel="weight", xlim=(0, times[-1]), ylim=(0, 1))
    return ax
