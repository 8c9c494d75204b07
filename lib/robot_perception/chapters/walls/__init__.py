"""Walls from laser scans: Andrade-Cetto, "Perception Issues in Mobile Robotics", section 2.1.

The paper gives neither a noise of the scanner nor a tolerance: wherever they stand, they are ours.
"""
