"""The camera that films coloured things, and what it gives: images and the truth about a target."""

from dataclasses import dataclass

import numpy as np

from data_synth._checks import number, whole

WIDTH, HEIGHT = 320, 240  # of all images, pixels


@dataclass(frozen=True, slots=True)
class Camera:
    """A colour camera; all values are ours.

    Parameters
    ----------
    read_noise
        Deviation of the noise in the dark, shares of full light.
    photon_noise
        Variance of the noise for a share of full light.
    blur
        Share of the time between frames that the shutter is open: motion within it blurs.
    parts
        How many moments stand for the time of an exposure.
    softness
        Deviation of the blur by the lens, pixels.
    """

    read_noise: float = 0.003
    photon_noise: float = 0.0003
    blur: float = 0.5
    parts: int = 4
    softness: float = 0.4

    def __post_init__(self) -> None:
        number("read_noise", self.read_noise, 0.0, 1.0)
        number("photon_noise", self.photon_noise, 0.0, 1.0)
        number("blur", self.blur, 0.0, 1.0)
        whole("parts", self.parts, 1, 64)
        number("softness", self.softness, 0.0, 10.0)


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
