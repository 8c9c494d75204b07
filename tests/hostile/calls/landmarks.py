"""Valid calls of `landmarks`."""

from types import SimpleNamespace

import numpy as np

from robot_perception import landmarks
from robot_perception.cameras import Pinhole, StereoRig
from robot_perception.landmarks import (
    DescriptorClasses,
    Euclidean,
    Features,
    Mahalanobis,
    Missed,
    Nearest,
    Sift,
    StereoRules,
    TrackRules,
    Tracks,
    metrics,
    textbook,
)
from tests.hostile.sweep import call
from tests.landmarks.worlds import features, shifted, texture

SIZE = (120, 90)
IMAGE = texture(0, SIZE)
RIGHT = shifted(IMAGE, -6.0)
RIG = StereoRig(Pinhole((100.0, 100.0), (59.5, 44.5), SIZE), 0.1)
BEFORE = features([[10, 10], [50, 10], [90, 10]], [0, 1, 2])
AFTER = features([[8, 10], [48, 10], [88, 10]], [0, 1, 2])
TRACKS = Tracks.start(BEFORE)
D = BEFORE.descriptors.astype(float)
CLASSES = DescriptorClasses.of(D).updated(np.array([0, 1, 2]), D + 1)
VARIANCES = np.full(D.shape, 4.0)
LOOKS = SimpleNamespace(firsts=D, means=D, squares=np.ones(D.shape), counts=np.array([2, 2, 3]))
ASKED = SimpleNamespace(descriptors=D, looks=LOOKS)
NEAREST = Euclidean(D).two_nearest(D)
ROWS = np.array([0, 1, 1])
PLACES = np.array([[0.0, 0.0, 1.0], [0.5, 0.1, 2.0]])
SIGHTED = landmarks.sight(None, IMAGE, RIGHT, RIG, np.eye(4))  # compiled before the clock runs
NEXT = landmarks.sight(SIGHTED, IMAGE, RIGHT, RIG, np.eye(4))
Mahalanobis(D, VARIANCES).two_nearest(D)

CALLS = {
    DescriptorClasses: lambda: call(D, np.ones(D.shape), np.array([1, 2, 3])),
    DescriptorClasses.merged: lambda: call(CLASSES, ROWS, CLASSES),
    DescriptorClasses.of: lambda: call(D),
    DescriptorClasses.updated: lambda: call(CLASSES, ROWS, D),
    DescriptorClasses.with_others: lambda: call(CLASSES, CLASSES),
    Euclidean: lambda: call(D),
    Euclidean.distances: lambda: call(Euclidean(D), D),
    Euclidean.two_nearest: lambda: call(Euclidean(D), D),
    Features: lambda: call(BEFORE.pixels, BEFORE.descriptors, BEFORE.scales, BEFORE.angles),
    Mahalanobis: lambda: call(D, VARIANCES, True),
    Mahalanobis.distances: lambda: call(Mahalanobis(D, VARIANCES), D),
    Mahalanobis.two_nearest: lambda: call(Mahalanobis(D, VARIANCES), D),
    Missed: lambda: call(np.arange(3), np.ones(3, dtype=int), np.ones((3, 3)), BEFORE, CLASSES),
    Nearest.within: lambda: call(NEAREST, 10.0, ratio=0.8),
    Sift: lambda: call(0, 3, 0.04, 10.0, 1.6),
    StereoRules: lambda: call(2.0, 200.0, (1.0, 60.0)),
    TrackRules: lambda: call(12.0, 200.0),
    Tracks.stable: lambda: call(TRACKS, 5),
    Tracks.start: lambda: call(BEFORE),
    landmarks.detect: lambda: call(IMAGE, Sift()),
    landmarks.extend: lambda: call(
        TRACKS, BEFORE, AFTER, TrackRules(), predicted=BEFORE.pixels.copy()
    ),
    metrics.euclidean_first: lambda: call(ASKED),
    metrics.euclidean_mean: lambda: call(ASKED),
    metrics.mahalanobis: lambda: call(ASKED),
    metrics.mahalanobis_shrunk: lambda: call(ASKED, 5.0),
    landmarks.floored_variances: lambda: call(CLASSES, 20.0),
    landmarks.follow: lambda: call(
        iter([BEFORE, AFTER]), TrackRules(), predictions=[BEFORE.pixels.copy()]
    ),
    landmarks.match_stereo: lambda: call(BEFORE, AFTER, StereoRules()),
    landmarks.observe: lambda: call(
        IMAGE, RIGHT, RIG, sift=Sift(), rules=StereoRules(), sigma_px=0.5
    ),
    landmarks.pooled_variances: lambda: call(CLASSES),
    landmarks.predict_pixels: lambda: call(PLACES, np.eye(4), RIG.camera),
    landmarks.raw_variances: lambda: call(CLASSES),
    landmarks.require_rectified: lambda: call(BEFORE, AFTER, StereoRules(), least=2),
    landmarks.shrunk_variances: lambda: call(CLASSES, 5.0),
    landmarks.sight: lambda: call(
        SIGHTED,
        IMAGE,
        RIGHT,
        RIG,
        np.eye(4),
        rules=StereoRules(),
        track_rules=TrackRules(),
        patience=2,
    ),
    landmarks.stereo_motion: lambda: call(SIGHTED, NEXT, RIG.camera, reach_px=2.0),
    textbook.describe: lambda: call(textbook.patch(IMAGE, np.array([60.0, 45.0]), 2.0, 0.3)),
    textbook.euclidean: lambda: call(D[0], D[1]),
    textbook.mahalanobis: lambda: call(D[0], D[1], VARIANCES[0]),
    textbook.match_stereo: lambda: call(BEFORE, AFTER, StereoRules()),
    textbook.patch: lambda: call(IMAGE, np.array([60.0, 45.0]), 2.0, 0.3),
}
