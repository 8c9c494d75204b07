"""Microphones beside the paper's sensors: when they speak, what they say, and what they took."""

import numpy as np
import pytest

from robot_perception.chapters.people_fusion import another, choosing, committee, hearing, sessions
from robot_perception.chapters.people_fusion.hearing import NAME, PAIR, Ears, heard
from robot_perception.chapters.people_fusion.sessions import Config
from robot_perception.geometry import wrap_angle
from robot_perception.people.aggregation import SensorRules
from robot_perception.people.detections import Detections, polar
from tests.chapters.people_fusion.test_keeping import session

SHORT = Config(8009, 12.0)  # none of those that are used elsewhere


def test_microphones_have_a_rhythm_of_their_own():
    found = heard(SHORT, Ears())
    assert np.diff([one.time for one in found]) == pytest.approx(0.25)
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
        near.append(np.mean(np.array(off) < committee.TURN))
    assert near[0] > 0.6 > 2 * near[1]


def test_a_pair_hears_each_voice_twice():
    """Two microphones cannot tell a direction from its mirror image."""
    counts = {len(one) for one in heard(SHORT, Ears(PAIR))}
    assert 2 in counts
    assert counts <= {0, 1, 2, 3, 4}


def test_all_readings_come_in_the_order_of_time_with_the_pose_of_the_last_one():
    whole = session([(2.0, 0.3)], 1.0)
    more = tuple(
        Detections(time, NAME, polar(np.ones(1), np.zeros(1), 2.0, 0.1)) for time in (0.5, 0.9)
    )
    rows = np.flatnonzero(whole.sensors == 0).tolist()
    done = hearing.joined(whole, rows, more)
    times = [one.time for _, one, _ in done]
    assert times == sorted(times)
    assert [k for k, *_ in done if k >= 0] == rows
    assert [one for k, one, _ in done if k < 0] == list(more)


def test_joined_readings_are_heard_by_the_committee(monkeypatch):
    """Somebody whom only microphones detect is tracked with them, and not without."""
    whole = session([(2.0, 2.8)], 4.0, sees=())
    more = tuple(
        Detections(0.25 * k, NAME, polar(np.full(1, 2.0), np.full(1, 2.8), 2.0, 0.1))
        for k in range(1, 16)
    )
    monkeypatch.setattr(sessions, "record", lambda config: whole)
    monkeypatch.setattr(hearing, "heard", lambda config, ears: more)
    rules = hearing.with_microphones(committee.RULES, SensorRules(0.3, 2.0, silence=False))
    with_, without = (
        committee.tracked.__wrapped__(Config(1), committee.System(rules, ears=ears))
        for ears in (Ears(), None)
    )
    assert len(with_.hypotheses[-1].persons(rules)) == 1
    assert len(without.hypotheses[-1]) == 0
    assert (with_.rows == without.rows).all()


def test_one_of_the_rules_that_were_tried_is_used():
    tried = [system.rules.sensors[NAME] for system in choosing.heard()]
    assert hearing.TRUSTED in tried
    assert len(set(tried)) == len(tried) == 48


def test_lines_of_code_are_no_comments_and_no_docstrings():
    def example():
        """Two lines of text
        do not count."""
        yield from (  # nor does this
            1,
            2,
        )

    assert another.lines(example) == 5
