"""Cards of the landing page: a chapter's hero figure with its question, paper and needs."""

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

from matplotlib.figure import Figure

from explorables.figures.output import check_alt
from explorables.figures.svg import to_svg
from explorables.media import Shown
from robot_perception.teaching.pages.contents import Contents, Page
from robot_perception.teaching.scores.badges import recorded
from robot_perception.teaching.scores.papers import PAPERS
from studies.ledger import Ledger


@dataclass(frozen=True, eq=False, slots=True)
class Card:
    """A chapter on the landing page: its hero figure, and the question that it answers."""

    question: str
    figure: Figure
    alt: str


def cards(contents: Contents, shown: Mapping[str, Card], ledger: Ledger | None = None) -> Shown:
    """Return a card for each chapter as a grid of links, in the order of the book.

    Number, title and needs are those of the chapter's page, the papers those of its claims. A
    chapter that is not among those shown has a card without a picture, with its own first question.

    Parameters
    ----------
    contents
        The chapters.
    shown
        Figures and questions by stem.
    ledger
        The claims; those of the book if not given.

    Raises
    ------
    ValueError
        If a card is shown of what is no chapter.
    """
    stems = [page.stem for page in contents.chapters]
    strange = sorted(shown.keys() - set(stems))
    if strange:
        raise ValueError(f"shown: no chapter {strange[0]!r}; the book has {', '.join(stems)}")
    ledger = recorded() if ledger is None else ledger
    html, lines = "", []
    for page in contents.chapters:
        one, number = shown.get(page.stem), f"{page.number} · " if page.number else ""
        question = one.question if one else page.question
        picture = to_svg(one.figure, alt=check_alt(one.alt)) if one else "<span></span>"
        about = f"{number}{papers(page, ledger)}"
        needs = ", ".join(_short(contents.pages[s]) for s in contents.needs(page.stem))
        needs = f"Needs {needs}" if needs else "Needs no other chapter"
        html += (
            f'<a class="rp-card" href="{escape(page.stem)}.html">{picture}'
            f'<span class="rp-card-about">{escape(about)}</span>'
            f'<strong class="rp-card-title">{escape(page.title)}</strong>'
            f'<span class="rp-card-question">{escape(question)}</span>'
            f'<span class="rp-card-needs">{escape(needs)}</span></a>'
        )
        lines.append(f"{number}{page.title}: {question} ({page.stem}.html) {needs}.")
    return Shown(
        {"text/html": f'<div class="rp-cards">{html}</div>', "text/plain": "\n".join(lines)}
    )


def papers(page: Page, ledger: Ledger) -> str:
    """Return the papers of which a chapter's claims speak, or its part if it makes none."""
    found = {entry.paper for entry in ledger.entries if entry.chapter == page.stem}
    names = [paper.citation for key, paper in PAPERS.items() if key in found]
    if len(names) == len(PAPERS):
        return "all five papers"
    return ", ".join(names) or page.part


def _short(page: Page) -> str:
    return str(page.number) if page.number else page.title
