"""A step of the Rao-Blackwellised filter, how it grows, the memory of its maps, and association.

A step is motion, update, and drawing particles anew where need be. Landmarks have been seen for a
while before it is timed, so that particles share what they have inherited.
"""

import time

import numpy as np

from robot_perception.beliefs import Gaussian, ParticleSet
from robot_perception.observations import Observations
from robot_perception.slam.planar import Odometry
from robot_perception.slam.rao_blackwellised import (
    ParticleMaps,
    RaoBlackwellisedSlam,
    associate_each,
    associate_shared,
    forward_mount,
    textbook,
)
from tests.tools.benchmarks.harness import Row, Timing

SEEN, STEPS = 8, 20
MOUNT = forward_mount(1.1)
MOTION = Odometry(np.zeros(3), np.diag([0.01**2, 0.005**2, 0.005**2]))
TARGET = 0.3e-6


def world(particles: int, landmarks: int) -> tuple[ParticleMaps, list[Observations]]:
    """Return maps after a while of looking round, and the next sights of eight landmarks each."""
    rng = np.random.default_rng(landmarks)
    places = rng.uniform([2, -3, 0], [8, 3, 2], (landmarks, 3))
    means = places + 0.02 * rng.standard_normal((particles, landmarks, 3))
    covs = np.tile(0.02**2 * np.eye(3), (particles, landmarks, 1, 1))
    poses = 0.02 * rng.standard_normal((particles, 3))
    maps = ParticleMaps(ParticleSet.uniform(poses), np.arange(landmarks), means, covs)
    looks = [look(places, rng) for _ in range(2 * STEPS)]
    return run(maps, looks[:STEPS]), looks[STEPS:]


def look(places: np.ndarray, rng: np.random.Generator, seen: int = SEEN) -> Observations:
    """Return the sight of some landmarks by a stereo rig at the origin."""
    ids = rng.permutation(len(places))[:seen]
    values = (places[ids] - MOUNT[:3, 3]) @ MOUNT[:3, :3]
    deviations = np.stack([np.full(seen, 0.02)] * 2 + [0.01 * values[:, 2] ** 2], axis=-1)
    noisy = values + deviations * rng.standard_normal((seen, 3))
    return Observations(ids, noisy, deviations[:, :, None] ** 2 * np.eye(3))


def run(maps: ParticleMaps, looks: list[Observations]) -> ParticleMaps:
    """Return the belief after steps."""
    slam, rng = RaoBlackwellisedSlam(MOUNT), np.random.default_rng(0)
    for seen in looks:
        maps, _ = slam.step(maps, MOTION, seen, rng=rng)
    return maps


def as_textbook(maps: ParticleMaps) -> list[textbook.Particle]:
    """Return the same belief as the textbook version holds it."""
    particles = []
    for m, pose in enumerate(maps.poses):
        ids, places = maps.landmarks(m)
        beliefs = [Gaussian(*both) for both in zip(places.mean, places.cov, strict=True)]
        landmarks = dict(zip(ids.tolist(), beliefs, strict=True))
        particles.append(textbook.Particle(pose, landmarks, float(maps.particles.log_weights[m])))
    return particles


def run_textbook(
    particles: list[textbook.Particle], looks: list[Observations]
) -> list[textbook.Particle]:
    """Return the same as `run`, one particle and one landmark at a time."""
    rng = np.random.default_rng(0)
    for seen in looks:
        particles = [textbook.predict(p, MOTION, rng=rng) for p in particles]
        particles = [textbook.update(p, seen, MOUNT) for p in particles]
        particles = textbook.resample(particles, rng=rng)
    return particles


def _step(particles: int, landmarks: int) -> Row:
    maps, looks = world(particles, landmarks)
    plain = as_textbook(maps)

    def agree() -> None:
        ours, theirs = run(maps, looks), run_textbook(plain, looks)
        np.testing.assert_allclose(ours.poses, [p.pose for p in theirs], rtol=0, atol=1e-9)
        means = [[place.mean for place in p.landmarks.values()] for p in theirs]
        np.testing.assert_allclose(ours.means, means, rtol=0, atol=1e-6)

    return Row(
        work=f"Rao-Blackwellised filter, {STEPS} steps, {particles} particles, {SEEN} landmarks "
        f"seen of {landmarks} (the limit is {TARGET * 1e6:g} µs per particle and landmark seen)",
        ours=lambda: run(maps, looks),
        peer=lambda: run_textbook(plain, looks),
        peer_name="the textbook version in Python",
        at_most=STEPS * TARGET * particles * SEEN,
        agree=agree,
        repeats=3,
    )


def growth(name: str, sizes: list[tuple[int, int]]) -> Timing:
    """Return the exponent of the time of a step against particles or landmarks in the map."""
    worlds, samples = [world(*size) for size in sizes], []
    for maps, looks in worlds:
        run(maps, looks)
    for _ in range(7):
        for maps, looks in worlds:  # in turn, so that a busy spell hits all sizes
            begin = time.perf_counter()
            run(maps, looks)
            samples.append((time.perf_counter() - begin) / STEPS)
    seconds = np.median(np.reshape(samples, (-1, len(sizes))), axis=0)
    return _grown(f"Rao-Blackwellised step, {name}", np.prod(sizes, axis=1), seconds, seconds[-1])


def corridor(particles: int, landmarks: int) -> ParticleMaps:
    """Return maps of a drive on which landmarks come and go, two new ones a step."""
    slam, rng = RaoBlackwellisedSlam(MOUNT), np.random.default_rng(0)
    maps = ParticleMaps.start(np.zeros(3), particles)
    places = rng.uniform([2, -3, 0], [8, 3, 2], (landmarks, 3))
    for first in range(0, landmarks - SEEN + 1, 2):
        seen = look(places[first : first + SEEN], rng)
        seen = seen.named(seen.ids + first)
        maps, _ = slam.step(maps, MOTION, seen, rng=rng)
    return maps


def memory(name: str, sizes: list[tuple[int, int]]) -> Timing:
    """Return the exponent of the memory of the maps, and beside it what plain arrays would take."""
    begin = time.perf_counter()
    held = [corridor(*size).nbytes for size in sizes]
    seconds = (time.perf_counter() - begin) / len(sizes)
    particles, landmarks = sizes[-1]
    plain = particles * landmarks * 12 * 8
    work = (
        f"Rao-Blackwellised maps after a drive, {name}: {held[-1] / 1e6:.2f} MB, "
        f"in plain arrays {plain / 1e6:.1f} MB; memory"
    )
    return _grown(work, np.prod(sizes, axis=1), np.array(held), seconds)


def _grown(work: str, sizes: np.ndarray, values: np.ndarray, seconds: float) -> Timing:
    """Return a row on growth, which must not be faster than linear but for a little."""
    exponent = float(np.polyfit(np.log(sizes), np.log(values), 1)[0])
    return Timing(
        work=f"{work}: exponent {exponent:.2f}",
        ours_s=float(seconds),
        peer_s=None,
        peer_name="",
        target="exponent ≤ 1.2",
        reached=exponent <= 1.2,
    )


def association(points: int, landmarks: int, particles: int) -> Row:
    """Return a row on names by each particle's own map, beside names that all share.

    Descriptors leave a tenth of the pairs to the gate. Half of the points have been followed, and
    each particle holds them for a landmark of its own map.
    """
    rng = np.random.default_rng(0)
    maps, _ = world(particles, landmarks)
    seen = look(maps.means[0], rng, points)
    costs = rng.random((points, landmarks))
    costs[np.arange(points), seen.ids] = 0.0
    held = np.where(np.arange(points) < points // 2, seen.ids, -1)
    costs[: points // 2] = np.where(costs[: points // 2] == 0.0, 0.0, np.inf)
    look_up = {"costs": costs, "limit": 0.1, "level": 0.999}
    unknown, own = seen.anonymous(), np.tile(held, (particles, 1))

    def shared() -> np.ndarray:
        return associate_shared(maps, unknown, MOUNT, **look_up)

    def each() -> np.ndarray:
        return associate_each(maps, unknown, MOUNT, own, **look_up)

    def agree() -> None:
        alone = ParticleMaps(
            ParticleSet.uniform(maps.poses[:1]), maps.ids, maps.means[:1], maps.covs[:1]
        )
        first = associate_shared(alone, unknown, MOUNT, by="best", **look_up)
        np.testing.assert_array_equal(each()[0], first)

    return Row(
        work=f"Rao-Blackwellised association, {points} points × {landmarks} landmarks × "
        f"{particles} particles: each particle by its own map (the target is three times the time "
        "of shared names)",
        ours=each,
        peer=shared,
        peer_name="names that all particles share",
        ratio=1 / 3,
        agree=agree,
        inner=20,
    )


def rows() -> list[Row | Timing]:
    """Return the rows of the benchmark table that concern the Rao-Blackwellised filter."""
    particles, landmarks = (50, 100, 200, 400), (250, 500, 1000, 2000)
    many, long = (25, 50, 100, 200), (190, 375, 750, 1500)
    return [
        _step(100, 500),
        association(30, 1500, 10),
        growth("50 to 400 particles, 500 landmarks", [(m, 500) for m in particles]),
        growth("100 particles, 250 to 2000 landmarks", [(100, n) for n in landmarks]),
        memory("25 to 200 particles × 1500 landmarks", [(m, 1500) for m in many]),
        memory("100 particles × 190 to 1500 landmarks", [(100, n) for n in long]),
    ]
