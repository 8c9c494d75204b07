"""A hall in which a stranger and a tutor come to a robot; the tutor raises a hand and walks off.

Only people and hall are here. Where the robot goes is the affair of who drives it, and what it sees
there is `see`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from data_synth._checks import array, generator, instance, number, whole
from data_synth.coloured.filming import wave
from data_synth.companion.canvas import lay, photograph
from data_synth.companion.faces import (
    SPAN,
    FaceIdentity,
    FaceView,
    face_square,
    make_identity,
    square,
)
from data_synth.companion.hall import Hall, RobotCamera, make_hall
from data_synth.companion.hands import HAND_BOX, HandPose, hand_sprite, make_hand
from data_synth.companion.hands import SPAN as HAND_SPAN
from data_synth.companion.walking import HIGH, Arm, Clothes, body_sprite, make_clothes
from data_synth.companion.walks import person_box

__all__ = [
    "Order",
    "Sight",
    "Stance",
    "Visit",
    "Visitor",
    "lay_people",
    "make_visit",
    "make_visitor",
    "see",
]

START = (4.0, 5.0, 0.0)
"""Pose of the robot at first: x, y (m) and heading (rad)."""
_HEAD = 1.595  # middle of the head's sprite above the ground, m
_ABOVE, _BESIDE, _REST = (0.36, 1.70), (0.50, 1.22), (0.27, 0.90)
_WRIST = 0.12  # middle of a hand's sprite above the wrist, m
_RISE = 5  # pictures that an arm takes
_LONG = (
    ("a stranger's hand", 20), ("", 20), ("tutor", 50), ("hand above", 25), ("walks", 60), ("", 5),
    ("halt", 25), ("hand down", 25), ("hand beside", 25), ("hand down", 25), ("leaves", 55),
)  # fmt: skip
_SHORT = (
    ("a stranger's hand", 14), ("", 14), ("tutor", 32), ("hand above", 14), ("walks", 36), ("", 3),
    ("halt", 16), ("leaves", 1),
)  # fmt: skip
"""Acts of a visit, each with its least number of pictures; no name where nobody wants anything."""


@dataclass(frozen=True, eq=False, slots=True)
class Visitor:
    """Somebody in the hall.

    Parameters
    ----------
    identity
        Whose face it is.
    clothes
        What the person wears.
    hand
        The one that is raised.
    """

    identity: FaceIdentity
    clothes: Clothes
    hand: HandPose

    def __post_init__(self) -> None:
        instance("identity", self.identity, FaceIdentity)
        instance("clothes", self.clothes, Clothes)
        instance("hand", self.hand, HandPose)


@dataclass(frozen=True, slots=True)
class Stance:
    """Place of a visitor, and what he does there.

    Parameters
    ----------
    x, y
        In the hall, m.
    heading
        Where the body looks, rad; ``None`` looks at the robot.
    walks
        Whether the person walks or stands.
    raised
        How far the hand is up, 0 to 1.
    beside
        Whether it goes beside the body and not above the head.
    tilt
        By which the hand is turned, clockwise as seen, rad.
    """

    x: float
    y: float
    heading: float | None = None
    walks: bool = False
    raised: float = 0.0
    beside: bool = False
    tilt: float = 0.0

    def __post_init__(self) -> None:
        for name in ("x", "y"):
            number(name, getattr(self, name), 0.0, 1000.0)
        if self.heading is not None:
            number("heading", self.heading)
        number("raised", self.raised, 0.0, 1.0)
        number("tilt", self.tilt, -4.0, 4.0)
        for name in ("walks", "beside"):
            instance(name, getattr(self, name), bool)


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """Picture of the camera, with the truth of what it shows.

    Parameters
    ----------
    image : (240, 320, 3)
        Red, green and blue.
    boxes : (k, 4)
        Of each visitor's head and trunk, px; not a number where the person is not before the
        camera.
    faces : (k, 4)
        The squares that mark the faces of those who look at the robot.
    hands : (k, 4)
        The squares round the raised hands.
    """

    image: np.ndarray = field(repr=False)
    boxes: np.ndarray
    faces: np.ndarray
    hands: np.ndarray


def make_visitor(rng: np.random.Generator) -> Visitor:
    """Return somebody, with hands as dark as the face."""
    generator(rng)
    identity = make_identity(rng)
    return Visitor(identity, make_clothes(rng), make_hand(rng, tone=identity.tone))


def see(
    hall: Hall,
    camera: RobotCamera,
    pose: np.ndarray,
    people: Sequence[tuple[Visitor, Stance]],
    *,
    rng: np.random.Generator,
    phase: float = 0.0,
    light: float = 1.0,
) -> Sight:
    """Return what a robot sees of the hall and the people in it.

    Parameters
    ----------
    hall, camera
        The world.
    pose : (3,)
        Of the robot: x, y (m), heading (rad).
    people
        Who is there, and how.
    rng
        Source of the expressions, small turns of the heads and the noise.
    phase
        Of everybody's step, rad.
    light
        On everything.

    Raises
    ------
    ValueError
        If the robot is outside of the hall, or a number is out of range.
    """
    instance("hall", hall, Hall)
    instance("camera", camera, RobotCamera)
    generator(rng)
    phase, light = number("phase", phase), number("light", light, 0.05, 4.0)
    if not isinstance(people, tuple | list):
        raise TypeError(f"people must be a list of pairs, got {type(people).__name__}")
    for pair in people:
        if len(instance("people", pair, tuple)) != 2:
            raise ValueError(f"people must be pairs of a visitor and a stance, got {pair}")
    canvas = hall.view(pose, camera) * np.float32(light)
    found = lay_people(canvas, camera, pose, people, rng=rng, phase=phase, light=light)
    return Sight(photograph(canvas, rng=rng), *found)


def lay_people(
    canvas: np.ndarray,
    camera: RobotCamera,
    pose: np.ndarray,
    people: Sequence[tuple[Visitor, Stance]],
    *,
    rng: np.random.Generator,
    phase: float = 0.0,
    light: float = 1.0,
) -> np.ndarray:
    """Lay people over what else a robot sees, in place, the farthest first.

    Parameters
    ----------
    canvas : (rows, columns, 3)
        Light that reaches the camera, red, green and blue.
    camera, pose, people, rng, phase, light
        As of `see`.

    Returns
    -------
    (3, k, 4)
        Boxes of each person's trunk, face and raised hand, px; not a number where there is none.
    """
    x, y, heading = array("pose", pose, (3,))
    found = np.full((3, len(people), 4), np.nan)
    places = []
    for visitor, stance in people:
        instance("visitor", visitor, Visitor)
        instance("stance", stance, Stance)
        east, north = stance.x - x, stance.y - y
        ahead = math.cos(heading) * east + math.sin(heading) * north
        left = math.cos(heading) * north - math.sin(heading) * east
        turn = 0.0  # of the body, seen from before: 0 looks at the robot
        if stance.heading is not None:
            turn = _wrapped(stance.heading - math.atan2(-north, -east))
        places.append((ahead, left, turn))
    for k in sorted(range(len(people)), key=lambda k: -places[k][0]):
        # in steps, so that a body is not drawn anew for every look
        looks = np.round(rng.normal(0, (0.08, 0.05, 0.3)) / (0.1, 0.1, 0.4)) * (0.1, 0.1, 0.4)
        ahead, left, _ = places[k]
        if ahead > 0.6 and abs(left) < 1.2 * ahead:
            found[:, k] = _person(canvas, camera, *people[k], places[k], phase + k, light, looks)
    return found


def _person(
    canvas: np.ndarray,
    camera: RobotCamera,
    visitor: Visitor,
    stance: Stance,
    place: tuple[float, float, float],
    phase: float,
    light: float,
    looks: np.ndarray,
) -> np.ndarray:
    """Lay a visitor into the picture; return the boxes of trunk, face and hand (3, 4)."""
    ahead, left, turn = place
    front, behind = abs(turn) < math.radians(60), abs(turn) > math.radians(120)
    view = "front" if front else "back" if behind else "side"
    yaw = float(np.clip((turn if front else 0.0) + looks[0], -1.5, 1.5))
    face = arm = None
    if front:
        smile = min(abs(float(looks[2])), 1.0)
        face = FaceView(yaw=round(yaw, 1), pitch=float(looks[1]), smile=smile, azimuth=0.3)
        target = np.array(_BESIDE if stance.beside else _ABOVE)
        out, up = _REST + stance.raised * (target - _REST)
        if stance.raised > 0:
            arm = Arm(1, float(out), float(up))
    sprite = body_sprite(visitor.clothes, visitor.identity, phase=phase, walks=stance.walks,
                         view=view, face=face, arm=arm, height=300)  # fmt: skip
    if view == "side" and turn > 0:  # the sprite walks to the right
        sprite = sprite[:, ::-1]
    u, v = camera.project(ahead, left, HIGH / 2)
    lay(canvas, sprite, (u, v), camera.focal * HIGH / ahead, light=light)
    boxes = np.full((3, 4), np.nan)
    boxes[0] = person_box(camera, ahead, left)
    if front:
        tall = camera.focal * SPAN / ahead
        u, v = camera.project(ahead, left, _HEAD)
        boxes[1] = face_square(u, v, tall, yaw)
    if arm is not None:
        tall = camera.focal * HAND_SPAN / ahead
        u, v = camera.project(ahead, left - out, up + _WRIST)
        hand = _hand(visitor.hand)
        lay(canvas, hand, (u, v), tall, angle=stance.tilt, light=light)
        off = (HAND_BOX[1] - 0.5) * tall
        middle = u - off * math.sin(stance.tilt), v + off * math.cos(stance.tilt)
        boxes[2] = square(middle, HAND_BOX[2] * tall)
    return boxes


@lru_cache(maxsize=16)
def _hand(hand: HandPose) -> np.ndarray:
    return hand_sprite(hand, 96)


def _wrapped(angle: float) -> float:
    return math.remainder(angle, 2 * math.pi)


@dataclass(frozen=True, slots=True)
class Order:
    """Act of somebody that concerns the robot.

    Parameters
    ----------
    what
        ``"a stranger's hand"``, ``"tutor"``, ``"hand above"``, ``"walks"``, ``"halt"``, ``"hand
        down"``, ``"hand beside"`` or ``"leaves"``.
    first, last
        In which pictures.
    """

    what: str
    first: int
    last: int


@dataclass(frozen=True, eq=False, slots=True)
class Visit:
    """A hall and what happens in it, ten pictures a second.

    Parameters
    ----------
    hall
        Where.
    stranger, tutor, passer
        Who: the first one raises a hand, too; the last one walks through between robot and tutor.
    orders
        What happens when.
    walked : (n, 3)
        Where the tutor is in each picture while he leads: x, y (m) and heading (rad).
    places : (2, 2)
        Where stranger and tutor stand before the robot, m.
    """

    hall: Hall
    stranger: Visitor
    tutor: Visitor
    passer: Visitor
    orders: tuple[Order, ...]
    walked: np.ndarray = field(repr=False)
    places: np.ndarray

    @property
    def frames(self) -> int:
        """Number of pictures that it lasts."""
        return self.orders[-1].last + 1

    def order(self, what: str) -> Order:
        """Return the first order of a name.

        Raises
        ------
        ValueError
            If there is none.
        """
        instance("what", what, str)
        for order in self.orders:
            if order.what == what:
                return order
        raise ValueError(f"what must be an order of the visit, got {what!r}")

    def at(self, frame: int) -> tuple[tuple[Visitor, Stance], ...]:
        """Return who is where in a picture.

        Raises
        ------
        ValueError
            If the picture is not one of the visit.
        """
        frame = whole("frame", frame, 0, self.frames - 1)
        found = []
        hand, comes = self.order("a stranger's hand"), self.order("tutor")
        if hand.first - 15 <= frame <= hand.last + 15:
            way = max(hand.first - 5 - frame, 0) + max(frame - hand.last - 5, 0)
            x, y = self.places[0] + np.array([0.0, 0.16]) * way
            heading = None if not way else math.pi / 2 if frame > hand.last else -math.pi / 2
            found.append((self.stranger, Stance(x, y, heading, bool(way), _lift(frame, hand))))
        if frame >= comes.first:
            found.append((self.tutor, self._tutor(frame)))
        walks = self.order("walks")
        passing = frame - (walks.first + walks.last) / 2
        if abs(passing) < 22:
            # between the two: as far beside the way as steps are left to go
            x, y, heading = self.walked[max(round(walks.last - walks.first) // 2 - 9, 0)]
            across = np.array([-math.sin(heading), math.cos(heading)]) * 0.11 * passing
            found.append((self.passer, Stance(x + across[0], y + across[1],
                                              heading + math.pi / 2, True)))  # fmt: skip
        return tuple(found)

    def _tutor(self, frame: int) -> Stance:
        comes, walks, leaves = (self.order(name) for name in ("tutor", "walks", "leaves"))
        if frame < walks.first:
            way = max(comes.first + 15 - frame, 0)
            x, y = self.places[1] - np.array([0.0, 0.16]) * way
            if way:
                return Stance(x, y, math.pi / 2, walks=True)
            return Stance(x, y, raised=_lift(frame, self.order("hand above")))
        if frame <= walks.last:
            x, y, heading = self.walked[frame - walks.first]
            return Stance(x, y, heading, walks=True)
        x, y, heading = self.walked[-1]
        if frame > leaves.first:
            way = 0.16 * (frame - leaves.first)
            away = heading + math.pi / 2
            there = np.array([x + way * math.cos(away), y + way * math.sin(away)])
            x, y = there.clip(0.3, [self.hall.length - 0.3, self.hall.width - 0.3])
            return Stance(float(x), float(y), away, walks=True)
        beside = [order for order in self.orders if order.what == "hand beside"]
        if beside and frame >= beside[0].first:
            return Stance(x, y, raised=_lift(frame, beside[0]), beside=True)
        return Stance(x, y, raised=_lift(frame, self.order("halt")))


def _lift(frame: int, order: Order) -> float:
    """Return how far a hand is up that goes up at the first picture and down after the last."""
    return float(np.clip(min(frame - order.first + 1, order.last - frame + 1) / _RISE, 0, 1))


def make_visit(rng: np.random.Generator, *, brief: bool = False) -> Visit:
    """Return a visit.

    Parameters
    ----------
    rng
        Source of hall, people, ways and times.
    brief
        Whether all goes fast and the tutor leaves when the robot should have halted.
    """
    generator(rng)
    instance("brief", brief, bool)
    walls, looks, ways = (np.random.default_rng(seed) for seed in rng.integers(2**63, size=3))
    hall = make_hall(walls, length=24.0)
    stranger, tutor, passer = (make_visitor(looks) for _ in range(3))
    orders, start = [], 22
    for what, least in _SHORT if brief else _LONG:
        last = start + least + int(ways.integers(0, 5))
        if what:
            orders.append(Order(what, start, last))
        start = last + 1
    distance = ways.uniform(2.05, 2.25, 2)
    places = np.stack([START[0] + distance, START[1] + ways.uniform(-0.3, 0.3, 2)], axis=1)
    walks = next(order for order in orders if order.what == "walks")
    count = walks.last - walks.first + 1
    heading = np.cumsum([0.012 * wave(1.0, (25, 60), rng=ways)(t) for t in range(count)])
    into = np.arange(count)
    pace = 0.085 * np.clip(np.minimum(into, count - into) / 8, 0, 1)
    steps = np.stack([pace * np.cos(heading), pace * np.sin(heading)], axis=1)
    walked = np.column_stack([places[1] + np.cumsum(steps, axis=0), heading])
    return Visit(hall, stranger, tutor, passer, tuple(orders), walked, places)
