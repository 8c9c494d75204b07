"""Small drives for the tests, written from positions, without the filter's equations."""

from dataclasses import dataclass

import numpy as np

from robot_perception.slam.planar import MapBelief, Observations, Odometry, Step

Q = np.diag([0.02**2, 0.02**2, 0.01**2])
R = np.diag([0.05**2, 0.05**2])
R_POLAR = np.diag([0.05**2, 0.01**2])


@dataclass
class Drive:
    """A drive round a circle: true poses and landmarks, and what was measured."""

    poses: np.ndarray  # (k + 1, 3)
    landmarks: np.ndarray  # (n, 2)
    steps: list[Step]

    @property
    def start(self):
        return MapBelief.start(self.poses[0], np.zeros((3, 3)))


def assert_close(ours, theirs, relative=1e-9):
    """Compare two arrays to a share of the largest entry, whatever the processor's rounding."""
    scale = np.abs(theirs).max(initial=0.0)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=relative * scale)


def wrapped(angle):
    return np.angle(np.exp(1j * angle))


def drive(rng, *, steps=60, landmarks=12, noise=1.0, polar=False, seen=4, observe=True):
    """Return a drive with noises of ``noise`` times the standard deviations above.

    ``noise`` scales what is measured and what the filter is told. Positions are complex numbers.
    """
    radius = 4.0
    angle = np.linspace(0, 2 * np.pi, steps + 1)
    place = radius * np.exp(1j * angle)
    heading = wrapped(angle + np.pi / 2)
    posts = rng.uniform(1.5, 7.0, landmarks) * np.exp(2j * np.pi * rng.random(landmarks))
    taken = []
    for k in range(1, steps + 1):
        shift = (place[k] - place[k - 1]) * np.exp(-1j * heading[k - 1])
        turned = wrapped(heading[k] - heading[k - 1])
        increment = np.array([shift.real, shift.imag, turned])
        increment = increment + noise * np.sqrt(np.diag(Q)) * rng.standard_normal(3)
        relative = (posts - place[k]) * np.exp(-1j * heading[k])
        ids = np.argsort(np.abs(relative))[:seen]
        if polar:
            values = np.stack([np.abs(relative[ids]), np.angle(relative[ids])], axis=-1)
        else:
            values = np.stack([relative[ids].real, relative[ids].imag], axis=-1)
        deviations = np.sqrt(np.diag(R_POLAR if polar else R))
        values = values + noise * deviations * rng.standard_normal(values.shape)
        if polar:
            values[:, 1] = wrapped(values[:, 1])
        observed = Observations(ids, values) if observe else None
        taken.append(Step(Odometry(increment, noise**2 * Q), observed))
    poses = np.stack([place.real, place.imag, heading], axis=-1)
    return Drive(poses, np.stack([posts.real, posts.imag], axis=-1), taken)


def belief_of(rng, n, *, size=0.1):
    """Return a belief over n landmarks with a full random covariance."""
    root = size * rng.standard_normal((3 + 2 * n, 3 + 2 * n))
    mean = np.concatenate([rng.uniform(-3, 3, 3), rng.uniform(-10, 10, 2 * n)])
    return MapBelief(mean, root @ root.T, rng.permutation(max(n, 50))[:n])
