"""The pattern grows: smoothing by the predicted scale, section 3.3."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Float

from robot_perception.ceiling.patterns import Pattern, make_pattern
from robot_perception.ceiling.tracker import Layers, PatternTracker
from robot_perception.chapters.pattern_tracking.scene import (
    MIDDLE,
    RULES,
    SCORED,
    SIGMAS,
    START,
    WINDOW,
    errors,
    scene,
    seen,
)
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition, Origin

PAPER = "ceiling-navigation"
DETAIL = 4
"""Pixels of the patch for one of the first picture: what is finer than that one appears later."""
SCALES = (1.01, 1.25, 1.5, 2.0)
"""At which patterns are compared with their models."""
SMOOTHINGS: Mapping[str, tuple[str, bool]] = {
    "none": ("none", False),
    "σ = s": ("scale", False),
    "σ = √(s² − 1)": ("difference", False),
    "none, model by 1 px": ("none", True),
    "σ = s, model by 1 px": ("scale", True),
}
"""Of the picture, before a particle of scale s > 1 takes its vectors, and of the model."""


@dataclass(frozen=True, slots=True)
class Config:
    """Patches that grow, with detail that shows when they do.

    Parameters
    ----------
    seeds
        Of patch and ground.
    scales
        At which the pattern is compared with its model, at its true place.
    films
        Seeds of films in which it is tracked, too.
    frames
        Of a film, in which the pattern grows to the largest scale, by the same factor each time.
    """

    seeds: tuple[int, ...] = SCORED
    scales: tuple[float, ...] = SCALES
    films: tuple[int, ...] = SCORED[:24]
    frames: int = 20


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """How much vectors differ from their model, and how far off a tracker is.

    Parameters
    ----------
    config
        What was run.
    unlike : (smoothings, scenes, scales)
        1 − C at the true place, mean over the vectors.
    off : (smoothings, films)
        Mean error of all coordinates in the second half of each film, σ.
    """

    config: Config
    unlike: Float[np.ndarray, "smoothings scenes scales"]
    off: Float[np.ndarray, "smoothings films"]

    def ratio(self, name: str, scale: float, to: str = "none") -> Interval:
        """Return 1 − C with one smoothing over that with another."""
        at, names = self.config.scales.index(scale), tuple(SMOOTHINGS)
        return bootstrap_ratio(*(self.unlike[names.index(n), :, at] for n in (name, to)))


def model(seed: int, smooth: bool) -> Pattern:
    """Return the pattern, made of the first picture or of that picture smoothed by a pixel."""
    first = scene(seed, DETAIL).picture(START)
    image = cv2.GaussianBlur(first, (0, 0), 1.0) if smooth else first
    return make_pattern(image, MIDDLE, WINDOW)


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Compare patterns with their models at each scale, and track some."""

    def compare(seed: int, rng: np.random.Generator) -> np.ndarray:
        return unlike(seed, config.scales, rng)

    def follow(seed: int, rng: np.random.Generator) -> np.ndarray:
        return film(seed, config, rng)

    found = np.array(sweep(compare, config.seeds, rng=rng))
    off = np.array(sweep(follow, config.films, rng=rng)).reshape(-1, len(SMOOTHINGS))
    return Result(config, np.moveaxis(found, 1, 0), off.T)


def unlike(
    seed: int, scales: tuple[float, ...], rng: np.random.Generator
) -> Float[np.ndarray, "smoothings scales"]:
    """Return 1 − C at the true place, mean over the vectors, by smoothing and scale."""
    patterns = [model(seed, smooth) for smooth in (False, True)]
    found = np.empty((len(SMOOTHINGS), len(scales)))
    for k, scale in enumerate(scales):
        place = np.array([*START[:3], scale])
        layers = Layers(seen(scene(seed, DETAIL).picture(place), rng))
        for m, (kind, smooth) in enumerate(SMOOTHINGS.values()):
            C = layers.correlations(patterns[smooth], place[None], kind)[0]
            found[m, k] = np.nanmean(1 - C)
    return found


def film(seed: int, config: Config, rng: np.random.Generator) -> Float[np.ndarray, " smoothings"]:
    """Return the mean error of each tracker in the second half of a film, by the same draws, σ."""
    one, draws, frames = scene(seed, DETAIL), int(rng.integers(2**32)), config.frames
    truth = np.tile(START, (frames, 1))
    truth[:, 3] = max(config.scales) ** (np.arange(frames) / (frames - 1))
    truth[1:, :3] += (0.3 * SIGMAS[:3] * rng.standard_normal((frames - 1, 3))).cumsum(0)
    found = np.zeros((len(SMOOTHINGS), frames, 4))
    for m, (kind, smooth) in enumerate(SMOOTHINGS.values()):
        tracker = PatternTracker(model(seed, smooth), replace(RULES, smoothing=kind))
        state, camera, each = tracker.start(START), *map(np.random.default_rng, (draws, draws))
        for k, place in enumerate(truth):
            state, info = tracker.step(state, seen(one.picture(place), camera), rng=each)
            found[m, k] = errors(info.pose, place)
    return np.abs(found[:, frames // 2 :]).mean(axis=(1, 2))


growing = Study(run, full=Config(), quick=Config(SCORED[:12], films=()), seed=34)
LESS = Accepted(
    0.0, 0.95, "a difference smaller by a twentieth at least; the paper names no number",
    Origin.CHOICE,
)  # fmt: skip


def table(result: Result) -> Table:
    """Return how unlike vectors are at their true places, and the tracker's error, by smoothing."""
    heads = {
        f"s = {s:g}": "1 − C at the true place, in thousandths" for s in result.config.scales
    } | {"error": "mean error in the second half of the films, in σ"}
    rows = {
        name: [*(bootstrap_mean(1000 * of[:, k]) for k in range(of.shape[1])), bootstrap_mean(off)]
        for name, of, off in zip(SMOOTHINGS, result.unlike, result.off, strict=True)
    }
    about = f"95 % over {len(result.config.seeds)} patches, {len(result.config.films)} films"
    return Table(rows, heads, about, "smoothing")


@growing.claim(
    "scale-smoothing",
    paper=PAPER,
    place="§3.3",
    basis="substitute",
    statement="Before vectors are taken at a scale s > 1, smoothing the picture by a Gaussian of "
    "σ = s makes them more like those of the model.",
    paper_value="“convolved with a 2D Gaussian function … where s^(i) is the predicted scale, if "
    "s^(i) > 1”",
    method="Patches with detail that shows only when they grow, at twice the size: 1 − C at the "
    "true place with σ = s over 1 − C without smoothing, of a model that was itself smoothed by a "
    "pixel. Ratio of means over patches.",
    accepted=LESS,
    sabotage=Change("a model that was not smoothed", run=lambda c, *, rng: sharp(c, rng=rng)),
)
def scale_smoothing(result: Result) -> Finding:
    """Compare smoothings of a model that was smoothed, and of one that was not."""
    printed = result.ratio("σ = s", 2.0)
    return Finding(
        result.ratio("σ = s, model by 1 px", 2.0, "none, model by 1 px"),
        {
            "ratio, model as printed": printed,
            "ratio, model as printed, s = 1.01": result.ratio("σ = s", 1.01),
            "ratio, σ = √(s² − 1)": result.ratio("σ = √(s² − 1)", 2.0),
            "ratio, both smoothed to neither": result.ratio("σ = s, model by 1 px", 2.0),
        },
        tables={"likeness": table(result)} if result.config.films else {},
        conditions=(
            Condition.judged("the model was smoothed by a pixel, too", LESS, outside=printed),
        ),
        note="At s = 1 the printed σ jumps from 0 to 1.",
    )


def sharp(config: Config, *, rng: np.random.Generator) -> Result:
    """Run with models as they are under the names of the smoothed ones."""
    found = run(config, rng=rng)
    return replace(found, unlike=found.unlike[[0, 1, 2, 0, 1]])
