"""A floor of a building to look at: a corridor with rooms on both sides, furnished and papered.

It stands in for building 79 of the University of Freiburg, of which no images are to be had. The
corridor with rooms, the 507 pairs and the 80 m are those of the paper; the plan is ours. Doors,
shelves, posters and notice boards are made of few pictures each, so that some places look alike;
some walls are bare.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from data_synth._checks import generator, instance, number, whole
from data_synth.stereo import Scene, Surface, make_scene
from data_synth.textures import paint
from data_synth.wheels import Slip

SLIP = Slip(along=0.03, across=0.015, bend=np.deg2rad(1.0), turn=np.deg2rad(2.0))
"""Slip of the wheels: after 80 m the robot is some metres from where it believes to be."""

_LONG, _WIDE, _DEEP = 20.1, 2.2, 5.0  # length and width of the corridor, depth of the rooms, m
_ROOMS = 3  # on each side
_WALL, _HIGH = 0.12, 2.7  # thickness and height of the walls, m
_DOOR, _LINTEL = 1.0, 2.05  # width and height of the doorways, m
_OUT = 0.005  # what hangs on a wall is that far in front of it, m
_CLEAR = 0.15  # of what hangs from the ends of its wall, m
_ACROSS = 2.5  # where the rooms are crossed, from the corridor, m
_LEAF = 0.95  # width of a door, m
_FRAME = 0.08  # of a doorway, m
_SHUT = "above", 0  # the room that nobody enters
_FINE = 0.005  # steps along which the drive is laid out, m
_ARM = 1.2  # a turn by one radian takes as many poses as that way straight on, m

_COUNTS = {
    "plaster": 1,
    "brick": 1,
    "planks": 1,
    "linoleum": 1,
    "carpet": 1,
    "panels": 1,
    "timber": 1,
    "door": 1,
    "poster": 7,
    "notices": 3,
    "books": 3,
    "window": 2,
    "radiator": 1,
    "writing": 2,
    "sign": 8,
    "drawers": 2,
    "papers": 2,
    "lamp": 1,
}
"""Number of pictures of a kind; what is drawn more often looks alike."""

_TILE = {  # width and height of one copy of what repeats, m
    "plaster": (2.0, 2.0),
    "brick": (2.0, 1.2),
    "planks": (1.0, 2.7),
    "timber": (0.5, 1.0),
    "linoleum": (2.0, 2.0),
    "carpet": (1.0, 1.0),
    "panels": (1.2, 1.2),
}
_HUNG = {  # width, height and lower edge of what hangs on walls, m
    "door": (0.95, 2.05, 0.0),
    "poster": (0.6, 0.8, 1.05),
    "notices": (1.2, 0.9, 0.95),
    "books": (1.0, 2.0, 0.0),
    "window": (1.5, 1.3, 0.95),
    "writing": (1.8, 1.0, 0.9),
    "sign": (0.16, 0.16, 1.45),
}
_STYLES = {  # what a wall is covered with, what hangs on it, and how far apart, m
    "corridor": ("plaster", ("poster", "sign", "notices", "door", "poster"), (0.5, 1.6)),
    "bare": ("plaster", ("sign",), (2.5, 4.0)),
    "study": ("plaster", ("books", "poster", "books", "sign", "notices"), (0.3, 1.0)),
    "seminar": ("plaster", ("writing", "poster", "sign", "notices"), (0.5, 1.5)),
    "brick": ("brick", ("poster", "sign"), (1.2, 2.5)),
    "planks": ("planks", ("poster", "notices", "sign"), (0.8, 2.0)),
    "outside": ("plaster", ("window",), (0.5, 0.8)),
    "blank": ("plaster", (), (1.0, 1.0)),
}
_ROOM_STYLES = {  # styles of the walls of a room: corridor, west, east, outside; and its floor
    "below": [
        ("study", "study", "bare", "outside", "carpet"),
        ("bare", "brick", "seminar", "outside", "linoleum"),
        ("study", "blank", "study", "outside", "carpet"),
    ],
    "above": [
        ("blank", "blank", "blank", "outside", "carpet"),
        ("planks", "seminar", "study", "outside", "carpet"),
        ("bare", "study", "brick", "outside", "linoleum"),
    ],
}


@dataclass(frozen=True, eq=False, slots=True)
class TexturedBuilding:
    """A floor with its surfaces, and the way of a drive through it.

    Parameters
    ----------
    scene
        All that can be seen.
    kinds : (surfaces,)
        What each surface shows: ``"wall"``, ``"floor"``, ``"ceiling"``, ``"jamb"``, or the kind of
        picture that hangs or stands there.
    waypoints : (points, 2)
        Corners of the drive, m.
    plan : (walls, 2, 2)
        Ends of the walls, seen from above, m.
    """

    scene: Scene
    kinds: np.ndarray
    waypoints: np.ndarray
    plan: np.ndarray


def make_textured_building(*, rng: np.random.Generator) -> TexturedBuilding:
    """Return a building whose pictures, hangings and furniture are drawn at random.

    The corridor runs from the origin along the first axis, with three rooms on either side. Doors
    join the rooms below it with each other, and two of those above.
    """
    build = _Builder(generator(rng))
    bounds = np.linspace(0.0, _LONG, _ROOMS + 1)
    doors = _doors(bounds)
    for side, sign, base in (("below", -1, 0.0), ("above", 1, _WIDE)):
        near, back, middle = base + sign * _WALL, base + sign * _DEEP, base + sign * _ACROSS
        low, high = min(near, back), max(near, back)
        for k, (left, right) in enumerate(pairwise(bounds)):
            front, west, east, far, floor = _ROOM_STYLES[side][k]
            closed = (side, k) == _SHUT
            ends = [(left, base), (right, base)][::-sign]  # the corridor to the left
            gap = None if closed else abs(doors[side][k] - ends[0][0])
            build.partition(*ends, gap, "corridor", front, leaf=True)
            build.wall(*[(left, back), (right, back)][::-sign], far)
            if k == 0:
                build.wall((left, high), (left, low), west)
            if k == _ROOMS - 1:
                build.wall((right, low), (right, high), east)
            else:
                gap = None if closed else abs(middle - low)
                edge, beyond = right - _WALL / 2, _ROOM_STYLES[side][k + 1][1]
                build.partition((edge, low), (edge, high), gap, east, beyond)
            build.ground(left, right, min(base, back), max(base, back), floor)
            build.furnish(left, right, near, back, doors[side][k])
    build.wall((0.0, _WIDE), (0.0, 0.0), "planks")
    build.wall((_LONG, 0.0), (_LONG, _WIDE), "bare")
    build.ground(0.0, _LONG, 0.0, _WIDE, "linoleum")
    for x, y in ((6.7, _WIDE - 0.2), (13.4, 0.2)):  # one on either side, the same
        build.box((x - 0.5, y - 0.2), (x + 0.5, y + 0.2), 1.2, "drawers", 0, "timber")
    scene = make_scene(build.surfaces, build.pictures)
    return TexturedBuilding(scene, np.array(build.kinds), _way(doors), np.array(build.plan))


def drive(
    building: TexturedBuilding,
    *,
    rng: np.random.Generator,
    poses: int = 507,
    radius: float = 0.8,
    wander: float = 0.05,
) -> np.ndarray:
    """Return poses (x, y, heading) along the way, closer to each other where the robot turns.

    Two of the rooms are passed twice and parts of the corridor three times, always in the same
    direction; the robot is steered by hand and never takes quite the same line.

    Parameters
    ----------
    building
        Where to drive.
    rng
        Source of the wandering.
    poses
        How many.
    radius
        Of the arcs at the waypoints, at most, m.
    wander
        Deviation of both coordinates of the waypoints, m; three deviations are the most.
    """
    instance("building", building, TexturedBuilding)
    generator(rng)
    whole("poses", poses, 2, 10**6)
    number("radius", radius, 0.1, 1.0)
    number("wander", wander, 0.0, 0.1)
    points = building.waypoints
    points = points + wander * rng.standard_normal(points.shape).clip(-3, 3)
    legs = np.diff(points, axis=0)
    ways = legs / np.hypot(*legs.T)[:, None]
    headings = np.unwrap(np.arctan2(ways[:, 1], ways[:, 0]))
    turns = np.diff(headings)
    cut = np.r_[0.0, radius * np.tan(abs(turns) / 2), 0.0]  # of a leg, before and after an arc
    pieces = []
    for k, way in enumerate(ways):
        start, end = points[k] + cut[k] * way, points[k + 1] - cut[k + 1] * way
        share = np.linspace(0.0, 1.0, 1 + int(np.hypot(*(end - start)) / _FINE))
        straight = start + share[:, None] * (end - start)
        pieces.append(np.column_stack([straight, np.full(len(share), headings[k])]))
        if k < len(turns):
            bend = np.linspace(0.0, turns[k], 1 + int(abs(turns[k]) * radius / _FINE))[1:]
            side = np.sign(turns[k]) * radius
            centre = end + side * np.array([-way[1], way[0]])
            heading = headings[k] + bend
            arc = centre + side * np.stack([np.sin(heading), -np.cos(heading)], axis=-1)
            pieces.append(np.column_stack([arc, heading]))
    line = np.concatenate(pieces)
    pace = np.hypot(np.hypot(*np.diff(line[:, :2], axis=0).T), _ARM * np.diff(line[:, 2]))
    gone = np.r_[0.0, np.cumsum(pace)]
    at = np.linspace(0.0, gone[-1], poses)
    x, y, heading = (np.interp(at, gone, column) for column in line.T)
    return np.stack([x, y, (heading + np.pi) % (2 * np.pi) - np.pi], axis=-1)


def _doors(bounds: np.ndarray) -> dict[str, np.ndarray]:
    """Places of the doors' middles along the corridor, m."""
    return {
        "below": bounds[:-1] + np.array([3.0, 3.6, 3.4]),
        "above": bounds[1:] - np.array([2.6, 3.9, 3.3]),
    }


def _way(doors: dict[str, np.ndarray]) -> np.ndarray:
    """Corners of the drive: two loops that share a part of the corridor, and the first again."""
    below, above = doors["below"], doors["above"]
    middle, under, over = _WIDE / 2, -_ACROSS, _WIDE + _ACROSS
    first = [(below[1], middle), (below[1], under), (below[0], under), (below[0], middle)]
    second = [(above[2], middle), (above[2], over), (above[1], over), (above[1], middle)]
    again = [(below[2], middle), (below[2], under), (below[0], under), (below[0], middle)]
    return np.array([(1.0, middle), *first, *second, *again, (below[0] + 5.0, middle)])


class _Builder:
    """Surfaces, added one after the other."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.pictures: list[np.ndarray] = []
        self.of_kind: dict[str, range] = {}
        for kind, count in _COUNTS.items():
            first = len(self.pictures)
            self.pictures += [paint(kind, rng=rng) for _ in range(count)]
            self.of_kind[kind] = range(first, first + count)
        self.surfaces: list[Surface] = []
        self.kinds: list[str] = []
        self.plan: list[np.ndarray] = []

    def add(
        self,
        corner: np.ndarray,
        right: np.ndarray,
        down: np.ndarray,
        kind: str,
        show: str,
        *,
        gain: float,
        carrier: int = -1,
    ) -> int:
        """Add a surface that shows a picture of a kind, and return its index."""
        tiles = (1.0, 1.0)
        if show in _TILE:
            wide, high = _TILE[show]
            tiles = float(np.linalg.norm(right)) / wide, float(np.linalg.norm(down)) / high
        picture = int(self.rng.choice(self.of_kind[show]))
        self.surfaces.append(Surface(corner, right, down, picture, tiles, gain, carrier))
        self.kinds.append(kind)
        return len(self.surfaces) - 1

    def face(
        self,
        start: np.ndarray,
        end: np.ndarray,
        low: float,
        high: float,
        kind: str,
        show: str,
        **words: float,
    ) -> int:
        """Add an upright surface with the free space to the left of the way from start to end."""
        corner, right = np.array([*end, high]), np.array([*(np.subtract(start, end)), 0.0])
        return self.add(corner, right, np.array([0.0, 0.0, low - high]), kind, show, **words)

    def wall(
        self,
        start: tuple[float, float],
        end: tuple[float, float],
        style: str,
        gap: float | None = None,
    ) -> None:
        """Add a wall, free space to the left, with a doorway some way from its start, or none."""
        start, end = np.array(start), np.array(end)
        long = np.hypot(*(end - start))
        way = (end - start) / long
        out = _OUT * np.array([-way[1], way[0]])
        show = _STYLES[style][0]
        gain = self.rng.uniform(0.85, 1.05)
        cuts = [(0.0, long)]
        if gap is not None:
            before, after = gap - _DOOR / 2, gap + _DOOR / 2
            cuts = [(0.0, before), (after, long)]
            ends = start + before * way, start + after * way
            above = self.face(*ends, _LINTEL, _HIGH, "wall", show, gain=gain)
            for a, b, low, high in (
                (before - _FRAME, before, 0.0, _LINTEL + _FRAME),
                (before, after, _LINTEL, _LINTEL + _FRAME),
                (after, after + _FRAME, 0.0, _LINTEL + _FRAME),
            ):
                ends = start + a * way + out, start + b * way + out
                self.face(*ends, low, high, "jamb", "timber", gain=gain, carrier=above)
        for a, b in cuts:
            ends = start + a * way, start + b * way
            carrier = self.face(*ends, 0.0, _HIGH, "wall", show, gain=gain)
            self.plan.append(np.array(ends))
            self.hang(start + out, way, a + _CLEAR, b - _CLEAR, style, gain, carrier)

    def hang(
        self,
        start: np.ndarray,
        way: np.ndarray,
        at: float,
        end: float,
        style: str,
        gain: float,
        carrier: int,
    ) -> None:
        """Hang pictures of a style along a stretch of wall."""
        _, kinds, apart = _STYLES[style]
        at += self.rng.uniform(0.0, apart[0])
        while kinds:
            kind = str(self.rng.choice(kinds))
            wide, high, low = _HUNG[kind]
            if at + wide > end:
                return
            where = start + at * way, start + (at + wide) * way
            rise = 0.0 if low == 0 else self.rng.uniform(-0.1, 0.1)
            self.face(*where, low + rise, low + rise + high, kind, kind, gain=gain, carrier=carrier)
            if kind == "window":
                low, high = 0.15, 0.75
                self.face(*where, low, high, "radiator", "radiator", gain=gain, carrier=carrier)
            at += wide + self.rng.uniform(*apart)

    def partition(
        self,
        start: tuple[float, float],
        end: tuple[float, float],
        gap: float | None,
        left: str,
        right: str,
        *,
        leaf: bool = False,
    ) -> None:
        """Add a wall with two faces, and the inside of its doorway, with or without an open door.

        Start and end are those of the left face.
        """
        a, b = np.array(start), np.array(end)
        long = np.hypot(*(b - a))
        way = (b - a) / long
        across = _WALL * np.array([way[1], -way[0]])  # to the right face
        self.wall(start, end, left, gap)
        self.wall(tuple(b + across), tuple(a + across), right, None if gap is None else long - gap)
        if gap is None:
            return
        one, two = a + (gap - _DOOR / 2) * way, a + (gap + _DOOR / 2) * way
        self.face(one, one + across, 0.0, _LINTEL, "jamb", "timber", gain=0.8)
        self.face(two + across, two, 0.0, _LINTEL, "jamb", "timber", gain=0.8)
        corner = np.array([*(one + across), _LINTEL])
        over = np.array([*(two - one), 0.0]), np.array([*-across, 0.0])
        self.add(corner, *over, "jamb", "timber", gain=0.6)
        if leaf:
            hinge = two + across + 0.02 * way
            tip = hinge + 0.04 * way + _LEAF * across / _WALL
            low, high = np.minimum(hinge, tip), np.maximum(hinge, tip)
            self.box(tuple(low), tuple(high), _LINTEL - 0.01, "door", None, "timber")

    def box(
        self,
        low: tuple[float, float],
        high: tuple[float, float],
        tall: float,
        show: str,
        front: int | None,
        top: str,
    ) -> None:
        """Add a box: a picture on its west, north, east or south side, or on both long ones."""
        (x0, y0), (x1, y1) = low, high
        ring = np.array([[x0, y0], [x0, y1], [x1, y1], [x1, y0], [x0, y0]])  # clockwise
        gain = self.rng.uniform(0.85, 1.05)
        for k, ends in enumerate(pairwise(ring)):
            long = np.hypot(*(ends[1] - ends[0])) > 0.5 if front is None else k == front
            picture = show if long else "timber"
            self.face(*ends, 0.0, tall, picture, picture, gain=gain)
        edges = np.array([x1 - x0, 0.0, 0.0]), np.array([0.0, y0 - y1, 0.0])
        self.add(np.array([x0, y1, tall]), *edges, top, top, gain=gain)

    def ground(self, west: float, east: float, south: float, north: float, show: str) -> None:
        """Add floor and ceiling of a rectangle, and its lamps."""
        wide, high = east - west, north - south
        across, up = np.array([wide, 0.0, 0.0]), np.array([0.0, high, 0.0])
        self.add(np.array([west, north, 0.0]), across, -up, "floor", show, gain=0.9)
        corner = np.array([west, south, _HIGH])
        carrier = self.add(corner, across, up, "ceiling", "panels", gain=0.9)
        for x in np.arange(west + 1.2, east - 1.2, 2.4):
            for y in np.arange(south + 0.9, north - 0.3, 2.4):
                corner = np.array([x, y, _HIGH - _OUT])
                lamp = np.array([1.2, 0.0, 0.0]), np.array([0.0, 0.3, 0.0])
                self.add(corner, *lamp, "lamp", "lamp", gain=1.0, carrier=carrier)

    def furnish(self, west: float, east: float, near: float, back: float, door: float) -> None:
        """Put tables below the windows, and cabinets and shelves beside the door."""
        inward = np.sign(near - back)
        facing = 1 if inward > 0 else 3
        for x in (west + self.rng.uniform(0.6, 1.2), east - self.rng.uniform(2.2, 2.8)):
            ys = back + 0.02 * inward, back + 0.72 * inward
            self.box((x, min(ys)), (x + 1.5, max(ys)), 0.74, "drawers", facing, "papers")
        for x in (west + 0.5, east - 1.5):
            if x < door < x + 1.0 or abs(x + 0.5 - door) < 1.3:
                continue
            ys = near - 0.02 * inward, near - 0.37 * inward
            corners = (x, min(ys)), (x + 1.0, max(ys))
            tall, show = [(1.15, "drawers"), (1.9, "books")][self.rng.integers(2)]
            self.box(*corners, tall, show, 4 - facing, "timber")
