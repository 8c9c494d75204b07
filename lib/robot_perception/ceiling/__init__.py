"""Patterns on the ceiling: a mosaic of them, and finding the way by it."""
