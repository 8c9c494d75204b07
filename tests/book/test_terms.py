"""The words of the book: each is short, used, explained where it says, and called as it says."""

import re

import pytest

from robot_perception.teaching.scores.papers import PAPERS
from robot_perception.teaching.words.terms import PAGE, called, heading, readable, uses
from robot_perception.teaching.words.terms import read as read_terms
from tests.book.contents import CONTENTS

TERMS = read_terms()
MOST_WORDS = 40
SMALL = """
    a after all am an and another are at by can eight for four from has he him his how hundred i
    in is it its like many me must not of on one or our round that the they this three to two
    what where which who whose why with you accurate asks checked choose compares exchanged
    finds follow keeps known makes remembers seen sets stay taken across behind raised right
    unknown wrong
"""
PLAIN = """
    angles arms camera ceiling committee corridor dimension doors eye hand head microphones motion
    copies names opinions opponent paper parts people person price robot rule shape system walls
    ways witnesses world
    birchfield douglas peucker ramer
"""
NO_TERMS = frozenset(SMALL.split())
"""Words of titles that nobody looks up: small ones, numbers, and what somebody does."""
THINGS = frozenset(PLAIN.split())
"""Words of titles that mean what they mean everywhere, and names of people."""


def parts(text):
    return re.findall(r"[\w-]+", text.casefold())


def titled(page):
    subtitle = re.search(r"^# .+\n\n\*([^*]+)\*$", page.source[0], re.M)
    return [*parts(page.title), *parts(subtitle[1] if subtitle else "")]


KNOWN = {word for term in TERMS for form in (term.name, *term.forms) for word in parts(form)}


def test_there_are_as_many_as_a_book_needs():
    assert 80 <= len(TERMS) <= 140


def test_they_stand_in_the_order_of_the_alphabet_and_each_once():
    names = [term.name.casefold() for term in TERMS]
    assert names == sorted(names)
    assert len({term.id for term in TERMS}) == len(TERMS)


def test_no_form_belongs_to_two():
    forms = [form.casefold() for term in TERMS for form in term.marked]
    assert sorted(set(forms)) == sorted(forms)


@pytest.mark.parametrize("page", CONTENTS.chapters, ids=lambda page: page.stem)
def test_every_word_of_a_title_is_explained(page):
    left = [
        word
        for word in titled(page)
        if not {word, word.removesuffix("s")} & (KNOWN | NO_TERMS | THINGS)
    ]
    assert not left


def test_no_word_that_is_left_out_is_idle():
    assert not THINGS - {word for page in CONTENTS.chapters for word in titled(page)}


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.name)
def test_a_word(term):
    assert len(term.plain.split()) <= MOST_WORDS
    assert term.says.endswith(".")
    assert "$" not in term.says  # the note on a page sets no formulas
    assert term.papers.keys() <= PAPERS.keys()
    assert term.places
    for place in term.places:
        assert heading(CONTENTS, place)
    for name in term.library:
        assert called(name) is not None


def test_every_word_is_used():
    used = uses(TERMS, readable(CONTENTS))
    assert not [name for name, pages in used.items() if not pages]


def test_the_page_is_in_the_contents():
    assert PAGE in CONTENTS.pages
