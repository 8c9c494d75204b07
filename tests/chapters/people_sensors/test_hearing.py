"""Microphones: when they speak, and whom they hear."""

import numpy as np
import pytest

from data_synth.people.staging import Config, staged
from robot_perception.book.people_sensors import CHOOSE, LEARN, TEST, heard
from robot_perception.geometry import wrap_angle

SHORT = Config(8009, 12.0)  # none of those that are used elsewhere


def test_microphones_have_a_rhythm_of_their_own():
    found = heard(SHORT)
    ends = 0.25 * np.arange(1, 49)  # nothing is known of a window before it ends
    assert [one.time for one in found] == pytest.approx(ends)
    assert {one.sensor for one in found} == {"microphones"}
    assert SHORT.seed not in {*CHOOSE, *TEST, *LEARN}


def test_most_of_what_four_hear_is_a_person_and_what_they_hear_elsewhere_is_not():
    """By direction, of people who are in the office at the time."""
    session_, _ = staged(SHORT)
    near = []
    for elsewhere in (False, True):
        off = []
        for one in heard(SHORT, elsewhere=elsewhere):
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
    counts = {len(one) for one in heard(SHORT, "pair")}
    assert 2 in counts
    assert counts <= {0, 1, 2, 3, 4}
