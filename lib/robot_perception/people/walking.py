"""Tell people from chairs by whether they have walked.

Two legs of a chair look like two of a person. What tells them apart is that people walk: a
hypothesis is a walker once it has been seen to go some distance, from sighting to sighting and as
fast as people do. A hypothesis that jumps from one thing to another, or that nobody has seen on the
way, has not walked.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.geometry import se2
from robot_perception.people.aggregation import Hypotheses


@dataclass(frozen=True, slots=True)
class WalkRules:
    """Rules by which a hypothesis has walked. The paper has none: they and their values are ours.

    Parameters
    ----------
    distance
        How far from where it was first seen, in one go, m.
    lasting
        How long it must have been seen until then, s: less may be a corner that comes into view.
    gap
        So long it may be out of sight on the way, s.
    speed
        Faster it is no person, m in a second.
    slack
        By so much a sighting may be off, m.
    forgotten
        After so long out of sight nobody knows where it is, s.

    Raises
    ------
    ValueError
        If a number is not positive.
    """

    distance: float = 0.8
    lasting: float = 1.5
    gap: float = 0.45
    speed: float = 2.0
    slack: float = 0.15
    forgotten: float = 3.0

    def __post_init__(self) -> None:
        for name in ("distance", "lasting", "gap", "speed", "slack", "forgotten"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name)))


@dataclass(frozen=True, eq=False, slots=True)
class Walks:
    """Distances that hypotheses have walked.

    Parameters
    ----------
    identity : (n,)
        Their numbers, which rise.
    since : (n,)
        When they were first seen since they were last out of sight, s.
    start : (n, 2)
        Where that was, in the world, m.
    last : (n, 2)
        Where they were last seen, in the world, m.
    walked : (n,)
        How far from the start they have been, the farthest of all times, m.
    seen : (n,)
        When they were last seen, s.

    Raises
    ------
    ValueError
        If shapes disagree, a number is not finite or the identities do not rise.
    """

    identity: Int[np.ndarray, " n"]
    since: Float[np.ndarray, " n"]
    start: Float[np.ndarray, "n 2"]
    last: Float[np.ndarray, "n 2"]
    walked: Float[np.ndarray, " n"]
    seen: Float[np.ndarray, " n"]

    def __post_init__(self) -> None:
        identity = checks.integers("identity", self.identity, ("n",), 0)
        if not (np.diff(identity) > 0).all():
            raise ValueError(f"identity must rise, got {identity.tolist()}")
        n, beside = identity.size, f"identity {identity.shape}"
        object.__setattr__(self, "identity", identity)
        flat, pairs = (n,), (n, 2)
        shapes = {"since": flat, "start": pairs, "last": pairs, "walked": flat, "seen": flat}
        for name, shape in shapes.items():
            object.__setattr__(self, name, checks.array(name, getattr(self, name), shape, beside))

    @classmethod
    def none(cls) -> "Walks":
        """Return that nothing has been seen."""
        none = np.zeros(0)
        pairs = np.zeros((0, 2))
        return cls(np.zeros(0, dtype=np.int64), none, pairs, pairs, none, none)

    def have_walked(self, rules: WalkRules) -> Bool[np.ndarray, " n"]:
        """Tell which have walked far enough."""
        return self.walked >= checks.instance("rules", rules, WalkRules).distance

    def are_known(self, time: float, rules: WalkRules) -> Bool[np.ndarray, " n"]:
        """Tell which have been seen so short a time ago that it is known where they are.

        Parameters
        ----------
        time
            Now, s.
        rules
            When they are forgotten.
        """
        forgotten = checks.instance("rules", rules, WalkRules).forgotten
        return checks.number("time", time) - self.seen <= forgotten


def watch_walks(
    walks: Walks, hypotheses: Hypotheses, pose: Float[np.ndarray, "3"], rules: WalkRules
) -> Walks:
    """Return how far hypotheses have walked after a reading, in their order.

    Parameters
    ----------
    walks
        Before.
    hypotheses
        What is there now; those that have gone are forgotten.
    pose : (3,)
        Pose of the robot in the world, m and rad.
    rules
        What walking is.

    Raises
    ------
    ValueError
        If the pose is not (3,) or not finite.
    """
    checks.instance("walks", walks, Walks)
    checks.instance("hypotheses", hypotheses, Hypotheses)
    checks.instance("rules", rules, WalkRules)
    points = se2.act(checks.array("pose", pose, (3,)), hypotheses.points)
    if not len(hypotheses):
        return Walks.none()
    start, last, walked = points.copy(), points.copy(), np.zeros(len(points))
    seen, since = hypotheses.last_seen.copy(), hypotheses.last_seen.copy()
    now = hypotheses.last_seen == hypotheses.time
    _, here, there = np.intersect1d(hypotheses.identity, walks.identity, return_indices=True)
    start[here], last[here] = walks.start[there], walks.last[there]
    walked[here], since[here], seen[here] = (
        values[there] for values in (walks.walked, walks.since, walks.seen)
    )
    elapsed = np.where(now, hypotheses.time - seen, 0)
    seen[now] = hypotheses.time
    way = np.hypot(*(points - last).T)
    broken = now & ((elapsed > rules.gap) | (way > rules.slack + rules.speed * elapsed))
    start[broken], since[broken] = points[broken], seen[broken]
    last[now] = points[now]
    far = np.where(seen - since >= rules.lasting, np.hypot(*(points - start).T), 0)
    walked[now] = np.maximum(walked, far)[now]
    return Walks(hypotheses.identity, since, start, last, walked, seen)
