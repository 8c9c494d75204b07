"""Merging by time stamp: nothing is lost, time adds up, and cuts do not change the motion."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.geometry import between
from robot_perception.slam.planar import Odometry, compound, dead_reckoning
from robot_perception.streams import Held, hold, merge, ticks
from tests.unchecked import unchecked

SEEDS = st.integers(0, 2**31)
DENSITY = np.array([2e-3, 1e-3])


def streams(seed):
    """Return commands and observations on a coarse clock, so that many times are the same."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.integers(0, 3, 30)) / 4
    commands = rng.integers(0, 2, (30, 2)) * [0.4, -0.7]
    return times, commands, np.sort(rng.integers(-8, 100, 25)) / 8


@given(SEEDS, st.sampled_from([0.0, 0.25, -0.5]), st.sampled_from([0.0, 0.25, 1.0]))
def test_every_observation_is_used_in_order_or_counted(seed, delay, pause):
    times, commands, observed = streams(seed)
    merged = merge(times, commands, observed, delay=delay, pause=pause)
    begin, end = times[0] + delay, times[-1] + delay
    assert merged.early == (observed <= begin).sum()
    assert merged.late == (observed > end).sum()
    used = np.concatenate([np.arange(observed.size)[rows] for rows in merged.rows])
    assert (np.diff(used) > 0).all()
    assert used.size + merged.early + merged.late + merged.skipped == observed.size
    for rows, moment in zip(merged.rows, merged.times[1:], strict=True):
        np.testing.assert_array_equal(np.flatnonzero(observed == moment), np.r_[rows])
    assert (np.diff(merged.times[1:]) >= pause).all()
    for time in set(observed[(observed > begin) & (observed <= end)]) - set(merged.times[1:]):
        assert time - merged.times[1:][merged.times[1:] < time].max() < pause
    if pause == 0:
        assert merged.skipped == 0
        assert set(merged.times[1:]) == set(observed[(observed > begin) & (observed <= end)])


@given(SEEDS, st.sampled_from([0.0, 0.25, -0.5]))
def test_time_adds_up(seed, delay):
    times, commands, observed = streams(seed)
    merged = merge(times, commands, observed, delay=delay)
    assert (merged.held.durations > 0).all()
    spans = np.bincount(merged.held.intervals, merged.held.durations)
    np.testing.assert_allclose(spans, np.diff(merged.times), rtol=1e-12, atol=1e-12)


@given(SEEDS)
def test_a_delay_may_round_the_ends_of_the_log_away(seed):
    """Begin and end plus the delay, less the delay, may fall outside the log by a rounding."""
    rng = np.random.default_rng(seed)
    times, delay = np.sort(rng.uniform(0, 10, 5)), rng.uniform(-1e3, 1e3)
    merged = merge(times, rng.standard_normal((5, 2)), times[1:] + delay, delay=delay)
    assert (merged.early, merged.late, merged.skipped) == (0, 0, 0)
    np.testing.assert_allclose(merged.held.durations.sum(), np.ptp(times), rtol=0, atol=1e-9)


@given(SEEDS)
def test_held_commands_are_those_of_the_middle_of_each_piece(seed):
    times, commands, _ = streams(seed)
    cuts = np.random.default_rng(seed).uniform(times[0], times[-1], 6)
    cuts = np.unique(np.append(cuts, times[[0, -1]]))
    held = hold(times, commands, cuts)
    edges = cuts[0] + np.cumsum(held.durations)
    for middle, command in zip(edges - held.durations / 2, held.commands, strict=True):
        row = max(i for i, time in enumerate(times) if time <= middle)
        np.testing.assert_array_equal(command, commands[row])
    assert np.unique(held.intervals).tolist() == list(range(len(cuts) - 1))
    assert len(held.durations) <= len(cuts) + len(times)


def test_equal_commands_are_joined_but_never_across_a_cut():
    commands = np.array([[1.0, 0], [1, 0], [1, 0], [2, 0], [2, 0]])
    held = hold(np.arange(5.0), commands, np.array([0.0, 1.5, 4.0]))
    np.testing.assert_array_equal(held.durations, [1.5, 1.5, 1.0])
    np.testing.assert_array_equal(held.commands[:, 0], [1, 1, 2])
    np.testing.assert_array_equal(held.intervals, [0, 1, 1])


def moved(times, commands, observed):
    """Return the path at the moments of observation, and the covariance of each motion."""
    merged = merge(times, commands, observed)
    increments, covs = compound(merged.held, DENSITY)
    motions = [Odometry(*motion) for motion in zip(increments, covs, strict=True)]
    return dead_reckoning(np.array([1.0, -2.0, 0.5]), motions), covs


@given(SEEDS, st.integers(0, 28), st.floats(0.05, 0.95))
def test_a_command_given_twice_moves_as_if_given_once(seed, row, share):
    times, commands, observed = streams(seed)
    middle = times[row] + share * (times[row + 1] - times[row])
    twice = np.insert(times, row + 1, middle), np.insert(commands, row + 1, commands[row], axis=0)
    for one, other in zip(moved(times, commands, observed), moved(*twice, observed), strict=True):
        np.testing.assert_array_equal(one, other)


@given(SEEDS)
def test_a_motion_does_not_depend_on_where_it_is_cut(seed):
    """One observation more splits a motion in two, which together are the same motion."""
    times, commands, observed = streams(seed)
    more = np.sort(np.append(observed, (times[0] + times[-1]) / np.pi))
    path, _ = moved(times, commands, observed)
    finer, _ = moved(times, commands, more)
    new = np.searchsorted(
        merge(times, commands, more).times, merge(times, commands, observed).times
    )
    np.testing.assert_allclose(between(finer[new], path), 0, atol=1e-9)


def test_ties():
    """At 1 s: the observation is made before the command acts; of two commands the last acts."""
    times, commands = np.array([0.0, 1, 1, 2]), np.array([[1.0], [5], [2], [7]])
    merged = merge(times, commands, np.array([0.0, 1, 1, 2, 2.1]))
    np.testing.assert_array_equal(merged.times, [0, 1, 2])
    np.testing.assert_array_equal(merged.held.commands, [[1.0], [2.0]])
    assert merged.rows == (slice(1, 3), slice(3, 4))
    assert (merged.early, merged.late, merged.skipped) == (1, 1, 0)


@given(SEEDS, st.sampled_from([1.0, 10.0, 25.0]), st.sampled_from([0.5, 5.0]))
def test_moments_at_a_rate_lie_where_readings_are(seed, rate, gap):
    """None is farther than the gap behind a reading, and where readings are none is missing."""
    rng = np.random.default_rng(seed)
    times = 1.7e9 + np.cumsum(rng.choice([0.0, 0.04, 0.3, 3.0, 8 * 3600.0], 30))
    found = ticks(times, rate=rate, longest_gap=gap)
    before = times[np.searchsorted(times, found, side="right") - 1]
    assert (np.diff(found) > 0).all()
    assert (found - before <= gap + 1e-6).all()
    assert found[0] == times[0]
    assert len(found) <= len(times) * (gap * rate + 1)
    for time, after in pairwise(times):
        if after - time <= gap:
            near = np.append(found, np.inf)[np.searchsorted(found, time)]
            assert near - time <= 1 / rate + 1e-6 or near > after


def test_moments_without_a_pause_are_those_of_one_span():
    times = np.linspace(0, 3, 31)
    np.testing.assert_allclose(ticks(times, rate=10, longest_gap=1), times, atol=1e-9)
    np.testing.assert_allclose(ticks(np.array([5.0]), rate=10, longest_gap=1), [5])


T, C = np.array([0.0, 1.0]), np.zeros((2, 2))
BAD = [
    (lambda: hold(T, C, np.array([0.5])), "two or more rising times"),
    (lambda: hold(T, C, np.array([0.5, 0.5])), "two or more rising times"),
    (lambda: hold(T, C, np.array([0.5, np.nan])), "two or more rising times"),
    (lambda: hold(T, C, np.array([-1.0, 0.5])), "known from 0.000 to 1.000 s, not from -1"),
    (lambda: hold(T, C, np.array([0.0, 2.0])), "not from 0.000 to 2.000 s"),
    (lambda: hold(T[:0], C[:0], T), "known nowhere"),
    (lambda: hold(T, C[:1], T), r"commands must be \(2, d\) for times .*, got \(1, 2\)"),
    (lambda: hold(T, C + np.inf, T), "commands must be finite"),
    (
        lambda: Held(np.ones((2, 2)), np.array([1.0, 0.0]), np.array([0, 0])),
        "durations must be pos",
    ),
    (lambda: Held(np.ones((2, 2)), np.ones(2), np.array([0, 2])), "intervals must count up from 0"),
    (lambda: Held(np.ones((2, 2)), np.ones(2), np.array([1, 1])), "intervals must count up from 0"),
    (lambda: Held(np.ones((2, 2)), np.ones(2), np.array([0, -1])), "intervals must count up from"),
    (lambda: hold(T[::-1], C, T), "times must not fall, got 1.0 before 0.0"),
    (lambda: merge(T[None], C, T), r"times must be \(n,\), got \(1, 2\)"),
    (lambda: merge(T[:0], C[:0], T), "times must hold a command"),
    (lambda: merge(T, C, np.array([0.5, np.nan])), "observed must be finite"),
    (lambda: merge(T, C, np.array([0.5, 0.25])), "observed must not fall, got 0.5 before 0.25"),
    (lambda: merge(T, C, T, pause=-1.0), "pause must not be negative, got -1.0"),
    (lambda: merge(T, C, T, delay=np.nan), "delay must be finite"),
    (lambda: merge(T, C, np.array([-1.0, 0, 3])), "0.000 and 1.000 s: of 3 2 are early, 1 late"),
    (lambda: merge(T, C, np.empty(0)), "of 0 0 are early, 0 late"),
    (lambda: ticks(T[:0], rate=1.0, longest_gap=1.0), "times must hold a reading"),
    (lambda: ticks(T[::-1], rate=1.0, longest_gap=1.0), "times must not fall"),
    (lambda: ticks(T, rate=0.0, longest_gap=1.0), "rate must be positive"),
    (lambda: ticks(T, rate=1.0, longest_gap=-1.0), "longest_gap must be positive"),
    (lambda: ticks(T, rate=1e9, longest_gap=2.0), r"moments at most, got 1e\+09"),
]


@pytest.mark.parametrize(("call", "message"), BAD, ids=range(len(BAD)))
def test_bad_input_is_named(call, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        call()
