"""Walls are fitted to laser scans: chains, segments with covariance, and maps merged over scans."""

from robot_perception.walls.chains import (
    count_distances,
    find_split,
    simplify,
    simplify_recursive,
)
from robot_perception.walls.corners import (
    LandmarkReport,
    LandmarkRules,
    find_corners,
    find_landmarks,
    find_poles,
    fit_pole,
)
from robot_perception.walls.fewest import simplify_fewest
from robot_perception.walls.mapper import WallInfo, WallMapper, build_map
from robot_perception.walls.path_hulls import count_hull_steps, simplify_path_hull
from robot_perception.walls.scores import (
    MapScore,
    distance_to_segments,
    explained,
    sample_faces,
    score_map,
)
from robot_perception.walls.segments import (
    Extraction,
    RangeNoise,
    ScanReport,
    Segments,
    extract_segments,
    find_breaks,
    fit_line,
    project,
    to_points,
)
from robot_perception.walls.simplicity import (
    count_sweep_steps,
    find_crossings,
    is_simple,
    require_simple,
)
from robot_perception.walls.wall_map import (
    Gate,
    WallMap,
    merge,
    search,
    seen_from,
    to_world,
)

__all__ = [
    "Extraction",
    "Gate",
    "LandmarkReport",
    "LandmarkRules",
    "MapScore",
    "RangeNoise",
    "ScanReport",
    "Segments",
    "WallInfo",
    "WallMap",
    "WallMapper",
    "build_map",
    "count_distances",
    "count_hull_steps",
    "count_sweep_steps",
    "distance_to_segments",
    "explained",
    "extract_segments",
    "find_breaks",
    "find_corners",
    "find_crossings",
    "find_landmarks",
    "find_poles",
    "find_split",
    "fit_line",
    "fit_pole",
    "is_simple",
    "merge",
    "project",
    "require_simple",
    "sample_faces",
    "score_map",
    "search",
    "seen_from",
    "simplify",
    "simplify_fewest",
    "simplify_path_hull",
    "simplify_recursive",
    "to_points",
    "to_world",
]
