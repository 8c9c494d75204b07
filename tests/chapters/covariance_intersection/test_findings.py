"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.covariance_intersection import explorers, rumour
from robot_perception.chapters.covariance_intersection import figures as draw
from robot_perception.teaching.explore import MOST_STATES
from robot_perception.teaching.figures import figure
from tests.chapters.findings import limits, presets_that_show_the_default, states

SETS = [
    (explorers.ELLIPSE_PRESETS, explorers.ELLIPSE_CONTROLS),
    (explorers.RUMOUR_PRESETS, explorers.RUMOUR_CONTROLS),
    (explorers.PAIR_PRESETS, explorers.PAIR_CONTROLS),
]


@pytest.mark.parametrize(("presets", "controls"), SETS)
def test_no_preset_shows_the_default_and_there_are_not_too_many_states(presets, controls):
    assert not presets_that_show_the_default(presets, controls)
    assert np.prod([len(c.values) for c in controls.values()]) <= MOST_STATES


@pytest.mark.parametrize(
    ("shown", "drawing", "controls"),
    [
        (explorers.fused, draw.two_opinions, explorers.ELLIPSE_CONTROLS),
        (explorers.heard, draw.rumours, explorers.RUMOUR_CONTROLS),
        (explorers.weighed, draw.areas, explorers.PAIR_CONTROLS),
    ],
)
def test_axes_stay_and_hold_what_is_drawn(shown, drawing, controls):
    _, ax = figure()
    seen = set()
    for state in states(controls):
        drawing(ax, shown(**state))
        seen.add(limits(ax))
        left, right, low, high = limits(ax)
        for line in ax.lines:
            x, y = (np.asarray(values, dtype=float) for values in line.get_data())
            assert np.nanmax(y) <= high, state
            assert np.nanmin(y) >= low, state
            assert np.nanmax(x) <= right + 1e-9, state
            assert np.nanmin(x) >= left - 1e-9, state
    assert len(seen) == 1


# Two Gaussians


def test_every_positive_correlation_breaks_the_kalman_ellipse_and_none_the_intersection():
    for state in states(explorers.ELLIPSE_CONTROLS):
        ratio = explorers.fused(**state).ratio
        if state["omega"] is None:
            assert (ratio > 1 + 1e-9) == (state["rho"] > 0), state
        else:
            assert ratio <= 1 + 1e-9, state


def test_the_intersection_passes_through_the_points_where_the_two_ellipses_cross():
    first, second = (np.linalg.inv(g.cov) for g in (explorers.FIRST, explorers.SECOND))
    turn = np.linspace(0, 2 * np.pi, 200_001)
    u = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    gap = np.einsum("ki,ij,kj->k", u, first - second, u)
    crossing = u[:-1][np.sign(gap[:-1]) != np.sign(gap[1:])]
    assert len(crossing) == 4
    omegas = explorers.ELLIPSE_CONTROLS["omega"].values
    for omega in (w for w in omegas if w is not None):
        stated = np.linalg.inv(explorers.fused(0.0, omega).stated)
        for point in crossing:
            assert point @ stated @ point == pytest.approx(point @ first @ point, rel=1e-3)


def test_words_say_on_which_side_the_true_ellipse_is():
    for state in states(explorers.ELLIPSE_CONTROLS):
        outside = explorers.fused(**state).ratio > 1 + 1e-9
        assert ("outside" in explorers.describe_ellipses(**state)) == outside


# The rumour


def test_the_intersection_is_never_overconfident_and_the_split_one_is_honest():
    for state in states(explorers.RUMOUR_CONTROLS):
        result = explorers.heard(**state)
        assert (result.ratio("intersection") <= 1 + 1e-9).all(), state
        np.testing.assert_allclose(result.ratio("split intersection"), 1, rtol=1e-9)
        assert (result.ratio("Kalman")[1:] > 1 + 1e-9).all() == (state["share"] > 0), state


def test_the_kalman_filter_is_overconfident_by_the_share_of_all_but_one_reading():
    for state in states(explorers.RUMOUR_CONTROLS):
        k = np.arange(1, rumour.Config().readings + 1)
        expected = 1 + state["share"] * (k - 1)
        np.testing.assert_allclose(explorers.heard(**state).ratio("Kalman"), expected, rtol=1e-9)


def test_true_deviations_are_those_of_the_runs():
    for state in states(explorers.RUMOUR_CONTROLS):
        result = explorers.heard(**state)
        for rule in rumour.RULES:
            measured = np.sqrt(np.mean(result.errors[rule] ** 2, axis=0))
            np.testing.assert_allclose(measured, result.true[rule], rtol=0.15)


def test_the_typical_run_of_the_hero_ends_outside_its_band():
    heard = explorers.heard(0.75)
    final, stated = heard.errors["Kalman"][:, -1], heard.stated["Kalman"][-1]
    one = explorers.typical(heard)
    assert abs(final[one]) == pytest.approx(heard.true["Kalman"][-1], rel=0.02)
    assert abs(final[one]) > 2 * stated


# Sonar and camera


def test_equation_4_is_never_below_the_best_and_for_some_cameras_above_the_sonar_alone():
    above = []
    for state in states(explorers.PAIR_CONTROLS):
        found = explorers.weighed(**state)
        printed, least = found.area(found.printed), found.area(found.least)
        assert least <= printed + 1e-12, state
        assert least <= found.areas.min() + 1e-12, state
        above.append(printed > 1 + 1e-6)
    assert any(above)
    assert not all(above)


def test_the_sharp_camera_has_the_sonars_area_and_the_other_presets_say_what_they_show():
    sharp = explorers.weighed(**{"depth": 2.0} | explorers.PAIR_PRESETS["a sharp camera"])
    assert sharp.printed == pytest.approx(0.5)
    assert sharp.least == pytest.approx(0.5)
    less = explorers.weighed(
        **{"depth": 2.0} | explorers.PAIR_PRESETS["a camera that knows no more"]
    )
    assert less.least == 0 < less.printed
