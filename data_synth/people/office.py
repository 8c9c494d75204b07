"""An office for people: the rooms of :mod:`data_synth.office`, furnished and lit.

Tables and chairs stand on legs that a laser takes for those of people, as it does waste-paper
baskets; doors, cabinets and cork boards have the colour of skin. The plan is not turned: the
corridor runs along the first axis.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np

from data_synth._checks import array, generator, instance, number, reals
from data_synth._grid import on_grid
from data_synth.fisheye import Stage, linear
from data_synth.office import make_office
from data_synth.textures import paint

_LONG, _WIDE, _DEEP, _DOOR = 20.0, 2.4, 5.7, 1.1  # corridor, depth of rooms, doorways, m
_HIGH, _LINTEL = 2.7, 2.05  # of the ceiling and the doorways, m
_WALL = 0.12  # thickness, m
_LEAF = 0.04  # of a door, m
_PANEL = 0.6  # side of the panels of the ceiling, m
_CELL = 0.02  # of the raster that the ceiling is drawn from, m
_GRID = 0.05  # of the raster that people find their way on, m
_TEXELS = 96  # along the sides of a picture
_MIDDLE = 1.2  # half the side of the square in the middle of a room that stays free, m
_LEFT = 1.1, 1.9  # how far from the middle of a room chairs are left, m
_DAYLIGHT = 0.03  # share of it that reaches the middle of a room

_WOOD = [(176, 128, 88), (196, 150, 108), (160, 112, 78), (205, 163, 122)]  # like skin, sRGB
_GREY = [(196, 198, 200), (150, 154, 160), (120, 124, 128), (210, 208, 202)]
_PLASTER = [(228, 226, 220), (214, 218, 222), (226, 222, 206), (206, 214, 206)]
_METAL = (88, 90, 94)


@dataclass(frozen=True, eq=False, slots=True)
class PeopleOffice:
    """An office floor.

    Parameters
    ----------
    stage
        What a camera sees.
    rooms : (r, 4)
        Low x, low y, high x and high y of each room, and last of the corridor, m.
    doors : (r - 1, 2, 2)
        For each room a place in front of its door and one behind it, m.
    exits : (2, 2)
        Where people leave the floor, at both ends of the corridor, m.
    boxes
        How many of the boxes of the stage are boxes; the others show posts.
    posts : (p, 4)
        Round things: x, y, radius and height, m.
    clearance : (rows, columns)
        Distance from each cell of the floor to what stands there, m; 0 where nobody can walk.
    corner : (2,)
        Of that raster, m.
    cell
        Side of its cells, m.
    warmth : (n,)
        Colour temperature of each light, K: those of the rooms, of the corridor, and daylight.
    level, sway, period, phase : (n,)
        Mean strength of each light, and the slow wave around it: share, s, rad.
    """

    stage: Stage
    rooms: np.ndarray
    doors: np.ndarray
    exits: np.ndarray
    boxes: int
    posts: np.ndarray
    clearance: np.ndarray
    corner: np.ndarray
    cell: float
    warmth: np.ndarray
    level: np.ndarray
    sway: np.ndarray
    period: np.ndarray
    phase: np.ndarray

    def section(self, height: float) -> tuple[np.ndarray, np.ndarray]:
        """Return what a level cut meets: faces (f, 2, 2) and circles (c, 3), x, y and radius, m.

        Faces have the free space to their left, and the walls come first.
        """
        number("height", height, 0.0, _HIGH)
        low, top = self.stage.spans.T
        cut = (low <= height) & (height <= top)
        rings = self.stage.boxes[: self.boxes][cut[: self.boxes], ::-1]
        edges = np.stack([rings, np.roll(rings, -1, axis=1)], axis=2).reshape(-1, 2, 2)
        return np.concatenate([self.stage.walls, edges]), self.posts[self.posts[:, 3] >= height, :3]

    def room_of(self, place: np.ndarray) -> int:
        """Return the index of the room that a place (2,) lies in, the nearest if in none."""
        x, y = array("place", place, (2,))
        outside = np.maximum(self.rooms[:, :2] - [x, y], [x, y] - self.rooms[:, 2:])
        return int(np.maximum(outside, 0.0).sum(axis=1).argmin())

    def free(self, places: np.ndarray) -> np.ndarray:
        """Return how far places (n, 2) are from what stands still, m; 0 where nobody can walk."""
        columns, rows = np.floor((array("places", places, (None, 2)) - self.corner) / self.cell).T
        most = np.array(self.clearance.shape) - 1
        rows, columns = np.clip(rows, 0, most[0]), np.clip(columns, 0, most[1])
        return self.clearance[rows.astype(int), columns.astype(int)]

    def light(self, time: float, lights_out: np.ndarray | None = None) -> np.ndarray:
        """Return the strengths (n, 3) of the lights at a time: blue, green and red.

        Parameters
        ----------
        time
            Of the session, s.
        lights_out : (n - 1,)
            When the lamps of each room go out, s; never if left out. Daylight stays.
        """
        number("time", time, -1e9, 1e9)
        count = len(self.level)
        wave = self.level * (1 + self.sway * np.sin(2 * np.pi * time / self.period + self.phase))
        if lights_out is not None:
            out = reals("lights_out", lights_out)
            if out.shape != (count - 1,) or np.isnan(out).any():
                raise ValueError(f"lights_out must be ({count - 1},) times, got {out.shape}")
            wave[:-1] *= time < out
        glow = wave[:, None] * _tint(self.warmth)
        glow[:-1] += _DAYLIGHT * glow[-1]
        return glow


def make_people_office(*, rng: np.random.Generator, distractors: bool = True) -> PeopleOffice:
    """Return an office floor with three rooms on each side of a corridor.

    Parameters
    ----------
    rng
        Source of randomness.
    distractors
        Whether furniture stands on legs and has the colour of wood and cork; else tables are
        boxes, there are no chairs and baskets, and all is painted grey.
    """
    generator(rng)
    instance("distractors", distractors, bool)
    plan = make_office(
        rng=rng, rooms=3, length=_LONG, corridor=_WIDE, depth=_DEEP, door=_DOOR, furniture=0
    )
    turn = np.array(
        [[np.cos(plan.tilt), -np.sin(plan.tilt)], [np.sin(plan.tilt), np.cos(plan.tilt)]]
    )
    build = _Builder(rng, distractors)
    rooms, doors = build.shell(on_grid(plan.faces @ turn))
    exits = np.array([[0.35, _WIDE / 2], [_LONG - 0.35, _WIDE / 2]])
    build.furnish_corridor(doors)
    for light, (room, door) in enumerate(zip(rooms[:-1], doors, strict=True)):
        build.furnish(room, door, light)
    low = rooms[:, :2].min(axis=0) - 0.3
    high = rooms[:, 2:].max(axis=0) + 0.3
    stage = build.stage(low, high, rooms)
    clearance = build.clearance(low, high, rooms, doors)
    count = len(rooms) + 1
    level = np.r_[rng.uniform(0.55, 1.15, count - 1), rng.uniform(0.4, 1.2)]
    warmth = np.r_[rng.uniform(3500, 5600, count - 1), rng.uniform(5800, 7500)]
    sway = np.r_[rng.uniform(0.02, 0.08, count - 1), rng.uniform(0.1, 0.3)]
    return PeopleOffice(
        *(stage, rooms, doors, exits, len(build.boxes)),
        *(np.array(build.posts).reshape(-1, 4), clearance, low, _GRID),
        *(warmth, level, sway, rng.uniform(20, 90, count), rng.uniform(-np.pi, np.pi, count)),
    )


def _tint(kelvin: np.ndarray) -> np.ndarray:
    """Blue, green and red of a light for a camera balanced at 4300 K: a straight line in mired."""
    off = (1e6 / kelvin - 1e6 / 4300)[:, None] / 100
    return np.exp(off * np.array([-0.42, -0.03, 0.22]))


def _pictures(rng: np.random.Generator, coloured: bool) -> tuple[np.ndarray, dict[str, list[int]]]:
    """Pictures in colour, and which show what."""
    wood = np.array(_WOOD[:3] if coloured else _GREY[:3], dtype=float)

    def wooden(grey: np.ndarray) -> np.ndarray:
        return wood[rng.integers(3)] * grey[..., None] / 135

    def cork(grey: np.ndarray) -> np.ndarray:
        ground = np.array((190, 146, 104) if coloured else (170, 174, 176)) * grey[..., None] / 135
        sheets = grey[..., None] * rng.uniform(0.85, 1.0, 3)
        return np.where(grey[..., None] > 178, sheets, ground)

    def hues(grey: np.ndarray) -> np.ndarray:
        hue = (grey.astype(int) * 13 + rng.integers(180)) % 180
        strong = np.where((grey == 130) | (grey == 35), 20, 110)  # not of shelf and shadow
        hsv = np.stack([hue, strong, np.minimum(grey * 1.15, 255)], axis=-1)
        return cv2.cvtColor(hsv.astype(np.uint8), cv2.COLOR_HSV2RGB).astype(float)

    def painted(grey: np.ndarray) -> np.ndarray:
        dark, light = rng.uniform(20, 120, 3), rng.uniform(150, 255, 3)
        return dark + (light - dark) * grey[..., None] / 255

    def sky(grey: np.ndarray) -> np.ndarray:
        g = grey[..., None].astype(float)
        trees = np.where(abs(g - 200) < 1, g, g * [0.75, 1.0, 0.6])  # 200: the frame
        return np.where(g > 222, g * [0.86, 0.95, 1.05], trees)

    def plain(grey: np.ndarray) -> np.ndarray:
        return np.repeat(grey[..., None], 3, axis=-1).astype(float)

    wanted: dict[str, tuple[str, int, Callable[[np.ndarray], np.ndarray]]] = {
        "door": ("door", 1, wooden),
        "timber": ("timber", 2, lambda grey: wooden(grey * 1.5)),
        "planks": ("planks", 1, wooden),
        "notices": ("notices", 3, cork),
        "poster": ("poster", 6, painted),
        "books": ("books", 3, hues),
        "window": ("window", 2, sky),
        "writing": ("writing", 2, plain),
        "radiator": ("radiator", 1, plain),
        "drawers": ("drawers", 2, plain),
        "screen": ("papers", 2, lambda grey: plain(grey) * [0.25, 0.3, 0.4]),
    }
    pictures, of_kind = [], {}
    for kind, (source, count, colour) in wanted.items():
        of_kind[kind] = list(range(len(pictures), len(pictures) + count))
        for _ in range(count):
            shown = colour(paint(source, rng=rng)).clip(0, 255)
            small = cv2.resize(shown, (_TEXELS, _TEXELS), interpolation=cv2.INTER_AREA)
            pictures.append(linear(small).astype(np.float32))
    return np.array(pictures), of_kind


@dataclass(eq=False)
class _Builder:
    """Walls, boxes and posts, added one after the other."""

    rng: np.random.Generator
    distractors: bool
    pictures: np.ndarray = field(init=False)
    of_kind: dict[str, list[int]] = field(init=False)
    walls: list[tuple] = field(default_factory=list)  # ends, paint, light, hangings
    boxes: list[tuple] = field(default_factory=list)  # corners, span, paint, picture, light
    looks: list[tuple] = field(default_factory=list)  # of the posts, to a camera
    posts: list[tuple] = field(default_factory=list)
    taken: list[np.ndarray] = field(default_factory=list)  # rectangles

    def __post_init__(self) -> None:
        self.pictures, self.of_kind = _pictures(self.rng, self.distractors)

    def one_of(self, colours: list[tuple[int, int, int]]) -> np.ndarray:
        return linear(colours[self.rng.integers(len(colours))])

    def wood(self) -> np.ndarray:
        return self.one_of(_WOOD if self.distractors else _GREY)

    def picture(self, kind: str) -> int:
        return int(self.rng.choice(self.of_kind[kind]))

    def shell(self, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Add the walls of the plan: eight faces a room, and the two ends of the corridor."""
        sides = faces.reshape(2, -1, 2, 2)
        rooms, doors = [], []
        daylight = 7
        for side, chain in zip((-1, 1), sides, strict=True):
            base, inner = (0.0, -_WALL) if side < 0 else (_WIDE, _WIDE + _WALL)
            for k in range(3):
                part = chain[8 * k : 8 * k + 8]
                here = len(rooms)
                tone = self.one_of(_PLASTER)
                low, high = part[2:6].min(axis=(0, 1)), part[2:6].max(axis=(0, 1))
                rooms.append([*low, *high])
                middle = part[[0, 7], 1].mean(axis=0)[0]
                doors.append([[middle, base - side * 0.6], [middle, base + side * 1.1]])
                for i, ends in enumerate(part):
                    if i == 0:
                        self.wall(ends, linear(_PLASTER[0]), 6, ("poster", "notices", "poster"))
                    elif i in (1, 7):
                        self.wall(ends, self.wood(), here)
                    elif i == 4:
                        self.windows(ends, tone, here, daylight)
                    else:
                        hangings = ("notices", "writing", "poster", "planks", "poster")
                        self.wall(ends, tone, here, hangings)
                x0, x1 = middle - _DOOR / 2, middle + _DOOR / 2
                halfway = (base + inner) / 2
                for edge, paint_, light in ((base, linear(_PLASTER[0]), 6), (inner, tone, here)):
                    y0, y1 = sorted((edge, halfway))
                    self.box(x0, y0, x1, y1, _LINTEL, _HIGH, paint_, light=light)
                self.leaf(middle, inner, side, here)
            self.wall(chain[24], linear(_PLASTER[0]), 6, ("poster",))
            self.wall(chain[25], linear(_PLASTER[1]), 6, door=True)
        rooms.append([0.0, 0.0, _LONG, _WIDE])
        return np.array(rooms), np.array(doors)

    def wall(
        self,
        ends: np.ndarray,
        tone: np.ndarray,
        light: int,
        kinds: tuple[str, ...] = (),
        *,
        door: bool = False,
    ) -> None:
        """Add a face, and what hangs there."""
        long = float(np.hypot(*(ends[1] - ends[0])))
        hung, at = [], self.rng.uniform(0.3, 0.9)
        if door:
            hung.append((long / 2 - 0.5, long / 2 + 0.5, 0.0, 2.05, self.picture("door"), light))
        sizes = {
            "poster": (0.6, 0.84, 1.15),
            "notices": (1.2, 0.9, 1.05),
            "writing": (1.8, 1.1, 0.95),
            "planks": (1.0, 1.9, 0.1),
        }
        while kinds:
            kind = str(self.rng.choice(kinds))
            wide, high, low = sizes[kind]
            if at + wide > long - 0.25:
                break
            hung.append((at, at + wide, low, low + high, self.picture(kind), light))
            at += wide + self.rng.uniform(0.5, 1.6)
        self.walls.append((ends, tone, light, hung))

    def windows(self, ends: np.ndarray, tone: np.ndarray, light: int, daylight: int) -> None:
        """Add a face with two windows and the radiators below them."""
        long = float(np.hypot(*(ends[1] - ends[0])))
        hung = []
        for middle in (0.28 * long, 0.72 * long):
            low, high = middle - 0.8, middle + 0.8
            hung.append((low, high, 0.95, 2.25, self.picture("window"), daylight))
            hung.append((low, high, 0.15, 0.75, self.picture("radiator"), light))
        self.walls.append((ends, tone, light, hung))

    def box(
        self,
        x0: float,
        y0: float,
        x1: float,
        y1: float,
        low: float,
        top: float,
        tone: np.ndarray,
        *,
        light: int,
        kind: str = "",
        turn: float = 0.0,
    ) -> None:
        """Add a box, turned about its middle."""
        middle, half = np.array([x0 + x1, y0 + y1]) / 2, np.array([x1 - x0, y1 - y0]) / 2
        ring = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        spin = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        picture = self.picture(kind) if kind else -1
        self.boxes.append((middle + ring @ spin, (low, top), tone, picture, light))

    def post(self, x: float, y: float, radius: float, top: float, tone: np.ndarray, light: int):
        """Add something round; a camera sees it as a box."""
        self.posts.append((x, y, radius, top))
        if top > 0.2:
            half = 0.85 * radius
            corners = np.array([x, y]) + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
            self.looks.append((corners, (0.0, top), tone, -1, light))

    def leaf(self, middle: float, inner: float, side: int, light: int) -> None:
        """Add an open door that stands into its room."""
        hand = self.rng.choice([-1, 1])
        wide = _DOOR - 0.1
        x, y = middle + hand * (_DOOR / 2 + 0.05), inner + side * (wide / 2 + 0.03)
        x0, x1, y0, y1 = x - _LEAF / 2, x + _LEAF / 2, y - wide / 2, y + wide / 2
        self.box(x0, y0, x1, y1, 0.01, 2.03, self.wood(), light=light, kind="door")
        self.taken.append(np.array([x0, y0, x1, y1]))

    def claims(self, low: np.ndarray, high: np.ndarray, gap: float) -> bool:
        """Take a rectangle unless it comes nearer to a taken one than a gap."""
        for other in self.taken:
            if (low - gap < other[2:]).all() and (other[:2] < high + gap).all():
                return False
        self.taken.append(np.r_[low, high])
        return True

    def furnish_corridor(self, doors: np.ndarray) -> None:
        """Add cabinets and a basket along the corridor, away from the doors."""
        for _ in range(5):
            wide = self.rng.uniform(0.8, 1.2)
            x = self.rng.uniform(1.2, _LONG - 1.2 - wide)
            if (np.abs(doors[:, 0, 0] - x - wide / 2) < wide / 2 + _DOOR).any():
                continue
            y = 0.02 if self.rng.random() < 0.5 else _WIDE - 0.40
            if self.claims(np.array([x, y]), np.array([x + wide, y + 0.38]), 1.5):
                tall = self.rng.uniform(0.9, 1.15)
                self.box(x, y, x + wide, y + 0.38, 0.0, tall, self.wood(), light=6, kind="timber")

    def furnish(self, room: np.ndarray, door: np.ndarray, light: int) -> None:
        """Put tables, chairs, cabinets, a basket and a plant along the walls of a room."""
        middle, inside = (room[:2] + room[2:]) / 2, door[1]
        entry = np.array([0.8, 1.1])
        self.taken.append(np.r_[inside - entry, inside + entry])
        if self.distractors:
            for _ in range(2):
                self.loose_chair(middle, light)
        self.taken.append(np.r_[middle - _MIDDLE, middle + _MIDDLE])
        wanted = {self.desks: 2, self.cabinet: 3}
        if self.distractors:
            wanted |= {self.plant: 1, self.basket: 2}
        for put, count in wanted.items():
            stands = 0
            for _ in range(20):
                stands += stands < count and put(room, light)

    def against(self, room: np.ndarray, wide: float, deep: float) -> tuple[np.ndarray, int]:
        """Low and high corner of a rectangle against one of the walls of a room, and which: 0 to 3
        for the low x, low y, high x and high y.
        """
        wall = int(self.rng.integers(4))
        size = np.array([deep, wide] if wall % 2 == 0 else [wide, deep])
        low = self.rng.uniform(room[:2] + 0.03, room[2:] - 0.03 - size)
        axis = wall % 2
        low[axis] = room[axis] + 0.03 if wall < 2 else room[2 + axis] - 0.03 - size[axis]
        return np.stack([low, low + size]), wall

    def desks(self, room: np.ndarray, light: int) -> bool:
        """Put one desk or two beside each other, with screens and chairs."""
        count, wide, deep = int(self.rng.integers(1, 3)), self.rng.uniform(1.2, 1.5), 0.75
        place, wall = self.against(room, count * wide, deep)
        axis, away = (1 - wall % 2), (1.0 if wall < 2 else -1.0)
        seats = place + np.array([[0.0], [0.7]] if wall < 2 else [[-0.7], [0.0]]) * (
            np.arange(2) == wall % 2
        )
        if not self.claims(*seats, 0.1):
            return False
        tone, radius = self.wood(), self.rng.uniform(0.022, 0.045)
        metal, step = linear(_METAL), np.eye(2)[axis] * wide
        for k in range(count):
            low, high = place[0] + k * step, place[1] - (count - 1 - k) * step
            self.box(*low, *high, 0.70 if self.distractors else 0.0, 0.74, tone, light=light)
            middle = (low + high) / 2
            normal = np.eye(2)[1 - axis] * away
            screen = middle - 0.12 * normal
            half = np.abs(np.eye(2)[axis] * 0.26 + np.eye(2)[1 - axis] * 0.03)
            ends = (*(screen - half), *(screen + half))
            self.box(*ends, 0.85, 1.22, linear((28, 28, 32)), light=light, kind="screen")
            if not self.distractors:
                continue
            for corner in ((0, 0), (0, 1), (1, 0), (1, 1)):
                x, y = low + 0.06 + np.array(corner) * (high - low - 0.12)
                self.post(x, y, radius, 0.70, metal, light)
            self.chair(middle + (0.58 + self.rng.uniform(0, 0.1)) * normal, wall, light)
        return True

    def chair(self, place: np.ndarray, wall: int, light: int) -> None:
        """Put a chair with four legs, or one with a column."""
        turn = np.pi / 2 * wall + self.rng.uniform(-0.6, 0.6)
        ahead, side = (
            np.array([np.cos(turn), np.sin(turn)]),
            np.array([-np.sin(turn), np.cos(turn)]),
        )
        cloth = self.one_of([(52, 70, 120), (60, 62, 66), (110, 48, 46), (62, 96, 78)])
        low, high = place - 0.21, place + 0.21
        self.box(*low, *high, 0.43, 0.48, cloth, light=light, turn=turn)
        back, half = place + 0.2 * ahead, np.array([0.02, 0.2])
        ends = (*(back - half), *(back + half))
        self.box(*ends, 0.58, 0.95, cloth, light=light, turn=turn)
        if self.rng.random() < 0.5:
            self.post(*place, 0.035, 0.45, linear(_METAL), light)
            return
        for i, j in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
            self.post(*(place + 0.19 * (i * ahead + j * side)), 0.018, 0.45, linear(_METAL), light)

    def loose_chair(self, middle: np.ndarray, light: int) -> None:
        """Put a chair that somebody has left near the middle of a room, if there is a place."""
        for _ in range(20):
            turn, away = self.rng.uniform(-np.pi, np.pi), self.rng.uniform(*_LEFT)
            place = middle + away * np.array([np.cos(turn), np.sin(turn)])
            if self.claims(place - 0.25, place + 0.25, 0.5):
                self.chair(place, int(self.rng.integers(4)), light)
                return

    def cabinet(self, room: np.ndarray, light: int) -> bool:
        """Put a cabinet or a shelf with books."""
        tall = float(self.rng.choice([1.05, 1.4, 1.95]))
        place, _ = self.against(room, self.rng.uniform(0.8, 1.2), 0.4)
        if not self.claims(*place, 0.1):
            return False
        kind = str(self.rng.choice(["drawers", "timber", "timber" if tall < 1.2 else "books"]))
        self.box(*place.ravel(), 0.0, tall, self.wood(), light=light, kind=kind)
        return True

    def basket(self, room: np.ndarray, light: int) -> bool:
        """Put a waste-paper basket."""
        return self.round(room, self.rng.uniform(0.11, 0.15), 0.33, light, (70, 74, 80))

    def plant(self, room: np.ndarray, light: int) -> bool:
        """Put a pot with a plant in it."""
        radius = self.rng.uniform(0.14, 0.2)
        if not self.round(room, radius, 0.4, light, (150, 86, 60)):
            return False
        x, y, *_ = self.posts[-1]
        for low, high, share in ((0.4, 0.75, 0.9), (0.7, 1.3, 1.2), (1.25, 1.55, 0.7)):
            half = radius * share
            green = linear((52, 92, 44)) * self.rng.uniform(0.7, 1.2)
            ends = (x - half, y - half, x + half, y + half)
            self.box(*ends, low, high, green, light=light, turn=self.rng.uniform(0, 1.5))
        return True

    def round(
        self, room: np.ndarray, radius: float, top: float, light: int, tone: tuple[int, int, int]
    ) -> bool:
        """Put something round against a wall."""
        place, _ = self.against(room, 2 * radius, 2 * radius)
        if not self.claims(*place, 0.02):
            return False
        self.post(*place.mean(axis=0), radius, top, linear(tone), light)
        return True

    def stage(self, low: np.ndarray, high: np.ndarray, rooms: np.ndarray) -> Stage:
        """All that a camera sees."""
        columns, rows = np.ceil((high - low) / _CELL).astype(int)
        plan = np.full((rows, columns), 6, dtype=np.uint8)
        ceiling = np.zeros_like(plan)
        x = low[0] + (np.arange(columns) + 0.5) * _CELL
        y = low[1] + (np.arange(rows)[:, None] + 0.5) * _CELL
        for k, (x0, y0, x1, y1) in enumerate(rooms):
            inside = (x0 <= x) & (x <= x1) & (y0 <= y) & (y <= y1)
            across, along = (x - x0) / _PANEL, (y - y0) / _PANEL
            joint = (across % 1 < 0.04) | (along % 1 < 0.04)
            i, j = np.floor(across), np.floor(along)
            within = (i < (x1 - x0) // _PANEL - 1) & (j < (y1 - y0) // _PANEL - 1)
            lamp = (i % 4 >= 1) & (i % 4 <= 2) & (j % 4 == 1) & within
            plan[inside] = k
            ceiling[inside] = np.where(lamp, 1, 2 * joint)[inside]
        hung = [item for *_, hangings in self.walls for item in hangings]
        first = np.cumsum([0, *(len(hangings) for *_, hangings in self.walls)])
        boxes = self.boxes + self.looks
        return Stage(
            np.array([ends for ends, *_ in self.walls]),
            np.array([tone for _, tone, *_ in self.walls]),
            np.array([light for *_, light, _ in self.walls]),
            np.array([item[:4] for item in hung], dtype=float),
            first,
            np.array([item[4] for item in hung]),
            np.array([item[5] for item in hung]),
            np.array([corners for corners, *_ in boxes]),
            np.array([span for _, span, *_ in boxes], dtype=float),
            np.array([tone for _, _, tone, *_ in boxes]),
            np.array([picture for *_, picture, _ in boxes]),
            np.array([light for *_, light in boxes]),
            *(self.pictures, plan, ceiling, low, _CELL, _HIGH),
        )

    def clearance(self, low: np.ndarray, high: np.ndarray, rooms: np.ndarray, doors: np.ndarray):
        """Distance from each cell of the floor to what stands there, m."""
        columns, rows = np.ceil((high - low) / _GRID).astype(int)
        free = np.zeros((rows, columns), dtype=np.uint8)

        def cells(points: np.ndarray) -> np.ndarray:
            return np.rint((points - low) / _GRID - 0.5).astype(np.int32)

        gaps, half = doors.mean(axis=1), np.array([_DOOR / 2, 0.9])
        areas = [*rooms, *np.hstack([gaps - half, gaps + half])]
        for area in areas:
            cv2.rectangle(free, *(tuple(map(int, c)) for c in cells(area.reshape(2, 2))), 1, -1)
        for corners, (bottom, _), *_ in self.boxes:
            if bottom < _LINTEL - 0.1:
                cv2.fillPoly(free, [cells(corners)], 0)
        for x, y, radius, _ in self.posts:
            at, size = cells(np.array([x, y])), round(radius / _GRID)
            cv2.circle(free, tuple(map(int, at)), size, 0, -1)
        free[[0, -1]] = free[:, [0, -1]] = 0
        return cv2.distanceTransform(free, cv2.DIST_L2, 5).astype(float) * _GRID
