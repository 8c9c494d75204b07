"""Belief of the planar filter: one Gaussian over the robot's pose and all landmarks."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.beliefs import Gaussian


@dataclass(frozen=True, eq=False, slots=True)
class MapBelief:
    r"""Normal distribution of :math:`x = (t_x, t_y, \varphi, p_{1x}, p_{1y}, …, p_{nx}, p_{ny})`.

    Parameters
    ----------
    mean : (3 + 2n,)
        Position, m; heading, rad; landmarks, m; all in the frame of the world.
    cov : (3 + 2n, 3 + 2n)
        Covariance in the same units.
    ids : (n,)
        Identifiers of the landmarks in the order of the state, each at least 0.

    Raises
    ------
    ValueError
        If the shapes disagree, an entry is not finite, an identifier is no integer, negative or
        there twice, or ``cov`` is not symmetric positive semi-definite.
    """

    mean: Float[np.ndarray, "states"]
    cov: Float[np.ndarray, "states states"]
    ids: Int[np.ndarray, "n"]

    def __post_init__(self) -> None:
        ids = checks.integers("ids", self.ids, ("n",))
        mean = checks.reals("mean", self.mean).copy()
        if mean.shape != (3 + 2 * ids.size,):
            raise ValueError(f"mean must be (3 + 2n,) for ids (n,), got {mean.shape}, {ids.shape}")
        if ids.size and ids.min() < 0:
            raise ValueError(f"ids must not be negative, got {ids.min()}")
        if len(set(ids.tolist())) < ids.size:
            raise ValueError(f"ids must differ, got {ids.tolist()}")
        checks.check_finite("mean", mean)
        size = (mean.size, mean.size)
        cov = checks.covariance("cov", self.cov, size, f"mean {mean.shape}").copy()
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "cov", cov)
        object.__setattr__(self, "ids", ids)

    @classmethod
    def start(cls, pose: Float[np.ndarray, "3"], cov: Float[np.ndarray, "3 3"]) -> "MapBelief":
        """Return the belief in a pose (m, m, rad) before any landmark was seen."""
        pose = checks.vector("pose", pose, 3)
        return cls(pose, cov, np.empty(0, dtype=np.int64))

    @property
    def pose(self) -> Float[np.ndarray, "3"]:
        """Estimated pose: m, m, rad."""
        return self.mean[:3]

    @property
    def pose_cov(self) -> Float[np.ndarray, "3 3"]:
        """Covariance of the pose."""
        return self.cov[:3, :3]

    @property
    def landmarks(self) -> Float[np.ndarray, "n 2"]:
        """Estimated positions of the landmarks, m, in the order of ``ids``."""
        return self.mean[3:].reshape(-1, 2)

    @property
    def landmark_covs(self) -> Float[np.ndarray, "n 2 2"]:
        """Covariance of each landmark by itself, m², in the order of ``ids``."""
        slots = 3 + 2 * np.arange(self.ids.size)[:, None] + np.arange(2)
        return self.cov[slots[:, :, None], slots[:, None, :]]

    def slot(self, landmark_id: int | np.integer) -> int:
        """Return where a landmark's first coordinate stands in the state.

        Raises
        ------
        ValueError
            If the landmark is not in the map.
        """
        found = np.flatnonzero(self.ids == checks.whole("landmark_id", landmark_id))
        if not found.size:
            raise ValueError(
                f"landmark_id must be one in the map of {self.ids.size}, got {landmark_id}"
            )
        return 3 + 2 * int(found[0])

    def landmark(self, landmark_id: int | np.integer) -> Gaussian:
        """Return the marginal belief in one landmark, m.

        Raises
        ------
        ValueError
            If the landmark is not in the map.
        """
        place = slice(self.slot(landmark_id), self.slot(landmark_id) + 2)
        return Gaussian(self.mean[place], self.cov[place, place])


def checked_places(kind: str, places: Mapping[int, np.ndarray]) -> dict[int, np.ndarray]:
    """Return places in the plane by identifier as (2,) arrays, or raise ``ValueError``.

    An identifier is an integer and at least 0: -1 stands for an observation without a name.
    """
    if not isinstance(places, Mapping):
        raise TypeError(f"{kind}s must map identifiers to places, got {checks.shown(places)}")
    checked = {}
    for name, place in places.items():
        whole = isinstance(name, int | np.integer) and not isinstance(name, bool)
        if not whole or name < 0:
            raise ValueError(
                f"{kind} needs an integer of at least 0 as identifier, got {name!r} among {kind}s"
            )
        checked[int(name)] = checks.vector(f"{kind} {name}", place, 2)
    return checked


def trusted(mean: np.ndarray, cov: np.ndarray, ids: np.ndarray) -> MapBelief:
    """Return a belief made by the filter itself, without the eigenvalues of the constructor."""
    belief = object.__new__(MapBelief)
    object.__setattr__(belief, "mean", mean)
    object.__setattr__(belief, "cov", cov)
    object.__setattr__(belief, "ids", ids)
    return belief
