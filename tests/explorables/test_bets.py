"""Bets: every answer has its reply, in HTML and in text; nothing is shown of it before."""

import re

import pytest

from explorables.bets import MOST_ANSWERS, bet

QUESTION = "A post is <seen> twice. How much of $P_0$ is left?"
REPLIES = {
    "all of it": "The start is <never> measured.",
    "$P_0 / 2$": "A half would need a second start.",
    "nothing": "No number of measurements does that.",
}
RIGHT = "all of it"


def html():
    return bet(QUESTION, REPLIES, RIGHT).bundle["text/html"]


def test_text_has_the_question_its_answers_and_then_the_replies():
    assert repr(bet(QUESTION, REPLIES, RIGHT)).splitlines() == [
        "A bet. A post is <seen> twice. How much of $P_0$ is left?",
        "  A  all of it",
        "  B  $P_0 / 2$",
        "  C  nothing",
        "Replies",
        "  A is right. The start is <never> measured.",
        "  B is wrong. A half would need a second start.",
        "  C is wrong. No number of measurements does that.",
    ]


def test_each_answer_is_a_radio_button_of_one_group_with_its_own_label():
    inputs = re.findall(r'<input type="radio" name="([^"]+)" id="([^"]+)"', html())
    assert len({group for group, _ in inputs}) == 1
    assert re.findall(r'<label for="([^"]+)"', html()) == [name for _, name in inputs]
    assert len({name for _, name in inputs}) == len(REPLIES)
    assert "checked" not in html().split("</style>")[-1]


def test_replies_stand_in_the_order_of_the_answers_and_say_right_or_wrong():
    told = re.findall(r'rp-reply--(\w+)"><strong>(.*?)</strong>', html())
    assert told == [("right", "A is right."), ("wrong", "B is wrong."), ("wrong", "C is wrong.")]


def test_two_bets_are_two_groups_and_the_same_bet_is_the_same_group():
    other = bet(QUESTION, {"all": "So.", "none": "No."}, "all").bundle["text/html"]
    assert re.search(r"bet-\w{12}", other)[0] != re.search(r"bet-\w{12}", html())[0]
    assert re.search(r"bet-\w{12}", html())[0] == re.search(r"bet-\w{12}", html())[0]


def test_text_is_escaped_and_mathematics_is_handed_to_mathjax():
    assert "<seen>" not in html()
    assert "<never>" not in html()
    assert r'How much of <span class="math">\(P_0\)</span> is left?' in html()
    assert r'</b> <span class="math">\(P_0 / 2\)</span></label>' in html()


def test_a_notebook_has_the_style_and_no_second_answer(monkeypatch):
    assert "<style>" in html()
    assert '<p class="rp-bet-answer' not in html()
    monkeypatch.setenv("EXPLORABLES_PAGE", "1")
    assert "<style>" not in html()
    answer = html().partition('<p class="rp-bet-answer')[2]
    assert "</b> all of it<br>The start is &lt;never&gt; measured.</p>" in answer
    assert "nothing" not in answer


def test_the_style_shows_as_many_replies_as_there_may_be_answers():
    shown = re.findall(r"nth-of-type\((\d)\):checked ~ \.rp-replies > :nth-child\((\d)\)", html())
    assert shown == [(str(n), str(n)) for n in range(1, MOST_ANSWERS + 1)]


@pytest.mark.parametrize(
    ("question", "replies", "right", "match"),
    [
        ("", REPLIES, RIGHT, "question must not be empty"),
        (QUESTION, {"a": " ", "b": "No."}, "a", r"replies\['a'\] must not be empty"),
        (QUESTION, {" ": "No.", "b": "No."}, "b", "an answer in replies"),
        (QUESTION, {"a": "Yes."}, "a", "2 to 6 answers, got 1"),
        (QUESTION, dict.fromkeys("abcdefg", "No."), "a", "2 to 6 answers, got 7"),
        (QUESTION, REPLIES, "half", "right must be one of 'all of it'"),
    ],
)
def test_what_is_no_bet_is_refused(question, replies, right, match):
    with pytest.raises(ValueError, match=match):
        bet(question, replies, right)


def test_six_answers_are_not_too_many():
    text = repr(bet(QUESTION, dict.fromkeys("abcdef", "No."), "f"))
    assert "  F is right. No." in text
