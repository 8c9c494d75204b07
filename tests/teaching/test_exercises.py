"""Exercises: right, wrong with a hint, not yet; a reader's odd answer never breaks the page."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.teaching.course.exercises import Exercise, Sheet

SHEET = Sheet(
    {
        "a-1": Exercise(0.25, mistakes=((4.0, "that is the inverse"),), hint="Divide."),
        "a-2": Exercise(np.array([1.0, 1.0])),
        "a-3": Exercise("the anchor"),
        "a-4": Exercise(lambda x: x > 3, mistakes=((lambda x: x < 0, "a variance"),)),
        "a-5": Exercise(True),
    }
)


@pytest.mark.parametrize(
    ("key", "answer", "outcome"),
    [
        ("a-1", ..., "not yet"),
        ("a-1", None, "not yet"),
        ("a-1", 0.25, "right"),
        ("a-1", 0.26, "wrong"),
        ("a-1", True, "wrong"),
        ("a-2", [1, 1], "right"),
        ("a-2", [[1, 1]], "wrong"),
        ("a-3", "The Anchor.", "right"),
        ("a-3", 3, "wrong"),
        ("a-3", "anchor", "wrong"),
        ("a-4", 5, "right"),
        ("a-4", "five", "wrong"),
        ("a-5", True, "right"),
        ("a-5", 1, "wrong"),
        ("a-5", np.bool_(False), "wrong"),
    ],
)
def test_outcomes(key, answer, outcome):
    assert repr(SHEET.check(key, answer)).startswith(f"{key}: {outcome}.")


def test_typical_mistake_gets_its_hint_and_others_the_general_one():
    assert "that is the inverse" in repr(SHEET.check("a-1", 4))
    assert "Divide." in repr(SHEET.check("a-1", 7))
    assert "a variance" in repr(SHEET.check("a-4", -1))


def test_an_answer_may_be_as_far_off_as_the_exercise_says():
    rough = Exercise(200.0, rtol=0.1)
    assert [rough.judge(answer)[0] for answer in (215.0, 185.0, 225.0)] == ["right"] * 2 + ["wrong"]


def test_unknown_exercise_names_the_known_ones():
    with pytest.raises(ValueError, match="a-1, a-2"):
        SHEET.check("b-1", 1)


@given(
    st.one_of(st.floats(), st.text(), st.lists(st.floats()), st.dictionaries(st.text(), st.text()))
)
def test_any_answer_gets_a_word(answer):
    for key in SHEET:
        assert SHEET.check(key, answer).bundle["text/html"].endswith("</p>")


def test_what_the_reader_wrote_is_escaped():
    class Hostile:
        def __array__(self, dtype=None, copy=None):
            raise TypeError("<script>")

    assert "<script>" not in SHEET.check("a-1", Hostile()).bundle["text/html"]
