"""Patterns on a ceiling: found, tracked and put together to a mosaic; a path that is remembered."""
