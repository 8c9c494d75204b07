"""Tests that a walk is told from standing, from jumps, and from time out of sight."""

import numpy as np
import pytest

from robot_perception.geometry import se2
from robot_perception.people import Hypotheses
from robot_perception.people.walking import WalkRules, Walks, watch_walks

STEP = 0.1  # s between readings
RULES = WalkRules(distance=0.8, lasting=1.0, gap=0.35, speed=2.0, slack=0.15, forgotten=3.0)


def known(places: dict[int, tuple], time: float, last: dict[int, float], pose) -> Hypotheses:
    """Return hypotheses at places in the world, each last seen at some time, about a robot."""
    n = len(places)
    points = np.array([*places.values()], dtype=float).reshape(-1, 2)
    x, y = se2.act(se2.inverse(pose), points).T
    mean = np.stack([np.hypot(x, y), np.arctan2(y, x)], axis=-1)
    covs, seen = np.tile(0.01 * np.eye(2), (n, 1, 1)), np.array([last[k] for k in places])
    ids = np.array([*places], dtype=np.int64)
    heard = {"laser": time}
    return Hypotheses(mean, covs, np.full(n, 0.9), ids, 0 * seen, seen, seen, heard, 100)


def watched(track, robot=lambda time: np.zeros(3), seen=lambda k: True) -> list[Walks]:
    """Watch one hypothesis, which is at ``track(time)`` in the world, for four seconds."""
    walks, all_of_them, last = Walks.none(), [], 0.0
    for k in range(41):
        time = round(k * STEP, 6)
        last = time if seen(k) else last
        found = known({7: track(last)}, time, {7: last}, robot(time))
        walks = watch_walks(walks, found, robot(time), RULES)
        all_of_them.append(walks)
    return all_of_them


def ahead(time: float) -> tuple[float, float]:
    return 2.0, -1.0 + 0.9 * time


CASES = {  # a track, and whether it has walked in the end
    "walks": ({"track": ahead}, True),
    "stands": ({"track": lambda time: (2.0, 1.0)}, False),
    "sways": ({"track": lambda time: (2.0, 1 + 0.3 * np.sin(3 * time))}, False),
    "jumps": ({"track": lambda time: (2.0, 0.9 * round(time))}, False),
    "runs too fast": ({"track": lambda time: (2.0, 4.0 * time)}, False),
    "stands beside a robot that drives": (
        {"track": lambda time: (2.0, 1.0), "robot": lambda time: np.array([time, 0, 0.2 * time])},
        False,
    ),
    "walks beside a robot that drives": (
        {"track": ahead, "robot": lambda time: np.array([0.0, 0.9 * time, 0.0])},
        True,
    ),
    "is seen at each third reading": ({"track": ahead, "seen": lambda k: k % 3 == 0}, True),
    "is seen at each fifth reading": ({"track": ahead, "seen": lambda k: k % 5 == 0}, False),
    "is seen for moments": (
        {"track": lambda time: (2.0, 1.5 * time), "seen": lambda k: k % 14 < 9},
        False,
    ),
    "walks there and back": (
        {"track": lambda time: (2.0, 0.9 * min(time, 4 - time))},
        True,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_who_walks(name):
    how, walks = CASES[name]
    assert watched(**how)[-1].have_walked(RULES).tolist() == [walks]


def test_a_walk_counts_from_its_distance_on_and_for_ever():
    told = [bool(walks.have_walked(RULES)[0]) for walks in watched(ahead)]
    first = told.index(True)
    assert STEP * first == pytest.approx(1.0, abs=1e-6)  # it must last so long
    assert all(told[first:])
    stays = watched(lambda time: ahead(min(time, 2.0)))
    assert stays[-1].have_walked(RULES).all()
    assert stays[-1].walked[0] == pytest.approx(1.8, abs=1e-6)


def test_nobody_knows_where_those_are_that_were_not_seen_for_long():
    found = watched(ahead, seen=lambda k: k < 8)
    known_at = [walks.are_known(k * STEP, RULES)[0] for k, walks in enumerate(found)]
    assert known_at.index(False) == 38  # 3 s after reading 7
    assert not any(known_at[38:])


def test_those_that_have_gone_are_forgotten_and_numbers_keep_what_is_theirs():
    walks, zero = Walks.none(), np.zeros(3)
    for k in range(15):
        time = k * STEP
        both = {3: (1.0, 0.0), 7: ahead(time)}
        walks = watch_walks(walks, known(both, time, dict.fromkeys(both, time), zero), zero, RULES)
    assert walks.have_walked(RULES).tolist() == [False, True]
    time += STEP
    found = known({7: ahead(time), 9: (1.0, 0.0)}, time, {7: time, 9: time}, zero)
    walks = watch_walks(walks, found, zero, RULES)
    assert walks.identity.tolist() == [7, 9]
    assert walks.have_walked(RULES).tolist() == [True, False]
    assert len(watch_walks(walks, Hypotheses.none(), zero, RULES).identity) == 0
