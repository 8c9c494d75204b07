"""Drawings of what an anchor leaves unseen: moved worlds, and information that nobody sent."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from robot_perception.chapters.anchored_slam.gauge import MovedWorld
from robot_perception.chapters.anchored_slam.invented import Result
from robot_perception.chapters.monobot.figures import AxesRow
from robot_perception.geometry import act
from robot_perception.teaching.figures.style import MEANING, band, label

WINDOW = (-2.6, 8.1), (-3.7, 6.4)
_ROBOT = np.array([[0.35, 0.0], [-0.2, 0.2], [-0.2, -0.2], [0.35, 0.0]])


def moved_world(ax: Axes, world: MovedWorld) -> Axes:
    """Draw a world before (grey) and after (blue) it was moved, on axes cleared first.

    A measurement that no longer fits is a magenta line: from where it asks a known thing to be, to
    where that is.
    """
    ax.clear()
    ax.grid(visible=False)
    known = np.broadcast_to(world.anchors, world.misses.shape)
    old, new, error = MEANING["world"], MEANING["moved world"], MEANING["error"]
    before, after = (
        (world.poses, world.landmarks, known, old, 0.35),
        (world.moved_poses, world.moved_landmarks, world.misses, new, 1.0),
    )
    for poses, landmarks, seen, colour, alpha in (before, after):
        points = np.concatenate([np.tile(landmarks, (len(poses), 1, 1)), seen], axis=1)
        ends = np.broadcast_to(poses[:, None, :2], points.shape)
        rays = _strokes(ends.reshape(-1, 2), points.reshape(-1, 2))
        ax.plot(*rays, color=colour, lw=0.6, alpha=alpha)
    for poses, landmarks, _, colour, _ in (before, after):
        outline = act(poses, np.tile(_ROBOT, (len(poses), 1, 1)))
        outline = np.concatenate([outline, np.full((len(poses), 1, 2), np.nan)], axis=1)
        ax.plot(*outline.reshape(-1, 2).T, color=colour, lw=1.6)
        ax.plot(*landmarks.T, "o", color=colour, markersize=6)
    gaps = [world.misses.reshape(-1, 2), world.moved_poses[: len(world.fixes), :2]]
    places = [known.reshape(-1, 2), world.fixes]
    ax.plot(*_strokes(np.vstack(gaps), np.vstack(places)), color=error, lw=2.0)
    anchor, sensor = MEANING["anchor"], MEANING["position sensor"]
    ax.plot(*world.anchors.T, "s", color=anchor, markersize=9)
    ax.plot(*world.fixes.T, "+", color=sensor, markersize=10, markeredgewidth=2)
    unseen = max(world.metres, world.radians) < 1e-9
    heading = f", heading {np.degrees(world.radians):.0f}°" if world.radians > 1e-9 else ""
    words = f"largest residual {world.metres:.2f} m{heading}"
    colour = MEANING["agreement"] if unseen else error
    label(ax, 0.02, 0.96, words, colour, transform=ax.transAxes, fontsize=11)
    legend = [("● the world", old), ("● moved", new)]
    legend += [("■ anchor", anchor)] if len(world.anchors) else []
    legend += [("+ position sensor", sensor)] if len(world.fixes) else []
    for i, (text, colour) in enumerate(legend):
        label(ax, 0.98, 0.05 + 0.06 * i, text, colour, transform=ax.transAxes, ha="right")
    ax.set(xlim=WINDOW[0], ylim=WINDOW[1], xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.locator_params(nbins=5)
    return ax


def claimed_information(ax: Axes, study: Mapping[str, Result]) -> Axes:
    """Draw the information that filters claim about the turn of the world, over that at the start.

    Parameters
    ----------
    ax
        Where to draw.
    study
        The three filters in their order; lines are medians, bands the central 80 % of the runs.
    """
    ax.axhline(1, color=MEANING["expected"], linewidth=0.8)
    top = max(np.quantile(result.gains, 0.9, axis=0).max() for result in study.values())
    styles = zip(("-", "-", "--"), (1.6 * top, 0.55, 1.6), strict=True)
    for (name, result), (line, place) in zip(study.items(), styles, strict=True):
        colour = MEANING[name]
        k = np.arange(result.gains.shape[1])
        low, middle, high = np.quantile(result.gains, [0.1, 0.5, 0.9], axis=0)
        band(ax, k, low, high, colour)
        ax.semilogy(k, middle, color=colour, linestyle=line)
        label(ax, 0.97 * k[-1], place, name, colour, ha="right")
    ax.minorticks_off()
    ax.set(xlim=(0, k[-1]), xlabel="steps", ylabel="information / start")
    ax.set_ylim(0.3, 3 * top)
    return ax


def heading_honesty(axes: AxesRow, study: Mapping[str, Result]) -> AxesRow:
    """Draw for each filter the stated deviation of the heading and the error really made.

    Parameters
    ----------
    axes
        One for each filter.
    study
        By filter; root mean squares over the runs are drawn.
    """
    stated = {name: np.degrees(result.stated) for name, result in study.items()}
    errors = {name: np.degrees(result.rms) for name, result in study.items()}
    top = 1.25 * max(values.max() for values in (*stated.values(), *errors.values()))
    made = MEANING["error"]
    for ax, (name, typical) in zip(axes, stated.items(), strict=True):
        colour = MEANING[name]
        k = np.arange(1, typical.size + 1)
        band(ax, k, np.zeros(k.size), typical, colour)
        ax.plot(k, typical, color=colour)
        ax.plot(k, errors[name], color=made)
        ax.set(xlim=(0, k[-1]), ylim=(0, top), xlabel="steps", title=name)
        ax.locator_params(nbins=4)
        ax.set_ylabel("heading, 1σ (°)")
        label(ax, 0.95, 0.9, "error made", made, ha="right", transform=ax.transAxes)
        label(ax, 0.95, 0.08, "stated", colour, ha="right", transform=ax.transAxes)
    return axes


def _strokes(starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return the coordinates (2, 3n) of separate strokes as one path."""
    return np.stack([starts, ends, np.full(starts.shape, np.nan)], axis=1).reshape(-1, 2).T
