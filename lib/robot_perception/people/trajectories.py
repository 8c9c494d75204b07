"""The ways of hypotheses in the world, and those that stay where they are."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.geometry import se2
from robot_perception.people.aggregation import Hypotheses


@dataclass(frozen=True, eq=False, slots=True)
class Trajectory:
    """Trajectory of one hypothesis.

    Parameters
    ----------
    identity
        Its number.
    times : (k,)
        s.
    points : (k, 2)
        Positions in the world at these times, m.
    """

    identity: int
    times: Float[np.ndarray, " k"]
    points: Float[np.ndarray, "k 2"]


def trajectories(
    history: Sequence[Hypotheses], poses: Float[np.ndarray, "k 3"]
) -> tuple[Trajectory, ...]:
    """Return the way of every hypothesis, by identity.

    Parameters
    ----------
    history
        The hypotheses at k times.
    poses : (k, 3)
        Poses of the robot in the world at these times, m and rad.

    Raises
    ------
    ValueError
        If there is not one pose for each, or a number is not finite.

    References
    ----------
    Schaffernicht, Martin, Scheidig and Gross, section 4.1.
    """
    history = checks.instances("history", history, Hypotheses)
    poses = checks.array("poses", poses, (len(history), 3), f"{len(history)} times of history")
    if not history:
        return ()
    times = np.repeat([h.time for h in history], [len(h) for h in history])
    points = np.concatenate([_in_world(*pair) for pair in zip(history, poses, strict=True)])
    identities = np.concatenate([h.identity for h in history])
    return tuple(
        Trajectory(int(one), times[identities == one], points[identities == one])
        for one in np.unique(identities)
    )


@dataclass(frozen=True, slots=True)
class StaticRules:
    """Rules by which a hypothesis counts as furniture. The paper gives no values: these are ours.

    Parameters
    ----------
    spread
        A hypothesis stays where it is while it is no further than this from there, m.
    longest
        For so long a person may stay, s.

    Raises
    ------
    ValueError
        If a number is not positive.
    """

    spread: float = 0.4
    longest: float = 20.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "spread", checks.positive("spread", self.spread))
        object.__setattr__(self, "longest", checks.positive("longest", self.longest))


@dataclass(frozen=True, eq=False, slots=True)
class Stays:
    """Places at which hypotheses are staying, and since when.

    Parameters
    ----------
    identity : (n,)
        Their numbers, which rise.
    place : (n, 2)
        Where the stay began, in the world, m.
    since : (n,)
        When it began, s.

    Raises
    ------
    ValueError
        If shapes disagree, a number is not finite or the identities do not rise.
    """

    identity: Int[np.ndarray, " n"]
    place: Float[np.ndarray, "n 2"]
    since: Float[np.ndarray, " n"]

    def __post_init__(self) -> None:
        identity = checks.integers("identity", self.identity, ("n",), 0)
        if not (np.diff(identity) > 0).all():
            raise ValueError(f"identity must rise, got {identity.tolist()}")
        n, beside = identity.size, f"identity {identity.shape}"
        object.__setattr__(self, "identity", identity)
        object.__setattr__(self, "place", checks.array("place", self.place, (n, 2), beside))
        object.__setattr__(self, "since", checks.array("since", self.since, (n,), beside))

    @classmethod
    def none(cls) -> "Stays":
        """Return that nothing has been seen."""
        return cls(np.zeros(0, dtype=np.int64), np.zeros((0, 2)), np.zeros(0))


def watch(
    stays: Stays, hypotheses: Hypotheses, pose: Float[np.ndarray, "3"], rules: StaticRules
) -> tuple[Stays, Bool[np.ndarray, " n"]]:
    """Return where hypotheses are staying now, and which of them have stayed too long.

    A stay ends when its hypothesis is further from its place than the spread; then another begins.

    Parameters
    ----------
    stays
        Before.
    hypotheses
        What is there now; those that have gone are forgotten.
    pose : (3,)
        Pose of the robot in the world, m and rad.
    rules
        The rules.

    Returns
    -------
    Stays
        In the order of the hypotheses.
    (n,)
        Whether each is static.

    Raises
    ------
    ValueError
        If the pose is not (3,) or not finite.

    References
    ----------
    Schaffernicht, Martin, Scheidig and Gross, section 4.1: long immovable hypotheses are discarded.
    """
    checks.instance("stays", stays, Stays)
    checks.instance("hypotheses", hypotheses, Hypotheses)
    checks.instance("rules", rules, StaticRules)
    points = _in_world(hypotheses, checks.array("pose", pose, (3,)))
    place, since = points.copy(), np.full(len(hypotheses), hypotheses.time)
    _, here, there = np.intersect1d(hypotheses.identity, stays.identity, return_indices=True)
    still = np.linalg.norm(points[here] - stays.place[there], axis=-1) <= rules.spread
    place[here[still]], since[here[still]] = stays.place[there[still]], stays.since[there[still]]
    if not len(hypotheses):
        return Stays.none(), np.zeros(0, dtype=bool)
    return Stays(hypotheses.identity, place, since), hypotheses.time - since > rules.longest


def _in_world(hypotheses: Hypotheses, pose: np.ndarray) -> Float[np.ndarray, "n 2"]:
    return se2.act(pose, hypotheses.points)
