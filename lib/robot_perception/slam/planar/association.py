"""Which landmark is it? Association inside the filter."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from robot_perception.gating import branch_and_bound, gate, nearest_neighbours
from robot_perception.slam.planar import kernels
from robot_perception.slam.planar.sensors import LandmarkSensor, Scan
from robot_perception.slam.planar.workspace import SINGULAR, Workspace

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
    """Return for each observation an identifier, ``IGNORED`` or ``NEW``; named ones keep theirs.

    Raises
    ------
    ValueError
        If the covariance of an innovation is singular.
    """
    found = scan.ids.copy()
    unnamed = np.flatnonzero(found == -1)
    taken = set(found.tolist())
    names = [name for name in (*work.ids, *anchors) if name not in taken]
    if not unnamed.size:
        return found
    found[unnamed] = NEW
    if not names:
        return found
    slots, points = work.targets(names, anchors)
    expected, by_pose, by_point = sensor.look(work.mean[:3], points)
    m, n = unnamed.size, len(names)
    innovations = sensor.residual(
        np.repeat(scan.values[unnamed], n, axis=0), np.tile(expected, (m, 1))
    ).reshape(m, n, 2)
    noises = noises if len(noises) == 1 else noises[unnamed]
    own = kernels.own_covs(work.cov, by_pose, by_point, slots)
    distances = kernels.pair_distances(innovations, own, noises)
    if np.isnan(distances).any():
        raise ValueError(SINGULAR)
    if isinstance(association, Gated):
        assignment = nearest_neighbours(distances, association.limit)
    else:
        i, j = pairs = np.nonzero(distances <= association.limit)
        S = work.innovation_cov(
            by_pose[j], by_point[j], slots[j], noises if len(noises) == 1 else noises[i]
        )
        chosen = _largest(np.stack(pairs, axis=-1), innovations[i, j], S, association.level)
        assignment = np.full(m, -1)
        assignment[i[chosen]] = j[chosen]
    found[unnamed[distances.min(axis=1) <= association.outer_limit]] = IGNORED
    matched = assignment >= 0
    found[unnamed[matched]] = np.array(names)[assignment[matched]]
    return found


def _largest(pairs: np.ndarray, innovations: np.ndarray, S: np.ndarray, level: float) -> np.ndarray:
    """Return the rows of the largest jointly compatible set of pairs."""
    if not len(pairs):
        return np.empty(0, dtype=np.int64)
    limits = np.array([gate(level, 2 * (k + 1)) for k in range(len(pairs))])
    return branch_and_bound(pairs, innovations, S, limits)
