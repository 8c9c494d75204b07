"""Rao-Blackwellised particle filter SLAM: a map of points in space for each of many paths."""

from robot_perception.slam.rao_blackwellised.association import associate_each, associate_shared
from robot_perception.slam.rao_blackwellised.belief import ParticleMaps
from robot_perception.slam.rao_blackwellised.filtering import (
    RaoBlackwellisedSlam,
    Weighing,
    add_landmarks,
    forward_mount,
    lineage,
    paths,
    predict,
    printed_number,
    resample,
    update,
)

__all__ = [
    "ParticleMaps",
    "RaoBlackwellisedSlam",
    "Weighing",
    "add_landmarks",
    "associate_each",
    "associate_shared",
    "forward_mount",
    "lineage",
    "paths",
    "predict",
    "printed_number",
    "resample",
    "update",
]
