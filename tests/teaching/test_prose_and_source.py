"""Numbers in prose and shown source."""

import inspect

import numba
import numpy as np
import pytest

from robot_perception import checks, kalman
from robot_perception.teaching.pages.source import show_source
from robot_perception.teaching.words.prose import tell


def test_tell_formats_numbers_and_keeps_braces_for_mathematics():
    shown = tell(r"The gain is {gain:.2f}, $\frac{{1}}{{4}}$, {gain:.1%}.", gain=0.25)
    assert shown.bundle["text/markdown"] == "The gain is 0.25, $\\frac{1}{4}$, 25.0\xa0%."


@pytest.mark.parametrize(
    ("number", "spec", "shown"),
    [
        (-2.4, ".1f", "−2.4"),
        (168587, ",", "168\u202f587"),
        (-0.001, ".0%", "0\xa0%"),
        (2e-15, ".0e", "2 × 10⁻¹⁵"),
        ("a-b", "", "a-b"),
    ],
)
def test_tell_sets_numbers_as_print_does(number: float | str, spec: str, shown: str):
    assert tell(f"It is {{x:{spec}}}.", x=number).bundle["text/plain"] == f"It is {shown}."


def test_tell_refuses_missing_and_unused_numbers():
    with pytest.raises(ValueError, match="slope"):
        tell("The slope is {slope}.", gain=1)
    with pytest.raises(ValueError, match="not used"):
        tell("No number.", gain=1)


def test_source_is_the_library_s_with_its_line_cut_to_what_a_reader_needs():
    text = repr(show_source(kalman.predict))
    heading, definition, *body = text.splitlines()
    first = inspect.unwrap(kalman.predict).__code__.co_firstlineno
    place = f"robot_perception/kalman.py, line {first}"
    assert heading == f"# predict in {place}; validation left out"
    assert definition == "def predict(prior, motion):"
    assert "Q)) # eq. (5)" in " ".join(body[-1].split())
    assert "; validation left out" not in repr(show_source(tell))


def test_a_class_is_shown_whole():
    assert "def __post_init__" in repr(show_source(kalman.Motion))


def test_source_links_to_the_page_only_in_the_built_book(monkeypatch):
    assert "href" not in show_source(tell).bundle["text/html"].split("</style>")[1]
    monkeypatch.setenv("EXPLORABLES_PAGE", "1")
    html = show_source(tell).bundle["text/html"]
    assert 'href="_modules/robot_perception/teaching/words/prose.html#tell"' in html


def test_source_of_a_compiled_function_is_its_python():
    compiled = numba.njit(checks.check_finite)
    assert "def check_finite" in repr(show_source(compiled))


@pytest.mark.parametrize("thing", [len, np.ufunc])
def test_no_source_is_a_clear_error(thing):
    with pytest.raises(TypeError, match="no Python source"):
        show_source(thing)
