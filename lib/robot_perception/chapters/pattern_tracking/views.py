"""What explorers and figures show of one patch on one ground."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception.ceiling.patterns import (
    Decay,
    Pattern,
    decay_in_picture,
    fit_decay,
    grey_vectors,
)
from robot_perception.ceiling.tracker import PatternTracker
from robot_perception.chapters.pattern_tracking import sweeps
from robot_perception.chapters.pattern_tracking.hidden import TOLERANCES, cover
from robot_perception.chapters.pattern_tracking.scene import (
    RULES,
    SIGMAS,
    START,
    errors,
    path,
    scene,
    seen,
)

SHOWN = 305
"""The patch and the ground that the page shows: a sign, the sixth of those that are scored."""
OTHER = 311
"""The ground whose things cover the patch."""
FRAMES = 60
"""Of the film."""


@dataclass(frozen=True, eq=False, slots=True)
class Sought:
    """A pattern that has moved, and where the particles say it is.

    Parameters
    ----------
    image : (rows, columns)
        The picture.
    truth, pose : (4,)
        Where the patch is, and the estimate.
    start : (4,)
        Where it was in the picture before.
    drawn : (n, 2)
        Where particles were drawn, px.
    spread
        σ of the walk, px.
    """

    image: UInt8[np.ndarray, "rows columns"]
    truth: Float[np.ndarray, " 4"]
    pose: Float[np.ndarray, " 4"]
    start: Float[np.ndarray, " 4"]
    drawn: Float[np.ndarray, "n 2"]
    spread: float

    @property
    def error(self) -> float:
        """Distance of the estimate from the truth, px."""
        return float(np.hypot(*(self.pose - self.truth)[:2]))

    @property
    def away(self) -> float:
        """How far the pattern has moved, σ of the walk."""
        return float(np.hypot(*(self.truth - self.start)[:2])) / self.spread

    def words(self) -> str:
        """Return what the drawing shows."""
        return (
            f"A picture full of things; the pattern has moved {self.away:.1f} σ. The estimate is "
            f"{self.error:.0f} px from it."
        )


@lru_cache(maxsize=256)
def sought(dx: int, dy: int, spread: float, particles: int) -> Sought:
    """Return what one step makes of a pattern that has moved by (dx, dy) px."""
    one, truth = scene(SHOWN), START + np.array([dx, dy, 0, 0])
    sigmas = SIGMAS * spread / SIGMAS[0]
    rules = replace(RULES, sigmas=tuple(sigmas.tolist()), particles=particles)
    tracker = PatternTracker(shown(), rules)
    image = seen(one.picture(truth), np.random.default_rng(1))
    _, info = tracker.step(tracker.start(START), image, rng=np.random.default_rng(2))
    walk = START[:2] + spread * np.random.default_rng(3).standard_normal((200, 2))
    return Sought(image, truth, info.pose, START, walk, spread)


@dataclass(frozen=True, eq=False, slots=True)
class Vector:
    """One grey vector of the pattern.

    Parameters
    ----------
    image : (rows, columns)
        The window and what is round it.
    points : (n, 2)
        All points of the pattern, px in that picture.
    at
        Which of them.
    line : (samples, 2)
        Where its grey values are taken.
    greys : (samples,)
        The vector.
    fall : (lags,)
        Its correlation with those beside it in the picture.
    decay
        Fitted to that: a line.
    """

    image: UInt8[np.ndarray, "rows columns"]
    points: Float[np.ndarray, "n 2"]
    at: int
    line: Float[np.ndarray, "samples 2"]
    greys: Float[np.ndarray, " samples"]
    fall: Float[np.ndarray, " lags"]
    decay: Decay

    @property
    def rate(self) -> float:
        """Slope of the fitted line, a sample."""
        return float(self.decay.rate[0])

    def words(self) -> str:
        """Return what the drawing shows."""
        return (
            f"Point {self.at} of the pattern: grey values along the gradient, and their "
            f"correlation with those beside them, which falls by {self.rate:.2f} a sample."
        )


@lru_cache(maxsize=128)
def vector(at: int) -> Vector:
    """Return a grey vector of the pattern that is shown."""
    one, pattern = scene(SHOWN), shown()
    image, reach = one.picture(START), 46
    points, phi = pattern.seen(START), pattern.places[:, 2]
    corner = (START[:2] - reach).astype(int)
    part = image[corner[1] : corner[1] + 2 * reach + 1, corner[0] : corner[0] + 2 * reach + 1]
    samples, step = pattern.vectors.shape[1], pattern.step
    here, way = points[at][None], phi[at : at + 1]
    off = step * (np.arange(samples) - samples // 2)[:, None]
    line = here - corner + off * [np.cos(way[0]), np.sin(way[0])]
    kinds = {"samples": samples, "step": step}
    fall = decay_in_picture(image, here, way, **kinds)
    greys = grey_vectors(image, here, way, **kinds)[0]
    return Vector(part, points - corner, at, line, greys, fall[0], fit_decay(fall))


@lru_cache(maxsize=1)
def shown() -> Pattern:
    """Return the pattern that is shown."""
    return scene(SHOWN).pattern()


@lru_cache(maxsize=1)
def surfaces() -> Float[np.ndarray, "2 rows columns"]:
    """Return both likelihoods over the ground that is shown, each from 0 at its median to 1."""
    found = sweeps.surfaces(SHOWN, sweeps.Config(), np.random.default_rng(1))
    middle = np.median(found, axis=(1, 2), keepdims=True)
    return (found - middle) / (found.max(axis=(1, 2), keepdims=True) - middle)


@dataclass(frozen=True, eq=False, slots=True)
class Hidden:
    """A pattern that is partly covered.

    Parameters
    ----------
    image : (rows, columns)
        The picture.
    truth, pose : (4,)
        Where it is, and the estimate.
    points : (n, 2)
        Of the pattern, at the estimate.
    good : (n,)
        Whether the deviation of each is below the threshold.
    lost
        Whether more are bad than are tolerated.
    """

    image: UInt8[np.ndarray, "rows columns"]
    truth: Float[np.ndarray, " 4"]
    pose: Float[np.ndarray, " 4"]
    points: Float[np.ndarray, "n 2"]
    good: np.ndarray
    lost: bool

    @property
    def error(self) -> float:
        """Mean error of the coordinates, σ."""
        return float(np.abs(errors(self.pose, self.truth)).mean())

    def words(self) -> str:
        """Return what the drawing shows."""
        return (
            f"A pattern, partly covered. {int((~self.good).sum())} of {len(self.good)} vectors "
            f"are bad; the estimate is {self.error:.2f} σ off."
        )


@lru_cache(maxsize=128)
def hidden(share: float, tolerance: str, side: int) -> Hidden:
    """Return what many particles make of a pattern of which a share is covered."""
    one, truth = scene(SHOWN), START + SIGMAS * [0.6, -0.5, 0.4, 0.3]
    image = cover(one.picture(truth), scene(OTHER).ground, truth, share, side)
    rules = replace(TOLERANCES[tolerance], particles=3000)
    tracker, pattern = PatternTracker(shown(), rules), shown()
    image = seen(image, np.random.default_rng(1))
    _, info = tracker.step(tracker.start(START), image, rng=np.random.default_rng(2))
    return Hidden(image, truth, info.pose, pattern.seen(info.pose), info.good, bool(info.lost))


@dataclass(frozen=True, eq=False, slots=True)
class Film:
    """A film and what the tracker makes of it.

    Parameters
    ----------
    images : (frames, rows, columns)
        Pictures.
    truth, poses : (frames, 4)
        Where the patch is, and the estimates.
    particles : (frames, n, 2)
        Where particles are after each picture, px.
    correlation : (frames,)
        Mean over the vectors at the estimate.
    """

    images: UInt8[np.ndarray, "frames rows columns"]
    truth: Float[np.ndarray, "frames 4"]
    poses: Float[np.ndarray, "frames 4"]
    particles: Float[np.ndarray, "frames n 2"]
    correlation: Float[np.ndarray, " frames"]

    @property
    def off(self) -> Float[np.ndarray, " frames"]:
        """Mean error of the coordinates in each picture, σ."""
        return np.abs(errors(self.poses, self.truth)).mean(axis=1)


COVERED = range(28, 40)
"""Pictures of the film in which half of the pattern is covered."""
JUMP = 48
"""The picture in which the patch jumps by six σ."""


@lru_cache(maxsize=1)
def film() -> Film:
    """Follow the patch while it swings, is covered, and jumps."""
    rng, one = np.random.default_rng(5), scene(SHOWN)
    truth = path(FRAMES, rng)
    truth[JUMP:, 0] += 6 * SIGMAS[0] * np.sign(START[0] - truth[JUMP, 0])
    tracker = PatternTracker(shown(), RULES)
    state, images, poses, clouds, match = tracker.start(START), [], [], [], []
    for k, place in enumerate(truth):
        image = one.picture(place)
        if k in COVERED:
            image = cover(image, scene(OTHER).ground, place, 0.5, 0)
        images.append(seen(image, rng))
        state, info = tracker.step(state, images[-1], rng=rng)
        poses.append(info.pose)
        clouds.append(state.particles.states[:, :2])
        match.append(np.nanmean(info.correlation))
    return Film(*map(np.array, (images, truth, poses, clouds, match)))
