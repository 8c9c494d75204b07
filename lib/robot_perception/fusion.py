r"""Two beliefs about one state made into one, also where nobody knows how their errors correlate.

A rule takes two beliefs a and b about the same n numbers and returns one; leading axes are batches
and broadcast. With the cross-covariance :math:`C_{ab}` of the errors unknown, the covariance of a
result is *consistent* if it is no smaller than that of the result's error for every
:math:`C_{ab}` that the two covariances admit.

Equation numbers are those of Schaffernicht, Martin, Scheidig and Gross, section 3.2, whose i is our
a and whose j is our b: ω is the weight of b. Their eq. (3) prints :math:`\mu_{new}^{-1}` where the
mean :math:`\mu_{new}` is meant.

Numbers that are angles wrap: ``angles`` names their indices. The difference of two angles is taken
the short way round, and the angle of a result is in [-π, π).
"""

from collections.abc import Sequence
from typing import no_type_check

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.beliefs import Gaussian
from robot_perception.geometry import wrap_angle
from robot_perception.kernels import kernel

__all__ = [
    "covariance_intersection",
    "intersection_by_inverses",
    "inverse_covariance_intersection",
    "kalman_fusion",
    "omega_determinants",
    "omega_least_determinant",
    "omega_least_trace",
    "split_covariance_intersection",
]

SINGULAR = 1e-14
"""Share of a variance below which what is left of it is rounding."""

Weights = float | Float[np.ndarray, "..."]


def intersection_by_inverses(a: Gaussian, b: Gaussian, omega: Weights) -> Gaussian:
    r"""Return the covariance intersection by the right sides of eq. (3), with inverse matrices.

    The second of them is the new mean, not its inverse. `covariance_intersection` gives the same,
    faster, and also for ω = 0 and 1 with a covariance that has no inverse.

    Parameters
    ----------
    a, b
        Beliefs about the same state, both covariances regular.
    omega : (…)
        Weight ω of b, from 0 to 1.

    Raises
    ------
    ValueError
        If the shapes do not fit, a weight is not from 0 to 1, or a covariance is singular.

    References
    ----------
    Schaffernicht et al., eq. (3).
    """
    omega = _weights(a, b, omega)
    w = omega[..., None, None]
    Y_a, Y_b = (1 - w) * _inverse("a", a), w * _inverse("b", b)
    cov = np.linalg.inv(Y_a + Y_b)
    mean = cov @ (Y_a @ a.mean[..., None] + Y_b @ b.mean[..., None])
    return Gaussian(mean[..., 0], (cov + cov.mT) / 2)


def covariance_intersection(
    a: Gaussian, b: Gaussian, omega: Weights, *, angles: Sequence[int] = ()
) -> Gaussian:
    r"""Return a belief that is consistent whatever the correlation of the two errors.

    .. math::
        C^{-1} = (1 - \omega) C_a^{-1} + \omega C_b^{-1}, \qquad
        C^{-1} \mu = (1 - \omega) C_a^{-1} \mu_a + \omega C_b^{-1} \mu_b

    Computed without inverse matrices, with :math:`S = (1 - \omega) C_b + \omega C_a`:

    .. math::
        \mu = \mu_a + \omega C_a S^{-1} (\mu_b - \mu_a), \qquad
        C = (1 - \omega) C_b S^{-1} C_a S^{-1} C_b + \omega C_a S^{-1} C_b S^{-1} C_a

    Parameters
    ----------
    a, b
        Beliefs about the same state.
    omega : (…)
        Weight ω of b, from 0 to 1: 0 gives a, 1 gives b.
    angles
        Indices of the numbers that are angles, rad.

    Raises
    ------
    ValueError
        If the shapes do not fit, a weight is not from 0 to 1, an index is none, or S is singular
        where the weight is neither 0 nor 1.

    References
    ----------
    Schaffernicht et al., eq. (3); Julier and Uhlmann, "A non-divergent estimation algorithm in the
    presence of unknown correlations", American Control Conference 1997.
    """
    omega = _weights(a, b, omega)
    difference, angles = _difference(a, b, angles)
    n = difference.shape[-1]
    batch = np.broadcast_shapes(difference.shape[:-1], omega.shape, a.cov.shape[:-2])
    batch = np.broadcast_shapes(batch, b.cov.shape[:-2])
    shift, cov = np.empty((*batch, n)), np.empty((*batch, n, n))
    regular = _intersect(
        *(_flat(belief.cov, batch, (n, n)) for belief in (a, b)),
        _flat(difference, batch, (n,)),
        _flat(omega, batch, ()),
        shift.reshape(-1, n),
        cov.reshape(-1, n, n),
    )
    if not regular:
        raise ValueError("the covariances of a and b must have a regular sum, got a singular one")
    return Gaussian(_shifted(a, shift, angles), cov)


def kalman_fusion(a: Gaussian, b: Gaussian, *, angles: Sequence[int] = ()) -> Gaussian:
    r"""Return the belief that is right if the two errors are independent.

    .. math::
        K = C_a (C_a + C_b)^{-1}, \qquad \mu = \mu_a + K (\mu_b - \mu_a), \qquad
        C = (I - K) C_a (I - K)^\top + K C_b K^\top

    With correlated errors it is too sure of itself. Parameters are those of
    :func:`covariance_intersection`.

    Raises
    ------
    ValueError
        If the shapes do not fit, an index is none, or the sum of the covariances is singular.
    """
    difference, angles = _difference(a, b, angles)
    K = _gain(a.cov, b.cov)
    rest = np.eye(difference.shape[-1]) - K
    cov = rest @ a.cov @ rest.mT + K @ b.cov @ K.mT
    return Gaussian(_shifted(a, _apply(K, difference), angles), (cov + cov.mT) / 2)


def split_covariance_intersection(
    a: Gaussian,
    b: Gaussian,
    a_independent: Float[np.ndarray, "... n n"],
    b_independent: Float[np.ndarray, "... n n"],
    omega: Weights,
    *,
    angles: Sequence[int] = (),
) -> tuple[Gaussian, Float[np.ndarray, "... n n"]]:
    r"""Return the fusion of two beliefs, a part of whose errors is known to be independent.

    .. math::
        P_a = \frac{C_a - I_a}{1 - \omega} + I_a, \quad P_b = \frac{C_b - I_b}{\omega} + I_b, \quad
        K = P_a (P_a + P_b)^{-1}

    Without an independent part it is covariance intersection, and where all is independent it is
    the Kalman filter's fusion.

    Parameters
    ----------
    a, b
        Beliefs about the same state.
    a_independent, b_independent : (…, n, n)
        The parts :math:`I_a`, :math:`I_b` of their covariances that are of independent errors.
    omega : (…)
        Weight ω of b, between 0 and 1.
    angles
        Indices of the numbers that are angles, rad.

    Returns
    -------
    Gaussian
        The belief.
    (…, n, n)
        The part of its covariance that is of independent errors,
        :math:`(I - K) I_a (I - K)^\top + K I_b K^\top`.

    Raises
    ------
    ValueError
        If the shapes do not fit, a weight is not between 0 and 1, an index is none, a part is no
        covariance or exceeds the whole, or both beliefs are sure of the same number.

    References
    ----------
    Julier and Uhlmann, "General decentralized data fusion with covariance intersection", chapter 12
    of Hall and Llinas (eds), "Handbook of Multisensor Data Fusion", 2001.
    """
    w = _weights(a, b, omega)[..., None, None]
    if not ((w > 0) & (w < 1)).all():
        raise ValueError(f"omega must be between 0 and 1, got {checks.shown(omega)}")
    difference, angles = _difference(a, b, angles)
    I_a = _part("a_independent", a_independent, a)
    I_b = _part("b_independent", b_independent, b)
    P_a = (a.cov - I_a) / (1 - w) + I_a
    P_b = (b.cov - I_b) / w + I_b
    K = _gain(P_a, P_b)
    rest = np.eye(difference.shape[-1]) - K
    cov = rest @ P_a @ rest.mT + K @ P_b @ K.mT
    independent = rest @ I_a @ rest.mT + K @ I_b @ K.mT
    fused = Gaussian(_shifted(a, _apply(K, difference), angles), (cov + cov.mT) / 2)
    return fused, (independent + independent.mT) / 2


def inverse_covariance_intersection(
    a: Gaussian, b: Gaussian, omega: Weights, *, angles: Sequence[int] = ()
) -> Gaussian:
    r"""Return a fusion that is tighter than covariance intersection where both share information.

    .. math::
        \Gamma = \omega C_a + (1 - \omega) C_b, \qquad
        C^{-1} = C_a^{-1} + C_b^{-1} - \Gamma^{-1}, \qquad
        \mu = \mu_a + C \left( C_b^{-1} - (1 - \omega) \Gamma^{-1} \right) (\mu_b - \mu_a)

    It is consistent where the correlation comes from information that both beliefs contain, not
    for every correlation. Parameters are those of :func:`covariance_intersection`; both covariances
    must be regular.

    Raises
    ------
    ValueError
        If the shapes do not fit, a weight is not from 0 to 1, an index is none, or a covariance is
        singular.

    References
    ----------
    Noack, Sijs, Reinhardt and Hanebeck, "Decentralized data fusion with inverse covariance
    intersection", Automatica 79, 2017.
    """
    w = _weights(a, b, omega)[..., None, None]
    difference, angles = _difference(a, b, angles)
    Y_a, Y_b = _inverse("a", a), _inverse("b", b)
    common = np.linalg.inv(w * a.cov + (1 - w) * b.cov)
    cov = np.linalg.inv(Y_a + Y_b - common)
    shift = _apply(cov @ (Y_b - (1 - w) * common), difference)
    return Gaussian(_shifted(a, shift, angles), (cov + cov.mT) / 2)


def omega_determinants(a: Gaussian, b: Gaussian) -> Weights:
    r"""Return the weight of b by eq. (4).

    .. math:: \omega = \frac{|C_a|}{|C_a| + |C_b|}

    The belief of the smaller determinant has the larger weight, as the paper says. It also says
    that this ω makes the determinant of the result least. For two numbers that is so only if the
    determinants are equal, :math:`|C_a| = |C_b|`, or
    :math:`\operatorname{tr}(C_b^{-1} C_a) = 2 (1 + |C_a| / |C_b|)`. Otherwise the determinant is
    larger than it could be, without bound: for two beliefs each of which knows what the other does
    not it tends to :math:`(1 + q)^2 / 4q` times the least one, with q the quotient of the two
    determinants. It can even be larger than that of the better belief alone.

    Parameters
    ----------
    a, b
        Beliefs about the same state.

    Returns
    -------
    (…)
        One weight for each pair of covariances.

    Raises
    ------
    ValueError
        If the shapes do not fit or a covariance is singular.

    References
    ----------
    Schaffernicht et al., eq. (4).
    """
    _check_pair(a, b)
    log_ratio = _log_determinant("a", a) - _log_determinant("b", b)
    return (0.5 + 0.5 * np.tanh(log_ratio / 2))[()]  # the quotient without overflow


def omega_least_determinant(a: Gaussian, b: Gaussian) -> Weights:
    r"""Return the weight of b that makes the determinant of the covariance intersection least.

    With the eigenvalues :math:`\delta_k` of :math:`C_a^{-1} C_b` it is where

    .. math:: \sum_k \frac{\delta_k - 1}{(1 - \omega) \delta_k + \omega}

    is 0, or the end of [0, 1] where the sum does not change its sign. In two dimensions this is a
    linear equation; in others its root is bracketed. Where every ω is as good it is 1/2. It does
    not depend on the units. Parameters, returns and errors are those of :func:`omega_determinants`.
    """
    return _best_weights(a, b, 1)


def omega_least_trace(a: Gaussian, b: Gaussian) -> Weights:
    r"""Return the weight of b that makes the trace of the covariance intersection least.

    With :math:`C_a = T T^\top` and :math:`C_b = T \operatorname{diag}(\delta) T^\top` it is where

    .. math:: \sum_k \frac{\lVert t_k \rVert^2 \delta_k (\delta_k - 1)}
                          {((1 - \omega) \delta_k + \omega)^2}

    is 0, or the end of [0, 1] where the sum does not change its sign. In two dimensions this is a
    linear equation; in others its root is bracketed. Where every ω is as good it is 1/2. The trace
    adds squares of all numbers, so it depends on their units. Parameters, returns and
    errors are those of :func:`omega_determinants`.
    """
    return _best_weights(a, b, 2)


def _best_weights(a: Gaussian, b: Gaussian, power: int) -> Weights:
    n = _check_pair(a, b)
    batch = np.broadcast_shapes(a.cov.shape[:-2], b.cov.shape[:-2])
    omega = np.empty(batch)
    flat = (_flat(belief.cov, batch, (n, n)) for belief in (a, b))
    with checks.computable("covariances of a and b"):
        found = _search(*flat, power, omega.reshape(-1))
    if not found:
        raise ValueError("covariances of a and b must be positive definite, got a singular one")
    return omega[()]


def _check_pair(a: Gaussian, b: Gaussian, **more: tuple[int, ...]) -> int:
    """Check that two beliefs are of the same numbers, and return how many these are."""
    checks.instance("a", a, Gaussian)
    checks.instance("b", b, Gaussian)
    n = a.mean.shape[-1]
    if b.mean.shape[-1] != n or n == 0:
        sizes = f"{a.mean.shape} and {b.mean.shape}"
        raise ValueError(f"a and b must be of the same n >= 1 numbers, got {sizes}")
    covs = {"cov of a": a.cov.shape[:-2], "cov of b": b.cov.shape[:-2]}
    checks.check_batches(a=a.mean.shape[:-1], b=b.mean.shape[:-1], **covs, **more)
    return n


def _weights(a: Gaussian, b: Gaussian, omega: Weights) -> np.ndarray:
    """Check two beliefs and weights, and return these."""
    found = checks.array("omega", omega)
    if not ((found >= 0) & (found <= 1)).all():
        raise ValueError(f"omega must be from 0 to 1, got {checks.shown(omega)}")
    _check_pair(a, b, omega=found.shape)
    return found


def _part(name: str, value: np.ndarray, whole: Gaussian) -> np.ndarray:
    """Return the part of a covariance that is of independent errors."""
    n = whole.mean.shape[-1]
    part = checks.covariance(name, value, (..., n, n), f"mean {whole.mean.shape}")
    checks.check_batches(**{name: part.shape[:-2]}, cov=whole.cov.shape[:-2])
    rest = whole.cov - part
    size = np.abs(whole.cov).max(axis=(-2, -1))
    if (np.linalg.eigvalsh(rest)[..., 0] < -1e-9 * size).any():
        raise ValueError(f"{name} must not exceed the covariance it is a part of")
    return part


def _difference(a: Gaussian, b: Gaussian, angles: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Return b minus a, and which numbers are angles."""
    n = _check_pair(a, b)
    found = checks.integers("angles", angles, ("k",), 0)
    if (found >= n).any():
        raise ValueError(f"angles must be indices below {n}, got {checks.shown(angles)}")
    difference = b.mean - a.mean
    difference[..., found] = wrap_angle(difference[..., found])
    return difference, found


def _shifted(a: Gaussian, shift: np.ndarray, angles: np.ndarray) -> np.ndarray:
    mean = a.mean + shift
    mean[..., angles] = wrap_angle(mean[..., angles])
    return mean


def _gain(P: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """Return P (P + Q)⁻¹."""
    _root("the sum of the covariances of a and b", P + Q)
    return np.linalg.solve(P + Q, P).mT


def _inverse(name: str, belief: Gaussian) -> np.ndarray:
    _root(f"the covariance of {name}", belief.cov)
    return np.linalg.inv(belief.cov)


def _log_determinant(name: str, belief: Gaussian) -> np.ndarray:
    return np.asarray(2 * np.log(_root(f"the covariance of {name}", belief.cov)).sum(axis=-1))


def _root(what: str, matrix: np.ndarray) -> np.ndarray:
    """Return the diagonal of the Cholesky factor of a regular matrix."""
    try:
        root = np.diagonal(np.linalg.cholesky(matrix), axis1=-2, axis2=-1)
    except np.linalg.LinAlgError:
        root = np.zeros(matrix.shape[-1])
    if not (root**2 > SINGULAR * np.diagonal(matrix, axis1=-2, axis2=-1)).all():
        raise ValueError(f"{what} must be positive definite, got a singular one")
    return root


def _apply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return (matrix @ vector[..., None])[..., 0]


def _flat(value: np.ndarray, batch: tuple[int, ...], shape: tuple[int, ...]) -> np.ndarray:
    """Return a batch of arrays with one leading axis, for the compiled loops."""
    if value.shape != (*batch, *shape):
        value = np.broadcast_to(value, (*batch, *shape)).copy()  # writable, as the others are
    return np.ascontiguousarray(value).reshape(-1, *shape)


@kernel()
@no_type_check
def _factor(matrix, L):  # pragma: no cover - compiled
    """Write the lower Cholesky factor, and tell whether there is one."""
    n = matrix.shape[0]
    for i in range(n):
        for j in range(i + 1):
            total = matrix[i, j]
            for q in range(j):
                total -= L[i, q] * L[j, q]
            if i > j:
                L[i, j], L[j, i] = total / L[j, j], 0.0
            elif total > SINGULAR * matrix[i, i]:
                L[i, i] = np.sqrt(total)
            else:
                return False
    return True


@kernel()
@no_type_check
def _intersect(covs_a, covs_b, differences, omegas, shifts, covs):  # pragma: no cover - compiled
    """Write shift of the mean and covariance of each pair, and tell whether every S is regular."""
    n = covs_a.shape[1]
    S, L = np.empty((n, n)), np.empty((n, n))
    white_a, white_b, product = np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    for p in range(len(omegas)):
        w, A, B, C = omegas[p], covs_a[p], covs_b[p], covs[p]
        for i in range(n):
            for j in range(n):
                S[i, j] = (1 - w) * B[i, j] + w * A[i, j]
        if not _factor(S, L):
            if 0 < w < 1:
                return False
            for i in range(n):  # all weight is on one belief, whatever the other is
                shifts[p, i] = w * differences[p, i]
                for j in range(n):
                    C[i, j] = w * B[i, j] + (1 - w) * A[i, j]
            continue
        _solve(L, A, white_a)  # S⁻¹ A
        _solve(L, B, white_b)  # S⁻¹ B
        C[:] = 0.0
        _add_square(white_b, A, 1 - w, product, C)
        _add_square(white_a, B, w, product, C)
        for i in range(n):
            shifts[p, i] = 0.0
            for q in range(n):
                shifts[p, i] += w * white_a[q, i] * differences[p, q]
    return True


@kernel()
@no_type_check
def _solve(L, matrix, out):  # pragma: no cover - compiled
    """Write (L Lᵀ)⁻¹ times a matrix."""
    n = L.shape[0]
    for j in range(n):
        for i in range(n):
            total = matrix[i, j]
            for q in range(i):
                total -= L[i, q] * out[q, j]
            out[i, j] = total / L[i, i]
        for i in range(n - 1, -1, -1):
            total = out[i, j]
            for q in range(i + 1, n):
                total -= L[q, i] * out[q, j]
            out[i, j] = total / L[i, i]


@kernel()
@no_type_check
def _add_square(X, M, weight, product, out):  # pragma: no cover - compiled
    """Add weight times Xᵀ M X, symmetric to the last bit."""
    n = X.shape[0]
    for i in range(n):
        for j in range(n):
            product[i, j] = 0.0
            for q in range(n):
                product[i, j] += M[i, q] * X[q, j]
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for q in range(n):
                total += X[q, i] * product[q, j]
            out[i, j] += weight * total
            if i != j:
                out[j, i] = out[i, j]


@kernel()
@no_type_check
def _diagonalise(A, B, T, M, delta):  # pragma: no cover - compiled
    """Write T and δ with A = T Tᵀ and B = T diag(δ) Tᵀ; tell whether A and B are regular.

    Jacobi's rotations of L⁻¹ B L⁻ᵀ, where A = L Lᵀ: each makes one entry 0, and in two dimensions
    one is enough.
    """
    n = A.shape[0]
    if not _factor(B, T) or not _factor(A, T):
        return False
    for j in range(n):  # M = L⁻¹ B
        for i in range(n):
            total = B[i, j]
            for q in range(i):
                total -= T[i, q] * M[q, j]
            M[i, j] = total / T[i, i]
    for i in range(n):  # M = M L⁻ᵀ
        for j in range(n):
            total = M[i, j]
            for q in range(j):
                total -= T[j, q] * M[i, q]
            M[i, j] = total / T[j, j]
    for _ in range(30):
        turned = False
        for i in range(n):
            for j in range(i + 1, n):
                entry = M[i, j]
                if abs(entry) <= 1e-16 * np.sqrt(M[i, i] * M[j, j]):
                    continue
                turned = True
                tau = (M[j, j] - M[i, i]) / (2 * entry)
                t = 1 / (abs(tau) + np.sqrt(1 + tau * tau))
                t = t if tau >= 0 else -t
                c = 1 / np.sqrt(1 + t * t)
                s = c * t
                for q in range(n):
                    M[q, i], M[q, j] = c * M[q, i] - s * M[q, j], s * M[q, i] + c * M[q, j]
                    T[q, i], T[q, j] = c * T[q, i] - s * T[q, j], s * T[q, i] + c * T[q, j]
                for q in range(n):
                    M[i, q], M[j, q] = c * M[i, q] - s * M[j, q], s * M[i, q] + c * M[j, q]
                M[i, j] = M[j, i] = 0.0
        if not turned:
            break
    for k in range(n):
        delta[k] = M[k, k]
        if not delta[k] > 0:
            return False
    return True


@kernel()
@no_type_check
def _slope(w, factors, delta, power):  # pragma: no cover - compiled
    """Return the sum of which the best weight is the root, and its derivative."""
    value, derivative = 0.0, 0.0
    for k in range(delta.size):
        below = (1 - w) * delta[k] + w
        term = factors[k] / below**power
        value += term
        derivative += power * term * (delta[k] - 1) / below
    return value, derivative


@kernel()
@no_type_check
def _balance(factors, delta, power):  # pragma: no cover - compiled
    """Return where the sum, which rises with the weight, is 0; the nearer end if nowhere."""
    if np.abs(delta - 1).max() <= 1e-12:
        return 0.5
    first, _ = _slope(0.0, factors, delta, power)
    last, _ = _slope(1.0, factors, delta, power)
    if first >= 0:
        return 0.0
    if last <= 0:
        return 1.0
    if delta.size == 2:
        ratio = (-factors[0] / factors[1]) ** (1 / power)
        w = (ratio * delta[1] - delta[0]) / ((1 - delta[0]) - ratio * (1 - delta[1]))
        return min(max(w, 0.0), 1.0)
    low, high, w = 0.0, 1.0, 0.5
    for _ in range(200):
        value, derivative = _slope(w, factors, delta, power)
        if value < 0:
            low = w
        else:
            high = w
        step = w - value / derivative
        step = step if low < step < high else (low + high) / 2
        if abs(step - w) <= 1e-16 + 4e-16 * w:
            return step
        w = step
    return w


@kernel()
@no_type_check
def _search(covs_a, covs_b, power, omegas):  # pragma: no cover - compiled
    """Write the weight of each pair; tell whether all covariances are regular."""
    n = covs_a.shape[1]
    T, M, delta, factors = np.empty((n, n)), np.empty((n, n)), np.empty(n), np.empty(n)
    for p in range(len(omegas)):
        if not _diagonalise(covs_a[p], covs_b[p], T, M, delta):
            return False
        for k in range(n):
            factors[k] = delta[k] - 1
            if power == 2:
                factors[k] *= delta[k] * (T[:, k] ** 2).sum()
        omegas[p] = _balance(factors, delta, power)
    return True
