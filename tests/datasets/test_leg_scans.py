"""The sector in which legs were marked."""

import numpy as np

from robot_perception.datasets import Sector


def test_a_sector_holds_what_lies_within():
    within = np.array([[1.0, 0.0], [4.9, 0.0], [1.0, 0.3]])
    outside = np.array([[5.1, 0.0], [1.0, -0.3], [-1.0, 0.0], [4.9, 1.5], [1.0, 0.6]])
    sector = Sector(np.deg2rad(-15), np.deg2rad(30), 5.0)
    assert sector.holds(within).all()
    assert not sector.holds(outside).any()
