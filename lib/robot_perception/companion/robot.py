r"""A robot and its tutor: detectors, link and tracker, which the states of an interaction drive.

In every state but ``follow`` faces are looked for, whose they are is asked, and the link is kept:
the face that has it is tracked by a Kalman filter, which says where to look, or by the particles of
ICONDENSATION, and its descriptor says whether it is still the tutor's. In ``follow`` head and trunk
are tracked. Hands are looked for in all states but ``wait`` and
``identify``, round the face or the person. What is found are the percepts that the rules of the
events are given:

- ``faces``: those that were found, each a `SeenFace`;
- ``held``: whether one of them has the link;
- ``hands``: how many hands were found;
- ``above``, ``beside``: whether one of them is above the upper edge of the tutor's face, and all of
  head and trunk in view, so that they can be tracked; whether there are hands, and none is above;
- ``fresh``: whether hands were down since the state was entered;
- ``hidden``: whether the person who is tracked is taken to be hidden.

References
----------
Menezes, Lerasle and Dias, "Visual Tracking Modalities for a Companion Robot", section II with
Fig. 2; all numbers are ours.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType, NoneType
from typing import Annotated, final

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.companion.boxes import check_box, colour_picture
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.companion.faces.eigenfaces import Recognition
from robot_perception.companion.faces.icondensation import FaceFilter, FaceFilterState
from robot_perception.companion.faces.link import Link, LinkRules, SeenFace, keep_link, same_name
from robot_perception.companion.faces.region import FaceTracker, RegionState
from robot_perception.companion.following import Follower
from robot_perception.companion.hands.cascade import HandDetector
from robot_perception.companion.interaction import (
    Event,
    Interaction,
    InteractionInfo,
    InteractionState,
    paper_table,
)
from robot_perception.companion.tutor import TutorModel, TutorRules, TutorState, TutorTracker
from robot_perception.extras import needing
from robot_perception.fields import Positive, any_of, checked, from_to

with needing():
    import cv2

__all__ = [
    "EVENTS",
    "CompanionRobot",
    "RobotInfo",
    "RobotRules",
    "RobotState",
    "body_of",
    "face_of",
]

Box = Float[np.ndarray, " 4"]
Grey = UInt8[np.ndarray, "height width"]
Recognise = Callable[[Grey, Box], Recognition | str | None]

FACE = 0.177
"""Side of the square that marks a face, m."""
BODY = (0.5, 0.82)
"""Width and height of head and trunk, m."""
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
"""Condition of each event of the paper's table, and for how many pictures it must hold, at ten
pictures a second; ours."""


def body_of(face: Box) -> Box:
    """Return the box of head and trunk below a face.

    Parameters
    ----------
    face : (4,)
        Left, top, width and height of the square that marks it, px.

    Raises
    ------
    ValueError
        If the box is not of four finite numbers, or has no area.
    """
    u, v, side = _middle(check_box("face", face))
    wide, high = BODY[0] * side / FACE, BODY[1] * side / FACE
    return np.array([u - wide / 2, v - 0.91 * side, wide, high])


def face_of(body: Box) -> Box:
    """Return where the face of a head and trunk should be.

    Parameters
    ----------
    body : (4,)
        Left, top, width and height, px.

    Raises
    ------
    ValueError
        If the box is not of four finite numbers, or has no area.
    """
    left, top, wide, high = check_box("body", body)
    side = FACE * high / BODY[1]
    return np.array([left + wide / 2 - side / 2, top + 0.41 * side, side, side])


@final
@dataclass(frozen=True, slots=True)
class RobotRules:
    """Numbers of the robot; all ours.

    Parameters
    ----------
    link
        When the link goes on and when it ends.
    face_window, hand_window
        How many sides of the tutor's face, from its middle, faces and hands are looked for; faces
        by this only where nothing tracks them.
    down
        Pictures without a hand after which a hand is a new one.
    fresh
        Whether the hand that ends the following must have been down before.
    waits
        Whether the robot stands while the person whom it follows is taken to be hidden. Otherwise
        it drives after the tracker's estimate, which somebody who passes pushes aside.
    """

    link: LinkRules = field(default_factory=lambda: LinkRules(patience=40))
    face_window: Positive = 3.0
    hand_window: Positive = 5.0
    down: Annotated[int, from_to(1, 10**6)] = 5
    fresh: bool = True
    waits: bool = True
    __post_init__ = checked


@final
@dataclass(frozen=True, eq=False, slots=True)
class RobotState:
    """State of the robot.

    Parameters
    ----------
    interaction
        Where the interaction stands.
    link
        With whom the robot is in touch; ``None`` if with nobody.
    person
        Whom it tracks; ``None`` unless it follows.
    quiet
        For how many pictures no hand has been found, since the state was entered.
    fresh
        Whether hands were down since then, or need not have been.
    place
        What is known of where the linked face is, if something tracks it.

    Raises
    ------
    ValueError
        If a person is tracked without a link.
    """

    interaction: InteractionState
    link: Link | None = None
    person: TutorState | None = None
    quiet: Annotated[int, from_to(0)] = 0
    fresh: bool = True
    place: Annotated[
        RegionState | FaceFilterState | None, any_of(RegionState, FaceFilterState, NoneType)
    ] = None

    def __post_init__(self) -> None:
        checked(self)
        if self.person is not None and self.link is None:
            raise ValueError("link must be there where person is, got none")

    @property
    def name(self) -> str:
        """The state of the table."""
        return self.interaction.name


@final
@dataclass(frozen=True, eq=False, slots=True)
class RobotInfo:
    """Diagnostics of one picture, and the robot's action.

    Parameters
    ----------
    faces
        That were found, where the state looks for them.
    held
        Which of them has the link; ``None`` if none has.
    hands : (n, 4)
        Boxes of open hands, px.
    hidden
        Whether the person who is tracked is taken to be hidden.
    interaction
        The events.
    command
        Speed (m/s) and turn rate (rad/s).
    """

    faces: tuple[SeenFace, ...]
    held: int | None
    hands: Float[np.ndarray, "n 4"]
    hidden: bool
    interaction: InteractionInfo
    command: tuple[float, float]


@final
@dataclass(frozen=True, eq=False, slots=True)
class CompanionRobot:
    """A robot that waits for its tutor, looks at his hands and follows him.

    Parameters
    ----------
    recognise
        Function of a grey picture and the box of a face in it that returns a `Recognition`, as
        ``lambda grey, box: known.recognise(crop(grey, box))``, or just a tutor's name, ``None``
        for a stranger.
    hands
        Finds open hands.
    faces
        Finds faces, which are small where a raised hand is in view: sizes are 1.05 apart.
    face_tracking
        Keeps the place of the face that has the link: a `FaceTracker`, whose window is where its
        detector looks, or a `FaceFilter`, which the detector steers. Without one, faces are looked
        for round the last place.
    verify
        Function of the link and a face that tells whether it is the tutor who began the link; by
        default by name. By descriptor: `faces.link.same_descriptor`.
    tracker
        Follows head and trunk.
    interaction
        States and events. States other than ``wait``, ``identify`` and ``follow`` only differ in
        where they lead.
    rules
        Numbers.
    follower
        How the robot drives; without one it stands.
    """

    recognise: Recognise
    hands: HandDetector
    faces: FaceDetector = field(default_factory=lambda: FaceDetector(scale=1.05, neighbours=2))
    face_tracking: Annotated[
        FaceTracker | FaceFilter | None, any_of(FaceTracker, FaceFilter, NoneType)
    ] = None
    verify: Callable[[Link, SeenFace], bool] = same_name
    tracker: TutorTracker = field(
        default_factory=lambda: TutorTracker(TutorModel(), TutorRules(gate=0.3, whole_gate=0.4))
    )
    interaction: Interaction = field(default_factory=lambda: Interaction(paper_table(), EVENTS))
    rules: RobotRules = field(default_factory=RobotRules)
    follower: Follower | None = None
    __post_init__ = checked

    def start(self) -> RobotState:
        """Return the state before the first picture."""
        return RobotState(self.interaction.start())

    def step(
        self,
        state: RobotState,
        image: UInt8[np.ndarray, "height width 3"],
        *,
        rng: np.random.Generator,
    ) -> tuple[RobotState, RobotInfo]:
        """Return the state after a picture.

        Parameters
        ----------
        state
            Before it.
        image : (height, width, 3)
            Red, green, blue.
        rng
            Source of the tracker's particles.

        Raises
        ------
        TypeError
            If the image does not hold bytes.
        ValueError
            If it is not in colour, or the table leads to ``follow`` without a link.
        """
        checks.instance("state", state, RobotState)
        checks.generator("rng", rng)
        image = colour_picture("image", image)
        grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
        faces, held, hidden = (), None, False
        if state.person is not None:
            state, hidden, around = self._tracked(state, state.person, image, rng)
        else:
            state, faces, held = self._looked(state, image, grey, rng)
            link, sides = state.link, self.rules.hand_window
            around = None if link is None else _around(link.face.box, sides)
        hands = np.zeros((0, 4))
        if around is not None and state.name not in ("wait", "identify"):
            hands = self.hands.find(grey, around) if _inside(around, grey) else hands
        state = replace(state, quiet=0 if len(hands) else state.quiet + 1)
        above = [self._above(state.link, hand) for hand in hands]
        percepts = {
            "faces": faces, "held": held is not None, "hands": len(hands),
            "above": any(above) and self._whole(state.link, grey),
            "beside": bool(above) and not any(above), "fresh": state.fresh, "hidden": hidden,
        }  # fmt: skip
        after, told = self.interaction.step(state.interaction, percepts)
        entered = after.name != state.name
        state = replace(state, interaction=after)
        if entered:
            state = self._entered(state, image, rng)
        state = replace(state, fresh=state.fresh or state.quiet >= self.rules.down)
        face = None if held is None else faces[held].box
        command = self._command(state, face, image.shape[1], hidden)
        return state, RobotInfo(faces, held, hands, hidden, told, command)

    def _tracked(
        self, state: RobotState, person: TutorState, image: np.ndarray, rng: np.random.Generator
    ) -> tuple[RobotState, bool, np.ndarray]:
        """Return the state with the person in a picture, whether hidden, and where hands may be."""
        person, info = self.tracker.step(person, image, rng=rng)
        left, top, wide, high = person.box
        name = state.link.name
        link = Link(name, SeenFace(face_of(person.box), name))
        around = np.array([left - wide, top - 0.6 * high, 3 * wide, 1.4 * high])
        return replace(state, person=person, link=link), info.hidden, around

    def _looked(
        self, state: RobotState, image: np.ndarray, grey: Grey, rng: np.random.Generator
    ) -> tuple[RobotState, tuple[SeenFace, ...], int | None]:
        """Return the state with the link after a picture, the faces, and which has the link."""
        boxes, place = self._found(state, image, grey, rng)
        faces = tuple(_asked(box, self.recognise(grey, box)) for box in boxes)
        link, info = keep_link(state.link, faces, self.rules.link, verify=self.verify)
        if link is None:
            return replace(state, link=None, place=None), faces, info.held
        if info.began:
            place = self._placed(image, link.face.box, rng)
        elif info.held is None:  # not seen, or not verified: where it should be by now
            link = replace(link, face=replace(link.face, box=_box(place, link.face.box)))
        return replace(state, link=link, place=place), faces, info.held

    def _found(
        self, state: RobotState, image: np.ndarray, grey: Grey, rng: np.random.Generator
    ) -> tuple[np.ndarray, RegionState | FaceFilterState | None]:
        """Return the boxes of faces, and where the face that has the link is by what tracks it."""
        if state.link is None:
            return self.faces.find(grey), None
        place = state.place
        if place is None and self.face_tracking is not None:  # it was followed until now
            place = self._placed(image, state.link.face.box, rng)
        if isinstance(place, RegionState):
            place, told = self.face_tracking.step(place, grey)
            return told.boxes, place
        if isinstance(place, FaceFilterState):
            boxes = self.faces.find(grey)
            return boxes, self.face_tracking.step(place, image, boxes, rng=rng)[0]
        window = _around(state.link.face.box, self.rules.face_window)
        return self.faces.find(grey, window if _inside(window, grey) else None), None

    def _placed(
        self, image: np.ndarray, box: Box, rng: np.random.Generator
    ) -> RegionState | FaceFilterState | None:
        """Return what is known of a face at a place; nothing if that is outside of the picture."""
        if isinstance(self.face_tracking, FaceFilter):
            there = self.face_tracking.sees(image, box)
            return self.face_tracking.start(image, box, rng=rng) if there else None
        return None if self.face_tracking is None else self.face_tracking.start(box)

    def _above(self, link: Link | None, hand: Box) -> bool:
        """Tell whether the middle of a hand is above the upper edge of the tutor's face."""
        top = np.inf if link is None else link.face.box[1]
        return bool(hand[1] + hand[3] / 2 < top)

    def _whole(self, link: Link | None, grey: Grey) -> bool:
        """Tell whether the middles of all patches of the tutor lie in the picture."""
        if link is None:
            return False
        left, top, wide, high = body_of(link.face.box)
        patches = self.tracker.model.patches
        middles = (patches[:, :2] + patches[:, 2:] / 2) * high
        u, v = (np.array([left + wide / 2, top + high / 2]) + middles).T
        rows, columns = grey.shape
        return bool(((u > 0) & (u < columns - 1) & (v > 0) & (v < rows - 1)).all())

    def _entered(
        self, state: RobotState, image: np.ndarray, rng: np.random.Generator
    ) -> RobotState:
        """Return the state made ready: a hand that is up is an old one; begin to track."""
        state = replace(state, fresh=not self.rules.fresh, quiet=0, person=None)
        if state.name == "follow":
            if state.link is None:
                raise ValueError("interaction must lead to 'follow' with a link only, got none")
            body = body_of(state.link.face.box)
            return replace(state, person=self.tracker.start(image, body, rng=rng), place=None)
        return replace(state, link=None, place=None) if state.name == "wait" else state

    def _command(
        self, state: RobotState, face: Box | None, width: int, hidden: bool
    ) -> tuple[float, float]:
        """Return speed (m/s) and turn rate (rad/s): drive after the tutor, or turn to the face."""
        middle = (width - 1) / 2
        if self.follower is None or (hidden and self.rules.waits):
            return 0.0, 0.0
        if state.person is not None:
            left, _, wide, high = state.person.box
            return self.follower.command(left + wide / 2 - middle, high)
        if face is None:
            return 0.0, 0.0
        return 0.0, self.follower.command(_middle(face)[0] - middle, self.follower.height)[1]


def _asked(box: Box, answer: Recognition | str | None) -> SeenFace:
    """Return a face with what the recogniser says of it."""
    if isinstance(answer, Recognition):
        return SeenFace(box, answer.name, answer.descriptor)
    return SeenFace(box, answer)


def _box(place: RegionState | FaceFilterState | None, last: Box) -> Box:
    """Return the box of a face by what tracks it; the last one if nothing does."""
    box = None if place is None else place.box
    return last if box is None else box


def _middle(box: Box) -> tuple[float, float, float]:
    """Return column, row and side of a square."""
    return float(box[0] + box[2] / 2), float(box[1] + box[3] / 2), float(box[2])


def _around(box: Box, sides: float) -> Box:
    """Return the window that reaches so many sides from the middle of a face."""
    u, v, side = _middle(box)
    reach = sides * side
    return np.array([u - reach, v - reach, 2 * reach, 2 * reach])


def _inside(box: Box, grey: Grey) -> bool:
    """Tell whether a part of a box is in the picture."""
    rows, columns = grey.shape
    return bool(box[0] < columns - 1 and box[1] < rows - 1 and (box[:2] + box[2:] > 1).all())
