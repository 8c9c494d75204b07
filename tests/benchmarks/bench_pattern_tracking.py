"""A pattern that has moved: one step of the tracker beside what OpenCV makes of the same task."""

import numpy as np

from robot_perception.ceiling.tracker import PatternTracker
from robot_perception.chapters.pattern_tracking.rivals import METHODS, Task, condensation
from robot_perception.chapters.pattern_tracking.scene import (
    CHOOSING,
    RULES,
    SIGMAS,
    START,
    errors,
    scene,
    seen,
)
from tests.benchmarks.harness import Row

NEAR = 0.6
"""Error in the mean over the coordinates up to which both sides give the same answer, σ."""


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern a pattern on clutter."""
    one, rng = scene(CHOOSING[0]), np.random.default_rng(1)
    truth = START + SIGMAS * [0.8, -0.6, 0.5, 0.4]
    images = [seen(one.picture(place), rng) for place in (START, truth)]
    task = Task(one.pattern(), images[0], (images[1],))
    tracker, ours = PatternTracker(task.pattern, RULES), condensation()
    state = tracker.start(START)

    def agree(name: str) -> None:
        for method in (ours, METHODS[name]):
            found = method(task, np.random.default_rng(2))
            assert np.abs(errors(found, truth)).mean() <= NEAR

    return [
        Row(
            work=f"pattern on clutter 320×240: a step of {RULES.particles} particles",
            ours=lambda: tracker.step(state, images[1], rng=rng),
            peer=lambda name=name: METHODS[name](task, rng),
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
