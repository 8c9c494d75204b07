"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.book import pattern_tracking as page
from robot_perception.ceiling.contours import find_contours, find_edges
from robot_perception.ceiling.recognition import EdgeField, RecognitionRules, recognise
from robot_perception.ceiling.tracker import PatternTracker
from robot_perception.chapters.pattern_tracking.scene import COORDINATES, RULES, START


def test_only_many_particles_of_a_wider_walk_reach_five_sigma_of_the_papers():
    explorer = page.moved_sign
    named = {n: explorer.state(**explorer.default | v) for n, v in explorer.presets.items()}
    many, wide = named["five σ, a wider walk, more particles"], named["five σ, a wider walk"]
    assert many.error < 3 < 20 < wide.error
    assert named["five σ"].error > 20
    edge = named["three σ and more"]
    assert edge.away > 3
    assert edge.error > 5


def test_particles_of_the_drawing_are_drawn_about_the_start():
    state = page.sought(15, 0, 5.0, 200)
    np.testing.assert_allclose(state.drawn.mean(axis=0), START[:2], atol=1.5)
    np.testing.assert_allclose(state.drawn.std(axis=0), 5, rtol=0.15)


def test_a_walk_of_other_width_is_that_of_the_tracker():
    """Of a narrow walk no particle reaches what lies at four of its σ."""
    assert page.sought(5, 0, 2.5, 200).away == 2
    assert page.sought(15, 0, 2.5, 2000).error > page.sought(15, 0, 5.0, 2000).error


def test_the_film_holds_the_sign_while_it_is_covered_and_loses_it_when_it_jumps():
    film = page.sign_film()
    assert np.median(film.off[: film.covered[0]]) < 0.4
    assert film.off[: film.jump].max() < 2
    assert film.off[film.jump :].min() > 2


def test_the_sign_is_found_again_where_it_is():
    film, pattern = page.sign_film(), page.sign()
    image, edges = film.images[-1], find_edges(film.images[-1])
    sizes = RecognitionRules(scales=(0.8, 0.9, 1.0, 1.1, 1.25))
    places = recognise(pattern, EdgeField(edges), find_contours(edges), sizes)[:5]
    tracker, rng = (
        PatternTracker(pattern, replace(RULES, passes=2)),
        np.random.default_rng(1),
    )
    infos = [tracker.step(tracker.start(one.pose), image, rng=rng)[1] for one in places]
    best = max(infos, key=lambda info: info.match)
    assert np.hypot(*(best.pose - film.truth[-1])[:2]) < 2
    assert best.match > 0.9 > 0.4 > sorted(info.match for info in infos)[-2]
    assert not best.lost


def test_a_vector_is_taken_across_its_point():
    for at in (0, 40, 119):
        state = page.vector(at)
        np.testing.assert_allclose(state.line.mean(axis=0), state.points[at])
        assert state.fall[0] == pytest.approx(1)


# What the text says of the rows


def test_contours_that_know_directions_hold_their_patterns():
    rows = page.followed.rows()
    edges, directed, vectors = (rows.mean("lost", by=name) for name in page.MEASURES)
    assert directed.high < edges.low
    assert abs(directed.estimate - vectors.estimate) < 0.02


def test_own_slopes_help_with_wide_sigmas_more_than_with_narrow_ones():
    rows = page.searched.rows()
    wide, narrow = (rows.ratio("error", page.SLOPES, sigma=sigma) for sigma in (2.0, 1.0))
    assert wide.estimate < narrow.estimate


def test_what_the_page_says_of_the_rivals():
    rows = page.displaced.rows()
    for name in ("template matching", "optical flow", "five pictures"):
        assert page.worst(rows, 3.0, name).high < page.worst(rows, 3.0).low
    assert page.worst(rows, 3.0, "5000 particles").estimate < page.worst(rows, 3.0).estimate
    assert page.worst(rows, 3.0, "ECC").estimate > 1
    worst = max(COORDINATES, key=lambda name: page.typical(rows, 2.0, name).estimate)
    assert worst == "θ"


def test_a_rule_that_forgives_the_threshold_is_no_worse_than_no_tolerance():
    rows = page.covered.rows()
    for share in page.SHARES:
        assert rows.ratio("error", ("bad", "at worst", "none"), share=share).low < 1
    beyond = ("bad", "left out beyond 3", "none")
    assert rows.ratio("error", beyond, share=0.0).estimate > 1


def test_in_films_the_tracker_hardly_feels_the_smoothing():
    rows = page.growing.rows()
    sharp = rows.mean("error", smoothing="none")
    for name in page.SMOOTHINGS:
        other = rows.mean("error", smoothing=name)
        assert other.low < sharp.high
        assert sharp.low < other.high
