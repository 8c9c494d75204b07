"""Anchored SLAM: what one known landmark makes observable, and what not."""

PAGES = ("recordings_robots", "recordings_park", "recordings_corners")
"""Further notebooks of the chapter; each computes on a real recording."""
