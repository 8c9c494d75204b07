"""Motion of a stereo camera between two pairs of pictures, from the points that both show."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks
from robot_perception.cameras import Pinhole
from robot_perception.extras import needing
from robot_perception.landmarks.tracking import Sighting

with needing():
    import cv2

LEAST = 6
"""Points without which there is no motion to be told from chance."""


@dataclass(frozen=True, eq=False, slots=True)
class StereoMotion:
    """A motion of the camera, and what it stands on.

    Parameters
    ----------
    T_now_before : (4, 4)
        Pose of the camera before the motion in its frame after it, m.
    used : (n,)
        Which features of the later pair it stands on.
    """

    T_now_before: Float[np.ndarray, "4 4"]
    used: Bool[np.ndarray, " n"]


def stereo_motion(
    before: Sighting, now: Sighting, camera: Pinhole, *, reach_px: float = 2.0
) -> StereoMotion | None:
    r"""Return the motion between two pairs by the features that go on from one to the next.

    .. math:: \min_T \sum_{i \in I} |u_i - \pi(T p_i)|^2

    with p the points of the earlier pair, u their pixels in the later left picture and I the
    largest set of them that agrees on a motion to within ``reach_px``, as far as a hundred samples
    of four find it.

    Parameters
    ----------
    before, now
        What the two pairs show, by `sight`.
    camera
        The left camera.
    reach_px
        How far a point may be from where the motion puts it, px.

    Returns
    -------
    StereoMotion or None
        Nothing where fewer than six features agree.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If ``now`` does not follow ``before``, or the reach is not positive.
    """
    points = checks.instance("before", before, Sighting).points.points.mean
    origins = checks.instance("now", now, Sighting).tracks.origins
    checks.instance("camera", camera, Pinhole)
    reach = checks.positive("reach_px", reach_px)
    if origins.max(initial=-1) >= len(points):
        raise ValueError(f"now must follow before, which has {len(points)} points")
    rows = np.flatnonzero(origins >= 0)
    if len(rows) < LEAST:
        return None
    seen, pixels = points[origins[rows]], now.points.features.pixels[rows].astype(float)
    lens = camera.matrix, np.array(camera.distortion)
    found, turn, shift, agree = cv2.solvePnPRansac(
        seen, pixels, *lens, reprojectionError=min(reach, 1e6), flags=cv2.SOLVEPNP_EPNP
    )
    if not found or agree is None or len(agree) < LEAST:
        return None
    agree = agree.ravel()
    turn, shift = cv2.solvePnPRefineLM(seen[agree], pixels[agree], *lens, turn, shift)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = cv2.Rodrigues(turn)[0], shift.ravel()
    used = np.zeros(len(origins), dtype=bool)
    used[rows[agree]] = True
    return StereoMotion(T, used)
