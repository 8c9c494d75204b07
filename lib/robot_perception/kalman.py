"""The linear Kalman filter, its Fisher information and its steady state.

Equation numbers are those of Andrade-Cetto, "Perception Issues in Mobile Robotics", section 2.2.
Leading axes are batches everywhere: a hundred filters are one array, not a loop.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.beliefs import Gaussian


@dataclass(frozen=True, eq=False, slots=True)
class Motion:
    r"""Linear motion model: :math:`x_{k+1} = F x_k + b + v`, :math:`v \sim \mathcal N(0, Q)`.

    Parameters
    ----------
    transition : (…, n, n)
        :math:`F`; any square matrix, symmetric or not.
    noise : (…, n, n)
        :math:`Q = F_v V F_v^\top`, covariance of the plant noise in the units of the state.
    shift : (…, n), optional
        :math:`b`, the effect of the command; zero if left out.

    Raises
    ------
    ValueError
        If the shapes disagree, an entry is not finite, or ``noise`` is no covariance.
    """

    transition: Float[np.ndarray, "... n n"]
    noise: Float[np.ndarray, "... n n"]
    shift: Float[np.ndarray, "... n"] | None = None

    def __post_init__(self) -> None:
        F = checks.array("transition", self.transition, (..., "n", "n"))
        n = F.shape[-1]
        Q = checks.covariance("noise", self.noise, (..., n, n), f"transition {F.shape}")
        b = np.zeros(n) if self.shift is None else checks.array("shift", self.shift, (..., n))
        checks.check_batches(transition=F.shape[:-2], noise=Q.shape[:-2], shift=b.shape[:-1])
        object.__setattr__(self, "transition", F)
        object.__setattr__(self, "noise", Q)
        object.__setattr__(self, "shift", b)


@dataclass(frozen=True, eq=False, slots=True)
class Sensor:
    r"""Linear sensor model: :math:`z = H x + w`, :math:`w \sim \mathcal N(0, R)`.

    Parameters
    ----------
    matrix : (…, m, n)
        :math:`H`.
    noise : (…, m, m)
        :math:`R = H_w W H_w^\top`, covariance of the measurement noise.

    Raises
    ------
    ValueError
        If the shapes disagree, an entry is not finite, or ``noise`` is no covariance.
    """

    matrix: Float[np.ndarray, "... m n"]
    noise: Float[np.ndarray, "... m m"]

    def __post_init__(self) -> None:
        H = checks.array("matrix", self.matrix)
        if H.ndim < 2 or 0 in H.shape[-2:]:
            raise ValueError(f"matrix must be (…, m, n) with m, n >= 1, got {H.shape}")
        m = H.shape[-2]
        R = checks.covariance("noise", self.noise, (..., m, m), f"matrix {H.shape}")
        checks.check_batches(matrix=H.shape[:-2], noise=R.shape[:-2])
        object.__setattr__(self, "matrix", H)
        object.__setattr__(self, "noise", R)


@dataclass(frozen=True, eq=False, slots=True)
class UpdateInfo:
    r"""Diagnostics of one update.

    Parameters
    ----------
    innovation : (…, m)
        :math:`\tilde z = z - H \hat x`.
    innovation_cov : (…, m, m)
        :math:`S`, eq. (8).
    gain : (…, n, m)
        :math:`K`, eq. (7).
    normalised_innovation_squared : (…,)
        :math:`\tilde z^\top S^{-1} \tilde z`, χ² with m degrees of freedom for a right model.
    log_likelihood : (…,)
        Logarithm of the density (11).
    """

    innovation: Float[np.ndarray, "... m"]
    innovation_cov: Float[np.ndarray, "... m m"]
    gain: Float[np.ndarray, "... n m"]
    normalised_innovation_squared: Float[np.ndarray, "..."]
    log_likelihood: Float[np.ndarray, "..."]


def predict(prior: Gaussian, motion: Motion) -> Gaussian:
    r"""Return the belief after a motion.

    .. math:: \hat x^- = F \hat x + b, \qquad P^- = F P F^\top + Q

    Parameters
    ----------
    prior
        Belief before the motion.
    motion
        The motion; its leading axes broadcast against those of the belief.

    Returns
    -------
    Gaussian
        Belief after the motion.

    Raises
    ------
    ValueError
        If the motion is of another state size.

    References
    ----------
    Andrade-Cetto, eqs (3) and (5).
    """
    checks.instance("prior", prior, Gaussian)
    checks.instance("motion", motion, Motion)
    F, Q, b = motion.transition, motion.noise, motion.shift
    if F.shape[-1] != prior.mean.shape[-1]:
        raise ValueError(f"motion is of {F.shape[-1]} states, the belief of {prior.mean.shape[-1]}")
    checks.check_batches(prior=prior.mean.shape[:-1], motion=F.shape[:-2])
    mean = _apply(F, prior.mean) + b  # eq. (3)
    return Gaussian(mean, _symmetric(F @ prior.cov @ F.mT + Q))  # eq. (5)


@checks.computable("prior, measurement and sensor")
def update(
    prior: Gaussian, measurement: Float[np.ndarray, "... m"], sensor: Sensor
) -> tuple[Gaussian, UpdateInfo]:
    r"""Return the belief after a measurement, and what the measurement showed.

    .. math::
        S = H P H^\top + R, \quad K = P H^\top S^{-1}, \quad
        \hat x^+ = \hat x + K \tilde z, \quad P^+ = (I - K H) P (I - K H)^\top + K R K^\top

    Parameters
    ----------
    prior
        Belief before the measurement.
    measurement : (…, m)
        :math:`z`, in the units of the sensor.
    sensor
        The sensor; leading axes of all three broadcast.

    Raises
    ------
    ValueError
        If the shapes disagree, the measurement is not finite, or :math:`S` is singular.

    References
    ----------
    Andrade-Cetto, eqs (6) to (9) and (11).
    """
    checks.instance("prior", prior, Gaussian)
    checks.instance("sensor", sensor, Sensor)
    H, R, P = sensor.matrix, sensor.noise, prior.cov
    m, n = H.shape[-2:]
    if n != prior.mean.shape[-1]:
        raise ValueError(f"sensor is of {n} states, the belief of {prior.mean.shape[-1]}")
    z = checks.array("measurement", measurement, (..., m))
    checks.check_batches(prior=prior.mean.shape[:-1], measurement=z.shape[:-1], sensor=H.shape[:-2])

    innovation = z - _apply(H, prior.mean)
    S = H @ P @ H.mT + R  # innovation covariance, eq. (8)
    log_det = _log_determinant("innovation covariance", S)
    K = np.linalg.solve(S, H @ P).mT  # gain, eq. (7); S and P are symmetric
    mean = prior.mean + _apply(K, innovation)  # eq. (6)
    rest = np.eye(n) - K @ H
    cov = rest @ P @ rest.mT + K @ R @ K.mT  # Joseph form, eq. (9)

    whitened = np.linalg.solve(S, innovation[..., None])[..., 0]
    squared = (innovation * whitened).sum(axis=-1)
    log_likelihood = -0.5 * (m * np.log(2 * np.pi) + log_det + squared)  # eq. (11)
    info = UpdateInfo(innovation, S, K, *map(np.asarray, (squared, log_likelihood)))
    return Gaussian(mean, _symmetric(cov)), info


def fisher_information(
    matrix: Float[np.ndarray, "m n"], innovation_covs: Float[np.ndarray, "... steps m m"]
) -> Float[np.ndarray, "... steps n n"]:
    r"""Return the running sum that the paper calls the total Fisher information.

    .. math:: J_k = \sum_{i=1}^k H^\top S_i^{-1} H

    The sum takes every innovation for news about one fixed state; see :func:`state_information`
    for what is known of the state as it is, and :func:`start_information` for the start.

    Parameters
    ----------
    matrix : (m, n)
        :math:`H`.
    innovation_covs : (…, steps, m, m)
        :math:`S_1, …, S_k`.

    Returns
    -------
    (…, steps, n, n)
        :math:`J_1, …, J_k`.

    Raises
    ------
    ValueError
        If the shapes disagree or an :math:`S_i` is singular.

    References
    ----------
    Andrade-Cetto, eq. (14).
    """
    H = checks.array("matrix", matrix, ("m", "n"))
    m = len(H)
    shape = (..., "steps", m, m)
    S = checks.covariance("innovation_covs", innovation_covs, shape, f"matrix {H.shape}")
    _log_determinant("innovation_covs", S)
    terms = H.T @ np.linalg.solve(S, np.broadcast_to(H, (*S.shape[:-1], H.shape[1])))
    return np.cumsum(_symmetric(terms), axis=-3)  # eq. (14)


@checks.computable("motions and sensors")
def start_information(
    motions: Sequence[Motion], sensors: Sequence[Sensor]
) -> Float[np.ndarray, "steps n n"]:
    r"""Return the Fisher information of the measurements about the state at the start.

    .. math::
        J_k = \sum_{i=1}^k (H_i \Phi_i)^\top S_i^{-1} (H_i \Phi_i), \qquad
        \Phi_{i+1} = F_{i+1} (I - K_i H_i) \Phi_i, \quad \Phi_1 = F_1,

    with :math:`S_i` and :math:`K_i` of the filter that knows the start exactly. An innovation
    depends on the start through the true state *and* through the prediction, which earlier
    innovations have already corrected; eq. (14) leaves the second part out.

    Parameters
    ----------
    motions, sensors
        The steps, in order; each motion is followed by its measurement.

    Returns
    -------
    (steps, n, n)
        Information after each step, without any prior on the start.

    Raises
    ------
    ValueError
        If the sequences are empty, differ in length, or an innovation covariance is singular.
    """
    motions = checks.instances("motions", motions, Motion)
    sensors = checks.instances("sensors", sensors, Sensor)
    if not motions or len(motions) != len(sensors):
        raise ValueError(f"need as many motions as sensors, got {len(motions)}, {len(sensors)}")
    n = motions[0].transition.shape[-1]
    belief = Gaussian(np.zeros(n), np.zeros((n, n)))
    sensitivity = np.eye(n)
    total, history = np.zeros((n, n)), []
    for motion, sensor in zip(motions, sensors, strict=True):
        belief = predict(belief, motion)
        sensitivity = motion.transition @ sensitivity
        seen = sensor.matrix @ sensitivity
        belief, info = update(belief, np.zeros(sensor.matrix.shape[-2]), sensor)
        total = total + seen.T @ np.linalg.solve(info.innovation_cov, seen)
        sensitivity = sensitivity - info.gain @ seen
        history.append(_symmetric(total))
    return np.stack(history)


@checks.computable("start, motions and sensors")
def state_information(
    motions: Sequence[Motion],
    sensors: Sequence[Sensor],
    start: Float[np.ndarray, "n n"] | None = None,
) -> Float[np.ndarray, "steps n n"]:
    r"""Return the Fisher information of the measurements about the state as it is now.

    .. math::
        Y_k = \left(F_k Y_{k-1}^{-1} F_k^\top + Q_k\right)^{-1} + H_k^\top R_k^{-1} H_k

    A motion takes away from what is known, a measurement adds to it. :math:`Y_{k-1}` may be
    singular: with :math:`M = F_k^{-\top} Y_{k-1} F_k^{-1}` the first term is
    :math:`(I + M Q_k)^{-1} M`. With the inverse of a prior covariance as ``start``, :math:`Y_k` is
    the inverse of the filter's own covariance.

    Parameters
    ----------
    motions, sensors
        The steps, in order; each motion is followed by its measurement.
    start : (n, n), optional
        Information about the state before the first motion; none if left out.

    Returns
    -------
    (steps, n, n)
        :math:`Y_1, …, Y_k`.

    Raises
    ------
    ValueError
        If the sequences are empty, differ in length or in the number of states, ``start`` is no
        information, or a transition or the noise of a sensor is singular.

    References
    ----------
    Tichavský, Muravchik and Nehorai, "Posterior Cramér–Rao bounds for discrete-time nonlinear
    filtering", IEEE Transactions on Signal Processing 46(5), 1998.
    """
    motions = checks.instances("motions", motions, Motion)
    sensors = checks.instances("sensors", sensors, Sensor)
    if not motions or len(motions) != len(sensors):
        raise ValueError(f"need as many motions as sensors, got {len(motions)}, {len(sensors)}")
    n = motions[0].transition.shape[-1]
    Y = np.zeros((n, n)) if start is None else checks.covariance("start", start, (n, n))
    history = []
    for motion, sensor in zip(motions, sensors, strict=True):
        F, Q, H, R = motion.transition, motion.noise, sensor.matrix, sensor.noise
        if F.shape != (n, n) or H.shape[1:] != (n,):
            raise ValueError(
                f"motions and sensors must all be of {n} states, got {F.shape} and {H.shape}"
            )
        _log_determinant("noise of a sensor", R)
        if np.linalg.matrix_rank(F) < n:
            raise ValueError("motions: a transition is singular, it forgets a direction for good")
        M = np.linalg.solve(F.T, np.linalg.solve(F.T, Y).T)
        Y = np.linalg.solve(np.eye(n) + M @ Q, M)  # a motion
        Y = _symmetric(Y + H.T @ np.linalg.solve(R, H))  # a measurement
        history.append(Y)
    return np.stack(history)


LOST = "motion and sensor have a steady state that is lost to rounding"


@dataclass(frozen=True, eq=False, slots=True)
class SteadyState:
    """Steady state of the covariance of a time-invariant filter.

    Parameters
    ----------
    predicted, posterior : (n, n)
        Covariance before and after each update.
    innovation_cov : (m, m)
    gain : (n, m)
    poles : (n,)
        Eigenvalues of :math:`(I - K H) F`, largest modulus first. An error shrinks by the modulus
        of its pole at every step; a pole of modulus 1 belongs to a direction without plant noise,
        along which the covariance falls like 1/k and the gain settles at zero.
    """

    predicted: Float[np.ndarray, "n n"]
    posterior: Float[np.ndarray, "n n"]
    innovation_cov: Float[np.ndarray, "m m"]
    gain: Float[np.ndarray, "n m"]
    poles: np.ndarray

    @property
    def time_constant(self) -> float:
        """Steps in which the slowest error falls by the factor e; infinite if it never does."""
        slowest = float(np.abs(self.poles[0]))
        if slowest >= 1:
            return np.inf
        return -1 / math.log(slowest) if slowest > 0 else 0.0


@checks.computable("motion and sensor")
def steady_state(motion: Motion, sensor: Sensor, *, tolerance: float = 1e-13) -> SteadyState:
    r"""Return the limit of the Riccati recursion, by doubling.

    .. math:: P = F P F^\top - F P H^\top (H P H^\top + R)^{-1} H P F^\top + Q

    One doubling advances the recursion from :math:`2^j` to :math:`2^{j+1}` steps. It starts from a
    state that is known exactly; where a mode grows, from one that is not: without plant noise of
    its own such a mode would count as known for ever, and no filter could follow its error.

    Parameters
    ----------
    motion, sensor
        One time-invariant system (no batch axes); the sensor's noise must be regular.
    tolerance
        Relative change at which the doubling stops.

    Raises
    ------
    ValueError
        If the system has a direction that does not decay and is never seen (it is not
        detectable): then the limit depends on the initial covariance, or does not exist. Also if
        the limit is lost to rounding, as with many fast growing modes and a single sensor.

    References
    ----------
    Chu, Fan, Lin and Wang, "Structure-preserving algorithms for periodic discrete-time algebraic
    Riccati equations", International Journal of Control 77(8), 2004.
    """
    checks.instance("motion", motion, Motion)
    checks.instance("sensor", sensor, Sensor)
    tolerance = checks.positive("tolerance", tolerance)
    F, Q, H, R = motion.transition, motion.noise, sensor.matrix, sensor.noise
    if any(a.ndim != 2 for a in (F, Q, H, R)) or H.shape[1] != F.shape[0]:
        raise ValueError(
            f"need one system of one size, got a motion {F.shape} and a sensor {H.shape}"
        )
    _log_determinant("noise of the sensor", R)
    unseen = _unseen_directions(F, H)
    if unseen:
        raise ValueError(f"no unique steady state: {unseen} undamped direction(s) are never seen")
    n = len(F)
    A, G, X = F.T, H.T @ np.linalg.solve(R, H), Q
    start = np.zeros((n, n))
    if np.abs(np.linalg.eigvals(F)).max() > 1 + 1e-9:
        # the recursion of the difference from any start is one of the same form
        start = max(np.abs(Q).max(), 1 / np.abs(G).max()) * np.eye(n)
        step = np.linalg.solve(np.eye(n) + G @ start, np.hstack([A, G]))
        A, G, X = step[:, :n], _symmetric(step[:, n:]), _symmetric(F @ start @ step[:, :n] + Q)
        X = X - start
    for _ in range(100):
        step = np.linalg.solve(np.eye(n) + G @ X, np.hstack([A, G]))
        after_a, after_g = step[:, :n], step[:, n:]
        change = A.T @ X @ after_a
        A, G, X = A @ after_a, _symmetric(G + A @ after_g @ A.T), _symmetric(X + change)
        if np.abs(change).max() <= tolerance * np.abs(start + X).max():
            break
    X = start + X
    if not np.isfinite(X).all():
        raise ValueError(f"{LOST}: it is not finite")
    S = H @ X @ H.T + R
    K = np.linalg.solve(S, H @ X).T
    rest = np.eye(n) - K @ H
    poles = np.linalg.eigvals(rest @ F)
    poles = poles[np.argsort(-np.abs(poles))]
    if np.abs(poles[0]) > 1 + 1e-6:
        raise ValueError(f"{LOST}: a pole of modulus {np.abs(poles[0]):.3g} remains")
    return SteadyState(X, _symmetric(rest @ X @ rest.T + K @ R @ K.T), S, K, poles)


def scale_free_rank(matrix: Float[np.ndarray, "... n n"]) -> np.ndarray:
    r"""Return the rank of symmetric positive semi-definite matrices, whatever the units.

    Rows and columns are scaled to a unit diagonal first, so that metres and millimetres give the
    same rank; an eigenvalue counts if it exceeds :math:`8 n^2` times the rounding error.

    Parameters
    ----------
    matrix : (…, n, n)
        Symmetric positive semi-definite matrices in any units.

    Returns
    -------
    (…,) of int

    Raises
    ------
    ValueError
        If a matrix is not symmetric positive semi-definite.
    """
    matrix = checks.covariance("matrix", matrix)
    diagonal = np.diagonal(matrix, axis1=-2, axis2=-1)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    eigenvalues = np.linalg.eigvalsh(scale[..., :, None] * matrix * scale[..., None, :])
    n = matrix.shape[-1]
    return np.asarray((eigenvalues > 8 * n**2 * np.finfo(float).eps).sum(axis=-1))


def _apply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return (matrix @ vector[..., None])[..., 0]


def _symmetric(matrix: np.ndarray) -> np.ndarray:
    return (matrix + matrix.mT) / 2


def _log_determinant(name: str, S: np.ndarray) -> np.ndarray:
    """Return log det S, or raise ``ValueError`` if a matrix is not positive definite."""
    try:
        factor = np.linalg.cholesky(S)
    except np.linalg.LinAlgError:
        lowest = np.linalg.eigvalsh(S)[..., 0].min()
        raise ValueError(f"{name} is singular, smallest eigenvalue is {lowest:.3g}") from None
    return np.asarray(2 * np.log(np.diagonal(factor, axis1=-2, axis2=-1)).sum(axis=-1))


def _unseen_directions(F: np.ndarray, H: np.ndarray) -> int:
    """Count undamped directions of ``F`` that the sensor never sees (Popov, Belevitch, Hautus)."""
    unseen = 0
    for pole in np.linalg.eigvals(F):
        if abs(pole) >= 1 - 1e-9:
            stacked = np.vstack([pole * np.eye(len(F)) - F, H])
            unseen = max(unseen, len(F) - np.linalg.matrix_rank(stacked))
    return int(unseen)
