"""Valid calls of `people`."""

import numpy as np

from robot_perception import people
from robot_perception.beliefs import ParticleSet
from robot_perception.people import (
    Detections,
    aggregation,
    behaviours,
    legs,
    places,
    robot,
    scores,
    skin,
    sonar,
    sound,
    tracker,
    trajectories,
    verification,
    walking,
)
from tests.hostile.sweep import call
from tests.people import scenes

SCAN = scenes.legs([[1.5, 0.2], [1.5, -0.1]], 0.07)
PROFILES = legs.profiles(SCAN, scenes.LASER)
NOBODY = people.polar(np.zeros(0), np.zeros(0), 0.1, 0.1)
RING = np.deg2rad(np.arange(-165.0, 180.0, 30.0))
PIXELS = np.array([[110, 140, 200], [120, 150, 210]], dtype=np.uint8)
MODEL = scenes.model()
TRACKER = skin.SkinTracker(scenes.CENTRE, scenes.FOCAL, scenes.SIZE, MODEL)
FACE = scenes.picture([(0.7, 0.3, 0.1)])
START = TRACKER.start()
TRACKER.step(START, FACE, rng=np.random.default_rng(0))
SQUARE = np.array([[0.15, 0], [0, 0.15], [-0.15, 0], [0, -0.15]])
CLICKS = np.random.default_rng(0).standard_normal((4, 400))
CLOUD = skin.Cloud(ParticleSet.uniform(np.full((50, 2), 0.3)))


def nowhere(points: np.ndarray) -> np.ndarray:
    return np.zeros(len(points), dtype=bool)


RULES = aggregation.AggregationRules()
AGGREGATOR = aggregation.Aggregator(RULES)
SEEN = Detections(1.0, "laser", people.polar(np.array([1.0, 2]), np.array([0.5, 3]), 0.1, 0.1))
THERE, _ = AGGREGATOR.step(AGGREGATOR.start(), SEEN, np.zeros(3))
AGAIN = Detections(1.1, "laser", SEEN.positions)
STAYS, _ = trajectories.watch(
    trajectories.Stays.none(), THERE, np.zeros(3), trajectories.StaticRules()
)
WALKS = walking.watch_walks(walking.Walks.none(), THERE, np.zeros(3), walking.WalkRules())
FRAME = scores.Frame(THERE.points, THERE.identity, THERE.points, THERE.identity)
BUSY = behaviours.State("busy", 0, 1.0, 0.5)
PEOPLE = tracker.PeopleTracker()
TRACKED, _ = PEOPLE.step(PEOPLE.start(np.zeros(3)), SEEN, np.zeros(3))
GUIDE = robot.ServiceRobot("guide")
KNOWS = robot.RobotState(TRACKED, np.zeros(len(TRACKED.hypotheses), dtype=bool), BUSY, np.ones(3))
AHEAD = np.array([[1.0, 1.0], [1.5, 1.2], [2.0, 1.4]])
BEHAVIOURS, VERIFIER = behaviours.Behaviours(), verification.Verifier(0.2)

CALLS = {
    Detections: lambda: call(1.0, "laser", NOBODY),
    people.polar: lambda: call(np.ones(2), np.array([0.5, 4.0]), 0.1, np.array([0.1, 0.2])),
    legs.LegRules: lambda: call(0.1, 2, (0.05, 0.25), 0.04, 0.015, (0.1, 0.5), 0.1, 0.1),
    legs.are_legs: lambda: call(PROFILES, legs.LegRules()),
    legs.detect: lambda: call(SCAN, scenes.LASER, legs.LegRules()),
    legs.pairs: lambda: call(PROFILES.middles, legs.LegRules()),
    legs.profiles: lambda: call(SCAN, scenes.LASER, legs.LegRules()),
    legs.segments: lambda: call(SCAN, scenes.LASER, legs.LegRules()),
    sonar.SonarRules: lambda: call(2.0, 0.5, 0.1, 0.3, 0.2),
    sonar.detect: lambda: call(np.full(12, 1.5), RING, 0.2, sonar.SonarRules(), nowhere),
    skin.SkinModel: lambda: call(np.zeros((8, 8)), 45.0),
    skin.SkinModel.fit: lambda: call(PIXELS, PIXELS + 9, bins=64, darkest=45.0, floor=1e-4),
    skin.SkinModel.log_ratio: lambda: call(MODEL, PIXELS),
    skin.SkinRules: lambda: call(
        *(50, 400, (0.05, 0.8), 0.01, (0.05, 0.07), 0.1, 0.1, 0.5, (0.15, 0.05), 0.12, 3, 3),
        *(2.0, 2.0),
    ),
    skin.SkinState: lambda: call((CLOUD,)),
    skin.SkinTracker: lambda: call(
        scenes.CENTRE, scenes.FOCAL, scenes.SIZE, MODEL, skin.SkinRules()
    ),
    skin.SkinTracker.detect: lambda: call(TRACKER, skin.SkinState((CLOUD,))),
    skin.SkinTracker.skin: lambda: call(TRACKER, FACE),
    skin.SkinTracker.start: lambda: call(TRACKER),
    skin.SkinTracker.step: lambda: call(
        *(TRACKER, skin.SkinState((CLOUD,)), FACE),
        rng=np.random.default_rng(0),
        elapsed=0.1,
        turned=0.1,
    ),
    sound.SoundRules: lambda: call(
        *((500.0, 4000.0), 4.0, 0.1, 0.15, 0.4, 2, 0.3, 0.05, 0.2, 343.0, 2.0, 2.0)
    ),
    sound.arrivals: lambda: call(SQUARE, np.array([0.5, 4.0]), 343.0),
    sound.background: lambda: call(CLICKS[None]),
    sound.gcc_phat: lambda: call(CLICKS, np.arange(201) % 200 > 0),
    sound.detect: lambda: call(CLICKS, SQUARE, 16000.0, np.ones(201), sound.SoundRules()),
    aggregation.SensorRules: lambda: call(0.3, 2.0, 0.4),
    aggregation.SensorRules.sees: lambda: call(RULES.sensors["laser"], THERE.mean),
    aggregation.AggregationRules: lambda: call(
        *(0.2, 0.5, 0.99, 1.0, 0.5, "kalman", "least trace"), *(RULES.sensors,)
    ),
    aggregation.Hypotheses: lambda: call(
        *(THERE.mean, THERE.cov, THERE.weight, THERE.identity, THERE.born, THERE.last_seen),
        *(THERE.charged, THERE.heard, THERE.following),
    ),
    aggregation.Hypotheses.none: call,
    aggregation.Hypotheses.persons: lambda: call(THERE, RULES),
    aggregation.Hypotheses.select: lambda: call(THERE, np.array([True, False])),
    aggregation.Aggregator: lambda: call(RULES),
    aggregation.Aggregator.start: lambda: call(AGGREGATOR),
    aggregation.Aggregator.step: lambda: call(AGGREGATOR, THERE, AGAIN, np.array([0.1, 0.0, 0.2])),
    aggregation.predict: lambda: call(THERE, 0.1, np.array([0.1, 0.0, 0.2]), 0.5),
    trajectories.trajectories: lambda: call([THERE, THERE], np.ones((2, 3))),
    trajectories.StaticRules: lambda: call(0.4, 20.0),
    trajectories.Stays: lambda: call(STAYS.identity, STAYS.place, STAYS.since),
    trajectories.Stays.none: call,
    trajectories.watch: lambda: call(STAYS, THERE, np.ones(3), trajectories.StaticRules()),
    walking.WalkRules: lambda: call(0.8, 1.5, 0.45, 2.0, 0.15, 3.0),
    walking.Walks: lambda: call(
        WALKS.identity, WALKS.since, WALKS.start, WALKS.last, WALKS.walked, WALKS.seen
    ),
    walking.Walks.none: call,
    walking.Walks.have_walked: lambda: call(WALKS, walking.WalkRules()),
    walking.Walks.are_known: lambda: call(WALKS, 1.5, walking.WalkRules()),
    walking.watch_walks: lambda: call(WALKS, THERE, np.ones(3), walking.WalkRules()),
    tracker.PeopleTracker: lambda: call(RULES, trajectories.StaticRules()),
    tracker.PeopleState: lambda: call(THERE, STAYS, np.ones(3)),
    tracker.PeopleTracker.start: lambda: call(PEOPLE, np.ones(3)),
    tracker.PeopleTracker.step: lambda: call(PEOPLE, TRACKED, AGAIN, np.ones(3)),
    verification.Verifier: lambda: call(0.2),
    verification.Verifier.start: lambda: call(VERIFIER),
    verification.Verifier.step: lambda: call(VERIFIER, frozenset({0}), THERE, np.array([0.5, 4.0])),
    places.points: lambda: call(np.array([[1.0, 0.5], [2.0, 4.0]])),
    places.pairs_within: lambda: call(np.array([[0.1, 0.3], [0.2, 0.9]]), 0.4),
    scores.Frame: lambda: call(THERE.points, THERE.identity, THERE.points, THERE.identity),
    scores.score: lambda: call([FRAME, FRAME], 0.5),
    scores.gospa: lambda: call(THERE.points, np.ones((3, 2)), 1.0),
    behaviours.State: lambda: call("busy", 0, 1.0, 0.5),
    behaviours.Behaviours: lambda: call(3.0, 1.5, 1.0, 3.0, 20.0, 1.0, 0.8, 1.0, 1.0),
    behaviours.roles: lambda: call(THERE, np.array([True, False]), BUSY, 0.4, 1.2),
    behaviours.blocks: lambda: call(np.ones((2, 2)), np.eye(2), 0.8),
    behaviours.Behaviours.guide: lambda: call(BEHAVIOURS, BUSY, THERE, False),
    behaviours.Behaviours.follow: lambda: call(BEHAVIOURS, BUSY, THERE),
    behaviours.Behaviours.survey: lambda: call(BEHAVIOURS, BUSY, THERE, False),
    robot.RobotState: lambda: call(KNOWS.people, KNOWS.static, BUSY, np.ones(3)),
    robot.ServiceRobot: lambda: call("guide", BEHAVIOURS, PEOPLE, 1.2, 1.0, 15),
    robot.ServiceRobot.start: lambda: call(GUIDE, np.ones(3)),
    robot.ServiceRobot.step: lambda: call(GUIDE, KNOWS, AGAIN, np.ones(3)),
    robot.ServiceRobot.act: lambda: call(GUIDE, KNOWS, np.ones(3), AHEAD, finished=False),
    robot.ServiceRobot.roles: lambda: call(GUIDE, KNOWS),
    robot.ServiceRobot.is_blocked: lambda: call(GUIDE, KNOWS, AHEAD),
    robot.upcoming: lambda: call(AHEAD, np.ones(3)),
    robot.velocity: lambda: call(
        *(behaviours.Command(0.5), np.ones(3), AHEAD), ahead=1, slow=0.6, gain=1.5, turn_rate=1.0
    ),
}
