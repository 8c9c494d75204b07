"""What the chapter tells a reader to find, in every state of the explorer of snakes."""

import numpy as np

from robot_perception.chapters.colour_and_shape import snake_explorers as explorers
from robot_perception.chapters.colour_and_shape import snake_figures as draw
from robot_perception.teaching.explore import MOST_STATES
from robot_perception.teaching.figures import image_axes
from tests.chapters.findings import limits, presets_that_show_the_default, states

CONTROLS = explorers.SNAKE_CONTROLS


def pairs():
    """Yield the settings with what the affine and the free snake make of them."""
    for state in states(CONTROLS):
        if state["snake"] == "free":
            yield state, explorers.slid(**(state | {"snake": "affine"})), explorers.slid(**state)


def test_no_preset_shows_the_default_and_there_are_not_too_many_states():
    assert not presets_that_show_the_default(explorers.SNAKE_PRESETS, CONTROLS)
    assert np.prod([len(c.values) for c in CONTROLS.values()]) <= MOST_STATES


def test_axes_stay_and_hold_the_snake():
    _, ax = image_axes(draw.segmented(explorers.scene()))
    seen = set()
    for state in states(CONTROLS):
        found = explorers.slid(**state)
        draw.slid(ax, found)
        seen.add(limits(ax))
        left, right, low, high = limits(ax)
        u, v = found.fit.outline.T
        assert left < u.min() < u.max() < right, state
        assert high < v.min() < v.max() < low, state
    assert len(seen) == 1


def test_the_affine_snake_leaves_the_neck_alone_whatever_its_weights():
    for state, affine, _ in pairs():
        assert affine.swallowed < 0.1, state
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
    for state in states(CONTROLS):
        words = explorers.describe_snake(**state)
        assert words.startswith("An affine" if state["snake"] == "affine" else "A free")
    start = {name: control.values[control.default] for name, control in CONTROLS.items()}
    free, stiff, elastic = (
        explorers.slid(**(start | explorers.SNAKE_PRESETS[name]))
        for name in ("free", "free and stiff", "too elastic")
    )
    assert free.swallowed > 0.5 > 0.25 > stiff.swallowed
    assert elastic.overlap < explorers.slid(**start).overlap - 0.05
