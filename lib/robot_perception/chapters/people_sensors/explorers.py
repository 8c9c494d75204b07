"""The explorer: what one sensor takes for people, moment by moment."""

from functools import partial

from robot_perception.chapters.people_sensors import figures as draw
from robot_perception.chapters.people_sensors import scene
from robot_perception.chapters.people_sensors.sessions import SENSORS
from robot_perception.teaching.controls import choice, timeline
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure

LOOK = Exploration(
    draw.look,
    scene.look,
    lambda look: look.words,
    {
        "sensor": choice("Sensor", SENSORS, "laser"),
        "at": timeline("Time", scene.MOMENTS, scene.SHOWN, "s", fps=1),
    },
    name="people-look",
    caption="Half a minute in the room, one sensor at a time. Dotted discs: the people, with a "
    "question mark those whom it does not find. Coloured, 2σ: what it takes for people; a cross "
    "marks what is false. The camera's detections are wedges, since it knows no distance.",
    presets={
        "the laser misses two": {"at": scene.MOMENTS[8]},
        "the sonars hear all three": {"sensor": "sonar", "at": scene.MOMENTS[9]},
        "the camera makes two up": {"sensor": "camera", "at": scene.MOMENTS[3]},
    },
    axes=partial(figure, width=5.0, height=5.0),
    finding=lambda look: (int(look.found.sum()), int(look.nobody.sum())),
)
