"""Small drives for the tests, written from positions, without the filter's equations."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from robot_perception.beliefs import ParticleSet
from robot_perception.observations import Observations
from robot_perception.slam.planar import Odometry
from robot_perception.slam.rao_blackwellised import ParticleMaps, forward_mount

MOUNT = forward_mount(1.1, 0.15, 0.06)
SLIP = np.array([0.01, 0.005, 0.01])


@dataclass
class Drive:
    """A drive round a circle: true poses and landmarks, and what was measured."""

    poses: np.ndarray  # (k + 1, 3)
    landmarks: np.ndarray  # (n, 3)
    motions: list[Odometry]
    looks: list[Observations]

    def start(self, count):
        return ParticleMaps.start(self.poses[0], count)


def seen_from(pose, points):
    """Return points of the world in the frame of a camera mounted as MOUNT says."""
    x, y, heading = pose
    ahead = (points[:, 0] - x) * np.cos(heading) + (points[:, 1] - y) * np.sin(heading)
    left = (points[:, 1] - y) * np.cos(heading) - (points[:, 0] - x) * np.sin(heading)
    return np.stack([0.06 - left, 1.1 - points[:, 2], ahead - 0.15], axis=-1)


def noises(points, rng):
    """Return covariances as a stereo rig has them: long in depth, and tilted a little."""
    depth = np.abs(points[:, 2]) + 0.5
    root = np.zeros((len(points), 3, 3))
    root[:, 0, 0] = root[:, 1, 1] = 0.002 * depth
    root[:, 2, 2] = 0.004 * depth**2
    root += 1e-3 * rng.standard_normal(root.shape)
    return root @ root.mT


def drive(rng, *, steps=20, landmarks=15, seen=5, slip=1.0):
    """Return a drive of so many steps; the odometry has ``slip`` times the deviations above."""
    angle = np.linspace(0, 2 * np.pi, steps + 1)
    heading = np.angle(np.exp(1j * (angle + np.pi / 2)))
    poses = np.stack([3 * np.cos(angle), 3 * np.sin(angle), heading], axis=-1)
    places = np.column_stack([rng.uniform(-6, 6, (landmarks, 2)), rng.uniform(0, 2.5, landmarks)])
    motions, looks = [], []
    for before, after in pairwise(poses):
        shift = complex(*(after - before)[:2]) * np.exp(-1j * before[2])
        turned = np.angle(np.exp(1j * (after[2] - before[2])))
        errors = slip * SLIP * rng.standard_normal(3)
        motions.append(
            Odometry(
                np.array([shift.real, shift.imag, turned]) + errors, np.diag((slip * SLIP) ** 2)
            )
        )
        ids = rng.permutation(landmarks)[:seen]
        values = seen_from(after, places[ids])
        covs = noises(values, rng)
        errors = np.linalg.cholesky(covs) @ rng.standard_normal((seen, 3, 1))
        looks.append(Observations(ids, values + errors[..., 0], covs))
    return Drive(poses, places, motions, looks)


def assert_close(ours, theirs, relative=1e-9):
    """Compare two arrays to a share of the largest entry, whatever the processor's rounding."""
    scale = np.abs(theirs).max(initial=0.0)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=relative * scale)


def maps_of(rng, count, landmarks):
    """Return a belief of random poses, weights, landmarks and covariances."""
    poses = rng.uniform(-3, 3, (count, 3))
    means = rng.uniform(-5, 5, (count, landmarks, 3))
    root = 0.5 * rng.standard_normal((count, landmarks, 3, 3))
    particles = ParticleSet(poses, rng.standard_normal(count))
    return ParticleMaps(particles, rng.permutation(50)[:landmarks], means, root @ root.mT)
