"""Behaviours: the paper's stories step by step, and what never happens."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from shapely import LineString, Point

from robot_perception.geometry import se2
from robot_perception.people.behaviours import (
    FURNITURE,
    MOVES,
    NOBODY,
    PARTNER,
    STOP,
    Behaviours,
    Command,
    State,
    blocks,
    roles,
)
from tests.people.test_aggregation import known
from tests.unchecked import unchecked

RULES = Behaviours()
FAR = RULES.reach + 0.1


def persons(time, *places, born=None):
    """Return persons (identity, r, φ) at a time; all of them came up at 0 s unless told."""
    some = known(*[(r, phi) for _, r, phi in places], time=time)
    ids = np.array([name for name, _, _ in places], dtype=np.int64)
    start = np.zeros(len(ids)) if born is None else np.array(born, dtype=float)
    return replace(some, identity=ids, following=1000, born=start)


def told(behaviour, story, state=None):
    """Return the phases and commands of a story of persons."""
    state, phases, commands = state or State(), [], []
    for there in story:
        state, command = behaviour(state, there)
        phases.append(state.phase)
        commands.append(command)
    return state, phases, commands


def polled(state, there, finished=False):
    return RULES.survey(state, there, finished)


def test_what_a_hypothesis_is_taken_for():
    """Too light, too far away perhaps, one that stays, one that moves, and the one it is about."""
    cov = np.tile(np.diag([0.1, 0.01]), (5, 1, 1))
    cov[1, 0, 0] = 1.3**2
    five = known(*[(1, 1)] * 5, weight=[0.2, 1, 1, 1, 1], cov=cov)
    still, busy = np.array([False, False, True, False, True]), State("busy", 4)
    found = roles(five, still, busy, 0.4, 1.2)
    assert found.tolist() == [NOBODY, NOBODY, FURNITURE, MOVES, PARTNER]
    waiting = roles(five, still, State("waiting", 4), 0.4, 1.2)
    assert waiting.tolist() == [NOBODY, NOBODY, FURNITURE, MOVES, FURNITURE]


def test_a_guide_goes_on_while_the_visitor_is_there():
    state, phases, commands = told(
        RULES.guide, [persons(0.0), persons(1.0, (4, 2, 3.0)), persons(2.0, (4, 2.9, 3.0))]
    )
    assert phases == ["waiting", "busy", "busy"]
    assert commands == [STOP, Command(RULES.speed), Command(RULES.speed)]
    assert (state.person, state.seen, state.since) == (4, 2.0, 1.0)


@pytest.mark.parametrize("away", [[], [(4, FAR, 3.0)]])
def test_a_guide_stops_asks_back_once_and_goes_on(away):
    start = State("busy", 4, seen=10.0, since=0.0)
    story = [persons(10.0 + t, *away) for t in (0.5, 1.0, 1.1, 2.0, 5.0)]
    state, phases, commands = told(RULES.guide, [*story, persons(16.0, (4, 2.0, 3.0))], start)
    assert phases == ["busy", "busy", "asking back", "asking back", "asking back", "busy"]
    assert [c.speed for c in commands] == [RULES.speed] * 2 + [0.0] * 3 + [RULES.speed]
    assert [c.say for c in commands] == ["", "", "come back", "", "", "welcome back"]
    assert state.since == 16.0


def test_a_guide_gives_up_and_takes_the_visitor_back_all_the_same():
    asking = State("asking back", 4, seen=0.0, since=1.0)
    late = 1.0 + RULES.resigned
    state, phases, _ = told(RULES.guide, [persons(late), persons(late + 0.1)], asking)
    assert phases == ["asking back", "given up"]
    state, command = RULES.guide(state, persons(late + 1, (4, 1, 0)))
    assert (state.phase, command.say) == ("busy", "welcome back")


def test_a_guide_that_is_blocked_asks_once_waits_and_says_thank_you():
    busy, here = State("busy", 4, seen=0.0, since=0.0), (4, 2.0, 3.0)
    state, phases, commands = busy, [], []
    for time, blocked in ((1.0, False), (2.0, True), (3.0, True), (4.0, False), (5.0, False)):
        state, command = RULES.guide(state, persons(time, here), blocked)
        phases.append(state.phase)
        commands.append(command)
    assert phases == ["busy", "blocked", "blocked", "busy", "busy"]
    assert [c.say for c in commands] == ["", "clear the path", "", "thank you", ""]
    assert [c.speed > 0 for c in commands] == [True, False, False, True, True]
    assert state.since == 4.0


def test_a_guide_that_is_blocked_still_notices_who_leaves():
    busy = State("busy", 4, seen=0.0, since=0.0)
    state, command = RULES.guide(busy, persons(0.5), True)  # out of sight for a moment
    assert (state.phase, command.say, state.seen, state.since) == (
        "blocked", "clear the path", 0.0, 0.5,
    )  # fmt: skip
    waits, command = RULES.guide(state, persons(0.9), False)
    assert (waits.phase, command) == ("blocked", STOP)
    gone, command = RULES.guide(state, persons(0.1 + RULES.patience), True)
    assert (gone.phase, command.say) == ("asking back", "come back")
    nobody, command = RULES.guide(State(), persons(1.0), True)
    assert (nobody.phase, command) == ("waiting", STOP)


@given(
    st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3)), min_size=2, max_size=5, unique=True),
    st.tuples(st.floats(-4, 4), st.floats(-4, 4)),
    st.floats(0.1, 2.0),
)
def test_who_blocks_a_route_is_nearer_than_half_its_width(ends, point, width):
    line = LineString(ends)
    apart = line.distance(Point(point))
    assume(abs(apart - width / 2) > 1e-6)
    there = blocks(np.array([point, (99.0, 0.0)]), np.array(ends), width)
    assert there.tolist() == [apart < width / 2, False]


@pytest.mark.parametrize("behaviour", [RULES.guide, RULES.follow])
def test_somebody_who_was_there_all_along_is_not_the_one_who_left(behaviour):
    lost = State("asking back", 4, seen=10.0, since=11.0)
    bystander, newcomer = (5, 1.0, 0.0), (9, 2.0, 0.0)
    state, _ = behaviour(lost, persons(12.0, bystander, born=[0.0]))
    assert state.phase == "asking back"
    for born, back in ((10.0 - RULES.memory, True), (9.9 - RULES.memory, False), (11.5, True)):
        there = persons(12.0, bystander, newcomer, born=[0.0, born])
        state, _ = behaviour(lost, there)
        assert (state.person == 9) == back
    state, _ = behaviour(lost, persons(12.0, (4, FAR, 0.0), newcomer, born=[0.0, 11.0]))
    assert state.phase == "asking back"  # they are known to be too far away


@given(st.lists(st.tuples(st.floats(0.05, 3), st.booleans()), min_size=1, max_size=40))
def test_a_guide_never_drives_without_the_visitor_for_longer_than_the_patience(story):
    state, time, last = State(), 0.0, -np.inf
    for pause, there in story:
        time += pause
        last = time if there else last
        state, command = RULES.guide(state, persons(time, *[(4, 2.0, 0.0)] * there))
        assert (command.speed > 0) == (time - last <= RULES.patience)


def test_a_follower_turns_to_the_person_and_keeps_its_distance():
    busy = State("busy", 4, seen=0.0, since=0.0)
    for r, phi, speed, turn in (
        (1.5, 0.2, 0.5, 0.2),
        (2.9, -0.3, 0.8, -0.3),
        (0.5, 0.0, 0.0, 0.0),
        (2.0, 2.0, 0.0, 1.0),
        (2.0, -3.0, 0.0, -1.0),
    ):
        _, command = RULES.follow(busy, persons(1.0, (4, r, phi)))
        assert (command.speed, command.turn_rate) == pytest.approx((speed, turn))


def test_a_follower_comes_to_rest_at_its_distance_facing_the_person():
    """Closed loop with a unicycle, from a person behind."""
    pose, place, state = np.zeros(3), np.array([[-2.0, 1.0]]), State()
    for k in range(300):
        x, y = se2.act(se2.inverse(pose), place)[0]
        r, phi = np.hypot(x, y), np.arctan2(y, x)
        state, command = RULES.follow(state, persons(0.05 * k, (0, r, phi)))
        pose = se2.compose(pose, 0.05 * np.array([command.speed, 0.0, command.turn_rate]))
    assert (r, phi) == pytest.approx((RULES.gap, 0.0), abs=1e-3)


def test_a_follower_stops_at_once_and_asks_back_after_its_patience():
    busy = State("busy", 4, seen=0.0, since=0.0)
    state, phases, commands = told(RULES.follow, [persons(t) for t in (0.5, 1.0, 1.1, 2.0)], busy)
    assert phases == ["busy", "busy", "asking back", "asking back"]
    assert commands == [STOP, STOP, Command(say="come back"), STOP]
    state, command = RULES.follow(state, persons(3.0, (7, 2.0, 0.0), born=[2.5]))
    assert (state.person, command.say, command.speed) == (7, "welcome back", 0.8)


def test_a_survey_from_the_invitation_to_the_end():
    state, say, phases = State(), [], []
    story = [
        (persons(0.0), False),
        (persons(1.0, (3, FAR, 0.0)), False),
        (persons(2.0, (3, 2.5, 0.0), (5, 2.8, 1.0)), False),
        (persons(3.0, (3, 2.0, 0.0)), False),
        (persons(4.0, (3, 1.4, 0.0)), False),
        (persons(5.0, (3, 1.3, 0.0)), False),
        (persons(6.0, (3, 1.3, 0.0)), True),
        (persons(7.0, (3, 1.3, 0.0)), False),  # not invited again
        (persons(8.0, (3, 1.3, 0.0), (6, 2.0, 0.0)), False),
    ]
    for there, finished in story:
        state, command = polled(state, there, finished)
        say.append(command.say)
        phases.append(state.phase)
        assert command.speed == command.turn_rate == 0
    waiting, inviting, busy = "waiting", "inviting", "busy"
    assert phases == [waiting] * 2 + [inviting] * 2 + [busy] * 2 + [waiting] * 2 + [inviting]
    assert say == ["", "", "come nearer", "", "take part", "", "thank you", "", "come nearer"]
    assert state.person == 6


def test_who_breaks_off_a_survey_is_noticed_and_called_back():
    state = State("busy", 3, seen=10.0, since=5.0)
    state, command = polled(state, persons(11.0, (3, 2.0, 0.0)))
    assert (state.phase, command) == ("busy", STOP)
    state, command = polled(state, persons(11.1, (3, 2.4, 0.0)))
    assert (state.phase, command.say, state.since) == ("asking back", "come back", 11.1)
    back, command = polled(state, persons(15.0, (3, 1.4, 0.0)))
    assert (back.phase, command.say) == ("busy", "welcome back")
    gone, _ = polled(state, persons(11.2 + RULES.resigned))
    assert gone.phase == "waiting"


def test_who_does_not_come_is_forgotten():
    state = State("inviting", 3, seen=10.0, since=10.0)
    there, _ = polled(state, persons(14.0, (3, 2.0, 0.0)))
    assert (there.phase, there.seen) == ("inviting", 14.0)
    for time, phase in ((11.0, "inviting"), (11.1, "waiting")):
        left, _ = polled(state, persons(time, (3, FAR, 0.0)))
        assert left.phase == phase


BAD = [
    (lambda: blocks(np.zeros((1, 2)), np.zeros((1, 2)), 1.0), "two ends at least"),
    (
        lambda: RULES.guide(State("busy", 1, 5.0, 1.0), persons(4.0, (1, 1, 0))),
        "older than the state",
    ),
    (lambda: RULES.follow(State(since=5.0), persons(4.0, (1, 1, 0))), "older than the state"),
    (lambda: State(phase="lost"), "phase must be one of"),
    (lambda: State(person=-2), "person must be at least -1"),
    (lambda: State(seen=np.inf), "seen must be finite or -inf"),
    (lambda: Behaviours(gap=0.0), "gap must be positive"),
    (lambda: Behaviours(close=4.0), "close must not be above reach"),
]


@pytest.mark.parametrize(("wrong", "message"), BAD)
def test_bad_input_is_named(wrong, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        wrong()
