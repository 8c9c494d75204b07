"""The explorers: one iteration in one dimension, how many samples how far, and snakes."""

from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from jaxtyping import Float

from robot_perception.appearance.affine_snake import SnakeFit, SnakeRules
from robot_perception.chapters.colour_and_shape import experiments, iteration
from robot_perception.chapters.colour_and_shape import figures as draw
from robot_perception.chapters.colour_and_shape.experiments import CHOOSING, LOST
from robot_perception.chapters.colour_and_shape.iteration import STEPS, Iteration
from robot_perception.chapters.colour_and_shape.snakes import (
    SNAKES,
    Case,
    Config,
    film_cases,
    measured,
)
from robot_perception.teaching.controls import choice, slider
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure, image_axes
from robot_perception.teaching.recorded import recorded

# One iteration -----------------------------------------------------------------------------------

DRAW = 2
"""Seed of the iteration that is shown."""


@cache
def iterated(samples: int, noise: float) -> Iteration:
    """Return one iteration."""
    config = iteration.Config(samples=samples, noise=noise)
    return iteration.run(config, rng=np.random.default_rng(DRAW))


steps = Exploration(
    lambda ax, state: draw.iterated(ax, *state),
    lambda samples, noise, step: (iterated(samples, noise), step),
    lambda state: state[0].words(state[1]),
    controls={
        "samples": slider("Samples N", (5, 20, 50, 200), 20),
        "noise": slider("Noise B", (0.0, 0.04, 0.15), 0.04),
        "step": choice("Up to step", {f"({k}) {words}": k for k, words in STEPS.items()}, "e"),
    },
    name="shape-iteration",
    caption="One iteration, from (a) to (e). A disc is a sample of the brightness; in (a) and "
    "(e) its size is its weight. At the bottom: how well each brightness fits the frame; the "
    "second hump is another object.",
    presets={
        "before the frame": {"step": "a"},
        "five samples": {"samples": 5},
        "copies stay copies": {"noise": 0.0},
        "scattered widely": {"samples": 200, "noise": 0.15},
    },
    axes=partial(figure, height=4.4),
    finding=lambda state: state[0],
)

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


many = Exploration(
    draw.tried,
    tried,
    Tried.words,
    controls={
        "samples": slider("Samples N", MANY, 50),
        "noise": slider("Noise, times B", NOISES, 1.0),
    },
    name="shape-many",
    caption="Overlap (IoU) with a circle that changes its colour, over 25 frames; its mean "
    "above. Thick: your choice. Thin: all other choices. Below the line the circle is lost.",
    presets={
        "no noise": {"noise": 0.0},
        "five samples": {"samples": 5},
        "five samples, half the noise": {"samples": 5, "noise": 0.5},
        "a hundred samples, no noise": {"samples": 100, "noise": 0.0},
    },
    axes=partial(figure, height=3.6),
    finding=lambda state: state.overlap,
)

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


snake = Exploration(
    draw.slid,
    slid,
    Slid.words,
    controls={
        "snake": choice("Deformations", {"affine": "affine", "free": "free"}, "affine"),
        "elasticity": slider("Elasticity α", (0.05, 0.2, 1.0, 5.0), 0.05),
        "rigidity": slider("Rigidity β", (0.05, 1.0, 10.0, 100.0), 0.05),
        "reach": slider("Reach at first", (3.0, 8.0, 20.0), 20.0, "px"),
    },
    name="shape-snake",
    caption="A piece of the frame that holds shell and neck (tinted). Dashed: the outline of the "
    "frame before. Solid: the snake on its way and at its end, with its overlap (IoU) with the "
    "shell and the share of the neck in it. As in the paper's Fig. 12.",
    presets={
        "free": {"snake": "free"},
        "free and stiff": {"snake": "free", "rigidity": 100.0},
        "too elastic": {"elasticity": 5.0},
    },
    axes=lambda: image_axes(draw.segmented(scene())),
    finding=lambda state: state.swallowed,
)
