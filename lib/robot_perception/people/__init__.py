"""People around a robot: what each sensor takes for one, in distance and direction about it."""

from robot_perception.people.detections import Detections, polar

__all__ = ["Detections", "polar"]
