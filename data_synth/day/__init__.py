"""A day of one robot in one building: the floor for all of its sensors, and who is there."""
