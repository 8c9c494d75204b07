"""The Rao-Blackwellised filter as the textbook writes it: one particle, one landmark at a time.

The same numbers as :mod:`.filtering`, from lists and dictionaries: this is the version to read.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.beliefs import Gaussian, normalise
from robot_perception.geometry import compose
from robot_perception.observations import Observations
from robot_perception.particles import effective_number, systematic
from robot_perception.slam.planar.motions import Odometry, PlanarMotion, Velocity
from robot_perception.slam.rao_blackwellised import kernels
from robot_perception.slam.rao_blackwellised.filtering import checked_seen


@dataclass(frozen=True, eq=False, slots=True)
class Particle:
    """One hypothesis of the path, by its last pose, and the map given that path, eq. (3).

    Parameters
    ----------
    pose : (3,)
        m, m, rad.
    landmarks : identifier -> Gaussian
        Places in the world, m.
    log_weight
        Logarithm of the weight, but for a constant.

    Raises
    ------
    ValueError
        If the pose is not three finite numbers, a landmark is no Gaussian of three dimensions, or
        the weight is NaN.
    """

    pose: Float[np.ndarray, "3"]
    landmarks: Mapping[int, Gaussian]
    log_weight: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", checks.vector("pose", self.pose, 3))
        object.__setattr__(
            self, "log_weight", checks.number("log_weight", self.log_weight, finite=False)
        )
        for name, place in checks.instance("landmarks", self.landmarks, Mapping).items():
            checks.whole("an identifier of landmarks", name, 0)
            checks.instance(f"landmarks[{name}]", place, Gaussian)
            checks.shaped(f"landmarks[{name}]", place.mean, (3,))


def camera_pose(
    pose: Float[np.ndarray, "3"], mount: Float[np.ndarray, "4 4"]
) -> Float[np.ndarray, "4 4"]:
    r"""Return T_world_camera: the robot's pose, then the mount.

    .. math:: T_{wc} = \begin{bmatrix} \cos\varphi & -\sin\varphi & 0 & x \\
        \sin\varphi & \cos\varphi & 0 & y \\ 0 & 0 & 1 & 0 \\ 0 & 0 & 0 & 1 \end{bmatrix} T_{rc}
    """
    x, y, heading = checks.vector("pose", pose, 3)
    mount = checks.array("mount", mount, (4, 4))
    T_world_robot = np.eye(4)
    T_world_robot[:2, :2] = [
        [np.cos(heading), -np.sin(heading)],
        [np.sin(heading), np.cos(heading)],
    ]
    T_world_robot[:2, 3] = x, y
    return T_world_robot @ mount


def predict(particle: Particle, motion: PlanarMotion, *, rng: np.random.Generator) -> Particle:
    """Return the particle after a motion with noise drawn for it alone."""
    checks.instance("particle", particle, Particle)
    checks.instance("motion", motion, Odometry, Velocity)
    noise = kernels.root(motion.increment_cov) @ checks.generator("rng", rng).standard_normal(3)
    return replace(particle, pose=compose(particle.pose, motion.increment + noise))


@checks.computable("particle and observations")
def update(
    particle: Particle, observations: Observations, mount: Float[np.ndarray, "4 4"]
) -> Particle:
    """Return the particle after observing landmarks that it has, eqs (4) to (6)."""
    checks.instance("particle", particle, Particle)
    checked_seen(observations, mount)
    T_world_camera = camera_pose(particle.pose, mount)
    R, t = T_world_camera[:3, :3], T_world_camera[:3, 3]
    landmarks, log_weight = dict(particle.landmarks), particle.log_weight
    for name, v, Q in zip(
        observations.ids.tolist(), observations.values, observations.covs, strict=True
    ):
        if name not in landmarks:
            raise ValueError(f"observations name a landmark that the particle has not: {name}")
        mean, cov = landmarks[name].mean, landmarks[name].cov
        expected = R.T @ (mean - t)  # what the camera should see
        H = R.T
        Z = H @ cov @ H.T + Q  # covariance of the innovation
        innovation = v - expected
        a = innovation @ np.linalg.solve(Z, innovation)  # eq. (5)
        log_weight -= 0.5 * (a + np.linalg.slogdet(2 * np.pi * Z)[1])  # eqs (4), (6)
        K = np.linalg.solve(Z, H @ cov).T
        rest = np.eye(3) - K @ H
        cov = rest @ cov @ rest.T + K @ Q @ K.T
        landmarks[name] = Gaussian(mean + K @ innovation, (cov + cov.T) / 2)
    return Particle(particle.pose, landmarks, log_weight)


def add_landmarks(
    particle: Particle, observations: Observations, mount: Float[np.ndarray, "4 4"]
) -> Particle:
    """Return the particle with landmarks that it sees for the first time."""
    checks.instance("particle", particle, Particle)
    checked_seen(observations, mount)
    T_world_camera = camera_pose(particle.pose, mount)
    R, t = T_world_camera[:3, :3], T_world_camera[:3, 3]
    new = {
        name: Gaussian(R @ v + t, R @ Q @ R.T)
        for name, v, Q in zip(
            observations.ids.tolist(), observations.values, observations.covs, strict=True
        )
    }
    known = sorted(set(new) & set(particle.landmarks))
    if known or -1 in new:
        raise ValueError(f"observations need names that are not yet in the map, got {known or -1}")
    return replace(particle, landmarks={**particle.landmarks, **new})


def resample(
    particles: Sequence[Particle], *, rng: np.random.Generator, share: float = 0.5
) -> list[Particle]:
    """Return particles drawn by their weights where their effective number is too low."""
    particles = list(checks.instances("particles", particles, Particle))
    checks.generator("rng", rng)
    share = checks.share("share", share)
    if not particles:
        raise ValueError("particles must be at least one, got none")
    log_weights = np.array([particle.log_weight for particle in particles])
    if effective_number(log_weights) >= share * len(particles):  # eq. (7), with the square
        return particles
    weights = np.exp(normalise(log_weights)[0])
    drawn = systematic(weights, len(particles), rng=rng)
    return [replace(particles[i], log_weight=0.0) for i in drawn]
