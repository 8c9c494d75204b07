"""Whole drives: the run against single steps, what its Jacobians keep, its bookkeeping."""

from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robot_perception.evaluation.consistency import average_bounds, normalised_squared
from robot_perception.slam.planar import (
    Association,
    CartesianSensor,
    MapBelief,
    Observations,
    Odometry,
    RangeBearing,
    Settings,
    Step,
    Truth,
    Velocity,
    kernels,
    run_filter,
    textbook,
)
from tests.slam.planar.drives import R_POLAR, Q, R, assert_close, drive, wrapped
from tests.unchecked import unchecked

CART = CartesianSensor(R)
SENSORS = {False: CART, True: RangeBearing(R_POLAR)}


def anchored(world, names):
    return {i: world.landmarks[i] for i in names}


class Recorder:
    """Notes every Jacobian that a run really uses."""

    def __init__(self, monkeypatch):
        self.blocks, self.landmarks = [], 0
        self.originals = (kernels.predict_cov, kernels.whiten, kernels.append)
        monkeypatch.setattr(kernels, "predict_cov", self.predict_cov)
        monkeypatch.setattr(kernels, "whiten", self.whiten)
        monkeypatch.setattr(kernels, "append", self.append)

    def begin(self, gauge):
        self.moved = gauge.copy()  # Φ_{k-1} … Φ_0 N, rows added for new landmarks
        self.blocks = []

    def predict_cov(self, cov, noise, at, after):
        self.moved = (
            textbook.motion_matrix(np.r_[at[:3], np.zeros(len(cov) - 3)], after) @ self.moved
        )
        return self.originals[0](cov, noise, at, after)

    def whiten(self, cov, by_pose, by_point, slots, *rest):
        for i, slot in enumerate(slots):
            row = by_pose[i] @ self.moved[:3]
            if slot >= 0:
                row = row + by_point[i] @ self.moved[slot : slot + 2]
            self.blocks.append(row)
        return self.originals[1](cov, by_pose, by_point, slots, *rest)

    def append(self, cov, n, by_pose, by_value, noises):
        for block in by_pose:
            self.moved = np.vstack([self.moved, block @ self.moved[:3]])
        return self.originals[2](cov, n, by_pose, by_value, noises)

    def visible(self):
        """Return how much of each direction any measurement of the run would have seen."""
        return np.abs(np.concatenate(self.blocks)).max(axis=0)


def gauge(pose):
    """Return shift in x, shift in y, turn about the origin of the world, as motions of the pose."""
    return np.column_stack([np.eye(3)[0], np.eye(3)[1], [-pose[1], pose[0], 1.0]])


@pytest.mark.parametrize("polar", [False, True])
def test_first_estimates_keep_the_unobservable_space(polar, monkeypatch):
    """H_k Φ_{k-1} … Φ_0 N = 0 for all k: no measurement of the run sees a shift or turn of it all.

    The plain filter's own Jacobians see the turn, from nowhere: its measurements cannot.
    """
    world = drive(np.random.default_rng(6), noise=3.0, polar=polar)
    truth = Truth(world.poses, dict(enumerate(world.landmarks)))
    recorder, seen = Recorder(monkeypatch), {}
    for name, linearisation in {"first": "first", "latest": "latest", "truth": truth}.items():
        recorder.begin(gauge(world.poses[0]))
        run_filter(world.start, world.steps, Settings(SENSORS[polar], linearisation=linearisation))
        seen[name] = recorder.visible()
        assert len(recorder.blocks) > 200
    np.testing.assert_allclose(seen["first"], 0, atol=1e-9)
    np.testing.assert_allclose(seen["truth"], 0, atol=1e-9)
    np.testing.assert_allclose(seen["latest"][:2], 0, atol=1e-9)  # shifts are linear
    assert seen["latest"][2] > 0.01


def test_an_anchor_leaves_the_turn_about_it(monkeypatch):
    world = drive(np.random.default_rng(6), noise=3.0)
    recorder = Recorder(monkeypatch)
    for names, hidden in (((1,), True), ((1, 2), False)):
        about = gauge(np.r_[world.poses[0, :2] - world.landmarks[1], 0.0])[:, 2:]
        recorder.begin(about)
        settings = Settings(CART, anchored(world, names), linearisation="first")
        run_filter(world.start, world.steps, settings)
        assert (recorder.visible()[0] < 1e-9) == hidden


def test_nees_over_fifty_runs_lies_in_its_bounds():
    """Noise so small that the model is linear in it: pose and landmarks are as sure as they say.

    Four times of each run, 95 % each; the level below makes a false alarm of the whole test 1 %.
    """
    times, runs = [5, 20, 40, 59], 50
    level = 1 - 0.01 / (2 * len(times))
    low, high = average_bounds(3, runs, level)
    for polar in (False, True):
        poses = np.empty((runs, len(times)))
        maps = np.empty(runs)
        sensor = RangeBearing(0.01**2 * R_POLAR) if polar else CartesianSensor(0.01**2 * R)
        for run, rng in enumerate(np.random.default_rng(8).spawn(runs)):
            world = drive(rng, noise=0.01, polar=polar)
            history = run_filter(world.start, world.steps, Settings(sensor))
            error = history.poses - world.poses[1:]
            error[:, 2] = wrapped(error[:, 2])
            poses[run] = normalised_squared(error[times], history.pose_covs[times])
            first = history.belief.ids[0]
            landmark = history.belief.landmark(int(first))
            row = history.belief.ids.tolist().index(int(first))
            np.testing.assert_array_equal(history.belief.landmark_covs[row], landmark.cov)
            maps[run] = normalised_squared(landmark.mean - world.landmarks[first], landmark.cov)
        assert ((low < poses.mean(axis=0)) & (poses.mean(axis=0) < high)).all()
        bounds = average_bounds(2, runs, level)
        assert bounds[0] < maps.mean() < bounds[1]


def test_nis_over_a_run_is_chi_squared():
    world = drive(np.random.default_rng(9), steps=400, noise=0.01)
    history = run_filter(world.start, world.steps, Settings(CartesianSensor(0.01**2 * R)))
    low, high = average_bounds(int(history.dof.sum()), 1, 0.99)
    assert low < history.nis.sum() < high


def test_retired_landmarks_are_frozen():
    """After its sixth revision a landmark is an anchor: the run goes on as if it had been told."""
    world = drive(np.random.default_rng(1), steps=40, landmarks=4, seen=4)
    settings = Settings(CART, revision_limit=5)
    run = run_filter(world.start, world.steps, settings)
    assert run.counts.retired == 4
    assert sorted(run.frozen) == [0, 1, 2, 3]
    assert run.sizes[5:8].tolist() == [4, 0, 0]  # first measurement, then six revisions
    early = run_filter(world.start, world.steps[:7], Settings(CART)).belief
    for name, place in run.frozen.items():
        np.testing.assert_allclose(place, early.landmark(name).mean, atol=1e-12)
    told = MapBelief.start(early.pose, early.pose_cov)
    rest = run_filter(told, world.steps[7:], Settings(CART, run.frozen))
    assert_close(rest.poses, run.poses[7:])
    assert_close(rest.pose_covs, run.pose_covs[7:])
    counts = run.counts
    assert (counts.new, counts.matched, counts.anchored) == (4, 24, 160 - 28)


def test_considered_landmarks_stand_still_and_still_count():
    """At equal Jacobians the considering filter is never surer than the best one."""
    world = drive(np.random.default_rng(3), steps=60, landmarks=4, seen=4)
    truth = Truth(world.poses, dict(enumerate(world.landmarks)))
    all_on = Settings(CART, linearisation=truth, keep=[6])
    settings = replace(all_on, revision_limit=5, retirement="consider")
    considered = run_filter(world.start, world.steps, settings)
    before, after = considered.kept[6], considered.belief
    np.testing.assert_array_equal(after.mean[3:], before.mean[3:])
    np.testing.assert_array_equal(after.cov[3:, 3:], before.cov[3:, 3:])
    best = run_filter(world.start, world.steps, all_on)
    for sure, less_sure in zip(best.pose_covs, considered.pose_covs, strict=True):
        assert np.linalg.eigvalsh(less_sure - sure)[0] > -1e-9 * np.abs(sure).max()
    frozen = run_filter(world.start, world.steps, replace(settings, retirement="freeze"))
    assert np.trace(frozen.pose_covs[-1]) < 0.9 * np.trace(considered.pose_covs[-1])


def test_freezing_makes_overconfident_and_considering_does_not():
    """The rule of the paper forgets an error that is still there; Schmidt's filter remembers it."""
    runs, nees = 30, {}
    low, high = average_bounds(3, runs, 0.999)
    settings = Settings(CartesianSensor(0.01**2 * R), revision_limit=10)
    for retirement in ("freeze", "consider"):
        values = np.empty(runs)
        for run, rng in enumerate(np.random.default_rng(8).spawn(runs)):
            world = drive(rng, noise=0.01)
            history = run_filter(world.start, world.steps, replace(settings, retirement=retirement))
            error = history.poses[-1] - world.poses[-1]
            error[2] = wrapped(error[2])
            values[run] = normalised_squared(error, history.pose_covs[-1])
        nees[retirement] = values.mean()
    assert low < nees["consider"] < high
    assert nees["freeze"] > 2 * high


def test_bookkeeping():
    world = drive(np.random.default_rng(0), steps=30)
    steps = list(world.steps)
    far = Observations(steps[20].observations.ids, steps[20].observations.values + 3.0)
    steps[20] = replace(steps[20], observations=far)  # named, but far off
    steps[21] = replace(steps[21], observations=steps[21].observations.anonymous())
    steps[22] = replace(steps[22], observations=None)
    steps[23] = replace(steps[23], motion=None)
    run = run_filter(
        world.start, steps, Settings(CART, {3: world.landmarks[3]}, Association("known", 0.9999))
    )
    counts = run.counts
    assert counts.observed == 29 * 4
    parts = (counts.matched, counts.anchored, counts.new, counts.rejected, counts.ignored)
    assert sum(parts) == counts.observed
    assert counts.ignored == 4
    assert counts.rejected >= 3
    assert counts.new == run.belief.ids.size == run.sizes[-1]
    assert run.dof.sum() == 2 * (counts.matched + counts.anchored)
    assert run.dof[22] == 0
    assert run.nis[22] == 0
    np.testing.assert_array_equal(run.used[21], -1)
    np.testing.assert_array_equal(run.used[0], steps[0].observations.ids)
    assert run.used[22].size == 0
    assert counts.anchored == sum((u == 3).sum() for u in run.used)


def one_step(**changes):
    observed = Observations(np.array([1]), np.ones((1, 2)))
    return replace(Step(Odometry(np.zeros(3), Q), observed), **changes)


START = MapBelief.start(np.zeros(3), np.zeros((3, 3)))
MAP = MapBelief(np.zeros(5), np.eye(5), np.array([1]))
BAD = [
    (lambda: run_filter(START, [], Settings(CART)), "at least one step"),
    (lambda: run_filter(START, iter(()), Settings(CART)), "at least one step"),
    (
        lambda: run_filter(
            START, [one_step(time=1.0), one_step(), one_step(time=0.5)], Settings(CART)
        ),
        "step 2: time goes backwards, from 1.0 to 0.5",
    ),
    (lambda: one_step(time=np.nan), "time must be finite"),
    (lambda: Step("abc"), "motion must be an Odometry or a Velocity, got 'abc'"),
    (lambda: Step((0.1, 0.0, 0.0)), r"motion must be an Odometry .* got \(0.1, 0.0, 0.0\)"),
    (lambda: Step(Odometry), "motion must be an Odometry .* got <class"),
    (lambda: one_step(fixes=3), "fixes must be a sequence, got 3"),
    (lambda: one_step(fixes=[3]), r"fixes\[0\] must be a PositionFix or a Compass, got 3"),
    (lambda: run_filter(START, ["abc"], Settings(CART)), "steps must be of type Step, got 'abc'"),
    (lambda: run_filter(None, [one_step()], Settings(CART)), "start must be a MapBelief, got None"),
    (lambda: Settings(CART, {"1": np.zeros(2)}), "anchor needs an integer .*, got '1'"),
    (lambda: run_filter(MAP, [one_step()], Settings(CART, {1: np.zeros(2)})), r"anchor: \[1\]"),
    (lambda: run_filter(START, [one_step()], Settings(CART, {1: np.zeros(3)})), "anchor 1"),
    (
        lambda: run_filter(START, [one_step(motion=None)] * 2, Settings(CartesianSensor(0 * R))),
        "step 1: innovation covariance is singular",
    ),
    (
        lambda: run_filter(
            START, [one_step()], Settings(CART, linearisation=Truth(np.zeros((1, 3)), {}))
        ),
        "step 0: the truth has 1 poses, need 2",
    ),
    (
        lambda: run_filter(
            START, [one_step()], Settings(CART, linearisation=Truth(np.zeros((2, 3)), {}))
        ),
        r"step 0: the truth has no landmarks \[1\]",
    ),
    (
        lambda: run_filter(
            START,
            [one_step(observations=Observations(np.array([1]), np.array([[-1.0, 0.0]])))],
            Settings(RangeBearing(R)),
        ),
        "step 0: ranges must not be negative",
    ),
    (lambda: Truth(np.zeros((2, 2)), {}), r"poses must be \(k \+ 1, 3\), got \(2, 2\)"),
    (lambda: Truth(np.full((2, 3), np.inf), {}), "poses must be finite"),
    (lambda: Truth(np.zeros((2, 3)), {4: np.array([0, np.nan])}), "landmark 4 must be finite"),
    *(
        (
            lambda wrong=wrong: Settings(CART, linearisation=wrong),
            "linearisation must be one of 'latest', 'first' or a Truth, got",
        )
        for wrong in ("last", None, 0, [], True, Truth)
    ),
    *(
        (lambda wrong=wrong: Settings(wrong), "sensor must be a LandmarkSensor, got")
        for wrong in ("polar", None, 0, [], True, RangeBearing)
    ),
    *(
        (lambda wrong=wrong: Settings(CART, retirement=wrong), "one of 'freeze', 'consider', got")
        for wrong in (None, 0, [], True)
    ),
    (lambda: Settings(CART, [np.zeros(2)]), "anchors must map identifiers to places"),
    (lambda: Settings(CART, None), "anchors must map identifiers to places, got None"),
    (lambda: Settings(CART, keep=3), r"keep must be \(steps,\), got \(\)"),
    (lambda: Settings(CART, keep=[1.0]), r"keep must be integers, got \[1.0\]"),
    (
        lambda: Settings(CART, revision_limit=True),
        "revision_limit must be a whole number, got True",
    ),
    (lambda: Settings(CART, retirement="forget"), "'forget'"),
    (lambda: Truth(np.zeros((2, 3)), {-1: np.zeros(2)}), "landmark needs .* got -1"),
    (lambda: Truth(np.zeros((2, 3)), {1.7: np.zeros(2)}), "landmark needs an integer .* got 1.7"),
    (lambda: Settings(CART, revision_limit=0), "at least 1, got 0"),
    (
        lambda: Settings(CART, revision_limit=np.nan),
        "revision_limit must be a whole number, got nan",
    ),
    (lambda: Settings(CART, revision_limit=2.5), "revision_limit must be a whole number, got 2.5"),
    (
        lambda: run_filter(START, [one_step()] * 2, Settings(CART, keep=[1, 2, -1])),
        r"a drive of 2 has not: \[2, -1\]",
    ),
    (lambda: run_filter(START, [one_step()], Settings(CART, {-1: np.zeros(2)})), "got -1"),
]


@pytest.mark.parametrize(("call", "message"), BAD, ids=range(len(BAD)))
def test_bad_input_is_named(call, message):
    with unchecked(), pytest.raises((TypeError, ValueError), match=message):
        call()


def test_a_start_that_lost_its_symmetry_is_refused():
    MAP.cov[0, 3] = 0.5
    try:
        with pytest.raises(ValueError, match="symmetric"):
            run_filter(MAP, [one_step()], Settings(CART))
    finally:
        MAP.cov[0, 3] = 0.0


def test_velocity_drives_the_run():
    """Speed and turn rate integrate to the circle that they describe."""
    steps = [Step(Velocity(0.4, 0.1, 0.5, 1e-6 * np.eye(2)), time=0.5 * k) for k in range(40)]
    run = run_filter(START, steps, Settings(CART))
    heading = 0.05 * np.arange(1, 41)
    expected = np.stack([4 * np.sin(heading), 4 * (1 - np.cos(heading))], axis=-1)
    np.testing.assert_allclose(run.poses[:, :2], expected, atol=1e-12)
    np.testing.assert_allclose(run.poses[:, 2], heading, atol=1e-12)


def timed(count=40):
    world = drive(np.random.default_rng(2), steps=count)
    steps = [replace(step, time=0.5 * k + 1e9) for k, step in enumerate(world.steps)]
    return world, steps


def test_a_trajectory_is_written_as_it_is(tmp_path):
    """Oracle: SciPy's rotations; the covariances to the digits that are written."""
    world, steps = timed()
    run = run_filter(world.start, steps, Settings(CART))
    np.testing.assert_array_equal(run.start, world.start.pose)
    np.testing.assert_array_equal(run.path[1:], run.poses)
    np.testing.assert_array_equal(run.path[0], run.start)
    np.testing.assert_array_equal(run.times, [step.time for step in steps])
    run.to_tum(tmp_path / "run.txt")
    table = np.loadtxt(tmp_path / "run.txt")
    np.testing.assert_allclose(table[:, 0], run.times, rtol=0, atol=1e-6)
    np.testing.assert_allclose(table[:, 1:3], run.poses[:, :2], rtol=0, atol=1e-9)
    assert not table[:, 3].any()
    found = Rotation.from_quat(table[:, 4:])
    about_z = Rotation.from_euler("z", run.poses[:, 2:])
    np.testing.assert_allclose((found * about_z.inv()).magnitude(), 0, atol=1e-7)
    run.to_csv(tmp_path / "run.csv")
    rows = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True)
    for i, name in enumerate(("x_m", "y_m", "heading_rad")):
        np.testing.assert_allclose(rows[name], run.poses[:, i], rtol=0, atol=1e-9)
    for (i, a), (j, b) in combinations_with_replacement(enumerate("xyh"), 2):
        np.testing.assert_allclose(rows[f"cov_{a}{b}"], run.pose_covs[:, i, j], rtol=1e-10)


def test_steps_may_share_a_time():
    run = run_filter(START, [one_step(time=t) for t in (2.0, 2.0, None, 2.0)], Settings(CART))
    np.testing.assert_array_equal(run.times, [2.0, 2.0, np.nan, 2.0])


@pytest.mark.parametrize("name", ["to_tum", "to_csv"])
def test_what_cannot_be_written_is_named(tmp_path, name):
    world, steps = timed(5)
    run = run_filter(world.start, steps, Settings(CART))
    with pytest.raises(FileNotFoundError, match=r"nowhere is no folder: cannot write run\.txt"):
        getattr(run, name)(tmp_path / "nowhere" / "run.txt")
    steps[3] = replace(steps[3], time=None)
    run = run_filter(world.start, steps, Settings(CART))
    assert np.isnan(run.times).tolist() == [False, False, False, True, False]
    with pytest.raises(ValueError, match="1 of 5 steps have none, the first is step 3"):
        getattr(run, name)(tmp_path / "run.txt")
    assert not list(tmp_path.iterdir())
