"""The table explored exhaustively, and the rules that drive it."""

from itertools import chain, combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.companion.interaction import (
    Event,
    Interaction,
    InteractionState,
    StateTable,
    Transition,
    paper_table,
)

TABLES = {"paper": paper_table(), "without halt": paper_table(halt=False)}
PAPER = TABLES["paper"]


def rules(table, **pictures):
    """Return rules that read an event's own name among the percepts."""
    return {
        event: Event(lambda seen, event=event: event in seen, pictures.get(event, 1))
        for event in table.events
    }


def run(interaction, *pictures):
    """Return the states after each picture, given by the events that are so in it."""
    state, names = interaction.start(), []
    for seen in pictures:
        state, _ = interaction.step(state, dict.fromkeys(seen, True))
        names.append(state.name)
    return names


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_every_state_and_set_of_events_leads_to_a_state_of_the_table(table):
    subsets = chain.from_iterable(
        combinations(table.events, k) for k in range(len(table.events) + 1)
    )
    for events in subsets:
        for state in table.states:
            after, event = table.next(state, events)
            assert after in table.states
            if event is None:
                assert after == state
                assert not {arrow.event for arrow in table.of(state)} & set(events)
            else:
                assert Transition(state, event, after) in table.transitions
                earlier = [a.event for a in table.of(state)]
                assert not set(earlier[: earlier.index(event)]) & set(events)


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_from_every_state_every_other_can_be_reached(table):
    for state in table.states:
        assert table.reachable(state) == set(table.states)


def test_states_of_the_paper():
    assert PAPER.states == ("wait", "identify", "idle", "follow", "gesture", "halt")
    assert "halt" not in TABLES["without halt"].states


def test_nobody_is_followed_who_was_not_identified():
    """Every way into following or gestures leads through idle, and into idle first by a tutor."""
    into = {arrow.source for arrow in PAPER.transitions if arrow.target in ("follow", "gesture")}
    assert into == {"idle"}
    without = [a for a in PAPER.transitions if a.event != "tutor"]
    seen, grew = {"wait"}, True
    while grew:
        more = {a.target for a in without if a.source in seen} - seen
        seen |= more
        grew = bool(more)
    assert seen == {"wait", "identify"}


def test_a_whole_interaction():
    names = run(
        Interaction(PAPER, rules(PAPER)),
        [], ["face"], [], ["tutor"], ["hand above"], [], ["open hand"], [], ["hand down"],
        ["hand beside"], ["hand down"], ["tutor gone"],
    )  # fmt: skip
    assert names == [
        "wait", "identify", "identify", "idle", "follow", "follow", "halt", "halt", "idle",
        "gesture", "idle", "wait",
    ]  # fmt: skip


def test_a_hand_that_stays_up_starts_following_again_only_without_halt():
    up = ["open hand", "hand above"]
    for table, expected in ((PAPER, "halt"), (TABLES["without halt"], "follow")):
        begun = [["face"], ["tutor"], ["hand above"], []]
        assert run(Interaction(table, rules(table)), *begun, up, up)[-1] == expected


def test_an_event_counts_when_it_has_held_for_its_pictures_in_a_row():
    interaction = Interaction(PAPER, rules(PAPER, face=3))
    assert run(interaction, *[["face"]] * 2, [], *[["face"]] * 3) == ["wait"] * 5 + ["identify"]


def test_what_was_seen_before_a_state_does_not_count_in_it():
    pictures = {"hand above": 2, "open hand": 2}
    interaction = Interaction(PAPER, rules(PAPER, **pictures))
    both = ["hand above", "open hand"]
    assert run(interaction, ["face"], ["tutor"], both, both, both, both) == [
        "identify", "idle", "idle", "follow", "follow", "halt",
    ]  # fmt: skip


def test_the_event_that_stands_first_is_taken_and_the_step_says_what_was_so():
    interaction = Interaction(PAPER, rules(PAPER, **{"hand above": 2}))
    state = InteractionState("idle")
    after, info = interaction.step(state, {"hand beside": 1, "hand above": 1, "face": 1})
    assert (after.name, info.event, info.before) == ("gesture", "hand beside", "idle")
    assert info.so == ("hand above", "hand beside")  # the face means nothing here
    assert info.true == ("hand beside",)
    after, info = interaction.step(state, {"hand beside": 1, "tutor gone": 1})
    assert info.event == "tutor gone"
    assert after == InteractionState("wait")


def test_pictures_of_a_state_are_counted():
    interaction, state = Interaction(PAPER, rules(PAPER)), InteractionState("idle")
    for _ in range(3):
        state, _ = interaction.step(state, {})
    assert (state.name, state.pictures) == ("idle", 3)


def test_a_user_adds_a_detector_an_event_and_a_state():
    table = PAPER.extended(
        Transition("idle", "whistle", "fetch"), Transition("fetch", "hand down", "idle"), first=True
    )
    events = rules(PAPER) | {"whistle": Event(lambda seen: seen["loudness"] > 0.5)}
    interaction = Interaction(table, events)
    quiet, loud = {"loudness": 0.1}, {"loudness": 0.9}
    idle = InteractionState("idle")
    assert interaction.step(idle, quiet)[0].name == "idle"
    assert interaction.step(idle, loud | {"tutor gone": True})[0].name == "fetch"
    later = PAPER.extended(
        Transition("idle", "whistle", "fetch"), Transition("fetch", "hand down", "idle")
    )
    both = loud | {"tutor gone": True}
    assert Interaction(later, events).step(idle, both)[0].name == "wait"
    with pytest.raises(KeyError, match="loudness"):
        interaction.step(idle, {})


def table(*arrows):
    """Return a table of arrows written as source, event and target."""
    return StateTable("a", tuple(Transition(*arrow) for arrow in arrows))


def test_states_stand_in_the_order_of_the_arrows_the_first_one_first():
    assert table("axb", "cxd", "bxc", "dxa").states == ("a", "b", "c", "d")


def test_a_first_state_that_nothing_leads_back_to_is_a_state():
    found = table("axb", "bxc", "cxb")
    assert found.reachable("a") == {"a", "b", "c"}
    assert found.reachable("c") == {"b", "c"}


NAMES = st.sampled_from("abcde")


@given(st.lists(st.tuples(NAMES, st.sampled_from("xyz"), NAMES), max_size=12))
def test_a_table_is_complete_or_refused(arrows):
    """By an oracle that goes through the arrows as often as there are states."""
    plain = [a for a in arrows if a[0] != a[2]]
    seen = {"a"}
    for _ in range(5):
        seen |= {target for source, _, target in plain if source in seen}
    states = {"a", *(s for source, _, target in plain for s in (source, target))}
    twice = len({a[:2] for a in plain}) < len(plain)
    stuck = states - {source for source, _, _ in plain}
    made = [Transition(*arrow) for arrow in plain]
    if twice or stuck or states - seen:
        with pytest.raises(ValueError, match=r"transitions must|every state must"):
            StateTable("a", tuple(made))
    else:
        table = StateTable("a", tuple(made))
        assert set(table.states) == states
        assert table.reachable("a") == seen


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda: Transition("a", "", "b"), "event must be a name"),
        (lambda: Transition("a", "x", "a"), "target must be another state"),
        (lambda: StateTable("a", ()), "lead out of start and every state, none does of .'a'"),
        (lambda: table("axb"), r"none does of \['b'\]"),
        (lambda: table("axb", "axc", "bxa", "cxa"), "once, got 'x' of 'a' twice"),
        (lambda: table("axb", "bxa", "cxa"), r"reached from 'a', got \['c'\]"),
        (lambda: PAPER.next("sleep", ()), "state must be"),
        (lambda: PAPER.next("idle", ["thunder"]), "events must be"),
        (lambda: Event(lambda seen: True, 0), "pictures must be"),
        (lambda: Interaction(PAPER, {}), "apart are .'face'"),
        (
            lambda: Interaction(PAPER, rules(PAPER) | {"rain": Event(lambda seen: True)}),
            "apart are .'rain'",
        ),
        (lambda: InteractionState("idle", -1), "pictures must be"),
        (lambda: InteractionState(" "), "name must be a name"),
        (lambda: InteractionState("idle", 0, {"face": -1}), "runs.'face'. must be"),
    ],
)
def test_what_is_wrong_is_named(wrong, text):
    with pytest.raises(ValueError, match=text):
        wrong()


def test_a_rule_that_gives_no_truth_is_named():
    events = rules(PAPER) | {"tutor gone": Event(lambda seen: 1)}
    with pytest.raises(TypeError, match="rule of 'tutor gone'"):
        Interaction(PAPER, events).step(InteractionState("idle"), {})
    with pytest.raises(TypeError, match="rule"):
        Event("face")
