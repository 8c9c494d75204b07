"""A map from two eyes: Gil et al., "SIFT features", sections 3 and 5, Fig. 4."""
