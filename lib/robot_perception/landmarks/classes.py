r"""A landmark as a class of descriptors: their mean, their diagonal variance, their number.

What a variance from few descriptors is worth is decided by the four estimates below. OpenCV rounds
descriptors to whole numbers, so none of them goes below the variance of rounding, 1/12.
"""

from dataclasses import dataclass
from typing import Annotated, no_type_check

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.fields import at_least, checked
from robot_perception.kernels import kernel

ROUNDING = 1 / 12  # variance of a number that was rounded to a whole one


@dataclass(frozen=True, eq=False, slots=True)
class DescriptorClasses:
    r"""Classes of descriptors, each with what its descriptors have added up to.

    .. math:: \bar d_i = \frac 1 p \sum_k d_k, \qquad q_i = \sum_k (d_k - \bar d_i)^2

    Parameters
    ----------
    means : (n, d)
        Means :math:`\bar d_i`.
    squares : (n, d)
        Sums :math:`q_i` of squared deviations from the mean, entry by entry.
    counts : (n,)
        Numbers p of descriptors, at least 1.

    Raises
    ------
    ValueError
        If the shapes disagree, a number is not finite, a sum negative or a number of descriptors
        less than 1.
    """

    means: Float[np.ndarray, "n d"]
    squares: Annotated[Float[np.ndarray, "n d"], at_least(0)]
    counts: Annotated[Int[np.ndarray, " n"], at_least(1)]
    __post_init__ = checked

    @classmethod
    def of(cls, descriptors: Float[np.ndarray, "n d"]) -> "DescriptorClasses":
        """Return a class for each of some descriptors.

        Parameters
        ----------
        descriptors : (n, d)
            The first descriptor of each class.

        Raises
        ------
        ValueError
            If the descriptors are not (n, d) or not finite.
        """
        first = checks.array("descriptors", descriptors, ("n", "d")).copy()
        return cls(first, np.zeros_like(first), np.ones(len(first), dtype=int))

    def __len__(self) -> int:
        return len(self.means)

    def __getitem__(self, rows: slice | np.ndarray | list[int]) -> "DescriptorClasses":
        """Return some of the classes: a slice, a mask or indices."""
        return DescriptorClasses(self.means[rows], self.squares[rows], self.counts[rows])

    def with_others(self, others: "DescriptorClasses") -> "DescriptorClasses":
        """Return these classes, and others after them.

        Parameters
        ----------
        others
            Classes of descriptors of the same length.

        Raises
        ------
        ValueError
            If the descriptors of ``others`` have another length.
        """
        self._check_like(others)
        return DescriptorClasses(
            np.concatenate([self.means, others.means]),
            np.concatenate([self.squares, others.squares]),
            np.concatenate([self.counts, others.counts]),
        )

    def updated(
        self, rows: Int[np.ndarray, " m"], descriptors: Float[np.ndarray, "m d"]
    ) -> "DescriptorClasses":
        r"""Return the classes with a new descriptor each in some of them (Welford's update).

        .. math:: \bar d \leftarrow \bar d + \frac{d - \bar d}{p + 1}, \qquad
                  q \leftarrow q + (d - \bar d)(d - \bar d_\text{new})

        Parameters
        ----------
        rows : (m,)
            Which class each descriptor belongs to; a class may be there several times.
        descriptors : (m, d)
            The descriptors.

        Raises
        ------
        ValueError
            If shapes disagree, a number is not finite or there is no such class.

        References
        ----------
        Welford, "Note on a method for calculating corrected sums of squares and products",
        Technometrics 4(3), 1962.
        """
        return self.merged(rows, DescriptorClasses.of(descriptors))

    def merged(
        self, rows: Int[np.ndarray, " m"], others: "DescriptorClasses"
    ) -> "DescriptorClasses":
        r"""Return the classes with others taken into some of them.

        .. math:: \bar d = \bar d_a + \frac{p_b}{p_a + p_b} (\bar d_b - \bar d_a), \qquad
                  q = q_a + q_b + \frac{p_a p_b}{p_a + p_b} (\bar d_b - \bar d_a)^2

        Parameters
        ----------
        rows : (m,)
            Which class each of the others goes into; a class may be there several times.
        others
            m classes of descriptors of the same length.

        Raises
        ------
        ValueError
            If shapes disagree or there is no such class.

        References
        ----------
        Chan, Golub and LeVeque, "Updating formulae and a pairwise algorithm for computing sample
        variances", COMPSTAT 1982.
        """
        self._check_like(others)
        rows = checks.integers("rows", rows, (len(others),), 0, f"others of {len(others)}")
        if rows.size and rows.max() >= len(self):
            raise ValueError(f"rows must be below {len(self)}, got {rows.max()}")
        merged = self.means.copy(), self.squares.copy(), self.counts.copy()
        _merge(*merged, rows, others.means, others.squares, others.counts)
        return DescriptorClasses(*merged)

    def _check_like(self, others: "DescriptorClasses") -> None:
        d = checks.instance("others", others, DescriptorClasses).means.shape[1]
        if d != self.means.shape[1]:
            raise ValueError(
                f"descriptors of others must have {self.means.shape[1]} numbers, got {d}"
            )


@kernel()
@no_type_check
def _merge(
    means, squares, counts, rows, other_means, other_squares, other_counts
):  # pragma: no cover - compiled
    """Take classes into others, in place."""
    for k in range(rows.size):
        i, a, b = rows[k], counts[rows[k]], other_counts[k]
        for j in range(means.shape[1]):
            step = other_means[k, j] - means[i, j]
            means[i, j] += step * (b / (a + b))
            squares[i, j] += other_squares[k, j] + step * step * (a * b / (a + b))
        counts[i] = a + b


def raw_variances(classes: DescriptorClasses) -> Float[np.ndarray, "n d"]:
    r"""Return the variance of each class as its own descriptors give it.

    .. math:: s^2 = \max\left(\frac{q}{p - 1}, \frac 1{12}\right)

    Parameters
    ----------
    classes
        Classes of at least two descriptors each.

    Raises
    ------
    ValueError
        If one of the classes has but one descriptor.

    References
    ----------
    Gil et al. (2006), §4; what it does where a variance is 0, it does not say.
    """
    return floored_variances(classes, ROUNDING)


def floored_variances(classes: DescriptorClasses, least: float) -> Float[np.ndarray, "n d"]:
    r"""Return the variance of each class, but never less than a floor.

    .. math:: s^2 = \max\left(\frac{q}{p - 1}, s^2_\text{least}\right)

    Parameters
    ----------
    classes
        Classes of at least two descriptors each.
    least
        The floor, at least the 1/12 of rounding.

    Raises
    ------
    ValueError
        If one of the classes has but one descriptor, or the floor is too low.
    """
    counts = checks.instance("classes", classes, DescriptorClasses).counts
    if not checks.positive("least", least) >= ROUNDING:
        raise ValueError(f"least must be at least 1/12, the variance of rounding, got {least}")
    lone = np.count_nonzero(counts < 2)
    if lone:
        raise ValueError(
            f"classes must have two descriptors or more, got {lone} of {len(counts)} with one"
        )
    return np.maximum(classes.squares / (counts - 1)[:, None], least)


def pooled_variances(classes: DescriptorClasses) -> Float[np.ndarray, "n d"]:
    r"""Return one variance for all classes: that of all descriptors about their classes' means.

    .. math:: s_0^2 = \max\left(\frac{\sum_i q_i}{\sum_i (p_i - 1)}, \frac 1{12}\right)

    Parameters
    ----------
    classes
        Classes, of which one at least has two descriptors.

    Returns
    -------
    (n, d)
        Equal rows, as a view of one.

    Raises
    ------
    ValueError
        If all of the classes have but one descriptor.
    """
    counts = checks.instance("classes", classes, DescriptorClasses).counts
    freedom = counts.sum() - len(counts)
    if not freedom:
        raise ValueError(
            f"classes must have two descriptors somewhere, got {len(counts)} with one at most"
        )
    pooled = np.maximum(classes.squares.sum(axis=0) / freedom, ROUNDING)
    return np.broadcast_to(pooled, classes.means.shape)


def shrunk_variances(classes: DescriptorClasses, strength: float) -> Float[np.ndarray, "n d"]:
    r"""Return the variance of each class drawn towards the pooled one, the more the fewer its
    descriptors.

    .. math:: s^2 = \max\left(\frac{q + \nu_0 s_0^2}{p - 1 + \nu_0}, \frac 1{12}\right)

    This is what a scaled inverse χ² prior of :math:`\nu_0` degrees of freedom makes of a variance.

    Parameters
    ----------
    classes
        Classes, of which one at least has two descriptors.
    strength
        Degrees of freedom :math:`\nu_0` that the pooled variance :math:`s_0^2` counts for.

    Raises
    ------
    ValueError
        If all of the classes have but one descriptor, or the strength is not positive.

    References
    ----------
    Smyth, "Linear models and empirical Bayes methods for assessing differential expression in
    microarray experiments", Statistical Applications in Genetics and Molecular Biology 3(1), 2004.
    """
    strength = checks.positive("strength", strength)
    pooled = pooled_variances(classes)
    freedom = (classes.counts - 1)[:, None] + strength
    return np.maximum((classes.squares + strength * pooled) / freedom, ROUNDING)
