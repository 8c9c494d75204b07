"""What the studies share: a camera below a ceiling, and what it sees of patterns, exactly.

Exact sightings come from `data_synth`: it says at which pixels points of the ceiling are seen. They
have no error, so that what remains is that of the method.
"""

from collections.abc import Mapping
from functools import cache

import numpy as np
from jaxtyping import Float

from data_synth.ceiling import CeilingCamera, Mount, make_ceiling
from data_synth.wheels import Slip

PAPER = "ceiling-navigation"
MOUNT = Mount()
"""The camera of the chapter: 2.5 m below the ceiling, 320 × 240 px, f = 200 px, straight up."""
SCALE = MOUNT.height / MOUNT.focal
"""Z/f of this camera, m per px."""
CENTRE = MOUNT.middle
HALF = np.array([(MOUNT.size[0] - 1) / 2, (MOUNT.size[1] - 1) / 2]) * SCALE
"""How far ahead and to the left it sees the ceiling, m."""
BORDER = 30.0
"""A pattern is seen if its middle keeps that far off the border, px, as in the library's rules."""
NO_SLIP = Slip(0.0, 0.0, 0.0, 0.0)
ARROW = 0.5
"""Length of the arrow by which the heading of a pattern is seen, m."""

Sightings = dict[str, Float[np.ndarray, "4"]]


@cache
def looking(
    roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0, x: float = 0.0, y: float = 0.0,
    height: float = MOUNT.height,
) -> CeilingCamera:  # fmt: skip
    """Return a camera that tells where points are seen, mounted in another way than ours.

    Its pictures, which nobody takes, have four pixels.
    """
    mount = Mount(height, size=(2, 2), centre=CENTRE, roll=roll, pitch=pitch, yaw=yaw, x=x, y=y)
    return CeilingCamera(_bare(), mount)


@cache
def _bare():
    return make_ceiling("plain", rng=np.random.default_rng(0), side=2.0)


def seen(
    camera: CeilingCamera,
    pose: Float[np.ndarray, "3"],
    patterns: Mapping[str, Float[np.ndarray, "3"]],
    border: float = -np.inf,
) -> Sightings:
    """Return the exact sightings of patterns from a pose of the robot.

    Parameters
    ----------
    camera
        Of `looking`.
    pose : (3,)
        Of the robot, m and rad.
    patterns
        Their poses on the ceiling, m and rad, by name.
    border
        Those whose middle is not that far inside the picture are left out, px; none by default.
    """
    if not patterns:
        return {}
    there = np.array([*patterns.values()])
    tips = there[:, :2] + ARROW * np.stack([np.cos(there[:, 2]), np.sin(there[:, 2])], axis=-1)
    at, to = np.split(camera.points_seen(pose, np.concatenate([there[:, :2], tips])), 2)
    along = to - at
    size = np.hypot(*along.T) * SCALE / ARROW
    rows = np.column_stack([at, np.arctan2(along[:, 1], along[:, 0]), size])
    inside = np.abs(at - CENTRE) <= np.array(MOUNT.size) / 2 - 0.5 - border
    kept = inside.all(axis=1) & np.isfinite(rows).all(axis=1)
    return {name: row for name, row, k in zip(patterns, rows, kept, strict=True) if k}
