"""The answers of the exercises are what happens."""

import numpy as np
import pytest
from scipy import stats

from robot_perception.book.look_alikes import EXERCISES, most_alike
from robot_perception.slam.planar import MapBelief


def test_the_gate_is_that_of_two_coordinates():
    assert EXERCISES["look-gate"].answer == pytest.approx(stats.chi2(2).ppf(0.99))


def test_a_filter_of_so_many_landmarks_holds_so_many_numbers():
    size = 3 + 2 * 3
    belief = MapBelief(np.zeros(size), np.eye(size), np.arange(3))
    assert belief.cov.size == (3 + 2 * 3) ** 2
    assert EXERCISES["look-cost"].answer == (3 + 2 * 1500) ** 2


def test_of_twelve_names_some_are_wrong():
    wrong = np.random.default_rng(0).uniform(size=(200_000, 12)) < 0.16
    assert EXERCISES["look-some"].answer == pytest.approx(wrong.any(axis=1).mean(), abs=0.005)


def test_an_association_by_look_and_place_is_better_than_by_either():
    def of_both(looks, gaps):
        costs = (looks / 149) ** 2 + (gaps / 0.7) ** 2
        return np.where(costs.min(axis=1) <= 1.8, costs.argmin(axis=1), -1)

    def by_looks(looks, gaps, limit):
        return np.where(looks.min(axis=1) <= limit, looks.argmin(axis=1), -1)

    def in_a_gate(looks, gaps, gate, limit):
        return by_looks(np.where(gaps < gate, looks, np.inf), gaps, limit)

    build = EXERCISES["look-build"]
    assert build.judge(of_both)[0] == "right"
    assert by_looks(*np.ones((2, 1, 6)), 149.0) == most_alike(*np.ones((2, 1, 6)))
    for limit in range(100, 201, 10):
        assert build.judge(lambda *seen, limit=limit: by_looks(*seen, limit))[0] == "wrong"
        for gate in (0.3, 0.5, 0.7, 0.8, 0.9):
            own = {"gate": gate, "limit": limit}
            assert build.judge(lambda *seen, own=own: in_a_gate(*seen, **own))[0] == "wrong"
