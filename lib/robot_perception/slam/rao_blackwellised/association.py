"""Data association, one for all particles or one for each.

A pair of an observation and a landmark is possible where its squared Mahalanobis distance in space
passes a gate and what it costs, the distance of descriptors, does not exceed a limit. Of the
possible pairs the cheapest is taken first, then the cheapest of what is left; each landmark is
given once. Without costs the distance in space is the cost.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.gating import gate
from robot_perception.observations import Observations
from robot_perception.slam.rao_blackwellised import kernels
from robot_perception.slam.rao_blackwellised.belief import ParticleMaps, gathered
from robot_perception.slam.rao_blackwellised.filtering import SINGULAR, checked_seen

LARGEST = float(np.finfo(float).max)


def associate_shared(
    maps: ParticleMaps,
    observations: Observations,
    mount: Float[np.ndarray, "4 4"],
    *,
    costs: Float[np.ndarray, "m N"] | None = None,
    limit: float = np.inf,
    level: float = 0.99,
    by: Literal["best", "mean"] = "mean",
) -> Int[np.ndarray, "m"]:
    r"""Return which landmark each observation is of, for all particles together.

    With ``by="best"`` the distances are those of the particle with the largest weight. With
    ``by="mean"`` they are those of the mixture of all, taken for one normal distribution:

    .. math::
        \bar\nu = \sum_m \omega^{[m]} \nu^{[m]}, \qquad
        \bar S = \sum_m \omega^{[m]} \left(S^{[m]} + (\nu^{[m]} - \bar\nu)
        (\nu^{[m]} - \bar\nu)^\top\right), \qquad d^2 = \bar\nu^\top \bar S^{-1} \bar\nu

    so that the gate widens with what the particles do not know of the pose.

    Parameters
    ----------
    maps
        The maps.
    observations
        Points in the frame of the camera with covariances. One with a name keeps it, and its
        landmark is not given to another.
    mount : (4, 4)
        T_robot_camera.
    costs : (m, N), optional
        Distances of descriptors, of each observation to each landmark in the order of the map.
    limit
        Largest cost of a pair.
    level
        Probability that a right pair passes the gate.
    by
        ``"best"`` or ``"mean"``.

    Returns
    -------
    (m,)
        Identifiers; -1 where no pair is possible, which is when the paper makes a new landmark.

    Raises
    ------
    ValueError
        If the costs are not (m, N), negative or NaN, the limit is not a number, the level not
        between 0 and 1, or the covariance of an innovation is singular.

    References
    ----------
    Gil et al., section 4.
    """
    possible = _Possible.of(maps, observations, mount, costs, limit, level)
    checks.one_of("by", by, ("best", "mean"))
    points, rows, known, pairs = possible.points, possible.rows, possible.known, possible.pairs
    if by == "best":
        only = slice(maps.best, maps.best + 1)
        points, rows, known = points[:, only], rows[:, only], known[:, only]
        distances = kernels.squared_distances(points, rows, known, *pairs, possible.gate)
    else:
        weights = maps.particles.weights
        distances = kernels.mixture_distances(points, rows, known, weights, *pairs, possible.gate)
    return possible.names(maps, observations, distances)[0]


def associate_each(
    maps: ParticleMaps,
    observations: Observations,
    mount: Float[np.ndarray, "4 4"],
    held: Int[np.ndarray, "M m"] | None = None,
    *,
    costs: Float[np.ndarray, "m N"] | None = None,
    limit: float = np.inf,
    level: float = 0.99,
) -> Int[np.ndarray, "M m"]:
    """Return for each particle which landmark of its own map each observation is of.

    Parameters
    ----------
    maps, observations, mount, costs, limit, level
        See :func:`associate_shared`. A name that an observation has holds for all particles.
    held : (M, m), optional
        For each particle, which landmark it has taken an observation for before, by following it:
        it can be no other one. -1 for none.

    Returns
    -------
    (M, m)
        Identifiers; -1 where no pair is possible.

    Raises
    ------
    ValueError
        As :func:`associate_shared`, or if ``held`` is not (M, m) or less than -1.

    References
    ----------
    Gil et al., section 4: "for all the landmarks in the map of each particle".
    """
    possible = _Possible.of(maps, observations, mount, costs, limit, level)
    distances = kernels.squared_distances(
        possible.points, possible.rows, possible.known, *possible.pairs, possible.gate
    )
    if held is not None:
        beside = f"{len(maps)} particles and {len(observations)} observations"
        size = (len(maps), len(observations))
        held = checks.integers("held", held, size, -1, beside)
        distances[~possible.allowed(maps, held)] = np.inf
    return possible.names(maps, observations, distances)


@dataclass(frozen=True, eq=False, slots=True)
class _Possible:
    """Pairs that are possible but for the gate, and the numbers that decide it.

    Parameters
    ----------
    unnamed : (m',)
        Which observations look for a landmark.
    slots : (n',)
        Which landmarks could be theirs.
    points : (m', M, 9)
        The observations in the world, as each particle sees them.
    rows : (n', M, 9)
        The landmarks of each particle.
    known : (n', M)
        Whether a particle has a landmark.
    pairs
        For each pair the row of ``unnamed`` and that of ``slots``.
    costs : (pairs,)
        Empty where the distance in space is the cost.
    limit, gate
        Largest cost, and largest squared distance.
    """

    unnamed: np.ndarray
    slots: np.ndarray
    points: np.ndarray
    rows: np.ndarray
    known: np.ndarray
    pairs: tuple[np.ndarray, np.ndarray]
    costs: np.ndarray
    limit: float
    gate: float

    @classmethod
    def of(
        cls,
        maps: ParticleMaps,
        observations: Observations,
        mount: np.ndarray,
        costs: np.ndarray | None,
        limit: float,
        level: float,
    ) -> "_Possible":
        """Return what is possible by the names and the costs alone."""
        checks.instance("maps", maps, ParticleMaps)
        seen = checked_seen(observations, mount)
        limit = min(checks.number("limit", limit, finite=False), LARGEST)
        unnamed = np.flatnonzero(observations.ids == -1)
        free = ~np.isin(maps.ids, observations.ids)
        candidates = np.broadcast_to(free, (unnamed.size, maps.ids.size))
        if costs is not None:
            size = (len(observations), maps.ids.size)
            beside = f"{size[0]} observations and {size[1]} landmarks"
            costs = checks.array("costs", costs, size, beside, finite=False)
            if not (costs >= 0).all():
                raise ValueError(f"costs must not be negative or NaN, got {costs.min()}")
            candidates = candidates & (costs[unnamed] <= limit)
        slots = np.flatnonzero(candidates.any(axis=0))
        pairs = np.nonzero(candidates[:, slots])
        return cls(
            unnamed,
            slots,
            kernels.located(maps.poses, seen[unnamed]),
            gathered(maps, slots.tolist()),
            maps.table[slots] >= 0,
            pairs,
            np.empty(0) if costs is None else costs[unnamed[pairs[0]], slots[pairs[1]]],
            limit,
            gate(level, 3),
        )

    def allowed(self, maps: ParticleMaps, held: np.ndarray) -> np.ndarray:
        """Return which pairs (pairs, M) agree with what particles hold observations for."""
        own, landmarks = held[:, self.unnamed[self.pairs[0]]].T, maps.ids[self.slots[self.pairs[1]]]
        return (own < 0) | (own == landmarks[:, None])

    def names(
        self, maps: ParticleMaps, observations: Observations, distances: np.ndarray
    ) -> np.ndarray:
        """Return the identifiers by squared distances (pairs, M), or raise."""
        if np.isnan(distances).any():
            raise ValueError(SINGULAR)
        sizes = (self.unnamed.size, self.slots.size)
        found = kernels.assigned(distances, self.costs, *self.pairs, sizes, self.limit)
        names = np.tile(observations.ids, (len(found), 1))
        names[:, self.unnamed] = np.append(maps.ids[self.slots], -1)[found]
        return names
