"""The explorers: one iteration in one dimension, how many samples how far, and snakes."""

from functools import partial

from robot_perception.chapters.colour_and_shape import figures as draw
from robot_perception.chapters.colour_and_shape import states
from robot_perception.chapters.colour_and_shape.iteration import STEPS
from robot_perception.chapters.colour_and_shape.states import MANY, NOISES, Slid, Tried
from robot_perception.teaching.controls import choice, slider
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure, image_axes

# One iteration -----------------------------------------------------------------------------------

steps = Exploration(
    lambda ax, state: draw.iterated(ax, *state),
    lambda samples, noise, step: (states.iterated(samples, noise), step),
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

many = Exploration(
    draw.tried,
    states.tried,
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

snake = Exploration(
    draw.slid,
    states.slid,
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
    axes=lambda: image_axes(draw.segmented(states.scene())),
    finding=lambda state: state.swallowed,
)
