"""The covariance under way: one triangle is kept, and nothing reads the other."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest

from robot_perception.slam.planar import (
    Association,
    CartesianSensor,
    Compass,
    MapBelief,
    PositionFix,
    RangeBearing,
    Settings,
    run_filter,
    runs,
)
from robot_perception.slam.planar.workspace import Workspace
from tests.slam.planar.drives import R_POLAR, R, belief_of, drive


class Poisoned(Workspace):
    """A workspace whose upper triangle is NaN whenever somebody may look at it."""

    def __init__(self, belief):
        super().__init__(belief)
        self.poison()

    def poison(self):
        self.cov[np.triu_indices(len(self.cov), 1)] = np.nan


def then_poisoned(name):
    def method(self, *args, **kwargs):
        result = getattr(Workspace, name)(self, *args, **kwargs)
        self.poison()
        return result

    return method


for change in ("predict", "revise", "add", "remove"):
    setattr(Poisoned, change, then_poisoned(change))


@pytest.mark.parametrize(
    "association",
    [Association(), Association("known", 0.9), Association("gated"), Association("joint")],
    ids=repr,
)
@pytest.mark.parametrize("retirement", ["freeze", "consider"])
@pytest.mark.parametrize("polar", [False, True])
def test_the_upper_triangle_is_never_read(polar, retirement, association, monkeypatch):
    world = drive(np.random.default_rng(7), noise=0.3, polar=polar)
    steps = [
        replace(s, fixes=(PositionFix(p[:2], 0.1 * np.eye(2)), Compass(p[2], 0.01)) * (k % 7 == 3))
        for k, (s, p) in enumerate(zip(world.steps, world.poses[1:], strict=True))
    ]
    if association.kind != "known":
        steps = [replace(s, observations=s.observations.anonymous()) for s in steps]
    settings = Settings(
        RangeBearing(0.09 * R_POLAR) if polar else CartesianSensor(0.09 * R),
        {2: world.landmarks[2]},
        association,
        revision_limit=8,
        retirement=retirement,
        keep=[20],
    )
    plain = run_filter(world.start, steps, settings)
    monkeypatch.setattr(runs, "Workspace", Poisoned)
    poisoned = run_filter(world.start, steps, settings)
    assert plain.counts == poisoned.counts
    assert plain.counts.retired > 0
    assert plain.counts.new > 5
    for name in ("poses", "pose_covs", "nis", "dof", "sizes"):
        np.testing.assert_array_equal(getattr(poisoned, name), getattr(plain, name))
    for ours, theirs in ((poisoned.belief, plain.belief), (poisoned.kept[20], plain.kept[20])):
        np.testing.assert_array_equal(ours.mean, theirs.mean)
        np.testing.assert_array_equal(ours.cov, theirs.cov)
        assert (ours.cov == ours.cov.T).all()  # exactly, and no NaN
    assert (plain.pose_covs == plain.pose_covs.transpose(0, 2, 1)).all()


def test_a_considered_landmark_stays_one_while_others_come_and_go():
    rng = np.random.default_rng(5)
    belief, sensor = belief_of(rng, 4), CartesianSensor(R)
    first, gone, still, last = belief.ids.tolist()
    work = Workspace(belief)
    work.consider(still)
    work.remove(gone)
    work.add([90, 91], rng.uniform(-3, 3, (2, 2)), R[None], sensor)
    work.remove(first)
    before = work.snapshot()
    slots, points = work.targets([last, 91, still], {})
    seen = sensor.expect(before.pose, points)[0] + 0.1
    innovation, by_pose, by_point = work.linearise(slots, points, seen, sensor, None)
    work.revise(by_pose, by_point, slots, innovation, R[None])
    after = work.snapshot()
    np.testing.assert_array_equal(after.landmark(still).mean, before.landmark(still).mean)
    np.testing.assert_array_equal(after.landmark(still).cov, before.landmark(still).cov)
    for name in (last, 90, 91):
        assert (after.landmark(name).mean != before.landmark(name).mean).all()
        assert np.trace(after.landmark(name).cov) < np.trace(before.landmark(name).cov)


@pytest.mark.parametrize("size", [3, 70])
@pytest.mark.parametrize("scale", [1e-12, 1e12])
@pytest.mark.parametrize("share", [-2e-9, -0.5e-9, 0.5e-9, 2e-9])
def test_a_covariance_is_symmetric_to_a_share_of_its_largest_variance(size, scale, share):
    """Wherever that variance and the two entries stand."""
    rng = np.random.default_rng(size)
    for _ in range(20):
        belief = belief_of(rng, size, size=0.01)
        largest, row, column = rng.choice(belief.mean.size, 3)
        belief.cov[largest, largest] = 1.0
        belief.cov[:] *= scale
        belief.cov[row, column] += share * scale
        if abs(share) > 1e-9 and row != column:
            with pytest.raises(ValueError, match="symmetric, 1 pairs"):
                Workspace(belief)
        else:
            Workspace(belief)


def test_the_update_keeps_its_digits_where_the_observations_almost_repeat():
    """Against 60 digits: a prior over ten decades, noise of 1e-10, two measurements 1e-7 apart."""
    rng = np.random.default_rng(0)
    n, k = 7, 2
    turn = np.linalg.qr(rng.standard_normal((n, n)))[0]
    cov = (turn * np.logspace(0, -10, n)) @ turn.T
    belief = MapBelief(np.zeros(n), (cov + cov.T) / 2, np.arange(2))
    by_pose, by_point = rng.standard_normal((1, 2, 3)), rng.standard_normal((1, 2, 2))
    by_pose = by_pose + 1e-7 * rng.standard_normal((k, 2, 3))
    by_point = by_point + 1e-7 * rng.standard_normal((k, 2, 2))
    innovation, noises = 1e-3 * rng.standard_normal((k, 2)), 1e-10 * np.eye(2)[None]
    work = Workspace(belief)
    work.revise(by_pose, by_point, np.array([3, 3]), innovation, noises)
    H = np.zeros((2 * k, n))
    H[:, :3], H[:, 3:5] = by_pose.reshape(-1, 3), by_point.reshape(-1, 2)
    with mpmath.workdps(60):
        P, H = mpmath.matrix(belief.cov.tolist()), mpmath.matrix(H.tolist())
        S = H * P * H.T + mpmath.mpf(1e-10) * mpmath.eye(2 * k)
        K = P * H.T * mpmath.inverse(S)
        exact = np.array((P - K * H * P).tolist(), dtype=float)
    np.testing.assert_allclose(work.release().cov, exact, rtol=0, atol=1e-14)
