"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.colour_and_shape import explorers, films, states
from robot_perception.chapters.colour_and_shape.experiments import LOST
from robot_perception.teaching.explore import MOST_STATES
from tests.chapters.findings import limits, presets_that_show_the_default
from tests.unchecked import unchecked


@pytest.fixture(scope="module", autouse=True)
def _tried_as_a_reader_would():
    with unchecked():
        states.grid()


@pytest.mark.parametrize("explorer", [explorers.steps, explorers.many, explorers.snake])
def test_no_preset_shows_the_default_and_axes_stay(explorer):
    assert not presets_that_show_the_default(explorer)
    seen = {limits(explorer.drawn(**state)) for state in explorer.parameters()}
    assert len(seen) == 1
    assert len(list(explorer.parameters())) <= MOST_STATES


# One iteration -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def iterations():
    """Each iteration once; up to which step it is drawn changes nothing."""
    return explorers.steps.found(step="e")


def test_axes_of_the_iteration_hold_all_samples(iterations):
    left, right, *_ = limits(explorers.steps.drawn())
    for found in iterations:
        for places in (found.start, found.drifted, found.moved):
            assert left < places.min() <= places.max() < right, found.config


def test_at_least_a_quarter_of_the_samples_is_not_drawn(iterations):
    for found in iterations:
        assert found.drawn <= 0.75 * found.config.samples, found.config


def test_only_noise_tells_copies_apart(iterations):
    for found in iterations:
        places = len(np.unique(found.moved))
        assert places == (found.config.samples if found.config.noise else found.drawn)


def test_noise_costs_samples():
    for samples in explorers.steps.controls["samples"].values:
        worth = [found.effective for found in explorers.steps.found(samples=samples, step="e")]
        assert worth == sorted(worth, reverse=True)
        assert worth[0] > 0.7 * samples
        assert worth[-1] < 0.6 * samples


def test_only_wide_noise_reaches_the_other_object(iterations):
    for found in iterations:
        near = found.weights[np.abs(found.moved - 0.72) < 0.08].sum()
        config = found.config
        assert (near > 0.05) == (config.noise == 0.15 and config.samples > 5), config


def test_words_of_the_iteration_say_the_step():
    for state in explorers.steps.parameters():
        assert f"up to step {state['step']}" in explorers.steps.described(**state)


# How many samples, and how far -------------------------------------------------------------------


def test_without_noise_the_circle_is_lost_however_many_samples_there_are():
    curves = explorers.many.found(noise=0.0)
    for curve in curves:
        assert curve[-1] < LOST
        assert np.array_equal(curve, curves[0])


def test_with_noise_and_twenty_samples_the_circle_is_held_in_every_frame():
    for state in explorers.many.parameters():
        if state["noise"] and state["samples"] >= 20:
            (overlap,) = explorers.many.found(**state)
            assert overlap.min() > 0.75, state
            assert overlap.mean() > 0.95, state


def test_five_samples_hold_the_circle_with_half_the_noise_only():
    held = [overlap[-1] >= LOST for overlap in explorers.many.found(samples=5)]
    assert held == [False, True, False, False]


def test_words_of_the_overlap_say_how_it_ends():
    for state in explorers.many.parameters():
        (overlap,) = explorers.many.found(**state)
        end = "held to the end." if overlap[-1] >= LOST else "lost at the end."
        assert explorers.many.described(**state).endswith(end)
    assert explorers.many.described().endswith("held to the end.")


# Snakes ------------------------------------------------------------------------------------------


def pairs():
    """Yield the settings with what the affine and the free snake make of them."""
    for state in explorers.snake.parameters(snake="free"):
        yield state, states.slid(**(state | {"snake": "affine"})), states.slid(**state)


def test_axes_hold_the_snake():
    left, right, low, high = limits(explorers.snake.drawn())
    for state in explorers.snake.parameters():
        u, v = states.slid(**state).fit.outline.T
        assert left < u.min() < u.max() < right, state
        assert high < v.min() < v.max() < low, state


def test_the_affine_snake_leaves_the_neck_alone_whatever_its_weights():
    assert max(explorers.snake.found(snake="affine")) < 0.1
    for state, affine, _ in pairs():
        assert affine.fit.residual < 1e-8, state


def test_a_loose_free_snake_with_a_long_reach_swallows_most_of_the_neck():
    for state, _, free in pairs():
        loose = state["elasticity"] <= 0.2 and state["rigidity"] <= 10
        if loose and state["reach"] == 20:
            assert free.swallowed > 0.5, state
        if state["rigidity"] == 100 and state["reach"] <= 8:
            assert free.swallowed < 0.02, state


def test_no_free_snake_lies_better_than_the_affine_one_of_its_weights():
    for state, affine, free in pairs():
        if state["elasticity"] < 5:
            assert free.overlap < affine.overlap, state
    best = max(pairs(), key=lambda pair: pair[2].overlap)
    assert 0.93 < best[2].overlap < max(affine.overlap for _, affine, _ in pairs())


def test_too_much_elasticity_shrinks_every_snake():
    for state, affine, free in pairs():
        if state["elasticity"] == 5:
            assert max(affine.overlap, free.overlap) < 0.88, state


def test_words_and_presets_say_what_is_shown():
    for state in explorers.snake.parameters():
        words = explorers.snake.described(**state)
        assert words.startswith("An affine" if state["snake"] == "affine" else "A free")
    start = explorers.snake.default
    free, stiff, elastic = (
        states.slid(**(start | explorers.snake.presets[name]))
        for name in ("free", "free and stiff", "too elastic")
    )
    assert free.swallowed > 0.5 > 0.25 > stiff.swallowed
    assert elastic.overlap < states.slid(**start).overlap - 0.05


# The films ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("world", ["circles", "rectangle", "beetle", "snail"])
def test_in_the_films_shown_the_fused_tracker_holds_and_colour_alone_loses(world):
    assert films.overlap(world, "fused").min() > 0.75
    assert films.overlap(world, "colours adapted")[-1] < LOST
    assert (films.overlap(world, "edges alone")[-1] > 0.9) == (world == "circles")


def test_the_film_of_where_it_breaks_breaks():
    found = films.overlap("circles", "fused", films.CROSSED)
    assert found[:20].min() > 0.8
    assert found[-20:].max() < 0.05
