"""Valid calls of the modules of `ceiling` that drive: mapping and navigator."""

import numpy as np

from robot_perception.ceiling import mapping, navigator, tracker, visual_memory
from robot_perception.ceiling.contours import ContourRules
from robot_perception.ceiling.correction import Correction
from robot_perception.ceiling.mosaic import Links, Mosaic
from robot_perception.ceiling.patterns import PatternRules, WindowRules
from robot_perception.ceiling.recognition import RecognitionRules
from tests.hostile.calls._ceiling_patterns import IMAGE, PATTERN, POSES, rng
from tests.hostile.sweep import call

CENTRE = (39.5, 29.5)
MIDDLE = np.array(CENTRE)
FEW = tracker.TrackerRules(particles=9)
PARTS = (FEW, PatternRules(most=20), WindowRules((32, 30), 2, 2, 4), ContourRules())
RECOGNITION = RecognitionRules(refined=4)
RULES = mapping.MapRules(*PARTS, RECOGNITION, border=5.0)
MAPPER = mapping.Mapper(0.01, CENTRE, RULES)
PATTERNS, PLACES = {"a": PATTERN}, {"a": POSES[0]}
TRACKERS = mapping.PatternTrackers(PATTERNS, FEW, 5.0)
TRACKED = TRACKERS.start(PLACES)
NOWHERE = np.zeros(3)
MOSAIC = Mosaic({"a": NOWHERE, "b": np.array([0.1, 0.0, 0.0]), "c": NOWHERE}, 0.01, MIDDLE)
STATE = mapping.MapState(MOSAIC, PATTERNS | {"b": PATTERN, "c": PATTERN}, TRACKED, NOWHERE,
                         NOWHERE, Links().add(PLACES, MIDDLE, 0.01))  # fmt: skip
SEEN = np.ones((60, 80), bool)
FIX = Correction(np.diag([80.0, 80.0, 1.0]), np.eye(3), np.zeros(3), np.array([0.0, 0.0, -1.0]),
                 2.0, (80, 60))  # fmt: skip
SOUGHT = mapping.Sought.of(IMAGE)
THREE = {"a": POSES[0], "b": POSES[0] + [10, 0, 0, 0], "c": POSES[1]}
SERVO = visual_memory.ServoRules()
ROUTE = [visual_memory.KeyImage(PLACES)]
GRAPH = visual_memory.PathGraph().add("A", "B", ROUTE)
NAVIGATOR = navigator.Navigator(ROUTE, PATTERNS, MOSAIC, CENTRE, 0.01, SERVO, RULES)
REPLAY = navigator.ReplayState(TRACKED, NOWHERE)

CALLS = {
    mapping.MapRules: lambda: call(
        *PARTS, RECOGNITION, 4, 0.97, 30.0, 40.0, 0.3, 5, 6.0, "adjust", 5, "all", True
    ),
    mapping.MapState: lambda: call(
        MOSAIC, STATE.patterns, TRACKED, NOWHERE, NOWHERE, STATE.links, 1, (60, 80)
    ),
    mapping.Mapper: lambda: call(0.01, CENTRE, RULES, FIX),
    mapping.Mapper.start: lambda: call(MAPPER),
    mapping.Mapper.step: lambda: call(MAPPER, STATE, IMAGE, rng=rng()),
    mapping.Sought: lambda: call(IMAGE, SOUGHT.edges, SOUGHT.contours, SOUGHT.field, SEEN),
    mapping.Sought.of: lambda: call(IMAGE, ContourRules(), SEEN, 3),
    mapping.Sought.windows: lambda: call(SOUGHT, PARTS[2], np.zeros((1, 2)), 5.0),
    mapping.View: lambda: call(FIX, RULES),
    mapping.View.corrected: lambda: call(mapping.View(None, RULES), IMAGE),
    mapping.View.sought: lambda: call(mapping.View(None, RULES), IMAGE),
    mapping.View.trackers: lambda: call(mapping.View(None, RULES), PATTERNS),
    mapping.PatternTrackers: lambda: call(PATTERNS, FEW, 5.0, 3, SEEN),
    mapping.PatternTrackers.start: lambda: call(TRACKERS, PLACES),
    mapping.PatternTrackers.step: lambda: call(TRACKERS, TRACKED, IMAGE, rng=rng()),
    mapping.look_for: lambda: call(PLACES, PATTERNS, SOUGHT, RULES, rng=rng()),
    mapping.located: lambda: call(MOSAIC, THREE, "nearest"),
    mapping.agreeing: lambda: call(MOSAIC, THREE, RULES),
    mapping.consistent: lambda: call(MOSAIC, THREE, 6.0),
    mapping.retrace: lambda: call([MOSAIC], [THREE, PLACES], 6.0),
    mapping.inside: lambda: call(POSES[0], (60, 80), 5.0, SEEN),
    navigator.Navigator: lambda: call(
        ROUTE, PATTERNS, MOSAIC, CENTRE, 0.01, SERVO, RULES, 0.25, 5, FIX
    ),
    navigator.Navigator.start: lambda: call(NAVIGATOR, IMAGE, rng=rng()),
    navigator.Navigator.step: lambda: call(NAVIGATOR, REPLAY, IMAGE, rng=rng()),
    navigator.Navigator.between: lambda: call(
        GRAPH, "A", "B", PATTERNS, MOSAIC, CENTRE, 0.01, servo=SERVO
    ),
    navigator.Navigator.drive: lambda: call(
        NAVIGATOR, REPLAY, lambda: IMAGE, lambda speed, turn: None, rng=rng(), most=1
    ),
    navigator.ReplayState: lambda: call(TRACKED, NOWHERE, 0, 0, 0, (60, 80)),
}
