"""Behaviours of a robot with the people it tracks: guide a visitor, follow a person, hold a survey.

Each is a small machine of states that sees persons and says what to do:

``Behaviours(…).guide(state, persons) -> (State, Command)``

Persons are the hypotheses that count as such, at their time; `roles` says which do. Somebody who
has been lost comes back under another identity: a person whose hypothesis came up about when the
last one was seen, or later, may be the same; one who was there all along is not.

The behaviours are those of Schaffernicht, Martin, Scheidig and Gross, sections 4.1 and 4.2; all
distances and times are ours.
"""

from dataclasses import dataclass, fields, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.people.aggregation import Hypotheses

Phase = Literal["waiting", "inviting", "busy", "asking back", "given up", "blocked"]
PHASES = ("waiting", "inviting", "busy", "asking back", "given up", "blocked")
NOBODY, FURNITURE, MOVES, PARTNER = range(4)
"""Roles of a hypothesis: too weak or nowhere, one that stays, a person, the one it is
about."""


@dataclass(frozen=True, slots=True)
class Command:
    """Command to the robot.

    Parameters
    ----------
    speed
        Forward, m/s; of a guide: at most so fast along the route.
    turn_rate
        Counter-clockwise, rad/s.
    say
        What to say now; most of the time nothing.
    """

    speed: float = 0.0
    turn_rate: float = 0.0
    say: Literal[
        "", "come back", "welcome back", "come nearer", "take part", "clear the path", "thank you"
    ] = ""


STOP = Command()


@dataclass(frozen=True, slots=True)
class State:
    """Memory of a behaviour.

    Parameters
    ----------
    phase
        ``"waiting"`` for somebody, ``"inviting"`` them, ``"busy"`` with them, ``"asking back"``,
        ``"given up"``, or ``"blocked"`` by others on the route.
    person
        Identity of the one it is about; -1: nobody yet.
    seen
        When they were last there, s; -inf: never.
    since
        When the phase began, s; -inf: always.

    Raises
    ------
    ValueError
        If there is no such phase or identity, or a time is neither finite nor -inf.
    """

    phase: Phase = "waiting"
    person: int = -1
    seen: float = -np.inf
    since: float = -np.inf

    def __post_init__(self) -> None:
        checks.one_of("phase", self.phase, PHASES)
        object.__setattr__(self, "person", checks.whole("person", self.person, -1))
        for name in ("seen", "since"):
            if checks.number(name, getattr(self, name), finite=False) == np.inf:
                raise ValueError(f"{name} must be finite or -inf, got inf")


@dataclass(frozen=True, slots=True)
class Behaviours:
    """Behaviours by distances, times and speeds, all of them ours.

    Each of the behaviours `guide`, `follow` and `survey` takes the state, which is what it
    remembers, and the persons who are there now. It returns the state after that and the command to
    the robot, and raises ``ValueError`` if the persons are older than the state.

    Parameters
    ----------
    reach
        Who is further away is not there, m.
    close
        Who takes part in a survey comes as near as this, m.
    patience
        For so long somebody may be out of sight, s.
    memory
        A hypothesis that came up so long before the last sight of somebody, or later, may be
        theirs, s.
    resigned
        For so long the robot asks somebody back, s.
    gap
        Distance at which the robot follows, m.
    speed, turn_rate
        Largest speeds, m/s and rad/s.
    gain
        Speed for a metre, and turn rate for a radian, that it is off, 1/s.

    Raises
    ------
    ValueError
        If a number is not positive, or ``close`` is above ``reach``.
    """

    reach: float = 3.0
    close: float = 1.5
    patience: float = 1.0
    memory: float = 3.0
    resigned: float = 20.0
    gap: float = 1.0
    speed: float = 0.8
    turn_rate: float = 1.0
    gain: float = 1.0

    def __post_init__(self) -> None:
        for entry in fields(self):
            checks.positive(entry.name, getattr(self, entry.name))
        if self.close > self.reach:
            raise ValueError(f"close must not be above reach {self.reach}, got {self.close}")

    def guide(
        self, state: State, persons: Hypotheses, blocked: bool = False
    ) -> tuple[State, Command]:
        """Return what a guide does: go on while the visitor is there, else stop and ask back.

        It waits for a first visitor. When they are away for longer than the patience it stops and
        asks them to come back; when they are there again it goes on; after a time it gives up.
        While others stand on the route it stops, asks them once to clear the path, and thanks them
        when they have. Where the route leads is not its business: the speed is that along the
        route.

        Parameters
        ----------
        state, persons
            What it remembers, and who is there now.
        blocked
            Whether others stand on the route ahead; `blocks` says who does.
        """
        blocked = checks.flag("blocked", blocked)
        time, at = _sight(state, persons, self, "reach")
        touring = state.phase in ("busy", "blocked")
        there = at >= 0 or (touring and time - state.seen <= self.patience)
        if there and (blocked or (at < 0 and state.phase == "blocked")):
            say = "" if state.phase == "blocked" else "clear the path"
            since = state.since if state.phase == "blocked" else time
            after = replace(state, phase="blocked", since=since)
            return (_with(after, persons, at, "blocked") if at >= 0 else after), Command(say=say)
        go = Command(speed=self.speed)
        if at >= 0:
            said = {"asking back": "welcome back", "given up": "welcome back"}
            say = (said | {"blocked": "thank you"}).get(state.phase, "")
            return _with(state, persons, at, "busy"), replace(go, say=say)
        if touring:
            if there:
                return state, go
            return replace(state, phase="asking back", since=time), Command(say="come back")
        return _resigned(state, time, self, "given up"), STOP

    def follow(self, state: State, persons: Hypotheses) -> tuple[State, Command]:
        r"""Return what a follower does: turn to the person and keep off, or stop and ask back.

        .. math:: v = k (r - d), \qquad \omega = k \varphi

        within the largest speeds, v not negative, and 0 while the person is beside or behind. Where
        the person is comes from the hypotheses, whichever sensor confirms them, so that it may be a
        back.
        """
        time, at = _sight(state, persons, self, "reach")
        if at >= 0:
            r, phi = persons.mean[at].tolist()
            turn = float(np.clip(self.gain * phi, -self.turn_rate, self.turn_rate))
            speed = float(
                np.clip(self.gain * (r - self.gap) * (abs(phi) < np.pi / 2), 0, self.speed)
            )
            say = "welcome back" if state.phase in ("asking back", "given up") else ""
            return _with(state, persons, at, "busy"), Command(speed, turn, say)
        if state.phase == "busy" and time - state.seen > self.patience:
            return replace(state, phase="asking back", since=time), Command(say="come back")
        return _resigned(state, time, self, "given up"), STOP

    def survey(self, state: State, persons: Hypotheses, finished: bool) -> tuple[State, Command]:
        """Return what a poller does: invite, ask, notice who breaks off, call back, begin again.

        Somebody within reach is asked nearer; when they come close they are asked to take part. Who
        is not close for longer than the patience before the end has broken off and is asked back;
        when they are close again the survey goes on. After a time, and after the end, the robot
        waits for the next; the one who has just been there is not invited again.

        Parameters
        ----------
        state, persons
            What it remembers, and who is there now.
        finished
            Whether the last question has just been answered.
        """
        finished = checks.flag("finished", finished)
        time, at = _sight(state, persons, self, "close")
        if state.phase in ("waiting", "given up"):
            near = (persons.mean[:, 0] <= self.reach) & (persons.identity != state.person)
            if not near.any():
                return state, STOP
            at = int(np.where(near, persons.mean[:, 0], np.inf).argmin())
            return _with(state, persons, at, "inviting"), Command(say="come nearer")
        if state.phase == "inviting":
            if at >= 0:
                return _with(state, persons, at, "busy"), Command(say="take part")
            near = (persons.identity == state.person) & (persons.mean[:, 0] <= self.reach)
            if near.any():
                return replace(state, seen=time), STOP
            left = time - state.seen > self.patience
            return (State(since=time) if left else state), STOP
        if state.phase == "busy" and finished:
            return State("waiting", state.person, since=time), Command(say="thank you")
        if at >= 0:
            say = "welcome back" if state.phase == "asking back" else ""
            return _with(state, persons, at, "busy"), Command(say=say)
        if state.phase == "busy" and time - state.seen > self.patience:
            return replace(state, phase="asking back", since=time), Command(say="come back")
        return _resigned(state, time, self, "waiting"), STOP


def roles(
    hypotheses: Hypotheses,
    static: Bool[np.ndarray, " n"],
    state: State,
    person: float,
    known: float,
) -> Int[np.ndarray, " n"]:
    """Return what each hypothesis is taken for: the one it is about may stand still.

    Parameters
    ----------
    hypotheses
        All that there are, n.
    static : (n,)
        Which of them have stayed in one place for too long.
    state
        What the behaviour remembers.
    person
        Weight above which a hypothesis counts.
    known
        Standard deviation of the distance up to which there is a place to deal with, m.

    Returns
    -------
    (n,)
        `NOBODY`, `FURNITURE`, `MOVES` or `PARTNER` of each.

    Raises
    ------
    ValueError
        If there is not one truth value for each, the weight is not between 0 and 1, or the standard
        deviation not positive.
    """
    checks.instance("hypotheses", hypotheses, Hypotheses)
    checks.instance("state", state, State)
    still = np.asarray(static)
    if still.dtype != bool or still.shape != (len(hypotheses),):
        raise ValueError(
            f"static must be {len(hypotheses)} truth values, got {checks.shown(static)}"
        )
    person, known = checks.level("person", person), checks.positive("known", known)
    theirs = (hypotheses.identity == state.person) & (state.phase != "waiting")
    role = np.where(theirs, PARTNER, np.where(still, FURNITURE, MOVES))
    placed = np.sqrt(hypotheses.cov[:, 0, 0]) <= known
    return np.where(placed & (hypotheses.weight > person), role, NOBODY)


def blocks(
    points: Float[np.ndarray, "n 2"], route: Float[np.ndarray, "k 2"], width: float
) -> Bool[np.ndarray, " n"]:
    r"""Tell which points stand on a route: nearer than half a width to one of its straight parts.

    .. math:: \min_{0 \le s \le 1} |p - a - s (b - a)| < w / 2

    Parameters
    ----------
    points : (n, 2)
        Places, m.
    route : (k, 2)
        Ends of the parts in their order, two at least, in the same frame, m.
    width
        w: room that the robot takes with what it keeps free on both sides, m.

    Raises
    ------
    ValueError
        If shapes disagree, a number is not finite, the route has no part or the width is not
        positive.
    """
    points = checks.array("points", points, ("n", 2))
    route = checks.array("route", route, ("k", 2))
    if len(route) < 2:
        raise ValueError(f"route must have two ends at least, got {len(route)}")
    a, part = route[:-1], np.diff(route, axis=0)
    gap = points[:, None] - a  # (n, k - 1, 2)
    squared = np.maximum((part**2).sum(axis=-1), np.finfo(float).tiny)
    s = np.clip((gap * part).sum(axis=-1) / squared, 0.0, 1.0)
    apart = np.linalg.norm(gap - s[..., None] * part, axis=-1)
    return (apart < checks.positive("width", width) / 2).any(axis=1)


def _sight(state: State, persons: Hypotheses, rules: Behaviours, limit: str) -> tuple[float, int]:
    """Return the time, and the row of the one it is about; -1 if they are not there."""
    checks.instance("state", state, State)
    checks.instance("persons", persons, Hypotheses)
    checks.instance("rules", rules, Behaviours)
    time = persons.time
    if time < max(state.seen, state.since):
        raise ValueError(
            f"persons must not be older than the state, got {checks.shown(time)} s after "
            f"{checks.shown(max(state.seen, state.since))} s"
        )
    near = persons.mean[:, 0] <= getattr(rules, limit)
    distance = np.where(near, persons.mean[:, 0], np.inf)
    same = np.flatnonzero((persons.identity == state.person) & (distance < np.inf))
    if same.size:
        return time, int(same[0])
    if state.person in persons.identity:  # known, and too far away
        return time, -1
    distance = np.where(persons.born >= state.seen - rules.memory, distance, np.inf)
    return time, int(distance.argmin()) if (distance < np.inf).any() else -1


def _with(state: State, persons: Hypotheses, at: int, phase: Phase) -> State:
    """Return that somebody is there."""
    since = state.since if state.phase == phase else persons.time
    return State(phase, int(persons.identity[at]), persons.time, since)


def _resigned(state: State, time: float, rules: Behaviours, phase: Phase) -> State:
    """Return the state after another moment of asking somebody back."""
    if state.phase == "asking back" and time - state.since > rules.resigned:
        return replace(state, phase=phase, since=time)
    return state
