"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.people_fusion import committee, rates, scene
from robot_perception.chapters.people_fusion import figures as draw
from robot_perception.chapters.people_fusion.behaviours import SEEDS
from robot_perception.chapters.people_fusion.explorers import RULES, SCENE
from robot_perception.chapters.people_sensors.scene import CONFIG, MOMENTS, SHOWN, found
from robot_perception.evaluation.intervals import Interval
from robot_perception.people.scores import score
from robot_perception.teaching.figures import figure
from robot_perception.teaching.tables import Table
from tests.chapters.findings import ExplorerTests, limits
from tests.unchecked import unchecked


@pytest.fixture(autouse=True, scope="module")
def computed():
    """All states, computed once, without the checks of shapes."""
    with unchecked():
        scene.all_chosen()
        SCENE.found()


class TestExplorers(ExplorerTests):
    explorers = (SCENE, RULES)


@pytest.mark.parametrize("explorer", [SCENE, RULES])
def test_no_two_states_say_the_same(explorer):
    words = [explorer.described(**setting) for setting in explorer.parameters()]
    assert len(set(words)) == len(words)


# The scene


def test_the_session_is_none_of_the_stories():
    assert CONFIG.seed not in SEEDS


def test_all_three_find_and_place_as_many_as_any_others_and_the_camera_alone_places_nobody():
    for setting in SCENE.parameters():
        ((missed, _, known),) = SCENE.found(**setting)
        ((together, _, placed),) = SCENE.found(**setting | {"who": "all three"})
        assert together <= missed, setting
        assert placed >= known, setting
        assert known == 0 or setting["who"] != "the camera alone", setting


def test_the_laser_alone_the_camera_alone_and_all_three_make_somebody_up():
    made_up = {who: any(scene.watched(who, at).nobody.any() for at in MOMENTS) for who in scene.WHO}
    assert made_up["the laser alone"]
    assert made_up["the camera alone"]
    assert made_up["all three"]
    assert not made_up["the sonars alone"]


def test_the_moment_of_the_hero_is_right_together_and_by_no_sensor_alone():
    errors = {who: SCENE.found(who=who, at=SHOWN)[0] for who in scene.WHO}
    assert errors["all three"] == (0, 0, 3)
    alone = [errors[who] for who, sensors in scene.WHO.items() if len(sensors) == 1]
    assert all(missed or known < 3 for missed, _, known in alone)
    counts = {"camera": 3, "laser": 2, "sonar": 1}
    assert {sensor: len(found(SHOWN, sensor)) for sensor in counts} == counts


def test_presets_show_what_their_names_say():
    found = {
        name: scene.watched(**SCENE.default | values) for name, values in SCENE.presets.items()
    }
    assert found["no camera"].missed.tolist() == [True, False, False]
    assert found["no sonars"].missed.tolist() == [False, True, False]
    assert found["no sonars"].nobody.any()
    assert scene.watched("all three", found["no sonars"].at).errors == (0, 0)
    worst = max(MOMENTS, key=lambda t: scene.watched("all three", t).errors[0])
    assert found["the worst moment"].at == worst


@pytest.mark.parametrize("who", scene.WHO)
def test_a_state_counts_as_the_studies_do(who):
    for at in MOMENTS:
        state = scene.watched(who, at)
        run = scene.history(sensors=scene.WHO[who])
        times = run.recording.judged_at[run.rows]
        last = int(np.searchsorted(times, at, side="right")) - 1
        total = score([list(committee.frames(run))[last]], committee.REACH)
        assert total.matched == len(state.missed) - state.missed.sum()
        assert total.hypotheses == state.persons.sum()
        assert total.hypotheses - total.matched == state.nobody.sum()


# The rules


def test_more_belief_or_a_higher_threshold_never_loses_people_and_none_reach_93():
    tracked = np.reshape(RULES.found(), (len(rates.THRESHOLDS), len(rates.FACTORS)))
    assert (np.diff(tracked, axis=0) >= 0).all()
    assert (np.diff(tracked, axis=1) >= 0).all()
    assert tracked.max() < rates.OF_THE_PAPER[1]


def test_the_last_people_cost_the_most_false_hypotheses():
    ours = scene.chosen(**RULES.default)
    most = max(scene.all_chosen().values(), key=lambda one: (one.tracked, one.false))
    assert most.tracked - ours.tracked < 0.03
    assert most.false > 1.5 * ours.false


# Drawings


def test_the_axes_hold_every_choice():
    left, right, low, high = limits(RULES.drawn())
    for one in scene.all_chosen().values():
        assert left <= one.false <= right
        assert low <= one.tracked <= high


def test_the_committee_is_drawn_twice_alike():
    _, ax = figure()
    counts = [len(draw.together.on(ax, SHOWN).get_children()) for _ in range(2)]
    assert counts[0] == counts[1]


def test_rooms_are_drawn_row_by_row_beside_the_papers_lines():
    shares = {name: (0.8 + 0.05 * k, 0.4 - 0.1 * k) for k, name in enumerate(("ours", "other"))}
    rows = {
        name: (*(Interval(v, v - 0.1, v + 0.1) for v in both), None, None)
        for name, both in shares.items()
    }
    _, ax = figure()
    draw.rooms.on(ax, Table(rows, committee.COLUMNS, "made up", "system"))
    dots = [line.get_data() for line in ax.lines if line.get_marker() == "o"]
    np.testing.assert_allclose(np.ravel(dots), [0.4, 0, 0.8, 0, 0.3, 1, 0.85, 1])
    lines = [line.get_xdata() for line in ax.lines if line.get_linestyle() == ":"]
    np.testing.assert_allclose(lines, [[x, x] for x in rates.OF_THE_PAPER])


def test_sweeps_and_the_paper_are_drawn_where_they_are():
    names = [f"{v} {name}" for name in ("α", "t_v") for v in (0.5, 2)] + ["θ = 0.1", "θ = 0.4"]
    rows = {
        name: (Interval(0.5 + 0.05 * k, 0, 1), Interval(0.1 * k, 0, 1), None, None)
        for k, name in enumerate(names)
    }
    _, axes = figure(1, 3)
    draw.trade.on(axes, Table(rows, committee.COLUMNS, "made up", "system"))
    (theta, paper), (alpha, _), (patience, _) = (
        [np.array(line.get_data()).T for line in ax.lines] for ax in axes
    )
    np.testing.assert_allclose(alpha, [[0.0, 0.5], [0.1, 0.55]])
    np.testing.assert_allclose(patience, [[0.2, 0.6], [0.3, 0.65]])
    np.testing.assert_allclose(theta, [[0.4, 0.7], [0.5, 0.75]])
    np.testing.assert_allclose(paper, [rates.OF_THE_PAPER])


def test_every_person_has_a_way():
    run = scene.history()
    _, ax = figure()
    with unchecked():
        draw.ways.on(ax, run)
    ends = [line for line in ax.lines if line.get_marker() in ("s", "o")]
    squares = [line for line in ends if line.get_marker() == "s"]
    found = [(persons.identity, static) for _, persons, static in run.persons]
    assert len(ends) == np.unique(np.concatenate([one for one, _ in found])).size
    assert len(squares) == np.unique(np.concatenate([one[static] for one, static in found])).size
