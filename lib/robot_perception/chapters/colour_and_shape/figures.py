"""Figures of the chapter "Colour and shape": experiments, colours, samples, one iteration."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from data_synth.coloured import Sequence as Film
from robot_perception.chapters.colour_and_shape import explorers, films
from robot_perception.chapters.colour_and_shape.experiments import LOST, WORLDS
from robot_perception.chapters.colour_and_shape.films import Tracks, outline, picture
from robot_perception.chapters.colour_and_shape.iteration import Iteration
from robot_perception.chapters.colour_and_shape.samples import Path, Samples
from robot_perception.teaching.figures.style import MEANING, label
from robot_perception.teaching.tables import Table


def _near(ax: Axes, points: np.ndarray, half: float = 60.0) -> None:
    """Show of a picture what lies round some points."""
    u, v = (points.min(axis=0) + points.max(axis=0)) / 2
    u, v = np.clip(u, 4 / 3 * half, 319 - 4 / 3 * half), np.clip(v, half, 239 - half)
    ax.set(xlim=(u - 4 / 3 * half, u + 4 / 3 * half), ylim=(v + half, v - half))


# The experiments ---------------------------------------------------------------------------------


def hero(axes: Sequence[Axes], at: int = 50) -> Sequence[Axes]:
    """Draw a frame of each experiment with the true outline and those of three trackers."""
    for ax, world in zip(axes, WORLDS, strict=True):
        film, found = films.filmed(world), films.tracks(world)
        picture(ax, film.frames[at])
        for name in ("colours adapted", "edges alone", "fused"):
            outline(ax, found.outlines[name][at - 1], name)
        outline(ax, film.outlines[at], "truth", linewidth=1.4)
        ax.set_title(world)
    return axes


def overlaps(axes: Sequence[Axes]) -> Sequence[Axes]:
    """Draw the overlap with the truth against the frame, by tracker, one experiment an axes."""
    for ax, world in zip(axes, WORLDS, strict=True):
        _overlap(ax, films.tracks(world))
        ax.set_title(world)
    axes[0].legend(loc="center left", bbox_to_anchor=(0.0, 0.42))
    return axes


def _overlap(ax: Axes, found: Tracks) -> Axes:
    """Draw the overlap with the truth against the frame, by tracker."""
    for name, values in found.overlap.items():
        k = np.arange(1, len(values) + 1)
        line = films.LINES[name]
        ax.plot(k, values, line, color=MEANING[name], label=name, linewidth=2.0)
    ax.axhline(LOST, color=MEANING["expected"], linewidth=1.0)
    label(ax, 0.5, LOST - 0.06, "lost", MEANING["expected"])
    ax.set(xlabel="frame", ylabel="overlap with the object", ylim=(0, 1.03))
    ax.set_xlim(0, len(values))
    return ax


def many(axes: Sequence[Axes], found: Table) -> Sequence[Axes]:
    """Draw the mean overlap of the fused tracker against the number of samples, by kind of film."""
    counts = [int(count) for count in found.rows]
    for ax, world in zip(axes, found.columns, strict=True):
        cells = [found[row, world] for row in found.rows]
        middle = np.array([cell.estimate for cell in cells])
        ax.fill_between(
            counts,
            [cell.low for cell in cells],
            [cell.high for cell in cells],
            color=MEANING["fused"],
            alpha=0.2,
            linewidth=0,
        )
        ax.plot(counts, middle, "o-", color=MEANING["fused"])
        ax.set_xscale("log")
        ax.set_xticks(counts, [str(count) for count in counts])
        ax.minorticks_off()
        ax.set(xlabel="samples N", ylabel="mean overlap", ylim=(0, 1.03))
        ax.set_title(world)
    return axes


# Colours -----------------------------------------------------------------------------------------


def path(axes: Sequence[Axes], film: Film, found: Path, at: Sequence[int]) -> Sequence[Axes]:
    """Draw some frames of a film, and in the last axes the way of the target's mean colour."""
    *pictures, ax = axes
    for panel, k in zip(pictures, at, strict=True):
        picture(panel, film.frames[k])
        _near(panel, film.outlines[k])
        panel.set_title(f"frame {k}")
    red, _, blue = found.colours.T.astype(float)
    ax.plot(red, blue, color=MEANING["expected"], linewidth=0.8)
    ax.scatter(red, blue, s=34, c=found.colours / 255, linewidths=0, zorder=3)
    for k in at:
        ax.plot(red[k], blue[k], "o", markersize=10, fillstyle="none", color=MEANING["truth"])
        ax.annotate(str(k), (red[k], blue[k]), (8, -10), textcoords="offset points", fontsize=10)
    ax.set(xlim=_room(red, 0.15), ylim=_room(blue, 0.15), xlabel="red", ylabel="blue")
    ax.set_title("mean colour")
    return axes


def samples(axes: Sequence[Sequence[Axes]], found: Samples) -> Sequence[Sequence[Axes]]:
    """Draw colours of samples in the opponent space, one a column; below, what has such colours."""
    everything = _rgb(found.clouds.reshape(-1, 3))
    left, right = _room(everything.sum(axis=1))
    low, high = _room(everything[:, 1] - everything[:, 0])
    for above, below, cloud, blob, points, weight in zip(
        *axes, found.clouds, found.blobs, found.outlines, found.weights, strict=True
    ):
        colours = _rgb(cloud)
        x, y = colours.sum(axis=1), colours[:, 1] - colours[:, 0]
        edges = {"edgecolors": MEANING["expected"], "linewidths": 0.3}
        above.scatter(x, y, s=16, c=np.clip(colours, 0, 255) / 255, **edges)
        above.set(xlim=(left, right), ylim=(low, high), xlabel="R + G + B", ylabel="G − R")
        above.set_title(f"weight {weight:.2f}")
        faded = 110 + found.image.astype(float) * 0.2
        shown = np.where(blob[..., None], found.image, faded)
        picture(below, np.round(shown).astype(np.uint8))
        _near(below, found.outlines[0], 62.0)
        closed = np.vstack([points, points[:1]])
        below.plot(*closed.T, color=MEANING["affine snake"], linewidth=2.2)
    return axes


def _room(values: Float[np.ndarray, " n"], share: float = 0.08) -> tuple[float, float]:
    """Return limits with some room on both sides of values."""
    spare = share * np.ptp(values)
    return float(values.min() - spare), float(values.max() + spare)


def _rgb(opponent: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """Return red, green and blue of coordinates of the opponent space; beyond 0 … 255 as well."""
    blue_green, green_red = 511 * opponent[:, :2].T - 255
    green = (766 * opponent[:, 2] - blue_green + green_red) / 3
    return np.stack([green - green_red, green, green + blue_green], axis=-1)


# One iteration -----------------------------------------------------------------------------------

_TOP = {"a": 4.0, "b": 3.0, "c": 2.0, "d": 1.0, "e": 0.0}


def _sizes(weights: np.ndarray) -> np.ndarray:
    """Return areas of points, as large together for few samples as for many."""
    return np.clip(2400 * weights / weights.sum(), 3, 300)


def _joined(ax: Axes, start: np.ndarray, end: np.ndarray, top: float) -> None:
    """Draw where samples come from; fainter the more they are."""
    gap = np.full(len(start), np.nan)
    x = np.stack([start, end, gap], axis=1).ravel()
    y = np.tile([top - 0.12, top - 0.88, np.nan], len(start))
    faint = float(np.clip(12 / len(start), 0.15, 0.8))
    ax.plot(x, y, color=MEANING["expected"], linewidth=0.8, alpha=faint)


def iterated(ax: Axes, found: Iteration, step: str) -> Axes:
    """Draw an iteration up to one of its steps, each below the one before; axes cleared first."""
    ax.clear()
    even = np.ones(len(found.start))
    rows = {
        "a": (found.start, found.start_weights),
        "b": (found.start[found.ancestors], even),
        "c": (found.drifted, even),
        "d": (found.moved, even),
        "e": (found.moved, found.weights),
    }
    last = None
    for name, (places, weights) in rows.items():
        if name > step:
            break
        top = _TOP[name]
        if last is not None and name != "e":
            _joined(ax, found.start[found.ancestors] if name == "b" else last, places, top + 1)
        size = _sizes(weights)
        ax.scatter(
            places,
            np.full(len(places), top),
            s=size,
            color=MEANING["estimate"],
            alpha=0.45,
            linewidths=0,
            zorder=3,
        )
        label(ax, 1.0, top + 0.4, explorers.STEPS[name], MEANING["expected"], ha="right")
        last = places
    if step == "e":
        ax.fill_between(
            found.grid,
            -0.75,
            -0.75 + 0.6 * found.likelihood,
            color=MEANING["readings"],
            alpha=0.25,
            linewidth=0,
        )
        label(ax, 0.02, -0.55, "fit to the frame", MEANING["readings"])
    ax.set(xlim=(0, 1), ylim=(-0.8, 4.6), xlabel="brightness")
    ax.set_yticks(list(_TOP.values()), [f"({name})" for name in _TOP])
    ax.grid(visible=False)
    return ax


def tried(ax: Axes, samples: int, noise: float) -> Axes:
    """Draw the overlap by frame for a number of samples and a noise; axes cleared first."""
    ax.clear()
    found = explorers.grid().overlap
    k = np.arange(1, found.shape[-1] + 1)
    ax.plot(k, found.reshape(-1, len(k)).T, color=MEANING["expected"], linewidth=1.2, alpha=0.6)
    values = explorers.overlap(samples, noise)
    ax.plot(k, values, color=MEANING["fused"], linewidth=2.6)
    ax.axhline(LOST, color=MEANING["expected"], linewidth=1.0)
    label(ax, 1.2, LOST - 0.06, "lost", MEANING["expected"])
    still = float(explorers.overlap(samples, 0.0)[7])
    label(ax, 8.0, still + 0.03, "no noise", MEANING["expected"])
    ax.set(xlim=(1, k[-1]), ylim=(0, 1.03), xlabel="frame", ylabel="overlap with the circle")
    ax.set_title(f"on average {values.mean():.2f}")
    return ax
