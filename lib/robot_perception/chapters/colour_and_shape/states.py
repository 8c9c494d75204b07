"""What the explorers show: one iteration in one dimension, how many samples how far, and snakes."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from jaxtyping import Float

from robot_perception.appearance.affine_snake import SnakeFit, SnakeRules
from robot_perception.chapters.colour_and_shape import experiments, iteration
from robot_perception.chapters.colour_and_shape.experiments import CHOOSING, LOST
from robot_perception.chapters.colour_and_shape.iteration import Iteration
from robot_perception.chapters.colour_and_shape.snakes import (
    SNAKES,
    Case,
    Config,
    film_cases,
    measured,
)
from robot_perception.teaching.recorded import recorded

# One iteration -----------------------------------------------------------------------------------

DRAW = 2
"""Seed of the iteration that is shown."""


@cache
def iterated(samples: int, noise: float) -> Iteration:
    """Return one iteration."""
    config = iteration.Config(samples=samples, noise=noise)
    return iteration.run(config, rng=np.random.default_rng(DRAW))


# How many samples, and how far -------------------------------------------------------------------

FILM = "circles", CHOOSING[1]
"""A film on which numbers were chosen, in which the colour leaves where it was."""
FRAMES = 25
MANY = (5, 20, 50, 100)
NOISES = (0.0, 0.5, 1.0, 2.0)


@recorded("shape-grid")
def grid() -> Float[np.ndarray, "many noises frames"]:
    """Return the overlap with the truth by N, noise and frame, from the second frame on."""
    world, seed = FILM
    film, dynamics = experiments.filmed(*FILM, FRAMES), experiments.trained(world)
    found = np.empty((len(MANY), len(NOISES), FRAMES))
    for i, samples in enumerate(MANY):
        for j, noise in enumerate(NOISES):
            rules = replace(experiments.rules_of(world), samples=samples, noise=noise)
            rng = np.random.default_rng(seed)
            steps = experiments.follow("fused", film, dynamics, rules, rng=rng)
            found[i, j] = experiments.scored(steps, film)
    return found


@dataclass(frozen=True, eq=False, slots=True)
class Tried:
    """Overlaps by frame with so many samples and so much noise, without noise, and with all."""

    samples: int
    noise: float
    overlap: Float[np.ndarray, " frames"]
    still: Float[np.ndarray, " frames"]
    every: Float[np.ndarray, "many noises frames"]

    def words(self) -> str:
        """Return what the state shows."""
        end = "lost at the end" if self.overlap[-1] < LOST else "held to the end"
        return (
            f"Overlap of outline and circle in {FRAMES} frames with {self.samples} samples and "
            f"{self.noise:g} times the learned noise: {self.overlap.mean():.2f} on average, {end}."
        )


def tried(samples: int, noise: float) -> Tried:
    """Return a state of the explorer of samples."""
    by_noise = grid()[MANY.index(samples)]
    return Tried(samples, noise, by_noise[NOISES.index(noise)], by_noise[0], grid())


# Snakes ------------------------------------------------------------------------------------------

SHELL = 24
"""Of the last film of those on which parameters were chosen: its neck is out and in the blob."""


@dataclass(frozen=True, eq=False, slots=True)
class Slid:
    """A case, how a snake came to rest in it, and the shares of shell and neck it holds."""

    case: Case
    snake: str
    rules: SnakeRules
    fit: SnakeFit
    overlap: float
    swallowed: float

    def words(self) -> str:
        """Return what the state shows."""
        kind = "An affine snake" if self.snake == "affine" else "A free snake"
        return (
            f"{kind} with elasticity {self.rules.elasticity:g}, rigidity {self.rules.rigidity:g} "
            f"and a reach of {self.rules.reach[0]:g} pixels at first: it holds "
            f"{self.swallowed:.0%} of the neck and overlaps with the shell by {self.overlap:.2f}; "
            f"{self.fit.residual:.1f} pixels of it are not affine."
        )


@recorded("shape-shell")
def scene() -> Case:
    """Return the frame that the explorer shows."""
    config = Config(films=CHOOSING[-1:], frames=(SHELL,))
    (case,) = film_cases(CHOOSING[-1], config, rng=np.random.default_rng(0))
    return case


@cache
def slid(snake: str, elasticity: float, rigidity: float, reach: float) -> Slid:
    """Return a state of the explorer of snakes."""
    case, rules = scene(), SnakeRules(elasticity, rigidity, reach=(reach, 3.0))
    fit = SNAKES[snake](case.start, case.edges, rules)
    found = measured([case], [fit.outline])
    return Slid(case, snake, rules, fit, float(found.overlap[0]), float(found.swallowed[0]))
