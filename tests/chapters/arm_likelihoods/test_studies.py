"""The studies: peaks, bumps, sums and hidden poses, by law."""

import numpy as np
import pytest

from robot_perception.arms.body_model import BodyModel
from robot_perception.chapters.arm_likelihoods import colouring, hiding, silent, summing, sweeping
from robot_perception.chapters.arm_likelihoods.scene import (
    AWAY,
    AWAYS,
    BEND,
    BENDS,
    CAMERA,
    CHOOSING,
    MIXES,
    cues,
    glance,
    surfaces,
    swept,
)


def bump(at, height, wide=2.0):
    k, j = np.meshgrid(np.arange(len(AWAYS)), np.arange(len(BENDS)), indexing="ij")
    return height * np.exp(-((k - at[0]) ** 2 + (j - at[1]) ** 2) / (2 * wide**2))


def test_peaks_are_counted_and_compared():
    log = np.log(bump((8, 8), 1.0) + bump((25, 20), 0.4) + bump((25, 3), 0.01) + 1e-6)
    angles = np.zeros(8)
    angles[[AWAY, BEND]] = AWAYS[8] + np.radians(4.0), BENDS[8]
    found = sweeping.peaks(log, angles)
    assert found.count == 2
    assert found.second == pytest.approx(0.4, rel=0.01)
    assert np.degrees(found.off) == pytest.approx(4.0)
    assert found.out
    angles[AWAY] += np.radians(20)
    assert not sweeping.peaks(log, angles).out
    equal = np.log(bump((8, 8), 1.0) + bump((25, 20), 0.8) + 1e-6)
    assert not sweeping.peaks(equal, angles).out


def test_the_sweep_moves_two_angles_of_the_arm_on_the_left_only():
    states = swept(np.arange(8.0))
    assert states.shape == (len(AWAYS) * len(BENDS), 8)
    np.testing.assert_array_equal(states[:, [1, 2, 4, 5, 6, 7]],
                                  np.tile([1, 2, 4, 5, 6, 7], (len(states), 1)))  # fmt: skip
    assert len(np.unique(states[:, AWAY])) == len(AWAYS)
    grid = states[:, BEND].reshape(len(AWAYS), -1)
    np.testing.assert_array_equal(grid[3], BENDS)


def test_a_mix_is_the_product_of_its_cues():
    shown = glance(CHOOSING[0], 10)
    logs = surfaces(shown)
    assert set(logs) == set(cues(shown.first))
    every = sweeping.mixed(logs, "all")
    np.testing.assert_allclose(every, logs["shape and motion"] + logs["colour"] + logs["texture"])
    assert all(set(names) <= set(logs) for names in MIXES.values())


def test_who_stands_still_has_no_edge_that_moves():
    assert not glance(CHOOSING[0], 10, stops=True).seen.moves
    assert glance(CHOOSING[0], 10).seen.moves


def test_bumps_are_local_maxima_that_stand_out():
    x = np.linspace(0, 6 * np.pi, 400)
    assert summing.bumps(1 - np.cos(x)) == 3
    assert summing.bumps(1 - np.cos(x) + 0.01 * np.sin(40 * x)) == 3
    assert summing.bumps(np.linspace(0, 1, 50)) == 1, "the end of a slope counts"


def test_costs_grow_as_their_form_says():
    config = summing.Sums((1, 2), "square of the sum")
    points = np.array([10, 20, 40])
    costs = np.stack([points**2.0, points * 1.0, 0 * points + 3.0])[None].repeat(2, axis=0)
    result = summing.Summed(config, (10, 20, 40), costs, np.zeros((2, 3)))
    growth = [result.growth(form).estimate for form in summing.FORMS]
    np.testing.assert_allclose(growth, [2, 1, 0], atol=1e-9)


def contours_of(shown):
    """Return how many points of the arm on the left the true pose shows."""
    half = shown.model.points // 2
    return shown.model.contours(shown.angles[None]).visible[0, :half].sum()


def test_hidden_poses_leave_the_other_arm_alone_and_show_least():
    shown = glance(CHOOSING[0])
    states = hiding.drawn(shown, 500, np.random.default_rng(0))
    np.testing.assert_array_equal(states[:, 4:], np.tile(shown.angles[4:], (len(states), 1)))
    assert not shown.model.collides(states).any()
    assert shown.model.possible(states).all()
    state, _, share = hiding.best_hidden(shown, states, "as printed")
    visible = shown.model.contours(states).visible[:, : shown.model.points // 2].sum(axis=1)
    mine = shown.model.contours(state[None]).visible[0, : shown.model.points // 2].sum()
    assert (visible <= mine).mean() <= 0.1
    assert share == mine / contours_of(shown)


def test_contours_of_a_straight_arm_have_rank_three():
    model = BodyModel.from_face(np.array([145.0, 42.0, 30.0, 30.0]), CAMERA)
    straight, bent = (silent.jacobian(model, silent.pose(bend)) for bend in (0.0, 0.4))
    assert silent.rank(straight) == 3
    assert silent.rank(bent) == 4
    assert np.abs(straight[:, silent.ABOUT]).max() == 0
    assert all(entry == 0 for entry in silent.symbolic())


def test_errors_of_a_patch_that_says_nothing_are_one():
    """A patch all of one colour on a wall of that colour: no state is better than another."""
    shown = glance(CHOOSING[1])
    found = colouring.errors(shown)
    assert found.shape == (6,)
    assert ((found > 0) & (found < 1.3)).all()
    assert (colouring.contrasts(shown) >= 0).all()


def test_the_square_of_a_hand_is_most_alike_to_itself():
    still = glance(CHOOSING[9], stops=True, pose=tuple(glance(CHOOSING[9]).first.state.tolist()))
    likelihood = colouring.field(still)
    joints = still.model.joints(still.first.state[None])[0]
    hands = still.model.pixels(joints[:, 2:].mean(axis=1))
    k, j = np.unravel_index(likelihood.argmax(), likelihood.shape)
    best = np.array([colouring.COLUMNS[j], colouring.ROWS[k]])
    assert np.linalg.norm(hands - best, axis=1).min() < 16
