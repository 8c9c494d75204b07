"""Chains that cross themselves."""

import numpy as np
import pytest

from data_synth import laser
from data_synth.office import drive, make_office
from robot_perception import walls
from robot_perception.book import walls as page


@pytest.mark.slow
def test_example_of_a_crossing_chain_goes_wrong_and_its_edges_are_named():
    example = page.crossing_example()
    assert example.differ
    assert 0 < len(example.edges) <= 4


def test_answers_of_one_length_may_differ(monkeypatch):
    chain = np.array([[0.0, 0], [1, 1], [2, 1], [3, 0]])
    assert not page.simplified(chain, 0.5).differ
    kept = page.simplified(chain, 0.5).plain
    other = np.setdiff1d(np.arange(4), kept[1:2])[: len(kept)]
    monkeypatch.setitem(page.HULLS, "Melkman", lambda chain, tolerance: other)
    assert page.simplified(chain, 0.5).differ


def test_quickhull_is_right_on_curves_that_cross():
    for rng in np.random.default_rng(1).spawn(30):
        assert not page.simplified(page.crossing_chain(rng), hulls="Quickhull").differ


@pytest.mark.parametrize("speed", [0.0, 0.3, -0.3])
def test_readings_of_a_moving_scanner_are_put_where_it_then_was(speed):
    office = make_office(rng=np.random.default_rng(1))
    for place, dense in ((71, True), (336, False)):  # some readings of the second are missing
        pose = drive(office)[place]
        chain = page.swept(office, pose, speed, np.random.default_rng(2))
        assert (len(chain) >= 350) == dense
        away = walls.distance_to_segments(chain, office.faces).min(axis=1)
        assert np.quantile(away, 0.9) < 0.03  # two deviations of a range; others are mixed


def test_the_speed_of_a_sweep_is_that_of_the_scan():
    """Oracle: a wall straight ahead comes nearer by speed times time."""
    wall = np.array([[[5.0, -50], [5, 50]]])
    quiet = laser.Scanner(range_sigma=0, resolution=0, spot=0, dropout=0)
    ranges = laser.scan_moving(
        wall, np.zeros(3), (0.3, 0.0), 3.0, quiet, rng=np.random.default_rng(0)
    ).ranges[0]
    middle = quiet.beams // 2
    assert ranges[middle] == pytest.approx(5.0 - 0.3 * 1.5, abs=1e-9)
