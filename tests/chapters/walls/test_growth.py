"""The worst case and what is fitted to its costs."""

import json

import numpy as np
import pandas as pd
import pytest

from robot_perception import walls
from robot_perception.book.walls import (
    doubled,
    dp_path_hull,
    exponent,
    hull_example,
    measured,
    recorded_times,
    recursion,
    surplus,
    worst_case,
    wound,
)
from robot_perception.teaching.scores import performance
from studies.claims import Finding
from studies.records import records
from studies.rows import Rows


def rows_of(cost, sizes):
    n = np.array(sizes)
    return Rows(pd.DataFrame({"n": n, "steps": cost(n.astype(float))}), "n", {})


def test_worst_case_cuts_off_one_vertex_at_each_split_and_is_simple():
    chain = worst_case(200)
    splits = [(s.i, s.f) for s in recursion(chain, 0.1) if s.split]
    assert splits == [(i, i + 1) for i in range(198)]
    assert walls.is_simple(chain)
    assert walls.count_distances(chain, 0.1) == 199 * 198 // 2
    np.testing.assert_array_equal(walls.simplify_path_hull(chain, 0.1), np.arange(200))


def test_exponent_of_a_cost_that_is_a_power_is_that_power():
    found = exponent(rows_of(lambda n: 3.0 * n**1.7, [10, 20, 40, 80]))
    assert (found.low, found.high) == pytest.approx((1.7, 1.7))


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


@pytest.mark.parametrize("name", COSTS)
def test_the_surplus_tells_n_log_n_from_a_power(name):
    cost, holds = COSTS[name]
    verdict = dp_path_hull.verdict(Finding(surplus(rows_of(cost, wound.replicates))))
    assert verdict == ("reproduced" if holds else "refuted")


def test_a_surplus_needs_sizes_that_double():
    with pytest.raises(ValueError, match=r"twice the one before, got \[10 20 30\]"):
        surplus(rows_of(lambda n: n, [10, 20, 30]))


def test_times_of_the_worst_case_are_those_of_the_benchmarks():
    rows = json.loads((records() / "performance.json").read_text(encoding="utf-8"))["rows"]
    assert [row for row in rows if "zigzag of 10⁵ points" in row["work"]] == [recorded_times()]


def test_a_record_without_the_worst_case_is_named(tmp_path, monkeypatch):
    performance.write({"rows": []}, tmp_path / "performance.json")
    monkeypatch.setattr(performance, "records", lambda: tmp_path)
    with pytest.raises(LookupError, match="has no row of the zigzag"):
        recorded_times()


def test_distances_on_the_worst_case_have_a_closed_form():
    n = np.array(doubled(50, 3))
    np.testing.assert_array_equal(measured.run(n=n.tolist()).of("steps"), (n - 1) * (n - 2) // 2)
    n = measured.rows().of("n")
    np.testing.assert_array_equal(measured.rows().of("steps"), (n - 1) * (n - 2) // 2)


def test_hulls_built_anew_take_about_as_many_steps_as_there_are_pairs():
    steps = wound.run(n=(100, 200, 400), count="steps of hulls built anew").of("steps")
    np.testing.assert_allclose(steps[1:] / steps[:-1], 4.0, rtol=0.05)


def test_farthest_vertex_of_the_example_is_a_corner_of_one_of_the_hulls():
    found = hull_example()
    left, right = found.corners
    assert found.farthest in {*left, *right}
    assert found.tag == left.max() == right.min()
