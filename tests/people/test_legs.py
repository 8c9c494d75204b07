"""Legs: round ones of closed form, segments one by one, and how far a beam in each degree sees."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.people.legs import (
    LegRules,
    Profiles,
    are_legs,
    detect,
    pairs,
    profiles,
    segments,
)
from tests.people.scenes import LASER, legs
from tests.unchecked import unchecked

SEEDS = st.integers(0, 2**31)
RADIUS = 0.07


def standing(r, phi, apart=0.3, turn=0.0):
    """Return the middles of two legs about a place, abreast as seen by the scanner, or turned."""
    across = np.array([-np.sin(phi + turn), np.cos(phi + turn)])
    return r * np.array([np.cos(phi), np.sin(phi)]) + np.array([[0.5], [-0.5]]) * apart * across


@given(st.floats(0.7, 2.0), st.floats(-1.2, 1.2), st.floats(0.2, 0.45))
def test_a_person_is_found_between_the_legs(r, phi, apart):
    found = detect(legs(standing(r, phi, apart), RADIUS), LASER)
    assert found.mean.shape == (1, 2)
    assert abs(found.mean[0, 0] - r) < 0.03  # the front of a leg is not quite as if seen from afar
    assert abs(found.mean[0, 1] - phi) < np.deg2rad(0.6)


def test_middles_and_widths_of_fine_scans_are_those_of_the_legs():
    angles, middles = np.linspace(-0.5, 0.5, 4001), standing(3.0, 0.1)
    found = profiles(legs(middles, RADIUS, angles), angles)
    found = Profiles(*(getattr(found, name)[are_legs(found)] for name in found.__slots__))
    order = np.argsort(middles[:, 1])
    np.testing.assert_allclose(found.middles, middles[order], atol=2e-3)
    np.testing.assert_allclose(found.widths, 2 * RADIUS, rtol=0.02)
    rms = RADIUS * np.sqrt(2 / 3 - np.pi**2 / 16)  # of √(1 - u²) about its mean π/4
    np.testing.assert_allclose(found.deviations, rms, rtol=0.02)
    np.testing.assert_allclose(found.bulges, RADIUS * np.pi / 4, rtol=0.12)  # no beam grazes


@given(SEEDS)
def test_segments_are_what_a_loop_over_the_readings_finds(seed):
    rng = np.random.default_rng(seed)
    ranges = 2 + np.cumsum(rng.normal(0, 0.07, 80))
    ranges = np.where(rng.random(80) < 0.1, np.inf, np.maximum(ranges, 0.2))
    angles, rules = np.sort(rng.uniform(-3, 3, 80)), LegRules(jump=0.1)
    expected, before = [], np.inf
    for k, r in enumerate(ranges):
        if np.isinf(r):
            pass
        elif np.isinf(before) or abs(r - before) > 0.1:
            expected.append([k, k])
        else:
            expected[-1][1] = k
        before = r
    spans = segments(ranges, angles, rules)
    np.testing.assert_array_equal(spans, np.reshape(expected, (-1, 2)))
    found = profiles(ranges, angles, rules)
    long = [span for span in expected if span[1] > span[0]]
    np.testing.assert_array_equal(found.spans, np.reshape(long, (-1, 2)))
    points = ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for k, (a, b) in enumerate(long):
        own, r, chord = points[a : b + 1], ranges[a : b + 1], points[b] - points[a]
        width = np.hypot(*chord) + r.mean() * (angles[b] - angles[a]) / (b - a)
        mean = own.mean(axis=0)
        assert found.widths[k] == pytest.approx(width)
        assert found.deviations[k] == pytest.approx(r.std())
        outwards = np.pi / 8 * width * mean / np.hypot(*mean)
        np.testing.assert_allclose(found.middles[k], mean + outwards)
        normal = np.array([-chord[1], chord[0]]) / np.hypot(*chord)
        bulge = np.mean((own[1:-1] - own[0]) @ normal) if b - a > 1 else 0.0
        assert found.bulges[k] == pytest.approx(bulge, abs=1e-9)
        sides = [ranges[a - 1] if a else np.inf, ranges[b + 1] if b < 79 else np.inf]
        assert found.free[k] == (sides[0] > ranges[a] or sides[1] > ranges[b])


@pytest.mark.parametrize(
    ("changes", "passes"),
    [
        ({}, True),
        ({"widths": 0.04}, False),
        ({"widths": 0.26}, False),
        ({"deviations": 0.05}, False),
        ({"bulges": -0.02}, False),
        ({"bulges": -0.01}, True),
        ({"free": False}, False),
    ],
)
def test_each_condition_counts(changes, passes):
    values = {"widths": 0.12, "deviations": 0.02, "bulges": 0.02, "free": True} | changes
    one = {name: np.array([value]) for name, value in values.items()}
    found = Profiles(np.array([[0, 3]]), np.array([[2.0, 0.0]]), **one)
    assert len(found) == 1
    np.testing.assert_array_equal(are_legs(found), [passes])


def test_a_wall_a_corner_and_a_strip_of_wall_are_no_legs():
    wall = 2 / np.cos(LASER[30:151])
    assert not are_legs(profiles(wall, LASER[30:151])).any()
    hollow = np.abs(np.deg2rad(np.arange(-3.0, 4.0)))  # the corner of a niche, 0.24 m wide
    niche = 2 - 0.1 * hollow / hollow.max()
    scan = np.r_[np.full(20, 6.0), niche, np.full(20, 6.0)]
    angles = np.deg2rad(np.arange(len(scan)) - 23.0)
    found = profiles(scan, angles)
    assert found.bulges[1] < -0.015
    assert not are_legs(found).any()
    scan[20:27] = 3.9 - niche
    np.testing.assert_array_equal(are_legs(profiles(scan, angles)), [False, True, False])
    strip = np.r_[np.full(20, 1.0), np.full(6, 2.0), np.full(20, 1.0)]
    angles = np.deg2rad(np.arange(46.0))
    found = profiles(strip, angles)
    np.testing.assert_array_equal(found.free, [True, False, True])


def test_a_skirt_and_legs_behind_one_another_are_missed():
    """As the paper says of its detector: section 2.1."""
    skirt = legs([[1.5, 0.0]], 0.2)
    assert len(detect(skirt, LASER).mean) == 0
    aside = legs(standing(1.5, 0.0, 0.3, turn=np.pi / 2), RADIUS)
    assert are_legs(profiles(aside, LASER)).sum() == 1
    assert len(detect(aside, LASER).mean) == 0


@pytest.mark.parametrize("r", [1.5, 2.5, 3.5, 4.5, 6.0])
def test_how_far_a_leg_is_seen_is_a_matter_of_the_gap_between_beams(r):
    r"""A leg of angular width α under beams Δ apart holds :math:`\lfloor\alpha/\Delta\rfloor` of
    them, or one more by chance :math:`\alpha/\Delta - \lfloor\alpha/\Delta\rfloor`.
    """
    gap, rng = np.deg2rad(1.0), np.random.default_rng(0)
    hits = 2 * np.arcsin(RADIUS / r) / gap
    chance = np.clip(hits - 1, 0, 1)  # of two readings
    seen = []
    for shift in np.linspace(0, gap, 100, endpoint=False):
        angles = LASER + shift + 1e-9 * rng.random()
        found = profiles(legs([[r, 0.0]], RADIUS, angles, far=9.0), angles)
        seen.append(are_legs(found).any())
    assert np.mean(seen) == pytest.approx(chance, abs=0.021)


@given(SEEDS, st.integers(0, 9))
def test_legs_are_paired_as_by_taking_the_nearest_pair_again_and_again(seed, count):
    rng = np.random.default_rng(seed)
    middles, rules = rng.uniform(0, 1, (count, 2)), LegRules(apart=(0.1, 0.5))
    left, expected = set(range(count)), []
    while True:
        near = [(np.hypot(*(middles[i] - middles[j])), i, j) for i in left for j in left if i < j]
        near = [pair for pair in near if 0.1 <= pair[0] <= 0.5]
        if not near:
            break
        _, i, j = min(near)
        left -= {i, j}
        expected.append([i, j])
    np.testing.assert_array_equal(pairs(middles, rules), np.reshape(expected, (-1, 2)))


def test_the_direction_is_less_certain_the_nearer_a_person_is():
    rules = LegRules(range_sigma=0.2, side_step=0.3)
    near, far = (detect(legs(standing(r, 0.4), RADIUS), LASER, rules) for r in (0.8, 2.0))
    for found in (near, far):
        r = found.mean[0, 0]
        expected = np.diag([0.2**2, np.arctan(0.3 / r) ** 2])
        np.testing.assert_allclose(found.cov[0], expected, rtol=1e-12, atol=1e-15)
    assert near.cov[0, 1, 1] > 4 * far.cov[0, 1, 1]


@pytest.mark.parametrize("turn", [-np.pi, np.pi / 2, 3.0])
def test_a_scanner_that_looks_backwards_sees_people_behind(turn):
    ahead = detect(legs([*standing(1.5, 0.3), *standing(2.0, -0.6)], RADIUS), LASER)
    behind = detect(legs([*standing(1.5, 0.3), *standing(2.0, -0.6)], RADIUS), LASER + turn)
    gaps = behind.mean - ahead.mean - [0, turn]
    np.testing.assert_allclose(np.exp(1j * gaps[:, 1]), 1, atol=1e-12)
    assert (np.abs(behind.mean[:, 1]) <= np.pi).all()


def test_nothing_in_range_is_nobody():
    nothing = np.full(181, np.inf)
    assert segments(nothing, LASER).shape == (0, 2)
    assert len(profiles(nothing, LASER)) == 0
    assert detect(nothing, LASER).mean.shape == (0, 2)
    assert detect(np.ones(1), np.zeros(1)).mean.shape == (0, 2)


@pytest.mark.parametrize(
    ("ranges", "angles", "reason"),
    [
        (np.ones(180), LASER, r"angles must be \(180,\) for ranges \(180,\), got \(181,\)"),
        (np.where(LASER > 1, np.nan, 1.0), LASER, "ranges must be positive, got 33 of 181 NaN"),
        (np.zeros(181), LASER, "ranges must be positive, got 181 of 181"),
        (np.ones(181), LASER[::-1], "angles must be strictly increasing"),
        (np.ones(181), 3 * LASER, "angles span 9.425 rad, more than one turn"),
        (np.zeros(0), np.zeros(0), "ranges must be one reading at least"),
    ],
)
def test_what_is_no_scan_is_refused(ranges, angles, reason):
    with unchecked(), pytest.raises(ValueError, match=reason):
        detect(ranges, angles)


@pytest.mark.parametrize(
    ("rules", "reason"),
    [
        ({"widths": (0.2, 0.1)}, r"widths must rise from 0 or more, got \(0.2, 0.1\)"),
        ({"apart": (-0.1, 0.1)}, "apart must rise from 0 or more"),
        ({"least_readings": 1}, "least_readings must be at least 2, got 1"),
        ({"jump": 0.0}, "jump must be positive"),
    ],
)
def test_rules_that_make_no_sense_are_refused(rules, reason):
    with unchecked(), pytest.raises(ValueError, match=reason):
        LegRules(**rules)
