"""Rays in a plan of straight faces and ellipses: what each meets first, and at what slant."""

import numpy as np

from data_synth._checks import array
from data_synth._kernels import kernel

_NEAR = 1e-9  # m; a ray does not meet what it starts from


def cast_outlines(
    origins: np.ndarray, directions: np.ndarray, faces: np.ndarray, ellipses: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return how far rays reach, what they meet and at what slant.

    Parameters
    ----------
    origins : (n, 2)
        Where the rays start, m; outside the ellipses, or they are not met.
    directions : (n,)
        Rad.
    faces : (f, 2, 2)
        Ends of faces that block from both sides, m.
    ellipses : (e, 5)
        Middle x and y, semi-axes, m, and direction of the first, rad.

    Returns
    -------
    distances, indices, slants : (n,)
        Infinite, -1 and 0 where a ray meets nothing; ellipses count on from the last face; the
        slant is the angle between the ray and the normal of what it meets, rad.

    Raises
    ------
    ValueError
        If the shapes are not as they should be or a semi-axis is not positive.
    """
    directions = array("directions", directions, (None,))
    origins = array("origins (one for each of directions)", origins, (len(directions), 2))
    faces = array("faces", faces, (None, 2, 2))
    ellipses = array("ellipses", ellipses, (None, 5))
    if not (ellipses[:, 2:4] > 0).all():
        raise ValueError(f"ellipses must have semi-axes above 0, got {ellipses[:, 2:4].min()}")
    distances = np.full(len(directions), np.inf)
    indices = np.full(len(directions), -1)
    slants = np.zeros(len(directions))
    _cast(origins, directions, faces, ellipses, distances, indices, slants)
    return distances, indices, slants


@kernel()
def _cast(origins, directions, faces, ellipses, distances, indices, slants):
    for k in range(len(directions)):
        x, y = origins[k]
        u, v = np.cos(directions[k]), np.sin(directions[k])
        first, which, straight = np.inf, -1, 1.0
        for f in range(len(faces)):
            ax, ay = faces[f, 0, 0] - x, faces[f, 0, 1] - y
            ex, ey = faces[f, 1, 0] - faces[f, 0, 0], faces[f, 1, 1] - faces[f, 0, 1]
            area = u * ey - v * ex
            if area == 0:
                continue
            away = (ax * ey - ay * ex) / area
            if not _NEAR < away < first:
                continue
            share = (ax * v - ay * u) / area
            if 0 <= share <= 1:
                first, which = away, f
                straight = abs(area) / np.sqrt(ex * ex + ey * ey)
        for e in range(len(ellipses)):
            a, b = ellipses[e, 2], ellipses[e, 3]
            cos, sin = np.cos(ellipses[e, 4]), np.sin(ellipses[e, 4])
            ox, oy = x - ellipses[e, 0], y - ellipses[e, 1]
            p, q = (cos * ox + sin * oy) / a, (cos * oy - sin * ox) / b  # on the unit circle
            r, s = (cos * u + sin * v) / a, (cos * v - sin * u) / b
            square, half, rest = r * r + s * s, p * r + q * s, p * p + q * q - 1
            inner = half * half - square * rest
            if inner < 0 or half >= 0 or rest <= 0:
                continue
            away = (-half - np.sqrt(inner)) / square
            if _NEAR < away < first:
                first, which = away, len(faces) + e
                nx, ny = (p + away * r) / a, (q + away * s) / b
                straight = -(nx * r * a + ny * s * b) / np.sqrt(nx * nx + ny * ny)
        distances[k], indices[k] = first, which
        if which >= 0:
            slants[k] = np.arccos(min(max(straight, 0.0), 1.0))
