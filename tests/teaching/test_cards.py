"""Cards of the landing page: links with a figure that has alternative text."""

import pytest

from explorables.figures import figure
from robot_perception.teaching.pages.cards import Card, cards
from robot_perception.teaching.pages.contents import Contents
from studies.ledger import Ledger
from tests.teaching.test_contents import boxed, page

BOOK = Contents(
    [
        page("walls & scans", "How many walls are there?"),
        boxed("slam", "You need [walls](walls & scans.ipynb)."),
    ]
)
NO_CLAIMS = Ledger(())


def card(**changes):
    fields = {"question": "How many & why?", "figure": figure()[0]}
    return Card(**(fields | {"alt": "A line that stands for many readings."} | changes))


def test_card_is_a_link_with_its_question_escaped():
    shown = cards(BOOK, {"slam": card()}, NO_CLAIMS)
    html = shown.bundle["text/html"]
    assert html.count('<a class="rp-card"') == 2
    assert "How many &amp; why?" in html
    assert 'aria-label="A line that stands for many readings."' in html
    assert "1 · Part" in html


def test_a_chapter_without_a_card_of_its_own_asks_its_first_question():
    first, second = repr(cards(BOOK, {}, NO_CLAIMS)).splitlines()
    assert "How many walls are there?" in first
    assert second.startswith("1 · Slam")


def test_a_card_says_what_the_chapter_needs():
    book = Contents([page("walls"), boxed("slam", "You need [walls](walls.ipynb).")])
    first, second = repr(cards(book, {}, NO_CLAIMS)).splitlines()
    assert first.endswith("Needs no other chapter.")
    assert second.endswith("Needs 1.")


def test_a_card_of_no_chapter_is_refused():
    with pytest.raises(ValueError, match="no chapter 'maps'"):
        cards(BOOK, {"maps": card()}, NO_CLAIMS)


def test_card_without_alternative_text_is_refused():
    with pytest.raises(ValueError, match="alt must say"):
        cards(BOOK, {"slam": card(alt="figure.png")}, NO_CLAIMS)
