"""The pattern grows: smoothing by the predicted scale, section 3.3."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from robot_perception.ceiling.tracker import PatternTracker, TrackerRules, smoothing
from robot_perception.chapters.pattern_tracking.scene import (
    RULES,
    SCORED,
    SIGMAS,
    START,
    errors,
    scene,
    seen,
)
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio, exact
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "ceiling-navigation"
DETAIL = 4
"""Pixels of the patch for one of the first picture: what is finer than that one appears later."""
SMOOTHINGS: Mapping[str, TrackerRules] = {
    "none": replace(RULES, smoothing="none"),
    "σ = s": replace(RULES, smoothing="scale"),
    "σ = √(s² − 1)": replace(RULES, smoothing="difference"),
}
"""Of the picture, before a particle of scale s > 1 takes its vectors."""


@dataclass(frozen=True, slots=True)
class Config:
    """Films in which a patch comes closer.

    Parameters
    ----------
    seeds
        Of patch, ground and motion.
    largest
        The scale in the last picture; from picture to picture it grows by the same factor.
    frames
        Of a film.
    """

    seeds: tuple[int, ...] = SCORED[:40]
    largest: float = 2.0
    frames: int = 25


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Errors while a pattern grows.

    Parameters
    ----------
    config
        What was run.
    scales : (frames,)
        True ones.
    off : (smoothings, films, frames, 4)
        Errors, σ.
    """

    config: Config
    scales: Float[np.ndarray, " frames"]
    off: Float[np.ndarray, "smoothings films frames 4"]

    def error(self, name: str) -> Float[np.ndarray, " films"]:
        """Return the mean error of all coordinates in the second half of each film, σ."""
        half = self.off.shape[2] // 2
        return np.abs(self.off[tuple(SMOOTHINGS).index(name), :, half:]).mean(axis=(1, 2))

    def ratio(self, name: str) -> Interval:
        """Return the error with a smoothing over that with none."""
        return bootstrap_ratio(self.error(name), self.error("none"))

    def bias(self, name: str) -> Float[np.ndarray, " frames"]:
        """Return the median error of the scale in each picture, σ."""
        return np.median(self.off[tuple(SMOOTHINGS).index(name), :, :, 3], axis=0)


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Follow each pattern with each smoothing, by the same draws."""

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        return film(seed, config, rng)

    found = np.array(sweep(task, config.seeds, rng=rng))
    return Result(config, growth(config), np.moveaxis(found, 1, 0))


def growth(config: Config) -> Float[np.ndarray, " frames"]:
    """Return the scale in each picture."""
    return config.largest ** (np.arange(config.frames) / (config.frames - 1))


def film(
    seed: int, config: Config, rng: np.random.Generator
) -> Float[np.ndarray, "smoothings frames 4"]:
    """Return the errors in each picture of a film."""
    one, draws = scene(seed, DETAIL), int(rng.integers(2**32))
    pattern = one.pattern()
    truth = np.tile(START, (config.frames, 1))
    truth[:, 3] = growth(config)
    truth[1:, :3] += (0.3 * SIGMAS[:3] * rng.standard_normal((config.frames - 1, 3))).cumsum(0)
    found = np.zeros((len(SMOOTHINGS), config.frames, 4))
    for t, rules in enumerate(SMOOTHINGS.values()):
        tracker, camera = PatternTracker(pattern, rules), np.random.default_rng(draws)
        state, each = tracker.start(START), np.random.default_rng(draws)
        for k, place in enumerate(truth):
            state, info = tracker.step(state, seen(one.picture(place), camera), rng=each)
            found[t, k] = errors(info.pose, place)
    return found


growing = Study(run, full=Config(), quick=Config(SCORED[:8], frames=20), seed=34)
LESS = Accepted(
    0.0, 0.95, "an error smaller by a twentieth at least; the paper names no number", Origin.CHOICE
)


def table(result: Result) -> Table:
    """Return errors by smoothing."""
    heads = {
        "error": "mean error in the second half of the films, in σ",
        "over none": "its ratio to that without smoothing",
        "at s = 1.01": "standard deviation of the Gaussian just above s = 1, px",
    }
    near = np.array([1.01])
    rows = {
        name: [bootstrap_mean(result.error(name)), result.ratio(name),
               exact(float(smoothing(near, rules.smoothing)[0]))]
        for name, rules in SMOOTHINGS.items()
    }  # fmt: skip
    return Table(rows, heads, f"95 % over {len(result.config.seeds)} films", "smoothing")


@growing.claim(
    "scale-smoothing",
    paper=PAPER,
    place="§3.3",
    basis="substitute",
    statement="While a pattern grows, the tracker errs less if the picture is smoothed by a "
    "Gaussian of σ = s, the predicted scale.",
    paper_value="“convolved with a 2D Gaussian function … if s > 1”",
    method="Patches that grow to twice their size on cluttered grounds: mean error of all "
    "coordinates in the second half of each film, smoothed by σ = s over not smoothed, by the same "
    "draws. Ratio of means over films.",
    accepted=LESS,
    sabotage=Change("σ = √(s² − 1) in its place", run=lambda c, *, rng: by_difference(c, rng=rng)),
)
def scale_smoothing(result: Result) -> Finding:
    """Compare the printed smoothing, ours, and none."""
    last = {f"scale too large at the end, {name} (σ)": exact(float(result.bias(name)[-1]))
            for name in SMOOTHINGS}  # fmt: skip
    return Finding(
        result.ratio("σ = s"),
        {"ratio, σ = √(s² − 1)": result.ratio("σ = √(s² − 1)")} | last,
        tables={"errors": table(result)},
        note="As printed the picture is smoothed by a pixel as soon as s exceeds 1, while the "
        "model was not.",
    )


def by_difference(config: Config, *, rng: np.random.Generator) -> Result:
    """Run with the other smoothing under the name of the printed one."""
    found = run(config, rng=rng)
    off, names = found.off.copy(), tuple(SMOOTHINGS)
    off[names.index("σ = s")] = off[names.index("σ = √(s² − 1)")]
    return replace(found, off=off)
