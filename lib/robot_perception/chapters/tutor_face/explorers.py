"""The explorer of the chapter "Is it you?"."""

from functools import partial

from robot_perception.chapters.tutor_face import figures as draw
from robot_perception.chapters.tutor_face import views
from robot_perception.teaching.controls import choice, slider
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure

asked = Exploration(
    draw.asking,
    views.asked,
    views.Asked.words,
    controls={
        "who": choice("Who comes", {name: name for name in views.FACES}, "the first tutor"),
        "count": slider("Eigenimages", (1, 2, 5, 10, 20), 20),
        "accepted": slider("Accepted of the known", (0.5, 0.7, 0.85, 0.95), 0.95),
    },
    name="tutor-asked",
    caption="Left: the face as the detector cuts it out. Middle: what the eigenimages make of it. "
    "Right: its distance to the nearest picture of each of three tutors. Dashed: the distance "
    "beyond which nobody is known.",
    presets={
        "one eigenimage": {"count": 1},
        "five eigenimages": {"count": 5},
        "a stranger": {"who": "a stranger"},
        "a stranger, half accepted": {"who": "a stranger", "accepted": 0.5},
    },
    axes=partial(figure, 1, 3, width=7.6, height=3.0),
    finding=lambda state: (state.true, state.named),
)
