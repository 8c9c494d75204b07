r"""State machine of the interaction: a table of states that detectors drive.

A detector is the user's: it puts what it found under a name of its own among the *percepts*. A rule
turns percepts into an *event*, true or false, and an event counts once it has been true for some
pictures in a row. The table says which event leads from which state to which. New detectors, events
and states are new entries; nothing here knows a face or a hand.

`paper_table` is Fig. 2 of Menezes, Lerasle and Dias, "Visual Tracking Modalities for a Companion
Robot", as its text tells it (the drawing is not to be had).
"""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Annotated, Any, final

from robot_perception import checks
from robot_perception.fields import checked, from_to

__all__ = [
    "Event",
    "Interaction",
    "InteractionInfo",
    "InteractionState",
    "StateTable",
    "Transition",
    "paper_table",
]

Percepts = Mapping[str, Any]


def _named(name: str, value: Any) -> str:
    """Return a text that is not blank."""
    if not checks.instance(name, value, str).strip():
        raise ValueError(f"{name} must be a name, got {value!r}")
    return value


Name = Annotated[str, _named]


def _arrows(name: str, value: Any) -> tuple["Transition", ...]:
    """Return the arrows of a tuple or a list, whose order counts."""
    return checks.instances(name, checks.instance(name, value, tuple, list), Transition)


@final
@dataclass(frozen=True, slots=True)
class Transition:
    """One arrow of the table.

    Parameters
    ----------
    source, target
        States.
    event
        What leads from the one to the other.

    Raises
    ------
    ValueError
        If the arrow leads nowhere else.
    """

    source: Name
    event: Name
    target: Name

    def __post_init__(self) -> None:
        checked(self)
        if self.source == self.target:
            raise ValueError(f"target must be another state than source, got {self.target!r} twice")


@final
@dataclass(frozen=True, slots=True)
class StateTable:
    """States and what leads from each to the next, in order of precedence.

    Parameters
    ----------
    start
        The first state.
    transitions
        The arrows. Where several events of a state are true, the one that stands first is taken.

    Raises
    ------
    ValueError
        If there is no arrow, two of a state have the same event, a state has no exit, or one cannot
        be reached from the start; the message names them.
    """

    start: Name
    transitions: Annotated[tuple[Transition, ...], _arrows]

    def __post_init__(self) -> None:
        checked(self)
        arrows = self.transitions
        seen: set[tuple[str, str]] = set()
        for arrow in arrows:
            if (arrow.source, arrow.event) in seen:
                raise ValueError(
                    f"transitions must name an event of a state once, got {arrow.event!r} of"
                    f" {arrow.source!r} twice"
                )
            seen.add((arrow.source, arrow.event))
        if stuck := sorted(set(self.states) - {arrow.source for arrow in arrows}):
            raise ValueError(
                f"transitions must lead out of start and every state, none does of {stuck}"
            )
        if lost := sorted(set(self.states) - self.reachable(self.start)):
            raise ValueError(f"every state must be reached from {self.start!r}, got {lost}")

    @property
    def states(self) -> tuple[str, ...]:
        """All states, the first one first."""
        named = (n for arrow in self.transitions for n in (arrow.source, arrow.target))
        return tuple(dict.fromkeys((self.start, *named)))

    @property
    def events(self) -> tuple[str, ...]:
        """All events."""
        return tuple(dict.fromkeys(arrow.event for arrow in self.transitions))

    def reachable(self, state: str) -> set[str]:
        """Return the states that some events lead to from this one, itself included."""
        todo, found = deque([_named("state", state)]), {state}
        while todo:
            here = todo.popleft()
            for arrow in self.transitions:
                if arrow.source == here and arrow.target not in found:
                    found.add(arrow.target)
                    todo.append(arrow.target)
        return found

    def of(self, state: str) -> tuple[Transition, ...]:
        """Return the arrows that lead out of a state, in order of precedence.

        Raises
        ------
        ValueError
            If there is no such state.
        """
        checks.one_of("state", state, self.states)
        return tuple(arrow for arrow in self.transitions if arrow.source == state)

    def next(self, state: str, events: Iterable[str]) -> tuple[str, str | None]:
        """Return the state after some events, and the event that led there.

        Parameters
        ----------
        state
            Before.
        events
            Those that are true; those that mean nothing in this state are passed over.

        Returns
        -------
        (str, str or None)
            The same state and ``None`` if no event leads elsewhere.

        Raises
        ------
        ValueError
            If there is no such state, or an event stands nowhere in the table.
        """
        given = checks.iterable("events", events)
        true = {checks.one_of("events", event, self.events) for event in given}
        for arrow in self.of(state):
            if arrow.event in true:
                return arrow.target, arrow.event
        return state, None

    def extended(self, *transitions: Transition, first: bool = False) -> "StateTable":
        """Return the table with more arrows, after those of the same state or before them."""
        first = checks.flag("first", first)
        parts = (transitions, self.transitions) if first else (self.transitions, transitions)
        return replace(self, transitions=(*parts[0], *parts[1]))


@final
@dataclass(frozen=True, slots=True)
class Event:
    """Condition under which an event is true.

    Parameters
    ----------
    rule
        Function of the percepts that returns whether it is so in this picture.
    pictures
        For how many pictures in a row it must be so.
    """

    rule: Callable[[Percepts], bool]
    pictures: Annotated[int, from_to(1, 10**6)] = 1
    __post_init__ = checked


@final
@dataclass(frozen=True, slots=True)
class InteractionState:
    """State of the interaction.

    Parameters
    ----------
    name
        The state of the table.
    pictures
        How many pictures it has lasted.
    runs
        For how many pictures in a row each event has been so, since the state was entered.
    """

    name: Name
    pictures: Annotated[int, from_to(0)] = 0
    runs: Mapping[str, Annotated[int, from_to(0)]] = field(
        default_factory=lambda: MappingProxyType({})
    )

    def __post_init__(self) -> None:
        checked(self)
        object.__setattr__(self, "runs", MappingProxyType(self.runs))


@final
@dataclass(frozen=True, slots=True)
class InteractionInfo:
    """Diagnostics of one step.

    Parameters
    ----------
    so
        The events whose rule holds in this picture.
    true
        Those that have held for as many pictures as they must.
    event
        The one that led to another state, ``None`` if the state stays.
    before
        The state before.
    """

    so: tuple[str, ...]
    true: tuple[str, ...]
    event: str | None
    before: str


@final
@dataclass(frozen=True, slots=True)
class Interaction:
    """A table and the rules of its events.

    Parameters
    ----------
    table
        The states.
    events
        The rule of each event of the table, by name.

    Raises
    ------
    ValueError
        If an event of the table has no rule, or a rule is of no event; the message names it.
    """

    table: StateTable
    events: Mapping[str, Event]

    def __post_init__(self) -> None:
        checked(self)
        if apart := sorted(set(self.events) ^ set(self.table.events)):
            raise ValueError(f"events must be those of the table, one a rule; apart are {apart}")
        object.__setattr__(self, "events", MappingProxyType(self.events))

    def start(self) -> InteractionState:
        """Return the state before the first picture."""
        return InteractionState(self.table.start)

    def step(
        self, state: InteractionState, percepts: Percepts
    ) -> tuple[InteractionState, InteractionInfo]:
        """Return the state after a picture.

        Only the rules of the events that lead out of the present state are asked, and their runs
        begin anew in every state: what was seen before does not count for it.

        Parameters
        ----------
        state
            Before the picture.
        percepts
            What the detectors found in it, by the user's names.

        Raises
        ------
        KeyError
            If a rule asks for a percept that is not there.
        TypeError
            If a rule returns something else than true or false.
        """
        name = checks.instance("state", state, InteractionState).name
        checks.instance("percepts", percepts, Mapping)
        runs: dict[str, int] = {}
        for arrow in self.table.of(name):
            so = self.events[arrow.event].rule(percepts)
            if checks.flag(f"rule of {arrow.event!r}", so):
                runs[arrow.event] = state.runs.get(arrow.event, 0) + 1
        true = tuple(e for e, run in runs.items() if run >= self.events[e].pictures)
        after, event = self.table.next(name, true)
        info = InteractionInfo(tuple(runs), true, event, name)
        if event is None:
            return InteractionState(name, state.pictures + 1, runs), info
        return InteractionState(after), info


def paper_table(*, halt: bool = True) -> StateTable:
    """Return the table of the paper's interaction.

    The robot waits until it sees a face, and identifies it until one is the tutor's. With its
    tutor it idles, verifies that he is still there, and looks for an open hand; where that stands
    relative to the head says whether to follow or to track gestures. An open hand ends the
    following. The paper leaves open what follows a halt and how the tracking of gestures ends:
    here both wait until the hand is down and idle again.

    Parameters
    ----------
    halt
        Whether the end of following is a state of its own, which lasts until the hand is down.
        Without it the hand that ended the following is still up when the robot idles, and starts
        it again.

    References
    ----------
    Section II with Fig. 2, section III (hand detection) and section IV.
    """
    end = (
        [
            Transition("follow", "open hand", "halt"),
            Transition("halt", "hand down", "idle"),
            Transition("halt", "tutor gone", "wait"),
        ]
        if checks.flag("halt", halt)
        else [Transition("follow", "open hand", "idle")]
    )
    return StateTable(
        "wait",
        (
            Transition("wait", "face", "identify"),
            Transition("identify", "tutor", "idle"),
            Transition("identify", "nobody", "wait"),
            Transition("idle", "tutor gone", "wait"),
            Transition("idle", "hand above", "follow"),
            Transition("idle", "hand beside", "gesture"),
            *end,
            Transition("follow", "lost", "wait"),
            Transition("gesture", "tutor gone", "wait"),
            Transition("gesture", "hand down", "idle"),
        ),
    )
