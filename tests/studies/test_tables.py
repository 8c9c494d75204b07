"""Tables keep every number, show it rounded, and refuse what they cannot show."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.intervals import Interval
from studies.tables import Table

ENDS = Table(
    {
        "plain": [Interval(1.7712, 1.3412, 2.2212), 5438.9, 3],
        "anchored <A>": [Interval(1.77, 1.34, 2.2), None, "lost"],
    },
    {"end (m)": "error at the end", "NEES": "3 is right", "runs": ""},
    "mean and 95 % interval over 50 runs",
    "filter",
)


def test_text_is_aligned_and_rounded():
    assert repr(ENDS.show()).splitlines() == [
        "filter               end (m)  NEES  runs",
        "plain         1.8 [1.3, 2.2]  5400     3",
        "anchored <A>  1.8 [1.3, 2.2]     –  lost",
    ]


def test_digits_are_those_asked_for_and_one_end_is_shown_if_the_other_is_the_number():
    assert "1.77 [1.34, 2.22]" in ENDS.text(3)
    one = Table({"r": [Interval(1.0, 1.0, 2.0), Interval(2.0, 1.0, 2.0)]}, {"a": "", "b": ""})
    assert one.text().splitlines()[1].split("  ")[1:] == ["1.0 [1.0, 2.0]", "2.0 [1.0, 2.0]"]


def test_an_interval_that_has_a_width_shows_it():
    near = Table({"r": [Interval(1.0, 0.9981, 1.0), Interval(0.5, 0.49999999, 0.5)]},
                 {"a": "", "b": ""})  # fmt: skip
    assert near.text().splitlines()[1].split("  ")[1:] == ["1.0 [0.998, 1.00]",
                                                           "0.50 [0.500000, 0.500000]"]  # fmt: skip


def test_html_defines_columns_escapes_and_marks_what_to_compare():
    html = ENDS.show(bold=["NEES", ("plain", "runs")]).bundle["text/html"]
    assert "<strong>5400</strong>" in html
    assert '<td data-name="runs"><strong>3</strong></td>' in html
    assert '<td data-name="end (m)">1.8 <small>[1.3, 2.2]</small></td>' in html
    assert "<strong>lost</strong>" not in html
    row = ENDS.show(bold=["anchored <A>"]).bundle["text/html"]
    assert [word in row for word in ("<strong>lost", "<strong>–", "<strong>3")] == [
        True,
        True,
        False,
    ]
    assert "anchored &lt;A&gt;" in html
    assert "<i>NEES</i>: 3 is right" in html
    assert '<th scope="row">plain</th>' in html


def test_a_table_of_words_is_known_and_numbers_have_minus_signs():
    assert 'class="rp-results rp-words"' in ENDS.show().bundle["text/html"]
    numbers = Table({"a-b": [Interval(-0.12, -0.25, 0.1), -3, None]}, {"x": "", "y": "", "z": ""})
    html = numbers.show().bundle["text/html"]
    assert 'class="rp-results"' in html
    assert ">a-b</th>" in html
    assert "−0.12 <small>[−0.25, 0.10]" in html
    assert "−3" in html
    assert "-0.12 [-0.25, 0.10]" in numbers.text()


def test_columns_of_words_stand_flush_left_and_those_with_a_number_do_not():
    rows = {"a": ["given", "lost", None, None], "b": [None, 3, 0.5, None]}
    html = (
        Table(rows, dict.fromkeys(("words", "both", "number", "none"), ""))
        .show()
        .bundle["text/html"]
    )
    assert html.count("rp-text") == 3
    assert '<th scope="col" class="rp-text">words</th>' in html
    assert '<td data-name="words" class="rp-text">given</td>' in html
    assert '<td data-name="words" class="rp-text">–</td>' in html


def test_cells_are_found_by_name_and_a_part_keeps_them():
    assert ENDS["plain", "end (m)"].high == 2.2212
    part = ENDS.pick(["anchored <A>"], ["runs", "end (m)"])
    assert part.rows == {"anchored <A>": ("lost", Interval(1.77, 1.34, 2.2))}
    assert (part.about, part.corner) == (ENDS.about, ENDS.corner)
    for place, known in ((("plane", "NEES"), "plain"), (("plain", "NIS"), "NEES")):
        with pytest.raises(KeyError, match=known):
            ENDS[place]


finite = st.floats(-1e100, 1e100)
triples = st.tuples(finite, finite, finite).map(sorted)
cells = st.one_of(
    finite,
    st.integers(-9, 9),
    st.none(),
    st.text(),
    triples.map(lambda t: Interval(t[1], t[0], t[2])),
)


@given(st.dictionaries(st.text(), st.tuples(cells, cells), max_size=4))
def test_plain_form_loses_nothing(rows):
    table = Table(rows, {"a": "", "b": "second"}, "drawn", "row")
    again = Table.from_plain(json.loads(json.dumps(table.to_plain(), allow_nan=False)))
    assert again.to_plain() == table.to_plain()
    assert again.text() == table.text()


@given(finite.filter(lambda x: x == 0 or abs(x) > 1e-300), st.integers(1, 6))
def test_rounded_numbers_are_right_to_the_digits(value, digits):
    text = Table({"r": [value]}, {"x": ""}).text(digits).splitlines()[1].split()[-1]
    assert math.isclose(float(text), value, rel_tol=0.51 * 10.0 ** (1 - digits), abs_tol=0)


@pytest.mark.parametrize(
    ("make", "error", "match"),
    [
        (lambda: Table({"r": [1, 2]}, {"x": ""}), ValueError, "row 'r' has 2 cells for 1"),
        (lambda: Table({}, {}), ValueError, "needs a column"),
        (lambda: Table({"r": [[1]]}, {"x": ""}), TypeError, r"\[1\]"),
        (lambda: Table({"r": [True]}, {"x": ""}), TypeError, "True"),
        (lambda: Table({"r": [np.nan]}, {"x": ""}), ValueError, "nan"),
    ],
)
def test_what_cannot_be_shown_is_refused(make, error, match):
    with pytest.raises(error, match=match):
        make()
