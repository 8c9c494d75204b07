"""The camera of the chapter, and the piece of ceiling that its film shows."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from data_synth.ceiling import Ceiling, Mount

MOUNT = Mount()
"""2.5 m below the ceiling, 320 × 240 px, f = 200 px, straight up."""
SCALE = MOUNT.height / MOUNT.focal
"""Z/f of this camera, m per px."""
CENTRE = np.array(MOUNT.middle)
"""Point at which the optical axis meets the picture, px."""
HALF = np.array([(MOUNT.size[0] - 1) / 2, (MOUNT.size[1] - 1) / 2]) * SCALE
"""Distances ahead and to the left to which it sees the ceiling, m."""
BORDER = 30.0
"""A pattern is seen if its middle keeps that far off the border, px, as in the library's rules."""
PER_METRE = 40
"""Pixels of a plan for a metre, at most."""


@dataclass(frozen=True, eq=False, slots=True)
class Plan:
    """A picture of a piece of ceiling, columns along x, and its left, right, lower and upper end.

    The ends are in metres, as axes ask for them whose y runs downwards.
    """

    image: UInt8[np.ndarray, "rows columns"]
    extent: tuple[float, float, float, float]


def plan(above: Ceiling, path: Float[np.ndarray, "n 3"], margin: float = 2.0) -> Plan:
    """Return the ceiling above a path, as it is."""
    ends = [path[:, :2].min(axis=0) - margin, path[:, :2].max(axis=0) + margin]
    (left, top), (right, bottom) = np.round(above.texels(np.array(ends))).astype(int)
    image = above.texture[top:bottom, left:right]
    share = PER_METRE * above.resolution
    small = cv2.resize(image, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    corners = np.array([[left, top], [right, bottom]]) - 0.5
    (west, north), (east, south) = above.places(corners)
    return Plan(small, (float(west), float(east), float(south), float(north)))


def painted(
    greys: UInt8[np.ndarray, "rows columns"], shown: np.ndarray, corner: Float[np.ndarray, "2"]
) -> Plan:
    """Return a painting of `robot_perception.ceiling.mosaic.paint` as a plan, half as large."""
    image = np.where(shown, greys, 255).astype(np.uint8)
    west, north = corner - SCALE / 2
    south, east = np.array(image.shape) * SCALE + [north, west]
    small = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    return Plan(small, (float(west), float(east), float(south), float(north)))
