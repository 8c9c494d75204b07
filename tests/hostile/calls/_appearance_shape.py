"""Valid calls of the modules of `appearance` that deal with shape."""

import numpy as np

from robot_perception.appearance import affine_snake as snakes
from robot_perception.appearance import segmentation, shape_scores
from tests.appearance.shapes import MIDDLE, SHAPE, pear
from tests.hostile.sweep import call

OUTLINE = pear(20) + MIDDLE
MASK = segmentation.filled(OUTLINE, SHAPE)
EDGES = segmentation.boundary(MASK)
RULES = snakes.SnakeRules(steps=3)
IMAGE = np.where(MASK[..., None], [180, 90, 40], [60, 90, 140]).astype(np.uint8)
BLOB = segmentation.blob(MASK)
AFFINE, _ = snakes.affine_part(OUTLINE, OUTLINE)

CALLS = {
    segmentation.segment: lambda: call(np.array([[0, 3], [2, 1]], dtype=np.int32), np.ones(4)),
    segmentation.clean: lambda: call(MASK, 3, 5),
    segmentation.dilate: lambda: call(MASK, 2),
    segmentation.boundary: lambda: call(MASK, 2),
    segmentation.euler_number: lambda: call(MASK),
    segmentation.filled: lambda: call(OUTLINE, (240, 320)),
    segmentation.blob: lambda: call(MASK, OUTLINE),
    segmentation.Blob.boundary: lambda: call(BLOB, 1),
    snakes.SnakeRules: lambda: call(0.1, 0.1, 1.0, (20.0, 3.0), 40),
    snakes.Affine.apply: lambda: call(AFFINE, OUTLINE),
    snakes.area: lambda: call(OUTLINE),
    snakes.resample: lambda: call(OUTLINE, 30),
    snakes.affine_part: lambda: call(OUTLINE, np.add(OUTLINE, 3)),
    snakes.image_edges: lambda: call(IMAGE, EDGES, 0.3),
    snakes.affine_snake: lambda: call(OUTLINE, EDGES, RULES),
    snakes.free_snake: lambda: call(OUTLINE, EDGES, RULES),
    snakes.step_by_step: lambda: call(OUTLINE, EDGES, RULES, affine=False),
    shape_scores.affine_similarity: lambda: call(EDGES, OUTLINE),
    shape_scores.predicted_area: lambda: call(110.0, np.array([100.0, 90.0]), 1.0),
    shape_scores.area_difference: lambda: call(np.array([110.0, 90.0]), 100.0),
    shape_scores.area_congruence: lambda: call(110.0, 100.0),
    shape_scores.quality: lambda: call(np.array([1, -3]), 0.2),
    shape_scores.rho: lambda: call(np.array([0.5, 1.0]), 0.9, 1.0, (1.0, 0.5, 2.0)),
    shape_scores.log_weight: lambda: call(np.array([0.1, 0.9]), 0.3),
    shape_scores.weight: lambda: call(0.4, 0.3),
}
