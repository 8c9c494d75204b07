"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from data_synth.people import LASER_ANGLES, SONAR_ANGLES
from robot_perception.chapters.people_fusion import committee, explorers, scene, sessions
from robot_perception.chapters.people_fusion import figures as draw
from robot_perception.chapters.people_fusion.behaviours import SEEDS
from robot_perception.chapters.people_fusion.sessions import RIG
from robot_perception.evaluation.intervals import Interval
from robot_perception.people import legs, sonar
from robot_perception.people.scores import score
from robot_perception.teaching.explore import MOST_STATES
from robot_perception.teaching.figures import figure, image_axes
from robot_perception.teaching.tables import Table
from tests.chapters.findings import default, limits, presets_that_show_the_default, states
from tests.unchecked import unchecked

SETS = [
    (explorers.SCENE_PRESETS, explorers.SCENE_CONTROLS),
    (explorers.RATES_PRESETS, explorers.RATES_CONTROLS),
]


@pytest.fixture(autouse=True, scope="module")
def computed():
    """All states, computed once, without the checks of shapes."""
    with unchecked():
        scene.signals()
        explorers.all_chosen()
        for state in states(explorers.SCENE_CONTROLS):
            explorers.shown(**state)


@pytest.mark.parametrize(("presets", "controls"), SETS)
def test_no_preset_shows_the_default_and_there_are_not_too_many_states(presets, controls):
    assert not presets_that_show_the_default(presets, controls)
    assert np.prod([len(c.values) for c in controls.values()]) <= MOST_STATES


# The session of the page


def test_the_session_is_none_of_those_that_are_used_elsewhere():
    used = {*sessions.LEARN, *sessions.CHOOSE, *sessions.TEST, *SEEDS}
    assert scene.CONFIG.seed not in used


def test_everybody_is_there_and_in_view_at_all_moments_ahead_and_behind():
    known = scene.recording()
    assert known.present.all()
    assert known.clear.all()
    assert (known.polar[..., 0] < draw.REACH).all()
    assert not known.skirt.any()
    ahead = np.abs(known.polar[..., 1]) < np.pi / 2
    assert (ahead.any(axis=1) & ~ahead.all(axis=1)).mean() > 0.5


def test_signals_are_those_that_the_detectors_had():
    seen = scene.signals()
    for k, at in enumerate(scene.MOMENTS):
        ranges, echoes = (np.where(r > 0, r, np.inf) for r in (seen.scans[k], seen.echoes[k]))
        found = legs.detect(ranges, LASER_ANGLES)
        np.testing.assert_allclose(found.mean, scene.found(at, "laser").positions.mean)
        found = sonar.detect(echoes, SONAR_ANGLES, RIG.ring.radius)
        np.testing.assert_allclose(found.mean, scene.found(at, "sonar").positions.mean)
        times = scene.recording().times[seen.readings[k]]
        assert (times <= at).all()
        assert (times > at - 0.06).all()


def test_the_loop_of_the_page_is_that_of_the_studies():
    with unchecked():
        ours, theirs = scene.history().tracked(), committee.tracked(scene.CONFIG)
    np.testing.assert_array_equal(ours.rows, theirs.rows)
    for one, other in zip(ours.persons, theirs.persons, strict=True):
        np.testing.assert_array_equal(one.mean, other.mean)
    for one, other in zip(ours.static, theirs.static, strict=True):
        np.testing.assert_array_equal(one, other)


# The scene


def test_all_three_find_as_many_as_any_others_and_only_the_camera_makes_people_up():
    for state in states(explorers.SCENE_CONTROLS):
        found = explorers.shown(**state)
        together = explorers.shown("all three", state["at"])
        assert together.missed.sum() <= found.missed.sum(), state
        if "camera" not in explorers.WHO[state["who"]]:
            assert not found.nobody.any(), state


def test_the_moment_of_the_hero_is_right_together_and_by_no_sensor_alone():
    assert explorers.shown("all three", explorers.SHOWN).right
    for who, sensors in explorers.WHO.items():
        if len(sensors) == 1:
            assert not explorers.shown(who, explorers.SHOWN).right
    for sensor in ("laser", "sonar"):
        assert len(scene.found(explorers.SHOWN, sensor)) == (2 if sensor == "laser" else 1)
    assert len(scene.found(explorers.SHOWN, "camera")) == 3


def test_presets_show_what_their_names_say():
    found = {
        name: explorers.shown(**default(explorers.SCENE_CONTROLS) | dict(values))
        for name, values in explorers.SCENE_PRESETS.items()
    }
    assert found["no camera"].missed.tolist() == [True, False, False]
    assert found["no sonars"].missed.tolist() == [False, True, False]
    assert found["no sonars"].nobody.any()
    assert explorers.shown("all three", found["no sonars"].at).right
    worst = max(scene.MOMENTS, key=lambda t: explorers.shown("all three", t).missed.sum())
    assert found["the worst moment"].at == worst


@pytest.mark.parametrize("who", explorers.WHO)
def test_a_state_counts_as_the_studies_do(who):
    for at in scene.MOMENTS:
        state = explorers.shown(who, at)
        with unchecked():
            run = scene.history(sensors=explorers.WHO[who]).tracked()
        times = run.recording.times[run.recording.judged[run.rows]]
        last = int(np.searchsorted(times, at, side="right")) - 1
        total = score([list(committee.frames(run))[last]], committee.REACH)
        assert total.matched == len(state.missed) - state.missed.sum()
        assert total.hypotheses == state.persons.sum()
        assert total.hypotheses - total.matched == state.nobody.sum()


# The rules


def test_more_belief_or_a_higher_threshold_never_loses_people_and_none_reach_93():
    found = explorers.all_chosen()
    for name in explorers.RATES_CONTROLS:
        values = explorers.RATES_CONTROLS[name].values
        for state in states(explorers.RATES_CONTROLS):
            larger = [v for v in values if v > state[name]]
            if larger:
                now = found[tuple(state.values())].tracked
                assert found[tuple((state | {name: larger[0]}).values())].tracked >= now, state
    assert max(one.tracked for one in found.values()) < explorers.PAPER[1]


def test_the_last_people_cost_the_most_false_hypotheses():
    found = explorers.all_chosen()
    ours = found[tuple(default(explorers.RATES_CONTROLS).values())]
    most = max(found.values(), key=lambda one: (one.tracked, one.false))
    assert most.tracked - ours.tracked < 0.03
    assert most.false > 1.5 * ours.false


# Drawings


def test_axes_stay():
    _, ax = figure()
    ends = {limits(draw.committee_at(ax, explorers.shown(**s))) for s in _some_scenes()}
    assert len(ends) == 1
    ends = set()
    for one in list(explorers.all_chosen().values())[::5]:
        left, right, low, high = limits(draw.rules(ax, one))
        ends.add((left, right, low, high))
        assert left <= one.false <= right
        assert low <= one.tracked <= high
    assert len(ends) == 1


def _some_scenes():
    return list(states(explorers.SCENE_CONTROLS))[::17]


def test_bent_ellipses_lie_two_deviations_away():
    found = scene.found(explorers.SHOWN, "sonar").positions
    for rim, mean, cov in zip(draw.rims(found.mean, found.cov), found.mean, found.cov, strict=True):
        r, phi = np.hypot(*rim.T), np.arctan2(-rim[:, 0], rim[:, 1])
        off = np.stack([r, phi], axis=-1) - mean
        away = np.einsum("ki,ij,kj->k", off, np.linalg.inv(cov), off)
        np.testing.assert_allclose(away, draw.DEVIATIONS**2)


def test_each_drawing_is_drawn_twice_alike():
    fig, axes = figure(1, 3, **draw.HERO)
    once = draw.hero(axes, explorers.SHOWN)[2].get_children()
    fig.draw_without_rendering()  # plans keep their aspect
    assert sum(ax.get_position().width for ax in axes) > 0.75, "the row is empty"
    assert len(draw.hero(axes, explorers.SHOWN)[2].get_children()) == len(once)
    for drawing in (draw.scan, draw.ring, draw.card):
        _, ax = figure()
        counts = [len(drawing(ax, explorers.SHOWN).get_children()) for _ in range(2)]
        assert counts[0] == counts[1]
    _, ax = image_axes(scene.picture(explorers.SHOWN))
    assert len(draw.fisheye(ax, explorers.SHOWN).lines) == 3 + 3


def test_each_state_says_what_it_shows():
    words = [explorers.describe_scene(**s) for s in states(explorers.SCENE_CONTROLS)]
    words += [explorers.describe_rates(**s) for s in states(explorers.RATES_CONTROLS)]
    assert len(set(words)) == len(words)


def test_shares_are_drawn_where_they_are():
    shares = [Interval(v, v - 0.1, v + 0.1) for v in (0.9, 0.5)]
    evidence = dict(zip(("found, 1 to 1.5 m", "found, 1.5 to 2 m"), shares, strict=True))
    _, ax = figure()
    draw.rates_by_distance(ax, {"laser": evidence | {"detections in a reading": shares[0]}})
    bars, line = ax.lines[:2], ax.lines[2]
    np.testing.assert_allclose(line.get_xdata(), [1.22, 1.72])
    np.testing.assert_allclose(line.get_ydata(), [0.9, 0.5])
    np.testing.assert_allclose(bars[1].get_ydata(), [0.4, 0.6])


def test_sweeps_and_the_paper_are_drawn_where_they_are():
    names = [f"{v} {name}" for name in ("α", "t_v") for v in (0.5, 2)] + ["θ = 0.1", "θ = 0.4"]
    rows = {
        name: (Interval(0.5 + 0.05 * k, 0, 1), Interval(0.1 * k, 0, 1), None, None)
        for k, name in enumerate(names)
    }
    _, axes = figure(1, 3)
    draw.trade(axes, Table(rows, committee.COLUMNS, "made up", "system"))
    (theta, paper), (alpha, _), (patience, _) = (
        [np.array(line.get_data()).T for line in ax.lines] for ax in axes
    )
    np.testing.assert_allclose(alpha, [[0.0, 0.5], [0.1, 0.55]])
    np.testing.assert_allclose(patience, [[0.2, 0.6], [0.3, 0.65]])
    np.testing.assert_allclose(theta, [[0.4, 0.7], [0.5, 0.75]])
    np.testing.assert_allclose(paper, [explorers.PAPER])


def test_every_person_has_a_way():
    with unchecked():
        run = scene.history().tracked()
        _, ax = figure()
        draw.ways(ax, run)
    identities = {int(one) for persons in run.persons for one in persons.identity}
    ends = [line for line in ax.lines if line.get_marker() in ("s", "o")]
    assert len(ends) == len(identities)
    still = {
        int(one)
        for persons, static in zip(run.persons, run.static, strict=True)
        for one in persons.identity[static]
    }
    assert sum(line.get_marker() == "s" for line in ends) == len(still)
