"""Three witnesses: what a laser, sonars and a camera each take for a person, one at a time."""

STUDIES = ("witnesses",)
