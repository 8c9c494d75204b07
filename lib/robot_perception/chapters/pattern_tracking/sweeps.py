"""Contours alone are ambiguous on clutter: both likelihoods over one sweep; section 1."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.ndimage import maximum_filter

from robot_perception.beliefs import ParticleSet
from robot_perception.ceiling.contours import find_edges
from robot_perception.ceiling.recognition import EdgeField, contour_log_likelihoods
from robot_perception.ceiling.tracker import Layers, PatternTracker, log_likelihoods
from robot_perception.chapters.pattern_tracking.scene import (
    RULES,
    SCORED,
    SIGMAS,
    START,
    Scene,
    errors,
    path,
    scene,
    seen,
)
from robot_perception.evaluation.intervals import bootstrap_mean
from robot_perception.evaluation.sweep import sweep
from robot_perception.particles import condensation
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "ceiling-navigation"
MEASURES = ("contours", "grey vectors")
PLAIN = 186
"""Grey value of a ground without clutter."""
LOST = 3.0
"""An error of so many σ, in the mean over the coordinates, is a loss; ours."""


@dataclass(frozen=True, slots=True)
class Config:
    """Likelihoods over places, and films.

    Parameters
    ----------
    seeds
        Of patch and ground.
    reach
        To each side of the pattern, px; a grid of `pitch` px.
    pitch
        px.
    films
        Seeds of films in which the pattern is followed by each likelihood.
    frames
        Of a film.
    cluttered
        Whether things are all round the patch.
    """

    seeds: tuple[int, ...] = SCORED
    reach: int = 60
    pitch: int = 2
    films: tuple[int, ...] = SCORED[:40]
    frames: int = 25
    cluttered: bool = True


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Modes and losses.

    Parameters
    ----------
    modes : (2, scenes)
        Number of places that stand out, by measure.
    lost : (2, films)
        Share of the pictures with the pattern lost.
    """

    modes: Float[np.ndarray, "2 scenes"]
    lost: Float[np.ndarray, "2 films"]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Sweep both likelihoods over each picture, and follow some patterns by each."""

    def task(seed: int, rng: np.random.Generator) -> list[int]:
        return [modes(surface) for surface in surfaces(seed, config, rng)]

    def follow(seed: int, rng: np.random.Generator) -> np.ndarray:
        return film(seed, config, rng)

    found = np.array(sweep(task, config.seeds, rng=rng)).T
    lost = np.array(sweep(follow, config.films, rng=rng)).T if config.films else np.empty((2, 0))
    return Result(found.astype(float), lost)


def ground(seed: int, config: Config) -> Scene:
    """Return the scene of a seed, with its ground or with a plain one."""
    one = scene(seed)
    return one if config.cluttered else replace(one, ground=np.full_like(one.ground, PLAIN))


def surfaces(
    seed: int, config: Config, rng: np.random.Generator
) -> Float[np.ndarray, "2 rows columns"]:
    """Return the logarithm of both likelihoods over x and y, all else true."""
    one, away = ground(seed, config), np.arange(-config.reach, config.reach + 1, config.pitch)
    pattern, image = one.pattern(), seen(one.picture(START), rng)
    places = np.tile(START, (len(away), len(away), 1))
    places[..., 0] += away
    places[..., 1] += away[:, None]
    flat = places.reshape(-1, 4)
    contours = contour_log_likelihoods(EdgeField(find_edges(image)), pattern, flat)
    C = Layers(image).correlations(pattern, flat, RULES.smoothing)
    return np.array([contours, log_likelihoods(C, pattern.decay, RULES)]).reshape(
        2, len(away), len(away)
    )


def modes(surface: Float[np.ndarray, "rows columns"]) -> int:
    """Return how many peaks rise above half the height from the median to the highest."""
    top = surface == maximum_filter(surface, size=5)
    return int((top & (surface > (np.median(surface) + surface.max()) / 2)).sum())


def film(seed: int, config: Config, rng: np.random.Generator) -> Float[np.ndarray, "2"]:
    """Return in which share of the pictures a pattern is lost, by contours and by vectors."""
    one, truth, draws = ground(seed, config), path(config.frames, rng), int(rng.integers(2**32))
    pattern, camera, lost = one.pattern(), rng, np.zeros(2)
    each = [np.random.default_rng(draws) for _ in MEASURES]
    tracker = PatternTracker(pattern, RULES)
    state = tracker.start(START)
    particles = state.particles
    for place in truth:
        image = seen(one.picture(place), camera)
        particles = by_contours(particles, EdgeField(find_edges(image)), pattern, each[0])
        state, info = tracker.step(state, image, rng=each[1])
        mean = particles.weights @ particles.states
        lost += [np.abs(errors(pose, place)).mean() > LOST for pose in (mean, info.pose)]
    return lost / len(truth)


def by_contours(
    particles: ParticleSet, field: EdgeField, pattern, rng: np.random.Generator
) -> ParticleSet:
    """Return the particles after a picture, weighed by contours: draw, move, weigh."""

    def move(states: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        moved = states + SIGMAS * rng.standard_normal(states.shape)
        moved[:, 3] = np.maximum(moved[:, 3], 0.05)
        return moved

    def weigh(states: np.ndarray) -> np.ndarray:
        return contour_log_likelihoods(field, pattern, states) / len(pattern.places)

    return condensation(particles, move, weigh, rng=rng)[0]


swept = Study(run, full=Config(), quick=Config(SCORED[:12], films=()), seed=36)


@swept.claim(
    "contours-ambiguous",
    paper=PAPER,
    place="§1",
    basis="substitute",
    statement="On clutter a pattern's contours fit several places.",
    paper_value="“representing patterns with only contour information may produce ambiguous "
    "measures”",
    method="Patches on cluttered grounds, the likelihood by distances to edges over 60 px to each "
    "side: peaks above half the height from its median to its highest. Mean over patches.",
    accepted=Accepted(2.0, np.inf, "more than one place", Origin.CHOICE),
    sabotage=Change("a plain ground", cluttered=False),
)
def ambiguous(result: Result) -> Finding:
    """Count the peaks of both likelihoods."""
    evidence = {"peaks, grey vectors": bootstrap_mean(result.modes[1])}
    if result.lost.size:
        for name, lost in zip(MEASURES, result.lost, strict=True):
            evidence[f"pictures with the pattern lost, {name}"] = bootstrap_mean(lost)
    return Finding(bootstrap_mean(result.modes[0]), evidence)
