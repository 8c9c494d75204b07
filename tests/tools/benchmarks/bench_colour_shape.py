"""Colour and shape tracked together: a frame with 50 samples."""

import numpy as np

from robot_perception.appearance.colour_distribution import Dynamics
from robot_perception.appearance.colour_shape import ColourShapeRules, ColourShapeTracker
from robot_perception.appearance.segmentation import filled
from tests.tools.benchmarks.harness import Row

SHAPE = (240, 320)


def rows() -> list[Row]:
    """Return the row of a frame, 320 × 240."""
    t = 2 * np.pi * np.arange(80) / 80
    outline = np.stack([160 + 45 * np.cos(t), 120 + 28 * np.sin(t)], axis=-1)
    rng = np.random.default_rng(0)
    inside = filled(outline, SHAPE)[..., None]
    image = np.where(inside, [190, 60, 50], [60, 150, 70]) + rng.normal(scale=4, size=(*SHAPE, 3))
    image = image.clip(0, 255).astype(np.uint8)
    dynamics = Dynamics(np.diag([1.0] * 6 + [0.0] * 2), np.zeros(8), 0.003 * np.eye(8))
    rules = ColourShapeRules()
    tracker = ColourShapeTracker(dynamics, rules)
    start = tracker.start(image, outline, rng=rng)

    def agree() -> None:
        state, _ = tracker.step(start, image, rng=rng)
        found = filled(state.outline, SHAPE)
        assert (found & inside[..., 0]).sum() > 0.9 * (found | inside[..., 0]).sum()

    return [
        Row(
            work=f"colour and shape, {rules.samples} samples, 320 × 240",
            ours=lambda: tracker.step(start, image, rng=rng),
            at_most=0.2,
            agree=agree,
        )
    ]
