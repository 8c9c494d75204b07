"""The explorers of the chapter "A robot that remembers the ceiling"."""

from functools import partial

from robot_perception.chapters.ceiling_navigation import chaining, scene
from robot_perception.chapters.ceiling_navigation import figures as draw
from robot_perception.teaching.controls import Drag, slider
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure

servoing = Exploration(
    draw.servoed,
    scene.driven,
    scene.Driven.words,
    controls={
        "factor": slider("Assumed over true scale", scene.FACTORS, 1.0),
        "bearing": slider("Gain k_α", scene.BEARINGS, 2.5, "per s"),
        "aside": slider("Starts beside the path by", scene.ASIDES, 0.3, "m"),
    },
    name="nav-servo",
    caption="A learned slalom (blue) driven again (red) by exact sightings; below, the robot's "
    "heading. The robot knows its scale Z/f wrong by the factor. Near a key image the loop is "
    "stable while the factor is below k_α / k_ρ, with k_ρ = 1 per second.",
    presets={
        "a ceiling believed half as high": {"factor": 0.5},
        "three times as high": {"factor": 3.0},
        "three times, quicker to turn": {"factor": 3.0, "bearing": 4.0},
    },
    axes=partial(figure, 2, width=5.8, height=5.4),
    finding=lambda state: (state.factor / state.limit, state.off, state.wagging, state.status),
)

dragged = Exploration(
    draw.quotients,
    scene.placed,
    scene.Placed.words,
    controls={
        "x": slider("Robot, x", scene.XS, 0.6, "m"),
        "y": slider("Robot, y", scene.YS, 0.4, "m"),
        "turn": slider("Robot, heading", scene.TURNS, 45.0, "°"),
    },
    name="nav-quotient",
    caption="A robot (red) below two patterns; the thin frame is what its camera sees. Purple: the "
    "reference. Green: where A⁻¹ B puts the new pattern. Magenta: where B A⁻¹ puts it.",
    presets={
        "turned round": {"turn": 180.0},
        "turned to the right": {"turn": -90.0},
        "below the reference, straight": {"x": 0.2, "y": 0.0, "turn": 0.0},
    },
    axes=partial(figure, width=5.8, height=5.0),
    drag=Drag(("x", "y"), "the robot"),
    finding=lambda state: (state.off(chaining.RIGHT), state.off(chaining.OVER)),
)
