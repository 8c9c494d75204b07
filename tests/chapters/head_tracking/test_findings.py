"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.head_tracking import explorers, heads, scene
from robot_perception.teaching.explore import MOST_STATES
from tests.chapters.findings import limits, presets_that_show_the_default
from tests.unchecked import unchecked


@pytest.fixture(scope="module", autouse=True)
def _followed_as_a_reader_would():
    with unchecked():
        for film in scene.SCENES:
            scene.tracks(film)


@pytest.mark.parametrize("explorer", [explorers.rates, explorers.look])
def test_no_preset_shows_the_default_and_axes_stay(explorer):
    assert not presets_that_show_the_default(explorer)
    seen = {tuple(limits(ax) for ax in explorer.drawn(**state)) for state in explorer.parameters()}
    assert len(seen) == 1
    assert len(list(explorer.parameters())) <= MOST_STATES


def test_where_only_the_light_changes_every_adapted_model_misses_less():
    for rate in scene.RATES[1:]:
        assert max(explorers.rates.found(film=scene.LIGHT, rate=rate)) < 0


def test_without_adaptation_the_threshold_changes_nothing():
    for film in scene.SCENES:
        assert set(explorers.rates.found(film=film, rate=0.0)) == {0.0}
        for floor in scene.FLOORS:
            states = [scene.followed(film, 0.0, gate, floor).iou for gate in scene.GATES]
            for iou in states[1:]:
                np.testing.assert_array_equal(iou, states[0])


def test_where_others_pass_no_model_misses_less_than_the_fixed_one():
    assert min(explorers.rates.found(film=scene.CROWD)) >= 0


def test_in_as_many_cells_no_space_is_ahead_throughout_and_coarser_cells_do_more():
    gains = explorers.look.found()
    assert -0.065 < min(gains) < -0.03
    assert 0.03 < max(gains) < 0.065
    common = [scene.look(at).common for at in range(10, 150, 10)]
    coarser = [one["opponent"] - one["opponent, finer cells"] for one in common]
    assert min(coarser) > 0.065


def test_a_head_is_missed_only_where_it_can_be_seen():
    """Of four pictures two show it, and in one of these the ellipse is elsewhere."""
    visible = np.array([1.0, heads.SEEN, heads.SEEN - 0.01, 0.0])
    iou = np.array([1.0, 0.0, 0.0, 0.0])
    state = scene.Followed(scene.CROWD, 0.0, 0.0, 0.0, iou, np.ones(4), np.ones(4), visible)
    assert state.missed(state.iou) == 0.5
    assert state.missed(state.fixed) == 0


def test_descriptions_say_what_is_shown():
    setting = {"film": scene.CROWD, "rate": 0.5, "gate": 0.0, "floor": 0.0}
    assert "never given up" in explorers.rates.described(**setting)
    state = scene.followed(**setting)
    assert f"missed in {state.missed(state.iou):.0%}" in explorers.rates.described(**setting)
    assert "100% in opponent" in explorers.look.described(at=0)


def test_score_as_printed_is_perfect_for_all_that_is_smaller_than_the_head():
    found = scene.sizes()
    inside = found.half_widths <= found.true
    assert (found.printed[inside] == 1).all()
    assert (np.diff(found.printed[~inside]) < 0).all()
    assert found.half_widths[found.by_shares.argmax()] == found.true
