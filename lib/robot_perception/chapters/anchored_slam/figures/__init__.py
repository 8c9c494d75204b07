"""Drawings of the chapter "Anchored SLAM", one module per study."""
