"""What states of the explorers count, findings that can fail, and drawings."""

import numpy as np
import pytest

from explorables.figures import figure
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
from studies.intervals import Interval
from tests.book import states
from tests.chapters.findings import limits
from tests.unchecked import unchecked

# The scene


def errors(who, at):
    """Return how many are missed, and how many are nobody's."""
    now = page.watched(who, at)
    return int(now.missed.sum()), int(now.nobody.sum())


def test_the_session_is_none_of_those_that_are_scored():
    scored = (*page.FRESH, *page.SKIRTED, *page.guided.replicates, *page.surveyed.replicates)
    assert PAGE.seed not in scored


@pytest.mark.parametrize("who", ["all three", "the camera alone"])
def test_a_state_counts_as_the_studies_do(who):
    run = page.committee(page_session(), sensors=page.SOME[who])
    every = list(run.persons())
    for at in MOMENTS[::5]:
        missed, nobody = errors(who, at)
        times = run.told.judged_at[run.rows]
        row, persons, _ = every[int(np.searchsorted(times, at, side="right")) - 1]
        seen = page.judged(run.told, row, persons, page.EVERYWHERE)
        assert len(seen.who) == 3 - missed
        assert len(seen.counts) - len(seen.which) == nobody


def test_a_finding_that_is_not_so_is_found():
    every = states.findings("people_fusion", SCENE.name)
    assert page.together_best(every)
    worse = [(who, at, missed + (who == "all three"), *rest) for who, at, missed, *rest in every]
    assert not page.together_best(worse)
    placed = [(*one[:3], 9 if one[0] == "the camera alone" else one[3], one[4]) for one in every]
    assert not page.together_best(placed)
    people = states.findings("people_fusion", RULED.name)
    assert page.never_loses(people)
    assert not page.never_loses(people[::-1])


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
