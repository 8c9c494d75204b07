"""Visual landmarks are found, seen by two eyes, tracked, described, and told from one another."""

from robot_perception.landmarks.association import Euclidean, Mahalanobis, Nearest
from robot_perception.landmarks.classes import (
    DescriptorClasses,
    floored_variances,
    pooled_variances,
    raw_variances,
    shrunk_variances,
)
from robot_perception.landmarks.ego_motion import StereoMotion, stereo_motion
from robot_perception.landmarks.features import Features, Sift, detect
from robot_perception.landmarks.stereo import (
    StereoPoints,
    StereoRules,
    match_stereo,
    observe,
    require_rectified,
)
from robot_perception.landmarks.tracking import (
    FeatureTrack,
    Missed,
    Sighting,
    TrackRules,
    Tracks,
    extend,
    follow,
    predict_pixels,
    sight,
)

__all__ = [
    "DescriptorClasses",
    "Euclidean",
    "FeatureTrack",
    "Features",
    "Mahalanobis",
    "Missed",
    "Nearest",
    "Sift",
    "Sighting",
    "StereoMotion",
    "StereoPoints",
    "StereoRules",
    "TrackRules",
    "Tracks",
    "detect",
    "extend",
    "floored_variances",
    "follow",
    "match_stereo",
    "observe",
    "pooled_variances",
    "predict_pixels",
    "raw_variances",
    "require_rectified",
    "shrunk_variances",
    "sight",
    "stereo_motion",
]
