"""Valid calls of `arms`."""

import numpy as np

from data_synth.arms.bodies import make_person
from data_synth.arms.gestures import ArmScene, film_arms
from data_synth.companion.faces import make_identity
from robot_perception.arms import body_model, likelihoods, printed, tracker, watching
from robot_perception.arms.body_model import REST, BodyModel, Measures
from robot_perception.beliefs import ParticleSet
from robot_perception.cameras import Pinhole
from tests.hostile.sweep import call

CAMERA = Pinhole((64.0, 64.0), (31.5, 23.5), (64, 48))
MODEL = BodyModel(CAMERA, np.array([0.0, -0.1, 1.9]), counts=(2, 2, 1), grid=(2, 3))
STATES = REST + np.array([[0.0] * 8, [0.1] * 8])
PATCHES = MODEL.place(REST)
RNG = np.random.default_rng(0)
IMAGE = RNG.integers(0, 256, (48, 64, 3), dtype=np.uint8)
LATER = RNG.integers(0, 256, (48, 64, 3), dtype=np.uint8)
SEEN = likelihoods.look(IMAGE)
GREY = SEEN.grey
CONTOURS = MODEL.contours(STATES)
SURFACE = MODEL.surface(STATES, PATCHES)
EVEN = np.full((6, 4, 4), 0.25)
BODIES = likelihoods.Bodies(MODEL, STATES)
FAR, VISIBLE = np.ones((2, 5)), np.ones((2, 5), dtype=bool)
FACE = np.array([28.0, 8.0, 6.0, 6.0])
RULES = tracker.ArmRules(particles=4, rounds=1, bins=4)
TRACKER = tracker.ArmTracker(CAMERA, rules=RULES)
STATE = TRACKER.start(IMAGE, rng=np.random.default_rng(1), face=FACE, pose=REST)
EDGE = likelihoods.EdgeCue()
PATCH = likelihoods.PatchCue(PATCHES, EVEN)
PICTURE = tracker.Picture(STATE, SEEN, RULES)
WATCH = watching.ArmWatch(TRACKER, level=-9.0, newest=0.5, anew=0.5)
WATCHED = watching.WatchState(STATE, np.array([-9.5, -2.0]), np.array([1, 0]))


WHO = make_identity(np.random.default_rng(3), tone=1)
FACED = film_arms(
    np.random.default_rng(3), 1, ArmScene("still"), make_person(np.random.default_rng(3), WHO)
).frames[0]


def rng():
    return np.random.default_rng(2)


def hidden(seen: body_model.Contours | body_model.Surface) -> tuple[np.ndarray, np.ndarray]:
    """Return points of which the first is hidden, and nowhere in the picture."""
    points, visible = seen.points.copy(), seen.visible.copy()
    points[(0,) * visible.ndim], visible[(0,) * visible.ndim] = np.nan, False
    return points, visible


CALLS = {
    body_model.Measures: lambda: call(
        (0.3, 0.25, 0.13), (0.05, 0.045, 0.03, 0.02), 0.4, 0.25, 0.18, (0.17, 0.11), 0.1
    ),
    body_model.Patches: lambda: call(np.array([0]), np.array([[0.2, 0.8]]), np.array([[0.0, 1.0]])),
    body_model.BodyModel: lambda: call(
        CAMERA, np.array([0.0, 0, 2]), Measures(), MODEL.limits, (2, 2, 1), (2, 3)
    ),
    body_model.BodyModel.from_face: lambda: call(FACE, CAMERA, Measures()),
    body_model.BodyModel.joints: lambda: call(MODEL, STATES),
    body_model.BodyModel.pixels: lambda: call(MODEL, np.array([[0.1, 0.2, 1.0]])),
    body_model.BodyModel.possible: lambda: call(MODEL, STATES),
    body_model.BodyModel.possible_arms: lambda: call(MODEL, STATES),
    body_model.BodyModel.collides: lambda: call(MODEL, STATES),
    body_model.BodyModel.contours: lambda: call(MODEL, STATES),
    body_model.BodyModel.surface: lambda: call(MODEL, STATES, PATCHES),
    body_model.BodyModel.place: lambda: call(MODEL, REST, np.array([[0.2, 0.8]] * 3)),
    body_model.contours_textbook: lambda: call(MODEL, STATES),
    body_model.Contours: lambda: call(*hidden(CONTOURS)),
    body_model.Surface: lambda: call(*hidden(SURFACE)),
    likelihoods.Look: lambda: call(IMAGE, GREY, SEEN.edges, SEEN.static, SEEN.moving, SEEN.most),
    likelihoods.EdgeRules: lambda: call((15.0, 50.0), 5.0, 0.7),
    likelihoods.look: lambda: call(LATER, GREY, likelihoods.EdgeRules()),
    likelihoods.Bodies: lambda: call(MODEL, STATES),
    likelihoods.Bodies.surface: lambda: call(BODIES, PATCHES),
    likelihoods.sampled: lambda: call(SEEN.static, CONTOURS, 5.0),
    likelihoods.square_of_sum: lambda: call(FAR, VISIBLE, 1.0),
    likelihoods.sum_of_squares: lambda: call(FAR, VISIBLE, 1.0),
    likelihoods.mean_square: lambda: call(FAR, VISIBLE, 1.0, 3.0),
    likelihoods.EdgeCue: lambda: call(0.6, 0.5, None, 4.0, 1.0),
    likelihoods.EdgeCue.distances: lambda: call(EDGE, SEEN, BODIES),
    likelihoods.PatchCue: lambda: call(PATCHES, EVEN, (0, 1), np.ones(6), 0.4, 0.3, 0.1),
    likelihoods.PatchCue.squared: lambda: call(PATCH, SEEN, BODIES),
    likelihoods.confidences: lambda: call(EVEN, (0, 1), 0.7),
    likelihoods.edge_weight: lambda: call(SEEN),
    likelihoods.StabiliserCue: lambda: call(0.2, REST),
    likelihoods.CollisionCue: lambda: call(20.0),
    likelihoods.LimitCue: lambda: call(20.0),
    likelihoods.EdgeCue.arms: lambda: call(EDGE, SEEN, BODIES),
    likelihoods.PatchCue.arms: lambda: call(PATCH, SEEN, BODIES),
    likelihoods.StabiliserCue.arms: lambda: call(likelihoods.StabiliserCue(), SEEN, BODIES),
    likelihoods.LimitCue.arms: lambda: call(likelihoods.LimitCue(), SEEN, BODIES),
    tracker.Picture.log_likelihoods: lambda: call(PICTURE, STATES),
    likelihoods.apart: lambda: call({"edges": EDGE}, SEEN, BODIES),
    likelihoods.summed: lambda: call({"edges": EDGE}, SEEN, BODIES),
    tracker.ArmRules: lambda: call(
        4, (0.1, 0.1, 0.2, 0.2), "auxiliary", likelihoods.EdgeRules(), ("colour",), 8, 1, 2.5, 0.35
    ),
    tracker.ArmTracker: lambda: call(CAMERA, Measures(), RULES, tracker.CUES, tracker.BOUNDS),
    tracker.ArmTracker.start: lambda: call(TRACKER, IMAGE, rng=rng(), face=FACE, pose=REST),
    tracker.ArmTracker.step: lambda: call(TRACKER, STATE, LATER, rng=rng()),
    tracker.Picture: lambda: call(STATE, SEEN, RULES),
    tracker.Picture.move: lambda: call(PICTURE, STATES, rng()),
    tracker.Picture.expect: lambda: call(PICTURE, STATES),
    tracker.Picture.ahead: lambda: call(PICTURE, STATES),
    tracker.Picture.log_likelihood: lambda: call(PICTURE, STATES),
    tracker.ArmState: lambda: call(
        ParticleSet.uniform(STATES), GREY, STATE.first, STATE.cues, STATE.bounds, 0
    ),
    tracker.find_face: lambda: call(FACED),
    printed.SumCue: lambda: call(60.0, 0.5, 1.0, "square of the sum"),
    watching.WatchState: lambda: call(STATE, np.array([-9.5, -2.0]), np.array([1, 0])),
    watching.ArmWatch: lambda: call(TRACKER, -9.0, 0.5, 0.5),
    watching.ArmWatch.start: lambda: call(WATCH, IMAGE, rng=rng(), face=FACE, pose=REST),
    watching.ArmWatch.step: lambda: call(WATCH, WATCHED, LATER, rng=rng()),
    watching.arm_logs: lambda: call(STATE, SEEN),
}
