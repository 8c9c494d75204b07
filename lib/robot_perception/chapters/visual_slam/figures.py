"""Drawings of the chapter: pictures, maps, particles over time, the map in space."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from explorables.figures import drawn, film, image_axes
from explorables.figures.charts import strip
from explorables.figures.maps import dots, lines, plan
from explorables.figures.style import MEANING, AxesRow, label
from explorables.media import Shown
from robot_perception.chapters.visual_slam.recordings import Followed
from robot_perception.evaluation.trajectories import align
from robot_perception.geometry import act

FLOOR = np.array([[-0.6, -5.6], [20.7, 7.8]])
"""Corners of the axes around the walls, m."""
WIDE = np.array([[-3.2, -6.6], [21.2, 10.2]])
"""Corners of the axes of maps, m: that by one particle reaches over the walls."""
TICKS = 1, 2, 5, 10, 20, 50


# Pictures ----------------------------------------------------------------------------------------


def ride(pictures: Sequence[np.ndarray]) -> Shown:
    """Show the drive through the left eye."""
    return film(
        pictures,
        fps=6,
        name="slam-film",
        alt="Frames of the left camera along the drive: a corridor with doors and posters, rooms "
        "with shelves, bare walls.",
        caption="The drive through the left eye, every tenth frame. Doors, posters and shelves "
        "are each made of a few pictures only, so that some places look alike.",
    )


@drawn(
    name="slam-tracks",
    alt="A book shelf seen by the left camera. Green trails run from the right to the left where "
    "features were followed for some frames; many orange dots have no trail.",
    caption="Frame 120, while the robot turns. Orange: points that both eyes see. Green, with "
    "their trails: those that were followed for more than five frames, and so count.",
    axes=lambda picture, seen, frame, stable: image_axes(picture),
)
def tracks_on(ax: Axes, picture: np.ndarray, seen: Any, frame: int, stable: int) -> Axes:
    """Draw the points of a frame over its picture: with the trail of those that are stable."""
    here = seen.frames == frame
    for track, pixel in zip(seen.tracks[here], seen.pixels[here], strict=True):
        trail = seen.pixels[(seen.tracks == track) & (seen.frames <= frame)]
        if len(trail) > stable:
            ax.plot(*trail[-12:].T, color=MEANING["landmark"], linewidth=1.6)
            ax.plot(*pixel, "o", color=MEANING["landmark"], markersize=4)
        else:
            ax.plot(*pixel, "o", color=MEANING["kept"], markersize=2.5)
    return ax


# The building ------------------------------------------------------------------------------------


def ground(ax: Axes, walls: np.ndarray, truth: np.ndarray, corners: np.ndarray) -> None:
    """Draw the plan of the building and the true path, on axes of some corners."""
    lines(ax, walls, MEANING["truth"], 2.4, alpha=0.25, zorder=0)
    ax.plot(*truth[:, :2].T, color=MEANING["truth"], linewidth=1.0)
    plan(ax, corners, margin=0.0)
    ax.locator_params(nbins=5)


def built(ax: Axes, drive: Any, walls: np.ndarray) -> Axes:
    """Draw Fig. 4 again, on axes cleared first: landmarks and path over the plan, and the truth."""
    ax.clear()
    dots(ax, drive.means[:, :2], MEANING["landmark"], 1.6)
    ground(ax, walls, drive.seen.poses, WIDE)
    ax.plot(*drive.path[:, :2].T, color=MEANING["robot"], linewidth=1.4, linestyle="--")
    return ax


@drawn(
    name="slam-wheels",
    alt="Floor plan of the building with two paths: the one by the wheels follows the true one "
    "and drifts off by up to a metre.",
    caption="The path by the wheels alone (dashed) and the true one (solid) from the same start. "
    "Grey: the walls.",
    width=6.4,
    height=4.2,
)
def wheels_alone(ax: Axes, drive: Any, walls: np.ndarray) -> Axes:
    """Draw Fig. 4d again: the true path and that by the wheels."""
    ground(ax, walls, drive.seen.poses, FLOOR)
    ax.plot(*drive.odometry[:, :2].T, color=MEANING["odometry"], linewidth=1.4, linestyle="--")
    start = drive.seen.poses[0, :2]
    ax.plot(*start, "o", color=MEANING["truth"], markersize=7)
    label(ax, start[0], start[1] + 0.55, "start", MEANING["truth"], ha="center")
    return ax


@drawn(
    name="slam-drives",
    alt="Three rows of dots on one axis. One particle: up to several metres off. Ten and fifty "
    "particles: mostly below one metre. A ring in each row marks the drive that is shown.",
    caption="Dots: sixty drives through twenty other buildings of the same plan, each by how far "
    "the path is off. Rings: the drive that is shown.",
    width=6.4,
    height=2.3,
)
def drives(ax: Axes, errors: Mapping[str, Sequence[float]], shown: Mapping[str, float]) -> Axes:
    """Draw where the drive that is shown lies among those that are scored."""
    return strip(ax, errors, shown, "path off by (m, root mean square)")


@drawn(
    name="slam-mends",
    alt="Six rows of six dots on one axis: the wheels alone, the filter as printed, with each of "
    "two mends, with both, and with names told as well.",
    caption="Dots: six drives through buildings of six plans, each by how far the path is off. "
    "Rings: their mean.",
    width=6.4,
    height=4.2,
)
def mends(ax: Axes, errors: Mapping[str, Sequence[float]]) -> Axes:
    """Draw how far the path is off with the wheels alone and with each front end."""
    middles = {name: float(np.mean(values)) for name, values in errors.items()}
    return strip(ax, errors, middles, "path off by (m, root mean square)")


def particles(axes: AxesRow, state: Any, walls: np.ndarray) -> AxesRow:
    """Draw the particles at a moment with the paths that led there, and numbers over time."""
    for ax in axes:
        ax.clear()
    (above, below), drive, frame = axes, state.drive, state.at
    ground(above, walls, drive.seen.poses[: frame + 1], FLOOR)
    for path in np.unique(state.paths[..., :2], axis=1).swapaxes(0, 1):
        above.plot(*path[:: max(1, frame // 120)].T, color=MEANING["robot"], linewidth=0.7)
    above.plot(*drive.poses[frame, :, :2].T, "o", color=MEANING["robot"], markersize=2.5)
    shown = np.union1d(np.arange(0, frame, 3), np.arange(max(frame - 15, 0), frame + 1))
    frames, count, _ = drive.poses.shape
    below.plot(shown, drive.effective[shown], color=MEANING["expected"], linewidth=1.0)
    below.plot(shown, state.alive[shown], color=MEANING["robot"], linewidth=2.2)
    below.axhline(count / 2, color=MEANING["paper"], linewidth=1.0, linestyle="--")
    below.set_yscale("log")
    below.set_yticks(TICKS, [f"{tick:g}" for tick in TICKS])
    below.minorticks_off()
    below.set(xlim=(0, frames), ylim=(0.85, 1.3 * count), xlabel="frame", ylabel="particles (log)")
    label(below, 0.99 * frames, 0.54 * count, "M/2", MEANING["paper"], ha="right")
    return axes


def turned(points: Float[np.ndarray, "n 3"], turn: float) -> Float[np.ndarray, "n 2"]:
    """Return points of space as seen from a height, the building turned by some degrees."""
    angle, tilt = np.deg2rad(turn), np.deg2rad(35.0)
    x, y, z = (points - [10.0, 1.1, 0.0]).T
    across = np.cos(angle) * x - np.sin(angle) * y
    away = np.sin(angle) * x + np.cos(angle) * y
    return np.stack([across, np.sin(tilt) * away + np.cos(tilt) * z], axis=-1)


def in_space(ax: Axes, drive: Any, turn: float, walls: np.ndarray) -> Axes:
    """Draw the map in space, turned, on axes cleared first: landmarks, floor plan and path."""
    ax.clear()
    motion = align(drive.path, drive.seen.poses)
    ends, path = walls.reshape(-1, 2), act(motion, drive.path[::4, :2])
    floor, way = (turned(np.pad(p, ((0, 0), (0, 1))), turn) for p in (ends, path))
    lines(ax, floor.reshape(-1, 2, 2), MEANING["truth"], 1.6, alpha=0.3, zorder=0)
    ax.plot(*way.T, color=MEANING["robot"], linewidth=1.0)
    places = np.column_stack([act(motion, drive.means[:, :2]), drive.means[:, 2]])
    dots(ax, turned(places, turn), MEANING["landmark"], 1.4)
    ax.set(xlim=(-12.5, 12.5), ylim=(-7.4, 9.0))
    ax.set_aspect("equal", adjustable="box")
    ax.set_position((0.0, 0.0, 1.0, 1.0))
    ax.set_axis_off()
    return ax


def route(ax: Axes, walls: np.ndarray, path: np.ndarray) -> Axes:
    """Draw a floor plan and the way through it about its middle, on axes cleared first."""
    ax.clear()
    middle = np.mean([walls.min(axis=(0, 1)), walls.max(axis=(0, 1))], axis=0)
    lines(ax, walls - middle, MEANING["truth"], 2.0, alpha=0.4, zorder=0)
    way = path[:, :2] - middle
    ax.plot(*way.T, color=MEANING["robot"], linewidth=1.4)
    ax.plot(*way[0], "o", color=MEANING["robot"], markersize=6)
    plan(ax, np.array([[-18.0, -11.0], [18.0, 11.0]]), margin=0.0)
    ax.locator_params(nbins=5)
    return ax


def street(ax: Axes, result: Followed) -> Axes:
    """Draw the path of a car, true, by its wheels and by the filter, with the landmarks near it."""
    near = np.abs(result.points - result.truth[:, None, :2]).max(axis=-1).min(axis=0) < 12
    dots(ax, result.points[near], MEANING["landmark"], 1.4)
    ax.plot(*result.truth[:, :2].T, color=MEANING["truth"], linewidth=1.4)
    ax.plot(*result.wheels[:, :2].T, color=MEANING["odometry"], linewidth=1.4, linestyle=":")
    ax.plot(*result.paths[100][:, :2].T, color=MEANING["robot"], linewidth=1.6, linestyle="--")
    plan(ax, result.truth[:, :2], margin=6.0)
    ax.locator_params(nbins=6)
    return ax


car = drawn(
    name="slam-car",
    alt="A street from above: the dotted path by the wheels leaves the true one; the dashed path "
    "of the filter stays on it.",
    caption="Twenty-three metres of a street. Solid: the true path; dotted: by the wheels; dashed "
    "red: with a hundred particles; green: landmarks near the path.",
    width=6.4,
    height=3.0,
)(street)
straight = drawn(
    name="stereo-straight",
    alt="A straight street from above, with three paths that spread to the right.",
    caption="The straight drive, the first of ten draws of the wheels' noise. Solid: the true "
    "path; dotted: by the wheels; dashed red: with a hundred particles; green: landmarks near the "
    "path.",
    width=6.4,
    height=3.0,
)(street)
bend = drawn(
    name="stereo-turn",
    alt="A bend from above, with three paths that part after it.",
    caption="The bend, the first draw; lines and colours as above.",
    width=6.4,
    height=4.4,
)(street)
