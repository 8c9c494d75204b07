"""What the chapter tells a reader to find, in every state of two explorers."""

import numpy as np
import pytest

from robot_perception.chapters.colour_and_shape import explorers, films
from robot_perception.chapters.colour_and_shape import figures as draw
from robot_perception.chapters.colour_and_shape.experiments import CHOOSING, LOST
from robot_perception.teaching.explore import MOST_STATES
from robot_perception.teaching.figures import figure
from tests.chapters.findings import default, limits, presets_that_show_the_default, states

ITERATION, SAMPLES = explorers.ITERATION_CONTROLS, explorers.SAMPLES_CONTROLS


@pytest.mark.parametrize(
    ("presets", "controls"),
    [
        (explorers.ITERATION_PRESETS, ITERATION),
        (explorers.SAMPLES_PRESETS, SAMPLES),
    ],
)
def test_no_preset_shows_the_default_and_there_are_not_too_many_states(presets, controls):
    assert not presets_that_show_the_default(presets, controls)
    assert np.prod([len(c.values) for c in controls.values()]) <= MOST_STATES


# One iteration -----------------------------------------------------------------------------------


def iterations():
    """Yield each iteration with its number of samples and its noise."""
    for samples in ITERATION["samples"].values:
        for noise in ITERATION["noise"].values:
            yield samples, noise, explorers.iterated(samples, noise)


def test_axes_of_the_iteration_stay_and_hold_all_samples():
    _, ax = figure()
    seen = set()
    for state in states(ITERATION):
        found = explorers.iterated(state["samples"], state["noise"])
        draw.iterated(ax, found, state["step"])
        seen.add(limits(ax))
        for places in (found.start, found.drifted, found.moved):
            assert limits(ax)[0] < places.min() <= places.max() < limits(ax)[1], state
    assert len(seen) == 1


def test_at_least_a_quarter_of_the_samples_is_not_drawn():
    for samples, noise, found in iterations():
        assert explorers.drawn(found) <= 0.75 * samples, (samples, noise)


def test_only_noise_tells_copies_apart():
    for samples, noise, found in iterations():
        places = len(np.unique(found.moved))
        assert places == (samples if noise else explorers.drawn(found)), (samples, noise)


def test_noise_costs_samples():
    worth = {(n, b): explorers.effective(found) for n, b, found in iterations()}
    for samples in ITERATION["samples"].values:
        least, some, much = (worth[samples, b] for b in ITERATION["noise"].values)
        assert least > some > much, samples
        assert least > 0.7 * samples
        assert much < 0.6 * samples


def test_only_wide_noise_reaches_the_other_object():
    for samples, noise, found in iterations():
        near = found.weights[np.abs(found.moved - 0.72) < 0.08].sum()
        assert (near > 0.05) == (noise == 0.15 and samples > 5), (samples, noise)


def test_words_of_the_iteration_say_the_step():
    for state in states(ITERATION):
        words = explorers.describe_iteration(**state)
        assert f"up to step {state['step']}" in words


# How many samples, and how far -------------------------------------------------------------------


def held(samples, noise):
    """Tell whether the circle is held to the last frame."""
    return explorers.overlap(samples, noise)[-1] >= LOST


def test_axes_of_the_overlap_stay():
    _, ax = figure()
    seen = set()
    for state in states(SAMPLES):
        draw.tried(ax, **state)
        seen.add(limits(ax))
    assert len(seen) == 1


def test_without_noise_the_circle_is_lost_however_many_samples_there_are():
    curves = [explorers.overlap(samples, 0.0) for samples in explorers.MANY]
    for curve in curves:
        assert curve[-1] < LOST
        assert np.array_equal(curve, curves[0])


def test_with_noise_and_twenty_samples_the_circle_is_held_in_every_frame():
    for state in states(SAMPLES):
        if state["noise"] and state["samples"] >= 20:
            assert explorers.overlap(**state).min() > 0.75, state
            assert explorers.overlap(**state).mean() > 0.95, state


def test_five_samples_hold_the_circle_with_half_the_noise_only():
    assert [held(5, noise) for noise in explorers.NOISES] == [False, True, False, False]


def test_words_of_the_overlap_say_how_it_ends():
    for state in states(SAMPLES):
        words = explorers.describe_samples(**state)
        assert words.endswith("held to the end." if held(**state) else "lost at the end.")
    assert held(**default(SAMPLES))


# The films ---------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("world", ["circles", "rectangle", "beetle", "snail"])
def test_in_the_films_shown_the_fused_tracker_holds_and_colour_alone_loses(world):
    found = films.tracks(world).overlap
    assert found["fused"].min() > 0.8
    assert found["colours adapted"][-1] < LOST
    assert (found["edges alone"][-1] > 0.9) == (world == "circles")


@pytest.mark.slow
def test_the_film_of_where_it_breaks_breaks():
    found = films.tracks("circles", CHOOSING[-1]).overlap["fused"]
    assert found[0] > 0.8
    assert found[-1] == 0
