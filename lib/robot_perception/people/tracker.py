"""People in the world: readings of any sensors, one after the other, of a robot that may drive.

The aggregation knows people about the robot; here its motion comes in, and who never moves is told:

``PeopleTracker(aggregation, static).step(state, detections, pose) -> (PeopleState, PeopleInfo)``

A robot needs no more: it calls ``step`` for each reading, with the pose that it takes itself to
have.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks
from robot_perception.geometry import se2
from robot_perception.people.aggregation import (
    AggregationInfo,
    AggregationRules,
    Aggregator,
    Hypotheses,
)
from robot_perception.people.detections import Detections
from robot_perception.people.trajectories import StaticRules, Stays, watch


@dataclass(frozen=True, eq=False, slots=True)
class PeopleState:
    """State of the tracker.

    Parameters
    ----------
    hypotheses
        People about the robot.
    stays
        Where they have stayed, in the world.
    pose : (3,)
        Where the robot took itself to be at the last reading, m and rad.

    Raises
    ------
    ValueError
        If the pose is not (3,) or not finite.
    """

    hypotheses: Hypotheses
    stays: Stays
    pose: Float[np.ndarray, "3"]

    def __post_init__(self) -> None:
        checks.instance("hypotheses", self.hypotheses, Hypotheses)
        checks.instance("stays", self.stays, Stays)
        object.__setattr__(self, "pose", checks.array("pose", self.pose, (3,)))


@dataclass(frozen=True, eq=False, slots=True)
class PeopleInfo:
    """Diagnostics of one reading.

    Parameters
    ----------
    static : (n,)
        Which of the hypotheses have stayed in one place for too long.
    merged
        What the aggregation did.
    """

    static: Bool[np.ndarray, " n"]
    merged: AggregationInfo


@dataclass(frozen=True, slots=True)
class PeopleTracker:
    """Follows people in the world, and tells who has stayed in one place for too long.

    Parameters
    ----------
    aggregation
        How readings are joined.
    static
        Who stays too long.
    """

    aggregation: AggregationRules = field(default_factory=AggregationRules)
    static: StaticRules = field(default_factory=StaticRules)

    def __post_init__(self) -> None:
        checks.instance("aggregation", self.aggregation, AggregationRules)
        checks.instance("static", self.static, StaticRules)

    def start(self, pose: Float[np.ndarray, "3"]) -> PeopleState:
        """Return what a robot at a pose (3,), m and rad, knows that has not yet looked."""
        return PeopleState(Hypotheses.none(), Stays.none(), pose)

    def step(
        self, state: PeopleState, detections: Detections, pose: Float[np.ndarray, "3"]
    ) -> tuple[PeopleState, PeopleInfo]:
        r"""Return what is known after one reading of one sensor.

        Hypotheses are moved by the way that the robot has gone since the last reading,
        :math:`u = x_{k-1}^{-1} x_k`, aggregated with the reading, and watched from the new pose.

        Parameters
        ----------
        state
            Before.
        detections
            The reading.
        pose : (3,)
            Where the robot takes itself to be at it, in the world, m and rad: by its wheels, or
            better. An error that grows slowly does no harm, as only the way between two readings
            counts.

        Raises
        ------
        ValueError
            As `Aggregator.step`, or if the pose is not (3,) or not finite.

        References
        ----------
        Schaffernicht, Martin, Scheidig and Gross (see `Detections`), sections 3.2 and 4.1.
        """
        checks.instance("state", state, PeopleState)
        pose = checks.array("pose", pose, (3,))
        motion = se2.between(state.pose, pose)
        found, merged = Aggregator(self.aggregation).step(state.hypotheses, detections, motion)
        stays, static = watch(state.stays, found, pose, self.static)
        return PeopleState(found, stays, pose), PeopleInfo(static, merged)
