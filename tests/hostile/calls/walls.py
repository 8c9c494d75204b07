"""Valid calls of `walls`."""

import numpy as np

from robot_perception import walls
from robot_perception.walls import Extraction, Gate, LandmarkRules, RangeNoise, WallMap
from tests.hostile.sweep import call

CHAIN = np.array([[0.0, 0], [1, 1], [2, 0], [3, 1]])
CROSSED = np.array([[0.0, 0], [2, 2], [2, 0], [0, 2]])
ANGLES = np.linspace(-1.5, 1.5, 151)
RANGES = np.minimum(2 / np.cos(ANGLES), 3 / np.maximum(np.abs(np.sin(ANGLES)), 1e-9))
SEGMENTS = walls.extract_segments(RANGES, ANGLES, Extraction())[0]
POSES = np.array([[0.0, 0, 0], [0.1, 0, 0]])
SCANS = np.stack([RANGES, RANGES])
MAP = walls.build_map(SCANS, ANGLES, POSES, Extraction(), Gate())[0]
FACES = MAP.ends
SEEN = np.ones(len(walls.sample_faces(FACES)[0]), dtype=bool)
MAPPER = walls.WallMapper(ANGLES, Extraction(), Gate(), 0.01 * np.eye(3))
POLE = np.array([[1.0, 0.1], [0.98, 0.0], [1.0, -0.1]])
for kernel in (
    walls.count_hull_steps,
    walls.simplify,
    walls.simplify_fewest,
):  # compiled before the clock runs
    kernel(CHAIN, 0.1)
walls.find_crossings(CROSSED)

CALLS = {
    RangeNoise: lambda: call(0.02, 0.001),
    Extraction: lambda: call(RangeNoise(), 0.08, 0.2, 6, 0.4),
    Gate: lambda: call(0.99, 0.02, 0.02, 0.5),
    LandmarkRules: lambda: call(Extraction(), 0.7, 0.1, 0.003, 0.15, 5, 0.15),
    WallMap.empty: lambda: call(),
    WallMap.seen_in: lambda: call(MAP, 1),
    walls.WallMapper: lambda: call(ANGLES, Extraction(), Gate(), 0.01 * np.eye(3)),
    walls.WallMapper.start: lambda: call(MAPPER),
    walls.WallMapper.step: lambda: call(MAPPER, MAP, RANGES, POSES[1]),
    walls.build_map: lambda: call(
        SCANS, ANGLES, POSES, Extraction(), Gate(), pose_cov=0.01 * np.eye(3)
    ),
    walls.count_distances: lambda: call(CHAIN, 0.1),
    walls.count_hull_steps: lambda: call(CHAIN, 0.1),
    walls.count_sweep_steps: lambda: call(CHAIN),
    walls.distance_to_segments: lambda: call(CHAIN, FACES),
    walls.explained: lambda: call(CHAIN, MAP, 0.1),
    walls.extract_segments: lambda: call(RANGES, ANGLES, Extraction()),
    walls.find_breaks: lambda: call(RANGES, ANGLES, RangeNoise(), 0.2),
    walls.find_corners: lambda: call(SEGMENTS, ANGLES, LandmarkRules()),
    walls.find_crossings: lambda: call(CROSSED, at_most=5),
    walls.find_landmarks: lambda: call(RANGES, ANGLES, LandmarkRules()),
    walls.find_poles: lambda: call(RANGES, ANGLES, LandmarkRules()),
    walls.find_split: lambda: call(CHAIN, 0, 3),
    walls.fit_line: lambda: call(np.array([2.0, 2.1]), np.array([0.0, 0.1]), RangeNoise()),
    walls.fit_pole: lambda: call(POLE, 0.15, 0.02),
    walls.is_simple: lambda: call(CHAIN),
    walls.merge: lambda: call(MAP, SEGMENTS, Gate()),
    walls.project: lambda: call(np.array([1.0, 0.5]), CHAIN),
    walls.require_simple: lambda: call(CHAIN),
    walls.sample_faces: lambda: call(FACES),
    walls.score_map: lambda: call(MAP, FACES, SEEN, reach=0.05, turn=0.1),
    walls.search: lambda: call(MAP, SEGMENTS, 0, Gate()),
    walls.seen_from: lambda: call(MAP.lines, MAP.covs, np.array([1.0, 2.0])),
    walls.simplify: lambda: call(CHAIN, 0.1),
    walls.simplify_fewest: lambda: call(CHAIN, 0.1),
    walls.simplify_path_hull: lambda: call(CHAIN, 0.1, assume_simple=True),
    walls.simplify_recursive: lambda: call(CHAIN, 0.1),
    walls.to_points: lambda: call(RANGES, ANGLES),
    walls.to_world: lambda: call(SEGMENTS, POSES[1], 0.01 * np.eye(3)),
}
