"""Cards of the landing page: links with a figure that has alternative text."""

import pytest

from robot_perception.teaching.cards import Card, cards
from robot_perception.teaching.figures import figure


def card(**changes):
    fields = {"page": "walls.html", "title": "Walls & scans", "question": "How many?"}
    fields |= {"figure": figure()[0], "alt": "A line that stands for many readings."}
    return Card(**(fields | changes))


def test_card_is_a_link_with_its_question_escaped():
    shown = cards(card(), card(page="monobot.html"))
    html = shown.bundle["text/html"]
    assert html.count('<a class="rp-card"') == 2
    assert "Walls &amp; scans" in html
    assert 'aria-label="A line that stands for many readings."' in html
    assert repr(shown).splitlines()[0] == "Walls & scans: How many? (walls.html)"


def test_card_without_alternative_text_is_refused():
    with pytest.raises(ValueError, match="alt must say"):
        cards(card(alt="figure.png"))
