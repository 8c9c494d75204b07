"""Likelihoods of arms: surfaces of cues, hidden parts, and what no contour tells."""
