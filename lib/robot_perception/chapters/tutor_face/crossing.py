"""Films of two tutors and a stranger who change places, and the faces that are found in them."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, Int

from data_synth.companion.face_films import FaceScene, film_faces
from data_synth.companion.faces import FaceIdentity
from robot_perception.chapters.tutor_face.scene import (
    DETECTOR,
    EIGENIMAGES,
    SAME,
    cut,
    film,
    found,
    greys,
    person,
)
from robot_perception.companion.boxes import overlap
from robot_perception.companion.faces.eigenfaces import Eigenfaces, enrol
from robot_perception.teaching.results import kept

TUTORS = 2
"""Of three people in a film; the third one is a stranger."""
ENROLLED = 25
"""Pictures of each tutor at enrolment, each of another occasion; ours."""
SCENE = FaceScene(people=3, cross=True, glances=2.0, tall=(95.0, 125.0))
"""They stand and shift, look away at times, and change places once."""
ALONE = FaceScene(glances=1.0)


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """The faces that are found in a film.

    Parameters
    ----------
    frames : (k,)
        In which picture.
    boxes : (k, 4)
        Where.
    names : (k,)
        Which tutor each is taken for; -1 for a stranger.
    people : (k,)
        Who it truly is; -1 for what is no face.
    """

    frames: Int[np.ndarray, " k"]
    boxes: Float[np.ndarray, "k 4"]
    names: Int[np.ndarray, " k"]
    people: Int[np.ndarray, " k"]


def identities(seed: int) -> tuple[FaceIdentity, ...]:
    """Return the two tutors of a film and the stranger."""
    return tuple(person(10_000 * seed + k) for k in range(SCENE.people))


def gallery(seed: int) -> Eigenfaces:
    """Enrol both tutors, each by pictures of many occasions."""
    faces, names = [], []
    for k, who in enumerate(identities(seed)[:TUTORS]):
        for occasion in range(2 * ENROLLED):
            shown = film_faces(np.random.default_rng([seed, k, occasion]), 1, ALONE, (who,))
            grey = cv2.cvtColor(shown.frames[0], cv2.COLOR_RGB2GRAY)
            boxes = DETECTOR.find(grey)
            hit = found(boxes, shown.boxes[0, 0])
            if hit is not None and names.count(f"{k}") < ENROLLED:
                faces.append(cut(grey, boxes[hit]))
                names.append(f"{k}")
    return enrol(np.array(faces), names, EIGENIMAGES)


@kept
def seen(seed: int, frames: int) -> Seen:
    """Find and recognise all faces of a film."""
    shown, known = film(seed, frames, SCENE, identities(seed)), gallery(seed)
    rows = []
    for t, (grey, truth) in enumerate(zip(greys(shown), shown.boxes, strict=True)):
        for box in DETECTOR.find(grey):
            name = known.recognise(cut(grey, box)).name
            same = overlap(box[None], truth)[0]
            who = int(same.argmax()) if same.max() >= SAME else -1
            rows.append((t, box, -1 if name is None else int(name), who))
    return Seen(*(np.array(part) for part in zip(*rows, strict=True)))
