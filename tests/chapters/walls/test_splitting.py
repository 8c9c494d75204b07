"""One scan and its recursion: the oracle, the explorer's settings, the printed rule."""

import numpy as np
import pytest

from robot_perception import walls
from robot_perception.chapters.walls import growth, splitting


def test_steps_of_the_recursion_are_those_of_the_library():
    chain = splitting.one_scan().points
    steps = splitting.recursion(chain, 0.08)
    assert (steps[1].i, steps[1].j) == (0, steps[0].f)  # the left part first, as in Table 1
    kept = sorted({0, len(chain) - 1, *(s.f for s in steps if s.split)})
    assert kept == walls.simplify_recursive(chain, 0.08).tolist()
    assert sum(s.j - s.i - 1 for s in steps) == walls.count_distances(chain, 0.08)


def test_brute_force_reference_agrees_on_every_kind_of_simple_chain():
    for rng in np.random.default_rng(3).spawn(60):
        chain = growth.simple_chain(rng)
        assert walls.is_simple(chain)
        kept = walls.simplify(chain, 0.3).tolist()
        assert kept == splitting.reference_vertices(chain, 0.3)


def test_oracle_measures_to_the_point_where_there_is_no_line():
    closed = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    assert splitting.reference_vertices(closed, 1.5) == [0, 1, 3]


def test_the_scan_of_the_opening_has_361_readings_and_eight_walls():
    scan = splitting.one_scan()
    assert (scan.ranges.size, len(scan.segments)) == (361, 8)


def test_true_faces_pass_through_the_readings_of_a_perfect_scanner():
    scan = splitting.one_scan(0.02, 0.0)
    away = walls.distance_to_segments(scan.points, scan.truth).min(axis=1)
    assert np.median(away) < 0.01


def test_printed_measure_is_distance_over_length():
    rng = np.random.default_rng(0)
    for triple in rng.normal(size=(20, 3, 2)):
        length = np.linalg.norm(triple[2] - triple[0])
        expected = walls.find_split(triple, 0, 2)[1] / length
        assert splitting.printed_measure(triple, 0, 2)[0] == pytest.approx(expected)


def test_printed_rule_does_not_split_a_closed_chain():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]])
    assert splitting.simplify_as_printed(square, 0.1) == [0, 3]


def test_printed_rule_does_not_care_for_the_scale_and_the_right_rule_does():
    kept = splitting.kept_by_scale()
    assert len(set(kept.printed)) == 1
    assert (np.diff(kept.distance) >= 0).all()
    assert kept.distance[0] < kept.distance[-1]
