"""Figures and pictures as notebook output: HTML with alternative text and a caption."""

from __future__ import annotations

import base64
import html
import io
import os
import re
from functools import cache
from importlib.resources import files

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from robot_perception.teaching.figures.svg import to_svg
from robot_perception.teaching.media import Shown

PAGE_VARIABLE = "ROBOT_PERCEPTION_PAGE"
"""Environment variable that is 1 while the book is built: no kernel stands behind the output."""

_SHORTEST_ALT = 20
_FILE_NAME = re.compile(r"\S+\.[A-Za-z0-9]{2,5}")
_MATHEMATICS = re.compile(r"(?<!\\)\$([^$]+)\$")


def show(fig: Figure, *, alt: str, caption: str | None = None) -> Shown:
    """Show a figure as themed SVG with its alternative text.

    Parameters
    ----------
    fig
        The figure; `robot_perception.teaching.figures.figure` makes one.
    alt
        What a reader who cannot see the figure has to know: what is drawn and what it shows.
    caption
        May hold mathematics between dollars.

    Returns
    -------
    Shown
        Notebook output.

    Raises
    ------
    ValueError
        If the alternative text is missing, short, or a file name.
    """
    return _output(to_svg(fig, alt=check_alt(alt)), alt, caption)


def picture(
    array: np.ndarray, *, alt: str, caption: str | None = None, pixelated: bool = False
) -> Shown:
    """Show a raster image, stored as WebP.

    Parameters
    ----------
    array
        Image of type uint8, shape (height, width) or (height, width, 3 or 4).
    alt
        As for `show`.
    caption
        May hold mathematics between dollars.
    pixelated
        Enlarge without smoothing, for images whose pixels matter.

    Returns
    -------
    Shown
        Notebook output.

    Raises
    ------
    ValueError
        If the array is no 8-bit image or the alternative text does not serve.
    """
    element = image_element(to_webp(array), array.shape, check_alt(alt), pixelated)
    return _output(element, alt, caption)


def to_webp(array: np.ndarray, *, effort: int = 4) -> bytes:
    """Encode an 8-bit image as WebP.

    Parameters
    ----------
    array
        Image of type uint8, shape (height, width) or (height, width, 3 or 4).
    effort
        0 (fast) to 6 (small).

    Returns
    -------
    bytes

    Raises
    ------
    ValueError
        If the array is no 8-bit image.
    """
    shape = array.shape
    layered = len(shape) == 3 and shape[2] in (3, 4)
    if array.dtype != np.uint8 or not (len(shape) == 2 or layered):
        raise ValueError(
            f"an image must be uint8 of shape (height, width[, 3 or 4]), got {array.dtype} {shape}"
        )
    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(array)).save(stream, "WEBP", quality=88, method=effort)
    return stream.getvalue()


def image_element(data: bytes, shape: tuple[int, ...], alt: str, pixelated: bool = False) -> str:
    """Write the `<img>` element of a WebP image, its data inside."""
    style = " rp-pixelated" if pixelated else ""
    height, width = shape[:2]
    return (
        f'<img class="dark-light{style}" width="{width}" height="{height}"'
        f' alt="{html.escape(alt)}"'
        f' src="data:image/webp;base64,{base64.b64encode(data).decode()}">'
    )


def check_alt(alt: str) -> str:
    """Return the alternative text, or refuse one that tells a reader nothing.

    Parameters
    ----------
    alt
        The text to judge.

    Returns
    -------
    str
        The text without surrounding blanks.

    Raises
    ------
    ValueError
        If it is no string, shorter than 20 characters, or a file name.
    """
    text = alt.strip() if isinstance(alt, str) else ""
    if len(text) < _SHORTEST_ALT or _FILE_NAME.fullmatch(text):
        raise ValueError(
            f"alt must say what the figure shows in {_SHORTEST_ALT} characters or more, got {alt!r}"
        )
    return text


def figcaption(caption: str | None) -> str:
    """Write the `<figcaption>` element; mathematics between dollars is handed to MathJax.

    Parameters
    ----------
    caption
        The text, or None.

    Returns
    -------
    str
        The element, empty without a caption.
    """
    if not caption:
        return ""
    text = _MATHEMATICS.sub(r"\\(\1\\)", html.escape(caption, quote=False))
    return f'<figcaption class="mathjax_process">{text}</figcaption>'


def on_page() -> bool:
    """Tell whether the output goes to a page of the book, where no kernel stands behind it."""
    return os.environ.get(PAGE_VARIABLE) == "1"


@cache
def front_end(name: str) -> str:
    """Read a file of the front end, a script or a style sheet."""
    return files("robot_perception.teaching").joinpath("front_end", name).read_text("utf-8")


def _output(element: str, alt: str, caption: str | None) -> Shown:
    style = "" if on_page() else f"<style>{front_end('figure.css')}</style>"
    markup = f'{style}<figure class="rp-figure">{element}{figcaption(caption)}</figure>'
    return Shown({"text/html": markup, "text/plain": alt})
