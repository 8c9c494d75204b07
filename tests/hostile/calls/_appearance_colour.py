"""Valid calls of the modules of `appearance` that deal with colours and with heads."""

import numpy as np

from robot_perception.appearance import colour_histograms as histograms
from robot_perception.appearance import colour_spaces as spaces
from robot_perception.appearance import head_ellipse as heads
from tests.hostile.sweep import call

IMAGE = np.random.default_rng(0).integers(0, 256, (40, 50, 3), dtype=np.uint8)
BINNING = spaces.Binning("RGB", (4, 4, 4))
INDEX = BINNING.index(IMAGE)
ONE = np.array([3.0, 0.0, 5.0])
HEAD = heads.Ellipse(25, 20, 6)
RULES = heads.HeadRules(radius=2, widest=4)
TRACKER = heads.HeadTracker(BINNING, RULES)
COLOURS = TRACKER.colours(IMAGE, HEAD)
STATE = heads.HeadState(HEAD, COLOURS, (0, 0), 0, (50, 40))

CALLS = {
    spaces.ColourSpace: lambda: call("HSI", (8, 8, 4)),
    spaces.ColourSpace.coordinates: lambda: call(spaces.SPACES["HSI"], IMAGE),
    spaces.Binning: lambda: call("RGB", (8, 8, 4)),
    spaces.Binning.index: lambda: call(BINNING, IMAGE),
    spaces.Binning.of: lambda: call(BINNING, np.array([[0.1, 0.5, 1.0], [0.2, 0.3, 0.4]])),
    histograms.histogram: lambda: call(INDEX, 64, INDEX > 7),
    histograms.box_histograms: lambda: call(INDEX, np.array([[0, 0, 9, 9], [5, 6, 7, 8]]), 64),
    histograms.shares: lambda: call(ONE),
    histograms.intersection: lambda: call(ONE, np.array([1.0, 2.0, 3.0])),
    histograms.intersection_of_shares: lambda: call(ONE, np.array([0.1, 0.2, 0.7])),
    histograms.adapt: lambda: call(ONE, np.array([1.0, 2.0, 3.0]), 0.1),
    histograms.two_views: lambda: call(ONE, np.array([1.0, 2.0, 3.0])),
    heads.Ellipse: lambda: call(25, 20, 6),
    heads.Ellipse.mask: lambda: call(HEAD, (50, 40)),
    heads.HeadRules: lambda: call(2, 1, "shares", "excess", 0.1, 0.7, 0.4, 0.3, 0.6, 4, 5, 20),
    heads.HeadState: lambda: call(HEAD, COLOURS, (1, -2), 0, (50, 40)),
    heads.HeadTracker: lambda: call(BINNING, RULES),
    heads.HeadTracker.colours: lambda: call(TRACKER, IMAGE, HEAD),
    heads.HeadTracker.start: lambda: call(TRACKER, IMAGE, HEAD),
    heads.HeadTracker.step: lambda: call(TRACKER, STATE, IMAGE, half_width=6.2),
    heads.candidate_scores: lambda: call(
        *(INDEX, (25, 20), COLOURS),
        half_widths=(5, 6),
        radius=2,
        measure="shares",
        incremental=True,
    ),
}
