"""Ten floor plans to drive through: loops, dead ends, corridors that look alike.

Each is made of corridors and rooms that are rectangles, walls between them and doors, papered and
furnished like the textured building. The robot turns round in the rooms at dead ends. Plans and
routes are ours; a route is as long as the paper's, some 80 m.
"""

from dataclasses import dataclass
from itertools import chain, cycle

import numpy as np

from data_synth._checks import generator, instance, whole
from data_synth.stereo import make_scene
from data_synth.textured_building import _WALL, TexturedBuilding, _Builder
from data_synth.textures import paint

LENGTH = 81.0
"""Length of each route, m."""

_RADIUS = 0.8  # of the arcs at the corners of a route, m
_SAVED = (2 - np.pi / 2) * _RADIUS  # by an arc instead of a corner, m
_LEAST = 1.2  # of a route after its last turn, m
_HALF = 1.1  # of the width of a corridor, m
_ROOM, _SIDE = 5.0, 0.9  # edge of a room to turn in; of its door from its middle, m
_THINGS = frozenset(
    ("door", "poster", "notices", "books", "window", "radiator", "writing", "sign", "drawers")
) | {"papers"}  # that hang or stand
_STYLES = "study", "seminar", "brick", "planks", "bare", "blank"  # of walls of rooms
_SIDES = "south", "north", "west", "east"


@dataclass(frozen=True, slots=True)
class _Cell:
    """A corridor or a room: edges, m."""

    west: float
    south: float
    east: float
    north: float
    room: bool = False

    def side(self, name: str) -> tuple[float, tuple[float, float]]:
        """Return where a side lies, and from where to where it reaches."""
        ends = (self.west, self.east) if name in ("south", "north") else (self.south, self.north)
        return getattr(self, name), ends


@dataclass(frozen=True, slots=True)
class _Plan:
    """Cells, the middles of doors, corners of a round that is repeated, and what comes before."""

    cells: tuple[_Cell, ...]
    doors: tuple[tuple[float, float], ...]
    route: tuple[tuple[float, float], ...]
    start: tuple[tuple[float, float], ...] = ()


def make_floor(plan: int, *, alike: bool, rng: np.random.Generator) -> TexturedBuilding:
    """Return a building of one of the plans; pictures, hangings and furniture are drawn at random.

    Parameters
    ----------
    plan
        Number of the plan, 0 to 9.
    alike
        Whether pictures are used again, so that some places look alike; if not, each thing that
        hangs or stands has a picture of its own.
    rng
        Source of pictures and furniture.
    """
    plan = whole("plan", plan, 0, len(PLANS) - 1)
    build = _Furnisher(generator(rng))
    build.alike = instance("alike", alike, bool)
    laid = PLANS[plan]
    styles = {cell: _dressed(cell, build.rng) for cell in laid.cells}
    build.raise_walls(_walls(laid), styles)
    for cell in laid.cells:
        floor = "carpet" if cell.room and build.rng.uniform() < 0.5 else "linoleum"
        build.ground(cell.west, cell.east, cell.south, cell.north, floor)
        if cell.room:
            build.fill(cell, laid.doors)
    scene = make_scene(build.surfaces, build.pictures)
    return TexturedBuilding(scene, np.array(build.kinds), _way(laid), np.array(build.plan))


def _dressed(cell: _Cell, rng: np.random.Generator) -> dict[str, str]:
    """Draw the style of each wall of a cell."""
    return {side: f"{rng.choice(_STYLES)}" if cell.room else "corridor" for side in _SIDES}


def _way(plan: _Plan) -> np.ndarray:
    """Return the corners of the route, which ends where it is long enough."""
    corners = [next(points := chain(plan.start, cycle(plan.route)))]
    left = LENGTH
    for point in points:
        long = float(np.hypot(*np.subtract(point, corners[-1])))
        if left <= long:
            leg = np.subtract(point, corners[-1])
            end = np.add(corners[-1], max(left, _LEAST + _RADIUS) / long * leg)
            return np.array([*corners, end])
        corners.append(point)
        left -= long - _SAVED
    raise AssertionError("a route goes round for ever")


# Walls -------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Wall:
    """A wall along an axis, between two cells or round one of them, with a door or none."""

    upright: bool  # runs from south to north
    at: float
    low: float
    high: float
    below: _Cell | None  # south or west of it
    above: _Cell | None
    door: float | None

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return both ends, m."""
        one, two = (self.low, self.at), (self.high, self.at)
        return (one[::-1], two[::-1]) if self.upright else (one, two)


def _walls(plan: _Plan) -> list[_Wall]:
    """Return all walls of a plan: between neighbours unless both are corridors, and around."""
    found = []
    for upright, (lower, upper) in ((False, ("south", "north")), (True, ("west", "east"))):
        for cell in plan.cells:
            at, (low, high) = cell.side(upper)
            edges = low
            for other in _beside(plan.cells, lower, at, low, high):
                first, last = other.side(lower)[1]
                first, last = max(first, low), min(last, high)
                if first > edges:
                    found.append(_Wall(upright, at, edges, first, cell, None, None))
                if cell.room or other.room:
                    door = _door(plan.doors, upright, at, first, last)
                    found.append(_Wall(upright, at, first, last, cell, other, door))
                edges = last
            if high > edges:
                found.append(_Wall(upright, at, edges, high, cell, None, None))
            at, (low, high) = cell.side(lower)
            edges = low
            for other in _beside(plan.cells, upper, at, low, high):
                first, last = other.side(upper)[1]
                if first > edges:
                    found.append(_Wall(upright, at, edges, first, None, cell, None))
                edges = min(last, high)
            if high > edges:
                found.append(_Wall(upright, at, edges, high, None, cell, None))
    return found


def _beside(cells: tuple[_Cell, ...], side: str, at: float, low: float, high: float) -> list[_Cell]:
    """Return the cells with a side on a stretch of a line, in its order."""
    found = [
        cell
        for cell in cells
        if cell.side(side)[0] == at and cell.side(side)[1][0] < high and cell.side(side)[1][1] > low
    ]
    return sorted(found, key=lambda cell: cell.side(side)[1][0])


def _door(
    doors: tuple[tuple[float, float], ...], upright: bool, at: float, low: float, high: float
) -> float | None:
    """Return where along a wall its door is."""
    for x, y in doors:
        on, along = (x, y) if upright else (y, x)
        if on == at and low < along < high:
            return along
    return None


def _corners(walls: list[_Wall]) -> set[tuple[float, float]]:
    """Return where just two walls meet, at a right angle."""
    meeting: dict[tuple[float, float], list[bool]] = {}
    for wall in walls:
        for end in wall.ends:
            meeting.setdefault(end, []).append(wall.upright)
    return {point for point, ways in meeting.items() if sorted(ways) == [False, True]}


class _Furnisher(_Builder):
    """A builder that papers walls on both sides, and furnishes rooms of any plan."""

    alike = True

    def add(self, corner, right, down, kind, show, *, gain, carrier=-1):
        """Add a surface; where nothing is to look alike, with a picture of its own."""
        if not self.alike and show in _THINGS:
            self.pictures.append(paint(show, rng=self.rng))
            self.of_kind[show] = range(len(self.pictures) - 1, len(self.pictures))
        return super().add(corner, right, down, kind, show, gain=gain, carrier=carrier)

    def raise_walls(self, walls: list[_Wall], styles: dict[_Cell, dict[str, str]]) -> None:
        """Add walls; at corners they reach round."""
        corners, half = _corners(walls), _WALL / 2
        for wall in walls:
            one, two = wall.ends
            low = wall.low - half * (one in corners)
            high = wall.high + half * (two in corners)
            names = ("east", "west") if wall.upright else ("north", "south")
            faces = [
                None if cell is None else styles[cell][side]
                for cell, side in zip((wall.below, wall.above), names, strict=True)
            ]
            # which face is to the left of the way: a corridor's, so that doors open into rooms
            cells = wall.below, wall.above
            first = 0 if wall.above is None or (wall.below and not wall.below.room) else 1
            ahead = (first == 0) == wall.upright
            line = wall.at + (half if first else -half)
            ends = [(line, low), (line, high)] if wall.upright else [(low, line), (high, line)]
            start, end = ends if ahead else ends[::-1]
            left, right = faces[first], faces[1 - first]
            if right is None:
                self.wall(start, end, f"{left}")
                continue
            gap = None
            if wall.door is not None:
                gap = wall.door - low if ahead else high - wall.door
            leaf = gap is not None and not cells[first].room
            self.partition(start, end, gap, f"{left}", right, leaf=leaf)

    def fill(self, room: _Cell, doors: tuple[tuple[float, float], ...]) -> None:
        """Put a table or a shelf before each wall of a room that has no door."""
        for side in _SIDES:
            at, (low, high) = room.side(side)
            upright = side in ("west", "east")
            closed = _door(doors, upright, at, low, high) is None
            long, deep, tall, show, top = (
                (1.5, 0.7, 0.74, "drawers", "papers"),
                (1.0, 0.35, 1.9, "books", "timber"),
            )[self.rng.integers(2)]
            begin = self.rng.uniform(low + 0.5, high - 0.5 - long)
            if not closed:
                continue
            inward = 1 if side in ("south", "west") else -1
            across = sorted((at + 0.08 * inward, at + (0.08 + deep) * inward))
            xs, ys = (begin, begin + long), tuple(across)
            if upright:
                xs, ys = ys, xs
            front = {"west": 2, "south": 1, "east": 0, "north": 3}[side]
            self.box((xs[0], ys[0]), (xs[1], ys[1]), tall, show, front, top)


# Plans -------------------------------------------------------------------------------------------


def _along(west: float, east: float, y: float = 0.0) -> _Cell:
    """Return a corridor along the first axis."""
    return _Cell(west, round(y - _HALF, 6), east, round(y + _HALF, 6))


def _up(x: float, south: float, north: float) -> _Cell:
    """Return a corridor along the second axis."""
    return _Cell(round(x - _HALF, 6), south, round(x + _HALF, 6), north)


def _room(west: float, south: float, east: float, north: float) -> _Cell:
    return _Cell(west, south, east, north, room=True)


@dataclass(frozen=True, slots=True)
class _End:
    """A room at the end of a corridor, its door, and the corners of the way that turns in it."""

    cell: _Cell
    door: tuple[float, float]
    turn: tuple[tuple[float, float], ...]


def _end(x: float, y: float, way: str) -> _End:
    """Return the room that a corridor ends in at a point, which is reached in some direction."""
    ahead = {"east": (1, 0), "west": (-1, 0), "north": (0, 1), "south": (0, -1)}[way]
    aside = abs(ahead[1]), abs(ahead[0])

    def point(far: float, beside: float) -> tuple[float, float]:
        return (
            round(x + far * ahead[0] + beside * aside[0], 6),
            round(y + far * ahead[1] + beside * aside[1], 6),
        )

    corners = [point(far, _SIDE + beside * _ROOM / 2) for far in (0.0, _ROOM) for beside in (-1, 1)]
    low, high = np.min(corners, axis=0).tolist(), np.max(corners, axis=0).tolist()
    near, far = _ROOM / 2 - _SIDE, _ROOM / 2 + _SIDE
    turn = point(far, 0.0), point(far, 2 * _SIDE), point(near, 2 * _SIDE), point(near, 0.0)
    return _End(_room(*low, *high), point(0.0, 0.0), turn)


def _ring() -> _Plan:
    cells = _along(-1.1, 14.1), _along(-1.1, 14.1, 9.0), _up(0.0, 1.1, 7.9), _up(13.0, 1.1, 7.9)
    rooms = _room(1.1, 1.1, 6.5, 7.9), _room(6.5, 1.1, 11.9, 7.9)
    doors = (3.8, 1.1), (6.5, 4.5), (9.2, 7.9)
    around = (13.0, 0.0), (13.0, 9.0), (0.0, 9.0), (0.0, 0.0)
    through = (3.8, 0.0), (3.8, 4.5), (9.2, 4.5), (9.2, 9.0), (0.0, 9.0), (0.0, 0.0)
    return _Plan((*cells, *rooms), doors, (*around, *through), ((1.5, 0.0),))


def _enfilade() -> _Plan:
    rooms = tuple(_room(a, 1.1, a + 4.5, 6.1) for a in (0.0, 4.5, 9.0, 13.5))
    doors = (2.25, 1.1), (4.5, 3.6), (9.0, 3.6), (13.5, 3.6), (15.75, 1.1)
    around = (15.75, 0.0), (15.75, 3.6), (2.25, 3.6), (2.25, 0.0)
    return _Plan((_along(0.0, 18.0), *rooms), doors, around, ((3.5, 0.0),))


def _comb() -> _Plan:
    ends = tuple(_end(x, 1.1, "north") for x in (2.5, 9.0, 15.5))
    visits = [((end.door[0], 0.0), *end.turn, (end.door[0], 0.0)) for end in ends]
    route = (*visits[0], *visits[1], *visits[2], *visits[1])
    cells = _along(0.0, 19.0), *(end.cell for end in ends)
    return _Plan(cells, tuple(end.door for end in ends), route, ((1.0, 0.0),))


def _bent() -> _Plan:
    one, two = _end(0.0, 0.0, "west"), _end(12.0, 11.0, "north")
    cells = _along(0.0, 13.1), _up(12.0, 1.1, 11.0), one.cell, two.cell
    route = (12.0, 0.0), *two.turn, (12.0, 0.0), *one.turn
    return _Plan(cells, (one.door, two.door), route, ((1.0, 0.0),))


def _three_arms() -> _Plan:
    west, east = _end(0.0, 0.0, "west"), _end(16.0, 0.0, "east")
    south = _end(8.0, -9.0, "south")
    cells = _along(0.0, 16.0), _up(8.0, -9.0, -1.1), west.cell, east.cell, south.cell
    middle = (8.0, 0.0)
    route = *east.turn, middle, *south.turn, middle, *west.turn
    return _Plan(cells, (west.door, east.door, south.door), route, ((1.0, 0.0),))


def _cross() -> _Plan:
    west, east = _end(0.0, 0.0, "west"), _end(14.0, 0.0, "east")
    south, north = _end(7.0, -7.0, "south"), _end(7.0, 7.0, "north")
    cells = _along(0.0, 14.0), _up(7.0, -7.0, -1.1), _up(7.0, 1.1, 7.0)
    rooms = west.cell, east.cell, south.cell, north.cell
    middle = (7.0, 0.0)
    route = *east.turn, middle, *north.turn, *south.turn, middle, *west.turn
    doors = west.door, east.door, south.door, north.door
    return _Plan((*cells, *rooms), doors, route, ((1.0, 0.0),))


def _eight() -> _Plan:
    level = tuple(_along(-1.1, 10.1, y) for y in (0.0, 7.0, 14.0))
    steep = tuple(_up(x, y + 1.1, y + 5.9) for x in (0.0, 9.0) for y in (0.0, 7.0))
    rooms = tuple(_room(1.1, y + 1.1, 7.9, y + 5.9) for y in (0.0, 7.0))
    lower = (9.0, 0.0), (9.0, 7.0), (0.0, 7.0)
    upper = (0.0, 14.0), (9.0, 14.0), (9.0, 7.0), (0.0, 7.0), (0.0, 0.0)
    return _Plan((*level, *steep, *rooms), (), (*lower, *upper), ((1.5, 0.0),))


def _horseshoe() -> _Plan:
    cells = _along(-1.1, 13.1), _up(0.0, 1.1, 12.0), _up(12.0, 1.1, 12.0)
    rooms = _room(1.1, 5.0, 6.0, 11.0), _room(6.0, 5.0, 10.9, 11.0)
    doors = (1.1, 8.0), (6.0, 8.0), (10.9, 8.0)
    around = (12.0, 0.0), (12.0, 8.0), (0.0, 8.0), (0.0, 0.0)
    return _Plan((*cells, *rooms), doors, around, ((1.5, 0.0),))


def _long() -> _Plan:
    west, east = _end(0.0, 0.0, "west"), _end(24.0, 0.0, "east")
    cells = _along(0.0, 24.0), west.cell, east.cell
    return _Plan(cells, (west.door, east.door), (*east.turn, *west.turn), ((1.0, 0.0),))


def _zigzag() -> _Plan:
    west, east = _end(0.0, 0.0, "west"), _end(12.0, 12.0, "east")
    level = _along(0.0, 13.1), _along(-1.1, 13.1, 6.0), _along(-1.1, 12.0, 12.0)
    steep = _up(12.0, 1.1, 4.9), _up(0.0, 7.1, 10.9)
    corners = (12.0, 0.0), (12.0, 6.0), (0.0, 6.0), (0.0, 12.0)
    route = *corners, *east.turn, *corners[::-1], *west.turn
    cells = *level, *steep, west.cell, east.cell
    return _Plan(cells, (west.door, east.door), route, ((1.0, 0.0),))


NAMES = (
    "ring",
    "enfilade",
    "comb",
    "bent",
    "three arms",
    "cross",
    "eight",
    "horseshoe",
    "long",
    "zigzag",
)
"""Names of the plans, in their order."""
PLANS = (
    _ring(),
    _enfilade(),
    _comb(),
    _bent(),
    _three_arms(),
    _cross(),
    _eight(),
    _horseshoe(),
    _long(),
    _zigzag(),
)
