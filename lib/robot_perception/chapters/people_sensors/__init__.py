"""Three witnesses: drawings, and what reads a film of pedestrians."""
