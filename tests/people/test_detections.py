"""Detections: an empty batch is one, directions are wrapped, and what is no position is refused."""

import numpy as np
import pytest

from robot_perception.beliefs import Gaussian
from robot_perception.people import Detections, polar
from tests.unchecked import unchecked


def test_positions_are_wrapped_and_their_errors_independent():
    found = polar(np.array([1.0, 2.0]), np.array([np.pi + 0.1, -0.5]), 0.1, np.array([0.2, 0.3]))
    np.testing.assert_allclose(found.mean, [[1, 0.1 - np.pi], [2, -0.5]], rtol=1e-15)
    np.testing.assert_allclose(found.cov, [np.diag([0.01, 0.04]), np.diag([0.01, 0.09])])


def test_nobody_is_an_empty_batch():
    nobody = Detections(3, "sonar", polar(np.zeros(0), np.zeros(0), 0.1, 0.2))
    assert len(nobody) == 0
    assert nobody.time == 3.0
    assert nobody.positions.cov.shape == (0, 2, 2)
    assert len(Detections(0.0, "laser", polar(np.ones(4), np.zeros(4), 0.1, 0.2))) == 4


@pytest.mark.parametrize(
    ("mean", "cov", "reason"),
    [
        ([1.0, 0.0], np.eye(2), r"positions.mean must be \(n, 2\), got \(2,\)"),
        ([[1.0, 0.0]], np.eye(2), r"positions.cov must be \(1, 2, 2\) for mean"),
        ([[1.0, 0.0, 0.0]], np.eye(3)[None], r"positions.mean must be \(n, 2\)"),
        ([[-0.1, 0.0]], np.eye(2)[None], "negative distance, got -0.1"),
        ([[1.0, 3.2]], np.eye(2)[None], "φ from -π to π, got 3.2"),
    ],
)
def test_what_is_no_position_is_refused(mean, cov, reason):
    with unchecked(), pytest.raises(ValueError, match=reason):
        Detections(0.0, "camera", Gaussian(np.array(mean), np.array(cov)))


def test_a_sensor_has_a_name():
    nobody = polar(np.zeros(0), np.zeros(0), 0.1, 0.2)
    assert Detections(0.0, "microphone", nobody).sensor == "microphone"
    for name in ("", 3):
        with unchecked(), pytest.raises(ValueError, match="sensor must be the name of a sensor"):
            Detections(0.0, name, nobody)
    with unchecked(), pytest.raises(ValueError, match="r_sigma must not be negative, got -1"):
        polar(np.ones(1), np.zeros(1), -1.0, 0.2)
