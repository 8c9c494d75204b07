"""Figures as notebook output: HTML with alternative text and a caption."""

from __future__ import annotations

import base64
import html
import os
import re
from functools import cache
from pathlib import Path

from matplotlib.figure import Figure

from explorables.figures.svg import to_html
from explorables.media import Shown, with_mathematics
from explorables.progress import PAGE_VARIABLE

FRONT_END = Path(__file__).parents[1] / "front_end"
"""Folder of the scripts and style sheets."""
_SHORTEST_ALT = 20
_FILE_NAME = re.compile(r"\S+\.[A-Za-z0-9]{2,5}")
_NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")


def show(fig: Figure, *, alt: str, caption: str | None = None, name: str | None = None) -> Shown:
    """Show a figure as themed SVG with its alternative text.

    A page numbers its captions; a text refers to the figure of the name ``worst-line`` by
    ``[the figure](#fig-worst-line)``, which becomes its number there.

    Parameters
    ----------
    fig
        The figure; `explorables.figures.figure` makes one.
    alt
        What a reader who cannot see the figure has to know: what is drawn and what it shows.
    caption
        May hold mathematics between dollars. One that names (a) letters the columns of the figure.
    name
        Words in small letters joined by hyphens, unique in the book; a figure that is referred to
        by number needs a caption.

    Raises
    ------
    ValueError
        If the alternative text is missing, short, or a file name, or the name does not serve.
    """
    check_name(name, caption)
    drawing = to_html(fig, alt=check_alt(alt), letters=is_lettered(caption))
    figure = f"{opening('rp-figure', name)}{drawing}{figcaption(caption)}</figure>"
    return Shown({"text/html": style_element("figure.css") + figure, "text/plain": alt})


def image_element(data: bytes, mime: str, size: tuple[int, int], alt: str) -> str:
    """Write the `<img>` element of an encoded picture, its data inside; SVG has no size."""
    width, height = size
    pixels = f' width="{width}" height="{height}"' if width else ""
    return (
        f'<img class="rp-frame dark-light" alt="{html.escape(alt)}"{pixels}'
        f' src="data:{mime};base64,{base64.b64encode(data).decode()}">'
    )


def check_alt(alt: str) -> str:
    """Return the alternative text, or refuse one that tells a reader nothing.

    Raises
    ------
    ValueError
        If it is no text, shorter than 20 characters, or a file name.
    """
    text = alt.strip() if isinstance(alt, str) else ""
    if len(text) < _SHORTEST_ALT or _FILE_NAME.fullmatch(text):
        raise ValueError(
            f"alt must say what the figure shows in {_SHORTEST_ALT} characters or more, got {alt!r}"
        )
    return text


def check_name(name: str | None, caption: str | None) -> None:
    """Raise ``ValueError`` unless a name can be an address and its figure has a caption."""
    if name is None:
        return
    if not _NAME.fullmatch(name):
        raise ValueError(f"name must be small letters and digits joined by hyphens, got {name!r}")
    if not caption:
        raise ValueError(f"name: figure {name!r} needs a caption, where its number stands")


def opening(kind: str, name: str | None = None) -> str:
    """Write the opening tag of a `<figure>`, with the address that its name gives."""
    address = f' id="fig-{name}"' if name else ""
    return f'<figure class="{kind}"{address}>'


def figcaption(caption: str | None) -> str:
    """Write the `<figcaption>` element, if any; MathJax sets what stands between dollars."""
    return f"<figcaption>{with_mathematics(caption)}</figcaption>" if caption else ""


def is_lettered(caption: str | None) -> bool:
    """Tell whether a caption names the columns of its figure by letters."""
    return caption is not None and "(a)" in caption


def on_page() -> bool:
    """Tell whether the output goes to a page of the book, where no kernel stands behind it."""
    return os.environ.get(PAGE_VARIABLE) == "1"


@cache
def front_end(name: str | Path) -> str:
    """Read a file of the front end, a script or a style sheet, or another one by its path."""
    return (FRONT_END / name).read_text("utf-8")


def style_element(*names: str | Path) -> str:
    """Write the style sheets that an output needs; a page of a book has them already."""
    return "" if on_page() else f"<style>{''.join(map(front_end, names))}</style>"
