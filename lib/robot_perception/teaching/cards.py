"""Cards of the landing page: a chapter's hero figure with its question."""

from dataclasses import dataclass
from html import escape

from matplotlib.figure import Figure

from robot_perception.teaching.figures.output import check_alt
from robot_perception.teaching.figures.svg import to_svg
from robot_perception.teaching.media import Shown


@dataclass(frozen=True, eq=False, slots=True)
class Card:
    """A chapter on the landing page: its hero figure, and the question that it answers."""

    page: str
    title: str
    question: str
    figure: Figure
    alt: str


def cards(*shown: Card) -> Shown:
    """Return the cards as a grid of links."""
    html = "".join(
        f'<a class="rp-card" href="{escape(card.page)}">'
        f"{to_svg(card.figure, alt=check_alt(card.alt))}"
        f'<strong class="rp-card-title">{escape(card.title)}</strong>'
        f'<span class="rp-card-question">{escape(card.question)}</span></a>'
        for card in shown
    )
    text = "\n".join(f"{card.title}: {card.question} ({card.page})" for card in shown)
    return Shown({"text/html": f'<div class="rp-cards">{html}</div>', "text/plain": text})
