"""Observations of a sensor of landmarks at one time."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks


@dataclass(frozen=True, eq=False, slots=True)
class Observations:
    """Landmarks observed at one time, each with the name of the landmark if that is known.

    Parameters
    ----------
    ids : (m,)
        Which landmark each observation is of; -1 for one without a name.
    values : (m, d)
        Observations in the units of the sensor, for instance points in its frame, m.
    covs : (m, d, d), optional
        Covariance of each observation; if left out, that of the sensor holds for all.

    Raises
    ------
    ValueError
        If the shapes disagree, a value is not finite, an identifier is no integer, below -1 or
        there twice, or a covariance is none.
    """

    ids: Int[np.ndarray, "m"]
    values: Float[np.ndarray, "m d"]
    covs: Float[np.ndarray, "m d d"] | None = None

    def __post_init__(self) -> None:
        values, covs = checks.array("values", self.values, ("m", "d")).copy(), self.covs
        if covs is not None:
            shape = (*values.shape, values.shape[1])
            covs = checks.covariance("covs", covs, shape, f"values {values.shape}").copy()
        self._set(self.ids, values, covs)

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, rows: slice | np.ndarray | list[int]) -> "Observations":
        """Return some of the observations: a slice, a mask or indices."""
        covs = None if self.covs is None else self.covs[rows]
        return self._like(self.ids[rows], self.values[rows], covs)

    def named(self, ids: Int[np.ndarray, "m"]) -> "Observations":
        """Return the same observations with other names."""
        return self._like(ids, self.values, self.covs)

    def anonymous(self) -> "Observations":
        """Return the same observations without names."""
        return self._like(np.full(len(self), -1), self.values, self.covs)

    def _like(self, ids: np.ndarray, values: np.ndarray, covs: np.ndarray | None) -> "Observations":
        """Return observations of which only the names are to be checked."""
        new = object.__new__(Observations)
        new._set(ids, values, covs)
        return new

    def _set(self, ids: np.ndarray, values: np.ndarray, covs: np.ndarray | None) -> None:
        ids = checks.integers("ids", ids, (len(values),), beside=f"values {values.shape}")
        names = [name for name in ids.tolist() if name != -1]
        if min(names, default=0) < 0:
            raise ValueError(f"ids must be at least -1, got {min(names)}")
        if len(set(names)) < len(names):
            twice = sorted({name for name in names if names.count(name) > 1})
            raise ValueError(f"ids name a landmark once at a time, got twice: {twice}")
        object.__setattr__(self, "ids", ids)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "covs", covs)


def unnamed(
    values: Float[np.ndarray, "m d"], covs: Float[np.ndarray, "m d d"] | None = None
) -> Observations:
    """Return observations of which nobody knows the landmarks."""
    values = checks.array("values", values, ("m", "d"))
    return Observations(np.full(len(values), -1), values, covs)
