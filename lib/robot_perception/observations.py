"""What a sensor of landmarks saw at one time."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from robot_perception.checks import check_covariance, check_finite


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
        values = np.array(self.values, dtype=float)
        if values.ndim != 2:
            raise ValueError(f"values must be (m, d), got {values.shape}")
        check_finite("values", values)
        covs = None if self.covs is None else np.array(self.covs, dtype=float)
        if covs is not None:
            if covs.shape != (*values.shape, values.shape[1]):
                wanted = (*values.shape, values.shape[1])
                raise ValueError(f"covs must be {wanted}, got {covs.shape}")
            check_covariance("covs", covs)
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
        ids = np.array(ids)
        if ids.size and not np.issubdtype(ids.dtype, np.integer):
            raise ValueError(f"ids must be integers, got {ids.dtype}")
        if ids.shape != values.shape[:1]:
            raise ValueError(f"ids must be {values.shape[:1]} as values are, got {ids.shape}")
        names = [name for name in ids.tolist() if name != -1]
        if min(names, default=0) < 0:
            raise ValueError(f"ids must be at least -1, got {min(names)}")
        if len(set(names)) < len(names):
            twice = sorted({name for name in names if names.count(name) > 1})
            raise ValueError(f"a landmark is observed once at a time, got twice: {twice}")
        object.__setattr__(self, "ids", ids.astype(np.int64))
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "covs", covs)


def unnamed(
    values: Float[np.ndarray, "m d"], covs: Float[np.ndarray, "m d d"] | None = None
) -> Observations:
    """Return observations of which nobody knows the landmarks."""
    return Observations(np.full(len(values), -1), values, covs)
