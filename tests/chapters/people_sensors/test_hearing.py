"""Microphones: when they speak, and whom they hear."""

import numpy as np
import pytest

from robot_perception.chapters.people_sensors import sessions
from robot_perception.chapters.people_sensors.hearing import NAME, PAIR, Ears, heard
from robot_perception.chapters.people_sensors.sessions import Config
from robot_perception.geometry import wrap_angle

SHORT = Config(8009, 12.0)  # none of those that are used elsewhere


def test_microphones_have_a_rhythm_of_their_own():
    found = heard(SHORT, Ears())
    ends = 0.25 * np.arange(1, 49)  # nothing is known of a window before it ends
    assert [one.time for one in found] == pytest.approx(ends)
    assert {one.sensor for one in found} == {NAME}
    assert SHORT.seed not in {*sessions.CHOOSE, *sessions.TEST, *sessions.LEARN}


def test_most_of_what_four_hear_is_a_person_and_what_they_hear_elsewhere_is_not():
    """By direction, of people who are in the office at the time."""
    session_, _ = sessions.staged(SHORT)
    near = []
    for ears in (Ears(), Ears(elsewhere=True)):
        off = []
        for one in heard(SHORT, ears):
            now = session_.at(one.time)
            gap = now.positions[now.present] - now.robot[:2]
            phi = np.arctan2(gap[:, 1], gap[:, 0]) - now.robot[2]
            gaps = np.abs(wrap_angle(one.positions.mean[:, 1, None] - phi))
            off += gaps.min(axis=1).tolist()
        assert len(off) > 10
        near.append(np.mean(np.array(off) < np.deg2rad(10)))
    assert near[0] > 0.6 > 2 * near[1]


def test_a_pair_hears_each_voice_twice():
    """Two microphones cannot tell a direction from its mirror image."""
    counts = {len(one) for one in heard(SHORT, Ears(PAIR))}
    assert 2 in counts
    assert counts <= {0, 1, 2, 3, 4}
