"""Weights, witnesses, wrong names and crowds, on what can be worked out."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from robot_perception.book import one_world as page
from robot_perception.observations import Observations
from robot_perception.slam import planar
from robot_perception.slam.planar import MapBelief

RNG = np.random.default_rng


@pytest.fixture(scope="module")
def run():
    return page.round_posts(page.USUAL, page.chance(1))


def belief_of(n, rng):
    """Return a belief in a pose and n landmarks."""
    size = 3 + 2 * n
    root = 0.1 * rng.standard_normal((size, size))
    mean = np.r_[1.0, -2.0, 0.4, rng.uniform(-5, 5, 2 * n)]
    return MapBelief(mean, root @ root.T + 0.01 * np.eye(size), np.arange(n))


@pytest.mark.parametrize("seed", range(6))
def test_the_weight_makes_the_determinant_least(seed):
    rng = RNG(seed)
    n = int(rng.integers(5, 40))
    root, H = rng.standard_normal((n, n)), rng.standard_normal((2, n))
    P, C = root @ root.T + np.eye(n), np.diag(rng.uniform(0.01, 0.5, 2))
    Y, own = np.linalg.inv(P), H.T @ np.linalg.inv(C) @ H
    found = minimize_scalar(
        lambda w: -np.linalg.slogdet((1 - w) * Y + w * own)[1],
        bounds=(0, 0.99999),
        method="bounded",
        options={"xatol": 1e-7},
    )
    assert page.weight(H @ P @ H.T, C, n) == pytest.approx(found.x, abs=1e-4)


def test_a_reading_that_is_not_sure_enough_is_not_heard():
    rng = RNG(0)
    belief = belief_of(6, rng)
    seen = Observations(np.array([77]), np.array([[1.0, 2.0]]), np.array([5.0 * np.eye(2)]))
    left = {77: (np.array([2.0, 1.0]), np.zeros((2, 2)))}
    assert page.heard(belief, seen, left, "intersected") is belief
    assert page.heard(belief, seen, left, "independent") is not belief


@pytest.mark.parametrize("rule", ["independent", "intersected"])
def test_a_reading_is_taken_in_by_the_inverse_of_the_covariance(rule):
    """By eq. (3) on the whole state, with a Jacobian from finite differences."""
    belief = belief_of(1, RNG(1))
    place, cov = np.array([3.0, 1.0]), np.diag([0.004, 0.001])
    R = np.diag([0.0004, 0.0001])
    seen = Observations(np.array([77]), np.array([[2.0, 2.5]]), R[None])

    def expected(pose):
        c, s = np.cos(pose[2]), np.sin(pose[2])
        return np.array([[c, s], [-s, c]]) @ (place - pose[:2])

    steps = 1e-6 * np.eye(3)
    H = np.zeros((2, belief.mean.size))
    H[:, :3] = np.transpose(
        [(expected(belief.pose + d) - expected(belief.pose - d)) / 2e-6 for d in steps]
    )
    c, s = np.cos(belief.pose[2]), np.sin(belief.pose[2])
    turn = np.array([[c, s], [-s, c]])
    C = R + turn @ cov @ turn.T
    w = page.weight(H @ belief.cov @ H.T, C, belief.mean.size)
    assert 0 < w < 1
    ours, theirs = (1 - w, w) if rule == "intersected" else (1.0, 1.0)
    Y = ours * np.linalg.inv(belief.cov) + theirs * H.T @ np.linalg.inv(C) @ H
    found = page.heard(belief, seen, {77: (place, cov)}, rule)
    assert found.cov == pytest.approx(np.linalg.inv(Y), rel=1e-5, abs=1e-9)
    gain = found.cov @ H.T @ np.linalg.inv(C) * theirs
    moved = belief.mean + gain @ (seen.values[0] - expected(belief.pose))
    assert found.mean == pytest.approx(moved, abs=1e-7)


def test_by_equation_4_what_is_out_of_sight_grows_less_certain_without_end(monkeypatch):
    """It compares determinants of the reading alone, so that the rest of the state pays."""

    def by_determinants(S, C, n):
        mine, theirs = np.linalg.det(S), np.linalg.det(C)
        return mine / (mine + theirs)

    belief = belief_of(3, RNG(2))
    seen = Observations(np.array([77]), np.array([[2.0, 2.5]]), 1e-4 * np.eye(2)[None])
    left = {77: (np.array([3.0, 1.0]), 1e-3 * np.eye(2))}
    ours, theirs = belief, belief
    for _ in range(5):
        ours = page.heard(ours, seen, left, "intersected")
    with monkeypatch.context() as patch:
        patch.setattr(page, "weight", by_determinants)
        for _ in range(5):
            theirs = page.heard(theirs, seen, left, "intersected")
    before, bounded, endless = (np.trace(b.cov[3:, 3:]) for b in (belief, ours, theirs))
    assert bounded < 1.1 * before
    assert endless > 1e6 * before


def test_where_no_landmark_leaves_the_filter_is_the_plain_one(run):
    poses, covs, sizes = page.retiring(run, page.USUAL, "intersected", limit=10_000)
    history = page.filtered(run, "plain", "own", "known", page.USUAL.start)
    assert poses == pytest.approx(history.poses, abs=1e-9)
    assert covs == pytest.approx(history.pose_covs, abs=1e-12)
    assert (sizes == 3 + 2 * history.sizes).all()


def test_landmarks_leave_after_so_many_revisions(run):
    often = np.bincount(np.concatenate([seen.ids for seen in run.seen])) - 1  # the first is none
    limit = int(often.min())
    _, _, sizes = page.retiring(run, page.USUAL, "intersected", limit=limit)
    assert sizes[-1] == 3 + 2 * np.count_nonzero(often <= limit) > 3


def test_what_is_left_of_a_belief_is_its_marginal():
    belief = belief_of(3, RNG(3))
    left = page.without(belief, 1)
    rows = [0, 1, 2, 3, 4, 7, 8]
    assert left.ids.tolist() == [0, 2]
    assert (left.mean == belief.mean[rows]).all()
    assert (left.cov == belief.cov[np.ix_(rows, rows)]).all()


def test_names_are_those_of_posts_that_were_met_and_are_not_in_sight(run):
    told = page.renamed(run, 40, RNG(0))
    met, wrong = set(), 0
    for seen, named in zip(run.seen, told.seen, strict=True):
        assert (named.values == seen.values).all()
        assert len(set(named.ids.tolist())) == len(named.ids)
        for true, name in zip(seen.ids.tolist(), named.ids.tolist(), strict=True):
            if name != true:
                wrong += 1
                assert true in met
                assert name in met
        met |= set(seen.ids.tolist())
    assert wrong == 40
    few = page.renamed(run, 3, RNG(0))
    same = [
        (a.ids == b.ids).all()
        for a, b in zip(page.renamed(run, 0, RNG(0)).seen, run.seen, strict=True)
    ]
    assert all(same)
    changed = sum((a.ids != b.ids).sum() for a, b in zip(few.seen, run.seen, strict=True))
    assert changed == 3


def test_each_drive_goes_round_posts_of_its_own_on_the_same_wheels():
    one, other = (page.round_new_posts(page.USUAL, page.chance(1, k)) for k in range(2))
    usual = page.round_posts(page.USUAL, page.chance(1, 0))
    assert (one.poses == other.poses).all()
    assert (one.wheels["own"].increments == usual.wheels["own"].increments).all()
    away = [np.hypot(*(a.landmarks - b.landmarks).T) for a, b in ((one, other), (one, usual))]
    assert (np.median(away, axis=1) > 0.1).all()
    sigma, gaps = page.SIGMA, []
    for pose, seen in zip(one.poses, one.seen, strict=True):
        c, s = np.cos(pose[2]), np.sin(pose[2])
        truth = (one.landmarks[seen.ids] - pose[:2]) @ np.array([[c, -s], [s, c]])
        gaps.append(seen.values - truth)
        assert seen.covs == pytest.approx(np.tile(sigma**2 * np.eye(2), (len(seen), 1, 1)))
    assert np.std(np.concatenate(gaps)) == pytest.approx(sigma, rel=0.1)


def test_the_nearest_wrong_name_is_nearer_than_any(run):
    def away(near):
        told = page.renamed(run, 40, RNG(0), near)
        pairs = zip(run.seen, told.seen, strict=True)
        places = [(a.ids, b.ids) for a, b in pairs if (a.ids != b.ids).any()]
        true, named = (run.landmarks[np.concatenate(ids)] for ids in zip(*places, strict=True))
        gaps = np.hypot(*(true - named).T)
        return gaps[gaps > 0].mean()

    assert away(True) < 0.6 * away(False)


def test_a_gate_of_particles_is_that_of_their_mixture():
    """A sighting five deviations off is turned away; two particles, a landmark each."""
    poses = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]])
    none = np.empty(0, dtype=int), np.empty((2, 0, 3)), np.empty((2, 0, 3, 3))
    maps = page.ParticleMaps(page.ParticleSet.uniform(poses), *none)
    first = Observations(np.array([7]), np.array([[3.0, 0.0]]), 0.01 * np.eye(2)[None])
    maps, _ = page.RaoBlackwellisedSlam(page.UPRIGHT, 2).step(
        maps, page.STILL, page.lifted(first), rng=RNG(0)
    )

    def passes(x, name=7):
        seen = Observations(np.array([name]), np.array([[x, 0.0]]), 0.01 * np.eye(2)[None])
        return page.fitting(maps, page.lifted(seen), page.LEVEL).tolist()

    reach = np.sqrt(page.chi_squared_quantile(page.LEVEL, 3) * 0.02)  # both maps moved with it
    assert passes(3.0 + 0.99 * reach) == [True]
    assert passes(3.0 + 1.01 * reach) == [False]
    assert passes(99.0, name=8) == [True]  # nobody has seen it before


def test_a_gate_keeps_the_path_that_wrong_names_bend(run):
    told = page.renamed(run, 16, RNG(1))
    for one in ("Kalman", "200 particles"):
        with_gate, without = (page.ridden(f"{one}{g}", told, page.USUAL, 0) for g in (", gate", ""))
        assert with_gate < without


def test_particles_that_see_nothing_spread_as_the_wheels_err():
    loop = page.WORLDS["turned"]
    run = page.round_posts(loop, page.chance(3))
    ride = page.guessed(run, loop, 4000, page.chance(4), blind=True)
    spread = np.array(page.STARTS[loop.start])
    belief = MapBelief.start(run.poses[0] + spread * run.start, np.diag(spread**2))
    for k, step in enumerate(page.steps_of(run, *page.BY_NAME)):
        belief = belief if step.motion is None else planar.predict(belief, step.motion)
        if k == 10:
            break
    assert ride.covs[10] == pytest.approx(belief.pose_cov, rel=0.1, abs=6e-4)
    assert ride.poses[10] == pytest.approx(belief.pose, abs=0.01)
    outside, *_ = page.judged(run, ride.poses, ride.covs)
    assert 0 <= outside <= 1


def test_a_crowd_is_near_what_the_kalman_filter_says_at_first():
    """The first posts put all particles where the exact posterior is, near enough to linear."""
    loop = page.WORLDS["linear"]
    run = page.round_posts(loop, page.chance(5))
    ride = page.guessed(run, loop, 4000, page.chance(6))
    history = page.filtered(run, "plain", "own", "known", loop.start)
    gap = ride.poses[:20] - history.poses[:20]
    sigma = np.sqrt(np.diagonal(history.pose_covs[:20], axis1=1, axis2=2))
    assert (np.abs(gap) <= 0.5 * sigma + 1e-6).all()
    assert len(ride.clouds) == len(run.poses)
    assert ride.clouds[0].shape == (4000, 3)


def test_errors_of_the_stated_size_are_outside_once_in_twenty():
    rng, count = RNG(7), 20_000
    cov = np.diag([0.04, 0.01, 0.0004])
    truth = np.zeros((count, 3))
    poses = rng.multivariate_normal(np.zeros(3), cov, count)
    outside, off, nees, sure = page.judged(
        page.SimpleNamespace(poses=truth), poses, np.tile(cov, (count, 1, 1))
    )
    assert outside == pytest.approx(0.05, abs=0.005)
    assert off == pytest.approx(np.sqrt(0.05), rel=0.02)
    assert nees == pytest.approx(3, rel=0.03)
    assert sure == pytest.approx(np.degrees(0.02))


def test_a_filter_whose_numbers_break_down_is_lost(run, monkeypatch):
    def broken(*_):
        raise ValueError("singular")

    assert 0 < page.ridden("Kalman", run, page.USUAL, 0) < 2
    monkeypatch.setattr(page, "path_of", broken)
    assert page.ridden("Kalman", run, page.USUAL, 0) == page.LOST


def test_the_best_fit_is_nearer_than_the_wheels():
    found = page.smoothed.one(3, "turned")
    assert found["optimum"] < found["wheels"]
