"""Valid calls of the modules of `appearance` that track colours and shape together."""

import numpy as np

from robot_perception.appearance import certainty, colour_shape, single_cues
from robot_perception.appearance import colour_distribution as colours
from tests.appearance.shapes import MIDDLE, pear
from tests.hostile.calls._appearance_shape import IMAGE, MASK
from tests.hostile.sweep import call

OUTLINE = pear(20) + MIDDLE
CLOUD = 0.5 + 0.1 * np.random.default_rng(0).normal(size=(30, 3))
FOUND = colours.describe(CLOUD)
AXES = FOUND.axes
STATES = np.tile(FOUND.state, (4, 1)) + 0.01 * np.arange(4)[:, None]
DYNAMICS = colours.Dynamics(np.eye(8), np.zeros(8), 0.001 * np.eye(8))
RULES = colour_shape.ColourShapeRules(samples=3, points=20)
TRACKER = colour_shape.ColourShapeTracker(DYNAMICS, RULES)
START = TRACKER.start(IMAGE, OUTLINE, rng=np.random.default_rng(0))
COLOUR, EDGE = single_cues.ColourTracker(RULES), single_cues.EdgeTracker(RULES)
SURE = certainty.CertaintyRules()
FIRST = certainty.original(IMAGE, OUTLINE, SURE)
WINDOW = single_cues.WindowTracker(RULES.binning, True, 0.2, True)


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def watch(_: str) -> None:
    pass


CALLS = {
    colours.ColourDistribution: lambda: call(FOUND.mean, FOUND.lengths, AXES, FOUND.angles),
    colours.ColourDistribution.of: lambda: call(STATES, AXES),
    colours.turn: lambda: call(np.array([0.1, 0.2])),
    colours.describe: lambda: call(CLOUD, AXES),
    colours.warp: lambda: call(CLOUD, FOUND, FOUND),
    colours.Dynamics: lambda: call(np.eye(8), np.zeros(8), np.eye(8)),
    colours.Dynamics.propagate: lambda: call(DYNAMICS, STATES, rng=rng(), noise=1.0),
    colours.learn: lambda: call(STATES, order=1, ridge=0.1),
    colour_shape.ColourShapeRules: lambda: call(
        3,
        colour_shape.BINNING,
        (0.5, 0.4, 0.1),
        0.1,
        0.5,
        1.0,
        False,
        True,
        True,
        True,
        500,
        2,
        20,
        3,
        5,
        4,
        0.2,
        colour_shape.SNAKE,
        0.6,
    ),
    colour_shape.ColourShapeTracker: lambda: call(DYNAMICS, RULES),
    colour_shape.ColourShapeTracker.start: lambda: call(TRACKER, IMAGE, OUTLINE, rng=rng()),
    colour_shape.ColourShapeTracker.warped: lambda: call(TRACKER, START, STATES),
    colour_shape.ColourShapeTracker.step: lambda: call(
        TRACKER, START, IMAGE, rng=rng(), watch=watch
    ),
    colour_shape.colours_inside: lambda: call(IMAGE, OUTLINE, RULES, rng=rng()),
    colour_shape.inner: lambda: call(MASK, 2),
    certainty.CertaintyRules: lambda: call(SURE.binning, (1.2, 1.5), 0.1, 1.0, 1.0, -1.0, 0.4),
    certainty.Original: lambda: call(FIRST.halves, 400.0),
    certainty.original: lambda: call(IMAGE, OUTLINE, SURE),
    certainty.certainty: lambda: call(IMAGE, OUTLINE, FIRST, SURE),
    single_cues.ColourTracker: lambda: call(RULES, True),
    single_cues.ColourTracker.start: lambda: call(COLOUR, IMAGE, OUTLINE),
    single_cues.ColourTracker.step: lambda: call(COLOUR, COLOUR.start(IMAGE, OUTLINE), IMAGE),
    single_cues.EdgeTracker: lambda: call(RULES),
    single_cues.EdgeTracker.start: lambda: call(EDGE, IMAGE, OUTLINE),
    single_cues.EdgeTracker.step: lambda: call(EDGE, EDGE.start(IMAGE, OUTLINE), IMAGE),
    single_cues.WindowTracker: lambda: call(RULES.binning, True, 0.2, True),
    single_cues.WindowTracker.start: lambda: call(WINDOW, IMAGE, OUTLINE),
    single_cues.WindowTracker.step: lambda: call(WINDOW, WINDOW.start(IMAGE, OUTLINE), IMAGE),
}
