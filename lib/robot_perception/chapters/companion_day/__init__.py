"""A companion's day: every system of the five papers in one robot, drawn."""
