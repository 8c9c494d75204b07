"""The fewest segments within a tolerance, against all subsets of vertices."""

from itertools import combinations, pairwise

import numpy as np
import pytest

from robot_perception.walls import find_split, simplify, simplify_fewest


def off(chain, i, j):
    """Distances of the vertices between two others from their line; from the point if closed."""
    chord, arms = chain[j] - chain[i], chain[i + 1 : j] - chain[i]
    if not chord.any():
        return np.linalg.norm(arms, axis=1)
    normal = np.array([-chord[1], chord[0]]) / np.linalg.norm(chord)
    return np.abs(arms @ normal)


def best(chain, tolerance):
    """All chains of the fewest segments, each with its sum of squares; by trying every subset."""
    n = len(chain)
    for inner in range(n - 1):
        found = []
        for kept in combinations(range(1, n - 1), inner):
            parts = [off(chain, i, j) for i, j in pairwise((0, *kept, n - 1))]
            if all(part.max(initial=0.0) <= tolerance for part in parts):
                found.append((sum((part**2).sum() for part in parts), [0, *kept, n - 1]))
        if found:
            return sorted(found)
    raise AssertionError("the whole chain is within any tolerance")


def chains(count, n=9):
    for rng in np.random.default_rng(4).spawn(count):
        yield np.stack([np.arange(n) + rng.uniform(-0.3, 0.3, n), rng.normal(0, 1, n)], axis=-1)


@pytest.mark.parametrize("tolerance", [0.2, 0.6, 1.2])
def test_the_best_of_all_subsets_is_found(tolerance):
    for chain in chains(25):
        (squares, kept), *_ = best(chain, tolerance)
        found = simplify_fewest(chain, tolerance).tolist()
        assert len(found) == len(kept)
        ours = sum((off(chain, i, j) ** 2).sum() for i, j in pairwise(found))
        assert ours == pytest.approx(squares, abs=1e-12)


def test_no_vertex_is_farther_than_the_tolerance_and_splitting_needs_no_fewer():
    fewer = 0
    for chain in chains(40, n=60):
        found, split = simplify_fewest(chain, 0.8), simplify(chain, 0.8)
        assert max(find_split(chain, int(i), int(j))[1] for i, j in pairwise(found)) <= 0.8
        assert len(found) <= len(split)
        fewer += len(found) < len(split)
    assert fewer > 20


def test_both_ends_are_kept_and_a_straight_chain_is_one_segment():
    line = np.stack([np.arange(6.0), 2 * np.arange(6.0)], axis=-1)
    assert simplify_fewest(line, 1e-6).tolist() == [0, 5]
    assert simplify_fewest(line[:2], 1.0).tolist() == [0, 1]


def test_a_closed_chord_is_a_point():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])
    assert simplify_fewest(square, 1.5).tolist() == [0, 4]  # the far corner is 1.41 away
    assert len(simplify_fewest(square, 1.4)) == 3


def test_a_point_that_is_not_finite_is_named():
    with pytest.raises(ValueError, match=r"point 1 is \[nan, 1.0\]"):
        simplify_fewest(np.array([[0.0, 0], [np.nan, 1], [2, 0]]), 0.1)
    with pytest.raises(ValueError, match="tolerance must be positive"):
        simplify_fewest(np.array([[0.0, 0], [2, 0]]), 0.0)
