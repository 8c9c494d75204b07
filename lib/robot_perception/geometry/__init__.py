"""Angles and rigid motions of the plane; of space in `se3`, and planes seen in `homographies`."""

from robot_perception.geometry.angles import closes, wrap_angle
from robot_perception.geometry.se2 import act, between, compose, inverse, rotation

__all__ = ["act", "between", "closes", "compose", "inverse", "rotation", "wrap_angle"]
