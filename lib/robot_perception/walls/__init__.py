"""Walls from laser scans: chains, segments with covariance, and maps merged over scans."""

from robot_perception.walls.chains import (
    count_distances,
    find_split,
    simplify,
    simplify_recursive,
)
from robot_perception.walls.path_hulls import count_hull_steps, simplify_path_hull
from robot_perception.walls.simplicity import find_crossings, is_simple, require_simple

__all__ = [
    "count_distances",
    "count_hull_steps",
    "find_crossings",
    "find_split",
    "is_simple",
    "require_simple",
    "simplify",
    "simplify_path_hull",
    "simplify_recursive",
]
