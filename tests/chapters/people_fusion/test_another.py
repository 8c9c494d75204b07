"""Microphones beside the paper's sensors: how they join, and what that took."""

import numpy as np

from robot_perception.chapters.people_fusion import another, choosing, committee
from robot_perception.chapters.people_sensors import hearing, sessions
from robot_perception.chapters.people_sensors.hearing import NAME, Ears
from robot_perception.chapters.people_sensors.sessions import SENSORS, Config
from robot_perception.people.aggregation import SensorRules
from robot_perception.people.detections import Detections, polar
from tests.chapters.people_fusion.test_keeping import session


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


def test_hypotheses_are_kept_after_each_judged_reading_of_a_sensor_that_takes_part(monkeypatch):
    whole = session([(2.0, 0.3)], 2.0)
    monkeypatch.setattr(sessions, "record", lambda config: whole)
    run = committee.tracked.__wrapped__(Config(1), committee.System(sensors=("laser",)))
    own = [row for row, k in enumerate(whole.judged) if SENSORS[whole.sensors[k]] == "laser"]
    assert run.rows.tolist() == own
    assert len(run.hypotheses) == len(run.static) == len(own) > 5


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
