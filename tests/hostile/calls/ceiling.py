"""Valid calls of `ceiling`."""

import numpy as np

from robot_perception.ceiling import correction, mosaic, visual_memory
from tests.hostile.calls import _ceiling_driving, _ceiling_patterns
from tests.hostile.sweep import call

K = np.array([[30.0, 0, 16], [0, 30, 12], [0, 0, 1]])
DOWN, SHIFT = np.array([0.0, 0, -1]), np.array([0.1, 0, -0.1])
CORRECTION = correction.Correction(K, np.eye(3), SHIFT, DOWN, 2.0, (32, 24), (-0.1, 0.0))
CENTRE = np.array([160.0, 120])
SIGHTING = np.array([100.0, 90, 0.3, 1])
SIGHTINGS = {"a": SIGHTING, "b": SIGHTING + 20}
POSE = np.array([0.5, 0.2, 0.1])
MOSAIC = mosaic.Mosaic({"a": POSE, "b": POSE + 0.3}, 0.01, CENTRE)
LINKS = mosaic.Links().add(SIGHTINGS, CENTRE, 0.01)
KEY = visual_memory.KeyImage(SIGHTINGS)
KEYS, RULES = visual_memory.KeyRules(), visual_memory.ServoRules()
FOLLOWER = visual_memory.Follower([KEY], (15.5, 11.5))
GRAPH = visual_memory.PathGraph().add("A", "B", [KEY])

GEOMETRY = {
    correction.correction: lambda: call(K, np.eye(3), SHIFT, DOWN, 2.0, K),
    correction.Correction: lambda: call(K, np.eye(3), SHIFT, DOWN, 2.0, (32, 24), (-0.1, 0.0), K),
    correction.Correction.apply: lambda: call(CORRECTION, np.zeros((24, 32), np.uint8)),
    correction.Correction.points: lambda: call(CORRECTION, np.array([[16.0, 12], [4, 5]])),
    mosaic.in_camera: lambda: call(SIGHTING, centre=CENTRE, scale=0.01),
    mosaic.camera_pose: lambda: call(POSE, POSE),
    mosaic.between_patterns: lambda: call(SIGHTING, SIGHTING + 1, "inverse first"),
    mosaic.place: lambda: call(
        POSE, SIGHTING, SIGHTING, centre=CENTRE, scale=0.01, order="inverse first"
    ),
    mosaic.align: lambda: call(np.eye(3), np.eye(3) + 0.1, np.ones(3), np.ones(3)),
    mosaic.Mosaic: lambda: call({"a": POSE}, 0.01, CENTRE),
    mosaic.Mosaic.with_pattern: lambda: call(MOSAIC, "c", POSE),
    mosaic.Mosaic.locate: lambda: call(
        MOSAIC, SIGHTINGS, {"a": 1.0}, sigma_px=1.0, sigma_heading=0.02
    ),
    mosaic.Mosaic.expected: lambda: call(MOSAIC, POSE, "a"),
    mosaic.Links: lambda: call(),
    mosaic.Links.add: lambda: call(LINKS, SIGHTINGS, CENTRE, 0.01),
    mosaic.Links.means: lambda: call(LINKS),
    mosaic.Links.groups: lambda: call(LINKS, ["a", "b"]),
    mosaic.pieces: lambda: call(MOSAIC, LINKS),
    mosaic.adjust: lambda: call(
        MOSAIC, LINKS, fixed="a", sigma_px=1.0, sigma_heading=0.02, loss="linear"
    ),
    mosaic.paint: lambda: call(
        [np.zeros((24, 32), np.uint8)], POSE[None], centre=np.array([15.5, 11.5]), scale=0.01
    ),
    visual_memory.KeyImage: lambda: call(SIGHTINGS),
    visual_memory.KeyRules: lambda: call(0.2, 1, 100.0),
    visual_memory.choose_key_images: lambda: call([SIGHTINGS, SIGHTINGS], KEYS),
    visual_memory.breaches: lambda: call([KEY, KEY], KEYS),
    visual_memory.PathGraph: lambda: call(KEYS),
    visual_memory.PathGraph.add: lambda: call(GRAPH, "A", "B", [KEY]),
    visual_memory.PathGraph.route: lambda: call(GRAPH, "A", "B"),
    visual_memory.relative_pose: lambda: call(
        SIGHTINGS,
        KEY,
        centre=CENTRE,
        scale=0.01,
        offset=POSE,
        sigma_px=1.0,
        sigma_heading=0.02,
    ),
    visual_memory.ServoRules: lambda: call(0.3, 1.5, -0.7, 0.3, 1.0, 0.05),
    visual_memory.servo: lambda: call(POSE, RULES),
    visual_memory.passed: lambda: call(POSE, RULES),
    visual_memory.Follower: lambda: call([KEY], (15.5, 11.5), 0.01, RULES, 0.25, True, MOSAIC),
    visual_memory.Follower.steer: lambda: call(FOLLOWER, SIGHTINGS, 0),
    visual_memory.Follower.drive: lambda: call(
        FOLLOWER, lambda: SIGHTINGS, lambda speed, turn: None, key=0, most=3
    ),
    visual_memory.closed_loop: lambda: call(
        FOLLOWER.steer, lambda: SIGHTINGS, lambda speed, turn: None, most=3
    ),
}
CALLS = GEOMETRY | _ceiling_patterns.CALLS | _ceiling_driving.CALLS
