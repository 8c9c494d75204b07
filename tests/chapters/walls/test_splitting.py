"""One scan and its recursion: the oracle, the printed rule, the fewest vertices."""

from itertools import pairwise

import numpy as np
import pytest

from robot_perception import walls
from robot_perception.book.walls import (
    by_distance_to_segments,
    enlarged,
    fewest,
    heights,
    one_scan,
    printed,
    recursion,
    simple_chain,
    split,
)


def as_printed(chain, epsilon):
    return split(chain, epsilon, printed)


def test_steps_of_the_recursion_are_those_of_the_library():
    chain = one_scan().points
    steps = recursion(chain, 0.08)
    assert (steps[1].i, steps[1].j) == (0, steps[0].f)  # the left part first, as in Table 1
    kept = sorted({0, len(chain) - 1, *(s.f for s in steps if s.split)})
    assert kept == walls.simplify_recursive(chain, 0.08).tolist()
    assert sum(s.j - s.i - 1 for s in steps) == walls.count_distances(chain, 0.08)


def test_brute_force_reference_agrees_on_every_kind_of_simple_chain():
    for rng in np.random.default_rng(3).spawn(60):
        chain = simple_chain(rng)
        assert walls.is_simple(chain)
        assert walls.simplify(chain, 0.3).tolist() == split(chain, 0.3, heights)


def test_oracle_measures_to_the_point_where_there_is_no_line():
    closed = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    assert split(closed, 1.5, heights) == [0, 1, 3]


def test_the_scan_of_the_opening_has_361_readings_and_eight_walls():
    scan = one_scan()
    assert (scan.ranges.size, len(scan.segments)) == (361, 8)


def test_true_faces_pass_through_the_readings_of_a_perfect_scanner():
    scan = one_scan(0.02, 0.0)
    away = walls.distance_to_segments(scan.points, scan.truth).min(axis=1)
    assert np.median(away) < 0.01


def test_printed_measure_is_distance_over_length():
    for triple in np.random.default_rng(0).normal(size=(20, 3, 2)):
        length = np.linalg.norm(triple[2] - triple[0])
        expected = walls.find_split(triple, 0, 2)[1] / length
        assert printed(triple, 0, 2)[0] == pytest.approx(expected)


def test_printed_rule_does_not_split_a_closed_chain():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]])
    assert as_printed(square, 0.1) == [0, 3]


def test_printed_rule_does_not_care_for_the_scale_and_the_right_rule_does():
    chain, scales = one_scan().points, (0.1, 0.5, 1.0, 2.0, 10.0)
    assert len({len(as_printed(scale * chain, 0.08)) for scale in scales}) == 1
    right = [len(walls.simplify(scale * chain, 0.08)) for scale in scales]
    assert right == sorted(right)
    assert right[0] < right[-1]


def test_a_squared_determinant_over_a_squared_length_is_the_squared_distance():
    rows = enlarged.run(squared=True)
    np.testing.assert_allclose(rows.of("measured"), rows.of("distance") ** 2)
    np.testing.assert_allclose(rows.of("power"), 2.0)


def test_the_chapters_shortest_way_is_as_short_as_the_librarys():
    for rng in np.random.default_rng(8).spawn(12):
        chain = np.cumsum(rng.normal(0.5, 1.0, (25, 2)), axis=0)
        found = fewest(chain, 0.7)
        assert found[0] == 0
        assert found[-1] == len(chain) - 1
        assert len(found) == len(walls.simplify_fewest(chain, 0.7))
        far = (heights(chain, i, j).max(initial=0) for i, j in pairwise(found))
        assert max(far) <= 0.7


def test_distances_to_the_chord_give_the_vertices_of_shapely():
    shapely = pytest.importorskip("shapely")
    for seed in range(6):
        chain = np.cumsum(np.random.default_rng(seed).normal(0.2, 1.0, (80, 2)), axis=0)
        kept = by_distance_to_segments(chain, 0.5)
        line = shapely.LineString(chain).simplify(0.5, preserve_topology=False)
        np.testing.assert_array_equal(chain[kept], np.asarray(line.coords))
