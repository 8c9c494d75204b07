"""What the chapter tells a reader to find, in every state of its explorer."""

import numpy as np
import pytest

from data_synth.people import LASER_ANGLES, SONAR_ANGLES
from data_synth.people.staging import RIG, SENSORS
from explorables.figures import figure, image_axes
from robot_perception.book import people_sensors as page
from robot_perception.book.people_sensors import LOOK, NOW, STAND, scene
from robot_perception.chapters.people_sensors import figures as draw
from robot_perception.people import legs, sonar
from robot_perception.people.places import points
from studies.intervals import Interval
from tests.unchecked import unchecked


@pytest.fixture(autouse=True, scope="module")
def computed():
    """All states, computed once, without the checks of shapes."""
    with unchecked():
        page.signals()
        LOOK.found()
        STAND.found()


# Somebody who stands somewhere


def test_the_person_stands_free_in_a_room_that_nothing_else_uses():
    office, _, robot = page.prepared()
    polar = [[r, np.deg2rad(phi)] for r in page.DISTANCES for phi in page.DIRECTIONS]
    assert (office.free(robot[:2] + points(np.array(polar))) > 0.2).all()
    used = {*page.LEARN, *page.CHOOSE, *page.TEST, *page.WALLED}
    assert page.OFFICE not in used


@pytest.mark.parametrize("how", page.HOW)
def test_the_laser_sees_nobody_behind_and_nobody_who_is_sideways(how):
    assert page.found_by("laser", how, ahead=False) == (0, 12)
    seen, places = page.found_by("laser", how, ahead=True)
    assert places == 15
    assert seen <= 1 if how in ("sideways", "in a long skirt") else seen >= 13


def test_the_camera_needs_a_face():
    assert page.found_by("camera", "facing the robot") == (27, 27)
    assert page.found_by("camera", "turned away") == (0, 27)


def test_sonars_hear_some_and_not_all_however_they_stand():
    for how in page.HOW:
        heard, places = page.found_by("sonar", how)
        assert places // 3 < heard < places
    assert page.found_by("sonar", "sideways") < page.found_by("sonar", "turned away")


def test_the_grip_is_on_the_person():
    for setting in STAND.parameters():
        now = STAND.state(**setting)
        np.testing.assert_allclose(
            page.place(**setting), draw.from_above(points(now.polar))[0], atol=1e-12
        )


# The session of the page


def test_the_session_is_none_of_those_that_are_used_elsewhere():
    used = {*page.LEARN, *page.CHOOSE, *page.TEST, *page.WALLED}
    assert page.PAGE.seed not in used


def test_everybody_is_there_and_in_view_at_all_moments_ahead_and_behind():
    known = page.page_session()
    assert known.present.all()
    assert known.clear.all()
    assert (known.polar[..., 0] < draw.REACH).all()
    assert not known.skirt.any()
    ahead = np.abs(known.polar[..., 1]) < np.pi / 2
    assert (ahead.any(axis=1) & ~ahead.all(axis=1)).mean() > 0.5


def test_signals_are_those_that_the_detectors_had():
    for k, at in enumerate(page.MOMENTS):
        now = scene(at)
        ranges, echoes = (np.where(r > 0, r, np.inf) for r in (now.scan, now.echoes))
        found = legs.detect(ranges, LASER_ANGLES)
        np.testing.assert_allclose(found.mean, now.found["laser"].positions.mean)
        found = sonar.detect(echoes, SONAR_ANGLES, RIG.ring.radius)
        np.testing.assert_allclose(found.mean, now.found["sonar"].positions.mean)
        times = page.page_session().times[page.signals()["readings"][k]]
        assert (times <= at).all()
        assert (times > at - 0.06).all()


# The explorer


def test_presets_show_what_their_names_say():
    found = [LOOK.found(**LOOK.default | values)[0] for values in LOOK.presets.values()]
    assert found == [(1, 0), (3, 0), (2, 2)]


def test_a_person_has_a_detection_of_their_own_and_the_rest_is_nobodys():
    for sensor in SENSORS:
        for at in page.MOMENTS:
            look = page.look(sensor, at)
            assert look.found.sum() + look.nobody.sum() == len(look.detections)


# Drawings


def test_bent_ellipses_lie_two_deviations_away():
    found = scene(NOW).found["sonar"].positions
    for rim, mean, cov in zip(draw.rims(found.mean, found.cov), found.mean, found.cov, strict=True):
        r, phi = np.hypot(*rim.T), np.arctan2(-rim[:, 0], rim[:, 1])
        off = np.stack([r, phi], axis=-1) - mean
        away = np.einsum("ki,ij,kj->k", off, np.linalg.inv(cov), off)
        np.testing.assert_allclose(away, draw.DEVIATIONS**2)


def test_each_drawing_is_drawn_twice_alike():
    fig, axes = draw.hero._axes()
    now = scene(NOW)
    once = draw.hero.on(axes, now)[2].get_children()
    fig.draw_without_rendering()  # plans keep their aspect
    assert sum(ax.get_position().width for ax in axes) > 0.75, "the row is empty"
    assert len(draw.hero.on(axes, now)[2].get_children()) == len(once)
    for drawing in (lambda ax, now: draw.scan.on(ax, now, 0.4), draw.ring.on, draw.overlay):
        _, ax = figure()
        counts = [len(drawing(ax, now).get_children()) for _ in range(2)]
        assert counts[0] == counts[1]
    _, ax = image_axes(now.picture)
    assert len(draw.fisheye.on(ax, now).lines) == 3 + 3


def test_shares_are_drawn_where_they_are():
    shares = {end: Interval(v, v - 0.1, v + 0.1) for end, v in ((1.5, 0.9), (2.0, 0.5))}
    _, ax = figure()
    draw.rates_by_distance.on(ax, {"sonar": shares})
    bars, line = ax.lines[:2], ax.lines[2]
    np.testing.assert_allclose(line.get_xdata(), [1.28, 1.78])
    np.testing.assert_allclose(line.get_ydata(), [0.9, 0.5])
    np.testing.assert_allclose(bars[1].get_ydata(), [0.4, 0.6])
