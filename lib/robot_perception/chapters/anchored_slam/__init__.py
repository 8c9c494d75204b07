"""Anchored SLAM: what one known landmark makes observable, and what not."""
