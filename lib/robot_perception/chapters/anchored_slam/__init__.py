"""Experiments of the chapter "Anchored SLAM", one module per study."""

from robot_perception.chapters.anchored_slam import building, gauge, rails, recordings
from robot_perception.chapters.anchored_slam.exercises import EXERCISES, check
from robot_perception.teaching.claims import Claim
from robot_perception.teaching.recordings import Recording

__all__ = ["CLAIMS", "EXERCISES", "RECORDINGS", "check"]

CLAIMS: tuple[Claim, ...] = rails.CLAIMS + gauge.CLAIMS + building.CLAIMS
RECORDINGS: tuple[Recording, ...] = recordings.RECORDINGS
