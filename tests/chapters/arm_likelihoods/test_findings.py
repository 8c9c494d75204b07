"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np

from robot_perception.chapters.arm_likelihoods import bets, views
from robot_perception.chapters.arm_likelihoods.explorers import dragged, gained
from robot_perception.chapters.arm_likelihoods.sweeping import NEAR
from tests.chapters.findings import ExplorerTests
from tests.chapters.ledger import recorded


class TestExplorers(ExplorerTests):
    explorers = (dragged, gained)


def test_the_outlines_highest_peak_is_elsewhere_and_that_of_all_cues_is_at_the_truth():
    for setting in dragged.parameters():
        state = dragged.state(**setting)
        if setting["mix"] == "shape":
            assert state.peaks.off > NEAR
            assert state.peaks.count > 5
        if setting["mix"] == "all":
            assert state.peaks.off <= NEAR
            assert state.peaks.count == 1


def test_the_dragged_hand_is_where_the_drawing_has_it():
    for away, bend in ((30, 70), (110, 10)):
        state = dragged.state(mix="shape", away=away, bend=bend)
        u, v = views.hand_place(away, bend)
        half = len(state.points) // 2
        hand = state.points[half - 8 : half]
        assert np.linalg.norm(hand.mean(axis=0) - [u, v]) < 6


def test_from_a_gain_of_one_on_the_distances_are_those_of_all_edges():
    for setting in gained.parameters():
        state = gained.state(**setting)
        if setting["gain"] >= 1:
            assert state.same
        elif not setting["stops"]:
            assert not state.same


def test_a_small_gain_blurs_and_standing_still_it_says_next_to_nothing():
    for wall in views.WALLS:
        wide, even = (gained.state(gain=gain, wall=wall, stops=False) for gain in (0.1, 1.0))
        assert (wide.surface > 0.5).mean() >= (even.surface > 0.5).mean()
    assert (gained.state(gain=0.1, wall=wall, stops=False).surface > 0.5).mean() > 0.05
    for gain in views.GAINS:
        still = gained.state(gain=gain, wall="cluttered", stops=True)
        other = gained.state(gain=1.0, wall="cluttered", stops=True)
        assert (still.distance != other.distance).mean() < 0.1


def test_the_right_answers_of_the_bets_are_what_is_computed():
    assert bets.HIDES["right"] == "hide the arm"
    assert recorded()["hidden-parts"].value.low > 0.5
    assert bets.TRUST["right"] == "no, they err a little more"
    assert recorded()["patch-confidence"].value.estimate > 0


def test_somebodys_hidden_arm_is_preferred():
    of, state, gain = views.hidden()
    assert gain > 0
    assert not of.model.collides(state[None])[0]
    visible = of.model.contours(np.array([of.angles, state])).visible[:, : of.model.points // 2]
    assert visible[1].sum() < 0.6 * visible[0].sum()


def test_a_straight_arm_does_not_move_and_a_bent_one_does():
    assert np.abs(views.straight(0.0)[1]).max() == 0
    assert views.straight(0.3)[1].max() > 10
