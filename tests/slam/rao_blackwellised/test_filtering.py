"""The Rao-Blackwellised filter against the textbook version, Kalman filters and SciPy."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from robot_perception import kalman
from robot_perception.beliefs import Gaussian, ParticleSet
from robot_perception.observations import Observations, unnamed
from robot_perception.particles import effective_number
from robot_perception.slam.planar import Odometry, Velocity, dead_reckoning
from robot_perception.slam.rao_blackwellised import (
    ParticleMaps,
    RaoBlackwellisedSlam,
    add_landmarks,
    forward_mount,
    lineage,
    paths,
    predict,
    printed_number,
    resample,
    textbook,
    update,
)
from tests.slam.rao_blackwellised.drives import (
    MOUNT,
    assert_close,
    drive,
    maps_of,
    noises,
    seen_from,
)
from tests.unchecked import unchecked

seeds = st.integers(0, 10**6)
STILL = Odometry(np.zeros(3), np.zeros((3, 3)))
SLAM = RaoBlackwellisedSlam(MOUNT)


def tilted_mount(rng):
    """Return a mount with a random rotation and translation."""
    Q, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    mount = np.eye(4)
    mount[:3, :3] = Q * np.sign(np.linalg.det(Q))
    mount[:3, 3] = rng.standard_normal(3)
    return mount


def textbook_particles(maps):
    """Return the same belief as the textbook holds it."""
    particles = []
    for m, pose in enumerate(maps.poses):
        ids, places = maps.landmarks(m)
        landmarks = {
            name: Gaussian(mean, cov)
            for name, mean, cov in zip(ids.tolist(), places.mean, places.cov, strict=True)
        }
        weight = float(maps.particles.log_weights[m])
        particles.append(textbook.Particle(pose, landmarks, weight))
    return particles


def assert_same(maps, particles, relative=1e-9):
    """Compare a belief with that of the textbook."""
    assert_close(maps.poses, np.array([p.pose for p in particles]), relative)
    log_weights = ParticleSet(maps.poses, np.array([p.log_weight for p in particles])).log_weights
    assert_close(maps.particles.log_weights, log_weights, relative)
    for m, particle in enumerate(particles):
        ids, places = maps.landmarks(m)
        assert ids.tolist() == list(particle.landmarks)
        for i, place in enumerate(particle.landmarks.values()):
            assert_close(places.mean[i], place.mean, relative)
            assert_close(places.cov[i], place.cov, relative)


def test_the_mount_looks_where_the_robot_drives_to():
    """The camera sees a point that is ahead, to the left and above where it should be."""
    ahead = np.array([[5.0, 1.0, 2.0]])
    seen = seen_from(np.zeros(3), ahead)
    np.testing.assert_allclose(seen, [[0.06 - 1.0, 1.1 - 2.0, 5.0 - 0.15]])
    back = forward_mount(1.1, 0.15, 0.06) @ [*seen[0], 1.0]
    np.testing.assert_allclose(back, [*ahead[0], 1.0])
    assert np.linalg.det(MOUNT[:3, :3]) == 1.0


@given(seed=seeds, turning=st.booleans())
@settings(max_examples=20)
def test_predict_is_the_textbooks(seed, turning):
    rng = np.random.default_rng(seed)
    maps = maps_of(rng, 7, 2)
    root = rng.standard_normal((3, 3))
    motion = (
        Velocity(1.0, 3.0, 0.5, np.diag([0.1, 2.0]))
        if turning
        else Odometry(root[0], root @ root.T)
    )
    ours = predict(maps, motion, rng=np.random.default_rng(seed))
    one = np.random.default_rng(seed)
    assert_same(ours, [textbook.predict(p, motion, rng=one) for p in textbook_particles(maps)])
    assert (ours.poses[:, 2] >= -np.pi).all()
    assert (ours.poses[:, 2] < np.pi).all()


def test_draws_of_a_motion_have_its_covariance():
    """Of 20 000 draws; the error of a variance is its 1/100th, so five of these are allowed."""
    root = np.array([[0.2, 0.0, 0.0], [0.1, 0.05, 0.0], [-0.05, 0.04, 0.1]])
    maps = ParticleMaps.start(np.array([1.0, 2.0, 0.0]), 20_000)
    noise = root @ root.T
    moved = predict(maps, Odometry(np.array([0.5, 0.0, 0.1]), noise), rng=np.random.default_rng(1))
    steps = moved.poses - maps.poses
    scale = np.sqrt(np.outer(np.diag(noise), np.diag(noise)))
    assert (np.abs(np.cov(steps.T) - noise) < 0.05 * scale).all()
    deviations = np.sqrt(np.diag(noise) / 20_000)
    assert (np.abs(steps.mean(axis=0) - [0.5, 0.0, 0.1]) < 4 * deviations).all()


def test_a_certain_motion_moves_all_particles_alike():
    maps = ParticleMaps.start(np.array([1.0, 2.0, np.pi / 2]), 5)
    singular = np.diag([0.0, 0.01, 0.0])
    ours = predict(
        maps, Odometry(np.array([1.0, 0.0, 0.0]), singular), rng=np.random.default_rng(0)
    )
    np.testing.assert_allclose(ours.poses[:, 1], 3.0)  # no noise along
    assert np.ptp(ours.poses[:, 0]) > 0.01
    ours = predict(maps, Odometry(np.ones(3), np.zeros((3, 3))), rng=np.random.default_rng(0))
    assert (ours.poses == ours.poses[0]).all()


@given(seeds)
@settings(max_examples=30)
def test_update_is_the_textbooks(seed):
    rng = np.random.default_rng(seed)
    maps, mount = maps_of(rng, 4, 6), tilted_mount(rng)
    ids = rng.permutation(maps.ids)[:3]
    values = rng.standard_normal((3, 3))
    observed = Observations(ids, values, noises(values, rng))
    ours, seen = update(maps, observed, mount)
    theirs = [textbook.update(p, observed, mount) for p in textbook_particles(maps)]
    assert_same(ours, theirs)
    gained = [p.log_weight for p in theirs] - maps.particles.log_weights
    assert_close(seen.log_likelihoods, gained)
    np.testing.assert_array_equal(ours.covs, ours.covs.swapaxes(-1, -2))


@given(seeds)
@settings(max_examples=20)
def test_new_landmarks_are_the_textbooks(seed):
    rng = np.random.default_rng(seed)
    maps, mount = maps_of(rng, 4, 3), tilted_mount(rng)
    values = rng.standard_normal((2, 3))
    observed = Observations(np.array([70, 60]), values, noises(values, rng))
    ours = add_landmarks(maps, observed, mount)
    assert_same(
        ours, [textbook.add_landmarks(p, observed, mount) for p in textbook_particles(maps)]
    )
    assert ours.ids.tolist() == [*maps.ids.tolist(), 70, 60]


@given(seeds)
@settings(max_examples=15)
def test_a_drive_is_the_textbooks(seed):
    """Steps with resampling, new landmarks and old ones: the same draws give the same belief."""
    rng = np.random.default_rng(seed)
    world = drive(rng, steps=8, landmarks=8)
    maps = world.start(6)
    particles = textbook_particles(maps)
    one, two = np.random.default_rng(seed), np.random.default_rng(seed)
    for motion, look in zip(world.motions, world.looks, strict=True):
        old = np.array([name in particles[0].landmarks for name in look.ids.tolist()])
        maps, _ = SLAM.step(maps, motion, look, rng=one)
        particles = [textbook.predict(p, motion, rng=two) for p in particles]
        particles = [textbook.update(p, look[old], MOUNT) for p in particles]
        particles = textbook.resample(particles, rng=two)
        particles = [textbook.add_landmarks(p, look[~old], MOUNT) for p in particles]
    assert_same(maps, particles, 1e-7)


def kalman_map(world, poses):
    """Return landmarks and log likelihoods by `kalman.py` along a path, seen from each pose."""
    places, total = {}, 0.0
    for pose, look in zip(poses, world.looks, strict=True):
        T = textbook.camera_pose(pose, MOUNT)
        R, t = T[:3, :3], T[:3, 3]
        for name, value, noise in zip(look.ids.tolist(), look.values, look.covs, strict=True):
            if name not in places:
                places[name] = Gaussian(R @ value + t, R @ noise @ R.T)
                continue
            sensor = kalman.Sensor(R.T, noise)
            places[name], info = kalman.update(places[name], value + R.T @ t, sensor)
            total += float(info.log_likelihood)
    return places, total


def test_with_one_particle_and_perfect_odometry_the_map_is_the_kalman_map():
    world = drive(np.random.default_rng(3), slip=0.0, steps=30)
    maps, evidence, rng = world.start(1), 0.0, np.random.default_rng(0)
    for motion, look in zip(world.motions, world.looks, strict=True):
        maps, info = SLAM.step(maps, motion, look, rng=rng)
        evidence += info.log_evidence
        assert not info.resampled
    assert_close(maps.poses[0], world.poses[-1], 1e-12)
    places, total = kalman_map(world, world.poses[1:])
    ids, ours = maps.landmarks(0)
    for i, name in enumerate(ids.tolist()):
        assert_close(ours.mean[i], places[name].mean)
        assert_close(ours.cov[i], places[name].cov)
        miss = ours.mean[i] - world.landmarks[name]
        assert miss @ np.linalg.solve(ours.cov[i], miss) < 25  # of 15 with three degrees each
    np.testing.assert_allclose(evidence, total, rtol=1e-9)


def test_the_map_of_each_particle_is_the_exact_one_given_its_path():
    """Paths are put together from the ancestors; along each, filterpy and least squares agree."""
    world = drive(np.random.default_rng(5), steps=15)
    maps, rng = world.start(8), np.random.default_rng(1)
    poses, ancestors = [], []
    for motion, look in zip(world.motions, world.looks, strict=True):
        maps, info = SLAM.step(maps, motion, look, rng=rng)
        poses.append(maps.poses)
        ancestors.append(info.ancestors)
    assert any((row != np.arange(8)).any() for row in ancestors)
    lines, own = lineage(ancestors), paths(poses, ancestors)
    np.testing.assert_array_equal(own, np.stack(poses)[np.arange(15)[:, None], lines])
    np.testing.assert_array_equal(own[-1], maps.poses)
    for m in range(8):
        ids, ours = maps.landmarks(m)
        places, _ = kalman_map(world, own[:, m])
        filters, information = filterpy_map(world, own[:, m])
        for i, name in enumerate(ids.tolist()):
            assert_close(ours.mean[i], places[name].mean)
            assert_close(ours.cov[i], places[name].cov)
            assert_close(ours.mean[i], filters[name].x[:, 0])
            assert_close(ours.cov[i], filters[name].P)
            Y, y = information[name]
            assert_close(ours.mean[i], np.linalg.solve(Y, y))
            assert_close(ours.cov[i], np.linalg.inv(Y))


def filterpy_map(world, poses):
    """Return filterpy's filter of each landmark, and the normal equations of all its sights."""
    filters, information = {}, {}
    for pose, look in zip(poses, world.looks, strict=True):
        T = textbook.camera_pose(pose, MOUNT)
        R, t = T[:3, :3], T[:3, 3]
        for name, value, noise in zip(look.ids.tolist(), look.values, look.covs, strict=True):
            there, spread = R @ value + t, R @ noise @ R.T
            if name not in filters:
                filters[name] = peer = KalmanFilter(3, 3)
                peer.x, peer.P, peer.H = there[:, None], spread, np.eye(3)
            else:
                filters[name].update(there[:, None], R=spread)
            Y, y = information.get(name, (np.zeros((3, 3)), np.zeros(3)))
            weight = np.linalg.inv(spread)
            information[name] = Y + weight, y + weight @ there
    return filters, information


def test_many_particles_find_their_way_where_the_wheels_and_one_particle_do_not():
    """End of a circle, six drives: one particle adds its own noise to that of the wheels."""
    errors = {0: [], 1: [], 50: []}
    for seed in range(6):
        world = drive(np.random.default_rng(seed), steps=40, slip=4.0)
        reckoned = dead_reckoning(world.poses[0], world.motions)[-1]
        errors[0].append(np.hypot(*(reckoned - world.poses[-1])[:2]))
        for count in (1, 50):
            maps, rng = world.start(count), np.random.default_rng(seed)
            for motion, look in zip(world.motions, world.looks, strict=True):
                maps, _ = SLAM.step(maps, motion, look, rng=rng)
            errors[count].append(np.hypot(*(maps.pose - world.poses[-1])[:2]))
    wheels, one, many = (np.mean(errors[count]) for count in (0, 1, 50))
    assert many < 0.4 * wheels
    assert many < 0.4 * one


@given(seeds)
@settings(max_examples=20)
def test_weights_are_the_normal_densities_of_eq_4(seed):
    """Against SciPy, in the frame of the camera; many landmarks multiply, eq. (6)."""
    rng = np.random.default_rng(seed)
    maps, mount = maps_of(rng, 3, 4), tilted_mount(rng)
    values = rng.standard_normal((4, 3))
    observed = Observations(maps.ids, values, noises(values, rng))
    _, seen = update(maps, observed, mount)
    expected = np.zeros(3)
    for m, pose in enumerate(maps.poses):
        T = textbook.camera_pose(pose, mount)
        for n in range(4):
            mean = T[:3, :3].T @ (maps.means[m, n] - T[:3, 3])
            cov = T[:3, :3].T @ maps.covs[m, n] @ T[:3, :3] + observed.covs[n]
            cov = (cov + cov.T) / 2
            expected[m] += multivariate_normal(mean, cov).logpdf(values[n])
    assert_close(seen.log_likelihoods, expected, 1e-8)
    evidence = np.log(maps.particles.weights @ np.exp(expected - expected.max())) + expected.max()
    np.testing.assert_allclose(seen.log_evidence, evidence, rtol=1e-8)


@pytest.mark.parametrize("drawn", ["selective", "always"])
def test_a_resampled_map_is_no_ones_but_its_own(drawn):
    """A landmark of one of two copies is updated: that of the other stays as it was."""
    rng = np.random.default_rng(0)
    maps = maps_of(rng, 4, 3)
    heavy = np.log([0.94, 0.02, 0.02, 0.02])
    maps = ParticleMaps(ParticleSet(maps.poses, heavy), maps.ids, maps.means, maps.covs)
    copies, info = resample(maps, rng=rng, share=0.5 if drawn == "selective" else 1.0)
    twins = np.flatnonzero(info.ancestors == 0)
    assert twins.size >= 3
    np.testing.assert_array_equal(copies.means[twins[0]], copies.means[twins[1]])
    before, old = copies.means.copy(), maps.means.copy()
    names = np.full((4, 1), -1)
    names[twins[0]] = maps.ids[1]
    value = seen_from(copies.poses[twins[0]], copies.means[twins[0], 1:2]) + 0.3
    after, _ = update(copies, unnamed(value, 0.01 * np.eye(3)[None]), MOUNT, names)
    changed = (after.means != before).any(axis=-1)
    assert np.argwhere(changed).tolist() == [[twins[0], 1]]
    np.testing.assert_array_equal(copies.means, before)  # nor does the belief before change
    np.testing.assert_array_equal(maps.means, old)


def test_no_step_changes_the_belief_before():
    world = drive(np.random.default_rng(2), steps=12)
    maps, rng = world.start(5), np.random.default_rng(0)
    kept = []
    for motion, look in zip(world.motions, world.looks, strict=True):
        kept.append((maps, maps.poses.copy(), maps.particles.log_weights.copy(), maps.covs))
        maps, _ = SLAM.step(maps, motion, look, rng=rng)
    for maps, poses, log_weights, covs in kept:
        np.testing.assert_array_equal(maps.poses, poses)
        np.testing.assert_array_equal(maps.particles.log_weights, log_weights)
        np.testing.assert_array_equal(maps.covs, covs)


def test_resampling_keeps_each_particle_with_its_map_and_drops_what_nobody_holds():
    """Whatever the sharing inside: the maps are those of a plain copy, in less memory."""
    rng = np.random.default_rng(4)
    maps = maps_of(rng, 20, 9)
    means, covs, poses = maps.means, maps.covs, maps.poses
    for _ in range(6):
        log_weights = 2 * rng.standard_normal(20)
        maps = ParticleMaps(ParticleSet(poses, log_weights), maps.ids, means, covs)
        whole = maps.nbytes
        for _ in range(3):
            maps, info = resample(maps, rng=rng, share=1.0, scheme=picky)
            means, covs, poses = (a[info.ancestors] for a in (means, covs, poses))
            np.testing.assert_array_equal(maps.means, means)
            np.testing.assert_array_equal(maps.covs, covs)
            np.testing.assert_array_equal(maps.poses, poses)
            np.testing.assert_allclose(maps.particles.weights, 1 / 20)
        assert maps.nbytes < whole / 2


def test_a_landmark_takes_memory_while_particles_differ_in_it():
    """Twenty versions when it is seen, one when all particles descend from one."""
    rng = np.random.default_rng(0)
    maps, one = maps_of(rng, 20, 3), {"share": 1.0, "scheme": lambda *_, rng: np.full(20, 7)}
    alike, _ = resample(maps, rng=rng, **one)
    row = 9 * 8
    assert maps.nbytes - alike.nbytes == 3 * 19 * row
    values = seen_from(alike.poses[0], alike.means[0, :1])
    look = Observations(alike.ids[:1], values, 0.01 * np.eye(3)[None])
    spread = predict(alike, Odometry(np.zeros(3), 1e-4 * np.eye(3)), rng=rng)
    seen, _ = update(spread, look, MOUNT)
    assert seen.nbytes - alike.nbytes == 19 * row
    again, _ = resample(seen, rng=rng, **one)
    assert again.nbytes == alike.nbytes
    np.testing.assert_array_equal(again.means, np.tile(seen.means[7], (20, 1, 1)))


def picky(weights, count, *, rng):
    """Draw from few particles, in no order."""
    return rng.choice(rng.permutation(count)[: max(1, count // 3)], count)


def weighted(*weights):
    """Return particles of given weights, with empty maps."""
    poses = np.zeros((len(weights), 3))
    none = np.empty((len(weights), 0, 3))
    with np.errstate(divide="ignore"):
        particles = ParticleSet(poses, np.log(weights))
    return ParticleMaps(particles, np.empty(0, dtype=int), none, np.empty((len(weights), 0, 3, 3)))


@pytest.mark.parametrize(
    ("weights", "number"),
    [
        ((1, 1, 1, 1), 4.0),
        ((1, 0, 0, 0), 1.0),
        ((1, 1, 0, 0), 2.0),
        ((0.7, 0.1, 0.1, 0.1), 1 / 0.52),
    ],
)
def test_particles_are_drawn_anew_below_half_of_them(weights, number):
    """M/2 itself is not below; never with a share of 0, with 1 wherever weights differ."""
    maps, rng = weighted(*weights), np.random.default_rng(0)
    after, info = resample(maps, rng=rng)
    np.testing.assert_allclose(info.effective, number)
    assert info.resampled == (number < 2)
    assert (after is maps) == (number >= 2)
    if info.resampled:
        np.testing.assert_allclose(after.particles.weights, 0.25)
    else:
        assert info.ancestors.tolist() == [0, 1, 2, 3]
    assert not resample(maps, rng=rng, share=0.0)[1].resampled
    assert resample(maps, rng=rng, share=1.0)[1].resampled == (number < 4 - 1e-9)


def test_selective_resampling_draws_less_often_than_constant_and_more_than_never():
    world = drive(np.random.default_rng(11), steps=40, seen=2, slip=0.3)
    counts = {}
    for share in (0.0, 0.5, 1.0):
        slam = RaoBlackwellisedSlam(MOUNT, 30, share)
        maps, rng, counts[share] = slam.start(world.poses[0]), np.random.default_rng(0), 0
        for motion, look in zip(world.motions, world.looks, strict=True):
            maps, info = slam.step(maps, motion, look, rng=rng)
            assert info.resampled == (info.effective < share * 30)
            counts[share] += info.resampled
    assert counts[0.0] == 0 < counts[0.5] < counts[1.0]


@given(seed=seeds, count=st.integers(1, 30))
def test_the_printed_number_is_one_whatever_the_weights(seed, count):
    """So it decides nothing: with three particles and more it always resamples, with one never.

    With two it lies on the threshold M/2 = 1, where rounding decides.
    """
    rng = np.random.default_rng(seed)
    maps = weighted(*rng.uniform(0.1, 1.0, count))
    np.testing.assert_allclose(printed_number(maps.particles.log_weights), 1.0, rtol=1e-12)
    if count != 2:
        _, info = resample(maps, rng=rng, criterion=printed_number)
        assert info.resampled == (count > 2)


def test_of_weights_as_they_are_the_printed_number_depends_on_the_unit():
    """Two points with millimetres of noise: 'always' in metres, 'never' in millimetres."""
    densities = {}
    for name, unit in (("metres", 1.0), ("millimetres", 1000.0)):
        values = unit * np.array([[0.1, 0.2, 2.0], [0.3, -0.2, 3.0]])
        covs = np.tile((0.005 * unit) ** 2 * np.eye(3), (2, 1, 1))
        maps = ParticleMaps.start(np.zeros(3), 10)
        maps = add_landmarks(maps, Observations(np.arange(2), values, covs), MOUNT)
        _, seen = update(maps, Observations(np.arange(2), values, covs), MOUNT)
        densities[name] = printed_number(seen.log_likelihoods)
    assert densities["metres"] < 5 < densities["millimetres"]
    assert printed_number(np.full(4, -1e5)) == np.inf
    assert effective_number(np.full(4, -1e5)) == pytest.approx(4)


def test_lineage_is_that_of_ancestors_followed_by_hand():
    rows = [np.array([0, 0, 2]), np.array([1, 2, 2]), np.array([0, 0, 1])]
    np.testing.assert_array_equal(lineage(rows), [[1, 1, 2], [0, 0, 1], [0, 1, 2]])
    np.testing.assert_array_equal(lineage(rows[:1]), [[0, 1, 2]])


def test_paths_are_poses_of_ancestors_followed_by_hand():
    rows = [np.array([0, 1]), np.array([1, 1]), np.array([0, 0])]
    poses = [np.array([[k, 0, 0.0], [k, 1, 0]]) for k in range(3)]
    expected = [[[0, 1, 0], [0, 1, 0]], [[1, 0, 0], [1, 0, 0]], [[2, 0, 0], [2, 1, 0]]]
    np.testing.assert_array_equal(paths(poses, rows), expected)


def test_the_mean_pose_turns_round():
    poses = np.array([[0.0, 1.0, np.pi - 0.1], [2.0, 3.0, -np.pi + 0.1], [9.0, 9.0, 0.0]])
    none = np.empty((3, 0, 3))
    particles = ParticleSet(poses, np.array([0.0, 0.0, -np.inf]))
    maps = ParticleMaps(particles, np.empty(0, dtype=int), none, np.empty((3, 0, 3, 3)))
    np.testing.assert_allclose(maps.pose[:2], [1.0, 2.0])
    np.testing.assert_allclose(np.cos(maps.pose[2]), -1.0)
    assert maps.best == 0


def test_many_updates_leave_covariances_positive_and_as_they_should_be():
    """Two thousand sights of one point: the variance falls like 1/k, to nine digits."""
    maps = ParticleMaps.start(np.array([0.0, 0.0, 0.4]), 1)
    value, noise = (
        np.array([[0.3, -0.2, 2.5]]),
        noises(np.array([[0.3, -0.2, 2.5]]), np.random.default_rng(0)),
    )
    look = Observations(np.array([3]), value, noise)
    maps = add_landmarks(maps, look, MOUNT)
    first = maps.covs[0, 0]
    for _ in range(2000):
        maps, _ = update(maps, look, MOUNT)
    assert_close(maps.covs[0, 0], first / 2001, 1e-9)
    assert np.linalg.eigvalsh(maps.covs[0, 0]).min() > 0


def test_a_particle_that_recognises_fewer_points_pays_for_it():
    """Of two particles one takes a point for new: its density is the one that the caller states."""
    maps = ParticleMaps.start(np.zeros(3), 2)
    value, noise = np.array([[0.3, -0.2, 2.5]]), 0.01 * np.eye(3)[None]
    maps = add_landmarks(maps, Observations(np.array([3]), value, noise), MOUNT)
    after, seen = update(
        maps, unnamed(value, noise), MOUNT, np.array([[3], [-1]]), unmatched_density=2.0
    )
    density = multivariate_normal(np.zeros(3), 0.02 * np.eye(3)).pdf(np.zeros(3))
    np.testing.assert_allclose(np.exp(seen.log_likelihoods), [density, 2.0])
    np.testing.assert_allclose(after.particles.weights, np.array([density, 2.0]) / (density + 2.0))
    np.testing.assert_allclose(after.covs[0, 0], maps.covs[0, 0] / 2)
    np.testing.assert_array_equal(after.covs[1], maps.covs[1])


def test_a_landmark_of_some_particles_is_no_others():
    maps = ParticleMaps.start(np.zeros(3), 3)
    values, noise = (
        np.array([[0.3, -0.2, 2.5], [0.1, 0.1, 1.0]]),
        np.tile(0.01 * np.eye(3), (2, 1, 1)),
    )
    where = np.array([[True, False], [True, True], [False, False]])
    look = Observations(np.array([3, 4]), values, noise)
    maps = add_landmarks(maps, look, MOUNT, where)
    np.testing.assert_array_equal(maps.known, where)
    np.testing.assert_array_equal(np.isnan(maps.means).all(axis=-1), ~where)
    np.testing.assert_array_equal(np.isnan(maps.covs).all(axis=(-1, -2)), ~where)
    assert [maps.landmarks(m)[0].tolist() for m in range(3)] == [[3], [3, 4], []]
    with pytest.raises(ValueError, match="some particles do not have"):
        update(maps, look, MOUNT)
    with pytest.raises(ValueError, match="assignment gives particles landmarks that they do not"):
        update(maps, look.anonymous(), MOUNT, np.array([[-1, -1], [-1, -1], [3, -1]]))
    after, _ = update(maps, look.anonymous(), MOUNT, np.array([[3, -1], [-1, 4], [-1, -1]]))
    np.testing.assert_array_equal(after.known, where)
    np.testing.assert_allclose(after.covs[0, 0], maps.covs[0, 0] / 2)
    np.testing.assert_allclose(after.covs[1, 0], maps.covs[1, 0])
    drawn, _ = resample(
        after,
        rng=np.random.default_rng(0),
        share=1.0,
        criterion=lambda _: 0.0,
        scheme=lambda *_, rng: np.array([2, 1, 1]),
    )
    np.testing.assert_array_equal(drawn.known, where[[2, 1, 1]])
    np.testing.assert_array_equal(drawn.means[1], after.means[1])
    drawn, _ = resample(
        drawn,
        rng=np.random.default_rng(0),
        share=1.0,
        criterion=lambda _: 0.0,
        scheme=lambda *_, rng: np.array([2, 2, 0]),
    )
    np.testing.assert_array_equal(drawn.known, where[[1, 1, 2]])
    np.testing.assert_array_equal(drawn.means[0], after.means[1])


def test_without_observations_nothing_is_learnt():
    maps, rng = maps_of(np.random.default_rng(0), 3, 2), np.random.default_rng(0)
    none = Observations(np.empty(0, dtype=int), np.empty((0, 3)), np.empty((0, 3, 3)))
    after, seen = update(maps, none, MOUNT)
    np.testing.assert_array_equal(after.means, maps.means)
    np.testing.assert_allclose(after.particles.weights, maps.particles.weights, rtol=1e-14)
    np.testing.assert_array_equal(seen.log_likelihoods, 0.0)
    np.testing.assert_allclose(seen.log_evidence, 0.0, atol=1e-15)
    after, info = SLAM.step(ParticleMaps.start(np.zeros(3), 4), STILL, none, rng=rng)
    assert after.means.shape == (4, 0, 3)
    assert info.effective == pytest.approx(4)
    assert add_landmarks(maps, none, MOUNT).ids.tolist() == maps.ids.tolist()


def test_an_observation_without_a_name_is_left_out_of_a_step():
    maps, rng = ParticleMaps.start(np.zeros(3), 2), np.random.default_rng(0)
    values, noise = np.ones((2, 3)), np.tile(np.eye(3), (2, 1, 1))
    maps, _ = SLAM.step(maps, STILL, Observations(np.array([-1, 5]), values, noise), rng=rng)
    assert maps.ids.tolist() == [5]
    np.testing.assert_allclose(maps.means[0, 0], (MOUNT @ np.ones(4))[:3])


def wrong_look(**changed):
    parts = {"ids": np.array([3]), "values": np.ones((1, 3)), "covs": np.eye(3)[None]}
    return Observations(**{**parts, **changed})


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: update(m, wrong_look(ids=np.array([9])), MOUNT), r"not in the map: \[9\]"),
        (lambda m: update(m, wrong_look(ids=np.array([-1])), MOUNT), r"not in the map: \[-1\]"),
        (
            lambda m: update(m, wrong_look(covs=None), MOUNT),
            r"with covariances, got \(1, 3\) with none",
        ),
        (
            lambda m: update(m, wrong_look(values=np.ones((1, 2)), covs=np.eye(2)[None]), MOUNT),
            r"points \(m, 3\) with covariances, got \(1, 2\)",
        ),
        (
            lambda m: update(m, wrong_look(), 2 * MOUNT),
            "mount must be a rotation and a translation",
        ),
        (lambda m: update(m, wrong_look(), np.diag([1.0, 1, -1, 1])), "mount must be a rotation"),
        (
            lambda m: update(m, wrong_look(), MOUNT, np.array([[3], [8]])),
            r"assignment names .*\[8\]",
        ),
        (lambda m: update(m, wrong_look(), MOUNT, np.array([[3]])), r"assignment must be \(2, 1\)"),
        (
            lambda m: update(
                m,
                unnamed(np.ones((2, 3)), np.tile(np.eye(3), (2, 1, 1))),
                MOUNT,
                np.array([[-1, -1], [3, 3]]),
            ),
            "landmark of a particle to two observations",
        ),
        (
            lambda m: update(m, wrong_look(values=np.full((1, 3), 1e200)), MOUNT),
            "values must be within 1e.100",
        ),
        (lambda m: add_landmarks(m, wrong_look(), MOUNT), r"in the map already: \[3\]"),
        (lambda m: add_landmarks(m, wrong_look().anonymous(), MOUNT), "need names, got -1"),
        (
            lambda m: add_landmarks(m, wrong_look(ids=np.array([4])), MOUNT, np.ones((1, 2), bool)),
            r"where must be booleans \(2, 1\), got bool \(1, 2\)",
        ),
        (
            lambda m: resample(m, rng=np.random.default_rng(0), criterion=2),
            "criterion must be a function, got 2",
        ),
        (
            lambda m: resample(m, rng=np.random.default_rng(0), criterion=lambda _: np.nan),
            "criterion must be a number",
        ),
        (
            lambda m: resample(
                m,
                rng=np.random.default_rng(0),
                criterion=lambda _: 0.0,
                scheme=lambda *_, rng: np.array([0, 2]),
            ),
            "scheme must draw from 2 particles, got 2",
        ),
        (lambda m: lineage([]), "ancestors must be rows of one length"),
        (lambda m: lineage([np.array([0, 2])]), "ancestors must be of 2 particles, got more"),
        (lambda m: paths([], [np.array([0, 1])]), "poses must be of 1 steps, got 0"),
        (
            lambda m: paths([np.zeros((3, 3))], [np.array([0, 1])]),
            r"poses must be \(2, 3\) for each step, got \(3, 3\)",
        ),
        (lambda m: m.landmarks(2), "particle must be from 0 to 1, got 2"),
        (lambda m: printed_number(np.full(3, -np.inf)), "log_weights must not all be -inf"),
        (lambda m: printed_number(np.array([0.0, np.nan])), "log_weights must be finite or -inf"),
        (
            lambda m: RaoBlackwellisedSlam(MOUNT, criterion=2),
            "criterion must be a function, got 2",
        ),
        (lambda m: RaoBlackwellisedSlam(2 * MOUNT), "mount must be a rotation"),
        (lambda m: RaoBlackwellisedSlam(MOUNT, 0), "particles must be at least 1, got 0"),
        (lambda m: RaoBlackwellisedSlam(MOUNT, share=2.0), "share must be"),
        (lambda m: ParticleMaps.start(np.zeros(3), 0), "count must be at least 1, got 0"),
    ],
)
def test_what_is_wrong_is_said(call, message):
    look = Observations(np.array([3]), np.ones((1, 3)), np.eye(3)[None])
    maps = add_landmarks(ParticleMaps.start(np.zeros(3), 2), look, MOUNT)
    with (
        unchecked(),
        pytest.raises(ValueError if "a function" not in message else TypeError, match=message),
    ):
        call(maps)


def test_two_sights_without_noise_are_refused():
    """A point seen exactly is known exactly; a second exact sight has a singular innovation."""
    exact = Observations(np.array([3]), np.ones((1, 3)), np.zeros((1, 3, 3)))
    maps = add_landmarks(ParticleMaps.start(np.zeros(3), 2), exact, MOUNT)
    with pytest.raises(
        ValueError, match="observations: the covariance of an innovation is singular"
    ):
        update(maps, exact, MOUNT)
    for seed in range(20):  # exact along one direction, wherever it points
        mount = tilted_mount(np.random.default_rng(seed))
        flat = Observations(np.array([3]), np.ones((1, 3)), np.diag([1.0, 1.0, 0.0])[None])
        maps = add_landmarks(ParticleMaps.start(np.zeros(3), 2), flat, mount)
        with pytest.raises(ValueError, match="singular"):
            update(maps, flat, mount)


@pytest.mark.parametrize("bad", [[0.0, np.nan], [-np.inf, -np.inf]])
def test_weights_that_are_none_are_refused(bad):
    maps = weighted(1, 1)
    with unchecked(), pytest.raises(ValueError, match="log_weights"):
        ParticleMaps(ParticleSet(maps.poses, np.array(bad)), maps.ids, maps.means, maps.covs)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ids": np.array([3, 3])}, r"ids must differ, got \[3, 3\]"),
        ({"ids": np.array([3, -1])}, "ids must be at least 0, got -1"),
        ({"means": np.zeros((2, 3, 3))}, r"means must be \(2, 2, 3\) for 2 particles and 2 ids"),
        ({"means": np.full((2, 2, 3), np.nan)}, "means must be finite"),
        ({"covs": -np.ones((2, 2, 3, 3))}, "covs must be positive semi-definite"),
        ({"particles": ParticleSet.uniform(np.zeros((2, 2)))}, r"particles must be \(M, 3\)"),
    ],
)
def test_a_belief_checks_what_it_is_made_of(change, message):
    parts = {
        "particles": ParticleSet.uniform(np.zeros((2, 3))),
        "ids": np.array([3, 4]),
        "means": np.zeros((2, 2, 3)),
        "covs": np.tile(np.eye(3), (2, 2, 1, 1)),
    }
    with unchecked(), pytest.raises(ValueError, match=message):
        ParticleMaps(**{**parts, **change})


def test_textbook_says_what_is_wrong():
    look = wrong_look()
    particle = textbook.Particle(np.zeros(3), {3: Gaussian(np.ones(3), np.eye(3))})
    with pytest.raises(
        ValueError, match="observations name a landmark that the particle has not: 4"
    ):
        textbook.update(particle, wrong_look(ids=np.array([4])), MOUNT)
    with pytest.raises(ValueError, match="not yet in the map"):
        textbook.add_landmarks(particle, look, MOUNT)
    with pytest.raises(ValueError, match="particles must be at least one"):
        textbook.resample([], rng=np.random.default_rng(0))
    with pytest.raises(ValueError, match=r"landmarks\[3\] must be \(3,\), got \(2,\)"):
        textbook.Particle(np.zeros(3), {3: Gaussian(np.ones(2), np.eye(2))})
