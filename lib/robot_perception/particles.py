r"""Particle filters: the effective number of particles, resampling, and one step of three filters.

A step takes a set of M particles, the functions that move and weigh them, and a generator, and
returns the set after the measurement:

``step(prior, …, log_likelihood, *, rng) -> (ParticleSet, StepInfo)``

The functions get all states (M, n) at once. A resampling scheme draws with replacement, particle i
on average :math:`N \omega_i` times in N draws; schemes differ in how far the numbers scatter.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, no_type_check, runtime_checkable

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.beliefs import ParticleSet, normalise
from robot_perception.kernels import kernel

States = Float[np.ndarray, "m n"]
Logarithms = Float[np.ndarray, "m"]
MOST_DRAWS = 10**8
"""More are no question of particles but of memory."""

Move = Callable[[States, np.random.Generator], States]
LogLikelihood = Callable[[States], Logarithms]


@runtime_checkable
class Scheme(Protocol):
    """Resampling scheme of a step."""

    def __call__(
        self, weights: Float[np.ndarray, "m"], count: int, *, rng: np.random.Generator
    ) -> Int[np.ndarray, "count"]:
        """Return the indices of the particles drawn."""


@dataclass(frozen=True, eq=False, slots=True)
class StepInfo:
    r"""Diagnostics of one step.

    Parameters
    ----------
    effective
        Effective number of particles once they were weighed, before any resampling that follows.
    resampled
        Whether particles were drawn anew in this step.
    ancestors : (M,)
        From which particle of the prior each new one comes.
    log_evidence
        Logarithm of the estimate of :math:`p(z_t \mid z_{1:t-1})`. The product of the estimates
        over all steps is unbiased for :math:`p(z_{1:t})`; its logarithm is not.
    """

    effective: float
    resampled: bool
    ancestors: Int[np.ndarray, "m"]
    log_evidence: float


def effective_number(
    log_weights: Float[np.ndarray, "*sets m"] | ParticleSet,
) -> float | Float[np.ndarray, "*sets"]:
    r"""Return how many particles of equal weight would be worth as much.

    .. math:: M_{\mathrm{eff}} = \frac{(\sum_i \omega_i)^2}{\sum_i \omega_i^2}

    It lies between 1 and M. Eq. (7) of [1] prints :math:`1 / \sum_i \omega_i`, which is 1 for any
    normalised weights.

    Parameters
    ----------
    log_weights : (…, M) or ParticleSet
        Logarithms of the weights, but for a constant.

    Raises
    ------
    ValueError
        If there is no weight, a logarithm is NaN or infinite, or all weights of a set are 0.

    References
    ----------
    Kong, Liu and Wong, "Sequential imputations and Bayesian missing data problems", Journal of the
    American Statistical Association 89(425), 1994.

    [1] Gil, Payá, Reinoso, Fernández and Puerto, "Simultaneous localization and mapping in indoor
    environments using SIFT features", VIIP 2006.
    """
    if isinstance(log_weights, ParticleSet):
        log_weights = log_weights.log_weights
    return np.exp(-normalise(2 * normalise(log_weights)[0])[1])[()]


def systematic(
    weights: Float[np.ndarray, "m"], count: int, *, rng: np.random.Generator
) -> Int[np.ndarray, "count"]:
    r"""Return which particles an evenly spaced comb with one random offset picks.

    .. math:: u_k = (k + U) / N, \qquad U \sim \mathcal U[0, 1)

    Teeth :math:`u_k` are laid on the cumulative sum of the weights: particle i comes
    :math:`\lfloor N \omega_i \rfloor` or :math:`\lceil N \omega_i \rceil` times. One random number
    serves all.

    Parameters
    ----------
    weights : (M,)
        Weights, not negative; their sum need not be 1.
    count
        Number N of draws.
    rng
        Source of randomness.

    Returns
    -------
    (N,)
        Indices of the particles drawn, ascending; a weight of 0 is never drawn.

    Raises
    ------
    ValueError
        If a weight is negative or NaN, their sum is 0 or infinite, or the count is below 1 or above
        a hundred million.

    References
    ----------
    Kitagawa, "Monte Carlo filter and smoother for non-Gaussian nonlinear state space models",
    Journal of Computational and Graphical Statistics 5(1), 1996, appendix.
    """
    weights, total, count = _checked(weights, count, rng)
    return _comb(weights, total, np.broadcast_to(rng.random(), count), _places(count))


def stratified(
    weights: Float[np.ndarray, "m"], count: int, *, rng: np.random.Generator
) -> Int[np.ndarray, "count"]:
    r"""Return which particles are hit by one random point in each of N equal strata.

    .. math:: u_k = (k + U_k) / N, \qquad U_k \sim \mathcal U[0, 1)

    Parameters, returns and errors are those of `systematic`.

    References
    ----------
    Kitagawa 1996 (see `systematic`), appendix.
    """
    weights, total, count = _checked(weights, count, rng)
    return _comb(weights, total, rng.random(count), _places(count))


def multinomial(
    weights: Float[np.ndarray, "m"], count: int, *, rng: np.random.Generator
) -> Int[np.ndarray, "count"]:
    r"""Return N particles drawn independently of each other.

    The points are drawn in ascending order, as partial sums of N + 1 exponential variables over
    their total, so that no sorting is needed.

    Parameters, returns and errors are those of `systematic`.

    References
    ----------
    Gordon, Salmond and Smith, "Novel approach to nonlinear/non-Gaussian Bayesian state estimation",
    IEE Proceedings F 140(2), 1993.
    """
    weights, total, count = _checked(weights, count, rng)
    return _inverse(weights, total, _ordered_uniform(count, rng))


def residual(
    weights: Float[np.ndarray, "m"], count: int, *, rng: np.random.Generator
) -> Int[np.ndarray, "count"]:
    r"""Return the whole part of each expected number for certain, and the rest drawn independently.

    .. math::
        n_i = \lfloor N \omega_i \rfloor, \qquad
        \bar\omega_i \propto N \omega_i - n_i

    The factor N of the second formula matters: with :math:`\omega_i - n_i`, which filterpy's
    ``residual_resample`` has, the draw is biased.

    Parameters, returns and errors are those of `systematic`.

    References
    ----------
    Liu and Chen, "Sequential Monte Carlo methods for dynamic systems", Journal of the American
    Statistical Association 93(443), 1998, section 3.2.
    """
    weights, total, count = _checked(weights, count, rng)
    expected = count * (weights / total)
    copies = np.floor(expected * (1 + 1e-13))  # 3 that came out as 2.9999999999999996 is 3
    rest = count - int(copies.sum())
    copies = copies.astype(np.int64)
    if rest:
        left = np.maximum(expected - copies, 0)
        drawn = _inverse(left, left.sum(), _ordered_uniform(rest, rng))
        copies += np.bincount(drawn, minlength=copies.size)
    return np.repeat(np.arange(copies.size), copies)


def condensation(
    prior: ParticleSet,
    move: Move,
    log_likelihood: LogLikelihood,
    *,
    rng: np.random.Generator,
    scheme: Scheme = systematic,
) -> tuple[ParticleSet, StepInfo]:
    r"""Return the particles after one step of the condensation algorithm: draw, move, weigh.

    .. math::
        a_i \sim \omega_{t-1}, \qquad x_t^i \sim p(x_t \mid x_{t-1}^{a_i}), \qquad
        \omega_t^i \propto p(z_t \mid x_t^i)

    Parameters
    ----------
    prior
        One set of M particles.
    move
        Function of states (M, n) and a generator that returns a draw of the next state of each.
    log_likelihood
        Function of states (M, n) that returns :math:`\log p(z_t \mid x)` of each; -inf where the
        measurement is impossible.
    rng
        Source of randomness.
    scheme
        How the particles are drawn: `systematic`, `stratified`, `residual`, `multinomial`, or
        another function of that kind.

    Returns
    -------
    ParticleSet
        Particles after the measurement, weighted.
    StepInfo

    Raises
    ------
    ValueError
        If the prior is a batch, a function returns arrays of another shape, a state that is not
        finite, a log likelihood that is NaN or infinite, or if it is -inf for all particles.

    References
    ----------
    Isard and Blake, "Condensation - conditional density propagation for visual tracking",
    International Journal of Computer Vision 29(1), 1998, figure 6.
    """
    _check_step(prior, rng, scheme, move=move, log_likelihood=log_likelihood)
    ancestors = _drawn(scheme, prior.weights, rng)
    states = _moved(move, prior.states[ancestors], rng)
    posterior, log_sum = _weighed(states, _logs("log_likelihood", log_likelihood(states), states))
    return posterior, _info(posterior, True, ancestors, log_sum - np.log(len(states)))


def importance(
    prior: ParticleSet,
    move: Move,
    log_likelihood: LogLikelihood,
    *,
    rng: np.random.Generator,
    share: float = 0.5,
    log_ratio: Callable[[States, States], Logarithms] | None = None,
    scheme: Scheme = systematic,
) -> tuple[ParticleSet, StepInfo]:
    r"""Return the particles after one step of importance sampling with selective resampling.

    .. math::
        x_t^i \sim q(x_t \mid x_{t-1}^i, z_t), \qquad
        \omega_t^i \propto \omega_{t-1}^i \, p(z_t \mid x_t^i) \,
        \frac{p(x_t^i \mid x_{t-1}^i)}{q(x_t^i \mid x_{t-1}^i, z_t)}

    The particles are drawn anew only when their effective number falls below a share of M. Without
    ``log_ratio`` the proposal q is the motion itself: the bootstrap filter.

    Parameters
    ----------
    prior, log_likelihood, rng, scheme
        As in `condensation`.
    move
        Function of states (M, n) and a generator that returns a draw from q for each.
    share
        The particles are drawn anew if their effective number is below this share of M, from 0
        (never) to 1.
    log_ratio
        Function of the states before and after that returns :math:`\log p - \log q` of each; given
        where ``move`` does not draw from the motion.

    Returns
    -------
    ParticleSet
        Particles after the measurement; of equal weights where they were drawn anew.
    StepInfo

    Raises
    ------
    ValueError
        As `condensation`; also if the share is not from 0 to 1 or a ``log_ratio`` is NaN or
        infinite.

    References
    ----------
    Doucet, Godsill and Andrieu, "On sequential Monte Carlo sampling methods for Bayesian
    filtering", Statistics and Computing 10, 2000, section II.
    """
    _check_step(prior, rng, scheme, move=move, log_likelihood=log_likelihood)
    share = checks.share("share", share)
    states = _moved(move, prior.states, rng)
    logs = prior.log_weights + _logs("log_likelihood", log_likelihood(states), states)
    if log_ratio is not None:
        checks.instance("log_ratio", log_ratio, Callable)
        logs = logs + _logs("log_ratio", log_ratio(prior.states, states), states)
    posterior, log_sum = _weighed(states, logs)
    info = _info(posterior, False, np.arange(len(states)), log_sum)
    if info.effective >= share * len(states):
        return posterior, info
    ancestors = _drawn(scheme, posterior.weights, rng)
    info = StepInfo(info.effective, True, ancestors, info.log_evidence)
    return ParticleSet.uniform(states[ancestors]), info


def auxiliary(
    prior: ParticleSet,
    move: Move,
    expect: Callable[[States], States],
    log_likelihood: LogLikelihood,
    *,
    rng: np.random.Generator,
    scheme: Scheme = systematic,
    ahead: LogLikelihood | None = None,
) -> tuple[ParticleSet, StepInfo]:
    r"""Return the particles after one step of the auxiliary filter: look ahead, draw, move, weigh.

    .. math::
        a_i \sim \omega_{t-1} \, g(\mu_t), \qquad
        x_t^i \sim p(x_t \mid x_{t-1}^{a_i}), \qquad
        \omega_t^i \propto \frac{p(z_t \mid x_t^i)}{g(\mu_t^{a_i})}

    with :math:`g(\mu) = p(z_t \mid \mu)`, or any cheaper function of that kind.

    Particles that the measurement will favour are drawn before they move, with :math:`\mu_t` a
    likely next state of each, such as its mean. Where the likelihood at :math:`\mu_t` says nothing
    of that at :math:`x_t`, as when the motion scatters widely, the weights are worse than those of
    `condensation`.

    Parameters
    ----------
    prior, move, log_likelihood, rng, scheme
        As in `condensation`.
    expect
        Function of states (M, n) that returns :math:`\mu_t` of each.
    ahead
        Function of states (M, n) that returns :math:`\log g` of each; the log likelihood if none is
        given.

    Raises
    ------
    ValueError
        As `condensation`, of ``expect`` and ``ahead`` too.

    References
    ----------
    Pitt and Shephard, "Filtering via simulation: auxiliary particle filters", Journal of the
    American Statistical Association 94(446), 1999, section 3.2.
    """
    _check_step(prior, rng, scheme, move=move, expect=expect, log_likelihood=log_likelihood)
    likely = checks.array("expect(states)", expect(prior.states), prior.states.shape)
    if ahead is None:
        first_logs = _logs("log_likelihood", log_likelihood(likely), likely)
    else:
        checks.instance("ahead", ahead, Callable)
        first_logs = _logs("ahead", ahead(likely), likely)
    first, first_sum = _weighed(likely, prior.log_weights + first_logs)
    ancestors = _drawn(scheme, first.weights, rng)
    states = _moved(move, prior.states[ancestors], rng)
    logs = _logs("log_likelihood", log_likelihood(states), states) - first_logs[ancestors]
    posterior, log_sum = _weighed(states, logs)
    return posterior, _info(posterior, True, ancestors, first_sum + log_sum - np.log(len(states)))


def _checked(
    weights: np.ndarray, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, float, int]:
    """Check the arguments of a resampling scheme; return the weights, their sum and the count."""
    weights = checks.reals("weights", weights)
    checks.shaped("weights", weights, ("m",))
    if not weights.size:
        raise ValueError("weights must not be empty")
    lowest, total = weights.min(), weights.sum()
    if not (lowest >= 0 and 0 < total < np.inf):
        raise ValueError(
            "weights must not be negative, with a finite sum above 0, "
            f"got a least weight of {lowest:.6g} and a sum of {total:.6g}"
        )
    if total < 1e-200:  # whose reciprocal may overflow
        weights = weights / total
        total = weights.sum()
    checks.generator("rng", rng)
    count = checks.whole("count", count, 1)
    return weights, total, checks.whole("count", count, 1, MOST_DRAWS)


def _ordered_uniform(count: int, rng: np.random.Generator) -> np.ndarray:
    """Return so many independent points of [0, 1) in ascending order."""
    sums = np.cumsum(rng.standard_exponential(count + 1))
    return sums[:-1] / sums[-1]


def _places(count: int) -> np.ndarray:
    """Return room for what `_comb` draws; NumPy asks for large pages of memory, numba does not."""
    return np.empty(count + 4, dtype=np.int64)


@kernel()
@no_type_check
def _comb(weights, total, offsets, drawn):  # pragma: no cover - compiled
    """Return what `_inverse` does for the points (k + offset of k) / N, one in each N-th of [0, 1).

    So many points lie below a cumulative sum that no search is needed. The first four places are
    written whether or not they belong to the particle, the next one writes over what does not: a
    loop of unknown length costs three times as much, as the processor cannot foresee its end. So
    there are four more places than points.
    """
    count = offsets.size
    density = count / total
    k, reached = 0, 0.0
    for i in range(weights.size):
        reached += weights[i]
        teeth = min(float(count), reached * density)
        below = int(teeth)
        below = below + (offsets[below] < teeth - below) if below < count else count
        drawn[k], drawn[k + 1], drawn[k + 2], drawn[k + 3] = i, i, i, i
        for rest in range(k + 4, below):
            drawn[rest] = i
        k = below
    drawn[k:] = _last(weights)
    return drawn[:count]


@kernel()
@no_type_check
def _inverse(weights, total, points):  # pragma: no cover - compiled
    """Return for each ascending point of [0, 1) the first particle whose cumulative sum is above.

    Above, not at it: a particle without weight is not drawn, not even by a point on the edge.
    """
    last = _last(weights)
    drawn = np.empty(points.size, dtype=np.int64)
    particle, reached = 0, weights[0]
    for k in range(points.size):
        while reached <= points[k] * total and particle < last:
            particle += 1
            reached += weights[particle]
        drawn[k] = particle
    return drawn


@kernel()
@no_type_check
def _last(weights):  # pragma: no cover - compiled
    """Return the last particle with a weight: it takes the points that rounding leaves above."""
    last = weights.size - 1
    while weights[last] == 0:
        last -= 1
    return last


def _check_step(
    prior: ParticleSet, rng: np.random.Generator, scheme: Scheme, **functions: Callable
) -> None:
    """Check what all steps are given."""
    if checks.instance("prior", prior, ParticleSet).log_weights.ndim != 1 or prior.states.ndim != 2:
        raise ValueError(f"prior must be one set of particles, got states {prior.states.shape}")
    for name, function in functions.items():
        checks.instance(name, function, Callable)
    checks.generator("rng", rng)
    checks.instance("scheme", scheme, Scheme)


def _moved(move: Move, states: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return checks.array("move(states, rng)", move(states, rng), states.shape)


def _drawn(scheme: Scheme, weights: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    ancestors = checks.integers(
        "scheme(weights, count)", scheme(weights, weights.size, rng=rng), weights.shape, 0
    )
    if ancestors.max() >= weights.size:
        raise ValueError(f"scheme must draw from {weights.size} particles, got {ancestors.max()}")
    empty = np.count_nonzero(weights[ancestors] == 0)
    if empty:
        raise ValueError(f"scheme must not draw a particle without weight, got {empty}")
    return ancestors


def _logs(name: str, logs: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Check what a function returned for states: a logarithm each, finite or -inf."""
    logs = checks.array(f"{name}(states)", logs, (len(states),), finite=False)
    bad = np.count_nonzero(np.isnan(logs) | (logs == np.inf))
    if bad:
        raise ValueError(f"{name} must be finite or -inf, got {bad} of {logs.size} otherwise")
    return logs


def _weighed(states: np.ndarray, logs: np.ndarray) -> tuple[ParticleSet, float]:
    """Return states with weights, and the logarithm of the sum of the weights."""
    if (logs == -np.inf).all():
        raise ValueError(
            f"log_likelihood is -inf for all {logs.size} particles that have a weight: "
            "none of them can have made the measurement"
        )
    return ParticleSet(states, logs), float(normalise(logs)[1])


def _info(
    posterior: ParticleSet, resampled: bool, ancestors: np.ndarray, log_evidence: float
) -> StepInfo:
    effective = float(effective_number(posterior))
    return StepInfo(effective, resampled, ancestors, float(log_evidence))
