"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.covariance_intersection import bets, consistency, rumour
from robot_perception.chapters.covariance_intersection.explorers import (
    heard,
    intersect,
    listen,
    weigh,
)
from robot_perception.teaching.explore import MOST_STATES
from tests.chapters.findings import limits, presets_that_show_the_default
from tests.chapters.ledger import recorded

HONEST = 1 + 1e-9
EXPLORERS = pytest.mark.parametrize("shown", [intersect, listen, weigh], ids=lambda e: e.name)


@EXPLORERS
def test_no_preset_shows_the_default_and_there_are_not_too_many_states(shown):
    assert not presets_that_show_the_default(shown)
    assert len(list(shown.parameters())) <= MOST_STATES


@EXPLORERS
def test_axes_stay_and_hold_what_is_drawn(shown):
    seen = set()
    for state in shown.parameters():
        axes = np.ravel(shown.drawn(**state))
        seen.add(tuple(limits(ax) for ax in axes))
        for ax, line in ((one, line) for one in axes for line in one.lines):
            left, right, low, high = limits(ax)
            x, y = (np.asarray(values, dtype=float) for values in line.get_data())
            assert np.nanmax(y) <= high, state
            assert np.nanmin(y) >= low, state
            assert np.nanmax(x) <= right + 1e-9, state
            assert np.nanmin(x) >= left - 1e-9, state
    assert len(seen) == 1


def test_the_right_answers_of_the_bets_are_what_is_computed():
    assert bets.TENTH["right"] == "about 3 times"
    assert heard(0.1).ratio("Kalman")[-1] == pytest.approx(3, abs=0.2)
    assert bets.TWICE["right"] == "twice"
    assert recorded()["kalman-overconfident"].evidence["largest"].estimate == pytest.approx(2)
    assert bets.LEAST["right"] == "hardly ever"
    assert recorded()["ci-omega-least"].value.low > 0.99


# Two Gaussians


def test_every_positive_correlation_breaks_the_kalman_ellipse_and_none_the_intersection():
    for rho in intersect.controls["rho"].values:
        kalman, *intersections = intersect.found(rho=rho)
        assert (kalman > HONEST) == (rho > 0), rho
        assert max(intersections) <= HONEST, rho


def test_the_intersection_passes_through_the_points_where_the_two_ellipses_cross():
    first, second = (np.linalg.inv(belief.cov) for belief in consistency.OPINIONS)
    turn = np.linspace(0, 2 * np.pi, 200_001)
    u = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    gap = np.einsum("ki,ij,kj->k", u, first - second, u)
    crossing = u[:-1][np.sign(gap[:-1]) != np.sign(gap[1:])]
    assert len(crossing) == 4
    for omega in intersect.controls["omega"].values[1:]:
        stated = np.linalg.inv(consistency.fused(0.0, omega).stated)
        for point in crossing:
            assert point @ stated @ point == pytest.approx(point @ first @ point, rel=1e-3)


def test_words_say_on_which_side_the_true_ellipse_is():
    for state, ratio in zip(intersect.parameters(), intersect.found(), strict=True):
        assert ("outside" in intersect.described(**state)) == (ratio > HONEST)


# The rumour


def test_the_intersection_is_never_overconfident_and_the_split_one_is_honest():
    for share in listen.controls["share"].values:
        (ratio,) = listen.found(share=share)
        assert (ratio["intersection"] <= HONEST).all(), share
        np.testing.assert_allclose(ratio["split intersection"], 1, rtol=1e-9)
        assert (ratio["Kalman"][1:] > HONEST).all() == (share > 0), share


def test_the_kalman_filter_is_overconfident_by_the_share_of_all_but_one_reading():
    for share in listen.controls["share"].values:
        expected = 1 + share * np.arange(rumour.Config().readings)
        np.testing.assert_allclose(heard(share).ratio("Kalman"), expected, rtol=1e-9)


def test_true_deviations_are_those_of_the_runs():
    for share in listen.controls["share"].values:
        result = heard(share)
        for rule in rumour.RULES:
            measured = np.sqrt(np.mean(result.errors[rule] ** 2, axis=0))
            np.testing.assert_allclose(measured, result.true[rule], rtol=0.15)


def test_the_typical_run_of_the_hero_ends_outside_its_band():
    shown = heard(0.75)
    off = abs(shown.errors["Kalman"][shown.typical, -1])
    assert off == pytest.approx(shown.true["Kalman"][-1], rel=0.02)
    assert off > 2 * shown.stated["Kalman"][-1]


def test_with_everything_repeated_the_intersection_is_honest_too():
    assert listen.default == {"share": 1}
    np.testing.assert_allclose(listen.found(share=1.0)[0]["intersection"], 1, rtol=1e-9)


# Sonar and camera


def test_equation_4_is_never_below_the_best_and_for_some_cameras_above_the_sonar_alone():
    above = []
    for printed, least, smallest in weigh.found():
        assert least <= min(printed, smallest) + 1e-12
        above.append(printed > 1 + 1e-6)
    assert any(above)
    assert not all(above)


def test_the_sharp_camera_has_the_sonars_area_and_the_other_presets_say_what_they_show():
    sharp, less, deep = (weigh.state(**weigh.default | p) for p in weigh.presets.values())
    assert (sharp.printed, sharp.least) == pytest.approx((0.5, 0.5))
    assert less.least == 0 < less.printed
    assert deep.least == 1 > deep.printed
