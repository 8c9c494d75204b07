"""Anchored SLAM: Andrade-Cetto, "Perception Issues", section 2.2, eqs (19) to (27)."""

STUDIES = ("rails", "gauge")
