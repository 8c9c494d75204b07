"""Polyline simplification against fastrdp and shapely."""

from collections.abc import Callable

import fastrdp
import numpy as np
import shapely

from robot_perception.walls import simplify, simplify_path_hull
from tests.benchmarks.harness import Row

TOLERANCE = 0.05


def scan_chain() -> np.ndarray:
    """A scan of 361 readings in a room of 6 m by 8 m, noise 2 cm."""
    rng = np.random.default_rng(0)
    angles = np.linspace(-np.pi / 2, np.pi / 2, 361)
    walls = np.minimum(3 / np.abs(np.cos(angles) + 1e-9), 4 / np.abs(np.sin(angles) + 1e-9))
    ranges = walls + rng.normal(0, 0.02, angles.size)
    return np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=-1)


def noisy_chain(n: int) -> np.ndarray:
    """A sine over ten metres with noise of 5 mm."""
    rng = np.random.default_rng(0)
    x = np.linspace(0, 10, n)
    return np.stack([x, np.sin(x) + rng.normal(0, 0.005, n)], axis=-1)


def zigzag_chain(n: int) -> np.ndarray:
    """The worst case: every split cuts off one vertex."""
    k = np.arange(n)
    return np.stack([k, np.where(k % 2, -1, 1) * (2 - k / n)], axis=-1)


def _same(chain: np.ndarray, ours: Callable) -> Callable[[], None]:
    def agree() -> None:
        expected = fastrdp.rdp_index(chain, TOLERANCE)
        np.testing.assert_array_equal(ours(chain, TOLERANCE), expected)

    return agree


def rows() -> list[Row]:
    """Return the rows of the benchmark table about walls."""
    scan, noisy, zigzag = scan_chain(), noisy_chain(10**6), zigzag_chain(10**5)
    scan_line, noisy_line = shapely.LineString(scan), shapely.LineString(noisy)
    return [
        Row(
            work="simplify a scan of 361 points",
            ours=lambda: simplify(scan, TOLERANCE),
            peer=lambda: fastrdp.rdp_index(scan, TOLERANCE),
            peer_name="fastrdp",
            ratio=0.5,
            agree=_same(scan, simplify),
            inner=2000,
        ),
        Row(
            work="simplify a scan of 361 points",
            ours=lambda: simplify(scan, TOLERANCE),
            peer=lambda: scan_line.simplify(TOLERANCE, preserve_topology=False),
            peer_name="shapely",
            inner=2000,
        ),
        Row(
            work="simplify a noisy line of 10⁶ points",
            ours=lambda: simplify(noisy, TOLERANCE),
            peer=lambda: fastrdp.rdp_index(noisy, TOLERANCE),
            peer_name="fastrdp",
            ratio=0.5,
            agree=_same(noisy, simplify),
        ),
        Row(
            work="simplify a noisy line of 10⁶ points",
            ours=lambda: simplify(noisy, TOLERANCE),
            peer=lambda: noisy_line.simplify(TOLERANCE, preserve_topology=False),
            peer_name="shapely",
        ),
        Row(
            work="simplify a zigzag of 10⁵ points with path hulls, check included",
            ours=lambda: simplify_path_hull(zigzag, TOLERANCE),
            peer=lambda: fastrdp.rdp_index(zigzag, TOLERANCE),
            peer_name="fastrdp",
            ratio=50,
            agree=_same(zigzag, simplify_path_hull),
            repeats=3,
        ),
    ]
