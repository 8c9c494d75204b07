"""Simulated worlds and their sensors: what the robots of the book perceive.

Nothing here imports ``robot_perception``: a simulator that shared an equation with the filter it
tests would confirm the filter's mistakes.
"""
