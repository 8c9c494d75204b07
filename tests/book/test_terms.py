"""The words of the book: each is short, used, explained where it says, and called as it says.

What a word means is told on pointing at it, so it must have that meaning where it is marked. A
word of plain English says on which pages it has it. ``meanings.tsv`` holds sentences, of the book
and planted ones, in which each such word is meant, and others, in which it is another word.
"""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from robot_perception.teaching.scores.papers import PAPERS
from robot_perception.teaching.words.terms import PAGE, Finder, called, heading, readable, uses
from robot_perception.teaching.words.terms import read as read_terms
from tests.book.contents import CONTENTS

TERMS = read_terms()
MOST_WORDS = 40
MEANINGS = [
    line.split("\t")
    for line in Path(__file__).with_name("meanings.tsv").read_text("utf-8").splitlines()
]
"""Word, page, whether it is meant there, sentence."""
TECHNICAL = """
    absolute trajectory error; anchor; auxiliary particle filter; bearing; Bhattacharyya distance;
    boosting; CamShift; cascade; class of descriptors; clutter; colour distribution; colour
    histogram; condensation; constant velocity; covariance; covariance intersection;
    cross-covariance; detection; disparity; effective number; eigenface; Euclidean distance;
    extended Kalman filter; face space; FastSLAM; first-estimates Jacobian; Fisher information;
    fusion; gain; gauge freedom; grey vector; histogram intersection; homography; importance
    sampling; innovation; integral image; Jacobian; joint compatibility; Kalman filter; key image;
    landmark; laser scan; leg detection; likelihood; line distance; line segment; linearisation;
    look-alike; loop closing; Mahalanobis distance; mean shift; monobot; Monte Carlo localisation;
    mosaic; NEES; NIS; occlusion; odometry; overconfident; particle; particle filter; polygonal
    simplification; pose; posterior; Rao-Blackwellised particle filter; recursion; relative error;
    SIFT; silhouette; skin colour; SLAM; sonar; stereo; straight part; teach and repeat; tracker;
    tutor; unicycle; visual servoing; voice
"""
SMALL = """
    a after all am an and another are at by can eight for four from has he him his how hundred i
    in is it its like many me must not of on one or our round s that the they this three to two
    every five
    what where which who whose why with you accurate asks checked choose compares exchanged
    finds follow keeps known makes remembers seen sets stay taken across behind raised right
    unknown wrong copies
"""
PLAIN = """
    angles arms camera ceiling committee companion corridor day dimension doors eye floor hand head
    microphones motion
    names opinions opponent paper parts people person price robot rule shape system walls
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


ONE_MEANING = frozenset(" ".join(TECHNICAL.split()).split("; "))
"""Words that have one meaning wherever the book says them in the forms that are marked."""
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
    assert "one_belief" not in {page.stem for page in used["chain"]}  # of a rule, and of events


def test_the_page_is_in_the_contents():
    assert PAGE in CONTENTS.pages


def marked(sentence, page, terms=TERMS):
    return {term.name for _, _, term in Finder(terms, page)(sentence)}


def test_a_word_has_one_meaning_or_says_where_it_is_meant():
    said = {term.name for term in TERMS if term.pages is not None or term.unlike}
    never = {term.name for term in TERMS if term.hover == ()}
    assert said | never | ONE_MEANING == {term.name for term in TERMS}
    assert not ONE_MEANING & (said | never)
    for term in TERMS:
        assert set(term.pages or ()) <= CONTENTS.pages.keys()
        for phrase in term.unlike:  # a phrase without the word would never be asked
            assert term.used.search(phrase)


@pytest.mark.parametrize(("word", "page", "meant", "sentence"), MEANINGS)
def test_a_word_is_marked_only_where_it_is_meant(word, page, meant, sentence):
    assert (word in marked(sentence, page)) == (meant == "yes")


def test_each_word_with_two_meanings_has_a_sentence_of_both():
    said = {term.name for term in TERMS if term.pages is not None or term.unlike}
    assert {word for word, _, meant, _ in MEANINGS if meant == "yes"} == said
    assert {word for word, _, meant, _ in MEANINGS if meant == "no"} == said


def test_matched_by_spelling_alone_words_would_be_wrong():
    plain = [replace(term, pages=None, unlike=()) for term in TERMS]
    wrong = [
        sentence
        for word, page, meant, sentence in MEANINGS
        if meant == "no" and word in marked(sentence, page, plain)
    ]
    assert len(wrong) > 40
