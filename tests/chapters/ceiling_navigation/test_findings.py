"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.ceiling_navigation import (
    bets,
    chaining,
    explorers,
    key_images,
    scene,
    upto_scale,
)
from tests.chapters.findings import ExplorerTests, limits
from tests.chapters.ledger import recorded
from tests.unchecked import unchecked


@pytest.fixture(scope="module", autouse=True)
def _driven_as_a_reader_would():
    with unchecked():
        for state in explorers.servoing.parameters():
            scene.driven(**state)


class TestExplorers(ExplorerTests):
    explorers = (explorers.servoing, explorers.dragged)


def test_in_all_63_states_the_robot_arrives_near_the_path():
    found = explorers.servoing.found()
    assert len(found) == 63
    assert {status for *_, status in found} == {"arrived"}
    assert max(off for _, off, *_ in found) < 0.18


def test_the_robot_swings_only_where_the_factor_reaches_the_limit():
    found = explorers.servoing.found()
    swings = [share for share, _, wagging, _ in found if wagging > 1]
    assert min(swings) >= 1
    assert len(swings) >= 6


def test_half_the_scale_is_slower_and_cuts_the_bends():
    for bearing in scene.BEARINGS:
        true, half, quarter = (scene.driven(factor, bearing, 0.0) for factor in (1.0, 0.5, 0.25))
        assert len(true.path) < len(half.path) < len(quarter.path)
        reach = [np.abs(s.path[:, 1]).max() for s in (quarter, half, true)]
        assert reach[0] < reach[1] < reach[2]


def test_a_robot_that_turns_more_quickly_bears_a_scale_three_times_too_large():
    slow, quick = (scene.driven(3.0, bearing, 0.6) for bearing in (1.8, 4.0))
    assert slow.wagging > 1 > quick.wagging


def test_the_right_quotient_is_right_everywhere_and_the_other_nowhere():
    found = np.array(explorers.dragged.found())
    assert len(found) == 96
    assert found[:, 0].max() < 1e-12
    assert 0.06 < found[:, 1].min() < 0.07
    assert 3.6 < found[:, 1].max() < 3.7
    # somewhere else from every place
    places = [scene.placed(**p).poses[chaining.OVER][:2] for p in explorers.dragged.parameters()]
    assert len(np.unique(np.round(places, 6), axis=0)) == 96


def test_what_is_drawn_of_the_quotient_is_inside_the_axes():
    for state in explorers.dragged.parameters():
        left, right, low, high = limits(explorers.dragged.drawn(**state))
        for x, y, _ in scene.placed(**state).poses.values():
            assert left < x < right
            assert high < y < low


def test_words_say_what_is_shown():
    assert "unstable" in explorers.servoing.described(factor=3.0)
    assert "lost" not in explorers.servoing.described(factor=3.0)
    state = scene.placed(0.6, 0.4, 45.0)
    assert f"{state.off(chaining.OVER):.2f} m away" in explorers.dragged.described()


def test_the_right_answers_of_the_bets_are_what_is_computed():
    assert bets.HIGHER["right"] == "at the key image"
    end = upto_scale.approach(np.array([-1.5, 0.2, 0.1]), 1.5, upto_scale.Config())[-1]
    assert np.hypot(*end[:2]) < 0.01
    assert bets.LOOP["right"] == "it leaves the circle out"
    (_, circle, came), (_, stood, lost), (_, cut, there) = scene.by_conditions().values()
    assert (came, lost, there) == ("arrived", "lost", "arrived")
    true = key_images.taught("circle")
    assert key_images.far(true, circle) < 0.2
    assert cut[:, 1].max() < 0.3 < 1.3 < circle[:, 1].max()
    assert len(stood) < len(circle) / 2
    assert bets.DRIFT["right"] == "those of headings"


def test_headings_bend_the_mosaic_more_than_positions():
    """With headings made right afterwards most of the error is gone."""
    run = scene.loop()
    steps = np.diff(run.located(run.mosaic)[:, :2], axis=0)
    wrong, right = run.located(run.mosaic)[:-1, 2], run.true[:-1, 2]
    turn = right - wrong
    turned = np.stack(
        [
            np.cos(turn) * steps[:, 0] - np.sin(turn) * steps[:, 1],
            np.sin(turn) * steps[:, 0] + np.cos(turn) * steps[:, 1],
        ],
        axis=-1,
    )
    mended = run.true[0, :2] + np.concatenate([np.zeros((1, 2)), np.cumsum(turned, axis=0)])
    jumps = np.hypot(*steps.T) > 0.2  # where it locates itself by older patterns
    last = int(np.argmax(jumps)) if jumps.any() else len(steps)
    before = run.off(run.located(run.mosaic))[:last]
    after = np.hypot(*(mended - run.true[:, :2])[:last].T)
    assert np.sqrt(np.mean(after**2)) < 0.5 * np.sqrt(np.mean(before**2))


def test_adjusted_the_loop_of_the_page_is_nearer_to_the_truth():
    run = scene.loop()
    chained, adjusted = (run.patterns_off(m) for m in (run.mosaic, run.adjusted))
    assert np.sqrt(np.mean(adjusted**2)) < 0.25 * np.sqrt(np.mean(chained**2))


def test_the_record_says_what_the_page_tells():
    found = recorded()["pose-up-to-scale"].evidence
    assert found["camera 30 cm behind the axle"].estimate == 0
    assert found["a changed tilt moves the end by"].estimate == pytest.approx(0.087, abs=0.01)
    needed = recorded()["key-image-conditions"].evidence
    assert needed["both, and two patterns in common"].low > needed["both conditions reproduce"].high
