"""Localisation in a finished map: weights by matrices, exact posteriors, points on a floor."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.beliefs import Gaussian, ParticleSet
from robot_perception.geometry import act, compose, inverse, se3, wrap_angle
from robot_perception.observations import Observations
from robot_perception.slam import rao_blackwellised as rb
from robot_perception.slam.localisation import (
    LandmarkMap,
    LocaliserRules,
    MapLocaliser,
    Whereabouts,
    _weigh,
    clusters,
)
from robot_perception.slam.planar import Odometry
from robot_perception.slam.visual import Looks, Options, VisualSlam
from tests.unchecked import unchecked

MOUNT = rb.forward_mount(1.1, 0.2, -0.05)
UPPER = np.triu_indices(3)


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def looks(names):
    """Return how landmarks look: one number for each kind, far from those of other kinds."""
    own = 1000.0 * np.eye(int(max(names)) + 1)[names]
    return Looks(own, own, np.zeros_like(own), np.ones(len(own), dtype=int))


def by_looks(asked):
    """Return the distances of descriptors."""
    return np.linalg.norm(asked.descriptors[:, None] - asked.looks.means, axis=-1)


def building(rng, count=60, sigma=0.02):
    """Return a map of points all over 12 m by 8 m, each of a kind of its own."""
    places = rng.uniform([0, 0, 0.3], [12, 8, 2.5], (count, 3))
    covs = sigma**2 * np.tile(np.eye(3), (count, 1, 1))
    return LandmarkMap(places, covs, looks(np.arange(count)))


def seen_from(pose, map_, rng=None, reach=6.0, sigma=0.03, mount=MOUNT):
    """Return what a camera sees of the landmarks before it: points, descriptors, and which."""
    T = se3.inverse(se3.from_se2(np.asarray(pose)) @ mount)
    points = se3.act(T, map_.means)
    rows = np.flatnonzero((points[:, 2] > 0.3) & (np.linalg.norm(points, axis=1) < reach))
    noise = 0 if rng is None else sigma * rng.standard_normal((len(rows), 3))
    covs = sigma**2 * np.tile(np.eye(3), (len(rows), 1, 1))
    seen = Observations(np.full(len(rows), -1), points[rows] + noise, covs)
    return seen, map_.looks.means[rows], rows


def drive(localiser, path, rng, state=None, sigma=(0.02, 0.01, 0.01), world=None):
    """Follow a path through the map; yield the states and the infos."""
    state = localiser.start(rng=rng) if state is None else state
    before = None
    for pose in path:
        motion = None
        if before is not None:
            step = compose(inverse(before), pose) + np.array(sigma) * rng.standard_normal(3)
            motion = Odometry(step, np.diag(sigma) ** 2)
        seen, found, _ = seen_from(pose, world or localiser.map, rng)
        state, info = localiser.step(state, motion, seen, found, costs=by_looks, rng=rng)
        yield state, info
        before = pose


def straight(start, count, pace=0.3, turn=0.05):
    """Return poses along an arc."""
    path = [np.array(start)]
    for _ in range(count - 1):
        path.append(compose(path[-1], np.array([pace, 0.0, turn])))
    return np.array(path)


def posed(poses, log_weights=None, *, localiser=None):
    """Return a state with these particles."""
    weights = np.zeros(len(poses)) if log_weights is None else log_weights
    particles = ParticleSet(np.array(poses, dtype=float), weights)
    return Whereabouts(particles, clusters(particles, near=(1.0, 0.5)), False)


def covariances(rng, count):
    """Return random covariances."""
    roots = 0.3 * rng.standard_normal((count, 3, 3))
    return roots @ roots.mT + 0.01 * np.eye(3)


# Weights -----------------------------------------------------------------------------------------


def by_matrices(poses, points, covs, names, means, map_covs, rules):
    """Return the logarithms of weights, eqs (4) to (6) and what is ours, matrix by matrix."""
    logs = []
    for pose in poses:
        back, total = se3.inverse(se3.from_se2(pose)), 0.0
        for v, C, row in zip(points, covs, names, strict=True):
            density = []
            for j in row[row >= 0]:
                R = back[:3, :3]
                Z = C + R @ map_covs[j] @ R.T + rules.reach**2 * np.eye(3)
                off = v - se3.act(back, means[j : j + 1])[0]
                a = off @ np.linalg.solve(Z, off)
                density.append(np.exp(-a / 2) / np.sqrt(np.linalg.det(2 * np.pi * Z)))
            right = (1 - rules.wrong) * np.mean(density)
            total += np.log(right + rules.wrong * rules.unmatched)
        logs.append(total)
    return np.array(logs)


@pytest.mark.parametrize("wrong", [0.0, 0.3])
@pytest.mark.parametrize("candidates", [1, 3])
def test_the_kernel_weighs_as_the_matrices_do(wrong, candidates, rng):
    rules = LocaliserRules(wrong=wrong, reach=0.4, unmatched=0.05)
    poses = rng.uniform(-3, 3, (7, 3))
    points, covs = rng.uniform(-1, 1, (5, 3)), covariances(rng, 5)
    means, map_covs = rng.uniform(-1, 1, (6, 3)), covariances(rng, 6)
    names = np.array([rng.permutation(6)[:candidates] for _ in points])
    names[2, 1:] = -1
    seen = np.concatenate([points, covs[:, *UPPER]], axis=1)
    places = np.concatenate([means, map_covs[:, *UPPER]], axis=1)
    ours = _weigh(poses, seen, names, places, rules.reach**2, rules.wrong, rules.unmatched)
    theirs = by_matrices(poses, points, covs, names, means, map_covs, rules)
    np.testing.assert_allclose(ours, theirs, rtol=1e-9)


def test_without_what_is_ours_the_weights_are_those_of_the_slam_filter(rng):
    rules = LocaliserRules(particles=40, wrong=0.0, reach=0.0, share=0.0)
    map_ = building(rng, 8)
    covs = covariances(rng, 8)
    map_ = replace(map_, covs=covs)
    poses = np.array([5.0, 4.0, 0.3]) + 0.1 * rng.standard_normal((40, 3))
    seen, found, rows = seen_from([5.0, 4.0, 0.3], map_, rng, sigma=0.2)
    maps = rb.ParticleMaps(
        ParticleSet.uniform(poses),
        np.arange(8),
        np.tile(map_.means, (40, 1, 1)),
        np.tile(covs, (40, 1, 1, 1)),
    )
    _, weighing = rb.update(maps, seen.named(rows), MOUNT)
    localiser = MapLocaliser(map_, MOUNT, rules)
    state, info = localiser.step(posed(poses), None, seen, found, costs=by_looks, rng=rng)
    np.testing.assert_allclose(
        state.particles.log_weights,
        ParticleSet(poses, weighing.log_likelihoods).log_weights,
        atol=1e-8,
    )
    assert info.log_evidence == pytest.approx(weighing.log_evidence, rel=1e-9)
    assert info.names[:, 0].tolist() == rows.tolist()


def test_weights_do_not_know_where_the_world_is(rng):
    map_, moved = building(rng, 20), np.array([3.0, -2.0, 0.7])
    T = se3.from_se2(moved)
    covs = T[:3, :3] @ covariances(rng, 20) @ T[:3, :3].T
    first = replace(map_, covs=T[:3, :3].T @ covs @ T[:3, :3])
    second = replace(map_, means=se3.act(T, map_.means), covs=(covs + covs.mT) / 2)
    poses = rng.uniform([0, 0, -3], [12, 8, 3], (50, 3))
    seen, found, _ = seen_from([5.0, 4.0, 0.3], map_, rng)
    logs = []
    for own, states in ((first, poses), (second, compose(moved, poses))):
        localiser = MapLocaliser(own, MOUNT, LocaliserRules(particles=50, share=0.0))
        state, _ = localiser.step(posed(states), None, seen, found, costs=by_looks, rng=rng)
        logs.append(state.particles.log_weights)
    np.testing.assert_allclose(*logs, atol=1e-8)


def test_a_wrong_match_costs_no_more_than_its_probability(rng):
    map_ = building(rng, 30)
    pose = np.array([5.0, 4.0, 0.3])
    seen, found, _ = seen_from(pose, map_)
    lied = found.copy()
    lied[0] = (
        map_.looks.means[-1] if not np.array_equal(found[0], map_.looks.means[-1]) else found[1]
    )
    rules = LocaliserRules(particles=2, share=0.0, wrong=0.3, unmatched=0.01)
    localiser = MapLocaliser(map_, MOUNT, rules)
    poses = np.array([pose, [5.0, 10.0, 0.3]])  # right, and nowhere
    ratios = []
    for descriptors in (found, lied):
        state, _ = localiser.step(posed(poses), None, seen, descriptors, costs=by_looks, rng=rng)
        ratios.append(-np.diff(state.particles.log_weights)[0])
    one = ratios[0] / len(seen)
    assert ratios[1] > ratios[0] - 2 * one > 10


# Exact posteriors --------------------------------------------------------------------------------


def test_with_a_known_heading_the_particles_have_the_kalman_mean_and_covariance(rng):
    map_ = building(rng, 3, sigma=0.2)
    rules = LocaliserRules(particles=60_000, wrong=0.0, reach=0.0, share=0.0)
    localiser = MapLocaliser(map_, np.eye(4), rules)
    truth, prior = (
        np.array([5.0, 4.0, 0.0]),
        Gaussian(np.array([5.2, 3.9, 0.0]), np.diag([0.2, 0.1, 0])),
    )
    points = map_.means - [*truth[:2], 0] + 0.1 * rng.standard_normal((3, 3))
    covs = np.tile(np.diag([0.3, 0.2, 0.1]) ** 2, (3, 1, 1))
    seen = Observations(np.full(3, -1), points, covs)
    state = localiser.start(prior, rng=rng)
    state, _ = localiser.step(state, None, seen, map_.looks.means, costs=by_looks, rng=rng)
    information = np.linalg.inv(prior.cov[:2, :2])
    vector = information @ prior.mean[:2]
    for mu, S, v, C in zip(map_.means, map_.covs, points, covs, strict=True):
        weight = np.linalg.inv((S + C)[:2, :2])
        information, vector = information + weight, vector + weight @ (mu - v)[:2]
    cov = np.linalg.inv(information)
    np.testing.assert_allclose(state.pose[:2], cov @ vector, atol=0.005)
    np.testing.assert_allclose(state.clusters[0].cov[:2, :2], cov, atol=6e-4)


def test_the_particles_have_the_mean_of_a_grid(rng):
    map_ = building(rng, 2, sigma=0.1)
    rules = LocaliserRules(particles=100_000, wrong=0.2, unmatched=0.05, reach=0.2, share=0.0)
    area = np.array([[4.0, 3.0], [6.0, 5.0]])
    localiser = MapLocaliser(map_, np.eye(4), rules, area)
    back = se3.inverse(se3.from_se2(np.array([5.0, 4.0, 0.3])))
    points, covs = se3.act(back, map_.means) + 0.1, np.tile(0.1 * np.eye(3), (2, 1, 1))
    seen = Observations(np.full(2, -1), points, covs)
    state = localiser.start(rng=rng)
    state, info = localiser.step(state, None, seen, map_.looks.means, costs=by_looks, rng=rng)
    axes = [np.linspace(a, b, n, endpoint=False) + (b - a) / n / 2
            for a, b, n in ((4, 6, 30), (3, 5, 30), (-np.pi, np.pi, 90))]  # fmt: skip
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    rows = (np.concatenate([of, C[:, *UPPER]], axis=1) for of, C in
            ((points, covs), (map_.means, map_.covs)))  # fmt: skip
    ours = rules.reach**2, rules.wrong, rules.unmatched
    logs = _weigh(grid, next(rows), np.array([[0], [1]]), next(rows), *ours)
    weights = np.exp(logs - logs.max())
    assert info.log_evidence == pytest.approx(np.log(weights.mean()) + logs.max(), abs=0.02)
    weights /= weights.sum()
    np.testing.assert_allclose(
        state.particles.weights @ state.particles.states[:, :2], weights @ grid[:, :2], atol=0.02
    )


def test_one_landmark_leaves_a_circle(rng):
    map_ = LandmarkMap(np.array([[6.0, 4.0, 1.1]]), 1e-4 * np.eye(3)[None], looks(np.array([0])))
    area = np.array([[0.0, 0.0], [12.0, 8.0]])
    rules = LocaliserRules(particles=60_000, reach=0.1, wrong=0.0, roughness=(0, 0, 0))
    localiser = MapLocaliser(map_, rb.forward_mount(1.1), rules, area)
    seen = Observations(np.array([-1]), np.array([[0.0, 0.0, 2.0]]), 1e-4 * np.eye(3)[None])
    state = localiser.start(rng=rng)
    state, _ = localiser.step(state, None, seen, map_.looks.means, costs=by_looks, rng=rng)
    poses = state.particles.states
    off = map_.means[0, :2] - poses[:, :2]
    np.testing.assert_allclose(np.hypot(*off.T).mean(), 2.0, atol=0.05)
    ahead = off[:, 0] * np.cos(poses[:, 2]) + off[:, 1] * np.sin(poses[:, 2])
    assert ahead.mean() > 1.9  # all look at it
    quarter = np.floor(np.arctan2(off[:, 1], off[:, 0]) / (np.pi / 2)) + 2
    assert (np.bincount(quarter.astype(int)) > 0.15 * len(poses)).all()
    assert not state.located


# Buildings ---------------------------------------------------------------------------------------


def test_a_global_start_comes_to_the_truth(rng):
    localiser = MapLocaliser(building(rng), MOUNT)
    path = straight([3.0, 2.0, 0.4], 8)
    *_, (state, info) = drive(localiser, path, rng)
    assert np.hypot(*(state.pose - path[-1])[:2]) < 0.15
    assert abs(state.pose[2] - path[-1, 2]) < 0.05
    assert state.located
    assert info.agreeing == (info.names[:, 0] >= 0).sum()
    assert np.sqrt(np.trace(state.clusters[0].cov[:2, :2])) < 0.3


def twofold(rng):
    """Return a building that looks the same after half a turn about its middle."""
    half = building(rng, 40)
    turned = act(np.array([12.0, 8.0, np.pi]), half.means[:, :2])
    means = np.concatenate([half.means, np.column_stack([turned, half.means[:, 2]])])
    return LandmarkMap(means, np.tile(half.covs, (2, 1, 1)), looks(np.tile(np.arange(40), 2)))


def test_a_symmetric_building_gives_two_clusters(rng):
    rules = LocaliserRules(particles=20_000, candidates=2, share=0.2)
    localiser = MapLocaliser(twofold(rng), MOUNT, rules)
    path = straight([3.0, 2.0, 0.4], 2)
    *_, (state, _) = drive(localiser, path, rng)
    two = sorted(state.clusters[:2], key=lambda one: one.pose[0])
    mirrored = np.array([12.0, 8.0, 0.0]) - path[-1] * [1, 1, -1] + [0, 0, -np.pi]
    for one, pose in zip(two, sorted([path[-1], mirrored], key=lambda one: one[0]), strict=True):
        assert 0.1 < one.share < 0.9
        assert np.hypot(*(one.pose - pose)[:2]) < 0.3
        assert abs((one.pose - pose)[2]) < 0.15
    assert not state.located


def test_with_one_candidate_half_of_the_points_are_lost_in_a_symmetric_building(rng):
    map_ = twofold(rng)
    seen, found, rows = seen_from([3.0, 2.0, 0.4], map_)
    agreeing = []
    for candidates in (1, 2):
        rules = LocaliserRules(candidates=candidates, share=0.0)
        localiser = MapLocaliser(map_, MOUNT, rules)
        state = posed([[3.0, 2.0, 0.4]])
        _, info = localiser.step(state, None, seen, found, costs=by_looks, rng=rng)
        agreeing.append([(info.names == rows[:, None]).any(axis=1).mean(), info.names.shape[1]])
    assert agreeing[0][0] < 1.0
    assert agreeing[1] == [1.0, 2]


@pytest.mark.parametrize("source", ["matches", "area"])
def test_fresh_particles_find_a_robot_that_was_carried_away(source, rng):
    map_ = building(rng, 80)
    there, here = straight([2.0, 2.0, 0.2], 6), straight([9.0, 6.0, -2.5], 8)
    errors = {}
    for fresh in (0.0, 0.2):
        rules = LocaliserRules(particles=4000, fresh=fresh, source=source)
        localiser = MapLocaliser(map_, MOUNT, rules)
        *_, (state, _) = drive(localiser, there, rng)
        assert np.hypot(*(state.pose - there[-1])[:2]) < 0.2
        *_, (state, info) = drive(localiser, here, rng, state)
        errors[fresh] = np.hypot(*(state.pose - here[-1])[:2])
        assert (info.ancestors < 0).sum() <= fresh * 4000
    assert errors[0.0] > 1.5
    assert errors[0.2] < 0.5


def test_fresh_particles_have_the_mean_weight_and_no_ancestor(rng):
    map_ = building(rng)
    rules = LocaliserRules(particles=100, fresh=0.25, share=0.0)
    localiser = MapLocaliser(map_, MOUNT, rules)
    pose = np.array([5.0, 4.0, 0.3])
    seen, found, _ = seen_from(pose, map_)
    state = localiser.start(rng=rng)
    state, info = localiser.step(state, None, seen, found, costs=by_looks, rng=rng)
    new = info.ancestors < 0
    assert new.sum() == 25
    assert np.ptp(state.particles.log_weights[new]) < 1e-12
    np.testing.assert_allclose(state.particles.states[new], np.tile(pose, (25, 1)), atol=1e-6)
    assert not info.resampled


def test_one_picture_implies_the_pose(rng):
    map_ = building(rng)
    localiser = MapLocaliser(map_, MOUNT)
    for pose in ([5.0, 4.0, 0.3], [2.0, 6.0, -3.1]):
        seen, found, rows = seen_from(pose, map_)
        fix = localiser.fix(seen, found, costs=by_looks, rng=rng)
        np.testing.assert_allclose(fix.pose, pose, atol=1e-6)
        assert fix.support == len(rows)
        lied = found[rng.permutation(len(found))]
        lied[: len(found) // 2] = found[: len(found) // 2]
        fix = localiser.fix(seen, lied, costs=by_looks, rng=rng)
        np.testing.assert_allclose(fix.pose, pose, atol=1e-3)
        assert len(rows) // 2 <= fix.support < len(rows)


def test_one_match_implies_no_pose(rng):
    map_ = building(rng)
    localiser = MapLocaliser(map_, MOUNT)
    seen, found, _ = seen_from([5.0, 4.0, 0.3], map_)
    assert localiser.fix(seen[:1], found[:1], costs=by_looks, rng=rng) is None
    assert localiser.fix(seen, 0 * found, costs=by_looks, rng=rng) is None


def test_wheels_alone_and_a_picture_without_matches_leave_the_weights(rng):
    map_ = building(rng)
    localiser = MapLocaliser(map_, MOUNT, LocaliserRules(particles=500))
    state = localiser.start(Gaussian(np.array([5.0, 4.0, 0.3]), np.zeros((3, 3))), rng=rng)
    none = Observations(np.empty(0, dtype=int), np.empty((0, 3)), np.empty((0, 3, 3)))
    noise = np.diag([0.1, 0.05, 0.2]) ** 2
    state, info = localiser.step(
        state,
        Odometry(np.array([1.0, 0.0, 0.5]), noise),
        none,
        np.empty((0, 60)),
        costs=by_looks,
        rng=rng,
    )
    np.testing.assert_allclose(state.particles.weights, 1 / 500)
    assert info.effective == pytest.approx(500)
    assert not info.resampled
    moved = compose(np.array([5.0, 4.0, 0.3]), np.array([1.0, 0.0, 0.5]))
    np.testing.assert_allclose(state.particles.states.mean(axis=0), moved, atol=0.04)
    turned = state.particles.states - moved
    c, s = np.cos(0.3), np.sin(0.3)
    own = turned @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(own.std(axis=0), [0.1, 0.05, 0.2], rtol=0.15)
    assert not state.located  # nothing agrees


def test_a_step_leaves_the_state_that_it_is_given(rng):
    """Of a robot that stands, with headings beyond half a turn, of particles that stay."""
    map_ = building(rng)
    localiser = MapLocaliser(map_, MOUNT, LocaliserRules(particles=3, share=0.0))
    poses = np.array([[5.0, 4.0, 4.0], [6.0, 4.0, 7.0], [5.0, 3.0, -5.0]])
    before = posed(poses)
    seen, found, _ = seen_from((5.0, 4.0, 0.1), map_, rng)
    after, _ = localiser.step(before, None, seen, found, costs=by_looks, rng=rng)
    np.testing.assert_array_equal(before.particles.states, poses)
    assert (np.abs(after.particles.states[:, 2]) <= np.pi).all()


def test_particles_are_drawn_anew_below_the_share(rng):
    map_ = building(rng)
    seen, found, _ = seen_from([5.0, 4.0, 0.3], map_)
    for share, drawn in ((0.0, False), (0.5, True)):
        rules = LocaliserRules(particles=300, share=share, roughness=(0.1, 0.0, 0.0))
        localiser = MapLocaliser(map_, MOUNT, rules)
        begun = localiser.start(rng=rng)
        state, info = localiser.step(begun, None, seen, found, costs=by_looks, rng=rng)
        assert info.resampled is drawn
        assert info.effective < 150
        off = state.particles.states - begun.particles.states[info.ancestors]
        assert (off[:, 1:] == 0).all()
        assert (0.07 < off[:, 0].std() < 0.13) == drawn
        assert (len(set(info.ancestors.tolist())) < 300) == drawn


def test_the_limit_says_what_is_no_landmark(rng):
    map_ = building(rng)
    seen, found, _ = seen_from([5.0, 4.0, 0.3], map_)
    found = found + 100 / np.sqrt(found.shape[1])  # 100 from each
    for limit, known in ((101.0, True), (99.0, False)):
        localiser = MapLocaliser(map_, MOUNT, LocaliserRules(limit=limit))
        state = localiser.start(rng=rng)
        _, info = localiser.step(state, None, seen, found, costs=by_looks, rng=rng)
        assert (info.names >= 0).all() == known
        assert (info.names >= 0).any() == known


def test_the_start_is_all_over_the_area(rng):
    map_ = building(rng, 2000)
    np.testing.assert_allclose(map_.extent, [[0.12, 0.08], [11.88, 7.92]], atol=0.1)
    rules = LocaliserRules(particles=20_000)
    for area in (None, np.array([[-4.0, 1.0], [-2.0, 7.0]])):
        localiser = MapLocaliser(map_, MOUNT, rules, area)
        poses = localiser.start(rng=rng).particles.states
        low, high = map_.extent if area is None else area
        bounds = np.array([*low, -np.pi]), np.array([*high, np.pi])
        shares = (poses - bounds[0]) / (bounds[1] - bounds[0])
        assert ((shares >= 0) & (shares <= 1)).all()
        np.testing.assert_allclose(shares.mean(axis=0), 0.5, atol=0.01)
        np.testing.assert_allclose(shares.std(axis=0), np.sqrt(1 / 12), atol=0.01)


# What the particles say --------------------------------------------------------------------------


def test_clusters_are_heaps_of_weight(rng):
    heaps = [([0.0, 0.0, 3.1], 0.5), ([6.0, 1.0, 0.0], 0.3), ([0.0, 0.0, 0.5], 0.2)]
    poses = np.concatenate([at + 0.1 * rng.standard_normal((400, 3)) for at, _ in heaps])
    weights = np.repeat([share for _, share in heaps], 400)
    found = clusters(ParticleSet(poses, np.log(weights)), near=(1.0, 0.5))
    assert len(found) == 3
    for one, (at, share) in zip(found, heaps, strict=True):
        assert one.share == pytest.approx(share, abs=0.01)
        off = one.pose - at
        off[2] = (off[2] + np.pi) % (2 * np.pi) - np.pi
        np.testing.assert_allclose(off, 0, atol=0.03)
        np.testing.assert_allclose(one.cov, 0.01 * np.eye(3), atol=0.003)


@pytest.mark.parametrize("turn", [0.5, np.pi - 0.05, np.pi, -np.pi / 2])
def test_clusters_turn_with_the_headings(turn, rng):
    """Where the circle is cut does not matter: a heap that looks backwards is one heap, as wide."""
    heaps = [rng.normal([0, 0, 0], [0.3, 0.3, 0.1], (300, 3)) for _ in range(2)]
    heaps[1] += [8, 0, 0.02]
    poses, logs = np.concatenate(heaps), np.log(rng.uniform(0.5, 1, 600))
    turned = np.column_stack([poses[:, :2], wrap_angle(poses[:, 2] + turn)])
    before, after = (clusters(ParticleSet(p, logs), near=(1.5, 0.6)) for p in (poses, turned))
    assert len(before) == len(after) == 2
    for one, other in zip(before, after, strict=True):
        assert other.share == pytest.approx(one.share)
        off = other.pose - one.pose - [0, 0, turn]
        np.testing.assert_allclose([*off[:2], wrap_angle(off[2])], 0, atol=1e-9)
        np.testing.assert_allclose(other.cov, one.cov, atol=1e-9)


def test_opposite_headings_in_one_place_are_two_clusters(rng):
    """Halves that look two ways have no mean between them that anybody believes."""
    poses = rng.normal([0.25, 0.25, 0.8], [0.02, 0.02, 0.05], (400, 3))
    poses[200:, 2] -= 3.1
    found = clusters(ParticleSet(poses, np.zeros(400)), near=(1.0, 0.5))
    assert [round(one.share, 2) for one in found] == [0.5, 0.5]
    assert sorted(round(one.pose[2], 1) for one in found) == [-2.3, 0.8]


def test_the_map_is_that_of_the_heaviest_particle(rng):
    world = building(rng, 20)
    slam = VisualSlam(MOUNT, Options(particles=3, stable=0))
    state = slam.start(np.array([5.0, 4.0, 0.3]), length=20)
    seen, found, rows = seen_from([5.0, 4.0, 0.3], world)
    state, _ = slam.step(state, None, seen.named(rows), found, costs=by_looks, rng=rng)
    map_ = LandmarkMap.of(state)
    assert len(map_) == len(rows)
    np.testing.assert_allclose(map_.means, world.means[rows], atol=1e-9)
    np.testing.assert_array_equal(map_.looks.means, found)
    with pytest.raises(ValueError, match="at least one landmark"):
        LandmarkMap.of(slam.start(np.zeros(3), length=20))


# Bad input ---------------------------------------------------------------------------------------


def test_what_cannot_be_is_refused(rng):
    map_ = building(rng)
    localiser = MapLocaliser(map_, MOUNT)
    state = localiser.start(rng=rng)
    seen, found, _ = seen_from([5.0, 4.0, 0.3], map_)
    step = {"costs": by_looks, "rng": rng}
    bare = Observations(seen.ids, seen.values)
    with pytest.raises(ValueError, match=r"descriptors must be .* 60 numbers each"):
        localiser.step(state, None, seen, found[:, :5], **step)
    with pytest.raises(ValueError, match="with covariances"):
        localiser.step(state, None, bare, found, **step)
    with pytest.raises(ValueError, match="must not be negative or NaN"):
        localiser.step(state, None, seen, found, costs=lambda a: -by_looks(a), rng=rng)
    with pytest.raises(ValueError, match="landmarks"):
        localiser.step(state, None, seen, found, costs=lambda a: np.ones((1, 1)), rng=rng)
    with pytest.raises(ValueError, match="lower corner"):
        MapLocaliser(map_, MOUNT, area=np.ones((2, 2)))
    with pytest.raises(ValueError, match="one pose"):
        localiser.start(Gaussian(np.zeros(2), np.eye(2)), rng=rng)
    with unchecked(), pytest.raises(ValueError, match="source must be one of"):
        LocaliserRules(source="elsewhere")
    with pytest.raises(ValueError, match="looks must be of the 60 landmarks"):
        replace(map_, looks=looks(np.arange(3)))
    sharp = MapLocaliser(
        replace(map_, covs=0 * map_.covs), MOUNT, LocaliserRules(wrong=0.0, reach=0.0)
    )
    exact = Observations(seen.ids, seen.values, 0 * seen.covs)
    with pytest.raises(ValueError, match="cannot come from any particle"):
        sharp.step(state, None, exact, found, **step)
