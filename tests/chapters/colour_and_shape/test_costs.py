"""The table of what a frame costs."""

import pytest

from robot_perception.chapters.colour_and_shape import costs
from robot_perception.chapters.colour_and_shape.experiments import Stages


def test_longest_stages_come_first_and_nothing_is_left_out():
    found = costs.table(Stages({"a": 0.001, "b": 0.004, "c": 0.002, "d": 0.0005}), most=2)
    assert list(found.rows) == ["b", "c", "all others", "together"]
    assert found["b", "ms a frame"] == pytest.approx(4)
    assert found["all others", "ms a frame"] == pytest.approx(1.5)
    assert found["together", "ms a frame"] == pytest.approx(7.5)
