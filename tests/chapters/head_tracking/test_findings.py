"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.head_tracking import figures as draw
from robot_perception.chapters.head_tracking import scene
from robot_perception.teaching.explore import MOST_STATES
from robot_perception.teaching.figures import figure
from tests.chapters.findings import limits, presets_that_show_the_default, states

SETS = [
    (scene.RATE_PRESETS, scene.RATE_CONTROLS),
    (scene.LOOK_PRESETS, scene.LOOK_CONTROLS),
]


@pytest.mark.parametrize(("presets", "controls"), SETS)
def test_no_preset_shows_the_default_and_there_are_not_too_many_states(presets, controls):
    assert not presets_that_show_the_default(presets, controls)
    assert np.prod([len(c.values) for c in controls.values()]) <= MOST_STATES


@pytest.mark.parametrize(
    ("drawing", "shape", "state", "controls"),
    [
        (draw.tracked, (2, 1), scene.followed, scene.RATE_CONTROLS),
        (draw.looked, (1, 2), scene.look, scene.LOOK_CONTROLS),
    ],
)
def test_axes_stay(drawing, shape, state, controls):
    _, axes = figure(*shape, height=5.0)
    seen = set()
    for choice in states(controls):
        drawing(axes, state(**choice))
        seen.add(tuple(limits(ax) for ax in axes))
    assert len(seen) == 1


def test_where_only_the_light_changes_every_adapted_model_misses_less():
    for choice in states(scene.RATE_CONTROLS):
        state = scene.followed(**choice)
        if choice["film"] == scene.LIGHT and choice["rate"] > 0:
            assert state.missed(state.iou) < state.missed(state.fixed), choice


def test_where_others_pass_no_model_misses_less_than_the_fixed_one():
    for choice in states(scene.RATE_CONTROLS):
        state = scene.followed(**choice)
        if choice["film"] == scene.CROWD:
            assert state.missed(state.iou) >= state.missed(state.fixed), choice


def test_in_as_many_cells_heads_have_as_much_in_common_as_in_rgb_or_more():
    gains = []
    for choice in states(scene.LOOK_CONTROLS):
        found = scene.look(**choice).common
        gains.append(found["opponent, finer cells"] - found["RGB"])
        assert gains[-1] >= -0.01, choice
    assert max(gains) > 0.1


def test_descriptions_say_what_is_shown():
    words = scene.describe_rates(scene.CROWD, 0.5, 0.0)
    state = scene.followed(scene.CROWD, 0.5, 0.0)
    assert f"missed in {state.missed(state.iou):.0%}" in words
    assert "100% in opponent" in scene.describe_look(0)


def test_score_as_printed_is_perfect_for_all_that_is_smaller_than_the_head():
    found = scene.sizes()
    inside = found.half_widths <= found.true
    assert (found.printed[inside] == 1).all()
    assert (np.diff(found.printed[~inside]) < 0).all()
    assert found.half_widths[found.by_shares.argmax()] == found.true
