"""Sonars: what a wall, a slanted wall, a leg and a neighbour's pulse do to the readings."""

import numpy as np
import pytest

from data_synth.sonar import SonarRing, ping

QUIET = SonarRing(range_sigma=0.0, loudness=0.0, crosstalk=0.0)
NO_FACE, NO_ROUND, HARD = np.zeros((0, 2, 2)), np.zeros((0, 5)), np.zeros(0, dtype=bool)
STILL = np.zeros(3)


def rng(seed=0):
    return np.random.default_rng(seed)


def wall(distance, look, slant=0.0):
    """A face at a distance from the ring in a direction, turned off the normal."""
    ahead = np.array([np.cos(look), np.sin(look)])
    along = np.array([-np.sin(look + slant), np.cos(look + slant)])
    middle = (QUIET.radius + distance) * ahead
    return np.array([[middle - 3 * along, middle + 3 * along]])


def post(distance, look, radius=0.06):
    middle = (QUIET.radius + distance + radius) * np.array([np.cos(look), np.sin(look)])
    return np.array([[*middle, radius, radius, 0.0]])


def heard(ring, ellipses, soft, sonar, repeats=200):
    soft, own = np.array([soft]), rng()
    return np.array(
        [ping(ring, STILL, NO_FACE, ellipses, soft, rng=own)[sonar] for _ in range(repeats)]
    )


def test_sonars_look_all_round():
    assert QUIET.angles.shape == (16,)
    np.testing.assert_allclose(np.diff(QUIET.angles), np.pi / 8)
    assert np.exp(1j * QUIET.angles).sum() == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("sonar", [0, 5, 15])
@pytest.mark.parametrize("distance", [0.3, 1.0, 1.8])
def test_a_wall_is_as_far_as_it_is(sonar, distance):
    faces = wall(distance, QUIET.angles[sonar])
    ranges = ping(QUIET, STILL, faces, NO_ROUND, HARD, rng=rng())
    assert ranges[sonar] == pytest.approx(distance, rel=1e-3)  # the rays are half a degree apart


def test_the_robot_carries_the_ring_along():
    pose = np.array([3.0, -1.0, 0.7])
    faces = wall(1.0, QUIET.angles[9])
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    moved = ping(QUIET, pose, faces @ turn.T + pose[:2], NO_ROUND, HARD, rng=rng())
    still = ping(QUIET, STILL, faces, NO_ROUND, HARD, rng=rng())
    np.testing.assert_allclose(moved, still)


def test_a_slanted_wall_is_lost():
    ring = SonarRing(range_sigma=0.0, crosstalk=0.0)
    straight, slanted = (
        ping(ring, STILL, wall(1.0, QUIET.angles[4], np.deg2rad(s)), NO_ROUND, HARD, rng=rng())[4]
        for s in (5, 45)
    )
    assert straight == pytest.approx(1.0, rel=0.1)
    assert np.isinf(slanted)


def test_nothing_is_heard_beyond_the_cut_nor_beside_the_cone():
    look = QUIET.angles[6]
    for distance, there in ((1.98, True), (2.02, False)):
        ranges = ping(QUIET, STILL, wall(distance, look), NO_ROUND, HARD, rng=rng())
        assert np.isfinite(ranges[6]) == there
    near = np.array([1.0 * np.cos(look + 0.3), 1.0 * np.sin(look + 0.3)])
    beside = np.array([[*near, 0.05, 0.05, 0.0]])
    assert np.isinf(heard(QUIET, beside, False, 6, 1))
    assert np.isfinite(heard(QUIET, post(1.0, look), True, 6, 1))


def test_clothes_are_heard_the_less_the_farther_they_are():
    ring = SonarRing(crosstalk=0.0)
    shares = [np.isfinite(heard(ring, post(d, ring.angles[3]), True, 3)).mean() for d in (0.6, 1.8)]
    assert shares[0] > 0.95
    assert 0.05 < shares[1] < 0.8


def test_ranges_are_noisy_in_proportion():
    ring = SonarRing(crosstalk=0.0, loudness=0.0)
    far = np.array(
        [
            ping(ring, STILL, wall(1.6, ring.angles[2]), NO_ROUND, HARD, rng=rng(k))[2]
            for k in range(300)
        ]
    )
    assert (far / 1.6 - 1).std() == pytest.approx(ring.range_sigma, rel=0.15)


def test_a_neighbours_pulse_arrives_after_half_of_its_whole_way():
    ring = SonarRing(range_sigma=0.0, loudness=0.0, crosstalk=1.0)
    target = post(1.0, ring.angles[8], 0.3)
    own = ping(QUIET, STILL, NO_FACE, target, np.zeros(1, bool), rng=rng())
    deaf = int(np.flatnonzero(np.isinf(own))[np.abs(np.flatnonzero(np.isinf(own)) - 8).argmin()])
    loud = deaf - 1 if np.isfinite(own[deaf - 1]) else deaf + 1
    readings = np.array(
        [ping(ring, STILL, NO_FACE, target, np.zeros(1, bool), rng=rng(k))[deaf] for k in range(40)]
    )
    look = ring.angles[[deaf, loud]]
    mounts = ring.radius * np.stack([np.cos(look), np.sin(look)], axis=-1)
    echo = mounts[1] + own[loud] * np.array([np.cos(look[1]), np.sin(look[1])])
    expected = (own[loud] + np.hypot(*(echo - mounts[0]))) / 2
    other = np.isfinite(readings)
    assert 0 < other.sum() < 40  # the neighbour on the other side hears nothing either
    np.testing.assert_allclose(readings[other], expected)
