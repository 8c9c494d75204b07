"""Valid calls of `slam`."""

from dataclasses import fields, replace

import numpy as np
import sympy

from robot_perception.beliefs import Gaussian, ParticleSet
from robot_perception.observations import Observations
from robot_perception.particles import effective_number, systematic
from robot_perception.slam import (
    localisation,
    monobot,
    observability,
    planar,
    rao_blackwellised,
    visual,
)
from robot_perception.slam.observability import symbolic
from robot_perception.slam.planar import calibration, textbook
from robot_perception.slam.rao_blackwellised import textbook as one_by_one
from robot_perception.streams import Held
from tests.hostile.calls import observations
from tests.hostile.sweep import call
from tests.slam.planar.logged import make_robot

EYE, Q = np.eye(2), np.eye(3)
POSE = np.array([1.0, 2.0, 0.5])

START, MEASUREMENTS, STEPS = Gaussian(np.zeros(1), np.eye(1)), np.ones((2, 4, 3)), np.ones(3)
REFERENCE = monobot.Reference(1, np.ones((2, 3)), 0.1)
NOISES = {"motion_variance": 0.1, "measurement_variance": 0.2}

RANGES, POINTS = planar.RangeBearing(0.01 * EYE), planar.CartesianSensor(0.01 * EYE)
BELIEF = planar.MapBelief(np.arange(5.0), np.eye(5), np.array([4]))
ANCHORS = {7: np.array([3.0, 3.0])}
SEEN, NEW = (
    Observations(np.array([4]), np.ones((1, 2))),
    Observations(np.array([5]), np.ones((1, 2))),
)
MOTION = planar.Odometry(np.ones(3), Q)
STEP = planar.Step(MOTION, SEEN, (planar.Compass(0.5, 0.1),), 1.0)
TRUTH = planar.Truth(np.zeros((2, 3)), {4: np.ones(2)})
SETTINGS = planar.Settings(POINTS)
HISTORY = planar.run_filter(BELIEF, [STEP], SETTINGS)
TIMELESS = planar.run_filter(BELIEF, [replace(STEP, time=None)], SETTINGS)
UNAIDED = planar.Step(MOTION, SEEN)

ROBOT = make_robot(np.random.default_rng(0), seconds=12.0)
SIGHTINGS = ROBOT.landmarks.times, ROBOT.landmarks.subjects, ROBOT.landmarks.values
SURVEY = {6: np.array([4.0, 0]), 7: np.array([0, 4.0]), 8: np.array([-4.0, 0]), 9: -4.0 * EYE[1]}
SURVEYED = {"places": SURVEY, "truth": ROBOT.truth}
CALIBRATED = calibration.Calibration(
    0.1, np.ones(2), 0.1, np.ones(2), np.zeros(2), np.ones(2), np.zeros(2), 0.3, 0
)

STATE, ABOUT = np.arange(5.0), np.ones(2)
SENSORS = (observability.Landmarks(), observability.Anchor(8.0, 9.0))
ANALYSIS = observability.analyse(np.eye(2, 3))
X, SYMBOLIC = symbolic.state(1), (observability.Position(), observability.Heading())

MOUNT = rao_blackwellised.forward_mount(1.0)
PARTICLES = ParticleSet.uniform(np.array([[0.0, 0.0, 0.1], [0.1, 0.0, 0.0]]))
PLACES, SPREADS = np.full((2, 1, 3), 2.0), np.tile(0.1 * Q, (2, 1, 1, 1))
MAPS = rao_blackwellised.ParticleMaps(PARTICLES, np.array([4]), PLACES, SPREADS)
POINT, OTHER = (
    Observations(np.array([name]), np.array([[-2.0, -1.0, 2.0]]), 0.1 * Q[None]) for name in (4, 5)
)
NAMED = rao_blackwellised.RaoBlackwellisedSlam(MOUNT, 2)
LOOKS = np.ones((1, 4))
FEW = visual.Options(2, 0)
SLAM = visual.VisualSlam(MOUNT, FEW)
VISUAL, _ = SLAM.step(
    SLAM.start(POSE, length=4),
    None,
    POINT,
    LOOKS,
    costs=lambda asked: np.ones((1, 1)),
    rng=np.random.default_rng(0),
)
MARKS = localisation.LandmarkMap(
    np.array([[2.0, 1.0, 0.5], [3.0, -1.0, 1.5]]),
    np.tile(0.1 * Q, (2, 1, 1)),
    visual.Looks(np.eye(2, 4), np.eye(2, 4), np.zeros((2, 4)), np.array([1, 2])),
)
FINDER = localisation.MapLocaliser(MARKS, MOUNT, localisation.LocaliserRules(20))
FOUND = FINDER.start(rng=np.random.default_rng(0))
PAIR = Observations(
    np.array([-1, -1]), np.array([[-1.0, 0.5, 2.0], [1.0, -0.5, 3.0]]), np.tile(0.1 * Q, (2, 1, 1))
)
PARTICLE = one_by_one.Particle(POSE, {4: Gaussian(np.full(3, 2.0), 0.1 * Q)})


def drawing(**more):
    """Return arguments of functions that draw particles anew."""
    scheme = {"share": 1.0, "criterion": effective_number, "scheme": systematic}
    return {"rng": np.random.default_rng(0), **scheme, **more}


def gated(**more):
    """Return arguments of association."""
    return {"costs": np.ones((1, 1)), "limit": 2.0, "level": 0.9, **more}


OFFERED_TOO = (Observations, Observations.anonymous, Observations.named)
INNER = {
    *(getattr(planar.CartesianSensor, name) for name in ("check", "expect", "residual")),
    *(getattr(planar.RangeBearing, name) for name in ("check", "expect", "residual")),
    *(getattr(planar.CartesianSensor, name) for name in ("locate", "locate_jacobians")),
    *(getattr(planar.RangeBearing, name) for name in ("locate", "locate_jacobians")),
    observability.Anchor.see,
    observability.Heading.see,
    observability.Landmarks.see,
    observability.Position.see,
    planar.PositionFix.residual,
    planar.Compass.residual,
}
"""What the filter and the analyses ask of a sensor at every step, with arrays of their own."""

CALLS = {
    **{thing: observations.CALLS[thing] for thing in OFFERED_TOO},
    monobot.sensor_matrix: lambda: call(2),
    monobot.motion: lambda: call(0.5, 0.1, 2),
    monobot.first_measurement: lambda: call(START, np.ones(2), 0.1),
    monobot.Reference: lambda: call(-1, np.ones((2, 3)), 0.1, 5.0),
    monobot.Reference.matrix: lambda: call(REFERENCE, 2),
    monobot.run_filter: lambda: call(START, STEPS, MEASUREMENTS, **NOISES),
    monobot.run_filter_stepwise: lambda: call(START, STEPS, MEASUREMENTS, **NOISES),
    monobot.run_referenced: lambda: call(START, STEPS, MEASUREMENTS, REFERENCE, **NOISES),
    monobot.settled: lambda: call(2, start_variance=0.0, **NOISES),
    monobot.relative_system: lambda: call(2, **NOISES),
    planar.Association: lambda: call("gated", 0.9, 0.99),
    planar.CartesianSensor: lambda: call(EYE),
    planar.RangeBearing: lambda: call(EYE, 0.1),
    planar.Compass: lambda: call(0.5, 0.1),
    planar.Compass.matrix: lambda: call(planar.Compass(0.5, 0.1)),
    planar.Compass.covariance: lambda: call(planar.Compass(0.5, 0.1)),
    planar.PositionFix: lambda: call(np.ones(2), EYE),
    planar.PositionFix.matrix: lambda: call(planar.PositionFix(np.ones(2), EYE)),
    planar.PositionFix.covariance: lambda: call(planar.PositionFix(np.ones(2), EYE)),
    planar.MapBelief: lambda: call(np.zeros(5), np.eye(5), np.array([4])),
    planar.MapBelief.start: lambda: call(POSE, Q),
    planar.MapBelief.slot: lambda: call(BELIEF, 4),
    planar.MapBelief.landmark: lambda: call(BELIEF, 4),
    planar.Odometry: lambda: call(np.ones(3), Q),
    planar.Odometry.move: lambda: call(MOTION, POSE),
    planar.Odometry.jacobians: lambda: call(MOTION, POSE),
    planar.Velocity: lambda: call(1.0, 0.1, 0.5, EYE),
    planar.Velocity.move: lambda: call(planar.Velocity(1.0, 0.1, 0.5, EYE), POSE),
    planar.Velocity.jacobians: lambda: call(planar.Velocity(1.0, 0.1, 0.5, EYE), POSE),
    planar.dead_reckoning: lambda: call(POSE, [MOTION, None]),
    planar.compound: lambda: call(Held(np.ones((1, 2)), np.ones(1), np.array([0])), np.ones(2)),
    planar.Step: lambda: call(MOTION, SEEN, (planar.Compass(0.5, 0.1),), 1.0),
    planar.Truth: lambda: call(np.zeros((2, 3)), {4: np.ones(2)}),
    planar.Settings: lambda: call(POINTS, ANCHORS, "gated", TRUTH, 50, "consider", [0]),
    planar.run_filter: lambda: call(BELIEF, [STEP], SETTINGS),
    planar.smooth: lambda: call([UNAIDED], HISTORY, POINTS),
    planar.History: lambda: call(*(getattr(TIMELESS, field.name) for field in fields(TIMELESS))),
    planar.History.to_csv: lambda: call(HISTORY, "path.csv", overwrite=True),
    planar.History.to_tum: lambda: call(HISTORY, "path.txt", overwrite=True),
    planar.predict: lambda: call(BELIEF, MOTION, POSE, POSE),
    planar.update: lambda: call(BELIEF, SEEN, RANGES, ANCHORS, STATE),
    planar.correct: lambda: call(BELIEF, planar.PositionFix(np.ones(2), EYE)),
    planar.add_landmarks: lambda: call(BELIEF, NEW, POINTS, POSE),
    textbook.motion_matrix: lambda: call(STATE, POSE),
    textbook.measurement_matrix: lambda: call(STATE, [3, None], np.ones((2, 2)), POINTS),
    textbook.predict: lambda: call(BELIEF, MOTION, POSE, POSE),
    textbook.update: lambda: call(BELIEF, SEEN, RANGES, ANCHORS, STATE),
    calibration.calibrate: lambda: call(
        ROBOT.commands.times,
        ROBOT.commands.velocities,
        *SIGHTINGS,
        **SURVEYED,
        delays=np.array([0.1, 0.2]),
    ),
    calibration.make_steps: lambda: call(
        CALIBRATED, ROBOT.commands.times, ROBOT.commands.velocities, *SIGHTINGS, pause=0.5
    ),
    calibration.sighting_errors: lambda: call(SIGHTINGS[0] + 3.0, *SIGHTINGS[1:], **SURVEYED),
    calibration.is_right: lambda: call(np.zeros((3, 2)), np.zeros(2)),
    calibration.pooled: lambda: call([CALIBRATED]),
    calibration.calibrate_odometry: lambda: call(
        np.tile(POSE, (3, 1)) * [[1], [2], [4]], np.eye(3)
    ),
    calibration.name_landmarks: lambda: call(np.tile(POSE, (2, 1)), iter([SEEN, SEEN]), 0.3),
    textbook.correct: lambda: call(BELIEF, planar.PositionFix(np.ones(2), EYE)),
    textbook.add_landmarks: lambda: call(BELIEF, NEW, POINTS, POSE),
    rao_blackwellised.ParticleMaps: lambda: call(PARTICLES, np.array([4]), PLACES, SPREADS),
    rao_blackwellised.ParticleMaps.start: lambda: call(POSE, 2),
    rao_blackwellised.ParticleMaps.landmarks: lambda: call(MAPS, 1),
    rao_blackwellised.forward_mount: lambda: call(1.0, 0.2, 0.1),
    rao_blackwellised.predict: lambda: call(MAPS, MOTION, rng=np.random.default_rng(0)),
    rao_blackwellised.update: lambda: call(
        MAPS, POINT, MOUNT, np.array([[4], [-1]]), unmatched_density=0.5
    ),
    rao_blackwellised.add_landmarks: lambda: call(MAPS, OTHER, MOUNT, np.ones((2, 1), dtype=bool)),
    rao_blackwellised.resample: lambda: call(MAPS, **drawing()),
    rao_blackwellised.RaoBlackwellisedSlam: lambda: call(
        MOUNT, 2, 1.0, effective_number, systematic
    ),
    rao_blackwellised.RaoBlackwellisedSlam.start: lambda: call(NAMED, POSE),
    rao_blackwellised.RaoBlackwellisedSlam.step: lambda: call(
        NAMED, MAPS, MOTION, POINT, rng=np.random.default_rng(0)
    ),
    rao_blackwellised.printed_number: lambda: call(np.zeros(2)),
    rao_blackwellised.lineage: lambda: call([np.array([0, 0]), np.array([1, 0])]),
    rao_blackwellised.paths: lambda: call(
        [np.ones((2, 3)), np.zeros((2, 3))], [np.array([0, 0]), np.array([1, 0])]
    ),
    rao_blackwellised.associate_shared: lambda: call(
        MAPS, POINT.anonymous(), MOUNT, **gated(by="best")
    ),
    rao_blackwellised.associate_each: lambda: call(
        MAPS, POINT.anonymous(), MOUNT, np.array([[4], [-1]]), **gated()
    ),
    visual.Options: lambda: call(10, 5, 0.5, "printed", 150.0, 0.99, 0.3, 2.0, "each", 0.5, 1),
    visual.VisualSlam: lambda: call(MOUNT, FEW),
    visual.VisualSlam.start: lambda: call(SLAM, POSE, length=4),
    visual.VisualSlam.step: lambda: call(
        SLAM,
        VISUAL,
        MOTION,
        OTHER,
        LOOKS,
        costs=lambda asked: np.ones((1, 1)),
        rng=np.random.default_rng(0),
    ),
    localisation.LandmarkMap: lambda: call(MARKS.means, MARKS.covs, MARKS.looks),
    localisation.LandmarkMap.of: lambda: call(VISUAL),
    localisation.LocaliserRules: lambda: call(
        20, 2.0, 2, 0.3, 0.1, 0.2, 0.5, (0.1, 0.1, 0.1), 0.1, "area", (1.0, 0.5), 0.5, 0.9, 0.2
    ),
    localisation.MapLocaliser: lambda: call(
        MARKS, MOUNT, localisation.LocaliserRules(20), np.array([[0.0, 0.0], [3.0, 4.0]])
    ),
    localisation.MapLocaliser.start: lambda: call(
        FINDER, Gaussian(POSE, 0.1 * Q), rng=np.random.default_rng(0)
    ),
    localisation.MapLocaliser.step: lambda: call(
        FINDER,
        FOUND,
        MOTION,
        PAIR,
        np.eye(2, 4),
        costs=lambda asked: np.ones((2, 2)),
        rng=np.random.default_rng(0),
    ),
    localisation.MapLocaliser.fix: lambda: call(
        FINDER,
        PAIR,
        np.eye(2, 4),
        costs=lambda asked: 1 - np.eye(2),
        rng=np.random.default_rng(0),
        tries=20,
    ),
    localisation.Fix: lambda: call(POSE, 3),
    localisation.LocaliserInfo: lambda: call(
        np.zeros((2, 1), dtype=int), 1.0, True, np.zeros(3, dtype=int), 0.5, 1
    ),
    localisation.clusters: lambda: call(PARTICLES, near=(1.0, 0.5)),
    one_by_one.Particle: lambda: call(POSE, {4: Gaussian(np.full(3, 2.0), 0.1 * Q)}, -1.0),
    one_by_one.camera_pose: lambda: call(POSE, MOUNT),
    one_by_one.predict: lambda: call(PARTICLE, MOTION, rng=np.random.default_rng(0)),
    one_by_one.update: lambda: call(PARTICLE, POINT, MOUNT),
    one_by_one.add_landmarks: lambda: call(PARTICLE, OTHER, MOUNT),
    one_by_one.resample: lambda: call(
        [PARTICLE, PARTICLE], rng=np.random.default_rng(0), share=0.5
    ),
    observability.Anchor: lambda: call(8.0, 9.0, POINTS),
    observability.Landmarks: lambda: call(RANGES),
    observability.Position: call,
    observability.Heading: call,
    observability.Analysis.hides: lambda: call(ANALYSIS, np.ones(3)),
    observability.analyse: lambda: call(np.eye(2, 3), tolerance=1e-9),
    observability.fixed_point_matrix: lambda: call(SENSORS, STATE, np.ones(3), 2),
    observability.trajectory_matrix: lambda: call(SENSORS, np.stack([STATE, STATE])),
    observability.see: lambda: call(SENSORS, STATE),
    observability.gauge_directions: lambda: call(STATE, ABOUT),
    observability.information_along: lambda: call(np.ones(2), EYE),
    observability.rotate: lambda: call(STATE, 0.5, ABOUT),
    observability.translate: lambda: call(STATE, ABOUT),
    symbolic.pose: lambda: call(1),
    symbolic.state: lambda: call(1, symbolic.pose(1)),
    symbolic.measurement: lambda: call(SYMBOLIC, X),
    symbolic.fixed_point_matrix: lambda: call(SYMBOLIC, 1, (1, 2)),
    symbolic.fixed_point_minors: lambda: call(SENSORS, 1),
    symbolic.trajectory_matrix: lambda: call(SYMBOLIC, 1, [symbolic.pose(0), symbolic.pose(1)]),
    symbolic.lie_matrix: lambda: call(SYMBOLIC, 1, speed=1, turn_rate=0),
    symbolic.read: lambda: call(sympy.eye(3, 5), SYMBOLIC, symbolic.pose(1)),
    symbolic.gauge_direction: lambda: call(X, (1, 0), 1, about=(2, 3)),
}
