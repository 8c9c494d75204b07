"""Figures in one style, coloured by the page's theme, with alternative text that must be there."""

from robot_perception.teaching.figures.drawn import drawn
from robot_perception.teaching.figures.films import film
from robot_perception.teaching.figures.output import picture, show
from robot_perception.teaching.figures.style import MEANING, band, figure, image_axes, label
from robot_perception.teaching.figures.svg import to_html, to_svg

__all__ = [
    "MEANING",
    "band",
    "drawn",
    "figure",
    "film",
    "image_axes",
    "label",
    "picture",
    "show",
    "to_html",
    "to_svg",
]
