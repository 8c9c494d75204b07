"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np

from robot_perception.chapters.tutor_following import bets, views, visiting
from robot_perception.chapters.tutor_following import figures as draw
from robot_perception.chapters.tutor_following.explorers import dragged, tracked
from tests.chapters.findings import ExplorerTests
from tests.chapters.ledger import recorded


class TestExplorers(ExplorerTests):
    explorers = (tracked, dragged)


def test_a_model_that_learns_from_every_picture_is_lost_whatever_the_patches():
    for patches in views.PATCHES:
        assert not tracked.state(patches=patches, learning="slowly", time=89).held
        assert not tracked.state(patches=patches, learning="fast", time=89).held


def test_presets_show_what_the_page_says():
    named = {name: tracked.state(**{**tracked.default, **v}) for name, v in tracked.presets.items()}
    assert named["one, never"].held
    assert not named["four, slowly"].held
    assert named["four, gated"].held


def test_the_passer_stands_before_the_person_when_the_page_says_so():
    from robot_perception.chapters.tutor_following.walking import film

    shown = film(views.WALK, "long, whole")
    hidden = np.flatnonzero(shown.visible < 0.4)
    assert abs(hidden[0] - 28) <= 3
    assert abs(hidden[-1] - 53) <= 3


def test_all_stages_pass_at_the_hand_and_nowhere_else():
    best = views.raised().best
    for setting in dragged.parameters():
        state = dragged.state(**setting)
        far = max(abs(setting["x"] - best[0]), abs(setting["y"] - best[1]))
        assert state.passed < len(state.margins) or far <= views.raised().side / 3
    assert dragged.state(x=int(best[0]), y=int(best[1])).passed == 13
    half = dragged.presets["half a hand"]
    assert dragged.state(**{**dragged.default, **half}).passed <= 2


def test_margins_say_which_stage_rejects():
    for setting in dragged.parameters():
        state = dragged.state(**setting)
        below = np.flatnonzero(state.margins < 0)
        assert state.passed == (below[0] if len(below) else len(state.margins))


def test_the_visit_that_is_shown_goes_through():
    shown, orders = views.visited(), visiting.visit(views.VISIT).orders
    assert len(orders) == 9
    assert all(shown[o.last].state in visiting.SHOULD[o.what] for o in orders)
    assert {one.state for one in shown} == set(draw.PLACES)
    order = views.ordered()
    assert order.state == "idle"
    face = order.faces[order.held].box
    assert order.hands[0, 1] + order.hands[0, 3] / 2 < face[1]


def test_the_right_answers_of_the_bets_are_what_is_computed():
    assert bets.FIXED["right"] == "the one that keeps the colours"
    assert recorded()["drift-dilemma"].evidence["fixed less adapting, hidden"].low > 0
    assert bets.STARTS["right"] == "it follows for a moment and stops"
    stopped = [s for s in recorded()["interaction-states"].sabotages if "began" in s.text]
    assert stopped[0].verdict != "conditional"
    kind = visiting.Kind(brief=True, fresh=False)
    states = []
    for moment in visiting.moments(views.VISIT, kind):
        states.append(moment.state)
        if len(states) > 1 and states[-2] == "follow" and states[-1] != "follow":
            break
    assert states[-1] == "halt"
    assert states.count("follow") <= 5


def test_words_say_where_the_tracker_is():
    words = tracked.state(patches="one", learning="slowly", time=89).words()
    assert "off the person" in words
    assert "lost" in words
    best = views.raised().best
    assert "taken for an open hand" in dragged.state(x=int(best[0]), y=int(best[1])).words()
