"""A hall with pictures and furniture on its walls, as a camera on a robot sees it."""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np

from data_synth._checks import array, generator, instance, number, whole
from data_synth.coloured.canvas import texture
from data_synth.coloured.filming import linear
from data_synth.companion.canvas import room, rows_and_columns

__all__ = ["Hall", "RobotCamera", "make_hall"]

_FINE = 48  # texels a metre
_FLOOR = 16


@dataclass(frozen=True, slots=True)
class RobotCamera:
    """A level camera on a robot.

    Parameters
    ----------
    focal
        Focal length, px; of the usual 320 columns it leaves a narrow view of 45°.
    size
        Rows and columns.
    height
        Above the floor, m.
    """

    focal: float = 386.0
    size: tuple[int, int] = (240, 320)
    height: float = 1.35

    def __post_init__(self) -> None:
        number("focal", self.focal, 10.0, 1e5)
        number("height", self.height, 0.1, 3.0)
        object.__setattr__(self, "size", rows_and_columns("size", self.size, 2, 4096))

    @property
    def middle(self) -> tuple[float, float]:
        """Column and row that the axis meets."""
        return (self.size[1] - 1) / 2, (self.size[0] - 1) / 2

    def project(self, ahead: float, left: float, up: float) -> tuple[float, float]:
        """Return column and row of a point: metres ahead of the camera, to its left, above ground.

        Raises
        ------
        ValueError
            If the point is not before the camera.
        """
        ahead = number("ahead", ahead, above=0.0)
        left, up = number("left", left), number("up", up)
        u, v = self.middle
        return u - self.focal * left / ahead, v - self.focal * (up - self.height) / ahead


@dataclass(frozen=True, eq=False, slots=True)
class Hall:
    """Four walls, a floor and a ceiling; the first corner is the origin.

    Parameters
    ----------
    length, width
        Along x and y, m.
    walls
        Light that the walls y = 0, x = length, y = width, x = 0 give back (rows, columns, 3), each
        from its left end as seen from inside.
    floor
        The same of the floor (rows along y, columns along x, 3).
    tall
        Height of the walls, m.
    """

    length: float
    width: float
    walls: tuple[np.ndarray, ...] = field(repr=False)
    floor: np.ndarray = field(repr=False)
    tall: float = 3.0

    def __post_init__(self) -> None:
        for name in ("length", "width", "tall"):
            number(name, getattr(self, name), 0.5, 1000.0)
        if len(instance("walls", self.walls, tuple)) != 4:
            raise ValueError(f"walls must be four, got {len(self.walls)}")
        for wall in self.walls:
            array("walls", wall, (None, None, 3))
        array("floor", self.floor, (None, None, 3))

    def view(self, pose: np.ndarray, camera: RobotCamera) -> np.ndarray:
        """Return the light (rows, columns, 3) that reaches the camera.

        Parameters
        ----------
        pose : (3,)
            x, y (m) and heading (rad) of the robot, inside the hall.
        camera
            That it carries.

        Raises
        ------
        ValueError
            If the robot is not inside.
        """
        instance("camera", camera, RobotCamera)
        x, y, heading = array("pose", pose, (3,))
        if not (0 < x < self.length and 0 < y < self.width):
            raise ValueError(
                f"pose must be inside {self.length:g} x {self.width:g} m, got ({x:g}, {y:g})"
            )
        rows, columns = camera.size
        u, v = camera.middle
        slope = (u - np.arange(columns)) / camera.focal  # to the left per metre ahead
        dx = math.cos(heading) - slope * math.sin(heading)
        dy = math.sin(heading) + slope * math.cos(heading)
        with np.errstate(divide="ignore"):
            reach = np.stack([
                np.where(dy < 0, -y / dy, np.inf),
                np.where(dx > 0, (self.length - x) / dx, np.inf),
                np.where(dy > 0, (self.width - y) / dy, np.inf),
                np.where(dx < 0, -x / dx, np.inf),
            ])  # fmt: skip
        wall = reach.argmin(axis=0)
        ahead = reach[wall, np.arange(columns)]
        px, py = x + ahead * dx, y + ahead * dy
        along = np.choose(wall, [self.length - px, self.width - py, px, py])
        drop = (np.arange(rows) - v) / camera.focal  # downwards per metre ahead
        up = camera.height - drop[:, None] * ahead
        light = np.empty((rows, columns, 3), dtype=np.float32)
        for k, paint in enumerate(self.walls):
            here = wall == k
            if here.any():
                across = np.broadcast_to(_FINE * along[here], (rows, here.sum()))
                down = _FINE * (self.tall - up[:, here])
                light[:, here] = _sample(paint, across, down)
        below = up < 0
        near = np.divide(camera.height, drop, out=np.zeros(rows), where=drop > 0)[:, None]
        ground = _sample(self.floor, _FLOOR * (x + near * dx), _FLOOR * (y + near * dy))
        light[below] = ground[below]
        light[up > self.tall] = 0.75
        return light


def make_hall(
    rng: np.random.Generator, *, length: float = 16.0, width: float = 10.0, clutter: int = 22
) -> Hall:
    """Return a hall.

    Parameters
    ----------
    rng
        Source of what stands at the walls.
    length, width
        m, from 4 to 60.
    clutter
        How many things stand or hang at each wall.
    """
    generator(rng)
    length, width = number("length", length, 4.0, 60.0), number("width", width, 4.0, 60.0)
    clutter = whole("clutter", clutter, 0, 1000)
    walls = tuple(
        room((round(3.0 * _FINE), round(long * _FINE)), rng=rng, clutter=clutter)
        for long in (length, width, length, width)
    )
    size = round(width * _FLOOR), round(length * _FLOOR)
    grain = 1 + 0.10 * texture(6, 3, rng=rng, size=size)
    rows, columns = np.indices(size) // _FLOOR
    tiles = np.where((rows + columns) % 2, 0.42, 0.36)
    floor = linear(np.array([1.0, 0.97, 0.92])) * (tiles * grain)[..., None]
    return Hall(length, width, walls, floor.clip(0.01, 1).astype(np.float32))


def _sample(paint: np.ndarray, across: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Return the paint at columns and rows, between its texels."""
    maps = (np.ascontiguousarray(at, dtype=np.float32) for at in np.broadcast_arrays(across, down))
    return cv2.remap(paint, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
