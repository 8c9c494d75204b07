"""Legs of real people, marked by others: how many are found, how far away, and what else is.

Run with ROBOT_PERCEPTION_DATA naming the directory that holds the recordings.
"""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from robot_perception import datasets
from robot_perception.people import legs

BOUNDS = [0, 2, 3, 4, 5]
NEAR = 0.2  # between a leg and its mark, m


def recording(name):
    found = datasets.find("leg_scans", f"{name}.npz")
    if found is None:
        pytest.skip(f"the recording leg_scans/{name} is not on this computer")
    return datasets.read_leg_scans(found)


def found_legs(ranges, angles):
    found = legs.profiles(ranges, angles)
    return found.middles[legs.are_legs(found)]


def hits(found, marked):
    """Tell which marked legs are found, each by a leg of its own."""
    apart = np.hypot(*(marked[:, None] - found).transpose(2, 0, 1))
    row, column = linear_sum_assignment(np.minimum(apart, 1.0))
    hit = np.zeros(len(marked), dtype=bool)
    hit[row[apart[row, column] <= NEAR]] = True
    return hit


def rates(thinned):
    """Return the share found of the legs marked in each interval of distance."""
    distances, found = [], []
    for name in ("positive_1", "positive_2", "positive_3"):
        scans = recording(name)
        for k in np.unique(scans.scans_of_legs):
            marked = scans.legs[scans.scans_of_legs == k]
            seen = found_legs(scans.ranges[k, ::thinned], scans.angles[::thinned])
            found.append(hits(seen, marked))
            distances.append(np.hypot(*marked.T))
    row = np.digitize(np.concatenate(distances), BOUNDS) - 1
    assert len(row) == 324 + 116 + 309
    return np.bincount(row, np.concatenate(found)) / np.bincount(row)


def test_most_marked_legs_are_found_at_every_distance():
    assert (rates(1) > 0.85).all()


def test_with_a_beam_in_each_degree_far_legs_are_missed():
    """The paper's scanner, made of every third beam of a finer one; its limit is 3 m."""
    found = rates(3)
    assert (found[:2] > 0.8).all()
    assert found[3] < 0.7
    assert (np.diff(found) < 0.02).all()


@pytest.mark.parametrize("name", ["negative_2_left", "negative_2_right"])
def test_other_things_are_taken_for_people_where_there_are_none(name):
    """The strongest disadvantage of the approach, says the paper."""
    scans = recording(name)
    assert scans.sector is None
    counts = [len(legs.detect(ranges, scans.angles).mean) for ranges in scans.ranges[::5]]
    assert 0.5 < np.mean(counts) < 5
