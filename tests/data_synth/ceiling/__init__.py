"""Worlds of a ceiling and of patches."""
