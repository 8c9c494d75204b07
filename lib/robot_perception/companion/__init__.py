"""The tutor of a robot: faces, a raised hand, a person to follow, and when to do what."""
