"""The film of the chapter: what an eye sees, and what the filter makes of it, by one clock."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robot_perception.chapters.visual_slam import drives, frontend
from robot_perception.chapters.visual_slam import figures as draw
from robot_perception.chapters.visual_slam.explorers import PLAYED, draws
from robot_perception.slam import rao_blackwellised as rb
from robot_perception.slam.planar import dead_reckoning
from robot_perception.slam.visual import Options
from robot_perception.teaching.figures import figure, film
from robot_perception.teaching.figures.style import MEANING, label
from robot_perception.teaching.media import Shown
from robot_perception.teaching.results import kept

SHOWN = range(0, frontend.FRAMES, frontend.EVERY)
FPS = 5
WIDTH, HEIGHT = 6.4, 4.6
PLACES = (0.02, 0.4, 0.47, 0.54), (0.6, 0.4, 0.39, 0.54), (0.1, 0.11, 0.88, 0.2)
"""Of picture, map and errors in the frame of a film: left, bottom, width, height."""
MOST, LINE = 1.5, 0.28
"""Upper end of the axis of errors, and the height of a label on it, m."""


@dataclass(frozen=True, eq=False, slots=True)
class Moment:
    """What the filter knows at a frame: its particles, and path and landmarks of the heaviest, m.

    ``used`` are the points of the frame, rows of what was seen, that were of known landmarks.
    """

    path: Float[np.ndarray, "times 3"]
    particles: Float[np.ndarray, "M 3"]
    landmarks: Float[np.ndarray, "n 3"]
    used: Int[np.ndarray, "points"]


@kept
def moments() -> tuple[Float[np.ndarray, "frames 3"], list[Moment]]:
    """Return the path by the wheels of the drive that is shown, and what the filter knew."""
    seen, ancestors, poses, found = frontend.seen(), [], [], []
    report, rng = draws(PLAYED)
    run = drives.steps(seen, Options(PLAYED), report, rng=rng)
    for frame, (state, info, _) in enumerate(run):
        ancestors.append(info.resampling.ancestors)
        poses.append(state.maps.poses)
        if frame in SHOWN:
            best = state.maps.best
            line = rb.lineage(ancestors)[:, best]
            path = np.array([at[m] for at, m in zip(poses, line, strict=True)])
            used = np.flatnonzero(seen.frames == frame)[info.known]
            found.append(Moment(path, poses[-1], state.maps.landmarks(best)[1].mean, used))
    return dead_reckoning(seen.poses[0], drives.motions(report)), found


def show(name: str | None = "slam-clock") -> Shown:
    """Show the drive: picture, map and errors, by one clock."""
    return film(
        frames(),
        fps=FPS,
        name=name,
        poster=len(SHOWN) // 2,
        alt="Above left a frame of the left camera with points on doors, shelves and posters; "
        "above right the floor plan, in which landmarks and a dashed path grow along a corridor "
        "and through rooms; below, the error of the wheels climbs, that of the filter stays low.",
        caption="The drive. Left: what the left eye sees; orange, points that both eyes see; "
        "green, those of landmarks of the map. Right: the map of the heaviest of fifty particles, "
        "its path (dashed red), all particles (red dots) and the truth (solid). Below: how far the "
        "position is off, by the wheels alone (grey) and by the filter (red).",
    )


def frames() -> Iterator[Figure]:
    """Yield the frames of the film, all drawn on one figure."""
    wheels, found = moments()
    fig, axes = figure(1, 3, width=WIDTH, height=HEIGHT)
    for ax, place in zip(axes, PLACES, strict=True):
        ax.set_position(place)
    eye, above, below = axes
    for picture, frame, moment in zip(frontend.film(), SHOWN, found, strict=True):
        look(eye, picture, frame, moment)
        built(above, frame, moment)
        astray(below, wheels, frame, moment)
        yield fig


def off(path: Float[np.ndarray, "times 3"]) -> Float[np.ndarray, "times"]:
    """Return how far a path is from the true positions at its times, m."""
    return np.linalg.norm(path[:, :2] - frontend.seen().poses[: len(path), :2], axis=1)


def worst() -> tuple[float, float]:
    """Return by how much the position by the wheels and by the filter is off at most, m."""
    wheels, found = moments()
    return float(off(wheels).max()), max(float(off(moment.path)[-1]) for moment in found)


def look(ax: Axes, picture: np.ndarray, frame: int, moment: Moment) -> Axes:
    """Draw a picture with what both eyes see in it, and the landmarks, on axes cleared first."""
    ax.clear()
    seen = frontend.seen()
    ax.imshow(picture, cmap="gray", vmin=0, vmax=255)
    ax.plot(*seen.pixels[seen.frames == frame].T, "o", color=MEANING["kept"], markersize=1.2)
    ax.plot(*seen.pixels[moment.used].T, "o", color=MEANING["landmark"], markersize=3)
    ax.set_axis_off()
    ax.set_title(f"frame {frame}")
    return ax


def built(ax: Axes, frame: int, moment: Moment) -> Axes:
    """Draw map, path and particles over the plan, on axes cleared first."""
    ax.clear()
    ax.plot(*moment.landmarks[:, :2].T, "o", color=MEANING["landmark"], markersize=1.2)
    draw.ground(ax, frontend.seen().poses[: frame + 1], draw.WIDE)
    ax.plot(*moment.path[:, :2].T, color=MEANING["robot"], linewidth=1.2, linestyle="--")
    ax.plot(*moment.particles[:, :2].T, "o", color=MEANING["robot"], markersize=2)
    ax.set_title(f"{len(moment.landmarks)} landmarks")
    return ax


def astray(ax: Axes, wheels: Float[np.ndarray, "frames 3"], frame: int, moment: Moment) -> Axes:
    """Draw how far the position was off until a frame, on axes cleared first."""
    ax.clear()
    errors = {"filter": off(moment.path), "wheels": off(wheels[: frame + 1])}
    height = -LINE
    for name, past in sorted(errors.items(), key=lambda item: item[1][-1]):
        colour = MEANING["robot" if name == "filter" else "odometry"]
        ax.plot(past, color=colour, linewidth=1.6)
        height = max(height + LINE, past[-1])  # two labels do not overlap
        label(ax, frame + 6, height, f"{name} {past[-1]:.1f} m", colour)
    ax.set(xlim=(0, 1.25 * frontend.FRAMES), ylim=(0, MOST), xlabel="frame", ylabel="off by (m)")
    ax.set_xticks(range(0, frontend.FRAMES, 100))
    return ax
