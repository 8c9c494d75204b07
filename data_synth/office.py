"""An office floor: a corridor with rooms on both sides, doors, furniture, and a drive through it.

Faces are directed: the free space lies to the left of the way from the first to the second end.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from data_synth._checks import array, generator, instance, number, whole

_THICKNESS = 0.12  # of the walls, m
_CLEAR = 0.75  # what the robot needs free on each side of its way, m
_WIDEST = 1.6  # piece of furniture, m
_LARGEST = 1e6  # side of a floor, m
_LEAST, _MOST_STEPS = 1e-9, 10_000_000  # of a drive: length or turn between poses, m and rad
_SLACK = 1e-9  # rounding decides neither the number of poses nor which way to turn round


@dataclass(frozen=True, eq=False, slots=True)
class Office:
    """A floor plan and a way through it.

    Parameters
    ----------
    faces : (faces, 2, 2)
        Ends of every face, m.
    kinds : (faces,)
        ``"wall"``, ``"jamb"`` (inside a doorway) or ``"furniture"``.
    waypoints : (points, 2)
        Corners of a drive that visits every room, m.
    tilt
        Direction of the corridor, rad.
    """

    faces: np.ndarray
    kinds: np.ndarray
    waypoints: np.ndarray
    tilt: float


def make_office(
    *,
    rng: np.random.Generator,
    rooms: int = 4,
    length: float = 20.0,
    corridor: float = 2.0,
    depth: float = 4.5,
    door: float = 1.0,
    furniture: int = 2,
) -> Office:
    """Return an office with random rooms, doors and furniture, turned by a random angle.

    Parameters
    ----------
    rng
        Source of randomness.
    rooms
        Rooms on each side of the corridor.
    length, corridor, depth
        Length and width of the corridor and depth of the rooms, m.
    door
        Width of the doors, m.
    furniture
        Pieces of furniture tried in each room; one that stands in the way is left out.

    Raises
    ------
    ValueError
        If a number is out of range, or a room is too narrow for its door or its furniture.
    """
    generator(rng)
    whole("rooms", rooms, 1, 1000)
    whole("furniture", furniture, 0, 1000)
    number("length", length, high=_LARGEST, above=0.0)
    number("corridor", corridor, high=_LARGEST, above=0.0)
    number("depth", depth, 1.5, _LARGEST)
    number("door", door, above=0.0)
    corners, kinds, pieces, visits = [(0.0, 0.0)], [], [], []

    def go(x: float, y: float, kind: str) -> None:
        corners.append((x, y))
        kinds.append(kind)

    for side in (-1, 1):  # rooms below, left to right, then rooms above, right to left
        widths = rng.uniform(0.7, 1.3, rooms)
        bounds = np.concatenate([[0.0], np.cumsum(widths)]) * length / widths.sum()
        order = range(rooms) if side < 0 else range(rooms - 1, -1, -1)
        base = 0.0 if side < 0 else corridor
        inner, back = base + side * _THICKNESS, base + side * depth
        for k in order:
            left, right = bounds[k] + _THICKNESS / 2, bounds[k + 1] - _THICKNESS / 2
            if right - left < max(door + 0.6, _WIDEST):
                raise ValueError(
                    f"length {length:g} m is too short for rooms {rooms} and door {door:g} m:"
                    f" a room is {right - left:.2f} m wide"
                )
            middle = rng.uniform(left + 0.3 + door / 2, right - 0.3 - door / 2)
            first, last = middle + side * door / 2, middle - side * door / 2
            near, far = (left, right) if side < 0 else (right, left)
            go(first, base, "wall")
            go(first, inner, "jamb")
            go(near, inner, "wall")
            go(near, back, "wall")
            go(far, back, "wall")
            go(far, inner, "wall")
            go(last, inner, "wall")
            go(last, base, "jamb")
            goal = np.array([(left + right) / 2, base + side * depth * 0.5])
            visits.append((middle, base + side * 1.0, goal))
            pieces += _furnish(left, right, inner, back, middle, goal, furniture, rng)
        go(*((length, 0.0) if side < 0 else (0.0, corridor)), "wall")
        go(*((length, corridor) if side < 0 else (0.0, 0.0)), "wall")
    outline = np.stack([corners[:-1], corners[1:]], axis=1)
    faces = np.concatenate([outline, *pieces]) if pieces else outline
    kinds += ["furniture"] * (len(faces) - len(kinds))
    waypoints = [np.array([0.8, corridor / 2])]
    for x, inside, goal in sorted(visits, key=lambda visit: visit[0]):
        way = [np.array([x, corridor / 2]), np.array([x, inside]), goal]
        waypoints += [*way, *way[1::-1]]
    waypoints.append(np.array([length - 0.8, corridor / 2]))
    tilt = rng.uniform(-np.pi, np.pi)
    turn = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
    return Office(faces @ turn.T, np.array(kinds), np.array(waypoints) @ turn.T, tilt)


def drive(office: Office, *, step: float = 0.25, turn: float = np.deg2rad(20.0)) -> np.ndarray:
    """Return poses (x, y, heading) along the waypoints: straight legs, and turns on the spot.

    Parameters
    ----------
    office
        Where to drive.
    step, turn
        Largest distance and turn between poses, m and rad.
    """
    instance("office", office, Office)
    number("step", step, _LEAST)
    number("turn", turn, _LEAST)
    way = array("waypoints of office", office.waypoints, (None, 2))
    if not np.hypot(*np.diff(way, axis=0).T).sum() / step <= _MOST_STEPS:
        raise ValueError(f"step must make at most {_MOST_STEPS} of the office, got {step:g} m")
    poses = []
    heading = None
    for start, end in pairwise(office.waypoints):
        leg = end - start
        distance = np.hypot(*leg)
        if distance < 1e-6:
            continue
        direction = np.arctan2(leg[1], leg[0])
        if heading is not None:
            change = (direction - heading + np.pi - _SLACK) % (2 * np.pi) - np.pi + _SLACK
            for k in range(1, int(np.ceil(abs(change) / turn - _SLACK))):
                poses.append([*start, heading + np.sign(change) * k * turn])
        heading = direction
        count = int(np.ceil(distance / step - _SLACK))
        poses += [[*(start + leg * k / count), heading] for k in range(count)]
    poses.append([*office.waypoints[-1], heading])
    return np.array(poses)


def _furnish(
    left: float,
    right: float,
    inner: float,
    back: float,
    door: float,
    goal: np.ndarray,
    tries: int,
    rng: np.random.Generator,
) -> list[np.ndarray]:
    """Boxes along the walls of a room that leave the robot's way free and do not overlap."""
    low, high = min(inner, back), max(inner, back)
    boxes, taken = [], []
    way = np.array([[door, inner], [door, inner + np.sign(back - inner) * 1.0], goal])
    for _ in range(tries):
        size = rng.uniform([0.5, 0.5], [_WIDEST, 0.9])
        corner = rng.uniform([left, low], [right, high] - size)
        pushed = rng.integers(3)  # against the left, the right or the back wall
        corner[0] = (left, right - size[0], corner[0])[pushed]
        corner[1] = (corner[1], corner[1], (low if back < inner else high - size[1]))[pushed]
        box = np.array([corner, corner + size])
        if any((box[0] < b[1] + 0.3).all() and (b[0] - 0.3 < box[1]).all() for b in taken):
            continue
        blocked = any(
            ((box[0] - _CLEAR < p) & (p < box[1] + _CLEAR)).all()
            for start, end in pairwise(way)
            for p in start + np.linspace(0, 1, 12)[:, None] * (end - start)
        )
        if blocked:
            continue
        taken.append(box)
        (x0, y0), (x1, y1) = box
        ring = np.array([[x0, y0], [x0, y1], [x1, y1], [x1, y0], [x0, y0]])  # clockwise
        boxes.append(np.stack([ring[:-1], ring[1:]], axis=1))
    return boxes
