"""The studies: a robot on a rail with a reference, ranks and moved worlds, and circles."""

from itertools import product

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.spatial.distance import pdist

from data_synth.monobot import measure_anchor, simulate_rail, watch_vehicle
from data_synth.wheels import Slip
from robot_perception.beliefs import Gaussian
from robot_perception.book import anchored_slam as page
from robot_perception.evaluation.consistency import average_bounds, normalised_squared
from robot_perception.slam import monobot as rail
from robot_perception.slam.observability import (
    analyse,
    fixed_point_matrix,
    gauge_directions,
    information_along,
    trajectory_matrix,
)
from studies.rows import Rows, framed

RNG = np.random.default_rng
RUNS = 400
FIGURES = pytest.mark.parametrize("figure", [page.FIG5, page.FIG6], ids=["fig5", "fig6"])


def tied(figure, runs=RUNS, seed=0, misplaced=0.0, **changes):
    """Return a robot with a reference, its runs by the notebook, and by the library's filter."""
    rng, robot = RNG(seed), page.referenced(**figure | changes)
    landmarks = {"landmarks": robot.n}
    r, z = page.drive(page.monobot(**page.FIG4 | landmarks), runs, rng)
    own = rng.spawn(1)[0]
    return robot, page.on_rail(robot, r, page.observed(robot, r, z, own, misplaced))


def by_library(figure, runs, seed, misplaced=0.0):
    """Return the same by the library's world and filter."""
    rng, robot = RNG(seed), page.referenced(**figure)
    world = simulate_rail(
        robot.path,
        np.ones(1),
        runs,
        start_deviation=0.1,
        motion_deviation=np.sqrt(robot.V),
        measurement_deviation=np.sqrt(robot.W[:, 1:]),
        rng=rng,
    )
    sign, noise = page.SIGNS[figure["reference"]], robot.W[1:, 0]
    measure = {-1: measure_anchor, 1: watch_vehicle}[sign]
    values = measure(world, 0.0, np.sqrt(noise), rng=rng.spawn(1)[0])
    return rail.run_referenced(
        Gaussian(robot.path[:1], np.array([[robot.P0]])),
        world.commands,
        world.measurements,
        rail.Reference(sign, values, noise, misplaced),
        motion_variance=robot.V,
        measurement_variance=robot.W[:, 1:],
    )


# On the rail -------------------------------------------------------------------------------------


@FIGURES
@pytest.mark.parametrize("misplaced", [0.0, 0.3])
def test_the_loop_gives_what_the_librarys_filter_gives(figure, misplaced):
    _, ours = tied(figure, 5, 3, misplaced)
    theirs = by_library(figure, 5, 3, misplaced)
    np.testing.assert_allclose(ours.means, theirs.means, atol=1e-12)
    np.testing.assert_allclose(ours.P, theirs.covs[0], atol=1e-12)
    np.testing.assert_allclose(ours.K, theirs.gains[0], atol=1e-12)


@FIGURES
@pytest.mark.parametrize("landmarks", [1, 3])
def test_errors_are_as_large_as_the_filter_says(figure, landmarks):
    _, found = tied(figure, landmarks=landmarks)
    errors = np.concatenate([found.vehicle_errors[..., None], found.landmark_errors], axis=-1)
    low, high = average_bounds(landmarks + 1, RUNS, 1 - 1e-4)
    for step in (0, 1, 7, 25, 100):
        assert low < normalised_squared(errors[:, step], found.P[step]).mean() < high


def test_the_gain_drawn_is_that_of_the_landmarks_own_innovation():
    _, found = tied(page.FIG5, 2)
    np.testing.assert_array_equal(found.gains[:, 1], found.K[:, 1, 1])
    assert np.all(found.gains[:, 1] > 0)


def test_figures_hold_what_the_captions_print():
    four, five, six = page.figures().values()
    share = np.sqrt(four.W[1:, 0]) / np.abs(1.0 - four.path[1:])
    noise = np.sqrt(five.W[1:, 0])
    np.testing.assert_allclose(noise, 0.01 + share * np.abs(five.path[1:]))
    np.testing.assert_allclose(np.sqrt(six.W[:, 0]), 0.1)
    assert five.H[0].tolist() == [-1, 0]
    assert six.H[0].tolist() == [1, 0]


@pytest.mark.parametrize("name", ["plain", "fig5", "fig6"])
def test_share_left_is_how_much_of_the_first_error_is_still_there(name):
    """Slope and squared correlation, measured, against the covariances."""
    figure = {"plain": {}, "fig5": page.FIG5, "fig6": page.FIG6}[name]
    robot, found = tied(figure, 4000, 5)
    first, last = (found.landmark_errors[:, k, 0] for k in (0, -1))
    share, fit = page.remaining(robot)[-1], stats.linregress(first, last)
    assert abs(fit.slope - share) < 4 * fit.stderr
    z = abs(np.arctanh(fit.rvalue) - np.arctanh(np.sqrt(share))) * np.sqrt(3997)
    assert z < 4


def rows(**columns):
    """Return rows of a trial with these columns."""
    return Rows(framed([{"sample": 0} | columns]), "sample", {})


def test_share_left_sees_an_error_that_is_large_and_one_that_the_first_measurement_fixes():
    trial = page.anchored.but(runs=4000).trial(sample=5)
    value, allowed = page.share_left(rows(**trial)), page.FADED
    assert allowed.contains(value)
    left = page.remaining(page.referenced(**page.FIG5))[-1]
    assert value.low / 1.1 <= left <= value.high
    for spoilt in (0.15 * trial["first"], RNG(1).normal(size=4000)):
        assert allowed.excludes(page.share_left(rows(**trial | {"last": spoilt})))


def test_a_trial_has_the_same_worlds_with_and_without_the_reference():
    one = page.anchored.but(runs=3).trial(sample=5)
    none = page.anchored.but(runs=3, reference="none").trial(sample=5)
    np.testing.assert_allclose(none["last"], one["plain"], atol=1e-12)
    assert np.abs(one["last"] - one["plain"]).max() > 0.01
    blurred = page.anchored.but(runs=3, blur=2.0).trial(sample=5)
    twice = page.anchored.but(runs=3, blur=4.0).trial(sample=5)
    added = blurred["last"] - one["last"]
    np.testing.assert_allclose(twice["last"] - one["last"], 2 * added, atol=1e-12)
    np.testing.assert_array_equal(blurred["first"], one["first"])


def test_anchored_map_is_the_relative_map():
    anchored, relative = page.anchored_and_relative(20, RNG(4))
    np.testing.assert_allclose(anchored, relative, atol=1e-12)
    assert np.abs(np.diff(anchored, axis=1)).max() > 0.01  # the estimates do move


def test_a_misplaced_anchor_moves_the_map():
    _, found = tied(page.FIG5, misplaced=0.1)
    last = found.landmark_errors[:, -1, 0]
    assert abs(last.mean() - 0.1) < 4 * stats.sem(last) + 0.001


@pytest.mark.parametrize("reference", page.SIGNS)
@pytest.mark.parametrize("n", [1, 2, 3])
def test_information_in_symbols(n, reference):
    """Determinant by Cauchy–Binet, and positive definite wherever S is, by Sylvester's minors."""
    J, weights = page.symbolic_information(n, reference)
    assert sympy.expand(J.det(method="berkowitz") - weights.det(method="berkowitz")) == 0
    A = RNG(n).normal(size=(n + 1, n + 1))
    inverse = np.linalg.inv(A @ A.T + np.eye(n + 1))
    values = {weights[i, j]: inverse[i, j] for i in range(n + 1) for j in range(n + 1)}
    number = np.array(J.subs(values), dtype=float)
    H = np.vstack([np.eye(n + 1)[0] * (-1 if reference == "anchor" else 1), 0 * A[1:]])
    H[1:, 0], H[1:, 1:] = -1, np.eye(n)
    np.testing.assert_allclose(number, H.T @ inverse @ H, atol=1e-12)
    assert np.linalg.eigvalsh(number)[0] > 0
    proof = page.written.trial(landmarks=n, reference=reference)
    assert proof["det"]
    assert proof["equal"] == (reference == "anchor")


def test_information_without_a_reference_is_singular_in_symbols():
    J, _ = page.symbolic_information(2, "none")
    assert J.applyfunc(sympy.expand) * sympy.ones(3, 1) == sympy.zeros(3, 1)


def test_information_on_the_start_is_what_least_squares_says():
    """Oracle: invert the joint information of the whole run, without any prior on the start."""
    steps = 6
    robot = page.referenced("anchor", 0.7, steps=steps)
    robot.V[:], robot.W[:, 1] = 1.0, 1.0
    eye = np.eye(steps + 2)  # positions 0 … steps, landmark
    total = np.zeros_like(eye)
    for k in range(steps):
        total += np.outer(eye[k + 1] - eye[k], eye[k + 1] - eye[k])
        total += np.outer(eye[k + 1], eye[k + 1]) / 0.49
        total += np.outer(eye[-1] - eye[k + 1], eye[-1] - eye[k + 1])
    kept = np.ix_([0, steps + 1], [0, steps + 1])
    marginal = np.linalg.inv(np.linalg.inv(total)[kept])
    np.testing.assert_allclose(page.on_start(robot)[-1], marginal, rtol=1e-9)


def test_the_sum_misses_a_rank_only_if_the_anchors_place_is_unknown():
    known, unknown = (
        page.ranked.but(known=known).trial(landmarks=2)["missing"] for known in (True, False)
    )
    assert set(known) == {0}
    assert set(unknown) == {1}


# Ranks -------------------------------------------------------------------------------------------


def numeric_rank(name, analysis, moving):
    """Return the rank by floating point, in the world of the explorer with one landmark."""
    used = page.sensors(name, page.PLACES)
    poses = page.PATH if moving else page.PATH * [0, 0, 1] + [1, 2, 0]
    states = np.hstack([poses, np.tile(page.LANDMARKS[0], (len(poses), 1))])
    if analysis == "one point":
        increment = np.array([0.8, -0.1, 0.2]) * [moving, moving, 1]
        return analyse(fixed_point_matrix(used, states[0], increment)).rank
    return analyse(trajectory_matrix(used, states)).rank


def test_exact_ranks_equal_those_of_floating_point():
    found = page.seen.rows()
    assert found.of("proven").all()
    for name, analysis, motion in product(page.SETS, page.ANALYSES, ("driving", "at rest")):
        rank = found.of("rank", sensing=name, analysis=analysis, motion=motion)[0]
        assert rank == numeric_rank(name, analysis, motion == "driving"), (name, analysis)


def test_table_says_what_the_ranks_say():
    found = page.seen.rows()
    table = page.rank_table(found)
    assert table.corner == "rank of 5"
    for name, analysis in product(page.SETS, page.ANALYSES):
        rank = found.of("rank", sensing=name, analysis=analysis, motion="driving")[0]
        assert table[name, analysis] == rank
    assert table["one anchor", "unseen"] == page.TURN
    assert table["compass", "unseen"] == "shift in x, shift in y"
    resting = page.rank_table(found, motion="at rest")
    assert resting["position sensor", "unseen"] == "turn about the robot"


def test_the_worst_of_the_analyses_counts_and_a_study_of_others_is_read_as_it_is():
    def of(**ranks):
        """Return rows of one set of sensors, with a rank for each analysis."""
        names = ["one point", "true path", "nonlinear"][: len(ranks)]
        return rows(
            sensing="one anchor", analysis=names, motion="driving", dimension=5,
            rank=list(ranks.values()),
        )  # fmt: skip

    assert page.lacking(of(a=5, b=4, c=3), "one anchor") == 2
    assert page.lacking(of(a=5, b=4, c=3), "one anchor", ("one point",)) == 0
    assert page.lacking(of(a=4), "plain", motion="at rest") == 1
    assert page.unseen(of(a=4), "plain").unit == "unseen direction"
    assert page.unseen(of(a=5), "plain").unit == "unseen directions"


# Moved worlds ------------------------------------------------------------------------------------


@given(
    st.sampled_from([*page.SETS, page.RESTING]),
    st.sampled_from(page.DIRECTIONS),
    st.floats(-3, 3, width=32),
)
@settings(max_examples=60)
def test_moving_keeps_all_distances_and_the_gap_is_the_residual(sensing, direction, amount):
    world = page.move_world(sensing, direction, amount)
    before = np.vstack([world.poses[:, :2], world.landmarks])
    after = np.vstack([world.moved_poses[:, :2], world.moved_landmarks])
    np.testing.assert_allclose(pdist(before), pdist(after), atol=1e-12)
    gaps = np.linalg.norm(world.misses - world.anchors, axis=-1)
    shifts = np.linalg.norm((world.moved_poses - world.poses)[: len(world.fixes), :2], axis=-1)
    largest = max(gaps.max(initial=0.0), shifts.max(initial=0.0))
    assert world.metres == pytest.approx(largest, abs=1e-12)


def test_a_turn_by_one_is_of_fifteen_degrees_about_the_anchor_or_where_the_robot_is_first():
    for direction, centre in ((page.TURN, [0.0, 0.0]), ("turn about the robot", page.PATH[0, :2])):
        world = page.move_world("compass", direction, 1)
        assert np.rad2deg(world.radians) == pytest.approx(15)
        before, after = (np.linalg.norm(p[:, :2] - centre, axis=1)
                         for p in (world.poses, world.moved_poses))  # fmt: skip
        np.testing.assert_allclose(before, after, atol=1e-12)


def test_a_robot_at_rest_sees_from_one_place_and_a_driving_one_from_four():
    for sensing, places in ((page.RESTING, 1), ("position sensor", 4)):
        world = page.move_world(sensing, "turn about the robot", 1)
        assert len(world.poses) == len(world.fixes) == places
        assert (world.residual < 1e-12) == (places == 1)


def test_what_is_unseen_is_what_the_exact_analysis_names():
    found = page.seen.rows().where(analysis="nonlinear")
    for name, motion in (*product(page.SETS, ("driving",)), ("position sensor", "at rest")):
        named = set(found.of("unseen", sensing=name, motion=motion)[0].split(", ")) - {"nothing"}
        blind = set(page.BLIND.get(name if motion == "driving" else page.RESTING, ()))
        assert named <= blind
        assert bool(named) == bool(blind)


# Circles -----------------------------------------------------------------------------------------


def circle(kind, seed=7, **changes):
    """Return a run of the circle, a filter's history, and the gains that it claims."""
    run = page.circling(RNG(seed), **changes)
    history = page.filtered_circle(run, kind)
    information = page.claimed(run, history, kind)
    return run, history, information / information[0]


def test_only_the_plain_filter_invents_information():
    found = page.circled.rows()
    assert page.invented(found, "plain").all()
    assert np.median(found.of("gain", filter="plain", step=page.STEPS)) > 5
    for kind in ("first estimates", "ideal"):
        assert not page.invented(found, kind).any()
        gains = found.of("gain", filter=kind).reshape(-1, page.STEPS)
        assert (np.diff(gains, axis=1) < 1e-6).all()  # and wheels only take away


def test_without_noise_of_the_wheels_the_information_stands_still():
    for kind in ("first estimates", "ideal"):
        _, _, gains = circle(kind, steps=40, slip=Slip(0.0, 0.0, 0.0, 0.0))
        np.testing.assert_allclose(gains, 1.0, atol=1e-7)


def test_no_honest_heading_is_surer_than_the_turn_it_started_with():
    for kind in page.FILTERS:
        run, history, _ = circle(kind)
        point = run.path[0] if kind == "ideal" else run.start.mean
        N = gauge_directions(point, run.places[0])["turn"]
        floor = 1 / information_along(N, run.start.cov)
        assert (history.pose_covs[:, 2, 2].min() >= floor * (1 - 1e-9)) == (kind != "plain")


@pytest.mark.parametrize("kind", page.FILTERS)
def test_who_states_the_error_of_the_heading(kind):
    found = page.circled.rows().where(filter=kind)
    low, high = average_bounds(1, 50, 1 - 1e-4)
    for step in (40, 70, page.STEPS):
        here = found.where(step=step)
        nees = np.mean((here.of("error") / here.of("sigma")) ** 2)
        assert (nees > high) if kind == "plain" else (low < nees < high)


def test_a_second_anchor_makes_the_plain_filter_honest_and_sharp():
    squares, errors = [], []
    for seed in range(15):
        run, history, _ = circle("plain", seed, steps=100, anchors=2)
        errors.append(page.wrap_angle(history.poses[-1, 2] - run.path[-1, 2]))
        squares.append(errors[-1] ** 2 / history.pose_covs[-1, 2, 2])
    low, high = average_bounds(1, 15, 1 - 1e-4)
    assert low < np.mean(squares) < high
    ideal = page.along_the_circles()["ideal"].rms[-1]
    assert np.rad2deg(np.sqrt(np.mean(np.square(errors)))) < ideal / 5


def test_the_less_was_known_the_more_is_invented():
    found = page.surer.rows()
    gains = [found.median("gain", known=known) for known in (1, 3, 10)]
    assert gains == sorted(gains)
    assert gains[0] < 1.2 < gains[1]
    squares = [found.of("square", known=known).mean() for known in (1, 3, 10)]
    assert squares == sorted(squares)


def test_the_start_known_to_ten_degrees_is_that_of_the_circles():
    end = page.circled.rows().where(filter="plain", step=page.STEPS)
    np.testing.assert_allclose(page.surer.rows().of("gain", known=10), end.of("gain"))
    squares = (end.of("error") / end.of("sigma")) ** 2
    np.testing.assert_allclose(page.surer.rows().of("square", known=10), squares)
