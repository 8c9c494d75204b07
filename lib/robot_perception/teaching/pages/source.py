"""Library source beside the equation it computes."""

import inspect
from collections.abc import Callable
from html import escape
from pathlib import Path

from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonLexer

from explorables.figures.output import on_page
from explorables.media import Shown
from explorables.outputs import output
from robot_perception.checks import shown
from robot_perception.teaching import FRONT_END
from robot_perception.teaching.pages.listings import reduced, validates
from robot_perception.teaching.pages.source_pages import address


def show_source(function: Callable | type) -> Shown:
    """Return the highlighted source of a library function with a link to its line.

    In the built book the link opens the source page at that function; in a live notebook the
    file and line are named.

    Parameters
    ----------
    function
        A function or class of the library, compiled ones included. A function is cut to what stands
        beside the equation, without docstring, validation and annotations; the heading says so.

    Raises
    ------
    TypeError
        If the object has no Python source.
    """
    function = inspect.unwrap(getattr(function, "py_func", function))
    try:
        lines, first = inspect.getsourcelines(function)
        module = inspect.getmodule(function).__name__
    except (OSError, TypeError, AttributeError) as error:
        raise TypeError(f"function {shown(function)} has no Python source to show") from error
    cut = inspect.isfunction(function)
    code = reduced(function) if cut else "".join(lines)
    left_out = "; validation left out" if cut and validates(function) else ""
    name = function.__qualname__
    place = f"{module.replace('.', '/')}.py, line {first}"
    if on_page():
        page = address(module, name)
        link = f'<a href="{escape(page)}"><code>{escape(name)}</code> in {escape(place)}</a>'
    else:
        link = f"<code>{escape(name)}</code> in {escape(place)}"
    body = highlight(code, PythonLexer(), HtmlFormatter(cssclass="highlight"))
    html = f'<div class="rp-source"><p class="rp-source-place">{link}{left_out}</p>{body}</div>'
    text = f"# {name} in {Path(place).as_posix()}{left_out}\n{code}"
    return output(html, text, FRONT_END / "listing.css")
