"""Colours and outlines of what is tracked."""
