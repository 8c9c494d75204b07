"""Snakes on the snail: what a case is, what is measured, and the sign of the area's score."""

from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from robot_perception.appearance import shape_scores
from robot_perception.appearance.segmentation import boundary, filled
from robot_perception.chapters.colour_and_shape import area_sign, snakes
from robot_perception.chapters.colour_and_shape import figures as draw
from robot_perception.teaching.figures import figure

SMALL = snakes.Config(films=snakes.CHOOSING[2:], frames=(8, 24))


@cache
def found() -> snakes.Result:
    return snakes.compared(cases(), SMALL)


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
    (case,) = snakes.film_cases(snakes.CHOOSING[2], bare, rng=np.random.default_rng(0))
    assert case.neck.any()  # where it would be
    assert case.in_blob < 0.3
    assert len(snakes.compared([case], bare).films) == 1


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


def test_the_gap_is_the_mean_of_the_films_means():
    result = found()
    by_film = [
        (result.snakes["free"].overlap - result.snakes["affine"].overlap)[result.films == film]
        for film in SMALL.films
    ]
    gap = result.gap("overlap")
    assert gap.estimate == pytest.approx(np.mean([film.mean() for film in by_film]))
    assert gap.low < gap.estimate < gap.high


def test_the_table_of_reaches_has_the_results_of_each():
    table = snakes.reach_table(cases(), SMALL)
    rules = replace(SMALL.rules, rigidity=snakes.STIFF, reach=(20.0, 3.0))
    result = snakes.compared(cases(), replace(SMALL, rules=rules))
    row = dict(zip(table.columns, table.rows["β = 100, reach 20 px"], strict=True))
    assert row["neck, free"] == result.snakes["free"].swallowed.mean()
    assert row["half, affine"] == (result.snakes["affine"].swallowed > 0.5).sum()
    assert row["overlap, affine"] == result.snakes["affine"].overlap.mean()


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
    printed, turned = (area_sign.curve(ratios, s) for s in area_sign.SIGNS)
    assert printed.argmin() == turned.argmax() == 16
    assert turned.max() == 1


def test_the_printed_sign_prefers_a_segmentation_of_twice_the_area_in_every_case():
    affine, rho = area_sign.compared(cases())
    assert affine.min() > 0.9  # both are fitted: the area alone decides
    for sign, share in (("printed", 0), ("turned round", 1)):
        assert area_sign.right_first(rho[sign]).estimate == share


# Figures


def test_the_figure_of_signs_draws_the_curves():
    _, ax = figure()
    draw.signs.on(ax)
    for line, sign in zip(ax.lines, area_sign.SIGNS, strict=False):
        expected = area_sign.curve(line.get_xdata(), sign)
        np.testing.assert_allclose(line.get_ydata(), expected)


def test_the_segmented_picture_fades_what_is_outside_and_tints_the_neck():
    case = cases()[0]
    picture = draw.segmented(case)
    body = case.blob & ~case.neck
    np.testing.assert_array_equal(picture[body], case.image[body])
    assert np.ptp(picture[~case.blob].astype(int)) <= 51  # a fifth of the contrast
    assert (picture[case.blob & case.neck] != case.image[case.blob & case.neck]).any(axis=1).all()
