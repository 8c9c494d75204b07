"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.book import people_fusion as page
from robot_perception.book.people_fusion import (
    MOMENTS,
    NOW,
    PAGE,
    RULED,
    SCENE,
    page_session,
    room,
    scene,
)
from robot_perception.chapters.people_fusion import figures as draw
from robot_perception.evaluation.intervals import Interval
from robot_perception.teaching.figures import figure
from tests.chapters.findings import limits
from tests.unchecked import unchecked


@pytest.fixture(autouse=True, scope="module")
def computed():
    """All states, computed once, without the checks of shapes."""
    with unchecked():
        page.all_chosen()
        SCENE.found()


@pytest.mark.parametrize("explorer", [SCENE, RULED], ids=["scene", "rules"])
def test_no_two_states_say_the_same(explorer):
    words = [explorer.described(**setting) for setting in explorer.parameters()]
    assert len(set(words)) == len(words)


# The scene


def errors(who, at=NOW):
    """Return how many are missed, are nobody's, and are placed."""
    now = page.watched(who, at)
    return int(now.missed.sum()), int(now.nobody.sum()), now.placed


def test_the_session_is_none_of_those_that_are_scored():
    scored = (*page.FRESH, *page.SKIRTED, *page.guided.replicates, *page.surveyed.replicates)
    assert PAGE.seed not in scored


def test_the_sonars_make_nobody_up():
    assert not any(errors("the sonars alone", at)[1] for at in MOMENTS)


def test_the_moment_of_the_hero_is_right_together_and_by_no_sensor_alone():
    assert errors("all three") == (0, 0, 3)
    alone = [errors(who) for who, sensors in page.SOME.items() if len(sensors) == 1]
    assert all(missed or known < 3 for missed, _, known in alone)
    counts = {"camera": 3, "laser": 2, "sonar": 1}
    assert {sensor: len(scene(NOW).found[sensor]) for sensor in counts} == counts


def test_presets_show_what_their_names_say():
    shown = {name: page.watched(**SCENE.default | v) for name, v in SCENE.presets.items()}
    assert shown["no camera"].missed.tolist() == [True, False, False]
    assert shown["no sonars"].missed.tolist() == [False, True, False]
    assert shown["no sonars"].nobody.any()
    assert errors("all three", shown["no sonars"].at)[:2] == (0, 0)
    worst = max(MOMENTS, key=lambda t: errors("all three", t)[0])
    assert shown["the worst moment"].at == worst


@pytest.mark.parametrize("who", page.SOME)
def test_a_state_counts_as_the_studies_do(who):
    run = page.committee(page_session(), sensors=page.SOME[who])
    every = list(run.persons())
    for at in MOMENTS:
        missed, nobody, _ = errors(who, at)
        times = run.told.judged_at[run.rows]
        row, persons, _ = every[int(np.searchsorted(times, at, side="right")) - 1]
        seen = page.judged(run.told, row, persons, page.EVERYWHERE)
        assert len(seen.who) == 3 - missed
        assert len(seen.counts) - len(seen.which) == nobody


def test_a_finding_that_is_not_so_is_found():
    every = SCENE.found()
    assert page.together_best(every)
    worse = [(who, at, missed + (who == "all three"), *rest) for who, at, missed, *rest in every]
    assert not page.together_best(worse)
    placed = [(*one[:3], 9 if one[0] == "the camera alone" else one[3], one[4]) for one in every]
    assert not page.together_best(placed)
    assert page.never_loses(RULED.found())
    assert not page.never_loses(RULED.found()[::-1])


# The rules


def test_the_last_people_cost_the_most_false_hypotheses():
    ours, most = page.ruled_by(**RULED.default).shares, max(page.all_chosen().values())
    assert most[0] - ours[0] < 0.03
    assert most[1] > 1.5 * ours[1]


# Drawings


def test_the_axes_hold_every_choice():
    left, right, low, high = limits(RULED.drawn())
    for tracked, false in page.all_chosen().values():
        assert left <= false <= right
        assert low <= tracked <= high


def test_the_committee_is_drawn_twice_alike():
    _, ax = figure()
    persons = page.together_at(NOW)
    counts = [len(draw.together.on(ax, scene(NOW), persons).get_children()) for _ in range(2)]
    assert counts[0] == counts[1]


def shares(*pairs):
    """Return shares tracked and false with their intervals."""
    return [tuple(Interval(v, max(v - 0.1, 0), min(v + 0.1, 1)) for v in pair) for pair in pairs]


def test_rooms_are_drawn_row_by_row_beside_the_papers_lines():
    _, ax = figure()
    draw.rooms.on(ax, dict(zip(("ours", "other"), shares((0.8, 0.4), (0.85, 0.3)), strict=True)))
    dots = [line.get_data() for line in ax.lines if line.get_marker() == "o"]
    np.testing.assert_allclose(np.ravel(dots), [0.4, 0, 0.8, 0, 0.3, 1, 0.85, 1])
    lines = [line.get_xdata() for line in ax.lines if line.get_linestyle() == ":"]
    np.testing.assert_allclose(lines, [[x, x] for x in draw.OF_THE_PAPER])


def test_every_person_has_a_way():
    run = page.committee(page_session())
    _, ax = figure()
    with unchecked():
        draw.ways.on(ax, run, room())
    ends = [line for line in ax.lines if line.get_marker() in ("s", "o")]
    squares = [line for line in ends if line.get_marker() == "s"]
    found = [(persons.identity, static) for _, persons, static in run.persons()]
    assert len(ends) == np.unique(np.concatenate([one for one, _ in found])).size
    assert len(squares) == np.unique(np.concatenate([one[static] for one, static in found])).size
