"""Fig. 10: one iteration of the condensation algorithm, explained in one dimension.

The one number is how bright a colour is; it brightens from frame to frame. The frame weighs a
brightness by how near it is to one of two that are seen: the object's, and another object's.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from robot_perception.beliefs import ParticleSet
from robot_perception.particles import condensation, multinomial

STEPS = {
    "a": "samples with their weights",
    "b": "drawn, some more than once",
    "c": "moved by A",
    "d": "scattered by B",
    "e": "weighed by the frame",
}


@dataclass(frozen=True, slots=True)
class Config:
    """A step; the paper draws it without numbers, all are ours.

    Parameters
    ----------
    samples
        N.
    before, spread
        Where the samples lie before the step, and how widely.
    velocity, noise
        By how much the brightness rises in a frame, and the deviation of what is added.
    seen, other, share
        Brightness of the object and of another one, and how well that fits instead.
    sigma
        How far a brightness may be off.
    """

    samples: int = 12
    before: float = 0.35
    spread: float = 0.08
    velocity: float = 0.12
    noise: float = 0.04
    seen: float = 0.5
    other: float = 0.72
    share: float = 0.3
    sigma: float = 0.05


@dataclass(frozen=True, eq=False, slots=True)
class Iteration:
    """The steps (a) to (e), each sample a place.

    Parameters
    ----------
    config
        What was run.
    start, start_weights : (N,)
        (a) The samples before, with their weights.
    ancestors : (N,)
        (b) Which of them are drawn.
    drifted : (N,)
        (c) Where they go by themselves.
    moved : (N,)
        (d) and with the noise.
    weights : (N,)
        (e) How the frame weighs them.
    grid, likelihood : (k,)
        What the frame says of every brightness.
    """

    config: Config
    start: Float[np.ndarray, " n"]
    start_weights: Float[np.ndarray, " n"]
    ancestors: Int[np.ndarray, " n"]
    drifted: Float[np.ndarray, " n"]
    moved: Float[np.ndarray, " n"]
    weights: Float[np.ndarray, " n"]
    grid: Float[np.ndarray, " k"]
    likelihood: Float[np.ndarray, " k"]

    @property
    def drawn(self) -> int:
        """How many of the samples were drawn at least once."""
        return len(np.unique(self.ancestors))

    @property
    def effective(self) -> float:
        """How many samples of equal weight would say as much."""
        return float(1 / (self.weights**2).sum())

    def words(self, step: str) -> str:
        """Return what the iteration shows up to a step."""
        samples, noise = self.config.samples, self.config.noise
        words = f"{samples} samples of a brightness, noise {noise:g}, up to step {step}"
        if step in "bcd":
            return f"{words}: {STEPS[step]}. {self.drawn} of the samples were drawn."
        if step == "a":
            return f"{words}: {STEPS[step]}, round {self.start @ self.start_weights:.2f}."
        best = self.moved[self.weights.argmax()]
        return (
            f"{words}: {self.drawn} of them were drawn; the heaviest lies at {best:.2f}, the "
            f"object at {self.config.seen:g}; they are worth {self.effective:.0f} equal ones."
        )


def likelihood(brightness: Float[np.ndarray, "..."], config: Config) -> Float[np.ndarray, "..."]:
    """Return how well a brightness fits the frame, at most about 1."""
    near, far = (
        np.exp(-0.5 * ((brightness - peak) / config.sigma) ** 2)
        for peak in (config.seen, config.other)
    )
    return near + config.share * far


def run(config: Config, *, rng: np.random.Generator) -> Iteration:
    """Return one step, by the function that the tracker uses."""
    start = config.before + config.spread * rng.standard_normal((config.samples, 1))
    logs = -0.5 * ((start[:, 0] - config.before) / config.spread) ** 2
    prior = ParticleSet(start, logs)

    def move(states: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        return states + config.velocity + config.noise * rng.standard_normal(states.shape)

    def log_likelihood(states: np.ndarray) -> np.ndarray:
        return np.log(likelihood(states[:, 0], config) + np.finfo(float).tiny)

    after, info = condensation(prior, move, log_likelihood, rng=rng, scheme=multinomial)
    grid = np.linspace(0, 1, 301)
    drifted = start[info.ancestors, 0] + config.velocity
    return Iteration(
        config,
        start[:, 0],
        prior.weights,
        info.ancestors,
        drifted,
        after.states[:, 0],
        after.weights,
        grid,
        likelihood(grid, config),
    )
