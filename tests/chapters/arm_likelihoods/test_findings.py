"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

import numpy as np
import pytest

from robot_perception.arms.likelihoods import sampled, square_of_sum
from robot_perception.book import arm_likelihoods as page
from robot_perception.chapters.arm_likelihoods import scene
from robot_perception.chapters.arm_likelihoods.scene import glance


def test_the_outline_has_many_peaks_and_all_cues_have_one():
    count = {mix: state for mix, state, _ in page.dragged.found(away=70, bend=90)}
    assert count["shape"] > 5
    assert count["all"] == 1


def test_the_dragged_hand_is_where_the_drawing_has_it():
    for away, bend in ((30, 70), (110, 10)):
        state = page.dragged_state("shape", away, bend)
        u, v = page.hand_place(away, bend)
        points, _ = state.outline
        half = len(points) // 2
        assert np.linalg.norm(points[half - 8 : half].mean(axis=0) - [u, v]) < 6


def test_words_say_what_is_drawn():
    words = page.dragged_words(page.dragged_state("all", 30, 70))
    assert "1 peak;" in words
    assert "at the true pose" in words
    assert "Motion changes nothing" in page.gained_words(page.gained_state(1.0, "cluttered", False))
    assert "reach farther" in page.gained_words(page.gained_state(0.25, "cluttered", False))


def test_a_small_gain_blurs():
    for wall in page.WALLS:
        wide, even = (page.gained_state(gain, wall, False) for gain in (0.1, 1.0))
        assert (wide.surface > 0.5).mean() > (even.surface > 0.5).mean()


def test_standing_still_next_to_nothing_moves():
    still, moves = (
        (glance(page.MOVES, scene.CLUTTER, 0, stops).seen.moving == 0).sum()
        for stops in (True, False)
    )
    assert still < 0.2 * moves


def test_the_pose_that_is_drawn_hides_the_arm_and_costs_less():
    of, state = page.hidden_pose()
    assert not of.model.collides(state[None])[0]
    contours = of.model.contours(np.array([of.angles, state]))
    half = of.model.points // 2
    assert contours.visible[1, :half].sum() < 0.4 * contours.visible[0, :half].sum()
    far = sampled(of.seen.static, contours, of.seen.most)
    truth, hidden = square_of_sum(far, contours.visible, 1.0)
    assert hidden > truth


def test_the_most_alike_place_of_the_picture_is_the_hand_itself():
    alike = page.whole_field()
    k, j = np.unravel_index(alike.likelihood.argmax(), alike.likelihood.shape)
    there = np.array([page.COLUMNS[j], page.ROWS[k]])
    assert np.linalg.norm(there - alike.place) < 12


def test_twice_the_points_cost_what_the_exercise_says():
    wider = page.EXERCISES["likelihoods-sums"].answer
    one, two = (
        square_of_sum(np.full((1, n), 3.0), np.ones((1, n), bool), sigma)[0]
        for n, sigma in ((10, 1.0), (20, wider))
    )
    assert two == pytest.approx(one)


def test_the_factor_of_the_exercise_makes_the_lower_peak_a_hundredth():
    heights = np.exp(page.EXERCISES["likelihoods-sharp"].answer * (page.LOG - page.LOG.max()))
    assert page.maxima(heights + 0.1 * np.exp(page.LOG)) == 2
    assert heights[60:].max() == pytest.approx(0.01)


def test_the_person_that_is_shown_is_scored_nowhere():
    assert scene.SHOWN not in {*page.FIRST, *page.FRESH}
    assert not set(scene.CHOOSING) & {*page.FIRST, *page.FRESH}
