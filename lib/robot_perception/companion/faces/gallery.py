"""A gallery of faces from pictures of people, and whom it takes a face in a picture for."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, final

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.companion.boxes import crop
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.companion.faces.eigenfaces import Eigenfaces, Recognition, enrol
from robot_perception.fields import checked, from_to

__all__ = ["Gallery"]

Grey = UInt8[np.ndarray, "height width"]


@final
@dataclass(frozen=True, eq=False, slots=True)
class Gallery:
    """People whose faces are known.

    Parameters
    ----------
    known
        Their face space.
    equalise
        Whether the grey values of a face are spread evenly, so that a dim picture is like a bright
        one.
    faceless
        Pictures in which no face was found when the gallery was made.
    """

    known: Eigenfaces
    equalise: bool = False
    faceless: Annotated[int, from_to(0)] = 0
    __post_init__ = checked

    @classmethod
    def learn(
        cls,
        people: Mapping[str, Iterable[Grey]],
        detector: FaceDetector,
        count: int = 20,
        *,
        accepted: float = 0.95,
        equalise: bool = False,
    ) -> "Gallery":
        """Return the gallery of the largest face in each picture.

        Parameters
        ----------
        people : name -> pictures, each (height, width)
            Grey values, of any sizes; they are asked for one by one.
        detector
            Finds the faces.
        count
            How many eigenimages; fewer where there are few faces.
        accepted
            See `enrol`.
        equalise
            See `Gallery`.

        Raises
        ------
        TypeError
            If an argument is of another type.
        ValueError
            If there is nobody, somebody has fewer than two pictures with a face, all faces are the
            same, or a number is out of range.
        """
        checks.instance("people", people, Mapping)
        checks.instance("detector", detector, FaceDetector)
        count, equalise = checks.whole("count", count, 1), checks.flag("equalise", equalise)
        faces: list[np.ndarray] = []
        names: list[str] = []
        faceless = 0
        for name, pictures in people.items():
            checks.instance("people", name, str)
            asked = checks.iterable(f"people[{name!r}]", pictures)
            found = [_largest(picture, detector, equalise) for picture in asked]
            own = [face for face in found if face is not None]
            if len(own) < 2:
                raise ValueError(
                    "people must have two pictures with a face each at least, got"
                    f" {len(own)} of {len(found)} of {name!r}"
                )
            faces, names = faces + own, names + [name] * len(own)
            faceless += len(found) - len(own)
        if not faces:
            raise ValueError("people must be one at least, got nobody")
        known = enrol(np.array(faces), names, max(min(count, len(faces) - 2), 1), accepted=accepted)
        return cls(known, equalise, faceless)

    def recognise(self, image: Grey, box: Float[np.ndarray, " 4"]) -> Recognition:
        """Return who a face in a picture may be.

        Parameters
        ----------
        image : (height, width)
            Grey values.
        box : (4,)
            Of the face: left, top, width, height, px.

        Raises
        ------
        TypeError, ValueError
            As `crop`.
        """
        return self.known.recognise(crop(image, box, equalise=self.equalise))


def _largest(picture: Grey, detector: FaceDetector, equalise: bool) -> np.ndarray | None:
    """Return the largest face in a picture as the recogniser wants it, none if there is none."""
    boxes = detector.find(picture)
    return crop(picture, boxes[0], equalise=equalise) if len(boxes) else None
