"""Drawings of the chapter: numbers and axes in, axes out."""

from collections.abc import Mapping, Sequence
from textwrap import fill
from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import ScalarFormatter

from explorables.figures import drawn
from explorables.figures.style import MEANING, AxesRow, band, ellipses, label
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.slam.monobot import MonobotRun

MEASUREMENTS = "measurements after the first"

Runs = Any
"""Runs of an experiment, as the notebook makes them: ``positions``,
``measurements``, ``means``, ``vehicle_errors`` and ``landmark_errors`` (runs first), ``deviations``
(measurements × states), and ``gains`` (steps × vehicle and landmark)."""

VARIANTS = ("plain", "overconfident", "out of order", "uncorrelated", "anchored")
"""Variants of the filter and their meanings, in the order of the chapter."""


# The rail --------------------------------------------------------------------------------------


def trajectory(ax: Axes, runs: Runs, run: int) -> Axes:
    """Draw one run as in the first column of Fig. 4: true path, estimates with ±2σ, sightings.

    A sighting is where one measurement alone, from the true path, puts the first landmark; every
    third is drawn.
    """
    position, means = runs.positions[run], runs.means[run]
    sightings = position + runs.measurements[run, :, 0]
    k, reach = np.arange(len(position)), 2 * runs.deviations
    vehicle, landmark, truth = MEANING["robot"], MEANING["landmark"], MEANING["truth"]
    for i, colour, alpha in ((0, vehicle, 0.18), (1, landmark, 0.28)):
        band(ax, k, means[:, i] - reach[:, i], means[:, i] + reach[:, i], colour, alpha=alpha)
    ax.plot(k[::3], sightings[::3], ".", color=MEANING["readings"], markersize=3, alpha=0.8)
    ax.plot(k, position, color=truth, linewidth=1.4)
    ax.plot(k, means[:, 0], color=vehicle, linewidth=1.2)
    ax.plot(k, means[:, 1], color=landmark, linewidth=1.6)
    ax.axhline(runs.landmarks_at, color=truth, linewidth=0.8, linestyle="--")
    ax.set(xlim=(0, k[-1]), xlabel=MEASUREMENTS, ylabel="position (m)")
    return ax


@drawn(
    alt="Landmark errors of thirty runs. Each line wanders for some measurements, then runs flat, "
    "at its own height, inside a band that does not narrow.",
    caption=lambda runs, **_: (
        f"{len(runs.landmark_errors)} runs, one of them bold. Band: ±2σ as the filter states it. "
        "Each error moves for a few measurements, then freezes at a height of its own."
    ),
    height=3.3,
)
def error_fan(ax: Axes, runs: Runs, *, picked: int | None = None) -> Axes:
    """Draw the first landmark's error in all runs inside the stated ±2σ, one run picked out."""
    errors = runs.landmark_errors[..., 0].T
    last = len(errors) - 1
    # an error freezes: each measurement at first, then every fifth
    times = np.unique([*range(min(last + 1, 25)), *range(0, last + 1, 5), last])
    colour, stated = MEANING["landmark"], runs.deviations[:, 1]
    style = {"color": colour, "linewidth": 0.9, "alpha": 0.55 if picked is None else 0.4}
    grey = MEANING["expected"]
    _errors(ax, errors, stated, grey, "landmark error (m)", times=times, **style)
    if picked is not None:
        ax.plot(times, errors[times, picked], color=colour, linewidth=2.6)
        ax.plot(0, errors[0, picked], "o", color=colour, markersize=6)
    return ax


def _errors(
    ax: Axes,
    errors: np.ndarray,
    deviations: np.ndarray,
    tint: str,
    what: str,
    *,
    times: np.ndarray | slice = slice(None),
    **style: float | str,
) -> Axes:
    """Draw errors, (measurements, lines) in m, at some times inside ±2σ."""
    k, errors, reach = np.arange(len(errors))[times], errors[times], 2 * deviations[times]
    band(ax, k, -reach, reach, tint)
    ax.plot(k, errors, **{"linewidth": 1.3, **style})
    ax.axhline(0, color=MEANING["truth"], linewidth=0.8)
    top = 1.15 * max(reach.max(), np.abs(errors).max())
    ax.set(xlim=(0, k[-1]), ylim=(-top, top), xlabel=MEASUREMENTS, ylabel=what)
    return ax


def gains(ax: Axes, runs: Runs) -> Axes:
    """Draw the gains of vehicle and first landmark on that landmark's innovation, as in Fig. 4."""
    vehicle, landmark = runs.gains.T
    k = np.arange(1, len(vehicle) + 1)
    ax.plot(k, vehicle, color=MEANING["robot"], linewidth=1.5)
    ax.plot(k, landmark, color=MEANING["landmark"], linewidth=1.8)
    ax.axhline(0, color=MEANING["expected"], linewidth=0.8)
    low, high = min(vehicle.min(), 0), max(landmark.max(), 0)
    room = 0.12 * (high - low)
    ax.set(xlim=(0, k[-1]), ylim=(low - 2 * room, high + room), xlabel=MEASUREMENTS, ylabel="gain")
    for y, name, meaning in (
        (room, "landmark", "landmark"),
        (low - 1.1 * room, "vehicle", "robot"),
    ):
        label(ax, 0.97 * k[-1], y, name, MEANING[meaning], ha="right", fontsize=9)
    return ax


def one_run(axes: AxesRow, runs: Runs, run: int) -> AxesRow:
    """Draw one run on two axes (path, landmark error) or four (and vehicle, gains), cleared.

    Errors stand inside the stated ±2σ; a dot is where a landmark's began.
    """
    for ax in axes:
        ax.clear()
    trajectory(axes[0], runs, run)
    errors, colour = runs.landmark_errors[run], MEANING["landmark"]
    _errors(axes[1], errors, runs.deviations[:, 1], colour, "landmark error (m)", color=colour)
    began = {"color": colour, "markersize": 5, "clip_on": False}
    axes[1].plot(np.zeros(errors.shape[1]), errors[0], "o", **began)
    if len(axes) > 2:
        errors, colour = runs.vehicle_errors[run, :, None], MEANING["robot"]
        _errors(axes[2], errors, runs.deviations[:, 0], colour, "vehicle error (m)", color=colour)
        gains(axes[3], runs)
    return axes


def watched(axes: AxesRow, state: SimpleNamespace) -> None:
    """Draw path and landmark error of one run, on scales that all states share."""
    one_run(axes, state.found, state.run)
    axes[0].set(ylim=(-2.6, 1.7))
    axes[1].set(ylim=(-0.32, 0.32))


@drawn(
    alt="Two columns, one and ten landmarks; rows: path and landmark, landmark error, vehicle "
    "error, gains. Errors stay on one side of zero; the landmark gain goes to zero.",
    caption="Fig. 4 rebuilt, bands ±2σ. Landmark errors (second row) freeze, the vehicle's error "
    "stays near them, the landmark's gain goes to zero. Uncoloured: truth; blue dots: single "
    "measurements.",
    rows=4,
    cols=2,
    height=9.2,
)
def fig4(axes: np.ndarray, results: Sequence[Runs]) -> np.ndarray:
    """Draw a run with one landmark and one with more, a column each, as the rows of Fig. 4."""
    for column, runs in zip(axes.T, results, strict=True):
        one_run(column, runs, 0)
        n = runs.landmark_errors.shape[-1]
        column[0].set_title("1 landmark" if n == 1 else f"{n} landmarks")
    return common_scales(axes)


def common_scales(axes: np.ndarray) -> np.ndarray:
    """Give the axes of each row the same ordinate, so that columns compare."""
    for row in axes:
        low, high = np.transpose([ax.get_ylim() for ax in row])
        for ax in row:
            ax.set_ylim(low.min(), high.max())
    return axes


def study(axes: AxesRow, runs: Runs) -> None:
    """Draw the landmark errors of all runs and the gains, on scales that all states share."""
    for ax in axes:
        ax.clear()
    error_fan.on(axes[0], runs)
    gains(axes[1], runs)
    for ax in axes:
        ax.locator_params(nbins=5)  # ticks cost more time to draw than the curves
    axes[0].set(ylim=(-0.9, 0.9))
    axes[1].set(ylim=(-0.45, 0.65))


@drawn(
    alt="A hundred dots around a line through zero that is flatter than the diagonal.",
    caption="A hundred runs, noise of Fig. 4. Full line: least squares; dashed: equality. What "
    "would make the points fall on the diagonal?",
    width=4.6,
    height=4.4,
)
def first_against_last(ax: Axes, first: np.ndarray, last: np.ndarray) -> Axes:
    """Draw the last error of each run against its first, with the fitted line and the diagonal."""
    reach = 1.08 * max(np.abs(first).max(), np.abs(last).max())
    ends = np.array([-reach, reach])
    equal, fitted = MEANING["expected"], MEANING["mean"]
    ax.plot(ends, ends, color=equal, linestyle="--", linewidth=1.2)
    ax.plot(ends, ends * (first @ last) / (first @ first), color=fitted)
    ax.plot(
        first, last, "o", color=MEANING["landmark"], markersize=3.5, alpha=0.6, markeredgewidth=0
    )
    label(ax, 0.66 * reach, 0.86 * reach, "equal", equal, ha="right", fontweight=400)
    what = "error after the {} measurement (m)"
    ax.set(xlim=ends, ylim=ends, xlabel=what.format("first"), ylabel=what.format("last"))
    ax.set_aspect("equal")
    return ax


@drawn(
    alt="Single runs scatter widely; the mean over the runs narrows to zero.",
    caption="Dots: last errors of the first 300 runs. Line: mean over the runs so far, with the "
    "±2σ range in which an unbiased filter's mean lies.",
    height=3.4,
)
def ensemble(ax: Axes, last: np.ndarray, deviation: float) -> Axes:
    """Draw the mean of the last errors over the first runs, ±2 standard errors, and single runs."""
    runs = np.unique(np.geomspace(2, last.size, 200).astype(int))
    half = 2 * deviation / np.sqrt(runs)
    one, mean = MEANING["landmark"], MEANING["mean"]
    ax.semilogx(np.arange(1, last.size + 1)[:300], last[:300], ".", color=one, markersize=3)
    band(ax, runs, -half, half, MEANING["expected"])
    ax.semilogx(runs, np.cumsum(last)[runs - 1] / runs, color=mean)
    ax.axhline(0, color=MEANING["expected"], linewidth=0.8)
    ax.xaxis.set_major_formatter(ScalarFormatter())
    top = 3.4 * deviation
    ax.set(xlim=(1, 1.6 * last.size), ylim=(-top, top), xlabel="runs", ylabel="landmark error (m)")
    label(ax, 1.3, 2.9 * deviation, "each dot: one run", one, fontweight=400)
    label(ax, last.size, -0.75 * deviation, "mean so far", mean, ha="right")
    return ax


# Information -----------------------------------------------------------------------------------


@drawn(
    alt="(a) Straight lines rising, steeper with more landmarks, all under the dashed line "
    "1/V. (b) For one landmark the sum rises while the information of the state is flat.",
    caption="Fig. 3 rebuilt at $P_0 = V = W = 1$ m². (a) First entry of eq. (14), by number of "
    "landmarks; none rises by more than 1/V a step. (b) One landmark. Why is one line flat?",
    cols=2,
    width=7.6,
    height=3.5,
    width_ratios=[1.5, 1],
)
def fig3(
    axes: AxesRow, curves: Mapping[int, np.ndarray], summed: np.ndarray, exact: np.ndarray
) -> None:
    """Draw eq. (14) by number of landmarks, and of one landmark beside the exact information."""
    ax, kinds = axes
    steps = len(summed)
    k = np.arange(1, steps + 1)
    limit, colour = MEANING["expected"], MEANING["paper"]
    ax.plot(k, k, color=limit, linewidth=1.2, linestyle="--")
    label(ax, 1.02 * steps, 1.03 * steps, "1/V a step", limit, fontsize=9, fontweight=400)
    last = np.inf
    for n, curve in reversed(curves.items()):
        ax.plot(k, curve, color=colour)
        last = min(curve[-1], last - 0.065 * steps, 0.95 * steps)
        name = "1 landmark" if n == 1 else f"{n}"
        label(ax, 1.02 * steps, last, name, colour, fontsize=9.5)
    ax.set(xlim=(0, 1.3 * steps), ylim=(0, 1.08 * steps), xticks=np.linspace(0, steps, 6))
    ax.set(xlabel=MEASUREMENTS, ylabel="first entry of the information (1/m²)")
    top, known = summed[-1], MEANING["information"]
    kinds.plot(k, summed, color=colour)
    kinds.plot(k, exact, color=known)
    kinds.set(xlim=(0, steps), ylim=(0, 1.08 * top))
    kinds.set(xlabel=MEASUREMENTS, ylabel="information (1/m²)")
    label(kinds, 0.98 * steps, 0.42 * top, "sum of eq. (14)", colour, ha="right")
    label(kinds, 0.98 * steps, exact[-1] + 0.07 * top, "of the state as it is", known, ha="right")


@drawn(
    alt="Log-likelihood over start and landmark: a straight ridge along the diagonal.",
    caption=lambda *_, measurements: (
        f"The stronger the colour, the likelier. {measurements} measurements fix the distance "
        "between start and landmark; along the arrow (1, 1) nothing changes."
    ),
    width=4.6,
    height=4.2,
)
def likelihood_ridge(
    ax: Axes, vehicle: np.ndarray, landmark: np.ndarray, values: np.ndarray, *, measurements: int
) -> Axes:
    """Draw the log-likelihood over start and landmark, with the direction it is blind to."""
    style = {"colors": [MEANING["information"]], "alpha": 0.16}
    for low in (-40, -18, -8, -2, -0.5):  # each region lies in the one before
        ax.contourf(vehicle, landmark, values, levels=[low, 0.1], **style)
    row, column = np.unravel_index(np.argmax(values), values.shape)
    middle = vehicle.mean() + np.array([0.0, landmark[row] - vehicle[column]])
    arrow = {"arrowstyle": "<->", "color": MEANING["unobservable"], "linewidth": 2.2}
    ax.annotate("", middle + 1.6, middle - 1.6, arrowprops=arrow)
    label(ax, *(middle + np.array([0.25, -1.0])), "(1, 1)", MEANING["unobservable"])
    ax.set(xlim=vehicle[[0, -1]], ylim=landmark[[0, -1]], aspect="equal")
    ax.set(xlabel="start of the vehicle (m)", ylabel="landmark (m)")
    return ax


def plane(ax: Axes, known: SimpleNamespace, *, reach: float = 5.5) -> Axes:
    """Draw the filter's 2σ ellipse and the 2σ region of the information, on axes cleared first.

    The region is a strip where the information is singular; the truth is the middle of the
    window, ±``reach`` in m.
    """
    ax.clear()
    mean, cov = known.belief.mean - known.truth, known.belief.cov
    values, vectors = np.linalg.eigh(known.information)
    style = {"width": 1.8, "fill": 0.18, "corners": 72}
    filtered, exact, truth = (MEANING[name] for name in ("estimate", "information", "truth"))
    if values[0] > 1e-9 * values[1]:
        ellipses(ax, mean[None], np.linalg.inv(known.information)[None], exact, **style)
    elif values[1] > 0:
        along, across = 4 * reach * vectors[:, 0], 2 / np.sqrt(values[1]) * vectors[:, 1]
        edges = [np.stack([mean + side - along, mean + side + along]) for side in (across, -across)]
        ax.fill(*np.vstack([edges[0], edges[1][::-1]]).T, color=exact, alpha=0.18, linewidth=0)
        for edge in edges:
            ax.plot(*edge.T, color=exact, linewidth=1.6)
    ellipses(ax, mean[None], cov[None], filtered, **style)
    ax.plot(*mean, "o", color=filtered, markersize=5)
    ax.plot(0, 0, "P", color=truth, markersize=9)
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    ax.set(xlabel="vehicle error (m)", ylabel="landmark error (m)")
    lines = (("filter, 2σ", filtered), ("measured, 2σ", exact), ("+ truth", truth))
    for i, (text, colour) in enumerate(lines):
        label(ax, 0.03, 0.95 - 0.08 * i, text, colour, transform=ax.transAxes)
    return ax


# Gains, numbers of landmarks, broken filters ---------------------------------------------------


@drawn(
    alt="Gains on a logarithmic axis: three straight lines fall steeply; two dashed curves "
    "flatten.",
    caption="$P_0 = V = W = 1$ m². Full: gain on the innovation that all landmarks share, by "
    "their number. Dashed: gain on a landmark's own innovation. There are two laws in one filter.",
    height=3.6,
)
def gain_decay(ax: Axes, curves: Mapping[int, tuple[np.ndarray, np.ndarray]]) -> Axes:
    """Draw how gains fall: on the common innovation (full), and on a landmark's own (dashed)."""
    colour, right = MEANING["landmark"], 0
    for n, (common, own) in curves.items():
        k = np.arange(1, len(common) + 1)
        seen = common > 1e-9
        ax.semilogy(k[seen], common[seen], color=colour)
        label(ax, k[seen][-1] + 0.6, 2 * common[seen][-1], f"{n}", colour)
        right = max(right, k[seen][-1])
        if n > 1:
            ax.semilogy(k, own, color=colour, linestyle="--")
            apart = 3.0 if n == max(curves) else 1 / 3
            label(ax, 0.97 * k[-1], apart * own[-1], f"own, {n}", colour, ha="right")
    label(ax, right + 4, 2e-8, "what all share, by n", colour)
    ax.set(xlim=(0, k[-1]), ylim=(1e-9, 3), xlabel=MEASUREMENTS, ylabel="gain of a landmark")
    return ax


@drawn(
    alt="(a) The error of one landmark falls to a floor. (b) The sum of squared errors rises.",
    caption="$P_0 = V = W = 1$ m². (a) Root mean square error of one landmark; line: by the "
    "filter, dots: 400 runs. (b) Expected sum of squared errors over the state, by the same "
    "filter.",
    cols=2,
    width=7.4,
    height=3.4,
)
def against_number(
    axes: AxesRow,
    counts: np.ndarray,
    measured: np.ndarray,
    expected: np.ndarray,
    total: np.ndarray,
    floor: float,
) -> None:
    """Draw the error of one landmark and that of all against the number of landmarks."""
    one, every = axes
    law = MEANING["expected"]
    one.axhline(floor, color=law, linestyle="--", linewidth=1.2)
    one.semilogx(counts, expected, color=law)
    one.semilogx(counts, measured, "o", color=MEANING["landmark"], markersize=5)
    top = 1.25 * max(measured.max(), expected.max())
    one.set(ylim=(0, top), ylabel="error of one landmark (m)")
    low = floor - 0.09 * top
    label(one, counts[0], low, "floor: vehicle's start", law, fontweight=400)
    every.loglog(counts, total, "-", color=MEANING["error"])
    every.loglog(counts, counts * total[-1] / counts[-1], color=law, linestyle="--", linewidth=1.2)
    every.set(ylabel="sum of squared errors (m²)")
    label(every, counts[0], total[-1] / 1.4, "proportional: dashed", law, fontweight=400)
    for ax in axes:
        ax.set(xticks=counts, xticklabels=[str(n) for n in counts], xlabel="landmarks")
        ax.minorticks_off()


@drawn(
    alt="Error: only the variant with a known landmark brings it down. Squared error over stated "
    "variance: too small P0 and the forgotten cross-covariance exceed one; others stay near it.",
    caption="A thousand runs: root mean square of the landmark's error, and squared error over "
    "stated variance (NEES), 1 if the filter is honest; band: 95 % of chance. Which would you have "
    "found in a hundred runs?",
    rows=2,
    height=5.8,
    gridspec_kw={"right": 0.64},
)
def variants(
    axes: AxesRow, rms: Mapping[str, np.ndarray], nees: Mapping[str, np.ndarray], *, runs: int
) -> None:
    """Draw error and honesty of each variant; grey is where honesty lies by chance, 95 %."""
    upper, lower = axes
    chance = average_bounds(1, runs)
    lower.axhspan(*chance, color=MEANING["expected"], alpha=0.25, linewidth=0)
    for name, meaning in zip(rms, VARIANTS, strict=True):
        style = {"color": MEANING[meaning], "label": fill(name, 16, break_on_hyphens=False)}
        upper.plot(rms[name], **style)
        lower.plot(nees[name], **style)
    for ax, what in zip(axes, ("rms landmark error (m)", "squared error / variance"), strict=True):
        ax.set(xlim=(0, len(rms[name]) - 1), ylim=(0, None), xlabel=MEASUREMENTS, ylabel=what)
    for ax in axes:
        ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))


@drawn(
    alt="Two drawings of a robot approaching an end wall, alike but for the numbers on the axis.",
    caption="A straight stretch of the Intel log, mapped from two origins; bands ±2σ of the wall. "
    "It is one map read with two rulers.",
    cols=2,
    width=7.4,
    height=3.4,
)
def two_origins(axes: AxesRow, runs: Mapping[str, MonobotRun]) -> AxesRow:
    """Draw a corridor mapped from several origins, by name, an axes each."""
    end, robot = MEANING["walls"], MEANING["robot"]
    for ax, (name, run) in zip(axes, runs.items(), strict=True):
        (vehicle, wall), reach = run.means[0].T, 2 * run.deviations[0, :, 1]
        k = np.arange(len(vehicle))
        band(ax, k, wall - reach, wall + reach, end, alpha=0.3)
        ax.plot(k, wall, color=end)
        ax.plot(k, vehicle, ".-", color=robot)
        ax.set(xlabel=MEASUREMENTS, ylabel="along the corridor (m)", title=name)
        ax.set(ylim=(vehicle[0] - 1.5, wall[0] + 3.0), xticks=k[::3])
        label(ax, 0.4, wall[0] + 1.5, "end wall", end)
        label(ax, 0.62 * k[-1], vehicle[0] + 2.2, "robot", robot)
    return axes
