"""What a world of coloured things gives: images and the truth about their target."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Sequence:
    """Images of a target and where it truly is; points are columns and rows, pixels.

    Parameters
    ----------
    frames : (n, height, width, 3)
        Red, green and blue of 8 bits; the centres of pixels lie at whole numbers.
    masks : (n, height, width)
        Visible pixels of the target, in the middle of each exposure.
    extra : (n, height, width)
        Visible pixels of what belongs to the target and lies beside its outline: legs, a neck.
    outlines : (n, points, 2)
        Closed outline of the whole target, hidden parts and those beyond the image included; the
        first point is not repeated.
    light : (n, 3)
        Colour of the light on the target, shares of full light.
    rate
        Frames a second.
    """

    frames: np.ndarray
    masks: np.ndarray
    extra: np.ndarray
    outlines: np.ndarray
    light: np.ndarray
    rate: float = 15.0


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LampSequence(Sequence):
    """A rectangle near a lamp; places are right of, below and ahead of the camera, m.

    Parameters
    ----------
    corners : (n, 4, 3)
        Of the rectangle.
    lamp : (3,)
        Where the lamp is.
    """

    corners: np.ndarray
    lamp: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class HeadSequence(Sequence):
    """A head that turns, tilts, comes and goes.

    Parameters
    ----------
    ellipses : (n, 4)
        Centre (column, row), half width and half height of the upright ellipse with the head's
        extent, pixels.
    tilt : (n,)
        Of the head in the image plane, clockwise in the image, rad.
    yaw : (n,)
        0 for a face that looks into the camera, ±π for the back of the head, rad.
    depth : (n,)
        Of the middle of the head, m.
    visible : (n,)
        Share of the head that is in the image and not hidden.
    """

    ellipses: np.ndarray
    tilt: np.ndarray
    yaw: np.ndarray
    depth: np.ndarray
    visible: np.ndarray
