"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

import numpy as np

from robot_perception.book import tutor_following as page
from robot_perception.chapters.tutor_following import figures as draw


def test_the_passer_stands_before_the_person_when_the_page_says_so():
    hidden = np.flatnonzero(page.walk(page.WALK, "stops").visible < 0.4)
    assert abs(hidden[0] - 28) <= 3
    assert abs(hidden[-1] - 53) <= 3


def test_margins_say_which_stage_rejects():
    for setting in list(page.dragged.parameters())[::8]:
        state = page.dragged.state(**setting)
        below = np.flatnonzero(state.margins < 0)
        assert state.passed == (below[0] if len(below) else len(state.margins))
    half = page.dragged.presets["half a hand"]
    assert page.dragged.state(**page.dragged.default | half).passed <= 2


def test_words_say_where_the_tracker_is():
    words = page.tracked.described(patches="four and a silhouette", learning="never", time=89)
    assert "on the person" in words
    assert "held" in words
    words = page.tracked.described(patches="one", learning="slowly", time=89)
    assert "nobody" in words
    assert "lost" in words
    assert "taken for an open hand" in page.dragged.described()


def test_the_visit_that_is_shown_goes_through():
    shown = page.shown_visit()
    orders = page.make_visit(np.random.default_rng(page.VISIT)).orders
    assert len(orders) == 9
    assert all(shown[o.last].state in page.SHOULD[o.what] for o in orders)
    assert {one.state for one in shown} == set(draw.PLACES)
    order = page.ordered()
    assert order.hands[0, 1] + order.hands[0, 3] / 2 < order.faces[order.held][1]
