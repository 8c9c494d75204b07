"""Distributions of colours: described, warped, and their motion learned."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from robot_perception.appearance.colour_distribution import (
    ColourDistribution,
    Dynamics,
    describe,
    learn,
    turn,
    warp,
)
from tests.unchecked import unchecked

SEEDS = st.integers(0, 2**31)
QUARTER = np.pi / 2


def cloud(rng, lengths=(0.1, 0.05, 0.02), count=200):
    """Return colours with these principal lengths on average, and the rotation of their axes."""
    axes = Rotation.random(random_state=rng).as_matrix()
    return 0.5 + (rng.normal(size=(count, 3)) * lengths) @ axes.T, axes


def same_axes(one, other, tolerance=1e-9):
    """Assert that axes agree but for their signs."""
    np.testing.assert_allclose(np.abs(one.mT @ other), np.eye(3), atol=tolerance)


@given(SEEDS)
def test_described_as_numpy_describes(seed):
    colours, _ = cloud(np.random.default_rng(seed))
    found = describe(colours)
    values, vectors = np.linalg.eigh(np.cov(colours.T, bias=True))
    np.testing.assert_allclose(found.mean, colours.mean(axis=0))
    np.testing.assert_allclose(found.lengths, np.sqrt(values[::-1]))
    same_axes(found.axes, vectors[:, ::-1], 1e-6)
    assert np.linalg.det(found.axes) == pytest.approx(1)


@given(SEEDS)
def test_a_warped_set_is_described_by_where_it_was_warped_to(seed):
    rng = np.random.default_rng(seed)
    colours, _ = cloud(rng)
    other, _ = cloud(rng, lengths=(0.2, 0.1, 0.03))
    before, after = describe(colours), describe(other)
    found = describe(warp(colours, before, after), before.axes)
    np.testing.assert_allclose(found.mean, after.mean)
    np.testing.assert_allclose(found.lengths, after.lengths)
    same_axes(found.axes, after.axes, 1e-6)
    np.testing.assert_allclose(warp(warp(colours, before, after), after, before), colours)


def test_the_shortest_axis_turns_round_where_the_nearest_ones_are_a_mirror():
    colours = np.array(
        [[1.0, 0, 0], [-1, 0, 0], [0, 0.5, 0], [0, -0.5, 0], [0, 0, 0.2], [0, 0, -0.2]]
    )
    before = Rotation.from_rotvec(np.deg2rad(150) * np.ones(3) / np.sqrt(3)).as_matrix()
    found = describe(colours, before)
    np.testing.assert_allclose(found.axes, np.diag([-1.0, -1, 1]), atol=1e-12)
    nearest = np.sum(found.axes * before, axis=0) > 0
    assert nearest.tolist() == [True, True, False]


@given(SEEDS, st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_states_come_back_with_their_angles(seed, theta, phi):
    rng = np.random.default_rng(seed)
    colours, _ = cloud(rng)
    before = describe(colours)
    state = np.r_[0.4, 0.5, 0.6, 0.3, 0.2, 0.1, theta, phi]
    after = ColourDistribution.of(state, before.axes)
    np.testing.assert_array_equal(after.state, state)
    np.testing.assert_allclose(
        describe(warp(colours, before, after), before.axes).state, state, atol=1e-7
    )


@given(st.floats(-3, 3), st.floats(-QUARTER, QUARTER))
def test_two_angles_are_two_turns(theta, phi):
    expected = Rotation.from_euler("ZY", [theta, -phi]).as_matrix()
    np.testing.assert_allclose(turn(np.array([theta, phi])), expected, atol=1e-12)


def test_a_turn_leaves_no_twist_about_the_first_axis():
    for angles in np.random.default_rng(0).uniform(-1, 1, (20, 2)):
        assert turn(angles)[2, 1] == 0  # the second axis stays in the plane of the first two


def test_unturned_axes_keep_their_signs():
    axes = Rotation.random(random_state=3).as_matrix()
    for signs in ([1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]):
        before = axes * signs
        colours = np.diag([0.3, 0.2, 0.1]) @ axes.T
        found = describe(np.vstack([colours, -colours]), before)
        np.testing.assert_allclose(found.axes, before, atol=1e-12)
        np.testing.assert_allclose(found.angles, 0, atol=1e-12)


@pytest.mark.parametrize("count", [1, 7])
def test_one_colour_has_no_length_and_the_axes_before(count):
    axes = Rotation.random(random_state=1).as_matrix()
    found = describe(np.full((count, 3), 0.25), axes)
    np.testing.assert_array_equal(found.mean, 0.25)
    np.testing.assert_array_equal(found.lengths, 0)
    np.testing.assert_allclose(found.axes, axes, atol=1e-12)
    np.testing.assert_allclose(found.angles, 0, atol=1e-12)


def test_of_equal_lengths_the_axes_before_are_kept():
    ball = np.vstack([np.eye(3), -np.eye(3)])
    before = Rotation.from_euler("xyz", [0.4, 0.3, 0.2]).as_matrix()
    np.testing.assert_allclose(describe(ball, before).axes, before, atol=1e-12)
    disc = ball * [1.0, 0.1, 1.0]  # two equal lengths: their plane is given, not their axes
    found = describe(disc, np.eye(3))
    np.testing.assert_allclose(found.lengths, np.sqrt(1 / 3) * np.array([1, 1, 0.1]))
    np.testing.assert_allclose(np.abs(found.axes[:, 2]), [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(found.axes[:, 0], [1, 0, 0], atol=1e-12)


def test_a_flat_set_is_moved_and_turned_but_not_stretched_out_of_its_plane():
    rng = np.random.default_rng(0)
    line = 0.5 + np.outer(rng.normal(size=50), [0.1, 0.0, 0.0])
    before = describe(line)
    wider = ColourDistribution(np.full(3, 0.2), np.full(3, 0.3), np.eye(3), np.zeros(2))
    found = describe(warp(line, before, wider))
    np.testing.assert_allclose(found.mean, 0.2)
    np.testing.assert_allclose(found.lengths, [0.3, 0, 0], atol=1e-9)


def test_a_batch_is_warped_as_one_after_the_other():
    rng = np.random.default_rng(0)
    colours, _ = cloud(rng)
    before = describe(colours)
    states = before.state + 0.02 * rng.uniform(size=(5, 8))
    batch = warp(colours, before, ColourDistribution.of(states, before.axes))
    for state, found in zip(states, batch, strict=True):
        after = ColourDistribution.of(state, before.axes)
        np.testing.assert_allclose(found, warp(colours, before, after))


def spiral(A, count, rng, noise=0.0):
    """Return states that follow x_t = A x_{t-1} + 0.01 + noise."""
    states = [np.r_[0.5, 0.4, 0.6, 0.1, 0.2, 0.1, 0.1, 0.2]]
    for _ in range(count):
        states.append(A @ states[-1] + 0.01 + noise * rng.normal(size=8))
    return np.array(states)


def test_learned_dynamics_are_those_of_the_training():
    rng = np.random.default_rng(0)
    A = 0.7 * np.eye(8) + 0.02 * rng.uniform(-1, 1, (8, 8))
    found = learn(spiral(A, 60_000, rng, 0.02), ridge=1e-6)
    np.testing.assert_allclose(found.A, A, atol=0.03)
    np.testing.assert_allclose(found.b, 0.01, atol=0.03)
    np.testing.assert_allclose(found.B @ found.B.T, 0.02**2 * np.eye(8), atol=2e-5)


def test_constant_velocity_is_found_and_goes_on():
    states = np.linspace(0.2, 0.8, 30)[:, None] * np.r_[np.ones(6), 0, 0]
    dynamics = learn(states, order=2)
    assert dynamics.order == 2
    ahead = dynamics.propagate(np.r_[states[-1], states[-2]], rng=np.random.default_rng(0))
    np.testing.assert_allclose(ahead[:8], 2 * states[-1] - states[-2], atol=1e-6)
    np.testing.assert_array_equal(ahead[8:], states[-1])


def test_what_training_does_not_show_stays_as_it_was():
    still = np.tile(np.r_[0.5, 0.4, 0.3, 0.1, 0.1, 0.1, 0.0, 0.0], (20, 1))
    dynamics = learn(still)
    np.testing.assert_allclose(dynamics.A, np.diag([1, 1, 1, 1, 1, 1, 0, 0]), atol=1e-12)
    np.testing.assert_allclose([*dynamics.b, *dynamics.B.ravel()], 0, atol=1e-9)


def test_the_ridge_pulls_to_the_state_as_it_was():
    states = spiral(0.5 * np.eye(8), 300, np.random.default_rng(0), 0.02)
    strong, weak = (np.diag(learn(states, ridge=r).A)[:6] for r in (100.0, 0.01))
    assert (strong > 0.95).all()
    assert (weak < 0.7).all()


def test_noise_has_its_covariance_and_can_be_left_out():
    rng = np.random.default_rng(0)
    B = 0.1 * rng.normal(size=(8, 8))
    dynamics = Dynamics(0.5 * np.eye(8), np.full(8, 5.0), B)
    moved = dynamics.propagate(np.ones((200_000, 8)), rng=rng, noise=2.0)
    np.testing.assert_allclose(np.cov(moved.T), 4 * B @ B.T, atol=0.01)
    np.testing.assert_array_equal(dynamics.propagate(np.ones(8), rng=rng, noise=0.0), 5.5)


def test_lengths_are_reflected_at_zero():
    dynamics = Dynamics(-np.eye(8), np.zeros(8), np.zeros((8, 8)))
    moved = dynamics.propagate(np.ones((2, 8)), rng=np.random.default_rng(0))
    np.testing.assert_array_equal(moved[0], [-1, -1, -1, 1, 1, 1, -1, -1])


@pytest.mark.parametrize(
    ("wrong", "match"),
    [
        (lambda: describe(np.zeros((0, 3))), "colours"),
        (lambda: describe(np.full((2, 3), np.nan)), "colours"),
        (lambda: describe(np.zeros((2, 3)), 2 * np.eye(3)), "axes"),
        (lambda: describe(np.zeros((2, 3)), np.diag([1.0, 1.0, -1.0])), "axes"),
        (lambda: ColourDistribution.of(-np.ones(8), np.eye(3)), "states"),
        (lambda: Dynamics(np.zeros((8, 7)), np.zeros(8), np.eye(8)), "A must be"),
        (lambda: learn(np.zeros((3, 8)), order=2), "states"),
        (lambda: learn(np.zeros((9, 8)), order=3), "order"),
        (lambda: learn(np.zeros((9, 8)), ridge=0.0), "ridge"),
    ],
)
def test_wrong_arguments_are_named(wrong, match):
    with unchecked(), pytest.raises(ValueError, match=match):
        wrong()


def test_a_set_is_not_warped_from_a_batch():
    one = describe(np.eye(3))
    batch = ColourDistribution.of(np.tile(one.state, (2, 1)), np.eye(3))
    with pytest.raises(ValueError, match="before"):
        warp(np.eye(3), batch, one)
