"""A robot in a finished map: one step of the particles beside the same weights in NumPy."""

import numpy as np

from robot_perception.book.map_localisation import log_weights
from robot_perception.geometry import se3
from robot_perception.landmarks.metrics import euclidean_mean
from robot_perception.observations import unnamed
from robot_perception.particles import systematic
from robot_perception.slam import rao_blackwellised
from robot_perception.slam.localisation import LandmarkMap, LocaliserRules, MapLocaliser
from robot_perception.slam.visual import Looks
from tests.tools.benchmarks.harness import Row

PARTICLES, LANDMARKS, POINTS = 1000, 1000, 60
MOUNT = rao_blackwellised.forward_mount(1.1)


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern a robot in a finished map."""
    rng = np.random.default_rng(1)
    means = rng.uniform([0, -6, 0], [20, 8, 2.7], (LANDMARKS, 3))
    covs, found = np.tile(0.01 * np.eye(3), (LANDMARKS, 1, 1)), rng.uniform(0, 90, (LANDMARKS, 128))
    map_ = LandmarkMap(means, covs, Looks(found, found, 0 * found, np.ones(LANDMARKS, dtype=int)))
    pose = np.array([10.0, 1.0, 0.3])
    T = se3.inverse(se3.from_se2(pose) @ MOUNT)
    points, spread = se3.act(T, means[:POINTS]), np.tile(0.01 * np.eye(3), (POINTS, 1, 1))
    seen, looks = unnamed(points, spread), found[:POINTS]
    rules = LocaliserRules(particles=PARTICLES, share=0.0)
    tracker = MapLocaliser(map_, MOUNT, rules)
    state = tracker.start(rng=rng)
    robot = se3.act(MOUNT, points)
    R = MOUNT[:3, :3]
    columns = robot, R @ spread @ R.T, means[:POINTS], covs[:POINTS]

    def in_numpy() -> np.ndarray:
        """Match, weigh and draw as the chapter's cell does."""
        table = np.linalg.norm(looks[:, None] - found, axis=-1)
        assert (table.argmin(axis=1) == np.arange(POINTS)).all()
        logs = log_weights(state.particles.states, *columns, rules)
        weights = np.exp(logs - logs.max())
        return systematic(weights, PARTICLES, rng=rng)

    def step() -> tuple:
        return tracker.step(state, None, seen, looks, costs=euclidean_mean, rng=rng)

    def agree() -> None:
        logs = log_weights(state.particles.states, *columns, rules)
        ours = step()[0].particles.log_weights
        np.testing.assert_allclose(ours - ours.max(), logs - logs.max(), atol=1e-8)

    return [
        Row(
            work=f"landmarks of a map, {LANDMARKS}: {PARTICLES} particles, {POINTS} points",
            ours=step,
            peer=in_numpy,
            peer_name="the same in NumPy",
            agree=agree,
            inner=1,
        )
    ]
