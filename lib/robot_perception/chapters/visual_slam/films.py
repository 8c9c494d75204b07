"""The film of the chapter: what an eye sees, and what the filter makes of it, by one clock."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int, UInt8
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from explorables.figures import figure, film
from explorables.figures.style import MEANING, label
from explorables.media import Shown
from robot_perception.chapters.visual_slam import figures as draw

FPS = 5
WIDTH, HEIGHT = 6.4, 4.6
PLACES = (0.02, 0.4, 0.47, 0.54), (0.6, 0.4, 0.39, 0.54), (0.1, 0.11, 0.88, 0.2)
"""Places of picture, map and errors in the frame of a film: left, bottom, width, height."""
MOST, LINE = 1.5, 0.28
"""Upper end of the axis of errors, and the height of a label on it, m."""


class Moment(NamedTuple):
    """State of the filter at a frame: its particles, and path and landmarks of the heaviest, m.

    ``used`` are the points of the frame, rows of what was seen, that were of known landmarks.
    """

    frame: int
    path: Float[np.ndarray, "times 3"]
    particles: Float[np.ndarray, "M 3"]
    landmarks: Float[np.ndarray, "n 3"]
    used: Int[np.ndarray, "points"]


class Clock(NamedTuple):
    """A drive to show: what was seen, left pictures, the walls, the path by the wheels, moments."""

    seen: Any
    pictures: UInt8[np.ndarray, "pictures height width"]
    walls: Float[np.ndarray, "walls 2 2"]
    wheels: Float[np.ndarray, "frames 3"]
    moments: Sequence[Moment]

    def off(self, path: Float[np.ndarray, "times 3"]) -> Float[np.ndarray, "times"]:
        """Return how far a path is from the true positions at its times, m."""
        return np.linalg.norm(path[:, :2] - self.seen.poses[: len(path), :2], axis=1)

    def errors(self) -> Float[np.ndarray, "moments 2"]:
        """Return how far wheels and filter are off at each moment, m."""
        wheels = self.off(self.wheels)
        return np.array([(wheels[one.frame], self.off(one.path)[-1]) for one in self.moments])

    def poster(self) -> int:
        """Return the moment at which the wheels are farther off than the filter by most."""
        return int(np.argmax(np.subtract(*self.errors().T)))


def show(clock: Clock, name: str | None = "slam-clock") -> Shown:
    """Show the drive: picture, map and errors, by one clock."""
    return film(
        frames(clock),
        fps=FPS,
        name=name,
        poster=clock.poster(),
        alt="Above left a frame of the left camera with points on doors, shelves and posters; "
        "above right the floor plan, in which landmarks and a dashed path grow along a corridor "
        "and through rooms; below, the error of the wheels climbs, that of the filter stays low.",
        caption="The drive. The picture: what one eye sees; orange, points that both eyes see; "
        "green, those of landmarks of the map. The plan: the map of the heaviest of fifty "
        "particles (green), its path (dashed red), all particles (red dots) and the true path "
        "(solid). The curves: how far the position is off, by the wheels alone (grey) and by the "
        "filter (red).",
    )


def frames(clock: Clock) -> Iterator[Figure]:
    """Yield the frames of the film, all drawn on one figure."""
    fig, axes = figure(1, 3, width=WIDTH, height=HEIGHT)
    for ax, place in zip(axes, PLACES, strict=True):
        ax.set_position(place)
    eye, above, below = axes
    for picture, moment in zip(clock.pictures, clock.moments, strict=True):
        look(eye, picture, clock.seen, moment)
        built(above, clock, moment)
        astray(below, clock, moment)
        yield fig


def look(ax: Axes, picture: np.ndarray, seen: Any, moment: Moment) -> Axes:
    """Draw a picture with what both eyes see in it, and the landmarks, on axes cleared first."""
    ax.clear()
    ax.imshow(picture, cmap="gray", vmin=0, vmax=255)
    here = seen.pixels[seen.frames == moment.frame]
    ax.plot(*here.T, "o", color=MEANING["kept"], markersize=1.2)
    ax.plot(*seen.pixels[moment.used].T, "o", color=MEANING["landmark"], markersize=3)
    ax.set_axis_off()
    ax.set_title(f"frame {moment.frame}")
    return ax


def built(ax: Axes, clock: Clock, moment: Moment) -> Axes:
    """Draw map, path and particles over the plan, on axes cleared first."""
    ax.clear()
    ax.plot(*moment.landmarks[:, :2].T, "o", color=MEANING["landmark"], markersize=1.2)
    draw.ground(ax, clock.walls, clock.seen.poses[: moment.frame + 1], draw.WIDE)
    ax.plot(*moment.path[:, :2].T, color=MEANING["robot"], linewidth=1.2, linestyle="--")
    ax.plot(*moment.particles[:, :2].T, "o", color=MEANING["robot"], markersize=2)
    ax.set_title(f"{len(moment.landmarks)} landmarks")
    return ax


def astray(ax: Axes, clock: Clock, moment: Moment) -> Axes:
    """Draw how far the position was off until a frame, on axes cleared first."""
    ax.clear()
    off = {
        "filter": clock.off(moment.path),
        "wheels": clock.off(clock.wheels[: moment.frame + 1]),
    }
    height = -LINE
    for name, past in sorted(off.items(), key=lambda item: item[1][-1]):
        colour = MEANING["robot" if name == "filter" else "odometry"]
        ax.plot(past, color=colour, linewidth=1.6)
        height = max(height + LINE, past[-1])  # two labels do not overlap
        label(ax, moment.frame + 6, height, f"{name} {past[-1]:.1f} m", colour)
    last = len(clock.seen.poses)
    ax.set(xlim=(0, 1.25 * last), ylim=(0, MOST), xlabel="frame", ylabel="off by (m)")
    ax.set_xticks(range(0, last, 100))
    return ax
