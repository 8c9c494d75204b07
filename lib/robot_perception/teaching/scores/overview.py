"""The papers at a glance: which chapters rebuild each, and what came of its claims."""

import tomllib
from collections.abc import Mapping
from html import escape

from explorables.media import Shown, html_table
from explorables.outputs import output
from robot_perception.teaching.scores.badges import EXPLAINED, SHEETS, recorded, style
from robot_perception.teaching.scores.papers import PAPERS
from robot_perception.teaching.scores.scorecard import BEYOND, OURS
from studies.files import reading
from studies.ledger import Ledger, verdicts
from studies.records import records

HEAD = ("Paper", "Rebuilt in", "Verdicts")
TO_COME = "a later chapter"
FOUND = "What we found beyond the papers"
HOLDS = "holds.toml"
"""Name of the file that says what holds of each paper."""


def overview(titles: Mapping[str, str]) -> Shown:
    """Return the papers as a table: the chapters that rebuild each, and how many verdicts of which.

    Findings of ours, which go beyond a paper, have a row of their own.

    Parameters
    ----------
    titles
        Titles of the chapters by stem, in the order of the book.
    """
    entries = recorded().entries
    beyond = tuple(e for e in entries if e.place.startswith(BEYOND))
    parts = [
        (key, paper.title, paper.citation, tuple(e for e in entries if e.paper == key))
        for key, paper in PAPERS.items()
    ]
    parts += [(OURS, FOUND, "counted in no other row", beyond)] if beyond else []
    rows, lines = [], []
    for key, title, about, found in parts:
        claims = Ledger(found if key == OURS else tuple(e for e in found if e not in beyond))
        stems = [stem for stem in titles if any(e.chapter == stem for e in claims.entries)]
        links = ", ".join(f'<a href="{s}.html">{escape(titles[s])}</a>' for s in stems)
        counts = verdicts(claims)
        badges = " ".join(
            f'<a class="{style(verdict)}" href="scorecard.html#claims-of-{key}" '
            f'title="{EXPLAINED[verdict]}">'
            f'<span class="rp-badge-verdict">{count}</span> {verdict}</a>'
            for verdict, count in counts.items()
        )
        rows.append(
            f'<tr><th scope="row">{escape(title)} <small>{escape(about)}</small>'
            f'</th><td class="rp-text">{links or TO_COME}</td>'
            f'<td class="rp-text"><p class="rp-badges">{badges or "–"}</p></td></tr>'
        )
        told = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
        name = title if key == OURS else about
        lines.append(f"{name}: {told or TO_COME}")
    head = "".join(f'<th scope="col">{name}</th>' for name in HEAD)
    html = html_table("Papers and verdicts", "rp-papers", head, "".join(rows))
    return output(html, "\n".join(lines), *SHEETS)


def holds() -> dict[str, str]:
    """Return what holds of each paper, by its key, and what we found beyond them.

    Raises
    ------
    DamagedFile
        If the file is not what is written there.
    """
    file = records() / HOLDS
    with reading(file, "does not say what holds of the papers"):
        said = tomllib.loads(file.read_text("utf-8"))
        return {key: " ".join(text.split()) for key, text in said.items()}


def explained() -> Shown:
    """Return the verdicts with what each of them means, as a list for who meets them first."""
    html = "".join(
        f'<dt><span class="{style(verdict)}"><span class="rp-badge-verdict">{verdict}</span></span>'
        f"</dt><dd>{escape(means)}</dd>"
        for verdict, means in EXPLAINED.items()
    )
    text = "\n".join(f"{verdict}: {means}" for verdict, means in EXPLAINED.items())
    return output(f'<dl class="rp-verdicts">{html}</dl>', text, *SHEETS)
