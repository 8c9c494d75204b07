"""Snakes on the snail: what a case is, what is measured, and the sign of the area's score."""

from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from robot_perception.appearance import shape_scores
from robot_perception.appearance.affine_snake import SnakeRules
from robot_perception.appearance.segmentation import boundary, filled
from robot_perception.chapters.colour_and_shape import area_sign, snakes
from robot_perception.chapters.colour_and_shape import snake_figures as draw
from robot_perception.teaching.figures import figure, image_axes

SMALL = snakes.Config(films=snakes.CHOOSING[2:], frames=(8, 24))


@cache
def found() -> snakes.Result:
    return snakes.run(SMALL, rng=np.random.default_rng(0))


@cache
def cases() -> list[snakes.Case]:
    return snakes.gathered(SMALL, rng=np.random.default_rng(0))


def test_films_that_are_scored_were_not_chosen_on():
    assert not set(snakes.Config().films) & set(snakes.CHOOSING)


def test_a_case_starts_from_the_frame_before_and_its_edges_are_those_of_the_blob():
    for case in cases():
        np.testing.assert_array_equal(case.edges, boundary(case.blob))
        start, truth = (filled(o, case.neck.shape) for o in (case.start, case.truth))
        assert (start & truth).sum() > 0.85 * (start | truth).sum()
        assert (case.blob & truth).sum() > 0.6 * truth.sum()


def test_most_of_the_neck_is_in_the_blob_and_none_without_a_neck():
    result = found()
    assert result.cases == 4
    assert len(result.films) + result.empty == 4
    assert min(case.in_blob for case in cases()) > SMALL.attached
    bare = replace(SMALL, films=snakes.CHOOSING[2:3], frames=(4,), neck=False)
    bald = snakes.run(bare, rng=np.random.default_rng(0))
    assert len(bald.films) == 1
    (case,) = snakes.film_cases(snakes.CHOOSING[2], bare, rng=np.random.default_rng(0))
    assert case.neck.any()  # where it would be
    assert case.in_blob < 0.3


def test_measures_are_those_of_known_outlines():
    case = cases()[0]
    whole = np.array([[-1.0, -1], [320, -1], [320, 240], [-1, 240]])
    shell = filled(case.truth, case.neck.shape).sum()
    for outline, swallowed, overlap in (
        (whole, 1.0, shell / case.neck.size),
        (case.truth, (filled(case.truth, case.neck.shape) & case.neck).sum(), 1.0),
    ):
        measures = snakes.measured([case], [outline])
        expected = swallowed / (1 if outline is whole else case.neck.sum())
        assert measures.swallowed[0] == pytest.approx(expected)
        assert measures.overlap[0] == pytest.approx(overlap)


def test_the_affine_snake_is_affine_and_the_free_one_swallows_more_of_these_necks():
    result = found()
    assert result.snakes["affine"].residual.max() < 1e-8
    assert result.snakes["free"].residual.min() > 0.5
    gap = result.snakes["free"].swallowed - result.snakes["affine"].swallowed
    assert gap.mean() > 0


def test_the_same_seed_gives_the_same_numbers():
    again = snakes.run(SMALL, rng=np.random.default_rng(0))
    np.testing.assert_array_equal(again.start.overlap, found().start.overlap)
    np.testing.assert_array_equal(again.snakes["free"].overlap, found().snakes["free"].overlap)


def test_the_gap_is_the_mean_of_the_films_means():
    result = found()
    by_film = [
        (result.snakes["free"].overlap - result.snakes["affine"].overlap)[result.films == film]
        for film in SMALL.films
    ]
    gap = result.gap("overlap")
    assert gap.estimate == pytest.approx(np.mean([film.mean() for film in by_film]))
    assert gap.low < gap.estimate < gap.high


def test_each_snake_is_scored_with_the_weights_that_are_best_for_it_elsewhere():
    rules = SnakeRules(reach=(8.0, 3.0), steps=10)
    got, best = snakes.tuned(cases()[:1], cases()[1:2], rules), snakes.grid(cases()[1:2], rules)
    for snake in snakes.SNAKES:
        alpha, beta = best.best(snake)
        own = replace(rules, elasticity=alpha, rigidity=beta)
        expected = snakes.fitted(cases()[:1], snake, own)
        np.testing.assert_array_equal(got[snake].overlap, expected.overlap)


def test_the_table_of_reaches_has_the_results_of_each():
    table = snakes.reach_table(cases(), SMALL)
    rules = replace(SMALL.rules, rigidity=snakes.STIFF, reach=(20.0, 3.0))
    result = snakes.compared(cases(), replace(SMALL, rules=rules))
    row = dict(zip(table.columns, table.rows["β = 100, reach 20 px"], strict=True))
    assert row["neck, free"] == result.snakes["free"].swallowed.mean()
    assert row["half, affine"] == (result.snakes["affine"].swallowed > 0.5).sum()
    assert row["overlap, affine"] == result.snakes["affine"].overlap.mean()


def test_a_grid_has_the_means_of_its_fits():
    got = snakes.grid(cases()[:2], SnakeRules(steps=5), (0.1, 0.5), (0.2, 3.0, 9.0))
    one = snakes.fitted(cases()[:2], "free", SnakeRules(0.5, 3.0, steps=5))
    assert got.overlap.shape == (2, 2, 3)
    assert got.overlap[1, 1, 1] == pytest.approx(one.overlap.mean())
    assert got.swallowed[1, 1, 1] == pytest.approx(one.swallowed.mean())
    i, j = (got.elasticities.index(got.best("free")[0]), got.rigidities.index(got.best("free")[1]))
    assert got.overlap[1, i, j] == got.overlap[1].max()


# The sign of the area's score


@pytest.mark.parametrize("ratio", [Fraction(1, 3), Fraction(1), Fraction(2), Fraction(7, 2)])
@pytest.mark.parametrize("sign", area_sign.SIGNS)
def test_exact_rho_is_that_of_the_scores(ratio, sign):
    exact = area_sign.exact_rho(ratio, Fraction(3, 2), printed=sign == "printed")
    score = area_sign.SIGNS[sign](1.0, float(ratio))
    assert float(exact) == pytest.approx(shape_scores.rho(1.0, score, 1.0, (1.0, 1.5, 1.0)))


def test_a_perfect_match_costs_the_whole_importance_as_printed_and_nothing_turned_round():
    mu = Fraction(5, 4)
    assert area_sign.exact_rho(Fraction(1), mu, printed=True) == mu
    assert area_sign.exact_rho(Fraction(1), mu, printed=False) == 0
    assert area_sign.exact_rho(Fraction(2), mu, printed=True) == mu / 2


def test_the_printed_sign_gives_the_least_weight_to_the_right_area():
    ratios = np.geomspace(0.25, 4, 33)
    printed, turned = (area_sign.curve(ratios, area_sign.Config(), s) for s in area_sign.SIGNS)
    assert printed.argmin() == turned.argmax() == 16
    assert turned.max() == 1


def test_the_printed_sign_prefers_a_segmentation_of_twice_the_area_in_every_case():
    result = area_sign.run(area_sign.Config(), cases())
    assert result.affine.min() > 0.9  # both are fitted: the area alone decides
    assert result.right_first("printed") == 0
    assert result.right_first("turned round") == len(cases())
    for sign, better in (("printed", 1), ("turned round", 0)):
        assert (result.weights[sign].argmax(axis=1) == better).all()


# Figures


def test_figures_draw_what_they_are_given():
    case, result = cases()[0], found()
    _, ax = image_axes(draw.segmented(case))
    draw.beginning(ax, case)
    np.testing.assert_array_equal(ax.lines[-1].get_xydata()[:-1], case.start)
    assert ax.lines[0].get_xydata().shape[0] == case.edges.sum()
    _, ax = figure()
    draw.swallowed(ax, result)
    for line, snake in zip(ax.lines, snakes.SNAKES, strict=True):
        ordered = np.sort(result.snakes[snake].swallowed)
        np.testing.assert_array_equal(line.get_xdata()[1:-1], ordered)
    _, ax = figure()
    got = snakes.grid([case], SnakeRules(steps=3), (0.1,), (0.2, 3.0))
    draw.stiffness(ax, got)
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), got.overlap[1, 0])
    _, ax = figure()
    draw.signs(ax, area_sign.Config())
    for line, sign in zip(ax.lines, area_sign.SIGNS, strict=False):
        expected = area_sign.curve(line.get_xdata(), area_sign.Config(), sign)
        np.testing.assert_allclose(line.get_ydata(), expected)


def test_the_segmented_picture_fades_what_is_outside_and_tints_the_neck():
    case = cases()[0]
    picture = draw.segmented(case)
    body = case.blob & ~case.neck
    np.testing.assert_array_equal(picture[body], case.image[body])
    assert np.ptp(picture[~case.blob].astype(int)) <= 51  # a fifth of the contrast
    assert (picture[case.blob & case.neck] != case.image[case.blob & case.neck]).any(axis=1).all()
