"""The explorers: a scene with sensors switched off, and the rules of the weights."""

from functools import partial

from robot_perception.chapters.people_fusion import committee, rates, scene
from robot_perception.chapters.people_fusion import figures as draw
from robot_perception.chapters.people_sensors.scene import MOMENTS, SHOWN
from robot_perception.teaching.controls import choice, slider, timeline
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure

SCENE = Exploration(
    draw.committee_at,
    scene.watched,
    lambda state: state.words,
    {
        "who": choice("Sensors", tuple(scene.WHO), "all three"),
        "at": timeline("Time", MOMENTS, SHOWN, "s", fps=1),
    },
    name="people-scene",
    caption="Half a minute in the room. Dotted discs: the people, with a question mark those who "
    "are not found. Red: the hypotheses, 2σ, curved, being Gaussian in distance and direction, "
    "and long where no distance is known; the greater the weight, the stronger the line. Filled "
    "ones count as persons, and a cross marks those that are false.",
    presets={
        "the camera alone": {"who": "the camera alone"},
        "no camera": {"who": "without the camera"},
        "no sonars": {"who": "without the sonars", "at": 21.66},
        "the worst moment": {"at": 9.66},
    },
    axes=partial(figure, width=5.0, height=5.0),
    finding=lambda state: (*state.errors, state.known),
)

RULES = Exploration(
    draw.rules,
    scene.chosen,
    lambda one: one.words,
    {
        "theta": slider("θ", rates.THRESHOLDS, committee.RULES.threshold),
        "alpha": slider("α of all sensors", rates.FACTORS, 1.0, "× ours"),
    },
    name="people-rules",
    caption="The half minute of the page under other rules. Large dot: your choice; small dots: "
    "all the others; diamond: the paper.",
    presets={
        "slow to believe": {"alpha": 0.25},
        "quick to believe": {"alpha": 3.0},
        "the most people": {"theta": 0.4, "alpha": 3.0},
        "the fewest false": {"theta": 0.2, "alpha": 0.25},
    },
    axes=partial(figure, height=3.8),
    finding=lambda one: one.tracked,
)
