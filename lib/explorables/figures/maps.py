"""Drawing maps, points, segments and axes in metres, and pictures with boxes, for every chapter."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from explorables.figures.style import MEANING


def lines(ax: Axes, ends: np.ndarray, colour: str, width: float = 2.0, **kwargs: object) -> None:
    """Draw segments given by their ends (segments, 2, 2)."""
    ax.add_collection(LineCollection(ends, colors=colour, linewidths=width, **kwargs))


def dots(
    ax: Axes,
    points: np.ndarray,
    colour: str = MEANING["readings"],
    size: float = 1.3,
    **kwargs: object,
) -> None:
    """Draw many points as one path: small as SVG, and the same in every renderer."""
    pen = np.full((len(points), 3, 2), np.nan)
    pen[:, 0] = points
    pen[:, 1] = points + np.array([1e-3, 0.0])
    (drawn,) = ax.plot(*pen.reshape(-1, 2).T, color=colour, linewidth=size, **kwargs)
    drawn.set_solid_capstyle("round")
    drawn.get_path().should_simplify = False


def plan(ax: Axes, points: np.ndarray, *, margin: float = 0.4) -> Axes:
    """Make axes a map in metres that holds all points, without distortion."""
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_aspect("equal", adjustable="box")
    ax.set_xlabel("x (m)")
    ax.set_ylabel("y (m)")
    return ax


def picture(ax: Axes, image: np.ndarray) -> None:
    """Show a picture on axes without scales."""
    most = 255 if image.dtype == np.uint8 else 1.0
    ax.imshow(image, cmap="gray", vmin=0, vmax=most, interpolation="nearest")
    ax.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5))
    ax.set_xticks([])
    ax.set_yticks([])
    ax.grid(visible=False)


def square(ax: Axes, box: np.ndarray, colour: str, **kwargs: object) -> None:
    """Draw the outline of a box: left, top, width and height."""
    left, top, wide, high = box
    u = left + wide * np.array([0, 1, 1, 0, 0])
    v = top + high * np.array([0, 0, 1, 1, 0])
    ax.plot(u, v, color=colour, **kwargs)
