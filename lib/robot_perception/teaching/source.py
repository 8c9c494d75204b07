"""Library source beside the equation it computes."""

import ast
import inspect
import textwrap
from collections.abc import Callable
from html import escape
from pathlib import Path

from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonLexer

from robot_perception.checks import flag, shown
from robot_perception.teaching.figures.output import on_page
from robot_perception.teaching.media import Shown
from robot_perception.teaching.source_pages import address


def show_source(function: Callable | type, *, docstring: bool = False) -> Shown:
    """Return the highlighted source of a library function with a link to its line.

    In the built book the link opens the source page at that function; in a live notebook the
    file and line are named.

    Parameters
    ----------
    function
        A function or class of the library, compiled ones included.
    docstring
        Whether to keep the docstring; without it the code stands beside the equation.

    Raises
    ------
    TypeError
        If the object has no Python source.
    """
    flag("docstring", docstring)
    function = inspect.unwrap(getattr(function, "py_func", function))
    try:
        lines, first = inspect.getsourcelines(function)
        module = inspect.getmodule(function).__name__
    except (OSError, TypeError, AttributeError) as error:
        raise TypeError(f"function {shown(function)} has no Python source to show") from error
    code = "".join(lines if docstring else _without_docstring(function, lines)).rstrip() + "\n"
    name = function.__qualname__
    place = f"{module.replace('.', '/')}.py, line {first}"
    if on_page():
        page = address(module, name)
        link = f'<a href="{escape(page)}"><code>{escape(name)}</code> in {escape(place)}</a>'
    else:
        link = f"<code>{escape(name)}</code> in {escape(place)}"
    body = highlight(code, PythonLexer(), HtmlFormatter(cssclass="highlight"))
    html = f'<div class="rp-source"><p class="rp-source-place">{link}</p>{body}</div>'
    return Shown({"text/html": html, "text/plain": f"# {name} in {Path(place).as_posix()}\n{code}"})


def _without_docstring(function: Callable | type, lines: list[str]) -> list[str]:
    """Return the source lines with the docstring cut out."""

    node = ast.parse(textwrap.dedent("".join(lines))).body[0]
    if ast.get_docstring(node) is None:
        return lines
    first = node.body[0]
    return lines[: first.lineno - 1] + lines[first.end_lineno :]
