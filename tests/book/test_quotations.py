"""What is quoted from the papers is what they say, word for word."""

import pytest

from robot_perception.teaching.scores.papers import PAPERS
from tests.book import quotations
from tests.book.quotations import LIST, OTHERS


def test_every_quotation_is_listed():
    wrong = [
        f"{place}: {quotation!r}"
        for place, quotation, keys in quotations.quoted()
        if not any(quotations.digest(quotation) in quotations.listed()[key] for key in keys)
    ]
    assert not wrong, "\n".join(
        [*wrong, "If the papers say so, run `python -m tests.book.quotations`, which lists them."]
    )


def test_what_is_listed_is_quoted_and_stands_in_the_papers():
    if not quotations.texts():
        pytest.skip("the papers are not here; ROBOT_PERCEPTION_PAPERS names their folder")
    assert quotations.texts().keys() == PAPERS.keys()
    assert LIST.read_text("utf-8").splitlines() == quotations.lines()


def test_what_is_no_quotation_from_a_paper_still_stands_in_the_book():
    said = {
        quotation
        for passage in (*quotations.prose(), *quotations.words())
        for quotation in quotations.quotations(passage.text)
    }
    assert OTHERS.keys() <= said


PAPER = (
    "The system shows *good results* with little\nvariations of view-\npoint, and if consid-\n\n"
    "Fig. 3. A caption.\n\nering only contours it is lost."
)


@pytest.mark.parametrize(
    "quotation",
    [
        "good results",
        "little variations of viewpoint",
        "The system shows … variations",
        "if considering only contours",
    ],
)
def test_what_a_paper_says_is_found(quotation):
    assert quotations.is_quoted(quotation, quotations.readings(PAPER))


@pytest.mark.parametrize(
    "quotation",
    ["almost good results", "little variation of viewpoint", "variations … The system shows"],
)
def test_what_a_paper_does_not_say_is_found_out(quotation):
    assert not quotations.is_quoted(quotation, quotations.readings(PAPER))


def test_quotations_are_what_stands_between_marks_in_one_paragraph():
    text = 'He says "one\ntwo" and “three”.\n\n`"code"` and 5" \n\n```\nx = "more"\n```\n"$L_i$"'
    assert quotations.quotations(text) == ["one two", "three"]
    assert quotations.quotations(f'<a id="place"></a>{text}') == ["one two", "three"]


def test_a_digest_depends_on_words_alone():
    assert quotations.digest("One, *two* … three") == quotations.digest("one two ... three")
    assert quotations.digest("one two three") != quotations.digest("one two … three")
