"""A building floor with a loop corridor, rooms, niches, pilasters and columns, and its drive.

The floor stands in for the ``usc-sal200`` data set of the paper, which is not to be had: 300 m² of
free floor and a loop of about 90 m, as the paper says; the plan itself is ours. Faces are directed
as in :mod:`data_synth.office`: the free space lies to the left.
"""

from dataclasses import dataclass
from numbers import Real

import numpy as np

from data_synth._checks import array, generator, number

_LONG, _SHORT = 30.0, 15.0  # sides of the rectangle along the middle of the corridor, m
_WIDTH = 2.0  # of the corridor, m
_WALL = 0.4  # thickness of the walls, so depth of the doorways, m
_DOOR, _ROOM, _DEPTH = 1.0, 3.6, 4.0  # width of doors, width and depth of rooms, m
_NICHE, _RECESS = 1.2, 0.5  # width and depth of niches, m
_PILASTER, _JUT = 0.6, 0.35  # width and depth of pilasters, m
_BETWEEN = 0.5  # at least, from anything to the end of its stretch of wall, m
_COLUMN_GAP = 0.3  # from the wall to the middle of a column, m
_COLUMN_SIDES = 16
_MOST_STEPS = 10_000_000
_START = 6.0  # of the drive, from the corner of the loop, m


@dataclass(frozen=True, eq=False, slots=True)
class Building:
    """A floor plan, its landmarks, and a loop through it.

    The drive starts at the origin of the world and looks along its first axis.

    Parameters
    ----------
    faces : (faces, 2, 2)
        Ends of every face, m.
    landmarks : (n, 2)
        True positions of all corners and columns, m.
    kinds : (n,)
        ``"concave"`` (a recess, seen from the floor), ``"convex"`` (it juts out) or ``"pole"``.
    loop : (4, 2)
        Corners of the loop, in the order in which it is driven, m.
    pole_radius
        Of the columns, m.
    area
        Of the free floor, m².
    """

    faces: np.ndarray
    landmarks: np.ndarray
    kinds: np.ndarray
    loop: np.ndarray
    pole_radius: float
    area: float


def make_building(*, rng: np.random.Generator, pole_radius: float = 0.15) -> Building:
    """Return a building whose rooms, doors, niches, pilasters and columns stand at random places.

    Parameters
    ----------
    rng
        Source of randomness.
    pole_radius
        Radius of the columns, m, at most 1.
    """
    generator(rng)
    number("pole_radius", pole_radius, high=1.0, above=0.0)
    half = _WIDTH / 2
    low = np.array([-_START - half, -half])
    high = np.array([_LONG - _START + half, _SHORT + half])
    outer = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    low, high = low + _WIDTH, high - _WIDTH
    core = np.array([low, [low[0], high[1]], high, [high[0], low[1]]])  # clockwise
    outline, block, columns = [], [], []
    for start, end in zip(outer, np.roll(outer, -1, axis=0), strict=True):
        slots = _slots(start, end, 6 if end[1] == start[1] else 3)
        shapes = [(_pilaster, _room)[k % 2](slot, rng) for k, slot in enumerate(slots)]
        outline += [start, *_along(start, end, np.concatenate(shapes))]
    for start, end in zip(core, np.roll(core, -1, axis=0), strict=True):
        slots = _slots(start, end, 7 if end[1] == start[1] else 3)
        niches = np.concatenate([_box(slot, _NICHE, _RECESS, rng) for slot in slots[1::2]])
        places = [[rng.uniform(*slot), -_COLUMN_GAP] for slot in slots[::2]]
        block += [start, *_along(start, end, niches)]
        columns += list(_along(start, end, np.array(places)))
    rings = [np.array(outline), np.array(block)]
    turn = 2 * np.pi * np.arange(_COLUMN_SIDES)[::-1] / _COLUMN_SIDES  # clockwise
    rim = pole_radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    circles = [column + rim for column in columns]
    corners = [_corner_kinds(ring) for ring in rings]
    loop = np.array([[-_START, 0], [_LONG - _START, 0], [_LONG - _START, _SHORT]])
    return Building(
        np.concatenate([_faces(ring) for ring in rings + circles]),
        np.concatenate([*rings, columns]),
        np.concatenate([*corners, np.full(len(columns), "pole")]),
        np.vstack([loop, [[-_START, _SHORT]]]),
        pole_radius,
        float(sum(_area(ring) for ring in rings + circles)),
    )


def drive(
    building: Building, *, step: float = 0.25, beyond: float = 8.0, radius: float = 1.0
) -> np.ndarray:
    """Return poses (x, y, heading) once round the loop and on, equally spaced along the way.

    The robot keeps to the middle of the corridor and takes the corners on arcs.

    Parameters
    ----------
    building
        Where to drive.
    step
        Distance between poses along the way, at most; a whole number of steps makes one loop, m.
    beyond
        How far it drives past its start at the end of the loop, m; at most the first leg.
    radius
        Of the arcs, m.

    Raises
    ------
    ValueError
        If ``beyond`` is negative or longer than the first leg, or the steps or the radius are not
        as they should be.
    """
    number("step", step, above=0.0)
    first = first_leg(building, radius=radius)
    if isinstance(beyond, bool) or not isinstance(beyond, Real):
        raise TypeError(f"beyond must be a number, got {beyond!r}")
    if not 0 <= beyond <= first:
        raise ValueError(f"beyond must lie in the first leg, 0 to {first:g} m, got {beyond}")
    sides = np.linalg.norm(np.roll(building.loop, -1, axis=0) - building.loop, axis=1) - 2 * radius
    before = np.hypot(*building.loop[0]) - radius  # of the first leg, behind the start
    quarter = np.pi / 2 * radius
    legs = [first, *sides[1:], before, beyond]
    lengths = np.array([legs[0], quarter, legs[1], quarter, legs[2], quarter, legs[3], quarter])
    lengths = np.r_[lengths, legs[4:]]
    bends = np.array([0, 1, 0, 1, 0, 1, 0, 1, 0, 0]) / radius
    ends = np.cumsum(lengths)
    once = ends[8]
    if not once / step <= _MOST_STEPS:
        raise ValueError(f"step must make at most {_MOST_STEPS} of {once:g} m, got {step:g} m")
    steps = int(np.ceil(once / step))
    grid = np.arange(0, steps + int(beyond * steps / once) + 1) * once / steps
    cuts = np.union1d(grid, ends[ends < grid[-1]])
    pace = np.diff(cuts)
    bend = bends[np.searchsorted(ends, (cuts[:-1] + cuts[1:]) / 2)]
    heading = np.r_[0.0, np.cumsum(bend * pace)]
    chord = pace * np.sinc(bend * pace / (2 * np.pi))
    middle = heading[:-1] + bend * pace / 2
    x = np.r_[0.0, np.cumsum(chord * np.cos(middle))]
    y = np.r_[0.0, np.cumsum(chord * np.sin(middle))]
    poses = np.stack([x, y, (heading + np.pi) % (2 * np.pi) - np.pi], axis=-1)
    return poses[np.isin(cuts, grid)]


def first_leg(building: Building, *, radius: float = 1.0) -> float:
    """Return how far it is from the start to where the first arc begins, m."""
    loop = array("building (its loop)", getattr(building, "loop", building), (4, 2))
    sides = np.hypot(*(np.roll(loop, -1, axis=0) - loop).T)
    number("radius", radius, above=0.0, high=min(sides.min() / 2, float(np.hypot(*loop[0]))))
    long = np.hypot(*(building.loop[1] - building.loop[0])) - 2 * radius
    return float(long - (np.hypot(*building.loop[0]) - radius))


def _slots(start: np.ndarray, end: np.ndarray, count: int) -> np.ndarray:
    """Equal stretches of a wall with room between them: where each begins and ends along it, m."""
    bounds = np.linspace(0.0, np.abs(end - start).sum(), count + 1)
    return np.stack([bounds[:-1] + _BETWEEN, bounds[1:] - _BETWEEN], axis=-1)


def _box(slot: np.ndarray, width: float, depth: float, rng: np.random.Generator) -> np.ndarray:
    """A niche, or with negative depth a pilaster: distances along the wall and depths behind it."""
    left = rng.uniform(slot[0], slot[1] - width)
    return np.array([[left, 0], [left, depth], [left + width, depth], [left + width, 0]])


def _pilaster(slot: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return _box(slot, _PILASTER, -_JUT, rng)


def _room(slot: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    left = rng.uniform(slot[0], slot[1] - _ROOM)
    door = rng.uniform(left + 0.4, left + _ROOM - 0.4 - _DOOR)
    right, back = left + _ROOM, _WALL + _DEPTH
    return np.array(
        [
            *([door, 0.0], [door, _WALL], [left, _WALL], [left, back]),
            *([right, back], [right, _WALL], [door + _DOOR, _WALL], [door + _DOOR, 0.0]),
        ]
    )


def _along(start: np.ndarray, end: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Points given by their distance along a wall and their depth behind it, in the plan."""
    way = (end - start) / np.hypot(*(end - start))
    return start + places[:, :1] * way + places[:, 1:] * np.array([way[1], -way[0]])


def _faces(ring: np.ndarray) -> np.ndarray:
    return np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)


def _area(ring: np.ndarray) -> float:
    """Area to the left of a ring: negative for one that is walked clockwise."""
    x, y = ring.T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2)


def _corner_kinds(ring: np.ndarray) -> np.ndarray:
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    left = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] > 0
    return np.where(left, "concave", "convex")
