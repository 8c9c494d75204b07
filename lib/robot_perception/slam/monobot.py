r"""The monobot: a robot on a line that measures its distance to n landmarks, SLAM in 1-D.

The state is :math:`x = (r, f_1, …, f_n)`, vehicle first, in metres. Step 0 is the first
measurement, which puts the landmarks into the map. In every later step the vehicle moves (predict)
and then measures (update).

References
----------
Andrade-Cetto, "Perception Issues in Mobile Robotics", section 2.2, eqs (1) to (23), Figs 3 to 6.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, no_type_check

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.beliefs import Gaussian
from robot_perception.fields import checked, double
from robot_perception.kalman import Motion, Sensor, predict, update
from robot_perception.kernels import kernel

VarianceLike = float | np.ndarray
MOST_LANDMARKS = 10_000
SINGULAR = (
    "innovation covariance is singular: measurement_variance is 0, or nothing beside"
    " motion_variance"
)


def sensor_matrix(landmarks: int) -> Float[np.ndarray, "n states"]:
    r"""Return the measurement matrix: a distance is the landmark's position minus the vehicle's.

    .. math:: H = [-\mathbf 1 \mid I]

    Parameters
    ----------
    landmarks
        Number n of landmarks, at least 1.

    Returns
    -------
    (n, n + 1)

    Raises
    ------
    ValueError
        If there is no landmark.
    """
    n = _counted(landmarks)
    return np.hstack([-np.ones((n, 1)), np.eye(n)])


def motion(command: float, motion_variance: float, landmarks: int) -> Motion:
    r"""Return the motion model of one step: the vehicle moves, the landmarks stay.

    .. math:: F = I, \qquad b = (u, 0, …, 0), \qquad Q = \operatorname{diag}(V, 0, …, 0)

    Parameters
    ----------
    command
        :math:`u`, m.
    motion_variance
        :math:`V`, m².
    landmarks
        Number n of landmarks, at least 1.

    Raises
    ------
    ValueError
        If there is no landmark or the variance is negative.

    References
    ----------
    Andrade-Cetto, eq. (19).
    """
    variance = checks.not_negative("motion_variance", motion_variance)
    eye = np.eye(_counted(landmarks) + 1)
    shift = checks.number("command", command) * eye[0]
    return Motion(eye, variance * np.outer(eye[0], eye[0]), shift)


def first_measurement(
    start: Gaussian, measurement: Float[np.ndarray, "... n"], measurement_variance: VarianceLike
) -> Gaussian:
    r"""Return the belief after the first measurement, which puts the landmarks into the map.

    .. math::
        \hat f_i = \hat r + z_i, \qquad
        P = \begin{bmatrix} P_r & P_r \mathbf 1^\top \\ P_r \mathbf 1 & P_r \mathbf{11}^\top + W
        \end{bmatrix}

    A landmark inherits the whole error of the vehicle that measured it. Without the off-diagonal
    blocks, the filter would take this common error for independent ones.

    Parameters
    ----------
    start
        Belief about the vehicle alone, one state, m.
    measurement : (…, n)
        Measured distances z, m.
    measurement_variance : (…, n) or number
        Their variances, the diagonal of W, m².

    Returns
    -------
    Gaussian
        Belief about vehicle and landmarks, n + 1 states.

    Raises
    ------
    ValueError
        If there is no landmark, a shape is wrong, or a variance is negative.
    """
    _check_start(start)
    z = checks.array("measurement", measurement, (..., "n"))
    W = _variances("measurement_variance", measurement_variance)
    n = _counted(z.shape[-1], "measurement")
    if W.shape[-1:] not in {(), (1,), (n,)}:
        raise ValueError(
            f"measurement_variance must be (…, {n}) for measurement {z.shape}, got {W.shape}"
        )
    checks.check_batches(
        start=start.mean.shape[:-1], measurement=z.shape[:-1], measurement_variance=W.shape[:-1]
    )
    mean = start.mean + np.insert(z, 0, 0.0, axis=-1)
    W = np.broadcast_to(W, (*W.shape[:-1], n))
    own = np.insert(W, 0, 0.0, axis=-1)[..., None] * np.eye(n + 1)
    return Gaussian(mean, start.cov + own)


def _sign(name: str, value: object) -> int:
    """Return a sign, or raise ``ValueError``."""
    sign = checks.whole(name, value)
    if sign not in (-1, 1):
        raise ValueError(f"{name} must be -1 (anchor) or 1 (external sensor), got {sign}")
    return sign


def _variance_or_variances(name: str, value: VarianceLike) -> VarianceLike:
    """Return a variance as a number, several as an array; raise ``ValueError`` if one is < 0."""
    variance = _variances(name, value)
    return variance if variance.ndim else float(variance)


@dataclass(frozen=True, eq=False, slots=True)
class Reference:
    r"""A sensor that ties the rail to the world: :math:`z^{(0)} = s\,(r - a) + w^{(0)}`.

    Parameters
    ----------
    sign
        :math:`s`: −1 if the vehicle measures its distance to an anchor at :math:`a`, eq. (20);
        +1 if a fixed sensor at :math:`a` measures the vehicle, eq. (23).
    values : (runs, steps)
        :math:`z^{(0)}` after each move, m.
    variance : number, (steps,) or (runs, steps)
        Variance of its noise :math:`w^{(0)}`, m².
    position
        :math:`a`, m: where the filter takes the anchor or sensor to be.

    Raises
    ------
    ValueError
        If a variance is negative.

    References
    ----------
    Andrade-Cetto, eqs (20) and (23).
    """

    sign: Annotated[Literal[-1, 1], _sign]
    values: Annotated[Float[np.ndarray, "runs steps"], double]
    variance: Annotated[VarianceLike, _variance_or_variances]
    position: float = 0.0
    __post_init__ = checked

    def matrix(self, landmarks: int) -> Float[np.ndarray, "rows states"]:
        r"""Return the measurement matrix with the row of the reference on top.

        .. math:: H = \begin{bmatrix} s & \mathbf 0 \\ -\mathbf 1 & I \end{bmatrix}

        Parameters
        ----------
        landmarks
            Number n of landmarks, at least 1.

        Returns
        -------
        (n + 1, n + 1)
        """
        matrix = np.insert(sensor_matrix(landmarks), 0, 0.0, axis=0)
        matrix[0, 0] = self.sign
        return matrix


@dataclass(frozen=True, eq=False, slots=True)
class MonobotRun:
    """Estimates of the filter at all steps of a batch of runs.

    Covariances do not depend on the data. If the noise is the same for all runs, they are stored
    once: their leading axis is 1 and broadcasts against the runs. A measurement has m = n numbers,
    or m = n + 1 with a reference, which comes first.

    Parameters
    ----------
    means : (runs, steps + 1, n + 1)
        Estimates after each measurement, m; step 0 is the first measurement.
    covs : (runs or 1, steps + 1, n + 1, n + 1)
        Their covariances, m².
    innovations : (runs, steps, m)
        Measured minus predicted distances, m.
    innovation_covs : (runs or 1, steps, m, m)
        Their covariances :math:`S`, eq. (8), m².
    gains : (runs or 1, steps, n + 1, m)
        Kalman gains :math:`K`, eq. (7).
    """

    means: Float[np.ndarray, "runs measurements states"]
    covs: Float[np.ndarray, "covs measurements states states"]
    innovations: Float[np.ndarray, "runs steps m"]
    innovation_covs: Float[np.ndarray, "covs steps m m"]
    gains: Float[np.ndarray, "covs steps states m"]

    @property
    def deviations(self) -> Float[np.ndarray, "covs measurements states"]:
        """Standard deviations of vehicle and landmarks, m."""
        return np.sqrt(np.diagonal(self.covs, axis1=-2, axis2=-1))


def run_filter(
    start: Gaussian,
    commands: Float[np.ndarray, "steps"],
    measurements: Float[np.ndarray, "runs measurements n"],
    *,
    motion_variance: VarianceLike,
    measurement_variance: VarianceLike,
) -> MonobotRun:
    """Run the filter over many runs at once, by compiled loops.

    It returns the same numbers as :func:`run_filter_stepwise`, which is slower and easier to read.

    Parameters
    ----------
    start
        Belief about the vehicle before the first measurement, one state; a leading axis of runs is
        allowed.
    commands : (steps,)
        Commanded displacements, m.
    measurements : (runs, steps + 1, n)
        Measured distances, m; the first of each run puts the landmarks into the map.
    motion_variance : number, (steps,) or (runs, steps)
        Variance V of the motion noise (plant noise), m².
    measurement_variance : number, (steps + 1, n) or (runs, steps + 1, n)
        Variance W of the measurement noise, m².

    Raises
    ------
    ValueError
        If there is no landmark, a shape is wrong, a number is not finite, a variance is negative,
        or an innovation covariance is singular.
    """
    start, commands, z, V, W = _checked(
        start, commands, measurements, motion_variance, measurement_variance
    )
    runs = z.shape[0]
    batch = max(start.cov.shape[0], V.shape[0], W.shape[0])
    P0 = np.ascontiguousarray(np.broadcast_to(start.cov[:, 0, 0], (batch,)))
    covs, innovation_covs, gains, regular = _covariance_kernel(P0, V, W)
    if not regular:
        raise ValueError(SINGULAR)
    origin = np.ascontiguousarray(np.broadcast_to(start.mean[:, 0], (runs,)))
    means, innovations = _mean_kernel(origin, commands, z, gains)
    return MonobotRun(means, covs, innovations, innovation_covs, gains)


def run_filter_stepwise(
    start: Gaussian,
    commands: Float[np.ndarray, "steps"],
    measurements: Float[np.ndarray, "runs measurements n"],
    *,
    motion_variance: VarianceLike,
    measurement_variance: VarianceLike,
) -> MonobotRun:
    """Run the filter over many runs at once, with one `kalman.predict` and `update` per step.

    Parameters, result and exceptions are those of :func:`run_filter`.
    """
    start, commands, z, V, W = _checked(
        start, commands, measurements, motion_variance, measurement_variance
    )
    matrix, noise = sensor_matrix(z.shape[-1]), W[:, 1:]
    belief = first_measurement(start, z[:, 0], W[:, 0])
    return _stepwise(belief, commands, V, matrix, noise, z)


def run_referenced(
    start: Gaussian,
    commands: Float[np.ndarray, "steps"],
    measurements: Float[np.ndarray, "runs measurements n"],
    reference: Reference,
    *,
    motion_variance: VarianceLike,
    measurement_variance: VarianceLike,
) -> MonobotRun:
    """Run the filter over many runs at once, with an anchor or an external sensor after each move.

    The first measurement is that of :func:`run_filter`, so that all maps begin alike. The reference
    measures from the first move on.

    Parameters
    ----------
    start, commands, measurements, motion_variance, measurement_variance
        As in :func:`run_filter`.
    reference
        Anchor or external sensor, with its measurements.

    Returns
    -------
    MonobotRun
        Run with n + 1 innovations a step, that of the reference first.

    Raises
    ------
    ValueError
        As :func:`run_filter`, or if the reference has another number of runs or steps.

    References
    ----------
    Andrade-Cetto, eqs (19), (20) and (23).
    """
    start, commands, z, V, W = _checked(
        start, commands, measurements, motion_variance, measurement_variance
    )
    runs, steps = z.shape[0], commands.size
    checks.instance("reference", reference, Reference)
    if reference.values.shape != (runs, steps):
        shape = reference.values.shape
        raise ValueError(f"reference must have values ({runs}, {steps}), got {shape}")
    own = _per_run("variance of the reference", reference.variance, (steps,), runs)
    batch = max(len(own), len(W))
    noise = np.empty((batch, steps, z.shape[2] + 1))
    noise[..., 0], noise[..., 1:] = own, W[:, 1:]
    values = reference.values + reference.sign * reference.position
    stacked = np.insert(z, 0, np.insert(values, 0, 0.0, axis=1), axis=2)
    matrix, belief = reference.matrix(z.shape[2]), first_measurement(start, z[:, 0], W[:, 0])
    return _stepwise(belief, commands, V, matrix, noise, stacked)


def _stepwise(
    belief: Gaussian,
    commands: np.ndarray,
    V: np.ndarray,
    matrix: np.ndarray,
    noise: np.ndarray,
    measurements: np.ndarray,
) -> MonobotRun:
    """Predict and update, step by step, from the belief after the first measurement."""
    n = belief.mean.shape[-1] - 1
    vehicle = np.eye(n + 1)[0]
    beliefs, infos = [belief], []
    for k, command in enumerate(commands):
        slip = V[:, k, None, None] * np.outer(vehicle, vehicle)
        moved = predict(belief, Motion(np.eye(n + 1), slip, command * vehicle))  # eq. (19)
        sensor = Sensor(matrix, noise[:, k, :, None] * np.eye(len(matrix)))
        try:
            belief, info = update(moved, measurements[:, k + 1], sensor)
        except ValueError as error:
            raise ValueError(SINGULAR) from error
        beliefs.append(belief)
        infos.append(info)
    return MonobotRun(
        means=np.stack([b.mean for b in beliefs], axis=1),
        covs=np.stack(np.broadcast_arrays(*(b.cov for b in beliefs)), axis=1),
        innovations=np.stack([i.innovation for i in infos], axis=1),
        innovation_covs=np.stack([i.innovation_cov for i in infos], axis=1),
        gains=np.stack([i.gain for i in infos], axis=1),
    )


@dataclass(frozen=True, slots=True)
class Settled:
    r"""Steady state of the filter for constant noise, in closed form; see `settled`.

    The landmarks are put into the map by the first measurement.

    Parameters
    ----------
    common_variance
        :math:`a`, predicted variance of the common mode of the relative state (sum of all distances
        over :math:`\sqrt n`), m²; one landmark and V = W = 1 m² give the golden ratio.
    information_rate
        :math:`\dot J_{11}`, growth of the first entry of eq. (14) per step, 1/m².
    landmark_variance, vehicle_variance
        :math:`P_f` and :math:`P_r`, limits of the variances after infinitely many measurements, m².
        In the limit all landmarks share one error, so :math:`P_f` is also the covariance of any
        two.
    pole
        Factor by which the gain on the common innovation shrinks at every step.
    """

    common_variance: float
    information_rate: float
    landmark_variance: float
    vehicle_variance: float
    pole: float


def settled(
    landmarks: int, *, start_variance: float, motion_variance: float, measurement_variance: float
) -> Settled:
    r"""Return the steady state of the filter for constant noise, in closed form.

    .. math::
        a = \tfrac12 \Big(nV + \sqrt{n^2V^2 + 4nVW}\Big), \qquad
        \dot J_{11} = \frac{n}{a + W}, \qquad
        P_f = P_0 + \frac{W}{n} \frac{a}{a + W}, \qquad
        P_r = P_f + \frac{1}{n} \frac{aW}{a + W}

    and the pole is :math:`W / (a + W)`.

    Parameters
    ----------
    landmarks
        Number n of landmarks, at least 1.
    start_variance, motion_variance, measurement_variance
        :math:`P_0 \ge 0`, :math:`V > 0`, :math:`W > 0`, m².

    Raises
    ------
    ValueError
        If there is no landmark or a variance is out of range.
    """
    n = _counted(landmarks, most=None)
    P0 = checks.not_negative("start_variance", start_variance)
    V = checks.positive("motion_variance", motion_variance)
    W = checks.positive("measurement_variance", measurement_variance)
    a = (n * V + np.sqrt((n * V) ** 2 + 4 * n * V * W)) / 2
    landmark = P0 + W / n * a / (a + W)
    return Settled(
        common_variance=float(a),
        information_rate=float(n / (a + W)),
        landmark_variance=float(landmark),
        vehicle_variance=float(landmark + a * W / (a + W) / n),
        pole=float(W / (a + W)),
    )


def relative_system(
    landmarks: int, *, motion_variance: float, measurement_variance: float
) -> tuple[Motion, Sensor]:
    r"""Return the system of the distances :math:`d_i = f_i - r` alone, which is observable.

    .. math:: d_{k+1} = d_k - (u + v)\,\mathbf 1, \qquad z = d + w

    The motion is returned for the command :math:`u = 0`.

    Parameters
    ----------
    landmarks
        Number n of landmarks, at least 1.
    motion_variance, measurement_variance
        V and W, m².

    Raises
    ------
    ValueError
        If there is no landmark or a variance is negative.
    """
    n, V = _counted(landmarks), checks.not_negative("motion_variance", motion_variance)
    W = checks.not_negative("measurement_variance", measurement_variance)
    eye, ones = np.eye(n), np.ones((n, n))
    return Motion(eye, V * ones), Sensor(eye, W * eye)


def _counted(landmarks: int, name: str = "landmarks", most: int | None = MOST_LANDMARKS) -> int:
    """Return the number of landmarks, or raise ``ValueError`` if there are none or too many."""
    if checks.whole(name, landmarks) < 1:
        raise ValueError(f"{name}: a monobot needs at least 1 landmark, got {landmarks}")
    return checks.whole(name, landmarks, 1, most)  # matrices have the square of this many entries


def _check_start(start: Gaussian) -> None:
    """Raise unless the belief at the start is about the vehicle alone."""
    if checks.instance("start", start, Gaussian).mean.shape[-1] != 1:
        raise ValueError(f"start must be a belief in 1 state, got {start.mean.shape[-1]}")


def _variances(name: str, value: VarianceLike) -> np.ndarray:
    """Return variances as an array of finite numbers of at least 0, or raise ``ValueError``."""
    value = checks.array(name, value)
    if value.size and value.min() < 0:
        raise ValueError(f"{name} must not be negative, got {value.min():.3g}")
    return value


def _checked(
    start: Gaussian,
    commands: np.ndarray,
    measurements: np.ndarray,
    V: VarianceLike,
    W: VarianceLike,
) -> tuple[Gaussian, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the checked arguments of a batch; all but commands get an axis of runs (or 1)."""
    z = checks.array("measurements", measurements, ("runs", "steps + 1", "n"))
    runs, n = z.shape[0], _counted(z.shape[2], "measurements")
    steps = z.shape[1] - 1
    if steps < 1 or runs < 1:
        raise ValueError(f"need at least 1 run and 2 measurements, got measurements {z.shape}")
    commands = checks.array("commands", commands, (steps,), f"measurements {z.shape}")
    _check_start(start)
    if start.mean.shape not in {(1,), (1, 1), (runs, 1)}:
        raise ValueError(f"start must be one belief or {runs}, got mean {start.mean.shape}")
    mean = start.mean.reshape(-1, 1)
    cov = np.broadcast_to(start.cov, (*start.cov.shape[:-2], 1, 1)).reshape(-1, 1, 1)
    V = _per_run("motion_variance", V, (steps,), runs)
    W = _per_run("measurement_variance", W, (steps + 1, n), runs)
    return Gaussian(mean, cov), commands, z, V, W


def _per_run(name: str, value: VarianceLike, shape: tuple[int, ...], runs: int) -> np.ndarray:
    """Return variances as ``(1, *shape)`` if shared by all runs, else as ``(runs, *shape)``."""
    value = _variances(name, value)
    own = value.ndim > len(shape)
    try:
        return np.ascontiguousarray(np.broadcast_to(value, (runs if own else 1, *shape)))
    except ValueError:
        raise ValueError(f"{name} must broadcast to {shape}, got {value.shape}") from None


@kernel()
@no_type_check
def _covariance_kernel(P0, V, W):  # pragma: no cover - compiled
    """Return covariances, innovation covariances and gains of each member of the batch.

    Joseph form for H = [-1 | I] and diagonal noise; inner loops run along rows. Checked against
    :func:`run_filter_stepwise` in the tests.
    """
    batch = P0.size
    steps, n = V.shape[1], W.shape[2]
    covs = np.empty((batch, steps + 1, n + 1, n + 1))
    innovation_covs = np.empty((batch, steps, n, n))
    gains = np.empty((batch, steps, n + 1, n))
    G = np.empty((n, n + 1))  # H P
    L = np.empty((n, n))
    K = np.empty((n, n + 1))  # transposed gain
    B = np.empty((n + 1, n + 1))  # P (I - K H)ᵀ
    M = np.empty((n, n + 1))
    for b in range(batch):
        v, w = min(b, V.shape[0] - 1), min(b, W.shape[0] - 1)
        P = covs[b, 0]
        P[:] = P0[b]
        for i in range(n):
            P[i + 1, i + 1] += W[w, 0, i]
        for k in range(steps):
            S, after = innovation_covs[b, k], covs[b, k + 1]
            for i in range(n + 1):
                for j in range(n + 1):
                    B[i, j] = P[i, j]
            B[0, 0] += V[v, k]  # eq. (5)
            for m in range(n):
                for i in range(n + 1):
                    G[m, i] = B[m + 1, i] - B[0, i]
            for m in range(n):
                for i in range(n):
                    S[m, i] = G[m, i + 1] - G[m, 0]
                S[m, m] += W[w, k + 1, m]  # eq. (8)
            for m in range(n):  # Cholesky factor of S
                for i in range(m + 1):
                    total = S[m, i]
                    for q in range(i):
                        total -= L[m, q] * L[i, q]
                    if i < m:
                        L[m, i] = total / L[i, i]
                    elif total <= 1e-14 * S[m, m]:
                        return covs, innovation_covs, gains, False
                    else:
                        L[m, m] = np.sqrt(total)
            for m in range(n):  # K = P Hᵀ S⁻¹, eq. (7)
                for i in range(n + 1):
                    K[m, i] = G[m, i]
                for q in range(m):
                    factor = L[m, q]
                    for i in range(n + 1):
                        K[m, i] -= factor * K[q, i]
                factor = 1 / L[m, m]
                for i in range(n + 1):
                    K[m, i] *= factor
            for m in range(n - 1, -1, -1):
                for q in range(m + 1, n):
                    factor = L[q, m]
                    for i in range(n + 1):
                        K[m, i] -= factor * K[q, i]
                factor = 1 / L[m, m]
                for i in range(n + 1):
                    K[m, i] *= factor
            for m in range(n):
                for j in range(n + 1):
                    factor = G[m, j]
                    gains[b, k, j, m] = K[m, j]
                    for i in range(n + 1):
                        B[j, i] -= factor * K[m, i]
            for m in range(n):
                for i in range(n + 1):
                    M[m, i] = B[m + 1, i] - B[0, i] - W[w, k + 1, m] * K[m, i]
            for m in range(n):
                for j in range(n + 1):
                    factor = K[m, j]
                    for i in range(n + 1):
                        B[j, i] -= factor * M[m, i]  # eq. (9)
            for i in range(n + 1):
                for j in range(n + 1):
                    after[i, j] = 0.5 * (B[i, j] + B[j, i])
            P = after
    return covs, innovation_covs, gains, True


@kernel()
@no_type_check
def _mean_kernel(origin, commands, z, gains):  # pragma: no cover - compiled
    """Return estimates and innovations of each run, eqs (3), (4) and (6)."""
    runs, n = z.shape[0], z.shape[2]
    steps = commands.size
    means = np.empty((runs, steps + 1, n + 1))
    innovations = np.empty((runs, steps, n))
    for run in range(runs):
        g = min(run, gains.shape[0] - 1)
        means[run, 0, 0] = origin[run]
        for i in range(n):
            means[run, 0, i + 1] = origin[run] + z[run, 0, i]
        for k in range(steps):
            x, after = means[run, k], means[run, k + 1]
            K, innovation = gains[g, k], innovations[run, k]
            vehicle = x[0] + commands[k]
            for m in range(n):
                innovation[m] = z[run, k + 1, m] - (x[m + 1] - vehicle)
            for i in range(n + 1):
                total = x[i] if i > 0 else vehicle
                for m in range(n):
                    total += K[i, m] * innovation[m]
                after[i] = total
    return means, innovations
