"""Scores of tracked people: found people, false hypotheses, and the field's measures of both."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import linear_sum_assignment

from robot_perception import checks


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """People and hypotheses at one time.

    Parameters
    ----------
    people : (p, 2)
        True positions, m.
    people_ids : (p,)
        Who they are; no two the same.
    hypotheses : (h, 2)
        Positions of the hypotheses that count as persons, m, in the same frame.
    hypotheses_ids : (h,)
        Their identities; no two the same.
    apart : (p, h)
        How far each hypothesis is from each person. Left out: the distance of the two places, m;
        another measure can say that a hypothesis is known in direction alone, for instance.

    Raises
    ------
    ValueError
        If shapes disagree, a number is not finite, a distance negative or a name double.
    """

    people: Float[np.ndarray, "p 2"]
    people_ids: Int[np.ndarray, " p"]
    hypotheses: Float[np.ndarray, "h 2"]
    hypotheses_ids: Int[np.ndarray, " h"]
    apart: Float[np.ndarray, "p h"] | None = None

    def __post_init__(self) -> None:
        for name in ("people", "hypotheses"):
            points = checks.array(name, getattr(self, name), ("n", 2))
            label, shape = f"{name}_ids", f"{name} {points.shape}"
            ids = checks.integers(label, getattr(self, label), (len(points),), beside=shape)
            if np.unique(ids).size < ids.size:
                raise ValueError(f"{label} must differ, got {ids.tolist()}")
            object.__setattr__(self, name, points)
            object.__setattr__(self, label, ids)
        given = _distances(self.people, self.hypotheses) if self.apart is None else self.apart
        apart = checks.array("apart", given, (len(self.people), len(self.hypotheses)))
        if (apart < 0).any():
            raise ValueError(f"apart must not be negative, got {apart.min():g}")
        object.__setattr__(self, "apart", apart)


@dataclass(frozen=True, slots=True)
class Score:
    """Sums over frames.

    Parameters
    ----------
    people
        How often somebody was there.
    hypotheses
        How often a hypothesis was.
    matched
        How often a hypothesis was that of a person.
    switches
        How often a person had another hypothesis than the last time one was theirs.
    distance
        Sum of the distances of the matched pairs, m unless frames say another measure.
    """

    people: int
    hypotheses: int
    matched: int
    switches: int
    distance: float

    @property
    def tracked(self) -> float:
        """Share of the people who have a hypothesis; 1 if nobody was there."""
        return self.matched / self.people if self.people else 1.0

    @property
    def false(self) -> float:
        """Share of the hypotheses that are false; 0 if there was none."""
        return 1 - self.matched / self.hypotheses if self.hypotheses else 0.0

    @property
    def mota(self) -> float:
        r"""Accuracy :math:`1 - (misses + false + switches) / people`; 1 if all is empty."""
        errors = self.people + self.hypotheses - 2 * self.matched + self.switches
        return 1 - errors / max(self.people, 1)

    @property
    def motp(self) -> float:
        """Mean distance of the matched pairs, m; 0 if there is none."""
        return self.distance / max(self.matched, 1)


def score(frames: Iterable[Frame], reach: float) -> Score:
    """Compare hypotheses with people, frame by frame.

    In each frame as many pairs within reach are matched as can be, each person and each hypothesis
    at most once. Among these matchings the one is taken that keeps most pairs of the frame before,
    and among those the one of the least total distance.

    Parameters
    ----------
    frames
        In the order of time.
    reach
        Largest distance of a hypothesis from its person, in the measure of the frames.

    Raises
    ------
    ValueError
        If the reach is not positive.

    References
    ----------
    Bernardin and Stiefelhagen, "Evaluating multiple object tracking performance: the CLEAR MOT
    metrics", EURASIP Journal on Image and Video Processing, 2008, section 2.1. There the pairs of
    before are kept even where that costs another match.
    """
    reach = checks.positive("reach", reach)
    last: dict[int, int] = {}  # whose hypothesis was which, whenever it was
    before: set[tuple[int, int]] = set()  # the pairs of the frame before
    people = hypotheses = switches = matched = 0
    distance = 0.0
    for frame in checks.instances("frames", frames, Frame):
        i, j = _matched(frame, reach, before)
        before = set(
            zip(frame.people_ids[i].tolist(), frame.hypotheses_ids[j].tolist(), strict=True)
        )
        switches += sum(last.get(person, name) != name for person, name in before)
        last |= dict(before)
        distance += float(frame.apart[i, j].sum())
        people, hypotheses = people + len(frame.people), hypotheses + len(frame.hypotheses)
        matched += len(before)
    return Score(people, hypotheses, matched, switches, distance)


@dataclass(frozen=True, slots=True)
class Gospa:
    """The GOSPA metric and its parts.

    Parameters
    ----------
    total
        The metric, m.
    localisation
        Root mean square sum part of the pairs: root of the sum of squared distances, m.
    missed
        People without a hypothesis.
    false
        False hypotheses.
    """

    total: float
    localisation: float
    missed: int
    false: int


def gospa(
    people: Float[np.ndarray, "p 2"], hypotheses: Float[np.ndarray, "h 2"], cutoff: float
) -> Gospa:
    r"""Return the distance of two sets of points that counts errors of place and of number.

    .. math::
        d = \min_{\gamma} \sqrt{\sum_{(i, j) \in \gamma} \lVert x_i - y_j \rVert^2
            + \tfrac{c^2}{2} \left( p + h - 2 |\gamma| \right)}

    over all assignments γ, each point at most once. It is a metric. A pair further apart than the
    cutoff c is never worth more than a miss and a false hypothesis.

    Parameters
    ----------
    people : (p, 2)
        True positions, m.
    hypotheses : (h, 2)
        Positions of the hypotheses, m.
    cutoff
        c, m.

    Raises
    ------
    ValueError
        If a shape is wrong, a number is not finite or beyond 1e100, or the cutoff not positive.

    References
    ----------
    Rahmathullah, García-Fernández and Svensson, "Generalized optimal sub-pattern assignment
    metric", FUSION 2017, with p = 2 and α = 2.
    """
    people = checks.array("people", people, ("p", 2))
    hypotheses = checks.array("hypotheses", hypotheses, ("h", 2))
    cutoff = checks.positive("cutoff", cutoff)
    apart = _distances(people, hypotheses)
    i, j = linear_sum_assignment(np.minimum(apart, cutoff) ** 2)
    near = apart[i, j] < cutoff
    squared, count = float((apart[i, j][near] ** 2).sum()), int(near.sum())
    missed, false = len(people) - count, len(hypotheses) - count
    total = np.sqrt(squared + cutoff**2 / 2 * (missed + false))
    return Gospa(float(total), float(np.sqrt(squared)), missed, false)


def _distances(one: np.ndarray, other: np.ndarray) -> Float[np.ndarray, "p h"]:
    return np.linalg.norm(one[:, None] - other, axis=-1)


def _matched(
    frame: Frame, reach: float, before: set[tuple[int, int]]
) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " k"]]:
    """Return rows and columns of the pairs within reach, by one assignment.

    A pair that is kept is worth more than all distances together, one more pair more than all that
    are kept.
    """
    near = frame.apart <= reach
    names = frame.hypotheses_ids.tolist()
    pairs = ([(person, name) in before for name in names] for person in frame.people_ids.tolist())
    held = np.array(list(pairs), dtype=float).reshape(near.shape)
    more = min(near.shape) + 1
    cost = frame.apart / reach - more * held - more * (more + 2)
    i, j = linear_sum_assignment(np.where(near, cost, 0.0))
    return i[near[i, j]], j[near[i, j]]
