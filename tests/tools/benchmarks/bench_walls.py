"""Polyline simplification against fastrdp and shapely."""

import time
from collections.abc import Callable

import fastrdp
import numpy as np
import shapely

from robot_perception.walls import simplify, simplify_path_hull
from tests.tools.benchmarks.harness import Row, Timing

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


def gear(n: int) -> np.ndarray:
    """Teeth from one millimetre to one metre: every two edges have overlapping boxes."""
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    radii = np.where(np.arange(n) % 2, 1.0, 0.001)
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=-1)


def spiral(n: int) -> np.ndarray:
    """Turns of a thousand vertices each."""
    angles = np.linspace(0, n * np.pi / 500, n)
    return np.stack([angles * np.cos(angles), angles * np.sin(angles)], axis=-1)


def turned(make: Callable[[int], np.ndarray]) -> Callable[[int], np.ndarray]:
    """Turn a chain out of the axes, so that neither x nor y shows at once that it is simple."""
    turn = np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    return lambda n: make(n) @ turn


def growth(name: str, make: Callable[[int], np.ndarray]) -> Timing:
    """Return the exponent of the time of path hulls, check included, against n.

    Over these sizes n log n itself shows 1.1; the limit lies 0.25 above, as the tree of edges and
    the hulls leave the processor's caches.
    """
    sizes = (8_000, 16_000, 32_000, 64_000, 128_000)
    chains = [make(n) for n in sizes]
    samples = []
    for _ in range(7):
        for chain in chains:  # in turn, so that a busy spell hits all sizes
            begin = time.perf_counter()
            simplify_path_hull(chain, TOLERANCE)
            samples.append(time.perf_counter() - begin)
    seconds = np.median(np.reshape(samples, (-1, len(sizes))), axis=0)
    exponent = float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
    return Timing(
        work=f"path hulls on {name} of {sizes[0]} to {sizes[-1]} points, check included: "
        f"exponent {exponent:.2f}",
        ours_s=float(seconds[-1]),
        peer_s=None,
        peer_name="",
        target="exponent ≤ 1.35",
        reached=exponent <= 1.35,
    )


def _same(chain: np.ndarray, ours: Callable) -> Callable[[], None]:
    def agree() -> None:
        expected = fastrdp.rdp_index(chain, TOLERANCE)
        np.testing.assert_array_equal(ours(chain, TOLERANCE), expected)

    return agree


def rows() -> list[Row | Timing]:
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
        growth("a gear", gear),
        growth("a spiral", spiral),
        growth("a turned zigzag", turned(zigzag_chain)),
        growth("a turned noisy line", turned(noisy_chain)),
    ]
