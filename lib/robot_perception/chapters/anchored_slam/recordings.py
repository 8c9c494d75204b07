"""The real recordings of the chapter "Anchored SLAM": five robots, a car among trees, a building.

No claim of the paper rests on them, for its own recording is not to be had.
"""

from robot_perception.chapters.anchored_slam.intel import INTEL, relation_table
from robot_perception.chapters.anchored_slam.mrclam import (
    ANCHORS,
    METHODS,
    UTIAS,
    method_table,
    robot_table,
    sensor_table,
    summary,
)
from robot_perception.chapters.anchored_slam.victoria import VICTORIA

__all__ = [
    "ANCHORS",
    "INTEL",
    "METHODS",
    "RECORDINGS",
    "UTIAS",
    "VICTORIA",
    "method_table",
    "relation_table",
    "robot_table",
    "sensor_table",
    "summary",
]

RECORDINGS = (UTIAS, VICTORIA, INTEL)
