"""The robot's camera, pictures of a person with a raised hand, and the numbers of the chapter."""

from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from data_synth.companion.hall import RobotCamera, make_hall
from data_synth.companion.hands import make_hand
from data_synth.companion.visits import Stance, make_visitor, see
from robot_perception.chapters.tutor_following.training import stored
from robot_perception.companion.boxes import overlap
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.companion.hands.cascade import HandDetector
from robot_perception.companion.tutor import TutorRules
from robot_perception.teaching.tables import Table

CAMERA = RobotCamera()
SAME = 0.4
"""A box is at what it should be at if they overlap by that (intersection over union); ours."""
RULES = TutorRules(gate=0.3, whole_gate=0.4)
"""Of the tracker with several patches; the gates are chosen on the films to choose on."""
FACES = FaceDetector(scale=1.05, neighbours=2)
"""Faces are small at the distance at which a raised hand is in view: sizes 1.05 apart."""


@lru_cache(maxsize=1)
def hands() -> HandDetector:
    """Return the detector of open hands that this book has trained."""
    return HandDetector(stored().cascade)


@dataclass(frozen=True, eq=False, slots=True)
class Shot:
    """A picture of one person in a hall.

    Parameters
    ----------
    image : (240, 320, 3)
        Red, green and blue.
    hand, face : (4,)
        The squares round them; not a number where no hand is raised.
    tone
        Of the skin, from light to dark.
    """

    image: UInt8[np.ndarray, "240 320 3"]
    hand: Float[np.ndarray, " 4"]
    face: Float[np.ndarray, " 4"]
    tone: int

    @property
    def grey(self) -> UInt8[np.ndarray, "240 320"]:
        """The grey picture."""
        return cv2.cvtColor(self.image, cv2.COLOR_RGB2GRAY)


def shot(
    rng: np.random.Generator, *, tilt: float = 0.0, gesture: str = "open", raised: float = 1.0
) -> Shot:
    """Return a picture of somebody who raises a hand, above the head or beside it.

    Parameters
    ----------
    rng
        Source of the person, the hall, the places and the noise.
    tilt
        By which the hand is turned to either side, rad; three degrees or so come on top.
    gesture
        What the hand shows.
    raised
        How far it is up.
    """
    who, hall = make_visitor(rng), make_hall(rng)
    who = replace(who, hand=make_hand(rng, gesture, tone=who.identity.tone))
    x, y = rng.uniform((4.0, 4.0), (9.0, 6.0))
    heading = rng.uniform(-0.5, 0.5) + rng.choice([0, np.pi])
    ahead, left = rng.uniform((1.9, -0.4), (2.6, 0.2))
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    there = np.array([x, y]) + turn @ (ahead, left)
    stance = Stance(
        *(float(value) for value in there),
        raised=raised,
        beside=bool(rng.integers(2)),
        tilt=float(tilt * rng.choice([-1, 1]) + rng.normal(0, 0.05)),
    )
    light = float(rng.uniform(0.7, 1.2))
    seen = see(hall, CAMERA, np.array([x, y, heading]), [(who, stance)], rng=rng, light=light)
    return Shot(seen.image, seen.hands[0], seen.faces[0], who.identity.tone)


def at(boxes: Float[np.ndarray, "n 4"], truth: Float[np.ndarray, " 4"]) -> np.ndarray:
    """Tell which boxes are at something (n,); none is if it is not there."""
    if not len(boxes) or not np.isfinite(truth).all():
        return np.zeros(len(boxes), dtype=bool)
    return overlap(boxes, truth[None])[:, 0] >= SAME


def setup_table() -> Table:
    """Return what the paper gives, what is ours, and what matters."""
    rows = {
        "open hands, other windows": ("2000, 6000", "2000, 6000", "not tested"),
        "stages of the cascade": ("–", "13", "see the explorer"),
        "particles": ("–", f"{RULES.particles}", "not tested"),
        "patches": ("several", "4 and a silhouette", "see below"),
        "rate of adaptation": ("–", f"{RULES.rate:g} a picture", "see below"),
        "pictures that make an event": ("–", "3, most of them", "not tested"),
    }
    return Table(rows, {"paper": "its values", "ours": "", "matters": ""})
