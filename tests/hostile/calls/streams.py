"""Valid calls of `streams`."""

import numpy as np

from robot_perception import streams
from tests.hostile.sweep import call

TIMES, COMMANDS = np.array([0.0, 1.0, 2.0]), np.ones((3, 2))

CALLS = {
    streams.Held: lambda: call(np.ones((2, 2)), np.ones(2), np.array([0, 1])),
    streams.merge: lambda: call(TIMES, COMMANDS, np.array([0.5, 1.5]), delay=0.1, pause=0.1),
    streams.ticks: lambda: call(TIMES, rate=10.0, longest_gap=0.5),
    streams.hold: lambda: call(TIMES, COMMANDS, np.array([0.5, 1.5])),
}
