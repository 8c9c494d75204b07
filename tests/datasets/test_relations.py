"""Relations are matched to scans by rounded time."""

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.datasets import ReadReport, Relations, read_relations
from tests.datasets.writing import write


def test_relations_are_matched_by_rounded_time(tmp_path):
    lines = [b"1.0004 2.0 1 0 0 0 0 0", b"2 3 1 0 0 0 0 0", b"1 1.9994 1 0 0 0 0 0"]
    relations = read_relations(write(tmp_path / "a.relations", lines))
    rows, scans = relations.match(np.array([2.0, 5.0, 1.0, 1.0]))
    np.testing.assert_array_equal(rows, [0])
    np.testing.assert_array_equal(scans, [[2, 0]])  # of two scans at one time, the first
    rows, scans = relations.match(np.array([2.0, 1.0]), decimals=2)
    np.testing.assert_array_equal(rows, [0, 2])
    np.testing.assert_array_equal(scans, [[1, 0], [1, 0]])
    rows, scans = relations.match(np.empty(0))
    assert rows.shape == (0,)
    assert scans.shape == (0, 2)


@given(st.lists(st.integers(0, 60), max_size=12))
def test_matching_agrees_with_a_dictionary(ticks):
    """Independent oracle: look both times up among the scans'."""
    times = np.array([(a, a + 7) for a in range(50)], dtype=float) / 8
    relations = Relations(times, np.zeros((50, 6)), ReadReport(Path("x"), {}, {}))
    scans = np.array(ticks, dtype=float) / 8
    first = {}
    for index, time in enumerate(scans.tolist()):
        first.setdefault(time, index)
    expected = [
        (row, first[a], first[b])
        for row, (a, b) in enumerate(times.tolist())
        if a in first and b in first
    ]
    rows, found = relations.match(scans)
    assert [(r, *pair) for r, pair in zip(rows.tolist(), found.tolist(), strict=True)] == expected
