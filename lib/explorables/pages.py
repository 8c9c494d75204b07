"""A page of its own: explorers, figures, films and bets in one HTML file that needs no server.

.. code-block:: python

    write_page("gain.html", "<h1>Gain</h1>", exploration, title="Gain")

Style sheets, scripts and all states stand inside the file.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from pathlib import Path
from typing import Any

from explorables.explorations import Exploration
from explorables.explore import Explorer
from explorables.figures.output import PAGE_VARIABLE, front_end

SHEETS = tuple(f"{name}.css" for name in ("figure", "explorer", "film", "bet", "table"))
SCRIPTS = ("explorer.js", "film.js")
NO_SCRIPTS = (
    '<p class="rp-note rp-unscripted">Your browser runs no scripts. Everything can be read, but '
    "controls need scripts: each figure shows its first state.</p>"
)
THEME = (
    'document.documentElement.classList.add("rp-scripted");'
    "{const page = document.documentElement.dataset;"
    'if (page.theme !== "light" && page.theme !== "dark")'
    ' page.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";}'
)
"""Sets the theme before the first paint; a theme's own script may accept only light and dark.

A page whose scripts run says so, to its style sheet.
"""
BODY = (
    "body { max-width: 50rem; margin: 2rem auto; padding: 0 1rem; color: var(--rp-ink);"
    " background: var(--rp-ground); font-family: var(--rp-font); }"
)


def page(*parts: Any, title: str, language: str = "en") -> str:
    """Return a page as HTML.

    Parameters
    ----------
    *parts
        What stands on it: explorations and explorers, what `figures.show`, `film` and `bet` return,
        and texts, which are HTML.
    title
        Name of the page.
    language
        Of its words, as HTML says it.

    Raises
    ------
    TypeError
        If a part is neither a text nor an output that has HTML.
    """
    with _as_page():
        body = "\n".join(map(_html, parts))
    style = "".join(map(front_end, SHEETS)) + BODY
    scripts = "".join(f"<script>{front_end(script)}</script>" for script in SCRIPTS)
    return (
        f'<!DOCTYPE html>\n<html lang="{escape(language)}">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{style}</style>\n"
        f"<script>{THEME}</script>\n{scripts}\n</head>\n"
        f"<body>\n<main>\n{NO_SCRIPTS}\n{body}\n</main>\n</body>\n</html>\n"
    )


def write_page(path: Path | str, *parts: Any, title: str, language: str = "en") -> Path:
    """Write a page to a file, and return where: as `page`.

    Raises
    ------
    TypeError
        If a part is neither a text nor an output that has HTML.
    OSError
        If it cannot be written.
    """
    file = Path(path)
    file.write_text(page(*parts, title=title, language=language), encoding="utf-8")
    return file


def _html(part: Any) -> str:
    if isinstance(part, str):
        return part
    if isinstance(part, Exploration):
        part = part.show()
    if isinstance(part, Explorer):
        return part.page()
    try:
        return part._repr_mimebundle_()["text/html"]
    except (AttributeError, KeyError):
        raise TypeError(f"a part must be a text or have HTML, got {part!r}") from None


@contextmanager
def _as_page() -> Iterator[None]:
    """Let outputs be those of a page, behind which there is no kernel."""
    before = os.environ.get(PAGE_VARIABLE)
    os.environ[PAGE_VARIABLE] = "1"
    try:
        yield
    finally:
        os.environ.pop(PAGE_VARIABLE)
        if before is not None:
            os.environ[PAGE_VARIABLE] = before
