"""The states of two explorers: one iteration in one dimension, and how many samples how far."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from jaxtyping import Float

import data_synth.coloured
from robot_perception import appearance
from robot_perception.chapters.colour_and_shape import experiments, iteration
from robot_perception.chapters.colour_and_shape.experiments import CHOOSING, WORLDS
from robot_perception.chapters.colour_and_shape.iteration import Iteration
from robot_perception.teaching.explore import choice, slider
from robot_perception.teaching.kept import kept

# One iteration -----------------------------------------------------------------------------------

STEPS: Mapping[str, str] = {
    "a": "samples with their weights",
    "b": "drawn, some more than once",
    "c": "moved by A",
    "d": "scattered by B",
    "e": "weighed by the frame",
}
"""Steps of the paper's Fig. 10."""
DRAW = 2
"""Seed of the iteration that is shown."""

ITERATION_CONTROLS = {
    "samples": slider("Samples N", (5, 20, 50, 200), 20),
    "noise": slider("Noise B", (0.0, 0.04, 0.15), 0.04),
    "step": choice("Up to step", {f"({k}) {words}": k for k, words in STEPS.items()}, "e"),
}
ITERATION_PRESETS = {
    "before the frame": {"step": "a"},
    "five samples": {"samples": 5},
    "copies stay copies": {"noise": 0.0},
    "scattered widely": {"samples": 200, "noise": 0.15},
}


@cache
def iterated(samples: int, noise: float) -> Iteration:
    """Return one iteration; the step is a matter of the drawing."""
    config = iteration.Config(samples=samples, noise=noise)
    return iteration.run(config, rng=np.random.default_rng(DRAW))


def drawn(found: Iteration) -> int:
    """Return how many of the samples were drawn at least once."""
    return len(np.unique(found.ancestors))


def effective(found: Iteration) -> float:
    """Return how many samples of equal weight would say as much."""
    return float(1 / (found.weights**2).sum())


def describe_iteration(samples: int, noise: float, step: str) -> str:
    """Return what a state of the explorer of one iteration shows, in words."""
    found = iterated(samples, noise)
    words = f"{samples} samples of a brightness, noise {noise:g}, up to step {step}"
    if step in "bcd":
        return f"{words}: {STEPS[step]}. {drawn(found)} of the samples were drawn."
    if step == "a":
        return f"{words}: {STEPS[step]}, round {found.start @ found.start_weights:.2f}."
    best = found.moved[found.weights.argmax()]
    return (
        f"{words}: {drawn(found)} of them were drawn; the heaviest lies at {best:.2f}, the object "
        f"at {iteration.Config().seen:g}; they are worth {effective(found):.0f} equal ones."
    )


# How many samples, and how far -------------------------------------------------------------------

FILM = "circles", CHOOSING[1]
"""A film on which numbers were chosen, in which the colour leaves where it was."""
FRAMES = 25
MANY = (5, 20, 50, 100)
NOISES = (0.0, 0.5, 1.0, 2.0)

SAMPLES_CONTROLS = {
    "samples": slider("Samples N", MANY, 50),
    "noise": slider("Noise, times B", NOISES, 1.0),
}
SAMPLES_PRESETS = {
    "no noise": {"noise": 0.0},
    "five samples": {"samples": 5},
    "five samples, half the noise": {"samples": 5, "noise": 0.5},
    "a hundred samples, no noise": {"samples": 100, "noise": 0.0},
}


@dataclass(frozen=True, eq=False, slots=True)
class Grid:
    """Overlap with the truth by N, noise and frame, from the second frame on."""

    overlap: Float[np.ndarray, "many noises frames"]


def _every_pair(frames: int) -> Grid:
    world, seed = FILM
    film = WORLDS[world](rng=np.random.default_rng(seed), frames=frames + 1)
    config, shape = experiments.Config(), film.frames.shape[1:3]
    dynamics = experiments.trained(world, config)
    found = np.empty((len(MANY), len(NOISES), frames))
    for i, samples in enumerate(MANY):
        for j, noise in enumerate(NOISES):
            rules = replace(config.of(world), samples=samples, noise=noise)
            rng = np.random.default_rng(seed)
            steps = experiments.follow("fused", film, dynamics, rules, rng=rng)
            found[i, j] = [
                experiments.overlap(outline, truth, shape)
                for (outline, _), truth in zip(steps, film.outlines[1:], strict=True)
            ]
    return Grid(found)


@cache
def grid() -> Grid:
    """Return all states of the explorer of samples; kept on this computer."""
    code = (data_synth.coloured, appearance, experiments)
    return kept(_every_pair, Grid, FRAMES, code=code)


def overlap(samples: int, noise: float) -> Float[np.ndarray, " frames"]:
    """Return a state of the explorer of samples."""
    return grid().overlap[MANY.index(samples), NOISES.index(noise)]


def describe_samples(samples: int, noise: float) -> str:
    """Return what a state of the explorer of samples shows, in words."""
    found = overlap(samples, noise)
    end = "lost at the end" if found[-1] < experiments.LOST else "held to the end"
    return (
        f"Overlap of outline and circle in {FRAMES} frames with {samples} samples and {noise:g} "
        f"times the learned noise: {found.mean():.2f} on average, {end}."
    )
