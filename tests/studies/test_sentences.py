"""Results as sentences: digits by the interval, limits in words, a noun for every number."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.intervals import Interval, exact
from studies.sentences import Form, sentence, wanted, with_interval
from studies.verdicts import Accepted

SPACE = "\N{NO-BREAK SPACE}"


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (Interval(0.7368, 0.5799, 0.8503), "share", "74 % [58, 85]"),
        (Interval(1.0, 0.9493, 1.0), "share", "100 % [95, 100]"),
        (Interval(0.04704, -0.02827, 0.1111), "points", "5 points [−3, 11]"),
        (Interval(1.4287, 1.2407, 1.6525), "times", "1.43 times [1.24, 1.65]"),
        (Interval(10.33, 9.3699, 11.7267, "cm"), "number", "10.3 cm [9.4, 11.7]"),
        (Interval(1.000830565, 1.000207641, 1.003322259), "times", "1.0008 times [1.0002, 1.0033]"),
        (Interval(174899.0, 174000.0, 178000.0), "number", "174899 [174000, 178000]"),
        (Interval(2.5e-7, 2.1e-7, 2.9e-7), "number", "2.50 × 10⁻⁷ [2.10 × 10⁻⁷, 2.90 × 10⁻⁷]"),
        (exact(174.8991177), "number", "175"),
        (exact(0.0, "px/rad"), "number", "0 px/rad"),
        (exact(1.0), "share", "100 %"),
        (exact(0.99985), "share", "99.985 %"),
        (Interval(0.215, 0.209, 1.316), "times", "0.215 times [0.209, 1.316]"),
        (Interval(0.99901, 0.99899, 1.0), "number", "0.9990 [0.9990, 1.0000]"),
    ],
)
def test_a_value_has_the_digits_that_its_interval_leaves(value, form, text):
    assert with_interval(value, form).replace(SPACE, " ") == text


@pytest.mark.parametrize(
    ("low", "high", "form", "unit", "text"),
    [
        (0.5, 1.0, "share", "", "at least 50 %"),
        (0.0, 0.75, "share", "", "at most 75 %"),
        (0.2, 0.3, "share", "", "20 to 30 %"),
        (1.0, 1.0, "share", "", "exactly 100 %"),
        (0.1, 1.0, "points", "", "at least 10 points"),
        (8.62, 100.0, "number", "points", "at least 8.62 points"),
        (0.0, 100.0, "number", "points", "at least 0 points"),
        (0.0, 1.1, "times", "", "at most 1.1 times"),
        (0.0, 1.0, "times", "", "at most the same"),
        (1.25, math.inf, "times", "", "at least 1.25 times"),
        (1 - 1e-9, 1 + 1e-9, "times", "", "the same"),
        (-math.inf, 0.5, "number", "px", "at most 0.5 px"),
        (0.0, 1e-9, "number", "", "at most 1 × 10⁻⁹"),
        (0.0, 0.0, "number", "unseen directions", "exactly 0"),
        (0.75, 1.33, "times", "", "0.75 to 1.33 times"),
    ],
)
def test_a_limit_is_said_where_it_is_one(low, high, form, unit, text):
    said = wanted(Accepted(low, high, "why"), form, exact(0.5, unit))
    assert said.replace(SPACE, " ") == text


def test_a_result_is_a_sentence():
    said = sentence(
        "{value} of the faces are held while they are covered",
        "share",
        Interval(0.7368, 0.5799, 0.8503),
        Accepted(0.5, 1.0, "why"),
        "reproduced",
    )
    assert said.replace(SPACE, " ") == (
        "74 % [58, 85] of the faces are held while they are covered; at least 50 % wanted: "
        "reproduced."
    )
    alone = sentence("the error is {value}", "number", exact(2.0, "m"), None, "illustrated")
    assert alone.replace(SPACE, " ") == "The error is 2 m: illustrated."


@given(st.floats(-1e6, 1e6), st.floats(1e-9, 1e6), st.sampled_from(Form))
def test_what_is_written_is_the_number_to_a_tenth_of_its_interval(middle, width, form):
    text = with_interval(Interval(middle, middle - width / 2, middle + width / 2), form)
    factor = 100.0 if form in ("share", "points") else 1.0
    number = text.split(SPACE)[0] if form != "number" else text.split(" [")[0]
    if "×" not in text:
        assert float(number.replace("−", "-")) == pytest.approx(
            factor * middle, abs=max(0.051 * factor * width, 5.1e-5) + 0.5 * (width * factor > 100)
        )
