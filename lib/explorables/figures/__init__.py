"""Figures in one style, coloured by the page's theme, with alternative text that must be there."""

from explorables.figures.drawn import drawn
from explorables.figures.films import film
from explorables.figures.output import show
from explorables.figures.style import MEANING, band, figure, image_axes, label
from explorables.figures.svg import to_html, to_svg

__all__ = [
    "MEANING",
    "band",
    "drawn",
    "figure",
    "film",
    "image_axes",
    "label",
    "show",
    "to_html",
    "to_svg",
]
