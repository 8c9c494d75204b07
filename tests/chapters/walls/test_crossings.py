"""Chains that cross themselves."""

from dataclasses import replace

import numpy as np
import pytest

from data_synth.office import drive, make_office
from robot_perception import walls
from robot_perception.chapters.walls import crossings


def test_example_of_a_crossing_chain_goes_wrong_and_its_edges_are_named():
    example = crossings.crossing_example()
    assert example.differ
    assert 0 < len(example.edges) <= 4


def test_answers_of_one_length_may_differ():
    chain = np.array([[0.0, 0], [1, 1], [2, 1], [3, 0]])
    same = crossings.simplified(chain, 0.5)
    assert not same.differ
    assert replace(same, hulls=np.array([0, 1, 3]), plain=np.array([0, 2, 3])).differ


@pytest.mark.parametrize("place", [71, 336])  # some readings of the second are missing
@pytest.mark.parametrize("speed", [0.0, 0.3, -0.3])
def test_readings_of_a_moving_scanner_are_put_where_it_then_was(speed, place):
    office = make_office(rng=np.random.default_rng(1))
    chain = crossings._chain(office, drive(office)[place], speed, np.random.default_rng(2))
    assert (len(chain) < 350) == (place == 336)
    away = walls.distance_to_segments(chain, office.faces).min(axis=1)
    assert np.quantile(away, 0.9) < 0.03  # two deviations of a range; others are mixed
