"""The real recordings of the chapter "Anchored SLAM": five robots, a car among trees, a building.

No claim of the paper rests on them: its own recording is unavailable.
"""

from robot_perception.chapters.anchored_slam.intel import INTEL
from robot_perception.chapters.anchored_slam.mrclam import UTIAS, robots
from robot_perception.chapters.anchored_slam.victoria import VICTORIA

__all__ = ["INTEL", "UTIAS", "VICTORIA", "robots"]
