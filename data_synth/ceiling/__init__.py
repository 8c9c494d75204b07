"""A ceiling, a robot below it whose camera looks up, and patches of ceilings on cluttered grounds.

They stand in for the office, the Peeke robot and the camera of the paper on navigating by the
ceiling, none of which is to be had.
"""

from data_synth.ceiling.camera import CeilingCamera, Exposure, Mount, Occluder
from data_synth.ceiling.clutter import clutter, grille_patch, patch, superimpose
from data_synth.ceiling.plane import Ceiling, Fixture, make_ceiling
from data_synth.ceiling.robot import drive, taught_path

__all__ = [
    "Ceiling",
    "CeilingCamera",
    "Exposure",
    "Fixture",
    "Mount",
    "Occluder",
    "clutter",
    "drive",
    "grille_patch",
    "make_ceiling",
    "patch",
    "superimpose",
    "taught_path",
]
