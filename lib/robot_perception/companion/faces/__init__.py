"""Faces: found, recognised, followed, and the one kept that began."""
