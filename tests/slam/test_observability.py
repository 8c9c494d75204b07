"""Observability: the three analyses against each other, differences, and worlds really moved."""

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.slam.observability import (
    CARTESIAN,
    RANGE_BEARING,
    Anchor,
    Heading,
    Landmarks,
    Position,
    analyse,
    fixed_point_matrix,
    gauge_directions,
    information_along,
    rotate,
    see,
    symbolic,
    trajectory_matrix,
    translate,
)
from robot_perception.slam.planar.motions import Odometry
from tests.unchecked import unchecked

A1, A2 = (1.0, 2.0), (-3.0, 1.0)
VIEWS = {"cartesian": CARTESIAN, "range-bearing": RANGE_BEARING}
NAMES = ("plain", "one anchor", "two anchors", "anchor and compass", "position", "compass")
# unseen directions: at one point (moving, standing), along a path (moving, turning on the spot)
HIDDEN = {
    "plain": (2, 3, 3, 3),
    "one anchor": (0, 1, 1, 1),
    "two anchors": (0, 0, 0, 0),
    "anchor and compass": (0, 0, 0, 0),
    "position": (0, 1, 0, 1),
    "compass": (2, 2, 2, 2),
}


def sensors(name, view=CARTESIAN, places=(A1, A2)):
    first, second = (Anchor(*place, view) for place in places)
    return {
        "plain": (Landmarks(view),),
        "one anchor": (Landmarks(view), first),
        "two anchors": (Landmarks(view), first, second),
        "anchor and compass": (Landmarks(view), first, Heading()),
        "position": (Landmarks(view), Position()),
        "compass": (Landmarks(view), Heading()),
    }[name]


SYMBOLS = tuple((anchor.x, anchor.y) for anchor in symbolic.ANCHORS)


def a_drive(rng, n=3, steps=12, moving=True):
    """Return true states of a robot among n landmarks, by the motion model of the filter."""
    pose, poses = rng.normal(size=3), []
    for _ in range(steps):
        poses.append(pose)
        ahead = rng.uniform(0.2, 1.0) if moving else 0.0
        increment = np.array([ahead, 0.0, rng.uniform(-0.5, 0.5)])
        pose = Odometry(increment, np.zeros((3, 3))).move(pose)
    landmarks = 4 * rng.normal(size=2 * n)
    return np.hstack([poses, np.tile(landmarks, (steps, 1))])


# Numbers -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@pytest.mark.parametrize("name", NAMES)
@given(st.integers(0, 2**31), st.integers(1, 5))
@settings(max_examples=8)
def test_ranks_in_numbers(name, view, seed, n):
    rng = np.random.default_rng(seed)
    moving, standing = a_drive(rng, n), a_drive(rng, n, moving=False)
    used = sensors(name, view)
    matrices = (
        fixed_point_matrix(used, moving[0], np.array([0.7, 0.1, 0.3])),
        fixed_point_matrix(used, moving[0], np.array([0.0, 0.0, 0.3])),
        trajectory_matrix(used, moving),
        trajectory_matrix(used, standing),
    )
    hidden = tuple(3 + 2 * n - analyse(matrix).rank for matrix in matrices)
    assert hidden == HIDDEN[name]


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
def test_what_one_anchor_hides_is_the_turn_about_it(view):
    states = a_drive(np.random.default_rng(1))
    along = analyse(trajectory_matrix(sensors("one anchor", view), states))
    assert along.hides(gauge_directions(states[0], np.array(A1))["turn"]) > 1 - 1e-12
    others = [
        d for c in (np.array(A2), states[0, :2]) for d in gauge_directions(states[0], c).values()
    ]
    assert all(along.hides(direction) < 0.99 for direction in others)


def test_what_plain_slam_hides_is_any_motion_of_the_world():
    states = a_drive(np.random.default_rng(2))
    along = analyse(trajectory_matrix(sensors("plain"), states))
    for centre in (A1, A2, (50.0, -7.0)):
        directions = gauge_directions(states[0], np.array(centre))
        assert all(along.hides(direction) > 1 - 1e-12 for direction in directions.values())
    assert along.hides(np.eye(9)[2]) < 0.99  # turning the robot alone is seen


def test_a_standing_robot_with_a_position_sensor_hides_the_turn_about_itself():
    states = a_drive(np.random.default_rng(3), moving=False)
    at_rest = analyse(trajectory_matrix(sensors("position"), states))
    assert at_rest.hides(gauge_directions(states[0], states[0, :2])["turn"]) > 1 - 1e-12
    assert at_rest.hides(gauge_directions(states[0], np.array(A1))["turn"]) < 0.99


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_rank_does_not_depend_on_the_unit_of_length(unit):
    states = a_drive(np.random.default_rng(4))
    scale = np.where(np.arange(9) == 2, 1.0, unit)
    places = tuple(tuple(unit * c for c in place) for place in (A1, A2))
    for name in NAMES:
        plain = analyse(trajectory_matrix(sensors(name), states))
        scaled = analyse(trajectory_matrix(sensors(name, places=places), states * scale))
        assert scaled.rank == plain.rank


@pytest.mark.parametrize("tolerance", [{}, {"tolerance": 1e-3}])
def test_a_singular_value_counts_above_its_share_of_the_largest(tolerance):
    """Two columns that are an angle apart have singular values √2 cos and √2 sin of its half."""
    for share in (0.8, 1.2):
        angle = 2 * np.arctan(share * tolerance.get("tolerance", 1e-9))
        columns = np.array([[1.0, np.cos(angle)], [0.0, np.sin(angle)]])
        assert analyse(columns, **tolerance).rank == 1 + (share > 1)


def test_two_anchors_at_one_place_are_one():
    states = a_drive(np.random.default_rng(5))
    used = sensors("two anchors", places=(A1, A1))
    assert analyse(trajectory_matrix(used, states)).rank == 8


def test_unseen_directions_are_orthonormal_and_unseen():
    states = a_drive(np.random.default_rng(6))
    matrix = trajectory_matrix(sensors("plain"), states)
    unseen = analyse(matrix).unseen
    np.testing.assert_allclose(unseen.T @ unseen, np.eye(3), atol=1e-12)
    assert np.abs(matrix @ unseen).max() < 1e-12


def test_a_sensor_of_nothing_hides_everything():
    blind = analyse(np.zeros((4, 5)))
    assert blind.rank == 0
    assert blind.hides(np.ones(5)) == pytest.approx(1)


# The matrices against the functions they stand for ----------------------------------------------


def differences(function, x, step=1e-6):
    """Return the Jacobian by central differences."""
    columns = [
        (function(x + step * e) - function(x - step * e)) / (2 * step) for e in np.eye(x.size)
    ]
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@pytest.mark.parametrize("name", NAMES)
def test_jacobians_against_differences(name, view):
    states = a_drive(np.random.default_rng(7))
    used = sensors(name, view)
    expected = differences(lambda x: see(used, x)[0], states[3])
    np.testing.assert_allclose(see(used, states[3])[1], expected, atol=1e-7)


def test_trajectory_matrix_is_the_derivative_of_all_measurements_by_the_start():
    increments = [Odometry(np.array([0.5, 0.1, 0.3]), np.zeros((3, 3)))] * 6
    used = sensors("one anchor")

    def drive(start):
        states = [start]
        for odometry in increments:
            states.append(np.concatenate([odometry.move(states[-1][:3]), start[3:]]))
        return np.array(states)

    start = a_drive(np.random.default_rng(8))[0]
    start[2] = 0.1  # the drive stays within (-π, π)
    expected = differences(lambda x: np.concatenate([see(used, s)[0] for s in drive(x)]), start)
    np.testing.assert_allclose(trajectory_matrix(used, drive(start)), expected, atol=1e-7)


def test_fixed_point_matrix_is_h_times_powers_of_the_filters_own_transition():
    state, increment = a_drive(np.random.default_rng(9))[0], np.array([0.5, 0.1, 0.3])
    F = np.eye(state.size)
    F[:3, :3] = Odometry(increment, np.zeros((3, 3))).jacobians(state[:3])[0]
    H = see(sensors("position"), state)[1]
    expected = np.vstack([H @ np.linalg.matrix_power(F, k) for k in range(state.size)])
    np.testing.assert_allclose(fixed_point_matrix(sensors("position"), state, increment), expected)


def test_anchor_jacobian_is_eq_25_and_position_eq_27():
    x = symbolic.state(2)
    R = sympy.Matrix([[sympy.cos(x[2]), -sympy.sin(x[2])], [sympy.sin(x[2]), sympy.cos(x[2])]])
    t = x[:2, :]
    eq24 = -R.T * t
    eq25 = sympy.Matrix.hstack(-R.T, -R.diff(x[2]).T * t, sympy.zeros(2, 4))
    anchor = symbolic.measurement([Anchor(0, 0)], x)
    assert (anchor - eq24).applyfunc(sympy.simplify) == sympy.zeros(2, 1)
    assert (anchor.jacobian(x) - eq25).applyfunc(sympy.simplify) == sympy.zeros(2, 7)
    values = dict(zip(x, np.random.default_rng(10).normal(size=7), strict=True))
    state = np.array(list(values.values()))
    printed = np.array(eq25.subs(values).tolist(), dtype=float)
    by_difference = differences(lambda s: see([Anchor(0, 0)], s)[0], state)
    np.testing.assert_allclose(printed, by_difference, atol=1e-8)
    assert np.array_equal(see([Position()], state)[1], np.eye(2, 7))


# Symbols -----------------------------------------------------------------------------------------


def symbolic_matrices(used):
    here, later = symbolic.pose(0), symbolic.pose(1)
    turned = (*here[:2], later[2])
    return (
        symbolic.fixed_point_matrix(used),
        symbolic.fixed_point_matrix(used, displacement=(0, 0)),
        symbolic.trajectory_matrix(used),
        symbolic.trajectory_matrix(used, poses=(here, turned)),
        symbolic.lie_matrix(used),
        symbolic.lie_matrix(used, speed=0),
    )


@pytest.mark.parametrize("name", NAMES)
def test_ranks_in_symbols(name):
    used = sensors(name, places=SYMBOLS)
    readings = [symbolic.read(matrix, used) for matrix in symbolic_matrices(used)]
    assert all(reading.proven for reading in readings)
    hidden = tuple(len(reading.unseen) for reading in readings)
    assert hidden == (*HIDDEN[name], *HIDDEN[name][2:])  # Lie derivatives agree with the path
    assert [reading.full for reading in readings] == [count == 0 for count in hidden]


@pytest.mark.parametrize("name", ["plain", "one anchor", "position"])
def test_ranges_and_bearings_have_the_same_ranks_in_symbols(name):
    seen, same = sensors(name, RANGE_BEARING, SYMBOLS), sensors(name, places=SYMBOLS)
    for analysis in (
        symbolic.fixed_point_matrix,
        symbolic.trajectory_matrix,
        symbolic.lie_matrix,
    ):
        assert symbolic.read(analysis(seen), seen) == symbolic.read(analysis(same), same)


def test_unseen_motions_by_name():
    used = sensors("one anchor", places=SYMBOLS)
    assert symbolic.read(symbolic.lie_matrix(used), used).unseen == ("turn about the anchor",)
    used = sensors("position")
    still = symbolic.lie_matrix(used, speed=0)
    assert symbolic.read(still, used).unseen == ("turn about the robot",)


@pytest.mark.parametrize("name", NAMES)
def test_symbols_and_numbers_are_the_same_matrix(name):
    used, rng = sensors(name), np.random.default_rng(11)
    states = a_drive(rng, n=1, steps=3)
    values = {
        symbol: value
        for step, state in enumerate(states)
        for symbol, value in zip(symbolic.state(1, symbolic.pose(step)), state, strict=True)
    }
    exact = np.array(symbolic.trajectory_matrix(used).subs(values).tolist(), dtype=float)
    np.testing.assert_allclose(trajectory_matrix(used, states), exact, atol=1e-12)
    exact = symbolic.fixed_point_matrix(used, displacement=(sympy.Rational(1, 2), 1)).subs(values)
    ours = fixed_point_matrix(used, states[0], np.array([0.5, 1.0, 0.3]), steps=2)
    rows = len(ours) // 2
    ours[rows:] -= ours[:rows]
    np.testing.assert_allclose(ours, np.array(exact.tolist(), dtype=float), atol=1e-12)


class Made:
    """A sensor given by its formula."""

    def __init__(self, formula):
        self.formula = formula


def test_rank_in_symbols_knows_that_the_squares_of_sine_and_cosine_sum_to_one():
    angle = symbolic.pose()[2]
    one = sympy.sin(angle) ** 2 + sympy.cos(angle) ** 2
    for entry, rank in ((one - 1, 0), (one + 1, 1), (sympy.sin(2 * angle), 1)):
        found = symbolic.read(sympy.Matrix([[entry.expand(trig=True), 0, 0]]), [Position()])
        assert (found.rank, len(found.unseen)) == (rank, 3 - rank)


def test_minors_in_symbols_are_counted_once_whatever_their_sign():
    (anchor,) = (s for s in sensors("one anchor", places=SYMBOLS) if isinstance(s, Anchor))
    mirrored = Made(lambda x: -symbolic.measurement([anchor], x))
    dx, dy = symbolic.DISPLACEMENT
    minors = symbolic.fixed_point_minors([mirrored, Landmarks()])
    assert len(minors) == 2
    assert {sympy.Abs(m) for m in minors} == {sympy.Abs(dx), sympy.Abs(dy)}


def test_minors_in_symbols_are_determinants_in_numbers():
    """Oracle: the determinants of the rows in numbers, of a sensor of mixed powers of the sine."""
    x = symbolic.state(1)
    odd = Made(lambda x: sympy.Matrix([x[0] * sympy.sin(x[2]) ** 2 + x[1] ** 2 + x[0], x[1]]))
    used = [odd, Landmarks()]
    values = dict(
        zip([*x, *symbolic.DISPLACEMENT], [0.3, -0.8, 0.7, 1.9, 2.3, 0.5, -0.4], strict=True)
    )
    matrix = np.array(symbolic.fixed_point_matrix(used).subs(values).tolist(), dtype=float)
    expected = {round(abs(np.linalg.det(matrix[[0, 1, 2, 3, row]])), 9) for row in range(4, 8)}
    minors = symbolic.fixed_point_minors(used)
    assert {round(abs(float(m.subs(values))), 9) for m in minors} == expected - {0.0}


def test_poses_in_symbols_may_be_made_of_one_another():
    x, y, angle = symbolic.pose()
    used = [Made(lambda s: sympy.Matrix([s[0] ** 2 * s[1]])), Landmarks()]
    swapped = symbolic.trajectory_matrix(used, poses=[(y, x, angle)])
    plain = symbolic.trajectory_matrix(used, poses=[(x, y, angle)])
    assert swapped == plain.subs({x: y, y: x}, simultaneous=True)
    assert swapped != plain


@pytest.mark.parametrize("landmarks", [1, 2])
def test_at_one_point_an_anchor_is_enough_exactly_if_the_robot_is_thought_to_move(landmarks):
    used = sensors("one anchor", places=SYMBOLS)
    minors = symbolic.fixed_point_minors(used, landmarks)
    dx, dy = symbolic.DISPLACEMENT
    assert {sympy.Abs(m) for m in minors} == {sympy.Abs(dx), sympy.Abs(dy)}
    # the same number as the determinant of whole numeric rows, up to a sign
    state, increment = a_drive(np.random.default_rng(12), n=1)[0], np.array([0.3, -0.8, 0.4])
    matrix = fixed_point_matrix(sensors("one anchor"), state, increment, steps=2)
    found = {round(abs(np.linalg.det(matrix[[0, 1, 2, 3, row]])), 12) for row in range(4, 8)}
    assert found == {0.3, 0.8}


def test_a_position_sensor_at_one_point_needs_a_displacement_in_any_direction():
    minors = symbolic.fixed_point_minors(sensors("position"))
    solved = sympy.solve(minors, symbolic.DISPLACEMENT, dict=True)
    assert solved == [dict.fromkeys(symbolic.DISPLACEMENT, 0)]


# The world really moved --------------------------------------------------------------------------


finite = st.floats(-20, 20)


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@given(st.integers(0, 2**31), finite, finite, st.floats(-3, 3))
@settings(max_examples=30)
def test_finite_motions_change_exactly_what_is_seen(view, seed, east, north, angle):
    state = a_drive(np.random.default_rng(seed))[0]
    shifted = translate(state, np.array([east, north]))
    turned = rotate(state, angle, np.array(A1))

    def change(name, other):
        gap = see(sensors(name, view), other)[0] - see(sensors(name, view), state)[0]
        if view is RANGE_BEARING:  # bearings wrap; no other sensor of these four is an angle
            gap[1::2] = (gap[1::2] + np.pi) % (2 * np.pi) - np.pi
        return np.abs(gap).max()

    assert change("plain", shifted) < 1e-8
    assert change("plain", turned) < 1e-8
    assert change("one anchor", turned) < 1e-8
    if abs(angle) > 0.01:
        assert change("two anchors", turned) > 1e-3
    if max(abs(east), abs(north)) > 0.01:
        assert change("position", shifted) > 0.009
        assert change("one anchor", shifted) > 1e-5


@given(st.integers(0, 2**31))
@settings(max_examples=20)
def test_gauge_directions_are_the_slopes_of_the_motions(seed):
    state, step = a_drive(np.random.default_rng(seed))[0], 1e-6
    slopes = gauge_directions(state, np.array(A2))
    east, north = step * np.eye(2)
    for name, moved in (
        ("shift in x", translate(state, east)),
        ("shift in y", translate(state, north)),
        ("turn", rotate(state, step, np.array(A2))),
    ):
        np.testing.assert_allclose((moved - state) / step, slopes[name], atol=1e-4)


class Bearings:
    """A sensor that the library does not have: directions of the landmarks alone."""

    def formula(self, x):
        offsets = [x[i : i + 2, :] - x[:2, :] for i in range(3, len(x), 2)]
        return sympy.Matrix([sympy.atan2(d[1], d[0]) - x[2] for d in offsets])


def test_a_sensor_of_ones_own_is_read_as_differences_say():
    """The motion is known, so bearings alone leave the shifts and the turn, and not the scale.

    The oracle is the rank of finite differences along a drive.
    """
    rng = np.random.default_rng(3)
    states = a_drive(rng, n=2)
    size = states.shape[1]

    def seen(start):
        """All bearings along the drive if the world and the first pose were another."""
        moved = states.copy()
        moved[:, 3:] = start[3:]
        turn = start[2] - states[0, 2]
        c, s = np.cos(turn), np.sin(turn)
        moved[:, :2] = (states[:, :2] - states[0, :2]) @ [[c, s], [-s, c]] + start[:2]
        moved[:, 2] += turn
        d = moved[:, 3:].reshape(len(moved), -1, 2) - moved[:, None, :2]
        return np.unwrap(np.arctan2(d[..., 1], d[..., 0]) - moved[:, 2:3], axis=0).ravel()

    steps = 1e-6 * np.eye(size)
    slopes = [(seen(states[0] + step) - seen(states[0] - step)) / 2e-6 for step in steps]
    rank = analyse(np.array(slopes).T, tolerance=1e-6).rank
    for analysis in (symbolic.trajectory_matrix, symbolic.lie_matrix):
        found = symbolic.read(analysis([Bearings()], 2), [Bearings()])
        assert (found.rank, found.proven) == (rank, True)
        assert found.unseen == ("shift in x", "shift in y", "turn about the robot")


# Information along a direction -------------------------------------------------------------------


@given(st.integers(0, 2**31), st.integers(1, 4))
@settings(max_examples=30)
def test_information_equals_the_inverse_and_bounds_the_heading(seed, n):
    rng = np.random.default_rng(seed)
    size = 3 + 2 * n
    root = rng.normal(size=(size, size))
    cov = root @ root.T + 0.1 * np.eye(size)
    N = gauge_directions(a_drive(rng, n)[0], np.array(A1))["turn"]
    ours = information_along(N, cov)
    assert ours == pytest.approx(N @ np.linalg.inv(cov) @ N, rel=1e-6)
    assert cov[2, 2] >= (1 - 1e-9) / ours


def test_information_of_a_singular_covariance_is_refused():
    with pytest.raises(ValueError, match="smallest eigenvalue is"):
        information_along(np.ones(3), np.ones((3, 3)))


# Bad input ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda s: see([], s[0]), "no sensor"),
        (lambda s: see([Landmarks()], s[0, :4]), r"\(4,\)"),
        (lambda s: see([Landmarks()], s), r"\(12, 9\)"),
        (lambda s: see([Landmarks()], np.where(s[0] == s[0, 1], np.nan, s[0])), "finite"),
        (lambda s: see([Anchor(np.inf, 0)], s[0]), "anchor"),
        (lambda s: see([Anchor(*s[0, :2], RANGE_BEARING)], s[0]), "exactly at the robot"),
        (lambda s: fixed_point_matrix([Position()], s[0], np.zeros(2)), r"\(2,\)"),
        (
            lambda s: fixed_point_matrix([Position()], s[0], np.zeros(3), 0),
            "steps must be from 1 to 10000",
        ),
        (lambda s: fixed_point_matrix([Position()], s[0], np.full(3, np.nan)), "increment"),
        (lambda s: trajectory_matrix([Position()], s[:0]), r"\(0, 9\)"),
        (lambda s: trajectory_matrix([Position()], s[0]), r"\(9,\)"),
        (lambda s: trajectory_matrix([Position()], s + np.arange(12)[:, None]), "stay where"),
        (lambda s: analyse(np.zeros((0, 3))), r"\(0, 3\)"),
        (lambda s: analyse(np.full((2, 3), np.inf)), "finite"),
        (lambda s: analyse(np.eye(3)[:2]).hides(np.zeros(3)), "not zero"),
        (lambda s: analyse(np.eye(3)[:2]).hides(np.ones(4)), r"\(3,\)"),
        (lambda s: gauge_directions(s[0], np.zeros(3)), r"\(3,\)"),
        (lambda s: gauge_directions(s[0, :4], np.zeros(2)), r"\(4,\)"),
        (lambda s: translate(s[0], np.zeros(3)), r"shift must be \(2,\), got \(3,\)"),
        (lambda s: translate(s[0], np.array([np.nan, 0])), "shift"),
        (lambda s: rotate(s[0], np.inf, np.zeros(2)), "angle"),
        (lambda s: rotate(s[0] * np.nan, 1.0, np.zeros(2)), "state"),
        (lambda s: information_along(np.ones(3), np.eye(4)), r"cov must be \(3, 3\)"),
        (lambda s: information_along(np.ones(3), -np.eye(3)), "cov"),
        (lambda s: information_along(np.ones(3), np.zeros((3, 3))), "singular"),
        (lambda s: symbolic.state(-1), "-1"),
        (lambda s: symbolic.measurement([], symbolic.state(1)), "no sensor"),
        (lambda s: symbolic.measurement([3], symbolic.state(1)), "no formula for 3"),
        (lambda s: symbolic.trajectory_matrix([Position()], poses=()), "no pose"),
        (lambda s: symbolic.fixed_point_minors([Landmarks()]), "4 measurements of 5 states, got 2"),
    ],
)
def test_bad_input_is_named(call, words):
    states = a_drive(np.random.default_rng(13))
    with unchecked(), pytest.raises(ValueError, match=words):
        call(states)


class Lever:
    """East of a point that sits a metre ahead of the robot's centre."""

    def formula(self, x):
        return sympy.Matrix([x[0] + sympy.cos(x[2])])


def test_turning_on_the_spot_shows_the_heading_of_a_lever():
    for turn_rate, rank in ((0, 1), (1, 2)):
        matrix = symbolic.lie_matrix([Lever()], 0, speed=0, turn_rate=turn_rate)
        assert symbolic.read(matrix, [Lever()]).rank == rank


@pytest.mark.parametrize("n", [0, 1, 3])
def test_motions_of_the_world_in_symbols_are_those_in_numbers(n):
    at, about = np.arange(3.0 + 2 * n) ** 2 - 5, np.array([2.0, -3.0])
    x = symbolic.state(n)
    values = dict(zip(x, at.tolist(), strict=True))
    ours = [
        symbolic.gauge_direction(x, shift, turn, about=[*map(sympy.Rational, about.tolist())]).subs(
            values
        )
        for shift, turn in (((1, 0), 0), ((0, 1), 0), ((0, 0), 1))
    ]
    wanted = gauge_directions(at, about).values()
    for found, direction in zip(ours, wanted, strict=True):
        np.testing.assert_allclose(np.array(found, dtype=float)[:, 0], direction, atol=1e-12)
