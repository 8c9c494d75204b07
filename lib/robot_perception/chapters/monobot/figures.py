"""Drawings of the chapter "The unobservable monobot": results and axes in, axes out."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse
from matplotlib.ticker import ScalarFormatter

from robot_perception.teaching.figures.style import (
    BLUE,
    COLOURS,
    GREEN,
    INK,
    MUTED,
    ORANGE,
    PURPLE,
    RED,
    band,
    label,
)

AxesRow = Sequence[Axes] | np.ndarray

LOOKS = "looks after the first"


def error_fan(
    ax: Axes,
    errors: np.ndarray,
    deviations: np.ndarray,
    *,
    picked: int | None = None,
    what: str = "landmark error (m)",
) -> Axes:
    """Draw the errors of many runs against the number of looks, with the filter's ±2σ band.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    errors : ndarray, shape (runs, looks)
        Estimate minus truth, m.
    deviations : ndarray, shape (looks,)
        Deviation that the filter states, m.
    picked : int, optional
        A run to draw in full colour.
    what : str
        Label of the vertical axis.
    """
    looks = _worth_drawing(errors.shape[1])
    errors, deviations = errors[:, looks], deviations[looks]
    band(ax, looks, -2 * deviations, 2 * deviations, MUTED)
    ax.plot(looks, errors.T, color=BLUE, linewidth=0.9, alpha=0.55)
    ax.axhline(0, color=INK, linewidth=0.8)
    if picked is not None:
        ax.plot(looks, errors[picked], color=ORANGE, linewidth=2.4)
        ax.plot(0, errors[picked, 0], "o", color=ORANGE, markersize=6)
    reach = 1.15 * max(2 * deviations.max(), np.abs(errors).max())
    ax.set(xlim=(0, looks[-1]), ylim=(-reach, reach), xlabel=LOOKS, ylabel=what)
    return ax


def _worth_drawing(looks: int) -> np.ndarray:
    """Return the looks at which a freezing error is drawn: each at first, then every fifth."""
    return np.unique(
        np.concatenate([np.arange(min(looks, 25)), np.arange(0, looks, 5), [looks - 1]])
    )


def information_curves(ax: Axes, curves: Mapping[int, np.ndarray]) -> Axes:
    """Draw the first entry of eq. (14) against the step, one curve for each number of landmarks."""
    steps = len(next(iter(curves.values())))
    k = np.arange(1, steps + 1)
    ax.plot(k, k, color=MUTED, linewidth=1.2, linestyle="--")
    label(ax, 1.02 * steps, 1.03 * steps, "1/V a look", MUTED, fontsize=9, fontweight=400)
    last = np.inf
    for (n, curve), colour in zip(reversed(curves.items()), COLOURS, strict=False):
        ax.plot(k, curve, color=colour)
        last = min(curve[-1], last - 0.065 * steps, 0.95 * steps)
        name = "1 landmark" if n == 1 else f"{n}"
        label(ax, 1.02 * steps, last, name, colour, fontsize=9.5)
    ax.set(
        xlim=(0, 1.3 * steps),
        ylim=(0, 1.08 * steps),
        xticks=np.linspace(0, steps, 6),
        xlabel=LOOKS,
        ylabel="first entry of the information (1/m²)",
    )
    return ax


def information_kinds(ax: Axes, summed: np.ndarray, on_start: np.ndarray) -> Axes:
    """Draw the sum of eq. (14) beside the information on the start, for one landmark."""
    k = np.arange(1, len(summed) + 1)
    ax.plot(k, summed, color=BLUE)
    ax.plot(k, on_start, color=ORANGE)
    ax.set(
        xlim=(0, k[-1]),
        ylim=(0, 1.08 * summed[-1]),
        xlabel=LOOKS,
        ylabel="information (1/m²)",
    )
    label(ax, 0.98 * k[-1], 0.42 * summed[-1], "sum of eq. (14)", BLUE, ha="right")
    label(ax, 0.98 * k[-1], on_start[-1] + 0.07 * summed[-1], "on the start", ORANGE, ha="right")
    return ax


def likelihood_ridge(
    ax: Axes, vehicle: np.ndarray, landmark: np.ndarray, log_likelihood: np.ndarray
) -> Axes:
    """Draw the log-likelihood over start and landmark, with the direction it is blind to.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    vehicle, landmark : ndarray, shape (a,), (b,)
        Positions tried, m.
    log_likelihood : ndarray, shape (b, a)
        Relative to the best.
    """
    levels = [-40, -18, -8, -2, -0.5, 0.1]
    ax.contourf(vehicle, landmark, log_likelihood, levels=levels, cmap="cividis", alpha=0.85)
    middle = np.array([vehicle.mean(), vehicle.mean() + _ridge(vehicle, landmark, log_likelihood)])
    arrow = {"arrowstyle": "<->", "color": RED, "linewidth": 2.2}
    ax.annotate("", middle + 1.6, middle - 1.6, arrowprops=arrow)
    label(ax, *(middle + np.array([0.25, -1.0])), "(1, 1)", RED)
    ax.set(
        xlabel="start of the vehicle (m)",
        ylabel="landmark (m)",
        xlim=vehicle[[0, -1]],
        ylim=landmark[[0, -1]],
        aspect="equal",
    )
    return ax


def _ridge(vehicle: np.ndarray, landmark: np.ndarray, log_likelihood: np.ndarray) -> float:
    row, column = np.unravel_index(np.argmax(log_likelihood), log_likelihood.shape)
    return landmark[row] - vehicle[column]


def plane(
    ax: Axes,
    truth: np.ndarray,
    mean: np.ndarray,
    cov: np.ndarray,
    information: np.ndarray,
    *,
    reach: float = 5.0,
) -> Axes:
    """Draw the filter's 2σ ellipse and the 2σ region of the information, on axes cleared first.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    truth, mean : ndarray, shape (2,)
        Vehicle and landmark, m.
    cov, information : ndarray, shape (2, 2)
        Covariance of the filter, m²; information, 1/m²: a strip where it is singular.
    reach : float
        Half the side of the window, m.
    """
    ax.clear()
    values, vectors = np.linalg.eigh(information)
    if values[1] > 0:
        half = 2 / np.sqrt(values[1])
        if values[0] > 1e-9 * values[1]:
            _ellipse(ax, mean, np.linalg.inv(information), ORANGE)
        else:
            t = np.array([-4.0, 4.0]) * reach
            axis, side = vectors[:, 0], vectors[:, 1]
            corners = [mean + t[i] * axis + s * half * side for s in (-1, 1) for i in (0, 1)]
            low, high = np.array(corners[:2]), np.array(corners[2:])
            polygon = np.vstack([low, high[::-1]])
            ax.fill(*polygon.T, color=ORANGE, alpha=0.18, linewidth=0)
            ax.plot(*low.T, color=ORANGE, linewidth=1.6)
            ax.plot(*high.T, color=ORANGE, linewidth=1.6)
    _ellipse(ax, mean, cov, BLUE)
    ax.plot(*mean, "o", color=BLUE, markersize=5)
    ax.plot(*truth, "P", color=INK, markersize=9)
    ax.set(
        xlim=(truth[0] - reach, truth[0] + reach),
        ylim=(truth[1] - reach, truth[1] + reach),
        xlabel="vehicle now (m)",
        ylabel="landmark (m)",
        aspect="equal",
    )
    lines = (("filter, 2σ", BLUE), ("information, 2σ", ORANGE), ("+ truth", INK))
    for i, (text, colour) in enumerate(lines):
        label(ax, 1.06, 0.95 - 0.09 * i, text, colour, transform=ax.transAxes)
    return ax


def _ellipse(ax: Axes, mean: np.ndarray, cov: np.ndarray, colour: str) -> None:
    values, vectors = np.linalg.eigh(cov)
    width, height = 4 * np.sqrt(np.maximum(values, 0))
    angle = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
    for face, alpha, line in ((colour, 0.18, 0), ("none", 1, 1.8)):
        ax.add_patch(
            Ellipse(
                mean,
                width,
                height,
                angle=angle,
                facecolor=face,
                alpha=alpha,
                edgecolor=colour,
                linewidth=line,
            )
        )


def trajectory(
    ax: Axes,
    position: np.ndarray,
    estimate: np.ndarray,
    deviation: np.ndarray,
    landmark: float,
    landmark_estimate: np.ndarray,
    landmark_deviation: np.ndarray,
    sightings: np.ndarray,
) -> Axes:
    """Draw one run as in the first column of Fig. 4: true path, estimates with ±2σ, sightings.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    position, estimate, deviation : ndarray, shape (looks,)
        True path, its estimate and the stated deviation, m.
    landmark : float
        True place, m.
    landmark_estimate, landmark_deviation : ndarray, shape (looks,)
        Its estimate and stated deviation, m.
    sightings : ndarray, shape (looks,)
        Where each look alone, from the true path, would put it, m; every third is drawn.
    """
    k = np.arange(len(position))
    band(ax, k, estimate - 2 * deviation, estimate + 2 * deviation, BLUE)
    low, high = (
        landmark_estimate - 2 * landmark_deviation,
        landmark_estimate + 2 * landmark_deviation,
    )
    band(ax, k, low, high, ORANGE, alpha=0.28)
    ax.plot(k[::3], sightings[::3], ".", color=MUTED, markersize=3, alpha=0.8)
    ax.plot(k, position, color=INK, linewidth=1.4)
    ax.plot(k, estimate, color=BLUE, linewidth=1.2)
    ax.plot(k, landmark_estimate, color=ORANGE, linewidth=1.6)
    ax.axhline(landmark, color=INK, linewidth=0.8, linestyle="--")
    ax.set(xlim=(0, k[-1]), xlabel=LOOKS, ylabel="position (m)")
    return ax


def error_band(
    ax: Axes, errors: np.ndarray, deviations: np.ndarray, colour: str, what: str
) -> Axes:
    """Draw the errors of one run, one line for each column, inside the stated ±2σ.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    errors : ndarray, shape (looks, lines)
        Estimate minus truth, m.
    deviations : ndarray, shape (looks,)
        Stated deviation, m.
    colour, what : str
        Colour, and label of the vertical axis.
    """
    k = np.arange(len(errors))
    band(ax, k, -2 * deviations, 2 * deviations, colour)
    ax.plot(k, errors, color=colour, linewidth=1.3)
    ax.axhline(0, color=INK, linewidth=0.8)
    reach = 1.15 * max(2 * deviations.max(), np.abs(errors).max())
    ax.set(xlim=(0, k[-1]), ylim=(-reach, reach), xlabel=LOOKS, ylabel=what)
    return ax


def gains_of(ax: Axes, vehicle: np.ndarray, landmark: np.ndarray) -> Axes:
    """Draw the gains of vehicle and landmarks on the first innovation, as in Fig. 4.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    vehicle, landmark : ndarray, shape (steps,)
        Gains, pure numbers.
    """
    k = np.arange(1, len(vehicle) + 1)
    ax.plot(k, vehicle, color=BLUE, linewidth=1.5)
    ax.plot(k, landmark, color=ORANGE, linewidth=1.8)
    ax.axhline(0, color=INK, linewidth=0.8)
    low, high = min(vehicle.min(), 0), max(landmark.max(), 0)
    room = 0.12 * (high - low)
    ax.set(xlim=(0, k[-1]), ylim=(low - 2 * room, high + room), xlabel=LOOKS, ylabel="gain")
    label(ax, 0.97 * k[-1], room, "landmark", ORANGE, ha="right", fontsize=9)
    label(ax, 0.97 * k[-1], low - 1.1 * room, "vehicle", BLUE, ha="right", fontsize=9)
    return ax


def one_run(
    axes: AxesRow,
    position: np.ndarray,
    means: np.ndarray,
    deviations: np.ndarray,
    landmark: float,
    looks: np.ndarray,
    gains: np.ndarray,
) -> AxesRow:
    """Draw one run on two or four axes: the path and the landmark error, then vehicle and gains.

    Parameters
    ----------
    axes : sequence of Axes
        Two or four; they are cleared first.
    position : ndarray, shape (looks,)
        True path, m.
    means, deviations : ndarray, shape (looks, n + 1)
        Estimates and stated deviations, m.
    landmark : float
        Where all landmarks stand, m.
    looks : ndarray, shape (looks, n)
        Measured distances, m.
    gains : ndarray, shape (steps, 2)
        Gains of vehicle and first landmark on the first innovation.
    """
    for ax in axes:
        ax.clear()
    error, first = means[:, 1:] - landmark, position + looks[:, 0]
    trajectory(
        axes[0],
        position,
        means[:, 0],
        deviations[:, 0],
        landmark,
        means[:, 1],
        deviations[:, 1],
        first,
    )
    error_band(axes[1], error, deviations[:, 1], ORANGE, "landmark error (m)")
    axes[1].plot(np.zeros(error.shape[1]), error[0], "o", color=INK, markersize=4, clip_on=False)
    if len(axes) > 2:
        vehicle = (means[:, 0] - position)[:, None]
        error_band(axes[2], vehicle, deviations[:, 0], BLUE, "vehicle error (m)")
        gains_of(axes[3], gains[:, 0], gains[:, 1])
    return axes


def study(axes: AxesRow, errors: np.ndarray, deviations: np.ndarray, gains: np.ndarray) -> AxesRow:
    """Draw the landmark errors of many runs and the gains, on two axes that are cleared first.

    Parameters
    ----------
    axes : sequence of Axes
        Two.
    errors : ndarray, shape (runs, looks)
        Estimate minus truth of the first landmark, m.
    deviations : ndarray, shape (looks,)
        Stated deviation, m.
    gains : ndarray, shape (steps, 2)
        Gains of vehicle and first landmark on the first innovation.
    """
    for ax in axes:
        ax.clear()
    error_fan(axes[0], errors, deviations)
    gains_of(axes[1], gains[:, 0], gains[:, 1])
    for ax in axes:
        ax.locator_params(nbins=5)  # ticks cost more time to draw than the curves
    return axes


def gain_decay(ax: Axes, common: Mapping[int, np.ndarray], own: Mapping[int, np.ndarray]) -> Axes:
    """Draw how gains fall: on the common innovation (full lines) and on a landmark's own (dashed).

    Parameters
    ----------
    ax : Axes
        Where to draw.
    common, own : mapping of int to ndarray, shape (steps,)
        By number of landmarks.
    """
    for (n, gain), colour in zip(common.items(), COLOURS, strict=False):
        k = np.arange(1, len(gain) + 1)
        seen = gain > 1e-9
        ax.semilogy(k[seen], gain[seen], color=colour)
        label(ax, k[seen][-1] + 0.7, 5e-9, "n = 1" if n == 1 else f"{n}", colour)
        if n > 1:
            ax.semilogy(k, own[n], color=colour, linestyle="--")
            apart = 3.0 if n == max(common) else 1 / 3
            label(ax, 0.97 * k[-1], apart * own[n][-1], f"own, {n}", colour, ha="right")
    ax.set(xlim=(0, k[-1]), ylim=(1e-9, 3), xlabel=LOOKS, ylabel="gain of a landmark")
    return ax


def first_against_last(ax: Axes, first: np.ndarray, last: np.ndarray) -> Axes:
    """Draw the last error of each run against its first, with the fitted line and the diagonal."""
    reach = 1.08 * max(np.abs(first).max(), np.abs(last).max())
    ends = np.array([-reach, reach])
    ax.plot(ends, ends, color=MUTED, linestyle="--", linewidth=1.2)
    ax.plot(ends, ends * (first @ last) / (first @ first), color=ORANGE)
    ax.plot(first, last, "o", color=BLUE, markersize=3.5, alpha=0.6, markeredgewidth=0)
    label(ax, 0.66 * reach, 0.86 * reach, "equal", MUTED, ha="right", fontweight=400)
    ax.set(
        xlim=ends,
        ylim=ends,
        xlabel="error after the first look (m)",
        ylabel="error after the last look (m)",
        aspect="equal",
    )
    return ax


def ensemble(ax: Axes, last: np.ndarray, deviation: float) -> Axes:
    """Draw the mean of the last errors over the first runs, ±2 standard errors, and single runs.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    last : ndarray, shape (runs,)
        Last error of each run, m.
    deviation : float
        Spread that the filter states for one run, m.
    """
    runs = np.unique(np.geomspace(2, last.size, 200).astype(int))
    means = np.cumsum(last)[runs - 1] / runs
    half = 2 * deviation / np.sqrt(runs)
    ax.semilogx(np.arange(1, last.size + 1)[:300], last[:300], ".", color=MUTED, markersize=3)
    band(ax, runs, -half, half, BLUE)
    ax.semilogx(runs, means, color=BLUE)
    ax.axhline(0, color=INK, linewidth=0.8)
    ax.xaxis.set_major_formatter(ScalarFormatter())
    ax.set(
        xlim=(1, 1.6 * last.size),
        ylim=(-3.4 * deviation, 3.4 * deviation),
        xlabel="runs",
        ylabel="landmark error (m)",
    )
    label(ax, 1.3, 2.9 * deviation, "each dot: one run", MUTED, fontweight=400)
    label(ax, last.size, -0.75 * deviation, "mean so far", BLUE, ha="right")
    return ax


def spread_of_one(
    ax: Axes, counts: np.ndarray, measured: np.ndarray, expected: np.ndarray, floor: float
) -> Axes:
    """Draw the root mean square error of one landmark against the number of landmarks."""
    ax.axhline(floor, color=MUTED, linestyle="--", linewidth=1.2)
    ax.semilogx(counts, expected, color=BLUE)
    ax.semilogx(counts, measured, "o", color=ORANGE, markersize=5)
    ax.set(
        xticks=counts,
        xticklabels=[str(n) for n in counts],
        ylim=(0, 1.25 * max(measured.max(), expected.max())),
        xlabel="landmarks",
        ylabel="error of one landmark (m)",
    )
    ax.minorticks_off()
    label(
        ax,
        counts[0],
        floor - 0.09 * ax.get_ylim()[1],
        "floor: vehicle's start",
        MUTED,
        fontweight=400,
    )
    return ax


def total_of_all(ax: Axes, counts: np.ndarray, total: np.ndarray) -> Axes:
    """Draw the expected sum of squared errors over the state against the number of landmarks."""
    ax.loglog(counts, total, "-", color=PURPLE)
    ax.loglog(counts, counts * total[-1] / counts[-1], color=MUTED, linestyle="--", linewidth=1.2)
    ax.set(
        xticks=counts,
        xticklabels=[str(n) for n in counts],
        xlabel="landmarks",
        ylabel="sum of squared errors (m²)",
    )
    ax.minorticks_off()
    label(ax, counts[1], total[-1] / 1.6, "proportional: dashed", MUTED, fontweight=400)
    return ax


def honesty(ax: Axes, values: Mapping[str, np.ndarray], bounds: tuple[float, float]) -> Axes:
    """Draw the mean squared error over the stated variance, step by step; 1 is honest.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    values : mapping of str to ndarray, shape (looks,)
        By name of the variant.
    bounds : tuple of float
        Where the mean lies by chance, 95 %.
    """
    looks = np.arange(len(next(iter(values.values()))))
    ax.axhspan(*bounds, color=MUTED, alpha=0.25, linewidth=0)
    for (name, value), colour in zip(values.items(), COLOURS, strict=False):
        ax.plot(looks, value, color=colour, label=name)
    ax.set(xlim=(0, looks[-1]), ylim=(0, None), xlabel=LOOKS, ylabel="squared error / variance")
    ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))
    return ax


def root_mean_squares(ax: Axes, values: Mapping[str, np.ndarray]) -> Axes:
    """Draw the root mean square landmark error of each variant against the looks."""
    looks = np.arange(len(next(iter(values.values()))))
    for (name, value), colour in zip(values.items(), COLOURS, strict=False):
        ax.plot(looks, value, color=colour, label=name)
    ax.set(xlim=(0, looks[-1]), ylim=(0, None), xlabel=LOOKS, ylabel="rms landmark error (m)")
    return ax


def two_origins(
    axes: AxesRow,
    names: Sequence[str],
    vehicles: Sequence[np.ndarray],
    walls: Sequence[np.ndarray],
    deviations: np.ndarray,
) -> AxesRow:
    """Draw a corridor mapped from several origins, one above the other.

    Parameters
    ----------
    axes : sequence of Axes
        Where to draw, one for each origin.
    names : sequence of str
        What each origin is.
    vehicles, walls : sequence of ndarray, shape (looks,)
        Estimates, m.
    deviations : ndarray, shape (looks,)
        Deviation of the wall, m, the same from every origin.
    """
    for ax, name, vehicle, wall, colour in zip(
        axes, names, vehicles, walls, (BLUE, GREEN), strict=False
    ):
        k = np.arange(len(vehicle))
        band(ax, k, wall - 2 * deviations, wall + 2 * deviations, ORANGE, alpha=0.3)
        ax.plot(k, wall, color=ORANGE)
        ax.plot(k, vehicle, ".-", color=colour)
        ax.set(xlabel=LOOKS, ylabel="along the corridor (m)", title=name)
        ax.set(ylim=(vehicle[0] - 1.5, wall[0] + 3.0), xticks=k[::3])
        label(ax, 0.4, wall[0] + 1.5, "end wall", ORANGE)
        label(ax, 0.62 * k[-1], vehicle[0] + 2.2, "robot", colour)
    return axes
