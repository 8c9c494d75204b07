"""Rooms that turn results into this book: words, a course, scores of claims, ways through pages."""

from pathlib import Path

from robot_perception.extras import need

need("matplotlib", "anywidget", "PIL")

FRONT_END = Path(__file__).parent / "front_end"
"""Folder of the style sheets and scripts that only this book has."""
