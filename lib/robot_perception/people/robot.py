"""A robot among people: it tracks them, and guides, follows or asks them on what it believes.

``ServiceRobot("guide").step(state, detections, pose) -> (RobotState, PeopleInfo)`` takes in one
reading of one sensor, and

``ServiceRobot("guide").act(state, pose, route) -> (RobotState, Command)`` says what to do then.

Whoever runs it knows the sensors and the wheels: detections come from the rooms' detectors, poses
from the odometry or better. `velocity` turns a command into that of the wheels along a route.
"""

from dataclasses import dataclass, field, replace
from typing import Literal, final

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.fields import checked
from robot_perception.geometry import se2, wrap_angle
from robot_perception.people.aggregation import Hypotheses
from robot_perception.people.behaviours import (
    FURNITURE,
    MOVES,
    STOP,
    Behaviours,
    Command,
    State,
    blocks,
    roles,
)
from robot_perception.people.detections import Detections
from robot_perception.people.tracker import PeopleInfo, PeopleState, PeopleTracker

Task = Literal["guide", "follow", "survey"]
TASKS = ("guide", "follow", "survey")


@final
@dataclass(frozen=True, eq=False, slots=True)
class RobotState:
    """State of the robot.

    Parameters
    ----------
    people
        What its tracker knows, of n hypotheses.
    static : (n,)
        Which of them have stayed in one place for too long.
    behaviour
        What its behaviour remembers.
    pose : (3,)
        Where it takes itself to be now, in the world, m and rad.

    Raises
    ------
    ValueError
        If there is not one truth value for each hypothesis, or the pose is not (3,) or not finite.
    """

    people: PeopleState
    static: Bool[np.ndarray, " n"]
    behaviour: State
    pose: Float[np.ndarray, "3"]

    def __post_init__(self) -> None:
        checked(self)
        if len(self.static) != len(self.hypotheses):
            raise ValueError(
                f"static must be {len(self.hypotheses)}, one for each of people, got "
                f"{len(self.static)}"
            )

    @property
    def hypotheses(self) -> Hypotheses:
        """People about the robot, n."""
        return self.people.hypotheses

    @property
    def partner(self) -> Float[np.ndarray, "2"] | None:
        """Place in the world of the person it deals with, m; ``None`` if they are not there."""
        theirs = self.hypotheses.identity == self.behaviour.person
        return se2.act(self.pose, self.hypotheses.points[theirs])[0] if theirs.any() else None


@final
@dataclass(frozen=True, eq=False, slots=True)
class ServiceRobot:
    """A robot that guides a visitor, follows a person or holds a survey; all numbers are ours.

    Parameters
    ----------
    task
        ``"guide"``, ``"follow"`` or ``"survey"``.
    behaviours
        How it does that.
    tracker
        How it follows people; who counts as a person is said by the rules of its aggregation.
    known
        Standard deviation of the distance up to which there is a place to deal with, m.
    width
        Room that a guide needs on its route, m.
    ahead
        So many points of the route ahead a guide wants free, one at least.

    Raises
    ------
    TypeError
        If a part is of another type.
    ValueError
        If there is no such task, or a number is not positive.

    References
    ----------
    Schaffernicht, Martin, Scheidig and Gross (see `Detections`), sections 4.1 and 4.2.
    """

    task: Task
    behaviours: Behaviours = field(default_factory=Behaviours)
    tracker: PeopleTracker = field(default_factory=PeopleTracker)
    known: float = 1.2
    width: float = 1.0
    ahead: int = 15

    def __post_init__(self) -> None:
        checks.one_of("task", self.task, TASKS)
        checks.instance("behaviours", self.behaviours, Behaviours)
        checks.instance("tracker", self.tracker, PeopleTracker)
        object.__setattr__(self, "known", checks.positive("known", self.known))
        object.__setattr__(self, "width", checks.positive("width", self.width))
        object.__setattr__(self, "ahead", checks.whole("ahead", self.ahead, 1, 10**6))

    def start(self, pose: Float[np.ndarray, "3"]) -> RobotState:
        """Return what a robot at a pose (3,), m and rad, knows that has not yet looked."""
        return RobotState(self.tracker.start(pose), np.zeros(0, dtype=bool), State(), pose)

    def step(
        self, state: RobotState, detections: Detections, pose: Float[np.ndarray, "3"]
    ) -> tuple[RobotState, PeopleInfo]:
        """Return what is known after one reading of one sensor.

        Parameters
        ----------
        state
            Before.
        detections
            The reading.
        pose : (3,)
            Where the robot takes itself to be at it, in the world, m and rad.

        Raises
        ------
        ValueError
            As `PeopleTracker.step`.
        """
        checks.instance("state", state, RobotState)
        people, info = self.tracker.step(state.people, detections, pose)
        return RobotState(people, info.static, state.behaviour, people.pose), info

    def act(
        self,
        state: RobotState,
        pose: Float[np.ndarray, "3"],
        route: Float[np.ndarray, "k 2"] | None = None,
        *,
        finished: bool = False,
    ) -> tuple[RobotState, Command]:
        """Return what to do by what is known, and what is remembered of it.

        It deals with those who are persons, have a place and move, and with whom it deals already,
        who may stand still. Before the first reading it stands.

        Parameters
        ----------
        state
            After the last reading.
        pose : (3,)
            Where the robot takes itself to be now, in the world, m and rad.
        route : (k, 2)
            Of a guide that stops for others on it: points in the world, m. Without it nobody is in
            the way.
        finished
            Whether the last question of a survey has just been answered.

        Raises
        ------
        ValueError
            If pose or route is of another shape, or a number is not finite.
        """
        checks.instance("state", state, RobotState)
        state = replace(state, pose=checks.array("pose", pose, (3,)))
        finished = checks.flag("finished", finished)
        persons = state.hypotheses.select(self.roles(state) >= MOVES)
        blocked = route is not None and self.is_blocked(state, route)
        if persons.time == -np.inf:
            return state, STOP
        before = state.behaviour
        if self.task == "guide":
            after, command = self.behaviours.guide(before, persons, blocked)
        elif self.task == "follow":
            after, command = self.behaviours.follow(before, persons)
        else:
            after, command = self.behaviours.survey(before, persons, finished)
        return replace(state, behaviour=after), command

    def roles(self, state: RobotState) -> Int[np.ndarray, " n"]:
        """Return what each hypothesis (n,) is taken for, as `behaviours.roles`."""
        checks.instance("state", state, RobotState)
        least = self.tracker.aggregation.person
        return roles(state.hypotheses, state.static, state.behaviour, least, self.known)

    def is_blocked(self, state: RobotState, route: Float[np.ndarray, "k 2"]) -> bool:
        """Tell whether others stand on the next points of a route (k, 2), m.

        They may stand still: who stands and talks is furniture otherwise.

        Raises
        ------
        ValueError
            If the route is not (k, 2), or a number is not finite.
        """
        next_ = upcoming(route, checks.instance("state", state, RobotState).pose)[: self.ahead]
        if len(next_) < 2:
            return False
        known = state.hypotheses
        others = (self.roles(state) >= FURNITURE) & (known.identity != state.behaviour.person)
        return bool(blocks(se2.act(state.pose, known.points[others]), next_, self.width).any())


def upcoming(
    route: Float[np.ndarray, "k 2"], pose: Float[np.ndarray, "3"]
) -> Float[np.ndarray, "n 2"]:
    """Return the points of a route from the one on that is nearest to a pose.

    Parameters
    ----------
    route : (k, 2)
        Points in the world, m.
    pose : (3,)
        Of the robot in the world, m and rad.

    Raises
    ------
    ValueError
        If a shape is another one, or a number is not finite.
    """
    route, pose = checks.array("route", route, ("k", 2)), checks.array("pose", pose, (3,))
    return route[int(np.hypot(*(route - pose[:2]).T).argmin()) :] if len(route) else route


def velocity(
    command: Command,
    pose: Float[np.ndarray, "3"],
    route: Float[np.ndarray, "k 2"],
    *,
    ahead: int = 6,
    slow: float = 0.6,
    gain: float = 1.5,
    turn_rate: float = 1.0,
) -> tuple[float, float]:
    r"""Return how a robot moves that is told a speed along a route: towards a point ahead on it.

    .. math:: v = v_c \max(0, 1 - |\delta| / \delta_0), \qquad \omega = k \delta

    where :math:`\delta` is the direction of that point from the robot's heading, and :math:`\omega`
    at most the largest turn rate. Without a route, or told to stand, it moves as commanded.

    Parameters
    ----------
    command
        What the robot is to do.
    pose : (3,)
        Where it takes itself to be, in the world, m and rad.
    route : (k, 2)
        Points in the world, m.
    ahead
        The point is so many after the one that is nearest, or the last.
    slow
        δ₀: so far off it only turns, rad.
    gain
        k, 1/s.
    turn_rate
        Largest, rad/s.

    Returns
    -------
    tuple of float
        Forward, m/s, and counter-clockwise, rad/s.

    Raises
    ------
    ValueError
        If a shape is another one, or a number is not finite or not positive.
    """
    checks.instance("command", command, Command)
    way, ahead = upcoming(route, pose), checks.whole("ahead", ahead, 0, 10**6)
    slow, gain = checks.positive("slow", slow), checks.positive("gain", gain)
    turn_rate = checks.positive("turn_rate", turn_rate)
    if not len(way) or command.speed == 0:
        return command.speed, command.turn_rate
    x, y, heading = np.asarray(pose, dtype=float)
    gap = way[min(ahead, len(way) - 1)] - [x, y]
    off = float(wrap_angle(np.arctan2(gap[1], gap[0]) - heading))
    speed = command.speed * max(0.0, 1 - abs(off) / slow)
    return speed, float(np.clip(gain * off, -turn_rate, turn_rate))
