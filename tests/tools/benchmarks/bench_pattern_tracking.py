"""A pattern that has moved: one step of the tracker beside what OpenCV makes of the same task."""

from types import SimpleNamespace

import numpy as np

from robot_perception.book import pattern_tracking as page
from robot_perception.ceiling.tracker import PatternTracker
from robot_perception.chapters.pattern_tracking.scene import RULES, SIGMAS, START, errors
from tests.tools.benchmarks.harness import Row

NEAR = 0.6
"""Error in the mean over the coordinates up to which both sides give the same answer, σ."""


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern a pattern on clutter."""
    rng = np.random.default_rng(1)
    truth = START + SIGMAS * [0.8, -0.6, 0.5, 0.4]
    images = [page.seen(page.picture(100, place), rng) for place in (START, truth)]
    pattern = page.learnt(100)
    task = SimpleNamespace(pattern=pattern, first=images[0], pictures=images[1:])
    tracker, ours = PatternTracker(task.pattern, RULES), page.tracks()
    state = tracker.start(START)

    def agree(name: str) -> None:
        for method in (ours, page.METHODS[name]):
            found = method(task, np.random.default_rng(2))
            assert np.abs(errors(found, truth)).mean() <= NEAR

    return [
        Row(
            work=f"pattern on clutter 320×240: a step of {RULES.particles} particles",
            ours=lambda: tracker.step(state, images[1], rng=rng),
            peer=lambda name=name: page.METHODS[name](task, rng),
            peer_name=peer,
            agree=lambda name=name: agree(name),
            inner=3,
        )
        for name, peer in (
            ("template matching", "cv2.matchTemplate, 81 windows"),
            ("ECC", "cv2.findTransformECC"),
            ("optical flow", "cv2.calcOpticalFlowPyrLK"),
        )
    ]
