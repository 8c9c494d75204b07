"""Numbers in prose and shown source."""

import inspect

import numba
import numpy as np
import pytest

from robot_perception import checks
from robot_perception.teaching.prose import tell
from robot_perception.teaching.source import show_source


def test_tell_formats_numbers_and_keeps_braces_for_mathematics():
    shown = tell(r"The gain is {gain:.2f}, $\frac{{1}}{{4}}$, {gain:.1%}.", gain=0.25)
    assert shown.bundle["text/markdown"] == r"The gain is 0.25, $\frac{1}{4}$, 25.0%."


def test_tell_refuses_missing_and_unused_numbers():
    with pytest.raises(ValueError, match="slope"):
        tell("The slope is {slope}.", gain=1)
    with pytest.raises(ValueError, match="not used"):
        tell("No number.", gain=1)


def test_source_is_the_library_s_with_its_line_and_without_the_docstring():
    shown = show_source(checks.check_finite)
    text = shown.bundle["text/plain"]
    first = inspect.unwrap(checks.check_finite).__code__.co_firstlineno
    assert f"robot_perception/checks.py, line {first}" in text
    assert "np.isfinite(value)" in text
    assert "Raise ``ValueError``" not in text
    assert "Raise ``ValueError``" in repr(show_source(checks.check_finite, docstring=True))


def test_source_links_to_the_page_only_in_the_built_book(monkeypatch):
    assert "href" not in show_source(tell).bundle["text/html"]
    monkeypatch.setenv("ROBOT_PERCEPTION_PAGE", "1")
    html = show_source(tell).bundle["text/html"]
    assert 'href="_modules/robot_perception/teaching/prose.html#tell"' in html


def test_source_of_a_compiled_function_is_its_python():
    compiled = numba.njit(checks.check_finite)
    assert "def check_finite" in repr(show_source(compiled))


@pytest.mark.parametrize("thing", [len, np.ufunc])
def test_no_source_is_a_clear_error(thing):
    with pytest.raises(TypeError, match="no Python source"):
        show_source(thing)
