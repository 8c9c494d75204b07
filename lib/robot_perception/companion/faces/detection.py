"""Faces found by OpenCV's boosted cascade of Haar-like features."""

from dataclasses import dataclass, field
from typing import Annotated, Any, final

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.companion.boxes import grey_picture, known_sides, within
from robot_perception.extras import needing
from robot_perception.fields import above, checked, from_to

with needing():
    import cv2

__all__ = ["FaceDetector"]

FRONTAL = "haarcascade_frontalface_default.xml"
SMALLEST = 24
"""Side of the cascade's window, px: it finds no smaller face."""


@final
@dataclass(frozen=True, eq=False, slots=True)
class FaceDetector:
    """OpenCV's detector of frontal faces.

    Parameters
    ----------
    scale
        From each size of the window to the next.
    neighbours
        How many windows must agree on a face.
    least, most
        Sides of the smallest and the largest face that is looked for, px.
    enlarge
        How many times the picture is made larger first: faces that are hardly larger than the
        cascade's window of 24 px are missed often, and one that is smaller always.

    Raises
    ------
    ValueError
        If the least side is below that of the cascade, 24 px in the enlarged picture, or above the
        largest.

    References
    ----------
    Viola and Jones, "Rapid object detection using a boosted cascade of simple features", CVPR 2001,
    in the implementation of Lienhart and Maydt (2002). Scale and neighbours are OpenCV's usual
    ones; the paper names none.
    """

    scale: Annotated[float, above(1, 10)] = 1.1
    neighbours: Annotated[int, from_to(0, 1000)] = 4
    least: int = SMALLEST
    most: int = 10_000
    enlarge: Annotated[int, from_to(1, 4)] = 1
    _cascade: Any = field(init=False, repr=False)

    def __post_init__(self) -> None:
        checked(self)
        low = SMALLEST // self.enlarge
        most = checks.whole("most", self.most, low, 10**6)
        checks.whole("least", self.least, low, most)
        cascade = cv2.CascadeClassifier(cv2.data.haarcascades + FRONTAL)
        object.__setattr__(self, "_cascade", cascade)

    def __reduce__(self) -> tuple:
        """Make it anew in another process: OpenCV's cascade cannot be sent there."""
        given = (self.scale, self.neighbours, self.least, self.most, self.enlarge)
        return FaceDetector, given

    def find(
        self,
        image: UInt8[np.ndarray, "height width"],
        window: Float[np.ndarray, " 4"] | None = None,
        sides: tuple[float, float] | None = None,
    ) -> Float[np.ndarray, "n 4"]:
        """Return the boxes of the faces, the largest first.

        Parameters
        ----------
        image : (height, width)
            Grey values.
        window : (4,), optional
            The part of the picture to look into: left, top, width and height, px. What of it lies
            outside of the picture is left out.
        sides
            Smallest and largest side of a face, px, where they are known better than ``least`` and
            ``most``: most of the work goes into the smallest.

        Returns
        -------
        (n, 4)
            Left, top, width and height in the picture, px; none if there is no face, or the window
            is smaller than the smallest face.

        Raises
        ------
        TypeError
            If the image does not hold bytes.
        ValueError
            If it is in colour or empty, the window has no area, or the sides do not rise.
        """
        least, most = known_sides(sides, self.least, self.most)
        image = grey_picture("image", image)
        image, corner = within(image, window)
        if min(image.shape) < least:
            return np.zeros((0, 4))
        image, times = np.ascontiguousarray(image), self.enlarge
        if times > 1:
            image = cv2.resize(image, None, fx=times, fy=times, interpolation=cv2.INTER_CUBIC)
        found = self._cascade.detectMultiScale(
            image,
            scaleFactor=self.scale,
            minNeighbors=self.neighbours,
            minSize=(times * least, times * least),
            maxSize=(times * most, times * most),
        )
        boxes = np.asarray(found, dtype=float).reshape(-1, 4) / times
        boxes[:, :2] += corner
        return boxes[np.lexsort((boxes[:, 1], boxes[:, 0], -boxes[:, 2]))]
