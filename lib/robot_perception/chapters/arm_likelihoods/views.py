"""What figures and explorers show: one person who gestures, and what the cues make of it."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float, UInt8

from robot_perception.arms.likelihoods import Bodies, EdgeCue, mean_square, sampled
from robot_perception.chapters.arm_likelihoods import hiding, summing
from robot_perception.chapters.arm_likelihoods.colouring import COLUMNS, ROWS, field
from robot_perception.chapters.arm_likelihoods.scene import (
    AWAY,
    AWAYS,
    BEND,
    BENDS,
    CHOOSING,
    CLUTTER,
    PASSERS,
    Glance,
    glance,
    surfaces,
    swept,
)
from robot_perception.chapters.arm_likelihoods.silent import pose
from robot_perception.chapters.arm_likelihoods.sweeping import Peaks, mixed, peaks

SHOWN = CHOOSING[10]
"""Seed of the person that is shown; none that is scored."""
ACROSS, DOWN = tuple(range(10, 131, 20)), tuple(range(10, 91, 20))
"""Angles of the dragged arm, degrees: away from the body, and the elbow's."""
GAINS = (0.1, 0.25, 0.5, 0.75, 1.0, 2.0)
WALLS = {"bare": (0, 0), "cluttered": (CLUTTER, 0), "cluttered, people walk": (CLUTTER, PASSERS)}
"""What is behind the person."""


@lru_cache(maxsize=1)
def shown() -> Glance:
    """Return the person before a cluttered wall."""
    return glance(SHOWN, CLUTTER, PASSERS)


@lru_cache(maxsize=1)
def logs() -> dict[str, Float[np.ndarray, "aways bends"]]:
    """Return the surfaces of that person."""
    return surfaces(shown())


@lru_cache(maxsize=8)
def height(mix: str) -> Float[np.ndarray, "aways bends"]:
    """Return the likelihood of a mix over the sweep, its largest value 1."""
    log = mixed(logs(), mix)
    return np.exp(log - log.max())


def outline(
    of: Glance, state: Float[np.ndarray, " 8"]
) -> tuple[Float[np.ndarray, "n 2"], Bool[np.ndarray, " n"]]:
    """Return the silhouette of a pose, and which of its points are seen."""
    contours = of.model.contours(state[None])
    return contours.points[0], contours.visible[0]


@lru_cache(maxsize=1)
def hand_field() -> tuple[Float[np.ndarray, "rows columns"], np.ndarray, np.ndarray]:
    """Return where the hand's colours are in the picture that is shown, and the places."""
    return field(shown()), COLUMNS, ROWS


@dataclass(frozen=True, eq=False, slots=True)
class Dragged:
    """An arm that is dragged over the picture.

    Parameters
    ----------
    image : (240, 320, 3)
        The picture.
    points, visible : (n, 2), (n,)
        Silhouette of the arms.
    surface : (aways, bends)
        Likelihood of the mix, its largest value 1.
    at, true : (2,)
        Both angles, of the dragged arm and in truth, degrees.
    value
        Of the surface there.
    peaks
        Of the surface.
    """

    image: UInt8[np.ndarray, "240 320 3"]
    points: Float[np.ndarray, "n 2"]
    visible: Bool[np.ndarray, " n"]
    surface: Float[np.ndarray, "aways bends"]
    at: tuple[float, float]
    true: tuple[float, float]
    value: float
    peaks: Peaks

    def words(self) -> str:
        """Return what the drawing shows."""
        there = "at the true pose" if self.peaks.off <= np.radians(15) else "elsewhere"
        count = f"{self.peaks.count} peak{'s' if self.peaks.count > 1 else ''}"
        return (
            f"The dragged arm has {self.value:.2g} of the highest likelihood. The surface has "
            f"{count}; the highest one is {there}."
        )


def posed(away: float, bend: float) -> Float[np.ndarray, " 8"]:
    """Return the true pose with other angles of the arm on the left, given in degrees."""
    state = shown().angles.copy()
    state[[AWAY, BEND]] = np.radians([away, bend])
    return state


@lru_cache(maxsize=160)
def dragged(mix: str, away: float, bend: float) -> Dragged:
    """Return an arm that is dragged, and the surface of a mix."""
    of, surface = shown(), height(mix)
    points, visible = outline(of, posed(away, bend))
    k = int(np.abs(AWAYS - np.radians(away)).argmin())
    j = int(np.abs(BENDS - np.radians(bend)).argmin())
    true = tuple(np.degrees(of.angles[[AWAY, BEND]]).tolist())
    found = peaks(mixed(logs(), mix), of.angles)
    return Dragged(of.image, points, visible, surface, (away, bend), true,
                   float(surface[k, j]), found)  # fmt: skip


def hand_place(away: float, bend: float, **_others: object) -> tuple[float, float]:
    """Return where the hand of the dragged arm is in the picture."""
    model = shown().model
    joints = model.joints(posed(away, bend)[None])[0, 0]
    u, v = model.pixels(joints[2:].mean(axis=0))
    return float(u), float(v)


@dataclass(frozen=True, eq=False, slots=True)
class Gained:
    """What K does.

    Parameters
    ----------
    image : (240, 320, 3)
        The picture.
    distance : (240, 320)
        The smaller of both distances at each pixel, px.
    surface : (aways, bends)
        Likelihood over the sweep, its largest value 1.
    true : (2,)
        Both angles, degrees.
    peaks
        Of the surface.
    same
        Whether the distance is that to the nearest edge everywhere.
    """

    image: UInt8[np.ndarray, "240 320 3"]
    distance: Float[np.ndarray, "240 320"]
    surface: Float[np.ndarray, "aways bends"]
    true: tuple[float, float]
    peaks: Peaks
    same: bool

    def words(self) -> str:
        """Return what the drawing shows."""
        where = "at the true pose" if self.peaks.off <= np.radians(15) else "elsewhere"
        moves = "Motion changes nothing." if self.same else "Edges that move reach farther."
        return f"{moves} {self.peaks.count} peaks; the highest one is {where}."


@lru_cache(maxsize=64)
def gained(gain: float, wall: str, stops: bool) -> Gained:
    """Return the distances and the surface for a K."""
    of = glance(SHOWN, *WALLS[wall], stops)
    seen = of.seen
    distance = np.minimum(seen.static, gain * seen.moving) if seen.moves else seen.static
    bodies = Bodies(of.model, swept(of.angles))
    log = EdgeCue(gain=gain)(seen, bodies).reshape(len(AWAYS), -1)
    true = tuple(np.degrees(of.angles[[AWAY, BEND]]).tolist())
    same = bool((distance == seen.static).all())
    return Gained(of.image, distance, np.exp(log - log.max()), true, peaks(log, of.angles), same)


@lru_cache(maxsize=1)
def bumpy() -> dict[str, Float[np.ndarray, " steps"]]:
    """Return both scores of the arm that is turned, each from 0 to 1."""
    found = summing.scores(shown())
    return {name: (one - one.min()) / np.ptp(one) for name, one in found.items()}


@lru_cache(maxsize=1)
def hidden() -> tuple[Glance, Float[np.ndarray, " 8"], float]:
    """Return somebody before a bare wall, and a pose that hides an arm and is preferred."""
    for seed in CHOOSING:
        of = glance(seed)
        states = hiding.drawn(of, 4000, np.random.default_rng(seed))
        state, gain, _ = hiding.best_hidden(of, states, "as printed")
        if gain > 0:
            return of, state, gain
    raise RuntimeError("nobody's hidden arm is preferred")  # pragma: no cover


@lru_cache(maxsize=2)
def straight(bend: float) -> tuple[Float[np.ndarray, " turns"], Float[np.ndarray, " turns"]]:
    """Return turns of the upper arm about its axis, degrees, and how far the wrist moves, px."""
    model = shown().model
    turns = np.arange(-90.0, 91.0, 5.0)
    states = np.tile(pose(bend), (len(turns), 1))
    states[:, 2] += np.radians(turns)
    points = model.contours(states).points[:, : model.points // 2]
    middle = points[len(turns) // 2]
    return turns, np.linalg.norm(points - middle, axis=-1).max(axis=1)


def loop() -> tuple[Glance, Float[np.ndarray, "m 8"]]:
    """Return the person before a bare wall, and the states of the sweep."""
    of = glance(SHOWN)
    return of, swept(of.angles)


def library_score(of: Glance, states: Float[np.ndarray, "m 8"]) -> Float[np.ndarray, " m"]:
    """Return what the library makes of silhouettes on static edges, hidden points priced."""
    contours = of.model.contours(states)
    far = sampled(of.seen.static, contours, of.seen.most)
    return mean_square(far, contours.visible, EdgeCue().sigma, EdgeCue().price)
