r"""The Rao-Blackwellised particle filter, one step at a time.

``RaoBlackwellisedSlam(mount).step(state, motion, observations, *, rng) -> (state, StepInfo)``

Each function takes a belief and returns a new one. Equation numbers are those of Gil, Payá,
Reinoso, Fernández and Puerto, "Simultaneous localization and mapping in indoor environments using
SIFT features", VIIP 2006. :mod:`.textbook` has it with one particle and one landmark at a time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.beliefs import normalise
from robot_perception.observations import Observations
from robot_perception.particles import Scheme, StepInfo, effective_number, systematic
from robot_perception.slam.planar.motions import Odometry, PlanarMotion, Velocity
from robot_perception.slam.rao_blackwellised import kernels
from robot_perception.slam.rao_blackwellised.belief import (
    ParticleMaps,
    descended,
    extended,
    gathered,
    rewritten,
    with_particles,
)

SINGULAR = "observations: the covariance of an innovation is singular, points without noise?"

Criterion = Callable[[np.ndarray], float]


@dataclass(frozen=True, eq=False, slots=True)
class Weighing:
    r"""Diagnostics of one update.

    Parameters
    ----------
    log_likelihoods : (M,)
        Logarithm of :math:`\omega_t^{[m]}`, eq. (6): the density of all observations for each
        particle, m⁻³ for each point.
    log_evidence
        Logarithm of the same for all particles together,
        :math:`\log \sum_m \omega_{t-1}^{[m]} \omega_t^{[m]}`.
    """

    log_likelihoods: Float[np.ndarray, "M"]
    log_evidence: float


def forward_mount(
    height: float, forward: float = 0.0, left: float = 0.0
) -> Float[np.ndarray, "4 4"]:
    """Return T_robot_camera of a level camera that looks where the robot drives to.

    The camera's axes: z forward, x right, y down; the robot's: x forward, y left, z up.

    Parameters
    ----------
    height, forward, left
        Where the camera is from the robot, m.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    offsets = (("forward", forward), ("left", left), ("height", height))
    T_robot_camera = np.zeros((4, 4))
    T_robot_camera[:3, :3] = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
    T_robot_camera[:, 3] = [*(checks.number(name, value) for name, value in offsets), 1.0]
    return T_robot_camera


def predict(maps: ParticleMaps, motion: PlanarMotion, *, rng: np.random.Generator) -> ParticleMaps:
    r"""Return the particles after a motion, each moved by a draw of its own.

    .. math:: s_t^{[m]} \sim p(s_t \mid s_{t-1}^{[m]}, u_t)

    Parameters
    ----------
    maps
        Belief before the motion.
    motion
        :class:`~robot_perception.slam.planar.Odometry` or
        :class:`~robot_perception.slam.planar.Velocity`; a covariance of zeros moves all alike.
    rng
        Source of the draws.

    References
    ----------
    Gil et al., section 3.2.
    """
    checks.instance("maps", maps, ParticleMaps)
    checks.instance("motion", motion, Odometry, Velocity)
    draws = checks.generator("rng", rng).standard_normal((len(maps), 3))
    poses = kernels.moved(maps.poses, motion.increment, motion.increment_cov, draws)
    return with_particles(maps, poses, maps.particles.log_weights)


def update(
    maps: ParticleMaps,
    observations: Observations,
    mount: Float[np.ndarray, "4 4"],
    assignment: Int[np.ndarray, "M m"] | None = None,
    *,
    unmatched_density: float = 1.0,
) -> tuple[ParticleMaps, Weighing]:
    r"""Return the belief after observing landmarks of the map, and what that showed.

    .. math::
        \hat v = R^\top (\mu - t), \quad Z = R^\top \Sigma R + Q, \quad
        \omega_i = |2 \pi Z|^{-1/2} e^{-\frac 1 2 (v - \hat v)^\top Z^{-1} (v - \hat v)}, \quad
        \omega = \omega_{t-1} \prod_i \omega_i

    where R and t take points of the camera to the world. Given the pose an observed point is a
    linear function of the landmark, so the map of a particle is the exact conditional one. The
    update is made in the frame of the world, where the sensor matrix is the identity: with
    :math:`S = \Sigma + R Q R^\top = L L^\top` and :math:`W = L^{-1} \Sigma`,

    .. math:: \mu^+ = \mu + W^\top L^{-1} (R v + t - \mu), \qquad \Sigma^+ = \Sigma - W^\top W

    and the determinant and the squared distance are those of Z, as a rotation changes neither.

    Parameters
    ----------
    maps
        Belief before the observations.
    observations
        Points (m, 3) in the frame of the camera, m, with covariances.
    mount : (4, 4)
        T_robot_camera.
    assignment : (M, m), optional
        For each particle, which landmark each observation is of; -1 for none. If left out, the
        names of the observations hold for all particles.
    unmatched_density
        Density of an observation for a particle that assigns it no landmark, m⁻³: particles that
        recognise different numbers of points are compared by it. Our choice; the paper has none.

    Returns
    -------
    posterior : ParticleMaps
    seen : Weighing

    Raises
    ------
    ValueError
        If an observation has no covariance, a name is not in the map (of the particle), a particle
        assigns a landmark twice, the mount is no rigid motion, an innovation's covariance is
        singular, or no particle explains the observations at all.

    References
    ----------
    Gil et al., eqs (4) to (6).
    """
    checks.instance("maps", maps, ParticleMaps)
    seen = checked_seen(observations, mount)
    unmatched = np.log(checks.positive("unmatched_density", unmatched_density))
    if assignment is None:
        slots, columns = _shared_columns(maps, observations.ids.tolist())
    else:
        slots, columns = _own_columns(maps, assignment, len(seen))
    rows = gathered(maps, slots)
    log_likelihoods, regular = kernels.revise(rows, maps.poses, seen, columns, unmatched)
    if not regular:
        raise ValueError(SINGULAR)
    log_weights = maps.particles.log_weights + log_likelihoods
    if not np.isfinite(log_weights.max()):
        raise ValueError("observations are so far from the maps that all weights are 0")
    log_weights, log_evidence = normalise(log_weights)
    posterior = rewritten(maps, slots, rows, log_weights)
    return posterior, Weighing(log_likelihoods, float(log_evidence))


def add_landmarks(
    maps: ParticleMaps,
    observations: Observations,
    mount: Float[np.ndarray, "4 4"],
    where: Bool[np.ndarray, "M m"] | None = None,
) -> ParticleMaps:
    r"""Return the belief with every observed landmark put into the maps.

    .. math:: \mu = R v + t, \qquad \Sigma = R Q R^\top

    That is the posterior of a point of which nothing was known, given the pose.

    Parameters
    ----------
    maps
        Belief before.
    observations
        Points (m, 3) in the frame of the camera, m, with covariances and names that are not yet in
        the map.
    mount : (4, 4)
        T_robot_camera.
    where : (M, m), optional
        Which particles get which landmark; all, if left out.

    Returns
    -------
    ParticleMaps

    Raises
    ------
    ValueError
        If an observation has no covariance or no name, a name is in the map already, or the mount
        is no rigid motion.
    """
    checks.instance("maps", maps, ParticleMaps)
    seen, names = checked_seen(observations, mount), observations.ids.tolist()
    if -1 in names:
        raise ValueError("observations of new landmarks need names, got -1")
    known = [name for name in names if name in maps.slots]
    if known:
        raise ValueError(f"observations name landmarks that are in the map already: {known}")
    size = (len(maps), len(names))
    where = np.ones(size, dtype=bool) if where is None else np.asarray(where)
    if where.dtype != bool or where.shape != size:
        raise ValueError(f"where must be booleans {size}, got {where.dtype} {where.shape}")
    return extended(maps, names, kernels.located(maps.poses, seen), where.T)


def resample(
    maps: ParticleMaps,
    *,
    rng: np.random.Generator,
    share: float = 0.5,
    criterion: Criterion = effective_number,
    scheme: Scheme = systematic,
) -> tuple[ParticleMaps, StepInfo]:
    r"""Return particles drawn anew by their weights, where too few of them count.

    .. math:: M_\text{eff} = \frac{1}{\sum_m (\omega^{[m]})^2} < \tfrac 1 2 M

    Parameters
    ----------
    maps
        Belief before.
    rng
        Source of randomness.
    share
        Particles are drawn anew where the criterion is below this share of M: 0 is never, 1
        whenever the weights differ. The paper: 1/2.
    criterion
        What is compared, of the logarithms of the weights:
        :func:`~robot_perception.particles.effective_number`, or :func:`printed_number`.
    scheme
        How they are drawn, see :mod:`robot_perception.particles`.

    Returns
    -------
    maps : ParticleMaps
    info : StepInfo
        ``effective`` is the value of the criterion; ``log_evidence`` is 0.

    Raises
    ------
    ValueError
        If the share is not from 0 to 1, the criterion no number, or the scheme draws no particles.

    References
    ----------
    Gil et al., section 3.3. Eq. (7) lacks the square: see :func:`printed_number`.
    """
    count = len(checks.instance("maps", maps, ParticleMaps))
    checks.generator("rng", rng)
    share = checks.share("share", share)
    _check_functions(criterion=criterion, scheme=scheme)
    effective = checks.number("criterion", criterion(maps.particles.log_weights), finite=False)
    if effective >= share * count:
        return maps, StepInfo(effective, False, np.arange(count), 0.0)
    drawn = scheme(maps.particles.weights, count, rng=rng)
    ancestors = checks.integers("scheme", drawn, (count,), 0)
    if ancestors.max() >= count:
        raise ValueError(f"scheme must draw from {count} particles, got {ancestors.max()}")
    return descended(maps, ancestors), StepInfo(effective, True, ancestors, 0.0)


@final
@dataclass(frozen=True, eq=False, slots=True)
class RaoBlackwellisedSlam:
    """Finds where a robot is, and the landmarks that its camera sees, by names that are known.

    Parameters
    ----------
    mount : (4, 4)
        T_robot_camera.
    particles
        Number M, at least 1.
    share, criterion, scheme
        When and how particles are drawn anew, see :func:`resample`.

    Raises
    ------
    ValueError
        If the mount is no rigid motion, there is no particle, or the share is not from 0 to 1.

    References
    ----------
    Gil et al., section 3.
    """

    mount: Float[np.ndarray, "4 4"]
    particles: int = 100
    share: float = 0.5
    criterion: Criterion = effective_number
    scheme: Scheme = systematic

    def __post_init__(self) -> None:
        object.__setattr__(self, "mount", checked_mount(self.mount))
        object.__setattr__(self, "particles", checks.whole("particles", self.particles, 1))
        object.__setattr__(self, "share", checks.share("share", self.share))
        _check_functions(criterion=self.criterion, scheme=self.scheme)

    def start(self, pose: Float[np.ndarray, "3"]) -> ParticleMaps:
        """Return empty maps with all particles at one pose.

        Parameters
        ----------
        pose : (3,)
            m, m, rad.

        Raises
        ------
        ValueError
            If the pose is not (3,) or not finite.
        """
        return ParticleMaps.start(pose, self.particles)

    def step(
        self,
        state: ParticleMaps,
        motion: PlanarMotion,
        observations: Observations,
        *,
        rng: np.random.Generator,
    ) -> tuple[ParticleMaps, StepInfo]:
        """Return the belief after a motion and what was then seen, with names that are known.

        The particles move, are weighed by the observed landmarks that are in the map, and drawn
        anew if need be; then observed landmarks that are not in the map are put into it.
        Observations without a name (-1) are left out.

        Parameters
        ----------
        state
            Belief before.
        motion
            See :func:`predict`.
        observations
            See :func:`update`.
        rng
            Source of randomness.

        Raises
        ------
        ValueError
            Where :func:`update`, :func:`add_landmarks` and :func:`resample` raise.
        """
        maps = predict(checks.instance("state", state, ParticleMaps), motion, rng=rng)
        ids = checks.instance("observations", observations, Observations).ids
        old = np.array([name in maps.slots for name in ids.tolist()], dtype=bool)
        maps, seen = update(maps, observations if old.all() else observations[old], self.mount)
        how = {"share": self.share, "criterion": self.criterion, "scheme": self.scheme}
        maps, info = resample(maps, rng=rng, **how)
        new = ~old & (ids >= 0)
        if new.any():
            maps = add_landmarks(maps, observations[new], self.mount)
        return maps, StepInfo(info.effective, info.resampled, info.ancestors, seen.log_evidence)


def printed_number(log_weights: Float[np.ndarray, "M"]) -> float:
    r"""Return what eq. (7) prints in place of the effective number.

    .. math:: \frac{1}{\sum_m \omega^{[m]}}

    Of normalised weights it is 1, whatever they are: below M/2, as a rule for resampling, it says
    "always" for more than two particles and "never" for one. Of the products (6) as they are it
    depends on the unit of length.

    Parameters
    ----------
    log_weights : (M,)
        Logarithms of the weights.

    Raises
    ------
    ValueError
        If there is no weight, a logarithm is NaN or infinite, or all weights are 0.

    References
    ----------
    Gil et al., eq. (7).
    """
    log_weights = checks.array("log_weights", log_weights, ("M",), finite=False)
    with np.errstate(over="ignore"):
        return float(np.exp(-normalise(log_weights)[1]))


def lineage(ancestors: Sequence[Int[np.ndarray, "M"]]) -> Int[np.ndarray, "steps M"]:
    """Return from which particle of each step each particle of the last step descends.

    The path of particle m is ``poses[t, lineage[t, m]]`` over the steps t: `paths`. Where all of a
    row are equal, one particle is left of which all others are copies.

    Parameters
    ----------
    ancestors
        What each step says: the particle before it that each particle after it comes from.

    Returns
    -------
    (steps, M)

    Raises
    ------
    ValueError
        If there is no step, a row is of another length, or an entry is no particle.
    """
    steps = checks.iterable("ancestors", ancestors)
    rows = [checks.integers("ancestors", row, ("M",), 0) for row in steps]
    if not rows or len({row.size for row in rows}) > 1:
        raise ValueError(f"ancestors must be rows of one length, got {[row.size for row in rows]}")
    if max(row.max(initial=0) for row in rows) >= rows[0].size:
        raise ValueError(f"ancestors must be of {rows[0].size} particles, got more")
    traced = [np.arange(rows[0].size)]
    for row in rows[:0:-1]:
        traced.append(row[traced[-1]])
    return np.array(traced[::-1])


def paths(
    poses: Sequence[Float[np.ndarray, "M 3"]], ancestors: Sequence[Int[np.ndarray, "M"]]
) -> Float[np.ndarray, "steps M 3"]:
    """Return the path of each particle of the last step: its pose, and those it descends from.

    Parameters
    ----------
    poses
        The particles after each step, as a state has them after drawing anew; m, m, rad.
    ancestors
        What each step says, as of `lineage`.

    Returns
    -------
    (steps, M, 3)

    Raises
    ------
    ValueError
        If there is no step, the poses are not (steps, M, 3) or not finite, or where `lineage`
        raises.
    """
    line = lineage(ancestors)
    steps = checks.iterable("poses", poses)
    found = [checks.array("poses", row, (line.shape[1], 3), "each step") for row in steps]
    if len(found) != len(line):
        raise ValueError(f"poses must be of {len(line)} steps, got {len(found)}")
    return np.array(found)[np.arange(len(line))[:, None], line]


def checked_seen(observations: Observations, mount: np.ndarray) -> np.ndarray:
    """Return observed points in the frame of the robot as rows of nine numbers, or raise."""
    checks.instance("observations", observations, Observations)
    values, covs = observations.values, observations.covs
    if values.shape[1] != 3 or covs is None:
        what = "none" if covs is None else "some"
        raise ValueError(
            f"observations must be points (m, 3) with covariances, got {values.shape} with {what}"
        )
    return kernels.in_robot_frame(values, covs, checked_mount(mount))


def checked_mount(mount: np.ndarray) -> np.ndarray:
    """Return T_robot_camera (4, 4), or raise."""
    mount = checks.array("mount", mount, (4, 4))
    if not kernels.is_rigid(mount, 1e-9):
        raise ValueError(f"mount must be a rotation and a translation, got {mount.tolist()}")
    return mount


def _check_functions(**functions: Callable) -> None:
    for name, function in functions.items():
        if not callable(function):
            raise TypeError(f"{name} must be a function, got {checks.shown(function)}")


def _shared_columns(maps: ParticleMaps, names: list[int]) -> tuple[list[int], np.ndarray]:
    """Return where observed landmarks stand in the map, and that of each observation among them."""
    unknown = [name for name in names if name not in maps.slots]
    if unknown:
        raise ValueError(f"observations name landmarks that are not in the map: {unknown}")
    slots = [maps.slots[name] for name in names]
    if (maps.table[slots] < 0).any():
        raise ValueError("observations name landmarks that some particles do not have: assignment?")
    return slots, np.arange(len(slots))[None]


def _own_columns(
    maps: ParticleMaps, assignment: np.ndarray, count: int
) -> tuple[list[int], np.ndarray]:
    """Return the same where each particle has an assignment of its own; -1 is no landmark."""
    beside = f"{len(maps)} particles and {count} observations"
    assignment = checks.integers("assignment", assignment, (len(maps), count), -1, beside)
    ordered = np.sort(assignment, axis=1)
    if ((ordered[:, 1:] == ordered[:, :-1]) & (ordered[:, 1:] >= 0)).any():
        raise ValueError("assignment gives a landmark of a particle to two observations")
    names = sorted(set(assignment.ravel().tolist()) - {-1})
    unknown = [name for name in names if name not in maps.slots]
    if unknown:
        raise ValueError(f"assignment names landmarks that are not in the map: {unknown}")
    slots = [maps.slots[name] for name in names]
    columns = np.where(assignment < 0, -1, np.searchsorted(names, assignment))
    used = (columns[:, :, None] == np.arange(len(names))).any(axis=1)
    if ((maps.table[slots] < 0) & used.T).any():
        raise ValueError("assignment gives particles landmarks that they do not have")
    return slots, columns
