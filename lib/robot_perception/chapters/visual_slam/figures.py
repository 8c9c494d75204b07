"""Drawings of the chapter: pictures, maps, particles over time, the map in space."""

import numpy as np
from matplotlib.axes import Axes

from robot_perception.chapters.monobot.figures import AxesRow
from robot_perception.chapters.visual_slam import explorers, frontend
from robot_perception.chapters.visual_slam.drives import Drive
from robot_perception.chapters.visual_slam.frontend import Seen
from robot_perception.chapters.visual_slam.recordings import Followed
from robot_perception.evaluation.trajectories import align
from robot_perception.geometry import act
from robot_perception.teaching.figures.maps import dots, lines, plan
from robot_perception.teaching.figures.style import MEANING, label

FLOOR = np.array([[-0.6, -5.6], [20.7, 7.8]])
"""Corners of the axes around the walls, m."""
WIDE = np.array([[-3.2, -6.6], [21.2, 10.2]])
"""Corners of the axes of maps, m: that by one particle reaches over the walls."""


TICKS = 1, 2, 5, 10, 20, 50


def walls_of(drive: Drive) -> np.ndarray:
    """Return the walls of the building from above, (walls, 2, 2)."""
    film = explorers.FILM
    return frontend.world(film.seed, film.poses)[0].plan


def built(ax: Axes, drive: Drive) -> Axes:
    """Draw Fig. 4 again, on axes cleared first: landmarks and path over the plan, and the truth."""
    ax.clear()
    lines(ax, walls_of(drive), MEANING["truth"], 2.4, alpha=0.25, zorder=0)
    dots(ax, drive.means[:, :2], MEANING["landmark"], 1.6)
    ax.plot(*drive.seen.poses[:, :2].T, color=MEANING["truth"], linewidth=1.0)
    ax.plot(*drive.path[:, :2].T, color=MEANING["robot"], linewidth=1.4, linestyle="--")
    plan(ax, WIDE, margin=0.0)
    ax.locator_params(nbins=5)
    return ax


def wheels_alone(ax: Axes, drive: Drive) -> Axes:
    """Draw Fig. 4d again: the true path and that by the wheels."""
    lines(ax, walls_of(drive), MEANING["truth"], 2.4, alpha=0.25, zorder=0)
    ax.plot(*drive.seen.poses[:, :2].T, color=MEANING["truth"], linewidth=1.0)
    ax.plot(*drive.odometry[:, :2].T, color=MEANING["odometry"], linewidth=1.4, linestyle="--")
    plan(ax, FLOOR, margin=0.0)
    ax.locator_params(nbins=5)
    return ax


def tracks_on(ax: Axes, seen: Seen, frame: int, *, stable: int = 5) -> Axes:
    """Draw the points of a frame over its picture: with the trail of those that are stable."""
    ax.clear()
    here = seen.frames == frame
    for track, pixel in zip(seen.tracks[here], seen.pixels[here], strict=True):
        trail = seen.pixels[(seen.tracks == track) & (seen.frames <= frame)]
        if len(trail) > stable:
            ax.plot(*trail[-12:].T, color=MEANING["landmark"], linewidth=1.6)
            ax.plot(*pixel, "o", color=MEANING["landmark"], markersize=4)
        else:
            ax.plot(*pixel, "o", color=MEANING["kept"], markersize=2.5)
    return ax


def particles(axes: AxesRow, drive: Drive, frame: int) -> AxesRow:
    """Draw the particles at a frame with the paths that led there, and numbers over time."""
    for ax in axes:
        ax.clear()
    above, below = axes
    lines(above, walls_of(drive), MEANING["truth"], 2.4, alpha=0.25, zorder=0)
    above.plot(*drive.seen.poses[: frame + 1, :2].T, color=MEANING["truth"], linewidth=1.0)
    alive = np.arange(drive.poses.shape[1])
    paths = np.empty((frame + 1, len(alive), 2))
    for k in range(frame, -1, -1):
        paths[k] = drive.poses[k, alive, :2]
        alive = drive.ancestors[k][alive]
    for path in np.unique(paths, axis=1).swapaxes(0, 1):
        above.plot(*path[:: max(1, frame // 120)].T, color=MEANING["robot"], linewidth=0.7)
    above.plot(*drive.poses[frame, :, :2].T, "o", color=MEANING["robot"], markersize=2.5)
    plan(above, FLOOR, margin=0.0)
    above.locator_params(nbins=5)
    shown = np.union1d(np.arange(0, frame, 3), np.arange(max(frame - 15, 0), frame + 1))
    count = drive.poses.shape[1]
    below.plot(shown, drive.effective[shown], color=MEANING["expected"], linewidth=1.0)
    below.plot(
        shown, explorers.ancestors(drive, frame)[shown], color=MEANING["robot"], linewidth=2.2
    )
    below.axhline(count / 2, color=MEANING["paper"], linewidth=1.0, linestyle="--")
    below.set_yscale("log")
    below.set_yticks(TICKS, [f"{tick:g}" for tick in TICKS])
    below.minorticks_off()
    below.set(
        xlim=(0, len(drive.poses)),
        ylim=(0.85, 1.3 * count),
        xlabel="frame",
        ylabel="particles (log)",
    )
    label(below, 0.99 * len(drive.poses), 0.54 * count, "M/2", MEANING["paper"], ha="right")
    return axes


def in_space(ax: Axes, drive: Drive, turn: float) -> Axes:
    """Draw the map in space, turned, on axes cleared first: landmarks, floor plan and path."""
    ax.clear()
    motion = align(drive.path, drive.seen.poses)
    ends = walls_of(drive)
    floor = np.concatenate([ends, np.zeros((*ends.shape[:2], 1))], axis=-1)
    seen = explorers.turned(floor.reshape(-1, 3), turn).reshape(-1, 2, 2)
    lines(ax, seen, MEANING["truth"], 1.6, alpha=0.3, zorder=0)
    path = act(motion, drive.path[::4, :2])
    way = explorers.turned(np.column_stack([path, np.zeros(len(path))]), turn)
    ax.plot(*way.T, color=MEANING["robot"], linewidth=1.0)
    places = np.column_stack([act(motion, drive.means[:, :2]), drive.means[:, 2]])
    dots(ax, explorers.turned(places, turn), MEANING["landmark"], 1.4)
    ax.set(xlim=(-12.5, 12.5), ylim=(-7.4, 9.0))
    ax.set_aspect("equal", adjustable="box")
    ax.set_position((0.0, 0.0, 1.0, 1.0))
    ax.set_axis_off()
    return ax


def car(ax: Axes, result: Followed) -> Axes:
    """Draw the path of a car, true, by its wheels and by the filter, with the landmarks near it."""
    near = np.abs(result.points - result.truth[:, None, :2]).max(axis=-1).min(axis=0) < 12
    dots(ax, result.points[near], MEANING["landmark"], 1.4)
    ax.plot(*result.truth[:, :2].T, color=MEANING["truth"], linewidth=1.4)
    ax.plot(*result.wheels[:, :2].T, color=MEANING["odometry"], linewidth=1.4, linestyle=":")
    ax.plot(*result.paths[100][:, :2].T, color=MEANING["robot"], linewidth=1.6, linestyle="--")
    plan(ax, result.truth[:, :2], margin=6.0)
    ax.locator_params(nbins=6)
    return ax
