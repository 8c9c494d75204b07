"""Places, views and features of which everything is known."""

import numpy as np

from data_synth.stereo import Scene, Surface, make_scene
from robot_perception.book.sift_association import PLACE, Views
from robot_perception.landmarks import Features


def places(points, *, carriers=0, prints=None, sizes=0.01, angles=0.0) -> np.ndarray:
    """Return places; what is not told is the same for all."""
    points = np.reshape(np.asarray(points, dtype=float), (-1, 3))
    out = np.empty(len(points), PLACE)
    out["points"], out["carriers"], out["sizes"], out["angles"] = points, carriers, sizes, angles
    shown = np.column_stack([0 * points[:, 0], points[:, :2]]) if prints is None else prints
    shown = np.reshape(shown, (-1, 3))
    out["pictures"], out["spots"] = shown[:, 0], shown[:, 1:]
    return out


def clear_views(count: int, rng: np.random.Generator, *, frames=5, tests=4, noise=2.0) -> Views:
    """Return landmarks a metre apart that look nothing like each other, and tests of each."""
    own = rng.integers(20, 200, size=(count, 128)).astype(float)
    marks = places(np.arange(count)[:, None] * [1.0, 0, 0])
    stacks = own[:, None] + noise * rng.standard_normal((count, frames, 128))
    rows = np.repeat(np.arange(count), tests)
    found = own[rows] + noise * rng.standard_normal((len(rows), 128))
    return Views(
        np.rint(stacks).astype(np.uint8),
        marks,
        np.rint(found).astype(np.uint8),
        marks[rows],
        np.zeros(len(rows)),
    )


def features(pixels, *, scales=2.0, angles=0.0, descriptors=None) -> Features:
    """Return features at pixels."""
    pixels = np.reshape(np.asarray(pixels, dtype=float), (-1, 2))
    n = len(pixels)
    look = np.zeros((n, 128)) if descriptors is None else np.asarray(descriptors, dtype=float)
    return Features(
        pixels,
        look.astype(np.float32),
        np.broadcast_to(scales, n).astype(float),
        np.broadcast_to(angles, n).astype(float),
    )


def tiled_wall(picture: np.ndarray) -> Scene:
    """Return a wall across the way, x = 4 m, 6 m wide and 3 m high, on which a picture stands
    three times beside itself and twice above.
    """
    edges = np.array([0.0, -6.0, 0.0]), np.array([0.0, 0.0, -3.0])
    wall = Surface(np.array([4.0, 3.0, 3.0]), *edges, 0, tiles=(3.0, 2.0))
    return make_scene([wall], [picture])
