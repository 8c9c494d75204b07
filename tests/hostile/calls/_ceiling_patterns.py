"""Valid calls of the modules of `ceiling` that see pictures: contours, patterns, trackers."""

import cv2
import numpy as np

from robot_perception.ceiling import contours, patterns, recognition, tracker
from tests.hostile.sweep import call


def _picture() -> np.ndarray:
    image = np.full((60, 80), 200, np.uint8)
    cv2.rectangle(image, (25, 20), (52, 38), 60, -1)
    cv2.circle(image, (40, 28), 5, 220, -1, cv2.LINE_AA)
    return image


IMAGE = _picture()
LAYERS = IMAGE[None].astype(np.float32)
RULES = contours.ContourRules()
EDGES = contours.find_edges(IMAGE)
SEGMENT, ARC = contours.Segment((1.0, 2.0), (9.0, 5.0)), contours.Arc((9.0, 8.0), 5.0, 0.2, 1.5)
CONTOURS = contours.find_contours(EDGES)
CENTRE, SIZE = (39.0, 29.0), (40.0, 36.0)
PATTERN = patterns.make_pattern(IMAGE, CENTRE, SIZE, patterns.PatternRules(most=20))
POSES = np.array([[39.0, 29.0, 0.0, 1.0], [38.0, 29.0, 0.1, 1.1]])
POINTS, PHI = np.array([[40.0, 30.0], [1.0, 25.0]]), np.array([0.1, 0.2])
FALLS = np.array([[1.0, 0.9, 0.7], [1.0, 0.8, 0.6]])
DECAY = patterns.Decay(np.array([0.1, 0.2]), np.array([1.0, 1.5]))
WINDOWS = patterns.WindowRules((32, 30), 2, 2, 4, 4.0, 0.75, 20.0)
FOLLOWS = tracker.TrackerRules(9, (5.0, 5.0, 0.05, 0.1), 4.0, 4.0, 0.3, "left out", "difference", 1)
TRACKER = tracker.PatternTracker(PATTERN, FOLLOWS)
STATE = TRACKER.start(POSES[0])
FOUND = recognition.RecognitionRules(refined=4)
FIELD = recognition.EdgeField(EDGES)


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


CALLS = {
    contours.Segment: lambda: call((1.0, 2.0), (9.0, 5.0)),
    contours.Segment.points: lambda: call(SEGMENT, 3.0),
    contours.Arc: lambda: call((9.0, 8.0), 5.0, 0.2, 1.5),
    contours.Arc.points: lambda: call(ARC, 3.0),
    contours.ContourRules: lambda: call(1.0, 4.0, 10.0, 12, 1.5, 0.8, 60.0),
    contours.Edges: lambda: call(EDGES.mask, EDGES.gradient),
    contours.Edges.directions: lambda: call(EDGES, POINTS),
    contours.find_edges: lambda: call(IMAGE, RULES),
    contours.find_contours: lambda: call(EDGES, RULES),
    patterns.PatternRules: lambda: call(11, 1.0, 3.0, 120, "slope", "picture", "line", True, True),
    patterns.Decay: lambda: call(DECAY.rate, DECAY.power),
    patterns.Pattern: lambda: call(
        PATTERN.places, PATTERN.vectors, PATTERN.decay, SIZE, 1.0, True, PATTERN.contours, (60, 80)
    ),
    patterns.Pattern.seen: lambda: call(PATTERN, POSES),
    patterns.grey_vectors: lambda: call(IMAGE, POINTS, PHI, samples=7, step=1.0),
    patterns.autocorrelation: lambda: call(PATTERN.vectors, centred=False),
    patterns.decay_in_picture: lambda: call(IMAGE, POINTS, PHI, samples=7, step=1.0, centred=True),
    patterns.fit_decay: lambda: call(FALLS, "line", own=True),
    patterns.deviations: lambda: call(np.array([[0.9, 0.3]]), DECAY),
    patterns.correlations: lambda: call(LAYERS, PATTERN, POSES, np.zeros(2, int)),
    patterns.make_pattern: lambda: call(
        IMAGE, CENTRE, SIZE, patterns.PatternRules(picked="random"), contours=RULES, rng=rng()
    ),
    patterns.WindowRules: lambda: call((64, 64), 4, 8, 4, 10.0, 0.75, 48.0),
    patterns.interest_windows: lambda: call(
        EDGES, CONTOURS, WINDOWS, taken=np.array([[10.0, 10.0]])
    ),
    tracker.TrackerRules: lambda: call(
        200, (5.0, 5.0, 0.05, 0.1), 4.0, 4.0, 0.3, "at worst", "difference", 0
    ),
    tracker.PatternState: lambda: call(STATE.particles, 1, (60, 80)),
    tracker.smoothing: lambda: call(np.array([0.9, 1.4]), "scale"),
    tracker.Layers: lambda: call(IMAGE),
    tracker.Layers.correlations: lambda: call(tracker.Layers(IMAGE), PATTERN, POSES, "difference"),
    tracker.PatternTracker: lambda: call(PATTERN, FOLLOWS),
    tracker.PatternTracker.start: lambda: call(TRACKER, POSES[0]),
    tracker.PatternTracker.step: lambda: call(TRACKER, STATE, IMAGE, rng=rng()),
    tracker.log_likelihoods: lambda: call(np.array([[0.9, 0.3], [0.5, np.nan]]), DECAY, FOLLOWS),
    recognition.RecognitionRules: lambda: call(2.0, 0.35, 0.2, 8.0, (1.0,), 30, 6.0, 0.4),
    recognition.EdgeField: lambda: call(EDGES),
    recognition.EdgeField.look: lambda: call(FIELD, POINTS),
    recognition.recognise: lambda: call(PATTERN, FIELD, CONTOURS, FOUND),
    recognition.contour_log_likelihoods: lambda: call(
        FIELD, PATTERN, POSES, sigma=2.0, aligned=0.3
    ),
}
