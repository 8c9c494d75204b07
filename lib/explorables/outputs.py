"""Outputs of a cell, on a page of the book and in a notebook: style and links of each."""

import re
from pathlib import Path

from explorables.figures.output import on_page, style_element
from explorables.media import Shown

_LINK = re.compile(r' href="(?P<page>[\w/.-]+)\.html(?P<place>#[^"]*)?"')
_SOURCES = (".ipynb", ".md")


def output(html: str, text: str, *sheets: str | Path) -> Shown:
    """Return HTML as the output of a cell.

    A page of the book has the style sheets, and its links lead to other pages. In a notebook the
    sheets come with the HTML, and a link leads to the notebook beside it that the page is made of,
    or nowhere if it is not there.

    Parameters
    ----------
    html
        With links as a page has them, such as ``scorecard.html#gain-vanishes``.
    text
        The same for a terminal, and for tests to compare.
    *sheets
        The style sheets that it needs: names of ours, or paths of others.
    """
    if not on_page():
        html = style_element("figure.css", *sheets) + _LINK.sub(_to_notebook, html)
    return Shown({"text/html": html, "text/plain": text})


def _to_notebook(link: re.Match[str]) -> str:
    for suffix in _SOURCES:
        if Path(link["page"] + suffix).exists():
            return f' href="{link["page"]}{suffix}{link["place"] or ""}"'
    return ""
