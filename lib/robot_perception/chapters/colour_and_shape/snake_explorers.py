"""The states of the explorer of snakes: weights, and the restriction to affine maps."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from robot_perception.appearance.affine_snake import SnakeFit, SnakeRules
from robot_perception.chapters.colour_and_shape.snakes import (
    CHOOSING,
    SNAKES,
    Case,
    Config,
    film_cases,
    measured,
)
from robot_perception.teaching.explore import choice, slider

FRAME = 24
"""Of the last film of those on which parameters were chosen: its neck is out and in the blob."""

SNAKE_CONTROLS = {
    "snake": choice("Deformations", {"affine": "affine", "free": "free"}, "affine"),
    "elasticity": slider("Elasticity α", (0.05, 0.2, 1.0, 5.0), 0.05),
    "rigidity": slider("Rigidity β", (0.05, 1.0, 10.0, 100.0), 0.05),
    "reach": slider("Reach at first", (3.0, 8.0, 20.0), 20.0, "px"),
}
SNAKE_PRESETS = {
    "free": {"snake": "free"},
    "free and stiff": {"snake": "free", "rigidity": 100.0},
    "too elastic": {"elasticity": 5.0},
}


@dataclass(frozen=True, eq=False, slots=True)
class Slid:
    """A case, how a snake came to rest in it, and the shares of shell and neck it holds."""

    case: Case
    snake: str
    fit: SnakeFit
    overlap: float
    swallowed: float


@cache
def scene() -> Case:
    """Return the frame that the explorer shows."""
    config = Config(films=CHOOSING[-1:], frames=(FRAME,))
    (case,) = film_cases(CHOOSING[-1], config, rng=np.random.default_rng(0))
    return case


@cache
def slid(snake: str, elasticity: float, rigidity: float, reach: float) -> Slid:
    """Return a state of the explorer of snakes."""
    case = scene()
    rules = SnakeRules(elasticity, rigidity, reach=(reach, 3.0))
    fit = SNAKES[snake](case.start, case.edges, rules)
    found = measured([case], [fit.outline])
    return Slid(case, snake, fit, float(found.overlap[0]), float(found.swallowed[0]))


def describe_snake(snake: str, elasticity: float, rigidity: float, reach: float) -> str:
    """Return what a state of the explorer of snakes shows, in words."""
    state = slid(snake, elasticity, rigidity, reach)
    kind = "An affine snake" if snake == "affine" else "A free snake"
    return (
        f"{kind} with elasticity {elasticity:g}, rigidity {rigidity:g} and a reach of {reach:g} "
        f"pixels at first: it holds {state.swallowed:.0%} of the neck and overlaps with the shell "
        f"by {state.overlap:.2f}; {state.fit.residual:.1f} pixels of it are not affine."
    )
