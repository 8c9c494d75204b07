"""A word of the environment that narrows drawn trials to studies that a change has reached."""

CHANGED = "ROBOT_PERCEPTION_CHANGED"
"""Environment variable: if it is set, draw no trial of a study whose rows are current."""
