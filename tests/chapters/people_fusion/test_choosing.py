"""How the rules were chosen: draws that obey the paper's order, and a race."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.chapters.people_fusion import choosing, committee
from robot_perception.chapters.people_fusion.choosing import DRAWS, drawn, race
from robot_perception.chapters.people_fusion.committee import System
from robot_perception.chapters.people_sensors.sessions import Config


def obeys(rules):
    laser, sonar, camera = (rules.sensors[name] for name in ("laser", "sonar", "camera"))
    return sonar.alpha < camera.alpha < camera.alpha_behind < laser.alpha


@given(st.integers(0, 10**6))
def test_the_more_reliable_the_sensor_the_higher_is_alpha(seed):
    rules = drawn(np.random.default_rng(seed))
    assert obeys(rules)
    assert rules.person > rules.threshold


def test_the_rules_of_the_committee_are_one_of_the_draws():
    source = np.random.default_rng(0)
    assert committee.RULES in [drawn(source) for _ in range(DRAWS)]
    assert obeys(committee.RULES)


def test_the_best_of_all_sessions_wins_among_those_that_are_left(monkeypatch):
    """Each round adds sessions to those before, and the worse half goes."""
    asked = []

    def judged(job, *, rng):
        (system, session), worth = job, np.array([10.0, 10.0, 0.0, 0.0, 0.0])
        walk = system.rules.walk
        asked.append((walk, session.seed))
        worth[2] = 10 * walk if session.seed else 5 - walk
        return worth

    monkeypatch.setattr(choosing, "_judged", judged)
    some = [System(replace(committee.RULES, walk=walk)) for walk in (0.1, 0.2, 0.3, 0.4)]
    sessions = [Config(0), Config(1), Config(2)]
    ((best, worth),) = race(some, sessions, ((1, 2), (3, 1)), rng=np.random.default_rng(0))
    assert best.rules.walk == 0.2  # 0.3 and 0.4 would have won later
    assert worth == pytest.approx(5 * (4.8 + 2.0 + 2.0) / (5 * 30))
    assert sorted(asked[4:]) == [(0.1, 1), (0.1, 2), (0.2, 1), (0.2, 2)]
