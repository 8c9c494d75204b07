"""Patterns on a ceiling: correlations of grey vectors at the places of particles, a step."""

import cv2
import numpy as np

from robot_perception.ceiling.contours import find_contours, find_edges
from robot_perception.ceiling.patterns import (
    Pattern,
    correlations,
    decay_in_picture,
    fit_decay,
    grey_vectors,
    make_pattern,
)
from robot_perception.ceiling.recognition import EdgeField, recognise
from robot_perception.ceiling.tracker import PatternTracker, TrackerRules
from tests.ceiling.pictures import cluttered, smooth
from tests.tools.benchmarks.harness import Row

PARTICLES, VECTORS, SAMPLES = 200, 200, 11
LEAST_RATE = 100e6
"""Grey values that are to be taken and compared in a second."""
START = np.array([160.0, 120.0, 0.0, 1.0])


def _pattern(image: np.ndarray) -> Pattern:
    """Return a pattern of so many vectors, at places drawn in its window."""
    rng = np.random.default_rng(1)
    places = np.column_stack(
        [rng.uniform(-0.5, 0.5, (VECTORS, 2)), rng.uniform(-np.pi, np.pi, VECTORS)]
    )
    points, phi = START[:2] + 64 * places[:, :2], places[:, 2]
    decay = fit_decay(decay_in_picture(image, points, phi, samples=SAMPLES))
    return Pattern(places, grey_vectors(image, points, phi, samples=SAMPLES), decay, (64, 64))


def _where(pattern: Pattern, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return where all samples of all poses lie: twice (poses, vectors, samples)."""
    k = np.arange(SAMPLES) - SAMPLES // 2
    phi = pattern.places[:, 2] + poses[:, 2:3]
    points, reach = pattern.seen(poses), k * poses[:, 3, None, None] * pattern.step
    u = points[..., 0, None] + reach * np.cos(phi)[..., None]
    return u, points[..., 1, None] + reach * np.sin(phi)[..., None]


def _compared(grey: np.ndarray, pattern: Pattern) -> np.ndarray:
    """Return the correlations of vectors with grey values (poses, vectors, samples)."""
    grey = grey - grey.mean(axis=2, keepdims=True)
    V = pattern.vectors - pattern.vectors.mean(axis=1, keepdims=True)
    lengths = np.sqrt(np.einsum("ijk,ijk->ij", grey, grey)) * np.linalg.norm(V, axis=1)
    return np.einsum("ijk,jk->ij", grey, V) / lengths


def _likelihoods() -> list[Row]:
    image = smooth(0, 5.0)
    pattern, layer = _pattern(image), image.astype(np.float32)
    rng = np.random.default_rng(2)
    poses = START + rng.standard_normal((PARTICLES, 4)) * (5, 5, np.deg2rad(3), 0.1)

    def ours() -> np.ndarray:
        return correlations(layer[None], pattern, poses)

    def gather() -> np.ndarray:
        u, v = _where(pattern, poses)
        column, row = u.astype(int), v.astype(int)
        right, down = u - column, v - row
        above = layer[row, column] * (1 - right) + layer[row, column + 1] * right
        below = layer[row + 1, column] * (1 - right) + layer[row + 1, column + 1] * right
        return _compared(above * (1 - down) + below * down, pattern)

    def remap() -> np.ndarray:
        u, v = (part.reshape(PARTICLES, -1).astype(np.float32) for part in _where(pattern, poses))
        grey = cv2.remap(layer, u, v, cv2.INTER_LINEAR)
        return _compared(grey.reshape(PARTICLES, VECTORS, SAMPLES), pattern)

    def agree(peer, bound: float) -> None:
        away = np.abs(ours() - peer())
        assert np.median(away) <= 0.1 * bound, np.median(away)
        assert np.quantile(away, 0.999) <= bound, np.quantile(away, 0.999)

    work = f"pattern correlations, {PARTICLES} particles × {VECTORS} vectors × {SAMPLES} samples"
    most = PARTICLES * VECTORS * SAMPLES / LEAST_RATE
    return [
        Row(
            work=work,
            ours=ours,
            peer=peer,
            peer_name=name,
            at_most=most,
            agree=lambda peer=peer, bound=bound: agree(peer, bound),
            inner=5,
        )
        # OpenCV rounds places to a 32nd of a pixel
        for peer, name, bound in ((gather, "NumPy gather", 1e-3), (remap, "cv2.remap", 0.1))
    ]


def _step() -> Row:
    image = smooth(0, 5.0)
    tracker = PatternTracker(_pattern(image), TrackerRules(particles=PARTICLES))
    state = tracker.start(START)

    def agree() -> None:
        after, info = tracker.step(state, image, rng=np.random.default_rng(3))
        assert np.hypot(*(after.pose - START)[:2]) <= 5
        assert not info.lost

    rng = np.random.default_rng(4)
    return Row(
        work=f"pattern tracking 320×240: one image, {PARTICLES} particles × {VECTORS} vectors",
        ours=lambda: tracker.step(state, image, rng=rng),
        at_most=1 / 100,
        agree=agree,
        inner=5,
    )


def _recognition() -> Row:
    image = cluttered(3)
    pattern = make_pattern(image, START[:2], (90, 90))

    def ours() -> tuple:
        edges = find_edges(image)
        return recognise(pattern, EdgeField(edges), find_contours(edges))

    def agree() -> None:
        best = ours()[0]
        assert np.hypot(*(best.pose - START)[:2]) <= 1.5

    return Row(
        work="pattern found anew in 320×240: edges, contours, candidates", ours=ours, agree=agree
    )


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern patterns on a ceiling."""
    return [*_likelihoods(), _step(), _recognition()]
