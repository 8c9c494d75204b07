"""The worst case and what is fitted to its costs."""

import json

import numpy as np
import pytest

from robot_perception import walls
from robot_perception.chapters.walls import growth, splitting
from robot_perception.evaluation.intervals import exponent
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.records import records


def test_worst_case_cuts_off_one_vertex_at_each_split_and_is_simple():
    chain = growth.worst_case(200)
    splits = [(s.i, s.f) for s in splitting.recursion(chain, 0.1) if s.split]
    assert splits == [(i, i + 1) for i in range(198)]
    assert walls.is_simple(chain)
    assert walls.count_distances(chain, 0.1) == 199 * 198 // 2
    np.testing.assert_array_equal(walls.simplify_path_hull(chain, 0.1), np.arange(200))


def test_exponent_of_a_cost_that_is_a_power_is_that_power():
    found = growth.fit(lambda chain, tolerance: 3.0 * len(chain) ** 1.7, [10, 20, 40, 80])
    assert (found.exponent.low, found.exponent.high) == pytest.approx((1.7, 1.7))


COSTS = {
    "n": (lambda n: 7.0 * n, True),
    "n log n": (lambda n: n * np.log2(n), True),
    "n log n and more that is linear": (lambda n: n * np.log2(n) + 30.0 * n, True),
    "n log² n": (lambda n: n * np.log2(n) ** 2, False),
    "n^1.1": (lambda n: n**1.1, False),
    "n^1.1 and more that is linear": (lambda n: n**1.1 + 30.0 * n, False),
    "n^1.2": (lambda n: n**1.2, False),
    "n²": (lambda n: n**2.0, False),
}


@pytest.mark.parametrize("size", ["quick", "full"])
@pytest.mark.parametrize("name", COSTS)
def test_the_surplus_tells_n_log_n_from_a_power(name, size):
    cost, holds = COSTS[name]
    sizes = np.array(growth.HULL_SIZES[size])
    costs = cost(sizes.astype(float))
    made = growth.Growth(sizes, costs, exponent(sizes.astype(float), costs))
    verdict = growth.dp_path_hull.verdict(Finding(growth.surplus(made)))
    assert verdict == ("reproduced" if holds else "refuted")


def test_a_surplus_needs_sizes_that_double():
    made = growth.fit(lambda chain, tolerance: float(len(chain)), [10, 20, 30])
    with pytest.raises(ValueError, match=r"twice the one before, got \[10 20 30\]"):
        growth.surplus(made)


def test_times_of_the_worst_case_are_those_of_the_benchmarks():
    rows = json.loads((records() / "performance.json").read_text(encoding="utf-8"))["rows"]
    assert [row for row in rows if "zigzag of 10⁵ points" in row["work"]] == [
        growth.recorded_times()
    ]


def test_a_record_without_the_worst_case_is_named(tmp_path, monkeypatch):
    (tmp_path / "performance.json").write_text('{"rows": []}', encoding="utf-8")
    monkeypatch.setattr(growth, "records", lambda: tmp_path)
    with pytest.raises(LookupError, match="has no row 'simplify a zigzag"):
        growth.recorded_times()


def test_growth_is_that_of_the_worst_case():
    sizes = np.array([50, 100, 200])
    costs = growth.fit(walls.count_distances, sizes.tolist()).costs
    np.testing.assert_array_equal(costs, (sizes - 1) * (sizes - 2) // 2)


@pytest.mark.parametrize("size", ["quick", "full"])
def test_n_log_n_grows_by_one_over_the_logarithm_more_than_n(size):
    sizes = np.array(growth.HULL_SIZES[size])
    middle = np.log(sizes).mean()
    assert growth.n_log_n_exponent(sizes) == pytest.approx(1 + 1 / middle, rel=1e-3)


def test_farthest_vertex_of_the_example_is_a_corner_of_one_of_the_hulls():
    found = growth.hull_example()
    left, right = found.corners
    assert found.farthest in {*left, *right}
    assert found.tag == left.max() == right.min()
