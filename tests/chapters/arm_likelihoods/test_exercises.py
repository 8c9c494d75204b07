"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.book.arm_likelihoods import EXERCISES
from robot_perception.companion.cues import bhattacharyya


def test_a_patch_that_slides_by_the_share_of_the_exercise_is_as_unlike_as_it_says():
    q = EXERCISES["likelihoods-slides"].answer
    first, now = np.eye(8)[0], (1 - q) * np.eye(8)[0] + q * np.eye(8)[5]
    assert bhattacharyya(now, first) ** 2 == pytest.approx(0.3)


def test_a_price_on_hidden_points_brings_arms_back_and_finds_the_truth():
    def with_price(far, seen):
        return -(np.where(seen, np.minimum(far, 5), 5) ** 2).mean(axis=1)

    def printed(far, seen):
        return -(np.where(seen, far, 0).sum(axis=1) ** 2)

    sheet = EXERCISES["likelihoods-cost"]
    assert sheet.judge(with_price)[0] == "right"
    assert "hides" in sheet.judge(printed)[1]
    assert "in clutter" in sheet.judge(lambda far, seen: seen.mean(axis=1))[1]
