"""People before the robot's camera, those it knows, and the numbers that both chapters share."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from data_synth.companion.canvas import lay, photograph, room
from data_synth.companion.face_films import FaceFilm, FaceScene, film_faces
from data_synth.companion.faces import (
    FACE_BOX,
    FaceIdentity,
    FaceView,
    face_sprite,
    make_identity,
)
from robot_perception.companion.boxes import crop, overlap
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.teaching.tables import Table

SIZE = (240, 320)
CHOOSING = tuple(range(100, 140))
"""Seeds of people and films on which numbers were chosen."""
SCORED = tuple(range(5000, 5400))
"""Those that are scored."""
SAME = 0.4
"""A detection is of a face whose box it overlaps by that (intersection over union); ours."""
EIGENIMAGES = 20
"""Section III."""
DETECTOR = FaceDetector()


@dataclass(frozen=True, eq=False, slots=True)
class Portrait:
    """A picture of one person.

    Parameters
    ----------
    image : (240, 320)
        Grey values.
    box : (4,)
        The square that marks the face.
    """

    image: UInt8[np.ndarray, "240 320"]
    box: Float[np.ndarray, " 4"]


def look(
    rng: np.random.Generator, who: FaceIdentity, *, turn: float = 0.0, light: float = 1.0
) -> Portrait:
    """Return a picture of a person in a room, as one stands before a robot and talks.

    Parameters
    ----------
    rng
        Source of the room, the place, the expression, the lamp and the noise.
    who
        The person.
    turn
        By which the head is turned, rad; a few degrees come on top.
    light
        Brightness.
    """
    yaw = float(np.clip(turn + rng.normal(0, 0.1), -1.6, 1.6))
    view = FaceView(
        yaw=yaw,
        pitch=float(np.clip(rng.normal(0, 0.06), -0.3, 0.3)),
        smile=round(min(abs(float(rng.normal(0, 0.4))), 1.0), 1),
        opened=round(float(rng.uniform() < 0.15), 1),
        azimuth=float(rng.normal(0, 0.3)),
        elevation=float(rng.uniform(0.3, 0.7)),
        ambient=float(rng.uniform(0.45, 0.65)),
        light=float(light * rng.uniform(0.85, 1.15)),
    )
    tall = rng.uniform(95, 150)
    u, v = rng.uniform(0.35, 0.65) * SIZE[1], rng.uniform(0.42, 0.58) * SIZE[0]
    canvas = room(SIZE, rng=rng) * np.float32(light)
    lay(canvas, face_sprite(who, view), (u, v), tall)
    image = cv2.cvtColor(photograph(canvas, rng=rng), cv2.COLOR_RGB2GRAY)
    side = FACE_BOX[2] * tall
    middle = u + 0.15 * np.sin(yaw) * tall, v + (FACE_BOX[1] - 0.5) * tall
    return Portrait(image, np.array([middle[0] - side / 2, middle[1] - side / 2, side, side]))


def found(boxes: Float[np.ndarray, "n 4"], truth: Float[np.ndarray, " 4"]) -> int | None:
    """Return which box is of a face, if one is."""
    if not len(boxes):
        return None
    same = overlap(boxes, truth[None])[:, 0]
    return int(same.argmax()) if same.max() >= SAME else None


def person(seed: int, *, tone: int | None = None) -> FaceIdentity:
    """Return the person of a seed."""
    return make_identity(np.random.default_rng(seed), tone=tone)


@lru_cache(maxsize=16)
def film(
    seed: int, frames: int, scene: FaceScene, identities: tuple[FaceIdentity, ...] | None = None
) -> FaceFilm:
    """Return the film of a seed."""
    return film_faces(np.random.default_rng(seed), frames, scene, identities)


def greys(film: FaceFilm) -> list[UInt8[np.ndarray, "240 320"]]:
    """Return the grey pictures of a film."""
    return [cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY) for frame in film.frames]


def cut(image: UInt8[np.ndarray, "rows columns"], box: Float[np.ndarray, " 4"]) -> np.ndarray:
    """Return the face in a box, as the recogniser wants it."""
    return crop(image, box)


def setup_table() -> Table:
    """Return what the paper gives, what is ours, and what matters."""
    rows = {
        "detector": ("Viola and Jones", "OpenCV's cascade", "not tested"),
        "eigenimages": (f"{EIGENIMAGES}", f"{EIGENIMAGES}", "little above ten"),
        "size of a face": ("–", "46 by 56 px", "not tested"),
        "beyond which nobody is known": ("–", "95 % of the known accepted", "for strangers"),
        "pictures of a tutor at enrolment": ("–", "7", "not tested"),
        "noise of the Kalman filter": ("–", "2 px a picture²", "the window"),
    }
    return Table(rows, {"paper": "its values", "ours": "", "matters": ""})
