"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.pattern_tracking import bets, views
from robot_perception.chapters.pattern_tracking.explorers import displaced, hides, slopes
from robot_perception.chapters.pattern_tracking.scene import START
from tests.chapters.findings import ExplorerTests
from tests.chapters.ledger import recorded


class TestExplorers(ExplorerTests):
    explorers = (displaced, slopes, hides)


def states(explorer):
    return [explorer.state(**setting) for setting in explorer.parameters()]


def test_no_slope_is_more_than_twice_another():
    rates = np.array(slopes.found())
    assert rates.max() < 2 * rates.min()


def test_beyond_five_sigma_the_estimate_stays_and_within_one_it_follows():
    moved = states(displaced)
    far = [state.error for state in moved if state.away >= 5]
    near = [state.error for state in moved if state.away <= 1]
    assert len(far) > 10
    assert len(near) == 8
    assert min(far) > 12
    assert max(near) < 4


def test_only_many_particles_of_a_wider_walk_reach_five_sigma_of_the_papers():
    names = {name: {**displaced.default, **values} for name, values in displaced.presets.items()}
    wide = displaced.state(**names["five σ, a wider walk"])
    many = displaced.state(**names["five σ, a wider walk, more particles"])
    assert many.error < 3 < 20 < wide.error
    assert displaced.state(**names["five σ"]).error > 20


def test_without_tolerance_what_is_covered_is_reported_lost_and_with_it_one_side_is():
    for setting in hides.parameters():
        _, _, lost = hides.finding(hides.state(**setting))
        covered = setting["tolerance"] == "none" and setting["share"] > 0
        assert lost == (covered or (setting["share"] == 0.6 and setting["side"] == 1)), setting


def test_particles_of_the_drawing_are_drawn_about_the_start():
    state = views.sought(15, 0, 5.0, 200)
    np.testing.assert_allclose(state.drawn.mean(axis=0), START[:2], atol=1.5)
    np.testing.assert_allclose(state.drawn.std(axis=0), 5, rtol=0.15)


def test_the_film_holds_the_sign_while_it_is_covered_and_loses_it_when_it_jumps():
    film = views.film()
    assert np.median(film.off[: views.COVERED[0]]) < 0.4
    assert film.off[: views.JUMP].max() < 2
    assert film.off[views.JUMP :].min() > 2


def test_the_right_answers_of_the_bets_are_what_is_recorded():
    ledger = recorded()
    assert bets.THREE["right"] == "more than one σ"
    assert ledger["tracker-fig8"].value.low > 1
    assert ledger["tracker-fig8"].value.high < 3
    assert bets.COVERED["right"] == "the error grows"
    assert ledger["occlusion"].evidence["ratio, nothing covered"].low > 1
    assert bets.SMOOTH["right"] == "no"
    assert ledger["scale-smoothing"].evidence["ratio, model as printed"].low > 1


def test_the_mended_rule_is_as_good_as_the_better_one_at_both_ends():
    table = recorded()["occlusion"].tables["errors"]
    for column in ("0 %", "60 %"):
        mended = table["at worst", column]
        better = min(table[name, column].estimate for name in ("none", "left out"))
        assert mended.low <= better
    assert table["at worst", "0 %"].estimate < table["left out", "0 %"].low


def test_what_the_page_says_of_the_rivals():
    table = recorded()["tracker-fig8"].tables["errors"]
    for column in ("2σ", "3σ", "4σ"):
        for name in ("template matching", "optical flow"):
            assert table[name, column].high < table["one picture", column].low
    assert table["5000 particles", "3σ"].high < table["one picture", "3σ"].low
    best = min(table.rows, key=lambda name: table[name, "1σ"].estimate)
    assert best == "ECC"
    assert table["ECC", "3σ"].low > table["optical flow", "3σ"].high


def test_in_films_the_tracker_hardly_feels_the_smoothing():
    table = recorded()["scale-smoothing"].tables["likeness"]
    sharp = table["none", "error"]
    for name in table.rows:
        other = table[name, "error"]
        assert other.low < sharp.high
        assert sharp.low < other.high


def test_a_vector_is_taken_across_its_point():
    for at in (0, 40, 119):
        state = views.vector(at)
        np.testing.assert_allclose(state.line.mean(axis=0), state.points[at])
        assert state.fall[0] == pytest.approx(1)
