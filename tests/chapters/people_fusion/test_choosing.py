"""How the rules were chosen: draws that obey the paper's order, and a race."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.book.people_fusion import CHOOSE, DRAWS, RULES, drawn, race


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
    assert RULES in [drawn(source) for _ in range(DRAWS)]
    assert obeys(RULES)


def test_the_best_of_all_sessions_wins_among_those_that_are_left():
    """Each round adds sessions to those before, and the worse half goes."""
    asked = []

    def score(rules, session):
        asked.append((rules.walk, session))
        matched = 10 * rules.walk if session != CHOOSE[0] else 5 - rules.walk
        return np.array([10.0, 10.0, matched])

    some = [replace(RULES, walk=walk) for walk in (0.1, 0.2, 0.3, 0.4)]
    best = race(some, score, ((1, 2), (3, 1)))
    assert best.walk == 0.2  # 0.3 and 0.4 would have won later
    assert sorted(asked[4:]) == [(walk, CHOOSE[k]) for walk in (0.1, 0.2) for k in (1, 2)]
