"""People in an office, and what a robot's laser, sonars and fisheye camera make of them.

The paper's robot stood among people in an office that nobody recorded; this one stands in for it.
What microphones hear of them is in :mod:`data_synth.people.sound`.
Frames: the robot looks along its first axis, the second points left; directions are counted
counter-clockwise from ahead.
"""

from data_synth.people.bodies import Person, legs, make_person, skin
from data_synth.people.office import PeopleOffice, make_people_office
from data_synth.people.session import Session, make_session, readings, record
from data_synth.people.signals import (
    LASER_ANGLES,
    SONAR_ANGLES,
    FisheyeImage,
    LaserScan,
    Rig,
    Sensing,
    SonarScan,
    Truth,
    truth,
)
from data_synth.people.world import STEP, Moment, Visit, Walk, Wander, World, walk

__all__ = [
    "LASER_ANGLES",
    "SONAR_ANGLES",
    "STEP",
    "FisheyeImage",
    "LaserScan",
    "Moment",
    "PeopleOffice",
    "Person",
    "Rig",
    "Sensing",
    "Session",
    "SonarScan",
    "Truth",
    "Visit",
    "Walk",
    "Wander",
    "World",
    "legs",
    "make_people_office",
    "make_person",
    "make_session",
    "readings",
    "record",
    "skin",
    "truth",
    "walk",
]
