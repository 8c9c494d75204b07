"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from robot_perception.book.arm_likelihoods import EXERCISES
from robot_perception.companion.cues import bhattacharyya


def test_a_patch_that_slides_by_the_share_of_the_exercise_is_as_unlike_as_it_says():
    q = EXERCISES["likelihoods-slides"].answer
    first, now = np.eye(8)[0], (1 - q) * np.eye(8)[0] + q * np.eye(8)[5]
    assert bhattacharyya(now, first) ** 2 == pytest.approx(0.3)


def test_a_price_is_paid_by_hidden_points_alone_and_the_mean_is_over_all():
    sheet = EXERCISES["likelihoods-price"]

    def right(far, seen, price):
        return -(np.where(seen, far, price) ** 2).mean(axis=1) / 2

    def over_the_visible(far, seen, price):
        return -(np.where(seen, far, price) ** 2).sum(axis=1) / seen.sum(axis=1) / 2

    assert sheet.judge(right)[0] == "right"
    for wrong in (over_the_visible, lambda far, seen, price: -(far**2).mean(axis=1) / 2):
        assert sheet.judge(wrong)[0] == "wrong"
