"""A whole visit: detectors drive the states of the interaction, and the robot moves."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from data_synth.companion.hall import make_hall
from data_synth.companion.visits import (
    START,
    Order,
    Sight,
    Stance,
    Visit,
    Visitor,
    make_visit,
    make_visitor,
    see,
)
from data_synth.companion.walks import REGION
from robot_perception.chapters.tutor_face.scene import EIGENIMAGES, cut
from robot_perception.chapters.tutor_following.scene import CAMERA, FACES, RULES, at, hands
from robot_perception.companion.faces.eigenfaces import Eigenfaces, enrol
from robot_perception.companion.faces.link import Link, LinkRules, SeenFace, keep_link
from robot_perception.companion.following import Follower
from robot_perception.companion.interaction import (
    Event,
    Interaction,
    Percepts,
    paper_table,
)
from robot_perception.companion.tutor import TutorModel, TutorState, TutorTracker
from robot_perception.teaching.results import kept

STEP = 0.1
"""Seconds from one picture to the next."""
PORTRAITS = 20
"""Pictures of each tutor at enrolment; ours."""
TUTORS = 3
ACCEPTED = 0.9
"""Share of a tutor's own pictures that the limit of the gallery accepts; ours."""
KEEP = 2.2
"""Distance that the robot keeps, m; ours."""
NOTHING = np.full(4, np.nan)
"""Where something is that is not there."""
FACE = 0.177
"""Side of the square that marks a face, m."""
DOWN = 5
"""Pictures without a hand after which a hand is a new one; ours."""
EVENTS: Mapping[str, Event] = MappingProxyType(
    {
        "face": Event(lambda seen: bool(seen["faces"]), 2),
        "tutor": Event(lambda seen: seen["held"], 3),
        "nobody": Event(lambda seen: not seen["faces"], 10),
        "tutor gone": Event(lambda seen: not seen["held"], 30),
        "hand above": Event(lambda seen: seen["above"], 3),
        "hand beside": Event(lambda seen: seen["beside"], 8),
        "hand down": Event(lambda seen: not seen["hands"], 8),
        "open hand": Event(lambda seen: bool(seen["hands"]) and seen["fresh"], 3),
        "lost": Event(lambda seen: seen["hidden"], 25),
    }
)
"""When each event of the paper's table is true, and for how many pictures it must be; ours."""


@dataclass(frozen=True, slots=True)
class Kind:
    """How a visit goes.

    Parameters
    ----------
    brief
        Whether all goes fast, and a visit ends soon after the robot should have halted.
    told
        Whether the robot is told whose each face is, and need not recognise it.
    fresh
        Whether the hand that ends the following must have been down before.
    """

    brief: bool = False
    told: bool = False
    fresh: bool = True


@dataclass(frozen=True, eq=False, slots=True)
class Moment:
    """A picture of a visit, what is found in it, and what is so.

    The picture is made again where it is asked for.

    Parameters
    ----------
    seed, brief, frame
        Which picture it is, of which visit.
    noise
        State of the source of its noise, a PCG-64, before it was taken.
    state
        Of the interaction, after this picture.
    pose : (3,)
        Of the robot when it was taken: x, y (m), heading (rad).
    faces, hands : (n, 4)
        Found, where the state looks for them.
    held
        The face that has the link; ``None`` if none has.
    box, truth : (4,)
        Where the tracker has the tutor's head and trunk, and where they are, px; not a number where
        it tracks nobody, or the tutor is not before the camera.
    tutor : (2,)
        Where the tutor is, m; not a number before he comes.
    """

    seed: int
    brief: bool
    frame: int
    noise: tuple[int, ...] = field(repr=False)
    state: str
    pose: Float[np.ndarray, " 3"]
    faces: tuple[SeenFace, ...]
    hands: Float[np.ndarray, "n 4"]
    held: int | None
    box: Float[np.ndarray, " 4"]
    truth: Float[np.ndarray, " 4"]
    tutor: Float[np.ndarray, " 2"]

    @property
    def image(self) -> UInt8[np.ndarray, "240 320 3"]:
        """The picture: red, green and blue."""
        rng = np.random.Generator(np.random.PCG64())
        rng.bit_generator.state = _state(*self.noise)
        return _seen(visit(self.seed, self.brief), self.pose, self.frame, rng).image


def _noise(rng: np.random.Generator) -> tuple[int, ...]:
    """Return the state of a PCG-64 in numbers."""
    said = rng.bit_generator.state
    return *said["state"].values(), said["has_uint32"], said["uinteger"]


def _state(state: int, inc: int, has_uint32: int, uinteger: int) -> dict[str, Any]:
    """Return the state of a PCG-64 as it takes it."""
    return {
        "bit_generator": "PCG64",
        "state": {"state": state, "inc": inc},
        "has_uint32": has_uint32,
        "uinteger": uinteger,
    }


def _seen(happens: Visit, pose: np.ndarray, frame: int, rng: np.random.Generator) -> Sight:
    """Return what the robot's camera sees in a picture of a visit."""
    people = happens.at(frame)
    return see(happens.hall, CAMERA, pose, people, rng=rng, phase=0.8 * frame)


@lru_cache(maxsize=4)
def gallery(seed: int) -> Eigenfaces:
    """Return the gallery of the tutor of a visit and two more, as the robot's camera saw them."""
    rng = np.random.default_rng([seed, 1])
    people = [visit(seed).tutor, *(make_visitor(rng) for _ in range(TUTORS - 1))]
    faces, names = [], []
    hall = make_hall(rng)
    for k, who in enumerate(people):
        for _ in range(3 * PORTRAITS):
            grey = cv2.cvtColor(portrait(who, hall, rng), cv2.COLOR_RGB2GRAY)
            boxes = FACES.find(grey)
            if len(boxes) and names.count(f"tutor {k + 1}") < PORTRAITS:
                faces.append(cut(grey, boxes[0]))
                names.append(f"tutor {k + 1}")
    return enrol(np.array(faces), names, EIGENIMAGES, accepted=ACCEPTED)


def portrait(who: Visitor, hall: Any, rng: np.random.Generator) -> UInt8[np.ndarray, "h w 3"]:
    """Return a picture of somebody who stands before the robot to be enrolled."""
    pose = np.array([rng.uniform(4, 9), rng.uniform(4, 6), rng.uniform(-0.5, 0.5)])
    ahead, left = rng.uniform((1.8, -0.3), (2.5, 0.3))
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    x, y = pose[0] + ahead * cos - left * sin, pose[1] + ahead * sin + left * cos
    stance = Stance(float(x), float(y))
    return see(hall, CAMERA, pose, [(who, stance)], rng=rng).image


@lru_cache(maxsize=4)
def visit(seed: int, brief: bool = False) -> Visit:
    """Return the visit of a seed."""
    return make_visit(np.random.default_rng(seed), brief=brief)


class Robot:
    """Detectors, tracker and wheels; which of them work depends on the state.

    Parameters
    ----------
    known
        Of the tutors; ``None`` if the robot is told whose each face is.
    rng
        Of the tracker.
    fresh
        Whether the hand that ends the following must have been down before.
    """

    def __init__(self, known: Eigenfaces | None, rng: np.random.Generator, *, fresh: bool) -> None:
        self.known, self.rng, self.ask = known, rng, fresh
        self.tracker = TutorTracker(TutorModel(), RULES)
        self.follower = Follower(CAMERA.focal, CAMERA.focal * (REGION[3] - REGION[1]) / KEEP)
        self.link: Link | None = None
        self.followed: TutorState | None = None
        self.faces: tuple[SeenFace, ...] = ()
        self.hands = np.zeros((0, 4))
        self.held: int | None = None
        self.quiet, self.fresh = 0, True

    def perceive(
        self, image: UInt8[np.ndarray, "h w 3"], state: str, tutor: Float[np.ndarray, " 4"]
    ) -> Percepts:
        """Return what the events ask for, by the detectors that the state needs.

        Where the tutor's face truly is counts only for a robot that is told.
        """
        grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
        self.faces, self.held, hidden = (), None, False
        if state == "follow":
            self.followed, info = self.tracker.step(self.followed, image, rng=self.rng)
            hidden = info.hidden
            self.link = Link(self.link.name, SeenFace(_face(self.followed.box), self.link.name))
            left, top, wide, high = self.followed.box
            around = np.array([left - wide, top - 0.6 * high, 3 * wide, 1.4 * high])
        else:
            self._look(grey, tutor)
            around = None if self.link is None else _around(self.link.face.box, 5, 5)
        self.hands = np.zeros((0, 4))
        if around is not None and state not in ("wait", "identify"):
            self.hands = hands().find(grey, around) if _inside(around) else self.hands
        self.quiet = 0 if len(self.hands) else self.quiet + 1
        above = [self._above(hand) for hand in self.hands]
        return {
            "faces": self.faces, "held": self.held is not None, "hands": len(self.hands),
            "above": any(above), "beside": bool(above) and not any(above),
            "fresh": self.fresh, "hidden": hidden,
        }  # fmt: skip

    def _look(self, grey: UInt8[np.ndarray, "h w"], tutor: Float[np.ndarray, " 4"]) -> None:
        """Find faces, ask whose they are, and keep the link."""
        window = None if self.link is None else _around(self.link.face.box, 3, 3)
        window = window if window is not None and _inside(window) else None
        found = []
        for box in FACES.find(grey, window):
            if self.known is None:
                name = "tutor 1" if at(box[None], tutor)[0] else None
            else:
                name = self.known.recognise(cut(grey, box)).name
            found.append(SeenFace(box, name))
        self.faces = tuple(found)
        self.link, info = keep_link(self.link, self.faces, LinkRules(patience=40))
        self.held = info.held

    def _above(self, hand: Float[np.ndarray, " 4"]) -> bool:
        """Tell whether the middle of a hand is above the upper edge of the tutor's face."""
        top = np.inf if self.link is None else self.link.face.box[1]
        return bool(hand[1] + hand[3] / 2 < top)

    def enter(self, image: UInt8[np.ndarray, "h w 3"], state: str) -> None:
        """Make ready for a new state: a hand that is up is an old one; begin to track."""
        self.fresh, self.quiet = not self.ask, 0
        if state == "follow":
            self.followed = self.tracker.start(image, _body(self.link.face.box), rng=self.rng)
        if state == "wait":
            self.link = None

    def command(self, state: str) -> tuple[float, float]:
        """Return speed (m/s) and turn rate (rad/s): drive after the tutor, or turn to the face."""
        self.fresh = self.fresh or self.quiet >= DOWN
        middle = CAMERA.middle[0]
        if state == "follow":
            left, _, wide, high = self.followed.box
            return self.follower.command(left + wide / 2 - middle, high)
        if self.held is None:
            return 0.0, 0.0
        u, _, _ = _middle(self.faces[self.held].box)
        return 0.0, self.follower.command(u - middle, self.follower.height)[1]


def _middle(box: Float[np.ndarray, " 4"]) -> tuple[float, float, float]:
    """Return column, row and side of a square."""
    return float(box[0] + box[2] / 2), float(box[1] + box[3] / 2), float(box[2])


def _body(face: Float[np.ndarray, " 4"]) -> np.ndarray:
    """Return the box of head and trunk below a face."""
    u, v, side = _middle(face)
    wide, high = (REGION[2] - REGION[0]) * side / FACE, (REGION[3] - REGION[1]) * side / FACE
    return np.array([u - wide / 2, v - 0.91 * side, wide, high])


def _face(body: Float[np.ndarray, " 4"]) -> np.ndarray:
    """Return where the face of a head and trunk should be."""
    left, top, wide, high = body
    side = FACE * high / (REGION[3] - REGION[1])
    return np.array([left + wide / 2 - side / 2, top + 0.41 * side, side, side])


def _around(box: Float[np.ndarray, " 4"], across: float, down: float) -> np.ndarray:
    """Return the window that reaches so many sides from the middle of a face."""
    u, v, side = _middle(box)
    return np.array([u - across * side, v - down * side, 2 * across * side, 2 * down * side])


def _inside(box: Float[np.ndarray, " 4"]) -> bool:
    """Tell whether a part of a box is in the picture."""
    rows, columns = CAMERA.size
    return bool(box[0] < columns - 1 and box[1] < rows - 1 and (box[:2] + box[2:] > 1).all())


def moments(seed: int, kind: Kind) -> Iterator[Moment]:
    """Run a visit and yield it picture by picture."""
    rng = np.random.default_rng([seed, 2])
    happens = visit(seed, kind.brief)
    robot = Robot(None if kind.told else gallery(seed), rng, fresh=kind.fresh)
    rules = Interaction(paper_table(), EVENTS)
    state, pose = rules.start(), np.array(START)
    for frame in range(happens.frames):
        people = happens.at(frame)
        noise, seen = _noise(rng), _seen(happens, pose, frame, rng)
        index = next((k for k, (who, _) in enumerate(people) if who is happens.tutor), None)
        face = NOTHING if index is None else seen.faces[index]
        after, _ = rules.step(state, robot.perceive(seen.image, state.name, face))
        if after.name != state.name:
            robot.enter(seen.image, after.name)
        truth, there = NOTHING, NOTHING[:2]
        if index is not None:
            truth, there = seen.boxes[index], np.array([people[index][1].x, people[index][1].y])
        followed = after.name == "follow"
        yield Moment(
            seed, kind.brief, frame, noise, after.name, pose, robot.faces, robot.hands, robot.held,
            robot.followed.box if followed else NOTHING, truth, there,
        )  # fmt: skip
        state, pose = after, _driven(pose, *robot.command(after.name), happens)


def _driven(pose: np.ndarray, speed: float, turn: float, happens: Visit) -> np.ndarray:
    """Return where the robot is after a picture's time."""
    x, y, heading = pose
    heading += STEP * turn / 2
    there = np.array([x + STEP * speed * np.cos(heading), y + STEP * speed * np.sin(heading)])
    x, y = there.clip(0.5, [happens.hall.length - 0.5, happens.hall.width - 0.5])
    return np.array([x, y, heading + STEP * turn / 2])


SHOULD = MappingProxyType(
    {
        "a stranger's hand": ("wait", "identify"),
        "tutor": ("idle",),
        "hand above": ("follow",),
        "walks": ("follow",),
        "halt": ("halt",),
        "hand down": ("idle",),
        "hand beside": ("gesture",),
        "leaves": ("wait", "identify"),
    }
)
"""The states in which the robot should be when an order is over."""


@kept
def obeyed(seed: int, kind: Kind) -> tuple[bool, ...]:
    """Return which orders of a visit are obeyed, up to the first that is not.

    While the tutor walks the tracker must be at him at the end, too, and a stranger's hand must
    never set the robot in motion.
    """
    orders = judged(visit(seed, kind.brief), kind)
    done: list[bool] = []
    for frame, moment in enumerate(moments(seed, kind)):
        order = orders[len(done)]
        if order.what == "a stranger's hand" and moment.state in ("follow", "gesture"):
            return *done, False
        if frame == order.last:
            right = moment.state in SHOULD[order.what]
            if order.what == "walks":
                right = right and bool(at(moment.box[None], moment.truth)[0])
            done.append(right)
            if not right or len(done) == len(orders):
                break
    return tuple(done)


def judged(happens: Visit, kind: Kind) -> tuple[Order, ...]:
    """Return the orders of a visit that are judged; a brief one ends before the tutor is gone."""
    return happens.orders[:-1] if kind.brief else happens.orders
