"""Posts along a loop, and a sensor that gives each post's place with an error of stated size.

The world of a controlled study: no walls, no scans, no question which post was seen. Written with
positions and noises only: no matrix, no filter, nothing shared with the library.
"""

from dataclasses import dataclass

import numpy as np

from data_synth._checks import array, generator, number

_START = 6.0  # of the drive, from the corner of the loop, at most, m


@dataclass(frozen=True, eq=False, slots=True)
class Posts:
    """Posts on both sides of a rectangular loop twice as long as wide.

    Parameters
    ----------
    landmarks : (n, 2)
        Places of the posts, m.
    loop : (4, 2)
        Corners of the loop, in the order in which it is driven, m; the drive starts at the origin.
    """

    landmarks: np.ndarray
    loop: np.ndarray


def make_posts(length: float, *, rng: np.random.Generator, apart: float = 3.0) -> Posts:
    """Return posts at random distances of 1 to 2 m from the loop, on either side in turn.

    Parameters
    ----------
    length
        Length of the rectangle, from 18 m to 1000 km.
    rng
        Source of the places.
    apart
        Distance along the loop between a post and the next, m.

    Raises
    ------
    ValueError
        If the loop is too short to turn in, or far too long.
    """
    length = number("length", length, 18.0, 1e6)
    apart = number("apart", apart, above=0.0)
    generator(rng)
    wide, high = length / 3, length / 6
    start = min(_START, wide / 2)
    loop = np.array([[-start, 0.0], [wide - start, 0.0], [wide - start, high], [-start, high]])
    ends = np.array([0.0, wide, wide + high, 2 * wide + high, length])
    along = np.arange(0.5 * apart, length, apart)
    place = np.stack([np.interp(along, ends, np.r_[side, side[0]]) for side in loop.T], axis=-1)
    leg = np.searchsorted(ends, along) - 1
    way = np.roll(loop, -1, axis=0) - loop
    left = np.stack([-way[:, 1], way[:, 0]], axis=-1) / np.hypot(*way.T)[:, None]
    side = rng.uniform(1.0, 2.0, along.size) * (-1.0) ** np.arange(along.size)
    return Posts(place + side[:, None] * left[leg], loop)


def glimpse(
    landmarks: np.ndarray,
    poses: np.ndarray,
    *,
    sigma: float,
    reach: float,
    rng: np.random.Generator,
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return which posts are seen from each pose, and where: ahead and leftward of the robot.

    Parameters
    ----------
    landmarks : (n, 2)
        Places of the posts, m.
    poses : (k, 3)
        Where the robot is, m and rad.
    sigma
        Deviation of each coordinate, m.
    reach
        Posts no farther away, in the half-plane ahead, are seen, m.
    rng
        Source of noise.
    """
    landmarks, poses = array("landmarks", landmarks, (None, 2)), array("poses", poses, (None, 3))
    number("sigma", sigma, 0.0)
    number("reach", reach, 0.0, finite=False)
    generator(rng)
    east = landmarks[:, 0] - poses[:, 0, None]
    north = landmarks[:, 1] - poses[:, 1, None]
    cos, sin = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
    points = np.stack([cos * east + sin * north, cos * north - sin * east], axis=-1)
    seen = (points[..., 0] > 0) & (np.hypot(points[..., 0], points[..., 1]) < reach)
    points = points + sigma * rng.standard_normal(points.shape)
    return [(np.flatnonzero(row), at[row]) for row, at in zip(seen, points, strict=True)]
