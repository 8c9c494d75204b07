"""Data association inside the filter: which landmark each observation without a name is of."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from robot_perception import checks
from robot_perception.gating import branch_and_bound, gate, nearest_neighbours
from robot_perception.observations import Observations
from robot_perception.slam.planar import kernels
from robot_perception.slam.planar.sensors import LandmarkSensor
from robot_perception.slam.planar.workspace import SINGULAR, Workspace

IGNORED, NEW = -1, -2  # in place of an identifier
KINDS = ("known", "gated", "joint")


@dataclass(frozen=True, slots=True)
class Association:
    """Rules of data association.

    Parameters
    ----------
    kind
        ``"known"``: each observation names its landmark; one without a name is ignored.
        ``"gated"``: an observation without a name is of the nearest landmark inside its gate; the
        nearest pair of all is taken first, and each landmark once. ``"joint"``: of the pairs inside
        their gates, the largest set that is jointly compatible is taken; see
        :func:`~robot_perception.gating.joint_compatibility`. In both, a landmark that another
        observation of the step names is not available.
    level
        Probability that a correct pair passes its gate, and that a correct set passes the joint
        one. If left out, 0.99; 1 for ``"known"``, which means no gate and is allowed there only.
    outer
        The same probability for the outer gate, 0.9999 if left out; ``"known"`` has no outer gate.
        An observation without a name that is outside the outer gates of all landmarks starts a new
        landmark. One inside an outer gate that is not matched is ignored.
    patience
        For ``"known"`` with a gate: after this many rejections of one landmark in a row, its next
        observation is used. Misread names rarely repeat, but an overconfident filter would reject
        correct observations for ever. ``None``: the gate never gives in.

    Attributes
    ----------
    limit, outer_limit
        Largest squared Mahalanobis distance inside the two gates: the quantile of χ² with two
        degrees of freedom at ``level`` and ``outer``; infinite where there is no gate.

    Raises
    ------
    ValueError
        If the kind is not one of these, 0 < level <= outer < 1 does not hold (for ``"known"``:
        0 < level <= 1, and no outer gate), or patience is below 1 or given without known names and
        a gate.
    """

    kind: Literal["known", "gated", "joint"] = "known"
    level: float | None = None
    outer: float | None = None
    patience: int | None = None
    limit: float = field(init=False)
    outer_limit: float = field(init=False)

    def __post_init__(self) -> None:
        checks.one_of("kind of association", self.kind, KINDS)
        for name, given in (("level", self.level), ("outer", self.outer)):
            if given is not None:
                checks.number(name, given, finite=False)
        known = self.kind == "known"
        level = (1.0 if known else 0.99) if self.level is None else self.level
        if known and self.outer is not None:
            raise ValueError(f"known names have no outer gate, got outer {self.outer}")
        outer = 0.9999 if self.outer is None else self.outer
        if not known and not 0 < level <= outer < 1:
            raise ValueError(f"need 0 < level <= outer < 1, got {level}, {outer}")
        if self.patience is not None:
            object.__setattr__(self, "patience", checks.whole("patience", self.patience, 1))
            if not known or level == 1:
                raise ValueError(
                    f"patience is for known names with a gate, got {self.kind!r} with level {level}"
                )
        object.__setattr__(self, "level", level)
        object.__setattr__(self, "outer", None if known else outer)
        object.__setattr__(self, "limit", np.inf if level == 1 else gate(level, 2))
        object.__setattr__(self, "outer_limit", np.inf if known else gate(outer, 2))


def associate(
    work: Workspace,
    observations: Observations,
    noises: np.ndarray,
    sensor: LandmarkSensor,
    anchors: Mapping[int, tuple[float, float]],
    association: Association,
) -> np.ndarray:
    r"""Return for each observation an identifier, ``IGNORED`` or ``NEW``; named ones keep theirs.

    A pair of observation i and landmark j is inside a gate if its squared Mahalanobis distance is
    at most the gate's limit:

    .. math:: d_{ij}^2 = (z_i - h_j)^\top S_{ij}^{-1} (z_i - h_j)

    Parameters
    ----------
    work
        Current belief of the filter.
    observations
        Observations of this step, of two numbers each.
    noises : (m, 2, 2) or (1, 2, 2)
        Their covariances, or one for all.
    sensor
        Sensor that made them.
    anchors : identifier -> (2,)
        Landmarks whose position is known, m; they can be matched, too.
    association
        Rules, ``"gated"`` or ``"joint"``.

    Raises
    ------
    ValueError
        If the covariance of an innovation is singular.
    """
    found = observations.ids.copy()
    unnamed = np.flatnonzero(found == -1)
    taken = set(found.tolist())
    names = [name for name in (*work.ids, *anchors) if name not in taken]
    if not unnamed.size:
        return found
    found[unnamed] = NEW
    if not names:
        return found
    slots, points = work.targets(names, anchors)
    expected, by_pose, by_point = sensor.expect(work.mean[:3], points)
    m, n = unnamed.size, len(names)
    innovations = sensor.residual(
        np.repeat(observations.values[unnamed], n, axis=0), np.tile(expected, (m, 1))
    ).reshape(m, n, 2)
    noises = noises if len(noises) == 1 else noises[unnamed]
    own = kernels.own_covs(work.cov, by_pose, by_point, slots)
    distances = kernels.pair_distances(innovations, own, noises)
    if np.isnan(distances).any():
        raise ValueError(SINGULAR)
    if association.kind == "gated":
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
