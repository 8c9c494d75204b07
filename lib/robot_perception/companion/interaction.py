r"""Finite state machine of the interaction between a robot and a person, driven by detectors.

The user brings the detectors. What they find in a picture is handed over as *percepts*, a mapping
from names to findings. A rule decides from the percepts whether an *event* holds in this picture,
and the event is true once it has held for a number of pictures in a row. A table of transitions
says which event leads from which state to which. New detectors, events and states are new entries;
nothing here depends on faces or hands.

`paper_table` is the state machine of Menezes, Lerasle and Dias, "Visual Tracking Modalities for a
Companion Robot", Fig. 2, rebuilt from the text; the drawing itself is unavailable to us.
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
    """Return a text, or raise ``ValueError`` if it is blank."""
    if not checks.instance(name, value, str).strip():
        raise ValueError(f"{name} must be a name, got {value!r}")
    return value


Name = Annotated[str, _named]


def _arrows(name: str, value: Any) -> tuple["Transition", ...]:
    """Return transitions as a tuple; only a tuple or a list has the order that counts."""
    return checks.instances(name, checks.instance(name, value, tuple, list), Transition)


@final
@dataclass(frozen=True, slots=True)
class Transition:
    """A transition of the table.

    Parameters
    ----------
    source, target
        State before and state after, by name.
    event
        Event that leads from the one to the other, by name.

    Raises
    ------
    ValueError
        If a name is blank, or both states are the same.
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
    """States and the transitions between them, in order of precedence.

    Parameters
    ----------
    start
        State at the start.
    transitions
        If several events that leave a state are true, the first of their transitions is taken.

    Raises
    ------
    ValueError
        If there is no transition, a state has two transitions for one event, a state cannot be
        left, or one cannot be reached from the start; the message names them.
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
        """All states, that at the start first."""
        named = (n for arrow in self.transitions for n in (arrow.source, arrow.target))
        return tuple(dict.fromkeys((self.start, *named)))

    @property
    def events(self) -> tuple[str, ...]:
        """All events, in the order of the transitions."""
        return tuple(dict.fromkeys(arrow.event for arrow in self.transitions))

    def reachable(self, state: str) -> set[str]:
        """Return the states that can be reached from a state by transitions, itself included."""
        todo, found = deque([_named("state", state)]), {state}
        while todo:
            here = todo.popleft()
            for arrow in self.transitions:
                if arrow.source == here and arrow.target not in found:
                    found.add(arrow.target)
                    todo.append(arrow.target)
        return found

    def of(self, state: str) -> tuple[Transition, ...]:
        """Return the transitions that leave a state, in order of precedence.

        Raises
        ------
        ValueError
            If there is no such state.
        """
        checks.one_of("state", state, self.states)
        return tuple(arrow for arrow in self.transitions if arrow.source == state)

    def next(self, state: str, events: Iterable[str]) -> tuple[str, str | None]:
        """Return the next state if some events are true, and the event that leads there.

        Parameters
        ----------
        state
            Present state.
        events
            True events; those without a transition from this state are ignored.

        Returns
        -------
        (str, str or None)
            Next state and event; the same state and ``None`` if no event leads elsewhere.

        Raises
        ------
        ValueError
            If there is no such state, or an event is not in the table.
        """
        given = checks.iterable("events", events)
        true = {checks.one_of("events", event, self.events) for event in given}
        for arrow in self.of(state):
            if arrow.event in true:
                return arrow.target, arrow.event
        return state, None

    def extended(self, *transitions: Transition, first: bool = False) -> "StateTable":
        """Return the table with more transitions, before all others if ``first``, else after."""
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
        Function of the percepts of one picture that tells whether the event holds in it.
    pictures
        Number of pictures in a row in which the rule must hold.
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
        State of the table.
    pictures
        Number of pictures since the state was entered.
    runs
        For each event, the number of pictures in a row in which its rule has held since then.
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
        Events whose rule holds in this picture.
    true
        Events that are true: their rule has held for enough pictures in a row.
    event
        Event that led to another state; ``None`` if the state stays.
    before
        State before the step.
    """

    so: tuple[str, ...]
    true: tuple[str, ...]
    event: str | None
    before: str


@final
@dataclass(frozen=True, slots=True)
class Interaction:
    """State machine: a table of transitions with the rules of its events.

    Parameters
    ----------
    table
        States and transitions.
    events
        Condition of each event of the table, by name.

    Raises
    ------
    ValueError
        If an event of the table has no rule, or a rule belongs to no event of the table; the
        message names it.
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

        Only the rules of events that leave the present state are evaluated. Their runs start from 0
        when a state is entered: pictures before do not count.

        Parameters
        ----------
        state
            State before the picture.
        percepts
            Findings of the detectors in the picture, by name.

        Raises
        ------
        KeyError
            If a rule asks for a percept that is not there.
        TypeError
            If a rule returns anything but true or false.
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
    """Return the state machine of the paper's interaction.

    The robot waits until it sees a face, and then identifies faces until one is its tutor's. With
    its tutor it idles: it verifies that the tutor is still there and looks for an open hand. A hand
    above the head means that it shall follow, a hand beside the head that it shall track gestures.
    An open hand ends the following.

    The paper does not say what comes after a halt, nor how the tracking of gestures ends. Here the
    robot stays in these states until the hand is down, and then idles again.

    Parameters
    ----------
    halt
        Whether the end of following is a state of its own that lasts until the hand is down.
        Without it, the hand that ended the following is still up when the robot idles, and starts
        the following again.

    References
    ----------
    Menezes, Lerasle and Dias, section II with Fig. 2, section III (hand detection), section IV.
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
