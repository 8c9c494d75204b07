r"""The colours of an object as one distribution: described, warped, and followed in time.

The set of colours :math:`\mathcal C_t`, points of a colour space scaled to :math:`[0, 1]^3`, is
described by eight numbers

.. math:: x_t = (m_t, \lambda_t, \theta_t, \phi_t)

its mean, the standard deviations along its principal axes (our reading of the paper's "magnitudes")
and two angles that turn the principal axes of :math:`\mathcal C_{t-1}` onto those of
:math:`\mathcal C_t`. Two angles fix the first axis, but not the turn about it. We choose no such
turn: :math:`R(\theta, \phi) = R_3(\theta) R_2(-\phi)`, with :math:`R_k` the rotation about axis k.
"""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.fields import at_least, checked

__all__ = ["SIZE", "ColourDistribution", "Dynamics", "describe", "learn", "turn", "warp"]

SIZE = 8
"""Number of entries in a state."""
EQUAL = 1e-9
"""Variances that differ by less, as a share of the largest, count as equal."""
FLAT = 1e-9
"""Standard deviation up to which colours count as equal along an axis."""

Colours = Float[np.ndarray, "n 3"]
States = Float[np.ndarray, "*batch 8"]


def _turned(name: str, axes: Float[np.ndarray, "*batch 3 3"]) -> Float[np.ndarray, "*batch 3 3"]:
    """Return axes, or raise ``ValueError`` if they are not the columns of a rotation."""
    off = np.abs(axes.mT @ axes - np.eye(3)).max(initial=0.0)
    if off > 1e-9 or (np.linalg.det(axes) < 0).any():
        raise ValueError(f"{name} must be a rotation, got one that is off by {off:.3g}")
    return axes


def _of_one_or_two(name: str, A: Float[np.ndarray, "8 n"]) -> Float[np.ndarray, "8 n"]:
    """Return a matrix, or raise ``ValueError`` if it suits neither one earlier state nor two."""
    if A.shape[1] not in (SIZE, 2 * SIZE):
        raise ValueError(f"{name} must be (8, 8) or (8, 16), got {A.shape}")
    return A


@dataclass(frozen=True, eq=False, slots=True)
class ColourDistribution:
    r"""A distribution of colours, or a batch of them.

    Parameters
    ----------
    mean : (…, 3)
        m, in the units of the colour space.
    lengths : (…, 3)
        :math:`\lambda`, standard deviations along the principal axes.
    axes : (…, 3, 3)
        V, the principal axes as columns of a rotation.
    angles : (…, 2)
        :math:`\theta` and :math:`\phi`, direction of the first axis in the frame of the axes of the
        time step before, rad (see `turn`).

    Raises
    ------
    ValueError
        If the shapes of the batch differ, or the axes are no rotation.
    """

    mean: Float[np.ndarray, "*batch 3"]
    lengths: Annotated[Float[np.ndarray, "*batch 3"], at_least(0)]
    axes: Annotated[Float[np.ndarray, "*batch 3 3"], _turned]
    angles: Float[np.ndarray, "*batch 2"]

    def __post_init__(self) -> None:
        checked(self)
        *batch, _ = self.mean.shape
        for name, size in (("lengths", (3,)), ("axes", (3, 3)), ("angles", (2,))):
            beside = f"mean {self.mean.shape}"
            checks.shaped(name, getattr(self, name), (*batch, *size), beside)

    @classmethod
    def of(cls, states: States, axes: Float[np.ndarray, "3 3"]) -> "ColourDistribution":
        r"""Return the distributions of states.

        Parameters
        ----------
        states : (…, 8)
            :math:`(m, \lambda, \theta, \phi)`.
        axes : (3, 3)
            Principal axes of the time step before, which the angles turn.

        Raises
        ------
        ValueError
            If a number is not finite, a length is negative, or the axes are no rotation.
        """
        states = checks.array("states", states, (..., SIZE))
        if (states[..., 3:6] < 0).any():
            raise ValueError(f"states must not have negative lengths, got {states[..., 3:6].min()}")
        axes = _rotation("axes", axes, (3, 3))
        angles = states[..., 6:]
        return cls(states[..., :3], states[..., 3:6], axes @ turn(angles), angles)

    @property
    def state(self) -> States:
        r""":math:`(m, \lambda, \theta, \phi)`."""
        return np.concatenate([self.mean, self.lengths, self.angles], axis=-1)


def turn(angles: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 3 3"]:
    r"""Return the rotation :math:`R_3(\theta) R_2(-\phi)` of two angles.

    .. math::
        R = \begin{pmatrix}
        \cos\theta \cos\phi & -\sin\theta & -\cos\theta \sin\phi \\
        \sin\theta \cos\phi & \cos\theta & -\sin\theta \sin\phi \\
        \sin\phi & 0 & \cos\phi
        \end{pmatrix}

    Parameters
    ----------
    angles : (…, 2)
        :math:`\theta` turns the first axis in the plane of the first two axes, :math:`\phi` lifts
        it out of that plane, rad.

    Raises
    ------
    ValueError
        If an angle is not finite.
    """
    angles = checks.array("angles", angles, (..., 2))
    (s, sin), (c, cos) = (np.moveaxis(f(angles), -1, 0) for f in (np.sin, np.cos))
    rows = [c * cos, -s, -c * sin], [s * cos, c, -s * sin], [sin, np.zeros_like(s), cos]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def describe(colours: Colours, axes: Float[np.ndarray, "3 3"] | None = None) -> ColourDistribution:
    r"""Return the distribution of a set of colours: its mean, lengths, axes and angles.

    .. math:: C = \frac1n \sum_i (c_i - m)(c_i - m)^\top = V \operatorname{diag}(\lambda^2) V^\top

    The axes are ordered by falling length. The colours leave open the signs of the axes, and the
    directions of axes of equal length (of all three for a single colour). There we take those
    nearest to the axes of the time step before.

    Parameters
    ----------
    colours : (n, 3)
        At least one colour.
    axes : (3, 3)
        Principal axes of the time step before, a rotation; those of the colour space if not given.

    Raises
    ------
    ValueError
        If there is no colour, one is not finite, or the axes are no rotation.
    """
    colours = _colours(colours)
    before = np.eye(3) if axes is None else _rotation("axes", axes, (3, 3))
    mean = colours.mean(axis=0)
    apart = colours - mean
    variances, found = np.linalg.eigh(apart.T @ apart / len(colours))
    variances, found = variances[::-1].clip(0.0), found[:, ::-1].copy()
    steps = np.diff(variances) < -EQUAL * variances[0]
    for group in np.split(np.arange(3), np.flatnonzero(steps) + 1):
        # rotate the axes of equal length towards the axes before; a single axis gets its sign
        left, _, right = np.linalg.svd(found[:, group].T @ before[:, group])
        found[:, group] = found[:, group] @ left @ right
    if np.linalg.det(found) < 0:
        found[:, 2] *= -1
    ahead, aside, up = before.T @ found[:, 0]
    angles = np.array([np.arctan2(aside, ahead), np.arcsin(np.clip(up, -1, 1))])
    return ColourDistribution(mean, np.sqrt(variances), found, angles)


def warp(
    colours: Colours, before: ColourDistribution, after: ColourDistribution
) -> Float[np.ndarray, "*batch n 3"]:
    r"""Return a set of colours moved, turned and stretched from one distribution to another.

    .. math::
        c \mapsto m' + V' \operatorname{diag}(\lambda' / \lambda) V^\top (c - m)

    Along an axis with :math:`\lambda = 0` nothing is stretched.

    Parameters
    ----------
    colours : (n, 3)
        Colours c, the set that ``before`` describes.
    before
        Distribution :math:`(m, \lambda, V)` of these colours.
    after
        Distribution :math:`(m', \lambda', V')` that they shall have, or a batch of them.

    Raises
    ------
    TypeError
        If ``before`` or ``after`` is not a `ColourDistribution`.
    ValueError
        If there is no colour, one is not finite, or ``before`` is a batch.
    """
    colours = _colours(colours)
    if checks.instance("before", before, ColourDistribution).mean.ndim != 1:
        raise ValueError(f"before must be one distribution, got {before.mean.shape[:-1]}")
    checks.instance("after", after, ColourDistribution)
    wide = before.lengths > FLAT
    scale = np.where(wide, after.lengths / np.where(wide, before.lengths, 1.0), 1.0)
    matrix = (after.axes * scale[..., None, :]) @ before.axes.T
    return after.mean[..., None, :] + (colours - before.mean) @ matrix.mT


@dataclass(frozen=True, eq=False, slots=True)
class Dynamics:
    r"""Motion model of a state from frame to frame, of first or of second order.

    .. math:: x_t = A s_{t-1} + b + B w, \qquad w \sim \mathcal N(0, I)

    with :math:`s_{t-1} = x_{t-1}` (first order) or :math:`s_{t-1} = (x_{t-1}, x_{t-2})` (second).

    Parameters
    ----------
    A : (8, 8) or (8, 16)
        Transition matrix.
    b : (8,)
        Constant drift.
    B : (8, 8)
        Noise matrix; :math:`B B^\top` is the covariance of the noise.

    References
    ----------
    Andrade-Cetto, "Perception issues in mobile robotics", section 3.3, probabilistic propagation.
    """

    A: Annotated[Float[np.ndarray, "8 n"], _of_one_or_two]
    b: Float[np.ndarray, "8"]
    B: Float[np.ndarray, "8 8"]
    __post_init__ = checked

    @property
    def order(self) -> int:
        """Order of the model: the number of earlier states that it needs, 1 or 2."""
        return self.A.shape[1] // SIZE

    def propagate(
        self, states: Float[np.ndarray, "*batch n"], *, rng: np.random.Generator, noise: float = 1.0
    ) -> Float[np.ndarray, "*batch n"]:
        r"""Return :math:`s_t`: the next states, each followed by the last one at second order.

        Negative lengths are reflected at 0.

        Parameters
        ----------
        states : (…, 8 order)
            :math:`s_{t-1}`: :math:`x_{t-1}`, or :math:`(x_{t-1}, x_{t-2})`.
        rng
            Source of w.
        noise
            Factor of B; 0 predicts without noise.

        Raises
        ------
        ValueError
            If the states have another size or a number is not finite, or the noise is negative.
        """
        states = checks.array("states", states, (..., SIZE * self.order))
        noise = checks.not_negative("noise", noise)
        w = checks.generator("rng", rng).standard_normal((*states.shape[:-1], SIZE))
        moved = states @ self.A.T + self.b + noise * (w @ self.B.T)
        moved[..., 3:6] = np.abs(moved[..., 3:6])
        return np.concatenate([moved, states[..., : SIZE * (self.order - 1)]], axis=-1)


def learn(states: Float[np.ndarray, "n 8"], *, order: int = 1, ridge: float = 0.1) -> Dynamics:
    r"""Return the dynamics of a training sequence, by least squares with a ridge.

    .. math::
        \min_{A, b} \sum_t |x_t - A s_{t-1} - b|^2 + N \kappa |(A - A_0) D|^2, \qquad
        B B^\top = \operatorname{cov}(x_t - A s_{t-1} - b)

    over the N transitions of the sequence, with D the diagonal matrix of the standard deviations of
    s in training. The prior :math:`A_0` holds where training decides nothing: mean and lengths stay
    as they were (first order) or go on at constant velocity (second order). It sets angles to 0, as
    an angle counts from the axes of the frame before and is a velocity already.

    Parameters
    ----------
    states : (n, 8)
        States of one sequence, frame by frame.
    order
        1, or 2 for the constant velocity that the paper names.
    ridge
        Weight :math:`\kappa` of the prior, positive; our choice.

    Raises
    ------
    ValueError
        If there are fewer than ``order + 2`` states, a number is not finite or beyond 1e100, or an
        argument is out of its range.

    References
    ----------
    Andrade-Cetto, "Perception issues in mobile robotics", section 3.3: "The parameters A and B are
    estimated a priori from a training sequence."
    """
    states = checks.array("states", states, ("n", SIZE))
    order = checks.whole("order", order, 1, 2)
    ridge = checks.positive("ridge", ridge)
    if len(states) < order + 2:
        raise ValueError(f"states must be at least {order + 2}, got {len(states)}")
    turned = np.r_[np.ones(6), 0.0, 0.0]
    prior = np.hstack([np.diag(turned)] if order == 1 else [np.diag(2 * turned), -np.diag(turned)])
    s = np.hstack([states[order - 1 - k : len(states) - 1 - k] for k in range(order)])
    after = states[order:] - s @ prior.T  # residuals of the prior
    centre, rest = s.mean(axis=0), after.mean(axis=0)
    apart = s - centre
    penalty = ridge * apart.var(axis=0) + FLAT**2  # where s never changed, the prior holds
    gram = apart.T @ apart / len(s) + np.diag(penalty)
    gained = np.linalg.solve(gram, apart.T @ (after - rest) / len(s)).T
    b = rest - gained @ centre
    left = after - s @ gained.T - b
    values, vectors = np.linalg.eigh(left.T @ left / len(s))
    B = (vectors * np.sqrt(values.clip(0.0))) @ vectors.T
    return Dynamics(prior + gained, b, B)


def _colours(value: Any) -> Colours:
    """Return a set of colours, or raise ``ValueError`` if it is empty or one is out of range."""
    colours = checks.array("colours", value, ("n", 3))
    if not len(colours):
        raise ValueError(f"colours must hold at least one, got {colours.shape}")
    if np.abs(colours).max() > 1e6:
        raise ValueError(f"colours must be within a million, got {np.abs(colours).max():g}")
    return colours


def _rotation(name: str, value: Any, shape: tuple, beside: str = "") -> np.ndarray:
    """Return an array of rotations, or raise ``ValueError`` if it holds another matrix."""
    return _turned(name, checks.array(name, value, shape, beside))
