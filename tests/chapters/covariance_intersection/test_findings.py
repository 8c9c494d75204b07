"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

import numpy as np
import pytest

from robot_perception.book import covariance_intersection as ci

HONEST = 1 + ci.ROUNDING
SHARES = pytest.mark.parametrize("share", ci.listen.controls["share"].values)


# Two Gaussians


def test_the_intersection_passes_through_the_points_where_the_two_ellipses_cross():
    first, second = (np.linalg.inv(belief.cov) for belief in ci.OPINIONS)
    turn = np.linspace(0, 2 * np.pi, 200_001)
    u = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    gap = np.einsum("ki,ij,kj->k", u, first - second, u)
    crossing = u[:-1][np.sign(gap[:-1]) != np.sign(gap[1:])]
    assert len(crossing) == 4
    for omega in ci.intersect.controls["omega"].values[1:]:
        stated = np.linalg.inv(ci.fused(0.0, omega).stated)
        for point in crossing:
            assert point @ stated @ point == pytest.approx(point @ first @ point, rel=1e-3)


def test_words_say_on_which_side_the_true_ellipse_is():
    for state in ci.intersect.parameters():
        outside = ci.fused(**state).ratio > HONEST
        assert ("outside" in ci.intersect.described(**state)) == outside


# The rumour


@SHARES
def test_the_kalman_filter_is_overconfident_by_the_share_of_all_but_one_reading(share):
    expected = 1 + share * np.arange(ci.READINGS)
    np.testing.assert_allclose(ci.heard(share).ratio["Kalman"], expected, rtol=1e-9)


@SHARES
def test_the_rule_that_is_told_the_share_is_honest(share):
    np.testing.assert_allclose(ci.heard(share).ratio["split intersection"], 1, rtol=1e-9)


@SHARES
def test_true_deviations_are_those_of_the_runs(share):
    found = ci.heard(share)
    for rule, errors in found.errors.items():
        measured = np.sqrt(np.mean(errors**2, axis=0))
        np.testing.assert_allclose(measured, found.true[rule], rtol=0.15)


def test_the_typical_run_of_the_hero_ends_outside_its_band():
    shown = ci.heard(0.75)
    off = abs(shown.errors["Kalman"][shown.typical, -1])
    assert off == pytest.approx(shown.true["Kalman"][-1], rel=0.02)
    assert off > 2 * shown.stated["Kalman"][-1]


def test_with_everything_repeated_the_intersection_is_honest_too():
    assert ci.listen.default == {"share": 1}
    np.testing.assert_allclose(ci.heard(1.0).ratio["intersection"], 1, rtol=1e-9)


# Sonar and camera


def test_area_of_the_fused_ellipse_is_over_that_of_the_sonars():
    found = ci.weighed(ci.BEARING, 2.0)
    assert found.areas[0] == pytest.approx(1)
    camera, sonar = (np.sqrt(np.linalg.det(one.cov)) for one in (found.camera, found.sonar))
    assert found.areas[-1] == pytest.approx(camera / sonar)


def test_the_sharp_camera_has_the_sonars_area_and_the_other_presets_say_what_they_show():
    weigh = ci.weigh
    sharp, less, deep = (weigh.state(**weigh.default | p) for p in weigh.presets.values())
    assert (sharp.printed, sharp.least) == pytest.approx((0.5, 0.5))
    assert less.least == 0 < less.printed
    assert deep.least == 1 > deep.printed
