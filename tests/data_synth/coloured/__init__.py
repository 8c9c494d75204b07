"""Worlds of coloured things."""
