"""Which landmark is it? Association inside the filter."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from robot_perception.gating import branch_and_bound, gate, nearest_neighbours
from robot_perception.slam.planar import kernels
from robot_perception.slam.planar.sensors import LandmarkSensor, Scan
from robot_perception.slam.planar.workspace import Workspace

IGNORED, NEW = -1, -2  # in place of an identifier


@dataclass(frozen=True, slots=True)
class Known:
    """The scan says which landmark it saw; what it does not say is ignored.

    Parameters
    ----------
    level
        Probability that a right observation passes the gate; 1 means that there is no gate.
    """

    level: float = 1.0
    limit: float = field(init=False)

    def __post_init__(self) -> None:
        limit = np.inf if self.level == 1 else gate(self.level, 2)
        object.__setattr__(self, "limit", limit)


@dataclass(frozen=True, slots=True)
class Gated:
    """Each observation belongs to the nearest landmark inside a gate.

    Parameters
    ----------
    level
        Probability that a right pair passes the inner gate.
    outer
        The same for the outer gate. An observation outside the outer gates of all landmarks is of a
        new one; one between the gates is ignored.

    Raises
    ------
    ValueError
        Unless 0 < level <= outer < 1.
    """

    level: float = 0.99
    outer: float = 0.9999
    limit: float = field(init=False)
    outer_limit: float = field(init=False)

    def __post_init__(self) -> None:
        _set_gates(self)


@dataclass(frozen=True, slots=True)
class Joint:
    """The largest set of pairs that fit together; see :func:`gating.joint_compatibility`.

    Parameters
    ----------
    level
        Probability that a right pair passes its own gate, and a right set the joint one.
    outer
        As in :class:`Gated`.

    Raises
    ------
    ValueError
        Unless 0 < level <= outer < 1.
    """

    level: float = 0.99
    outer: float = 0.9999
    limit: float = field(init=False)
    outer_limit: float = field(init=False)

    def __post_init__(self) -> None:
        _set_gates(self)


def _set_gates(gates: Gated | Joint) -> None:
    if not 0 < gates.level <= gates.outer < 1:
        raise ValueError(f"need 0 < level <= outer < 1, got {gates.level}, {gates.outer}")
    object.__setattr__(gates, "limit", gate(gates.level, 2))
    object.__setattr__(gates, "outer_limit", gate(gates.outer, 2))


Association = Known | Gated | Joint


def associate(
    work: Workspace,
    scan: Scan,
    noises: np.ndarray,
    sensor: LandmarkSensor,
    anchors: Mapping[int, tuple[float, float]],
    association: Gated | Joint,
) -> np.ndarray:
    """Return for each observation an identifier, ``IGNORED`` or ``NEW``; named ones keep theirs."""
    found = scan.ids.copy()
    open_ = np.flatnonzero(found == -1)
    names = [n for n in (*work.ids, *anchors) if n not in set(found.tolist())]
    if not open_.size:
        return found
    found[open_] = NEW
    if not names:
        return found
    slots, points = work.targets(names, anchors)
    expected, by_pose, by_point = sensor.look(work.mean[:3], points)
    cross = kernels.cross_rows(work.cov, by_pose, by_point, slots)
    values, noises = scan.values[open_], noises[open_ if len(noises) > 1 else slice(1)]
    innovations = np.stack(
        [sensor.residual(v[None].repeat(len(names), 0), expected) for v in values]
    )
    distances = kernels.pair_distances(innovations, cross, by_pose, by_point, slots, noises)
    if isinstance(association, Joint):
        assignment = _jointly(
            innovations, distances, cross, by_pose, by_point, slots, noises, association
        )
    else:
        assignment = nearest_neighbours(distances, association.limit)
    between = distances.min(axis=1) <= association.outer_limit
    found[open_[between]] = IGNORED
    matched = assignment >= 0
    found[open_[matched]] = np.array(names)[assignment[matched]]
    return found


def _jointly(
    innovations: np.ndarray,
    distances: np.ndarray,
    cross: np.ndarray,
    by_pose: np.ndarray,
    by_point: np.ndarray,
    slots: np.ndarray,
    noises: np.ndarray,
    association: Joint,
) -> np.ndarray:
    assignment = np.full(len(distances), -1)
    pairs = np.argwhere(distances <= association.limit)
    if not pairs.size:
        return assignment
    i, j = pairs.T
    rows = (2 * j[:, None] + np.arange(2)).ravel()
    S = kernels.innovation_cov(
        cross[rows], by_pose[j], by_point[j], slots[j], noises[i if len(noises) > 1 else [0]]
    )
    limits = np.array([gate(association.level, 2 * (k + 1)) for k in range(len(pairs))])
    chosen = branch_and_bound(pairs, innovations[i, j], S, limits)
    assignment[i[chosen]] = j[chosen]
    return assignment
