"""What explorers, figures and the film show of a gallery and of two films."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float, UInt8

from data_synth.companion.face_films import FaceScene
from robot_perception.chapters.tutor_face import bridging, identifying
from robot_perception.chapters.tutor_face.bridging import GLANCES, Followed
from robot_perception.chapters.tutor_face.identifying import ENROLLED, LATER, PEOPLE, STRANGERS
from robot_perception.chapters.tutor_face.scene import CHOOSING, DETECTOR, cut, film, greys, person
from robot_perception.companion.faces.eigenfaces import Eigenfaces, enrol

TUTORS = range(3)
"""Who is known to the robot of the page."""
FRAMES = 90
FILM = CHOOSING[1]
"""Seed of the film that is shown; none that is scored."""


@lru_cache(maxsize=64)
def space(count: int, accepted: float = 0.95) -> Eigenfaces:
    """Return the gallery of three tutors, with so many eigenimages."""
    pictures, names = identifying.shown()[0].part(TUTORS, range(ENROLLED))
    return enrol(pictures, names, count, accepted=accepted)


FACES = {
    "the first tutor": (0, ENROLLED),
    "the second tutor": (1, ENROLLED),
    "the third tutor": (2, ENROLLED),
    "a stranger": (PEOPLE, 0),
    "another stranger": (PEOPLE + 1, 0),
}
"""Who comes, and which picture of that person it is."""


@dataclass(frozen=True, eq=False, slots=True)
class Asked:
    """A face that is shown to the gallery.

    Parameters
    ----------
    face, rebuilt : (rows, columns)
        As the detector cuts it out, and what the eigenimages make of it.
    distances : (3,)
        To the nearest picture of each tutor.
    most
        Beyond which nobody is known.
    true
        Which tutor it is; ``None`` for a stranger.
    named
        Whom it is taken for; ``None`` for nobody.
    """

    face: Float[np.ndarray, "rows columns"]
    rebuilt: Float[np.ndarray, "rows columns"]
    distances: Float[np.ndarray, " 3"]
    most: float
    true: int | None
    named: int | None

    @property
    def right(self) -> bool:
        """Whether the answer is right, who comes known or not."""
        return self.true == self.named

    def words(self) -> str:
        """Return what the drawing shows."""
        who = "a stranger" if self.true is None else f"tutor {self.true + 1}"
        taken = "nobody" if self.named is None else f"tutor {self.named + 1}"
        return f"The face of {who}, its rebuilt picture, and three distances. Taken for {taken}."


@lru_cache(maxsize=256)
def asked(who: str, count: int, accepted: float) -> Asked:
    """Return what the gallery says of a face."""
    k, time = FACES[who]
    face = identifying.shown()[0].part(range(k, k + 1), range(time, ENROLLED + LATER))[0][0]
    gallery = space(count, accepted)
    seen = gallery.recognise(face)
    whose = np.array(gallery.names)
    each = gallery.distances(seen.descriptor)
    nearest = np.array([each[whose == f"person {n + 1}"].min() for n in TUTORS])
    named = None if seen.name is None else gallery.people.index(seen.name)
    true = k if k in TUTORS else None
    return Asked(face, gallery.rebuild(face), nearest, gallery.most_distance, true, named)


@dataclass(frozen=True, eq=False, slots=True)
class Met:
    """A picture of three people, and what the robot says of each face that it finds."""

    image: UInt8[np.ndarray, "240 320 3"]
    boxes: Float[np.ndarray, "n 4"]
    names: tuple[str | None, ...]


@lru_cache(maxsize=1)
def met() -> Met:
    """Return two people in a picture, of whom the robot knows one."""
    base = 1000 * identifying.GALLERY
    people = person(base), person(base + PEOPLE + STRANGERS - 1)
    shown = film(CHOOSING[7], 40, FaceScene(people=2, glances=0.0, tall=(120.0, 135.0)), people)
    for frame, grey in zip(shown.frames, greys(shown), strict=True):
        boxes = DETECTOR.find(grey)
        names = tuple(space(20).recognise(cut(grey, box)).name for box in boxes)
        if len(boxes) == 2 and sorted(name is None for name in names) == [False, True]:
            return Met(frame, boxes, names)
    raise ValueError("no picture of the film has one face that is known and one that is not")


@lru_cache(maxsize=1)
def filmed() -> tuple[UInt8[np.ndarray, "n 240 320 3"], Followed]:
    """Return the film that is shown, and what the filter makes of it."""
    pictures = film(FILM, FRAMES, GLANCES).frames
    return pictures, bridging.followed(FILM, FRAMES, GLANCES)
