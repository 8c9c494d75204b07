"""Runs over random worlds against whole matrices: every sensor, association, noise and size."""

import numpy as np
import pytest

from robot_perception.slam.planar import (
    Association,
    CartesianSensor,
    Compass,
    MapBelief,
    Observations,
    Odometry,
    PositionFix,
    RangeBearing,
    Settings,
    Step,
    Truth,
    Velocity,
    run_filter,
)
from tests.slam.planar.dense import assert_is_dense

SIZES = (0, 30, 59)  # landmarks: 3, 63 and 121 states, that grow in every run
STEPS = 8
BIAS = 0.3
ASSOCIATIONS = [
    Association(),
    Association("known", 0.6),
    Association("gated", 0.9, 0.99),
    Association("joint", 0.9, 0.99),
]


def covariances(rng, count, size):
    """Return covariances that are far from diagonal and from each other."""
    roots = rng.standard_normal((count, size, size)) * rng.choice([0.003, 0.03], (count, 1, 1))
    return roots @ roots.mT + 1e-6 * np.eye(size)


def world(rng, size, polar, named):
    """Return a belief in many landmarks, a drive, anchors and the truth, which the belief fits.

    Some landmarks of each scan are in the map, some anchors, some new, and one may be seen again,
    without its name. Unless all are ``named``, most others have none either.
    """
    count = size + 3 + STEPS
    names = rng.permutation(200)[:count].tolist()
    reach, direction = rng.uniform(3, 12, count), rng.uniform(-np.pi, np.pi, count)
    places = reach * np.exp(1j * direction)
    root = 0.03 * rng.standard_normal((3 + 2 * size, 3 + 2 * size)) / np.sqrt(3 + 2 * size)
    mean = np.r_[0.3, -0.2, rng.uniform(-np.pi, np.pi), places[:size].view(float)]
    true = mean + root @ rng.standard_normal(mean.size)
    places[:size] = true[3::2] + 1j * true[4::2]
    here, heading = complex(*true[:2]), true[2]
    anchors = {names[j]: places[[j]].view(float) for j in (size, size + 1)}
    poses, steps, near, first = [true[:3]], [], rng.permutation(size)[:8], rng.integers(3)
    for k in range(STEPS):
        speed, rate, kind = rng.uniform(0.1, 0.5), rng.choice([0.0, 2.0, -2.0]), (first + k) % 3
        if kind == 0:
            noise = covariances(rng, 1, 3)[0]
            error = np.linalg.cholesky(noise) @ rng.standard_normal(3)
            motion = Odometry(np.array([speed, 0.1, rate]) + error, noise)
            here, heading = here + complex(speed, 0.1) * np.exp(1j * heading), heading + rate
        elif kind == 1:
            motion = Velocity(speed, rate, 0.5, covariances(rng, 1, 2)[0])
            moved = motion.move(np.array([here.real, here.imag, heading]))
            here, heading = complex(*moved[:2]), moved[2]
        else:
            motion = None
        poses.append([here.real, here.imag, heading])
        pick = np.r_[rng.permutation(near)[:4], rng.integers(size, size + 2), size + 2 + k]
        pick = rng.permutation(np.r_[pick, pick[-1] + 1][: rng.integers(1, 8)])
        pick = np.r_[pick, pick[:1]]
        relative = (places[pick] - here) * np.exp(-1j * heading)
        values = np.stack([relative.real, relative.imag], axis=-1)
        if polar:
            values = np.stack([np.abs(relative) + BIAS, np.angle(relative)], axis=-1)
        covs = covariances(rng, pick.size, 2)
        errors = np.linalg.cholesky(covs) @ rng.standard_normal((pick.size, 2, 1))
        ids = np.array(names)[pick]
        ids[rng.random(pick.size) < (0.1 if named else 0.7)] = -1
        ids[-1] = -1
        observed = Observations(ids, values + errors[..., 0], covs if rng.random() < 0.7 else None)
        at = np.array([here.real, here.imag])
        fixes = (
            PositionFix(at + 0.03 * rng.standard_normal(2), covariances(rng, 1, 2)[0]),
            Compass(heading + 0.03 * rng.standard_normal(), 1e-3),
            Compass(heading, 2e-3),
        )
        steps.append(Step(motion, observed, fixes[: rng.integers(4)]))
    landmarks = {name: np.array([p.real, p.imag]) for name, p in zip(names, places, strict=True)}
    return (
        MapBelief(mean, root @ root.T, np.array(names)[:size]),
        steps,
        anchors,
        Truth(np.array(poses), dict.fromkeys(range(230), np.array([5.0, 5.0])) | landmarks),
    )


@pytest.mark.parametrize("association", ASSOCIATIONS, ids=repr)
@pytest.mark.parametrize("linearisation", ["latest", "first", "truth"])
@pytest.mark.parametrize("size", SIZES)
def test_a_run_is_the_dense_filters(association, linearisation, size):
    for seed in range(3):
        rng = np.random.default_rng([seed, size])
        polar = bool((seed + size) % 2)
        noise = covariances(rng, 1, 2)[0]
        start, steps, anchors, truth = world(rng, size, polar, association.kind == "known")
        settings = Settings(
            RangeBearing(noise, BIAS) if polar else CartesianSensor(noise),
            anchors,
            association,
            truth if linearisation == "truth" else linearisation,
            revision_limit=(None, 1, 2)[seed % 3],
            retirement=("freeze", "freeze", "consider")[seed % 3],
            keep=range(STEPS),
        )
        assert_is_dense(run_filter(start, steps, settings), start, steps, settings)


def in_units(step, unit):
    """Return a step with its lengths in another unit."""
    motion, seen, across = step.motion, step.observations, np.array([unit, unit, 1.0])
    if isinstance(motion, Odometry):
        noise = motion.noise * np.outer(across, across)
        motion = Odometry(motion.increment * across, noise)
    elif motion is not None:
        noise = motion.noise * np.outer(across[1:], across[1:])
        motion = Velocity(motion.speed * unit, motion.turn_rate, motion.duration, noise)
    covs = None if seen.covs is None else seen.covs * unit**2
    fixes = [
        PositionFix(fix.value * unit, fix.noise * unit**2) if isinstance(fix, PositionFix) else fix
        for fix in step.fixes
    ]
    return Step(motion, Observations(seen.ids, seen.values * unit, covs), tuple(fixes))


@pytest.mark.parametrize("association", ASSOCIATIONS, ids=repr)
@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_unit_of_length_changes_nothing(association, unit):
    """No threshold is a number of metres."""
    rng = np.random.default_rng(7)
    noise = covariances(rng, 1, 2)[0]
    start, steps, anchors, _ = world(rng, 4, False, association.kind == "known")
    run = run_filter(start, steps, Settings(CartesianSensor(noise), anchors, association))
    across = np.full(start.mean.size, unit)
    across[2] = 1.0
    other = run_filter(
        MapBelief(start.mean * across, start.cov * np.outer(across, across), start.ids),
        [in_units(step, unit) for step in steps],
        Settings(
            CartesianSensor(noise * unit**2),
            {name: place * unit for name, place in anchors.items()},
            association,
        ),
    )
    assert other.counts == run.counts
    np.testing.assert_allclose(other.nis, run.nis, rtol=1e-6)
    np.testing.assert_allclose(other.poses, run.poses * across[:3], rtol=1e-9)
