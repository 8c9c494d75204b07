"""Valid calls of `companion`."""

import cv2
import numpy as np

from data_synth.companion.face_films import FaceScene, film_faces
from robot_perception.beliefs import Gaussian, ParticleSet
from robot_perception.companion import boxes, cues, following, interaction, robot, tutor
from robot_perception.companion.faces import (
    detection,
    eigenfaces,
    gallery,
    icondensation,
    link,
    region,
)
from robot_perception.companion.hands import boosting, cascade, features, windows
from tests.hostile.sweep import call

GREY = np.random.default_rng(0).integers(0, 256, (40, 50), dtype=np.uint8)
COLOUR = np.random.default_rng(1).integers(0, 256, (40, 50, 3), dtype=np.uint8)
BOX = np.array([5.0, 6.0, 20.0, 24.0])
BOXES = BOX[None]
STATES = np.array([[20.0, 20, 0.1, 15], [25.0, 18, 0.0, 12]])
POINTS = cues.patch_points(STATES, tutor.PATCHES, grid=4)
SEEN_OF_THEM = np.ones((2, 4, 16), dtype=bool)
EVEN = np.full((4, 3, 4), 0.25)
FACES = np.random.default_rng(2).uniform(0, 1, (6, 5, 4))
NAMES = ["a", "a", "a", "b", "b", "b"]
SPACE = eigenfaces.Eigenfaces.learn(FACES, NAMES, 3)
DETECTOR = detection.FaceDetector()
TRACKER = region.FaceTracker(DETECTOR)
FACE = TRACKER.start(BOX)
SEEN = link.SeenFace(BOX, "ann")
LINK = link.Link("ann", SEEN)
FILTER = icondensation.FaceFilter(icondensation.FaceFilterRules(particles=5, bins=4))
PLACED = np.array([[20.0, 20, 26], [22.0, 19, 28]])
WALKED = icondensation.FaceFilterState(ParticleSet.uniform(PLACED), EVEN[:2])
POOL = features.feature_pool(np.random.default_rng(0), 6)
WINDOWS = np.random.default_rng(3).integers(0, 256, (8, 24, 24), dtype=np.uint8)
VALUES = features.feature_values(WINDOWS, POOL)
LABELS = np.arange(8) < 4
STUMPS = boosting.Boosted(np.array([0]), np.zeros(1), np.array([1]), np.ones(1))
STAGE = cascade.Stage(STUMPS, 0.5)
CASCADE = cascade.Cascade(POOL, (STAGE,))
HANDS = cascade.HandDetector(CASCADE)
FEW = tutor.TutorRules(particles=6, bins=4, grid=4)
TUTOR = tutor.TutorTracker(tutor.TutorModel(), FEW)
FOLLOWED = tutor.TutorState(ParticleSet.uniform(STATES), EVEN)
TABLE = interaction.paper_table()
ARROWS = (interaction.Transition("a", "x", "b"), interaction.Transition("b", "y", "a"))
PAIR = interaction.StateTable("a", ARROWS)
EVENTS = {name: interaction.Event(lambda seen: False) for name in ("x", "y")}
TALK = interaction.Interaction(PAIR, EVENTS)
FOLLOWER = following.Follower(300.0, 200.0)
SHOWN = [
    cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY)
    for frame in film_faces(np.random.default_rng(0), 3, FaceScene(glances=0.0)).frames
]
PORTRAITS = np.random.default_rng(5).uniform(0, 1, (6, 56, 46))
PEOPLE = gallery.Gallery(eigenfaces.Eigenfaces.learn(PORTRAITS, NAMES, 3))


def known(grey, box):
    return "ann"


ROBOT = robot.CompanionRobot(known, HANDS, tracker=TUTOR)


def rng():
    return np.random.default_rng(4)


CALLS = {
    boxes.overlap: lambda: call(BOXES, BOXES + 1),
    boxes.overlap_in_pairs: lambda: call(BOXES, BOXES + 1),
    boxes.crop: lambda: call(GREY, BOX, (6, 5), equalise=True),
    detection.FaceDetector: lambda: call(1.1, 4, 24, 100, 2),
    detection.FaceDetector.find: lambda: call(DETECTOR, GREY, BOX, (24.0, 40.0)),
    eigenfaces.Eigenfaces: lambda: call(
        SPACE.mean, SPACE.images, SPACE.deviations, SPACE.names, SPACE.descriptors, True, 2.0, 3.0
    ),
    eigenfaces.Eigenfaces.learn: lambda: call(FACES, NAMES, 2, whiten=True),
    eigenfaces.Eigenfaces.describe: lambda: call(SPACE, FACES[0]),
    eigenfaces.Eigenfaces.rebuild: lambda: call(SPACE, FACES[0], 2),
    eigenfaces.Eigenfaces.recognise: lambda: call(SPACE, FACES[0]),
    eigenfaces.Eigenfaces.distances: lambda: call(SPACE, np.zeros(3)),
    eigenfaces.enrol: lambda: call(FACES, NAMES, 2, accepted=0.9, folds=3, whiten=True),
    region.RegionRules: lambda: call(2.0, 0.5, 0.05, 0.08, 3.0, 0.3, 0.999, 20),
    region.RegionState: lambda: call(Gaussian(FACE.belief.mean, FACE.belief.cov), 1),
    region.FaceTracker: lambda: call(DETECTOR, region.RegionRules(), lambda found: None),
    region.FaceTracker.start: lambda: call(TRACKER, BOX),
    region.FaceTracker.predict: lambda: call(TRACKER, FACE),
    region.FaceTracker.window: lambda: call(TRACKER, FACE),
    region.FaceTracker.sides: lambda: call(TRACKER, FACE),
    region.FaceTracker.step: lambda: call(TRACKER, FACE, GREY),
    link.SeenFace: lambda: call(BOX, "ann", np.zeros(3)),
    link.Link: lambda: call("ann", SEEN, 1),
    link.LinkRules: lambda: call("verified", 30, 1.0),
    link.same_name: lambda: call(LINK, SEEN),
    link.same_descriptor: lambda: call(eigenfaces.Eigenfaces.learn(PORTRAITS, NAMES, 3)),
    link.keep_link: lambda: call(LINK, [SEEN], link.LinkRules(), verify=lambda a, b: True),
    icondensation.FaceFilterRules: lambda: call(
        50, 0.1, 0.05, 0.02, 0.5, 0.08, 0.08, 0.08, 3.0, (24.0, 90.0), 8
    ),
    icondensation.FaceFilterState: lambda: call(ParticleSet.uniform(PLACED), EVEN[:2]),
    icondensation.FaceFilter: lambda: call(FILTER.rules),
    icondensation.FaceFilter.start: lambda: call(FILTER, COLOUR, BOX, rng=rng()),
    icondensation.FaceFilter.sees: lambda: call(FILTER, COLOUR, BOX),
    icondensation.FaceFilter.step: lambda: call(FILTER, WALKED, COLOUR, BOXES, rng=rng()),
    icondensation.FaceFilter.log_likelihood: lambda: call(FILTER, COLOUR, PLACED, EVEN[:2]),
    features.integral: lambda: call(GREY),
    features.feature_pool: lambda: call(rng(), 4),
    features.feature_values: lambda: call(WINDOWS, POOL),
    features.feature_values_textbook: lambda: call(WINDOWS, POOL),
    boosting.Boosted: lambda: call(np.array([0]), np.zeros(1), np.array([1]), np.ones(1)),
    boosting.Boosted.scores: lambda: call(STUMPS, VALUES),
    boosting.best_stump: lambda: call(VALUES, VALUES.argsort(axis=1), LABELS, np.full(8, 0.125)),
    boosting.boost: lambda: call(VALUES, LABELS, lambda found: True, most=2),
    cascade.Stage: lambda: call(STUMPS, 0.5),
    cascade.Cascade: lambda: call(POOL, (STAGE,)),
    cascade.Cascade.passed: lambda: call(CASCADE, WINDOWS),
    cascade.Cascade.to_plain: lambda: call(CASCADE),
    cascade.Cascade.from_plain: lambda: call(CASCADE.to_plain()),
    cascade.Goals: lambda: call(0.99, 0.5, 3, 10),
    cascade.train: lambda: call(
        WINDOWS, lambda so_far, count: np.concatenate([WINDOWS, WINDOWS])[:count], POOL,
        count=10, goals=cascade.Goals(stages=1), told=lambda report: None,
    ),
    windows.window_at: lambda: call(GREY, BOX),
    windows.random_window: lambda: call(GREY, rng=np.random.default_rng(0)),
    windows.hard_windows: lambda: call(
        CASCADE, 6, pictures=[GREY], windows=WINDOWS, rng=np.random.default_rng(0)
    ),
    cascade.HandDetector: lambda: call(CASCADE, 1.2, 2, 3, 24),
    cascade.HandDetector.find: lambda: call(HANDS, GREY, BOX, (24.0, 30.0)),
    cascade.HandDetector.windows: lambda: call(HANDS, GREY, (24.0, 30.0)),
    cascade.HandDetector.stages_passed: lambda: call(HANDS, GREY, np.array([3.0, 4.0, 26.0, 26.0])),
    cues.patch_points: lambda: call(STATES, tutor.PATCHES, grid=4),
    cues.patch_histograms: lambda: call(COLOUR, POINTS, SEEN_OF_THEM, bins=4),
    cues.patch_histograms_textbook: lambda: call(COLOUR, POINTS, SEEN_OF_THEM, bins=4),
    cues.bhattacharyya: lambda: call(EVEN, EVEN),
    cues.edge_distances: lambda: call(GREY, thresholds=(60.0, 140.0), most=10.0),
    cues.edge_picture: lambda: call(GREY, thresholds=(60.0, 140.0)),
    cues.distance_transform: lambda: call(GREY > 200, most=10.0, precise=True),
    cues.sampled: lambda: call(np.ones((40, 50)), POINTS[:, 0], 5.0),
    cues.contour_distances: lambda: call(np.ones((40, 50)), STATES, tutor.SILHOUETTE),
    tutor.TutorModel: lambda: call(tutor.PATCHES, tutor.SILHOUETTE, {}),
    tutor.TutorRules: lambda: call(
        50, 0.06, 0.03, 0.03, 0.07, 3.0, 0.05, 0.3, 0.4, 8, 8
    ),
    tutor.TutorState: lambda: call(ParticleSet.uniform(STATES), EVEN, 0),
    tutor.TutorTracker: lambda: call(tutor.TutorModel(), FEW),
    tutor.TutorTracker.start: lambda: call(TUTOR, COLOUR, BOX, rng=rng()),
    tutor.TutorTracker.step: lambda: call(TUTOR, FOLLOWED, COLOUR, rng=rng()),
    tutor.TutorTracker.log_likelihood: lambda: call(
        TUTOR, COLOUR, STATES, EVEN, np.ones((40, 50))
    ),
    interaction.Transition: lambda: call("a", "x", "b"),
    interaction.StateTable: lambda: call("a", ARROWS),
    interaction.StateTable.reachable: lambda: call(PAIR, "a"),
    interaction.StateTable.of: lambda: call(PAIR, "a"),
    interaction.StateTable.next: lambda: call(PAIR, "a", ["x"]),
    interaction.StateTable.extended: lambda: call(
        PAIR, interaction.Transition("a", "z", "b"), first=True
    ),
    interaction.Event: lambda: call(lambda seen: True, 2),
    interaction.InteractionState: lambda: call("a", 1, {"x": 1}),
    interaction.Interaction: lambda: call(PAIR, EVENTS),
    interaction.Interaction.start: lambda: call(TALK),
    interaction.Interaction.step: lambda: call(TALK, interaction.InteractionState("a"), {}),
    interaction.paper_table: lambda: call(halt=True),
    following.Follower: lambda: call(300.0, 200.0, 2.5, 2.0, 1.5, 1.2),
    following.Follower.command: lambda: call(FOLLOWER, 10.0, 150.0),
    gallery.Gallery: lambda: call(SPACE, True, 2),
    gallery.Gallery.learn: lambda: call(
        {"ann": SHOWN}, DETECTOR, 2, accepted=0.9, equalise=True
    ),
    gallery.Gallery.recognise: lambda: call(PEOPLE, GREY, BOX),
    robot.body_of: lambda: call(BOX),
    robot.face_of: lambda: call(BOX),
    robot.RobotRules: lambda: call(link.LinkRules(), 3.0, 5.0, 5, True),
    robot.RobotState: lambda: call(
        interaction.InteractionState("wait"), LINK, FOLLOWED, 1, True, region.RegionState()
    ),
    robot.CompanionRobot: lambda: call(
        known, HANDS, DETECTOR, region.FaceTracker(), link.same_name, TUTOR,
        interaction.Interaction(TABLE, robot.EVENTS), robot.RobotRules(), FOLLOWER,
    ),
    robot.CompanionRobot.start: lambda: call(ROBOT),
    robot.CompanionRobot.step: lambda: call(ROBOT, ROBOT.start(), COLOUR, rng=rng()),
}  # fmt: skip
