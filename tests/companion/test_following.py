"""The robot that follows, on geometry of its own."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.companion.following import Follower

FOCAL, TALL = 300.0, 1.7
RULES = Follower(FOCAL, FOCAL * TALL / 2.0)  # keeps 2 m


def drive(person, *, seconds=12.0, rules=RULES, step=0.05):
    """Let a point robot follow; return distance and bearing over time."""
    x = y = heading = 0.0
    found = []
    for t in np.arange(0.0, seconds, step):
        px, py = person(t)
        away = math.hypot(px - x, py - y)
        bearing = math.remainder(math.atan2(py - y, px - x) - heading, 2 * math.pi)
        found.append((away, bearing))
        offset = -FOCAL * math.tan(bearing)
        v, w = rules.command(offset, FOCAL * TALL / (away * math.cos(bearing)))
        x, y = x + step * v * math.cos(heading), y + step * v * math.sin(heading)
        heading += step * w
    return np.array(found)


def test_a_person_who_stands_is_approached_to_the_distance_to_keep():
    away, bearing = drive(lambda t: (4.0, 1.0))[-1]
    assert away == pytest.approx(2.0, abs=0.05)
    assert bearing == pytest.approx(0.0, abs=0.01)


def test_who_is_too_near_is_backed_away_from():
    assert drive(lambda t: (1.2, 0.0))[-1, 0] == pytest.approx(2.0, abs=0.1)


def test_a_person_who_walks_is_followed_with_the_lag_of_a_proportional_law():
    """At rest relative to him v = k_v (Z / Z* - 1) is his speed."""
    speed = 0.6
    away, bearing = drive(lambda t: (2.0 + speed * t, 0.0), seconds=25)[-1]
    assert away == pytest.approx(2.0 * (1 + speed / RULES.speed_gain), abs=0.02)
    assert bearing == pytest.approx(0.0, abs=0.01)


def test_a_person_on_a_curve_stays_in_a_narrow_view():
    found = drive(lambda t: (3 * math.sin(0.2 * t), 5 - 3 * math.cos(0.2 * t)), seconds=40)
    assert np.abs(found[100:, 1]).max() < math.radians(15)


@given(st.floats(-1e4, 1e4), st.floats(1e-3, 1e5))
def test_commands_keep_their_limits_and_turn_towards_the_person(offset, height):
    v, w = RULES.command(offset, height)
    assert -RULES.most_speed / 3 <= v <= RULES.most_speed
    assert abs(w) <= RULES.most_turn
    assert w * offset <= 0
    mirrored = RULES.command(-offset, height)
    assert mirrored == pytest.approx((v, -w))


def test_far_to_the_side_the_robot_turns_before_it_drives():
    assert RULES.command(0.0, RULES.height / 2)[0] > 1
    assert RULES.command(FOCAL * 1.01, RULES.height / 2)[0] == 0.0


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda: Follower(0.0, 100.0), "focal must be"),
        (lambda: Follower(300.0, 100.0, turn_gain=-1.0), "turn_gain must be"),
        (lambda: RULES.command(math.nan, 100.0), "offset must be"),
        (lambda: RULES.command(0.0, 0.0), "height must be"),
    ],
)
def test_what_is_wrong_is_named(wrong, text):
    with pytest.raises(ValueError, match=text):
        wrong()
