"""A ceiling: tiles, plaster and beams, and what is fixed to them, at known places.

The ceiling is one plane, painted on texels of 1 cm. Column j and row i of n texels have their
middle at x = (j - (n - 1)/2)·0.01 m and y = (i - (n - 1)/2)·0.01 m: the world's origin is in the
middle, x runs along the columns and y along the rows. Looked up at with x to the right, y points
down, so the texture is what an eye sees and writing is not mirrored.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import cv2
import numpy as np

from data_synth._checks import array, generator, instance, number
from data_synth.ceiling._fixtures import PAINTERS, Stamp, lay, luminaire, vent

Kind = Literal["varied", "repeated", "plain"]

RESOLUTION = 0.01
"""Side of a texel, m."""
TILE = 0.6
"""Side of a tile, m."""
PERIOD = (2.4, 3.0)
"""After which a ceiling of repeated fixtures is the same again, along x and along y, m."""

_SCALE = 1 / RESOLUTION
_DENSITY = 0.52  # fixtures for a square metre
_STAINS = 0.012
_GRID_TURNS = 0.75  # share of the fixtures that stand along the grid
_LONG = ("pipe", "tray")
_MIDDLE = ("luminaire", "vent", "hatch")  # stand in the middle of tiles
_COARSE = 0.05  # of the plan in which fixtures keep apart, m


@dataclass(frozen=True, slots=True)
class Fixture:
    """Something on the ceiling.

    Parameters
    ----------
    kind
        What it is: "luminaire", "vent", "spot", "detector", "sign", "hatch", "sprinkler",
        "speaker", "pipe", "tray" or "stain".
    x, y
        Its middle, m.
    angle
        From x to its length, rad.
    width, length
        Of the rectangle that it lies in, m.
    """

    kind: str
    x: float
    y: float
    angle: float
    width: float
    length: float

    def __post_init__(self) -> None:
        instance("kind", self.kind, str)
        for name in ("x", "y", "angle"):
            number(name, getattr(self, name), -1e6, 1e6)
        for name in ("width", "length"):
            number(name, getattr(self, name), 0.0, 1e6)


@dataclass(frozen=True, eq=False, slots=True)
class Ceiling:
    """A painted ceiling.

    Parameters
    ----------
    texture : (n, n)
        Grey values of 8 bits, row y, column x, the world's origin in the middle.
    fixtures
        What is on it, where it truly is.
    kind
        "varied", "repeated" or "plain".
    resolution
        Side of a texel, m.
    """

    texture: np.ndarray
    fixtures: tuple[Fixture, ...]
    kind: str
    resolution: float = RESOLUTION

    def __post_init__(self) -> None:
        instance("texture", self.texture, np.ndarray)
        if self.texture.dtype != np.uint8:
            raise TypeError(f"texture must be of 8 bits, got {self.texture.dtype}")
        if self.texture.ndim != 2 or len({*self.texture.shape}) != 1 or len(self.texture) < 2:
            raise ValueError(f"texture must be (n, n), n > 1, got {self.texture.shape}")
        for fixture in instance("fixtures", self.fixtures, tuple):
            instance("fixtures", fixture, Fixture)
        if not isinstance(self.kind, str) or self.kind not in get_args(Kind):
            raise ValueError(
                f"kind must be one of {', '.join(get_args(Kind))}, got {self.kind!r:.60}"
            )
        number("resolution", self.resolution, 1e-4, 1.0)

    @property
    def side(self) -> float:
        """Side of the whole, m."""
        return len(self.texture) * self.resolution

    def texels(self, points: np.ndarray) -> np.ndarray:
        """Return where points (n, 2), m, lie in the texture: column and row."""
        points = array("points", points, (None, 2))
        return points / self.resolution + (len(self.texture) - 1) / 2

    def places(self, texels: np.ndarray) -> np.ndarray:
        """Return where columns and rows (n, 2) of the texture lie in the world, m."""
        texels = array("texels", texels, (None, 2))
        return (texels - (len(self.texture) - 1) / 2) * self.resolution


def make_ceiling(kind: Kind, *, rng: np.random.Generator, side: float = 30.0) -> Ceiling:
    """Return a ceiling; all that it looks like is ours.

    Parameters
    ----------
    kind
        "varied": an office's, every view different; "repeated": one luminaire and one vent over
        and over, after `PERIOD` all is the same but for some exceptions; "plain": paint and
        nothing on it.
    rng
        Source of what is where.
    side
        Of the whole, m.

    Raises
    ------
    ValueError
        If the kind is unknown, or the side is not from 2 m to 40 m.
    """
    if not isinstance(kind, str) or kind not in get_args(Kind):
        raise ValueError(f"kind must be one of {', '.join(get_args(Kind))}, got {kind!r:.60}")
    generator(rng)
    texels = round(number("side", side, 2.0, 40.0) * _SCALE)
    make = {"varied": _varied, "repeated": _repeated, "plain": _plain}[kind]
    ground, fixtures = make(texels, rng)
    np.rint(ground, out=ground)
    np.clip(ground, 0, 255, out=ground)
    return Ceiling(np.ascontiguousarray(ground, dtype=np.uint8), tuple(fixtures), kind)


def _plain(n: int, rng: np.random.Generator) -> tuple[np.ndarray, list[Fixture]]:
    return 184 + 1.5 * _clouds(n, 400.0, rng), []


def _clouds(n: int, cell: float, rng: np.random.Generator) -> np.ndarray:
    """Return smooth noise (n, n) of deviation about 1, and of cells in texels."""
    coarse = int(np.ceil(n / cell)) + 4
    grid = cv2.GaussianBlur(rng.standard_normal((coarse, coarse)).astype(np.float32), (0, 0), 0.7)
    return cv2.resize(grid / 0.4, (n, n), interpolation=cv2.INTER_CUBIC)


def _joints(at: np.ndarray, width: float) -> np.ndarray:
    """Return the shares of texels at places ``at`` that lie in joints at the multiples of 1.

    Both in tiles; the joint's middle is at the multiple.
    """
    step = at[1] - at[0]
    away = np.abs(at - np.rint(at))
    return np.clip((width / 2 - away) / step + 0.5, 0, 1).astype(np.float32)


def _speckle(rows: int, columns: int, rng: np.random.Generator) -> np.ndarray:
    """Return what mineral fibre adds to the grey of a tile: grain and small dark fissures."""
    grain = rng.standard_normal((rows, columns), dtype=np.float32)
    soft = cv2.GaussianBlur(grain, (0, 0), 0.9)
    return 5.0 * soft - 14.0 * np.clip(soft - 0.75, 0, 1)


def _tiled(n: int, shift: np.ndarray, rng: np.random.Generator) -> tuple:
    """Return tiles' greys (n, n) and the joints' shares (n,) along x and y."""
    places = (np.arange(n) - (n - 1) / 2) * RESOLUTION
    across, down = (places - shift[0]) / TILE, (places - shift[1]) / TILE
    first = [np.floor(part).astype(int) - int(np.floor(part[0])) for part in (across, down)]
    greys = rng.normal(186, 4.0, (first[1][-1] + 1, first[0][-1] + 1)).astype(np.float32)
    width = 0.02 / TILE
    return greys[np.ix_(first[1], first[0])], _joints(across, width), _joints(down, width)


def _varied(n: int, rng: np.random.Generator) -> tuple[np.ndarray, list[Fixture]]:
    side = n * RESOLUTION
    shift = rng.uniform(0, TILE, 2)
    ground, across, down = _tiled(n, shift, rng)
    ground += _speckle(n, n, rng)
    lines = 1 - (1 - across) * (1 - down[:, None])
    ground += lines * (108 - ground)
    plan = _Plan(side)
    for _ in range(round(side * side / 75)):
        _plaster(ground, shift, rng)
    fixtures = [_stain(ground, side, rng) for _ in range(round(side * side * _STAINS))]
    for _ in range(round(side / 9)):
        _beam(ground, plan, side, rng)
    names = list(PAINTERS)
    shares = np.array([PAINTERS[name][1] for name in names])
    wanted = rng.choice(len(names), round(side * side * _DENSITY), p=shares / shares.sum())
    for k in sorted(wanted, key=lambda k: names[k] not in _LONG):  # long ones need most room
        stamp = PAINTERS[names[k]][0](rng)
        for _ in range(12):
            fixture = _placed(names[k], stamp, side, shift, rng)
            if max(abs(fixture.x), abs(fixture.y)) < side / 2 and plan.take(fixture):
                _fix(ground, stamp, fixture)
                fixtures.append(fixture)
                break
    ground += 5.0 * _clouds(n, 350.0, rng)
    return ground, fixtures


def _placed(
    kind: str, stamp: Stamp, side: float, shift: np.ndarray, rng: np.random.Generator
) -> Fixture:
    x, y = rng.uniform(-side / 2, side / 2, 2)
    if rng.random() < _GRID_TURNS:
        angle = rng.integers(4) * np.pi / 2
        if kind in _MIDDLE:
            length, width = stamp.length, stamp.width
            if round(angle / (np.pi / 2)) % 2:
                length, width = width, length
            x = _snapped(x, length, shift[0])
            y = _snapped(y, width, shift[1])
        else:
            x, y = (_snapped(at, TILE, start) for at, start in zip((x, y), shift, strict=True))
            x, y = np.array([x, y]) + rng.choice([-0.15, 0.0, 0.15], 2)
    else:
        angle = rng.uniform(-np.pi, np.pi)
    return Fixture(kind, float(x), float(y), float(angle), stamp.width, stamp.length)


def _snapped(at: float, size: float, shift: float) -> float:
    """Return the nearest place at which something of a size fills whole tiles, or half ones."""
    odd = round(max(size, 0.3) / TILE + 0.01) % 2
    return shift + TILE * (np.rint((at - shift) / TILE - odd / 2) + odd / 2)


def _fix(ground: np.ndarray, stamp: Stamp, fixture: Fixture) -> None:
    middle = (len(ground) - 1) / 2
    at = (fixture.x * _SCALE + middle, fixture.y * _SCALE + middle)
    lay(ground, stamp, at, fixture.angle, _SCALE)


class _Plan:
    """Plan of what is painted already."""

    def __init__(self, side: float) -> None:
        self.side = side
        self.taken = np.zeros((round(side / _COARSE),) * 2, dtype=np.uint8)

    def take(self, fixture: Fixture, gap: float = 0.12, *, anyway: bool = False) -> bool:
        """Take the room of a fixture if it is free, or anyway; tell whether it was taken."""
        half = np.array([fixture.length, fixture.width]) / 2 + gap
        corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        cos, sin = np.cos(fixture.angle), np.sin(fixture.angle)
        corners = corners @ np.array([[cos, sin], [-sin, cos]]) + [fixture.x, fixture.y]
        pixels = np.rint((corners + self.side / 2) / _COARSE - 0.5).astype(np.int32)
        low, high = pixels.min(axis=0), pixels.max(axis=0) + 1
        left, top = low.clip(0, len(self.taken))
        right, bottom = high.clip((left, top), len(self.taken))
        room = np.zeros((bottom - top, right - left), dtype=np.uint8)
        if not room.size:
            return False
        cv2.fillConvexPoly(room, pixels - [left, top], 1)
        part = self.taken[top:bottom, left:right]
        if not anyway and (part & room).any():
            return False
        part |= room
        return True


def _plaster(ground: np.ndarray, shift: np.ndarray, rng: np.random.Generator) -> None:
    """Replace some tiles by smooth plaster with a trim."""
    n = len(ground)
    tiles = rng.integers(3, 8, 2)
    first = np.floor((rng.uniform(-0.5, 0.5, 2) * n * RESOLUTION - shift) / TILE - tiles / 2)
    low = np.rint((shift + first * TILE) * _SCALE + n / 2).astype(int)  # at joints
    left, top = low.clip(0, n)
    right, bottom = (low + round(TILE * _SCALE) * tiles).clip((left, top), n)
    if right - left < 20 or bottom - top < 20:
        return
    grey = rng.uniform(188, 206)
    grain = rng.standard_normal((bottom - top, right - left), dtype=np.float32)
    ground[top:bottom, left:right] = 128
    inner = ground[top + 4 : bottom - 4, left + 4 : right - 4]
    inner[:] = grey + 4 * cv2.GaussianBlur(grain, (0, 0), 2.0)[4:-4, 4:-4]


def _stain(ground: np.ndarray, side: float, rng: np.random.Generator) -> Fixture:
    """Darken an irregular patch with a darker rim, as water leaves it."""
    across = rng.uniform(0.35, 1.1)
    x, y = rng.uniform(-side / 2, side / 2, 2)
    n, half = len(ground), int(np.ceil(across * 0.75 * _SCALE))
    column, row = (round((at + side / 2) * _SCALE - 0.5) for at in (x, y))
    left, right = max(column - half, 0), min(column + half + 1, n)
    top, bottom = max(row - half, 0), min(row + half + 1, n)
    rows, columns = np.mgrid[top:bottom, left:right]
    turn = np.arctan2(rows - row, columns - column)
    edge = np.full(turn.shape, 0.5 * across * _SCALE)
    for k in range(2, 6):
        edge *= 1 + rng.uniform(0.05, 0.3) / k * np.sin(k * turn + rng.uniform(0, 2 * np.pi))
    inside = (edge - np.hypot(rows - row, columns - column)) / _SCALE  # m from the rim
    deep = rng.uniform(14, 34)
    wet = np.clip(inside / 0.02, 0, 1) * (0.45 + 0.55 * np.exp(-np.abs(inside) / 0.035))
    ground[top:bottom, left:right] -= (deep * wet).astype(np.float32)
    return Fixture("stain", float(x), float(y), 0.0, across, across)


def _beam(ground: np.ndarray, plan: _Plan, side: float, rng: np.random.Generator) -> None:
    """Lay a beam across the whole ceiling."""
    width, at = rng.uniform(0.2, 0.4), rng.uniform(-side / 2, side / 2)
    upright = rng.random() < 0.5
    n = len(ground)
    places = (np.arange(n) - (n - 1) / 2) * RESOLUTION - at
    cover = np.clip((width / 2 - np.abs(places)) * _SCALE + 0.5, 0, 1).astype(np.float32)
    grey = rng.uniform(140, 170) - 40 * np.clip(1 - (width / 2 - np.abs(places)) / 0.04, 0, 1)
    grey += 12 * np.clip(places / width, -1, 1)
    some = np.flatnonzero(cover)
    some = slice(some[0], some[-1] + 1)
    part = ground[:, some] if upright else ground[some].T
    part += cover[some] * (grey.astype(np.float32)[some] - part)
    lie = (at, 0.0, np.pi / 2) if upright else (0.0, at, 0.0)
    plan.take(Fixture("beam", *lie, width, side), gap=0.05, anyway=True)


def _repeated(n: int, rng: np.random.Generator) -> tuple[np.ndarray, list[Fixture]]:
    side = n * RESOLUTION
    across, down = (round(part * _SCALE) for part in PERIOD)
    cell = np.full((down, across), 186, dtype=np.float32)
    tile = _speckle(60, 60, rng)
    cell += np.tile(tile, (down // 60, across // 60))
    width = 0.02 / TILE
    lines = [_joints((np.arange(size) + 0.5) * RESOLUTION / TILE, width) for size in (across, down)]
    cell += (1 - (1 - lines[0]) * (1 - lines[1][:, None])) * (108 - cell)
    lamp, outlet = luminaire(rng), vent(rng)
    while (lamp.length, lamp.width) != (1.2, 0.6):
        lamp = luminaire(rng)
    while outlet.length != TILE:
        outlet = vent(rng)
    start = -side / 2
    inside = [("luminaire", lamp, (0.6, 0.9)), ("vent", outlet, (1.5, 2.1))]
    for _, stamp, at in inside:
        lay(cell, stamp, (at[0] * _SCALE - 0.5, at[1] * _SCALE - 0.5), 0.0, _SCALE)
    ground = np.tile(cell, (n // down + 1, n // across + 1))[:n, :n].copy()
    fixtures = [
        Fixture(
            kind,
            start + at[0] + i * PERIOD[0],
            start + at[1] + j * PERIOD[1],
            0.0,
            stamp.width,
            stamp.length,
        )
        for j in range(n // down + 1)
        for i in range(n // across + 1)
        for kind, stamp, at in inside
    ]
    fixtures = [f for f in fixtures if max(f.x, f.y) < side / 2]
    whole = (n // across, n // down)
    cells = rng.permutation(whole[0] * whole[1])[: round(side * side / 180)]
    for place in cells:  # the exceptions
        kind = ("detector", "sign", "speaker")[rng.integers(3)]
        stamp = PAINTERS[kind][0](rng)
        x = start + place % whole[0] * PERIOD[0] + 0.9
        y = start + place // whole[0] * PERIOD[1] + 1.5
        fixture = Fixture(kind, float(x), float(y), 0.0, stamp.width, stamp.length)
        _fix(ground, stamp, fixture)
        fixtures.append(fixture)
    return ground, fixtures
