r"""Distances between new descriptors and the landmarks of a map, by four metrics.

Each takes the mean descriptors :math:`\bar d_j` of newcomers and what is kept of how the landmarks
look, and returns a table of distances, the roots of eqs (8) and (9) of Gil, Payá, Reinoso,
Fernández and Puerto, "Simultaneous localization and mapping in indoor environments using SIFT
features", VIIP 2006:

.. math:: E_{ij} = |\bar d_j - \bar d_i|^2, \qquad
    L_{ij} = (\bar d_j - \bar d_i)^\top S_i^{-1} (\bar d_j - \bar d_i)

Beyond which distance a newcomer is no landmark, they do not say. The unit of L is a variance: for
normal and independent entries of variance :math:`S_i`, known, means of p descriptors each of one
landmark give :math:`L = \frac 2 p \chi^2_{128}`. Descriptors of neighbouring frames are not
independent, and from few of them :math:`S_i` is too small where they happened to agree, so this is
a lower end for a limit and none that right pairs respect.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.landmarks.association import Euclidean, Mahalanobis
from robot_perception.landmarks.classes import DescriptorClasses, raw_variances, shrunk_variances


@runtime_checkable
class DescriptorStatistics(Protocol):
    """Statistics of N landmarks' descriptors: firsts, means, summed squared deviations, numbers."""

    @property
    def firsts(self) -> Float[np.ndarray, "N d"]:
        """The descriptor with which each was first seen."""

    @property
    def means(self) -> Float[np.ndarray, "N d"]:
        """The mean of the descriptors of each."""

    @property
    def squares(self) -> Float[np.ndarray, "N d"]:
        """Sums of their squared deviations from it."""

    @property
    def counts(self) -> Int[np.ndarray, "N"]:
        """Number of landmarks."""


@runtime_checkable
class Asked(Protocol):
    """Newcomers and the landmarks that they might be."""

    @property
    def descriptors(self) -> Float[np.ndarray, "m d"]:
        """The mean descriptor of each newcomer."""

    @property
    def looks(self) -> DescriptorStatistics:
        """Descriptors of the landmarks."""


Metric = Callable[[Asked], Float[np.ndarray, "m N"]]


def euclidean_mean(asked: Asked) -> Float[np.ndarray, "m N"]:
    r"""Return the Euclidean distances to the mean descriptors of the landmarks.

    .. math:: |\bar d_j - \bar d_i|

    Parameters
    ----------
    asked
        Newcomers and landmarks.

    Raises
    ------
    ValueError
        If descriptors are not of one length or not finite.

    References
    ----------
    Gil et al., eq. (8), to the means of eq. (9).
    """
    return _euclidean(asked, _looks(asked).means)


def euclidean_first(asked: Asked) -> Float[np.ndarray, "m N"]:
    r"""Return the Euclidean distances to the descriptors with which landmarks were first seen.

    .. math:: |\bar d_j - d_{i,1}|

    Parameters
    ----------
    asked
        Newcomers and landmarks.

    Raises
    ------
    ValueError
        If descriptors are not of one length or not finite.

    References
    ----------
    Gil et al., eq. (8), of one descriptor of a landmark.
    """
    return _euclidean(asked, _looks(asked).firsts)


def mahalanobis(asked: Asked) -> Float[np.ndarray, "m N"]:
    r"""Return the Mahalanobis distances with the variances of each landmark's own descriptors.

    .. math:: \sqrt{(\bar d_j - \bar d_i)^\top S_i^{-1} (\bar d_j - \bar d_i)}

    Parameters
    ----------
    asked
        Newcomers and landmarks of two descriptors or more each.

    Raises
    ------
    ValueError
        If descriptors are not of one length or not finite, or a landmark has but one.

    References
    ----------
    Gil et al., eq. (9). No variance is below that of rounding, see
    :func:`~robot_perception.landmarks.raw_variances`.
    """
    classes = _classes(asked)
    return _mahalanobis(asked, classes, raw_variances(classes))


def mahalanobis_shrunk(asked: Asked, strength: float = 10.0) -> Float[np.ndarray, "m N"]:
    r"""Return the same with variances that are drawn towards those of all landmarks.

    Parameters
    ----------
    asked
        Newcomers and landmarks, of which one at least has two descriptors.
    strength
        Degrees of freedom that the variance of all landmarks counts for; ours.

    Raises
    ------
    ValueError
        If descriptors are not of one length or not finite, no landmark has two, or the strength is
        not positive.

    References
    ----------
    See :func:`~robot_perception.landmarks.shrunk_variances`.
    """
    classes = _classes(asked)
    return _mahalanobis(asked, classes, shrunk_variances(classes, strength))


METRICS: Mapping[str, Metric] = MappingProxyType(
    {
        "Euclid to the mean": euclidean_mean,
        "Euclid to the first": euclidean_first,
        "Mahalanobis, raw": mahalanobis,
        "Mahalanobis, shrunk": mahalanobis_shrunk,
    }
)
"""Metrics by name."""


def _looks(asked: Asked) -> DescriptorStatistics:
    looks = checks.instance("asked", asked, Asked).looks
    return checks.instance("asked.looks", looks, DescriptorStatistics)


def _classes(asked: Asked) -> DescriptorClasses:
    looks = _looks(asked)
    return DescriptorClasses(looks.means, looks.squares, looks.counts)


def _euclidean(asked: Asked, landmarks: np.ndarray) -> np.ndarray:
    return np.sqrt(Euclidean(landmarks).distances(asked.descriptors))


def _mahalanobis(asked: Asked, classes: DescriptorClasses, variances: np.ndarray) -> np.ndarray:
    return np.sqrt(Mahalanobis(classes.means, variances).distances(asked.descriptors))
