"""A whole visit: detectors drive the states of the interaction, and the robot moves."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
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
from robot_perception.companion.faces.link import SeenFace
from robot_perception.companion.following import Follower
from robot_perception.companion.robot import CompanionRobot, Recognise, RobotRules
from robot_perception.companion.tutor import TutorModel, TutorTracker
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


def robot(kind: Kind) -> CompanionRobot:
    """Return the robot of a kind of visits, which knows nobody yet."""
    follower = Follower(CAMERA.focal, CAMERA.focal * (REGION[3] - REGION[1]) / KEEP)
    rules, tracker = RobotRules(fresh=kind.fresh), TutorTracker(TutorModel(), RULES)
    return CompanionRobot(
        lambda grey, box: None, hands(), FACES, tracker, rules=rules, follower=follower
    )


def recogniser(seed: int, told: bool, face: Float[np.ndarray, " 4"]) -> Recognise:
    """Return what tells whose a face is: the gallery of a visit, or where the tutor's face is."""
    if told:
        return lambda grey, box: "tutor 1" if at(box[None], face)[0] else None
    return lambda grey, box: gallery(seed).recognise(cut(grey, box)).name


def moments(seed: int, kind: Kind) -> Iterator[Moment]:
    """Run a visit and yield it picture by picture."""
    rng = np.random.default_rng([seed, 2])
    happens, companion = visit(seed, kind.brief), robot(kind)
    state, pose = companion.start(), np.array(START)
    for frame in range(happens.frames):
        people = happens.at(frame)
        noise, seen = _noise(rng), _seen(happens, pose, frame, rng)
        index = next((k for k, (who, _) in enumerate(people) if who is happens.tutor), None)
        face = NOTHING if index is None else seen.faces[index]
        companion = replace(companion, recognise=recogniser(seed, kind.told, face))
        state, info = companion.step(state, seen.image, rng=rng)
        truth, there = NOTHING, NOTHING[:2]
        if index is not None:
            truth, there = seen.boxes[index], np.array([people[index][1].x, people[index][1].y])
        yield Moment(
            seed, kind.brief, frame, noise, state.name, pose, info.faces, info.hands, info.held,
            NOTHING if state.person is None else state.person.box, truth, there,
        )  # fmt: skip
        pose = _driven(pose, *info.command, happens)


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
