"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

import numpy as np
import pytest

from robot_perception.book import colour_and_shape as page
from tests.chapters.findings import limits
from tests.unchecked import unchecked


@pytest.fixture(scope="module", autouse=True)
def _tried_as_a_reader_would():
    with unchecked():
        page.grid()


# One iteration

ITERATED = [page.iterated(one["samples"], one["noise"]) for one in page.steps.parameters(step="e")]


def test_axes_of_the_iteration_hold_all_samples():
    left, right, *_ = limits(page.steps.drawn())
    for found in ITERATED:
        for places in (found.start, found.drifted, found.moved):
            assert left < places.min() <= places.max() < right


def test_samples_drift_spread_and_are_weighed_by_the_frame():
    for found in ITERATED:
        drifted = found.start[found.ancestors] + page.VELOCITY
        np.testing.assert_allclose(found.drifted, drifted)
        assert np.abs(found.moved - drifted).max() <= 5 * found.noise
        says = page.fit(found.moved)
        np.testing.assert_allclose(found.weights, says / says.sum(), rtol=1e-9)
        assert found.grid[found.likelihood.argmax()] == pytest.approx(0.5, abs=0.01)


def test_only_wide_noise_reaches_the_other_object():
    for found in ITERATED:
        near = found.weights[np.abs(found.moved - 0.72) < 0.08].sum()
        assert (near > 0.05) == (found.noise == 0.15 and found.samples > 5)


# How many samples, and how far


def test_five_samples_hold_the_circle_with_half_the_noise_only():
    held = [one.overlap[-1] >= page.LOST for one in page.many.found(samples=5)]
    assert held == [False, True, False, False]


def test_words_of_the_overlap_say_how_it_ends():
    for setting in page.many.parameters():
        (state,) = page.many.found(**setting)
        end = "held to the end." if state.overlap[-1] >= page.LOST else "lost at the end."
        assert page.many.described(**setting).endswith(end)


# Snakes


@pytest.mark.slow
def test_axes_hold_the_snake_and_the_affine_one_is_affine():
    left, right, low, high = limits(page.snake.drawn())
    for setting in list(page.snake.parameters())[::7]:
        state = page.snake_at(**setting)
        u, v = state.fit.outline.T
        assert left < u.min() < u.max() < right, setting
        assert high < v.min() < v.max() < low, setting
        assert state.snake == "free" or state.fit.residual < 1e-8


def test_a_loose_free_snake_with_a_long_reach_swallows_most_of_the_neck():
    start = page.snake.default
    named = {name: page.snake_at(**start | set_) for name, set_ in page.snake.presets.items()}
    assert named["free"].swallowed > 0.5 > 0.25 > named["free and stiff"].swallowed > 0.1
    assert named["too elastic"].overlap < page.snake_at(**start).overlap - 0.05
    for reach in (3.0, 8.0):
        stiff = page.snake_at("free", 0.05, 100.0, reach)
        assert stiff.swallowed < 0.02


def test_the_segmented_picture_fades_what_is_outside_and_tints_the_neck():
    case = page.shell()
    picture = page.draw.segmented(case)
    body = case.blob & ~case.neck
    np.testing.assert_array_equal(picture[body], case.image[body])
    assert np.ptp(picture[~case.blob].astype(int)) <= 51  # a fifth of the contrast
    assert (picture[case.blob & case.neck] != case.image[case.blob & case.neck]).any(axis=1).all()


# The films


@pytest.mark.slow
@pytest.mark.parametrize("world", page.WORLDS)
def test_in_the_films_shown_both_cues_hold_and_colour_alone_loses(world):
    film, tracks = page.filmed(world, page.SHOWN, page.LONG), page.shown_tracks()[world]
    found = {name: page.overlaps_of(film, track) for name, track in tracks.items()}
    assert found["fused"].min() > 0.75
    assert found["colours adapted"][-1] < page.LOST
    assert (found["edges alone"][-1] > 0.9) == (world == "circles")


def test_the_film_of_where_it_breaks_breaks():
    film = page.filmed("circles", page.CROSSED, page.LONG)
    found = page.overlaps_of(film, page.track("circles", "fused", page.CROSSED))
    assert found[:10].min() > 0.5
    assert found[-1] < page.LOST


# What the text says of the rows


def test_adapted_colours_lose_every_animal_and_both_cues_hold_them():
    rows = page.followed.rows()
    for world in ("beetle", "snail"):
        assert page.lost(rows, "colours adapted unchecked", (world,)).all()
        assert page.lost(rows, "both", (world,)).mean() < 0.1


def test_on_circles_and_snails_edges_alone_do_as_well():
    rows = page.followed.rows()
    for world in ("circles", "snail"):
        found = page.more_often(rows, "edges alone", "both", (world,))
        assert found.low <= 0 <= found.high


def test_camshift_loses_most_circles_some_snails_and_cards_and_no_beetle():
    rows = page.followed.rows()
    share = {world: page.lost(rows, "CamShift", (world,)).mean() for world in page.WORLDS}
    assert share["circles"] > 0.5 > 0.2 > share["snail"] > 0.1
    assert share["rectangle"] > 0 == share["beetle"]


def test_one_sample_is_worse_than_fifty_on_the_beetle():
    by_count = page.by_count()["beetle"]
    assert by_count[1].mean() < by_count[50].mean()
