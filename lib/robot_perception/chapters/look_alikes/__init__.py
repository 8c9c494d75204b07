"""Taken for another: Gil et al., "SIFT features", sections 1, 4 and 6."""
