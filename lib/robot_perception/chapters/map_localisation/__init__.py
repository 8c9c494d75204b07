"""Where am I?: a robot that is switched on somewhere in a map that is finished."""
