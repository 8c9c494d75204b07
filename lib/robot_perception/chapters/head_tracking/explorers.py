"""The explorers of the chapter "A head by its colours"."""

from functools import partial

from robot_perception.chapters.head_tracking import figures as draw
from robot_perception.chapters.head_tracking import scene
from robot_perception.chapters.head_tracking.heads import GIVES_UP, RULES
from robot_perception.teaching.controls import choice, slider
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure

rates = Exploration(
    draw.tracked,
    scene.followed,
    scene.Followed.words,
    controls={
        "film": choice("Film", {name: name for name in scene.SCENES}, scene.LIGHT),
        "rate": slider("Adaptation a", scene.RATES, RULES.rate),
        "gate": slider("Threshold", scene.GATES, RULES.gate),
        "floor": choice("Gives up", {"never": 0.0, f"below {GIVES_UP:g}": GIVES_UP}, 0.0),
    },
    name="head-rates",
    caption="Ten seconds of film. Above: the overlap (IoU) of ellipse and head; below 0.2 the "
    "ellipse misses the head. Dashed: a = 0, with the same rule for giving up. Below: the light "
    "on the head, and how much of the head is visible.",
    presets={
        "the first frame for ever": {"rate": 0.0},
        "half of it new in every frame": {"rate": 0.5},
        "others pass, a higher threshold": {"film": scene.CROWD, "gate": 0.8},
        "others pass, five times as fast": {"film": scene.CROWD, "rate": 0.1},
        "both give up": {"floor": GIVES_UP},
    },
    axes=partial(figure, 2, height=5.2),
    finding=lambda state: state.missed(state.iou) - state.missed(state.fixed),
)

look = Exploration(
    draw.looked,
    scene.look,
    scene.HeadColours.words,
    controls={"at": slider("Frame", tuple(range(0, 150, 10)), 60)},
    name="head-look",
    caption="Left: the head. Right: colours of its pixels, in frame 0 (blue) and this one (red): "
    "brightness to the right, the difference of green and red upwards. Above: what the head's "
    "histogram has in common with that of frame 0, in the tracker's cells of the paper's space "
    "(coarse), in as many as RGB has (finer), and in RGB.",
    presets={"dark": {"at": 110}, "bright": {"at": 20}, "the first": {"at": 0}},
    axes=partial(figure, 1, 2, width=7.4, height=3.2),
    finding=lambda state: state.common["opponent, finer cells"] - state.common["RGB"],
)
