"""Sonar: every near reading is a hypothesis, neighbours are one person, also round the back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.people.sonar import SonarRules, detect
from tests.unchecked import unchecked

RING = np.deg2rad([-170, -150, -130, -90, -50, -30, -10, 10, 30, 50, 90, 130, 150, 170.0])
NEARBY = np.deg2rad(np.arange(-165.0, 180.0, 30.0))
RADIUS = 0.2


def reading(angles=RING, **near):
    """Return readings: infinite but for some sensors, ``s3=1.5``."""
    ranges = np.full(len(angles), np.inf)
    for name, value in near.items():
        ranges[int(name[1:])] = value
    return ranges


def test_one_reading_is_one_hypothesis_behind_what_the_sound_meets():
    rules = SonarRules(depth=0.1, range_sigma=0.3, bearing_sigma=0.2)
    found = detect(reading(s3=1.5), RING, RADIUS, rules)
    np.testing.assert_allclose(found.mean, [[1.5 + RADIUS + 0.1, -np.pi / 2]])
    np.testing.assert_allclose(found.cov, [np.diag([0.09, 0.04])])


def test_only_what_is_nearer_than_two_metres_counts():
    found = detect(reading(s0=2.0, s4=1.999, s9=3.0), RING, RADIUS)
    np.testing.assert_allclose(found.mean[:, 1], RING[[4]])
    assert detect(reading(), RING, RADIUS).mean.shape == (0, 2)


@pytest.mark.parametrize(("one", "other", "phi"), [(7, 8, 20.0), (0, 13, 180.0), (5, 6, -20.0)])
def test_neighbours_that_may_have_met_one_person_are_one(one, other, phi):
    near = {f"s{one}": 1.0, f"s{other}": 1.0}
    found = detect(reading(**near), RING, RADIUS, SonarRules(widest=0.5, depth=0.0))
    np.testing.assert_allclose(np.exp(1j * found.mean[:, 1]), [np.exp(1j * np.deg2rad(phi))])
    np.testing.assert_allclose(found.mean[:, 0], 1.2 * np.cos(np.deg2rad(10)))
    apart = {f"s{one}": 1.0, f"s{other}": 1.7}
    assert len(detect(reading(**apart), RING, RADIUS).mean) == 2
    assert len(detect(reading(**near), RING, RADIUS, SonarRules(widest=0.3)).mean) == 2


def test_of_a_wall_every_reading_remains():
    wall = RADIUS + 0.6
    ranges = np.where(np.abs(RING) < 1, wall / np.cos(RING) - RADIUS, np.inf)
    found = detect(ranges, RING, RADIUS, SonarRules(widest=0.5, depth=0.0))
    np.testing.assert_allclose(found.mean[:, 1], RING[4:10])
    np.testing.assert_allclose(found.mean[:, 0] * np.cos(found.mean[:, 1]), wall)


def test_all_round_means_all_of_them():
    found = detect(np.full(12, 0.4), NEARBY, RADIUS)
    np.testing.assert_allclose(found.mean[:, 1], NEARBY)


@given(st.integers(0, 2**31))
def test_a_turn_of_the_ring_turns_the_hypotheses(seed):
    """Nothing is special about the seam between the last sensor and the first."""
    rng = np.random.default_rng(seed)
    ranges = np.where(rng.random(12) < 0.6, rng.uniform(0.2, 2.2, 12), np.inf)
    shift, rules = int(rng.integers(12)), SonarRules(widest=0.6)
    before = detect(ranges, NEARBY, RADIUS, rules).mean
    after = detect(np.roll(ranges, shift), NEARBY, RADIUS, rules).mean
    after = after[:, 0] * np.exp(1j * (after[:, 1] - shift * np.deg2rad(30.0)))
    before = before[:, 0] * np.exp(1j * before[:, 1])
    np.testing.assert_allclose(np.sort_complex(after.round(9)), np.sort_complex(before.round(9)))


def test_readings_on_the_map_are_left_out_and_people_beside_it_too():
    seen = []

    def occupied(points):
        seen.append(points)
        return points[:, 0] > 1.0

    near = reading(s6=1.0, s7=1.0, s10=1.0, s4=1.9)
    found = detect(near, RING, RADIUS, occupied=occupied)
    np.testing.assert_allclose(found.mean[:, 1], RING[[10]])
    rows = [4, 6, 7, 10]
    r = near[rows] + RADIUS
    expected = np.stack([r * np.cos(RING[rows]), r * np.sin(RING[rows])], axis=1)
    np.testing.assert_allclose(seen[0], expected)


@pytest.mark.parametrize(
    ("ranges", "angles", "radius", "reason"),
    [
        (np.ones(13), RING, 0.2, r"angles must be \(13,\) for ranges \(13,\), got \(14,\)"),
        (reading(s2=np.nan), RING, 0.2, "ranges must be positive, got 1 of 14 NaN"),
        (reading(s2=-1.0), RING, 0.2, "ranges must be positive"),
        (reading(), RING[::-1], 0.2, "angles must rise over less than a turn"),
        (reading(), np.linspace(0, 2 * np.pi, 14), 0.2, "angles must rise over less than a turn"),
        (reading(), RING, -0.1, "ring_radius must not be negative"),
        (np.zeros(0), np.zeros(0), 0.2, "ranges must be one reading at least"),
    ],
)
def test_what_is_no_round_is_refused(ranges, angles, radius, reason):
    with unchecked(), pytest.raises(ValueError, match=reason):
        detect(ranges, angles, radius)


def test_a_map_that_answers_something_else_is_refused():
    with unchecked(), pytest.raises(ValueError, match=r"occupied\(points\) must be \(1,\)"):
        detect(reading(s1=1.0), RING, RADIUS, occupied=lambda points: points > 0)
