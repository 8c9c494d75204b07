"""The explorers: what one sensor takes for people, and what all make of somebody at a place."""

from functools import partial

import numpy as np

from robot_perception.chapters.people_sensors import figures as draw
from robot_perception.chapters.people_sensors import scene, standing
from robot_perception.chapters.people_sensors.sessions import SENSORS
from robot_perception.chapters.people_sensors.standing import Stood
from robot_perception.teaching.controls import Drag, choice, slider, timeline
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


def describe_stood(now: Stood) -> str:
    """Return who finds the person, and what else is taken for people."""
    return (
        f"The room from above: somebody {now.how}, {now.distance:g} m from the robot in the "
        f"direction {now.direction:+d}°, is {now.words}; false detections: {now.false}."
    )


def place(distance: float, direction: float, how: str) -> tuple[float, float]:
    """Return where the person stands in the drawing, however they stand there."""
    x, y = draw.polar(distance, np.deg2rad(direction))
    return float(x), float(y)


STAND = Exploration(
    draw.stood,
    standing.stood,
    describe_stood,
    {
        "distance": slider("Distance", standing.DISTANCES, 1.4, "m"),
        "direction": slider("Direction", standing.DIRECTIONS, -40, "°"),
        "how": choice("The person stands", tuple(standing.HOW), "facing the robot"),
    },
    name="people-stand",
    caption="Drag the person (disc) round the robot. Dots: where the beams of the laser ended; "
    "arcs: echoes of the sonars. What each sensor takes for people is orange (laser), blue "
    "(sonars) and green (camera), 2σ; the title says who is right.",
    presets={
        "behind the robot": {"direction": 160},
        "sideways": {"how": "sideways"},
        "a long skirt": {"how": "in a long skirt"},
        "turned away, behind": {"how": "turned away", "direction": -160},
    },
    axes=partial(figure, width=5.0, height=5.0),
    drag=Drag(("distance", "direction"), "the person", place),
    finding=lambda now: {sensor: now.sees(sensor) for sensor in SENSORS},
)


def found(how: str, *, ahead: bool | None = None) -> dict[str, tuple[int, int]]:
    """Return at how many of how many places each sensor finds somebody who stands in a way.

    ``ahead`` asks for the places of the half-plane that the laser sweeps, or for all others.
    """
    states = [standing.stood(**setting) for setting in STAND.parameters(how=how)]
    chosen = [now for now in states if ahead in (None, abs(now.direction) <= 90)]
    return {sensor: (sum(now.sees(sensor) for now in chosen), len(chosen)) for sensor in SENSORS}
