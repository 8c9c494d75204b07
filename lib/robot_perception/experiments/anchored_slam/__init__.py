"""Experiments of the chapter "Anchored SLAM", one module per study."""

from robot_perception.experiments.anchored_slam import rails

CLAIMS = rails.CLAIMS
