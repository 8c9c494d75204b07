"""Scores: brute force over all assignments, axioms of a metric, and cases counted by hand."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from robot_perception.people.scores import Frame, gospa, score
from tests.unchecked import unchecked

seeds, sizes = st.integers(0, 10**6), st.integers(0, 4)


def frame(people, hypotheses, names=None, ids=None):
    people, hypotheses = (np.array(x, dtype=float).reshape(-1, 2) for x in (people, hypotheses))
    ids = np.arange(len(people)) if ids is None else np.array(ids, dtype=np.int64)
    names = np.arange(len(hypotheses)) if names is None else np.array(names, dtype=np.int64)
    return Frame(people, ids, hypotheses, names)


def matchings(p, h):
    """Yield all sets of pairs, each row and column at most once."""
    for order in permutations([*range(h), *[-1] * p], p):
        yield [(i, j) for i, j in enumerate(order) if j >= 0]


@given(seeds, sizes, sizes, st.floats(0.1, 3))
@settings(max_examples=60)
def test_gospa_is_the_least_over_all_assignments(seed, p, h, cutoff):
    rng = np.random.default_rng(seed)
    x, y = rng.standard_normal((p, 2)), rng.standard_normal((h, 2))
    apart = np.linalg.norm(x[:, None] - y, axis=-1)
    best = min(
        sum(apart[pair] ** 2 for pair in pairs) + cutoff**2 / 2 * (p + h - 2 * len(pairs))
        for pairs in matchings(p, h)
    )
    found = gospa(x, y, cutoff)
    assert found.total == pytest.approx(np.sqrt(best), abs=1e-12)
    parts = found.localisation**2 + cutoff**2 / 2 * (found.missed + found.false)
    assert parts == pytest.approx(best, abs=1e-12)
    assert p - found.missed == h - found.false


@given(seeds, sizes, sizes, sizes, st.floats(0.1, 3))
def test_gospa_is_a_metric(seed, k, m, n, cutoff):
    rng = np.random.default_rng(seed)
    x, y, z = (rng.standard_normal((size, 2)) for size in (k, m, n))
    assert gospa(x, x, cutoff).total == 0
    assert gospa(x, y, cutoff).total == pytest.approx(gospa(y, x, cutoff).total)
    detour = gospa(x, y, cutoff).total + gospa(y, z, cutoff).total
    assert gospa(x, z, cutoff).total <= detour + 1e-12


@given(seeds, sizes, sizes)
@settings(max_examples=60)
def test_a_frame_alone_is_matched_as_often_as_can_be_and_then_as_near(seed, p, h):
    rng = np.random.default_rng(seed)
    x, y = rng.standard_normal((p, 2)), rng.standard_normal((h, 2))
    apart = np.linalg.norm(x[:, None] - y, axis=-1)
    near = [pairs for pairs in matchings(p, h) if all(apart[q] <= 1.0 for q in pairs)]
    count, least = min((-len(pairs), sum(apart[q] for q in pairs)) for pairs in near)
    found = score([frame(x, y)], 1.0)
    assert (found.people, found.hypotheses, found.matched) == (p, h, -count)
    assert found.distance == pytest.approx(least, abs=1e-12)
    assert found.switches == 0


def test_rates_of_a_case_counted_by_hand():
    frames = [
        frame([(0, 0), (5, 0)], [(0.1, 0), (5.3, 0), (9, 9)], names=[7, 8, 9]),
        frame([(0, 0), (5, 0)], [(0.1, 0)], names=[7]),
        frame([(0, 0)], [(0.2, 0), (0, 0)], names=[7, 5]),  # kept, though another is nearer
        frame([(0, 0)], [(0, 0.4)], names=[5]),  # switched
        frame([(0, 0)], [(0, 0.4)], names=[5]),
        frame([], [(3, 3)]),
    ]
    found = score(frames, 0.5)
    assert (found.people, found.hypotheses, found.matched, found.switches) == (7, 9, 6, 1)
    assert found.tracked == pytest.approx(6 / 7)
    assert found.false == pytest.approx(3 / 9)
    assert found.mota == pytest.approx(1 - (1 + 3 + 1) / 7)
    assert found.motp == pytest.approx((0.1 + 0.3 + 0.1 + 0.2 + 0.4 + 0.4) / 6)


def test_one_hypothesis_is_never_two_peoples():
    """Somebody who comes back finds their hypothesis with another, and keeps no claim to it."""
    frames = [
        frame([(0, 0)], [(0, 0)], names=[7], ids=[0]),
        frame([(0.2, 0)], [(0.2, 0)], names=[7], ids=[1]),
        frame([(0, 0), (0.2, 0)], [(0.1, 0)], names=[7], ids=[0, 1]),
    ]
    found = score(frames, 1.0)
    assert (found.hypotheses, found.matched, found.false) == (3, 3, 0.0)


@given(seeds, st.integers(1, 6))
@settings(max_examples=60)
def test_each_frame_is_an_assignment_and_no_share_leaves_0_to_1(seed, count):
    """As many matches as SciPy's assignment finds in each frame by itself, whatever was before."""
    rng = np.random.default_rng(seed)
    frames, most = [], 0
    for _ in range(count):
        ids, names = (rng.permutation(5)[: rng.integers(5)] for _ in range(2))
        x, y = rng.uniform(0, 3, (len(ids), 2)), rng.uniform(0, 3, (len(names), 2))
        frames.append(frame(x, y, names=names, ids=ids))
        near = np.linalg.norm(x[:, None] - y, axis=-1) <= 1.0
        most += int(near[linear_sum_assignment(~near)].sum())
    found = score(frames, 1.0)
    assert found.matched == most <= min(found.people, found.hypotheses)
    assert 0 <= found.false <= 1
    assert 0 <= found.tracked <= 1
    assert found.switches <= found.matched


def test_another_measure_decides_who_is_near():
    """In direction alone the second is nobody's; what is too far in it is in no pair."""
    one = frame([(1, 0), (0, 1)], [(3, 0), (0, 1.1)])
    chords = replace(one, apart=np.array([[0.0, 1.4], [1.4, 0.9]]))
    found = score([chords], 0.2)
    assert (found.matched, found.distance) == (1, 0.0)
    assert score([one], 0.2).matched == 1


def test_two_that_exchange_their_hypotheses_are_two_switches():
    together = frame([(0, 0), (1, 0)], [(0, 0), (1, 0)], names=[1, 2])
    crossed = frame([(0, 0), (1, 0)], [(0, 0), (1, 0)], names=[2, 1])
    assert score([together, crossed], 0.4).switches == 2
    assert score([together, crossed], 1.0).switches == 0  # in reach both keep their own
    gone = frame([], [])
    assert score([together, gone, crossed], 0.4).switches == 2


def test_two_pairs_in_reach_are_better_than_a_near_one():
    found = score([frame([(0, 0), (1.0, 0)], [(0.1, 0), (-0.95, 0)])], 1.0)
    assert (found.matched, found.distance) == (2, pytest.approx(0.95 + 0.9))


@given(seeds, st.integers(2, 4), st.sampled_from([0.6, 1.0]))
@settings(max_examples=60)
def test_a_frame_after_another_has_most_pairs_then_keeps_most_then_is_nearest(seed, n, reach):
    """By brute force over all matchings; those who change their hypothesis are the switches."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(0, 1.5, (2, n, 2))
    apart = np.linalg.norm(x[:, None] - y, axis=-1)
    near = [pairs for pairs in matchings(n, n) if all(apart[q] <= reach for q in pairs)]
    count, kept, least = min(
        (-len(pairs), -sum(i == j for i, j in pairs), sum(apart[q] for q in pairs))
        for pairs in near
    )
    both = score([frame(3 * x, 3 * x), frame(x, y)], reach)
    assert both.matched == n - count
    assert both.switches == kept - count
    assert both.distance == pytest.approx(least, abs=1e-12)


def test_a_pair_more_is_worth_more_than_one_that_is_kept():
    before = frame([(0, 0)], [(0, 0)], names=[7], ids=[0])
    after = frame([(0, 0), (0.9, 0)], [(0, 0), (-0.9, 0)], names=[7, 8], ids=[0, 1])
    found = score([before, after], 1.0)
    assert (found.matched, found.switches) == (3, 1)


def test_nobody_and_nothing():
    empty = score([], 1.0)
    assert (empty.tracked, empty.false, empty.mota, empty.motp) == (1.0, 0.0, 1.0, 0.0)
    assert gospa(np.zeros((0, 2)), np.zeros((0, 2)), 1.0).total == 0


NONE, SOME = np.zeros((0, 2)), np.zeros((1, 2))
EMPTY = (NONE, np.zeros(0, int)) * 2
ONE = (SOME, np.zeros(1, int)) * 2
BAD = [
    (lambda: frame([(0, 0), (1, 1)], [], ids=[3, 3]), "people_ids must differ"),
    (lambda: frame([], [(0, 0), (1, 1)], names=[3, 3]), "hypotheses_ids must differ"),
    (lambda: frame([(0, 0)], [], ids=[1, 2]), "people_ids must be"),
    (lambda: Frame(*EMPTY, np.zeros((1, 0))), "apart must be"),
    (lambda: Frame(*ONE, [[-1.0]]), "apart must not be negative, got -1"),
    (lambda: Frame(*ONE, [[np.inf]]), "apart must be finite"),
    (lambda: score([], 0.0), "reach must be positive"),
    (lambda: gospa(np.zeros((1, 3)), np.zeros((1, 2)), 1.0), "people must be"),
    (lambda: gospa(np.zeros((1, 2)), np.zeros((1, 2)), 0.0), "cutoff must be positive"),
]


@pytest.mark.parametrize(("wrong", "message"), BAD)
def test_bad_input_is_named(wrong, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        wrong()
