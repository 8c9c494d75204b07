"""The scorecard: every recorded claim as a card, by paper, with what a reader can check."""

import inspect
import math
from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path
from string import Formatter

from explorables.figures.output import on_page
from explorables.media import Shown, html_table
from explorables.outputs import output
from robot_perception.teaching.pages.source_pages import address
from robot_perception.teaching.scores.badges import (
    EXPLAINED,
    SHEETS,
    STANDS_ON,
    as_text,
    conditions,
    in_words,
    recorded,
    style,
)
from robot_perception.teaching.scores.papers import PAPERS, paper
from robot_perception.teaching.words.prose import tell
from studies import registration
from studies.claims import Claim
from studies.keys.cells import declared_in
from studies.ledger import Entry, Ledger, Sabotaged, Withdrawn, verdicts
from studies.sentences import with_interval
from studies.verdicts import Accepted, Basis, Origin

TESTS, TEST = "tests.book.test_claims", "test_the_record_says_what_the_rows_say"
"""Module and function that test each claim."""
OURS, BEYOND = "ours", "beyond the paper"
"""Key of our findings, and how the place of their claims begins."""
EXPERIMENTS, MATHEMATICS = "Experiments", "Mathematics: identities, counts and proofs"
"""Kinds of claims."""


def scorecard(claims: Iterable[Claim], titles: Mapping[str, str], said: Mapping[str, str]) -> Shown:
    """Return the recorded claims as cards by paper, with a filter by verdict and by paper.

    Of each paper its experiments come before its mathematics; findings of ours that go beyond the
    papers stand last. Without scripts there is no filter, and all cards are shown.

    Parameters
    ----------
    claims
        The declared claims, whose functions compute what is recorded.
    titles
        Titles of the chapters by stem.
    said
        What holds of each paper, by its key; ``{kalman-roi:.0%}`` stands for the value of a claim.
    """
    ledger, computed = recorded(), {claim.id: claim for claim in claims}
    sections = ""
    for key, groups in grouped(ledger).items():
        cards = "".join(
            f'<div class="rp-claim-group"><p class="rp-claim-kind">{kind}</p>'
            f'<div class="rp-claim-cards">'
            f"{''.join(_card(e, computed[e.id], titles[e.chapter]) for e in entries)}</div></div>"
            for kind, entries in groups.items()
        )
        name = f"{paper(key).citation}: {paper(key).title}" if key in PAPERS else "Findings of ours"
        sections += (
            f'<section aria-labelledby="claims-of-{key}"><h2 id="claims-of-{key}">{escape(name)}'
            f"</h2><p>{escape(_with_values(said.get(key, ''), ledger))}</p>{cards}</section>"
        )
    html = f'<div class="rp-scorecard">{_bar(ledger)}{_filter(ledger)}{sections}</div>'
    return Shown({"text/html": html, "text/plain": as_text(ledger)})


def _with_values(text: str, ledger: Ledger) -> str:
    names = {name for _, name, _, _ in Formatter().parse(text) if name}
    return f"{tell(text, **{name: ledger[name].value.estimate for name in names})}"


def grouped(ledger: Ledger) -> dict[str, dict[str, list[Entry]]]:
    """Return the claims by paper, and what goes beyond them; by kind of claim in each."""
    found: dict[str, dict[str, list[Entry]]] = {key: {} for key in (*PAPERS, OURS)}
    kinds = (EXPERIMENTS, MATHEMATICS)
    for kind, entry in ((kind, entry) for kind in kinds for entry in ledger.entries):
        if (entry.basis == Basis.MATHEMATICS) == (kind == MATHEMATICS):
            key = OURS if entry.place.startswith(BEYOND) else entry.paper
            found[key].setdefault(kind, []).append(entry)
    return {key: groups for key, groups in found.items() if groups}


def withdrawn() -> Shown:
    """Return the claims that were scored and are none of the book any more, as a table."""
    gone = recorded().withdrawn
    head = "".join(f'<th scope="col">{name}</th>' for name in ("Claim", "Gave", "Withdrawn"))
    html = html_table("Withdrawn claims", "rp-papers", head, "".join(map(_gone, gone)))
    lines = [f"{g.id} {g.verdict} {in_words(g.value)}, withdrawn on {g.day}: {g.why}" for g in gone]
    return output(html, "\n".join(lines), *SHEETS)


def _gone(claim: Withdrawn) -> str:
    name, instead = escape(claim.id), escape(claim.instead)
    place = f'; in its place <a href="scorecard.html#{instead}">{instead}</a>' if instead else ""
    return (
        f'<tr id="{name}"><th scope="row">{name} '
        f"<small>{escape(paper(claim.paper).citation)}, {escape(claim.place)}</small></th>"
        f'<td class="rp-text">{escape(claim.statement)} <strong>{escape(claim.verdict)}</strong>, '
        f"{escape(in_words(claim.value))} on {escape(claim.date)}</td>"
        f'<td class="rp-text">{escape(claim.day)}: {escape(claim.why)}{place}</td></tr>'
    )


def registered_again() -> Shown:
    """Return the claims that were registered more than once, with the reason for the last time."""
    last = registration.latest()
    again = [last[e.id] for e in recorded().entries if e.id in last and last[e.id].number > 1]
    head = "".join(f'<th scope="col">{name}</th>' for name in ("Claim", "Times", "Why anew"))
    rows = "".join(
        f'<tr><th scope="row"><a href="scorecard.html#{escape(one.claim)}">{escape(one.claim)}</a>'
        f'</th><td>{one.number}</td><td class="rp-text">{escape(one.day)}: {escape(one.remark)}'
        "</td></tr>"
        for one in again
    )
    html = html_table("Claims that were registered again", "rp-papers", head, rows)
    lines = [f"{one.claim} {one.number} times, last on {one.day}: {one.remark}" for one in again]
    return output(html, "\n".join(lines), *SHEETS)


def _bar(ledger: Ledger) -> str:
    """Return the shares of the verdicts as a bar; the counts stand in words above the cards."""
    parts = "".join(
        f'<span class="{style(verdict, "rp-share")}" style="flex-grow: {count}"></span>'
        for verdict, count in verdicts(ledger).items()
    )
    return f'<div class="rp-shares" aria-hidden="true">{parts}</div>'


def _filter(ledger: Ledger) -> str:
    """Return the form by which a script chooses cards; the script shows it."""
    papers = {entry.paper for entry in ledger.entries}
    by_verdict = [
        (str(verdict), str(verdict), style(verdict, "rp-badge"), EXPLAINED[verdict])
        for verdict in verdicts(ledger)
    ]
    by_paper = [
        (key, paper(key).citation, "rp-badge", paper(key).title) for key in PAPERS if key in papers
    ]
    return (
        '<form class="rp-filter" autocomplete="off" aria-label="Choose claims" hidden>'
        f"{_choices('verdict', by_verdict)}{_choices('paper', by_paper)}"
        '<p><span role="status"></span> <button type="button">Open all</button></p></form>'
    )


def _choices(name: str, options: Iterable[tuple[str, str, str, str]]) -> str:
    every = ("", "all", "rp-badge", "")
    labels = "".join(
        f'<label class="{kind}" title="{escape(title)}"><input type="radio" name="{name}" '
        f'value="{escape(value)}"{"" if value else " checked"}> {escape(text)}</label>'
        for value, text, kind, title in (every, *options)
    )
    return f"<fieldset><legend>{name.capitalize()}</legend>{labels}</fieldset>"


def _card(entry: Entry, claim: Claim, title: str) -> str:
    about = "" if entry.value is None else entry.value.about
    numbers = [("Result", f"{escape(entry.result(verdict=False))} <small>{escape(about)}</small>")]
    if entry.paper_value:
        numbers.insert(0, ("Paper", escape(entry.paper_value)))
    listed = "".join(f"<div><dt>{name}</dt><dd>{text}</dd></div>" for name, text in numbers)
    where = f"{paper(entry.paper).citation}, {entry.place}"
    name, verdict = escape(entry.id), escape(entry.verdict)
    return (
        f'<article class="{style(entry.verdict, "rp-claim")}" id="{name}" '
        f'data-verdict="{verdict}" data-paper="{escape(entry.paper)}" '
        f'aria-labelledby="{name}-says">'
        f'<p class="rp-claim-head"><span class="{style(entry.verdict, "rp-badge")}">'
        f'{verdict}</span> <a href="#{name}">{name}</a> '
        f"<small>{escape(where)}</small></p>"
        f'<h3 id="{name}-says">{escape(entry.statement)}</h3>{conditions(entry)}'
        f'<dl class="rp-claim-numbers">{listed}</dl>{_links(entry, claim, title)}'
        f"<details><summary>How we know<span class='rp-hidden'>: {name}</span>"
        f"</summary>{_details(entry, claim.study.rows().note)}</details></article>"
    )


def _links(entry: Entry, claim: Claim, title: str) -> str:
    """Return where a claim is shown, which cell declares it, and what tests it."""
    name, cell = _declared(claim)
    place = f"book/{cell.replace('[', ', cell ').rstrip(']')}"
    links = [
        ("Shown in", _page(entry.chapter, f"claim-{entry.id}"), title),
        ("Computed by", address(claim.module, name), place),
        ("Tested by", address(TESTS, TEST), f"{TESTS.replace('.', '/')}.py"),
    ]
    items = "".join(
        f'<li>{what} <a href="{escape(page)}">{escape(text)}</a></li>'
        if on_page() or not page.startswith("_")
        else f"<li>{what} {escape(text)}</li>"
        for what, page, text in links
    )
    return f'<ul class="rp-claim-links">{items}</ul>'


def _declared(claim: Claim) -> tuple[str, str]:
    """Return the name of the function that computes a claim, or its own, and the file or cell."""
    if claim.compute is None:
        return declared_in(claim.module, claim.id)
    function = inspect.unwrap(claim.compute)
    return function.__qualname__, Path(inspect.getsourcefile(function) or "").name


def _page(stem: str, name: str = "") -> str:
    """Return the address of a chapter: its page in the book, its file beside a notebook."""
    return f"{stem}.html{name and f'#{name}'}" if on_page() else f"{stem}.ipynb"


def _details(entry: Entry, rows: str) -> str:
    """Return how a claim was measured, what range counts as holding and why, and what else."""
    items = [("Stands on", STANDS_ON[Basis(entry.basis)]), ("Measured", entry.method)]
    if entry.accepted is not None:
        items += [(f"Holds {_range(entry.accepted)}", f"{_origin(entry)} {entry.accepted.why}")]
    items += [(key, str(value)) for key, value in entry.evidence.items()]
    if entry.note:
        items.append(("Note", entry.note))
    items += [("Registered", registration.in_words(entry.id)), ("Rows", rows)]
    items += [
        ("Sabotage", f"The same with {found.text}: {_gave(entry, found)}{found.verdict}")
        for found in entry.sabotages
    ]
    listed = "".join(f"<dt>{escape(key)}</dt><dd>{escape(text)}</dd>" for key, text in items)
    command = f"robot-perception claims --run --claim {entry.id}"
    tables = "".join(
        f"<p>{escape(name[:1].upper() + name[1:])}</p>{table.show().bundle['text/html']}"
        for name, table in entry.tables.items()
    )
    return (
        f"<dl>{listed}<dt>Compute it</dt><dd><code>{escape(command)}</code></dd>"
        f"<dt>Recorded</dt><dd>{escape(entry.date)}: {escape(entry.versions)}</dd></dl>{tables}"
    )


def _gave(entry: Entry, found: Sabotaged) -> str:
    return "" if found.value is None else f"{with_interval(found.value, entry.form)}, "


def _range(accepted: Accepted) -> str:
    low, high = accepted.low, accepted.high
    if low == high:
        return f"at {low:.4g}"
    if math.isinf(low):
        return f"up to {high:.4g}"
    return f"from {low:.4g}" if math.isinf(high) else f"from {low:.4g} to {high:.4g}"


def _origin(entry: Entry) -> str:
    """Return who set the accepted range; for our choice, how far from another verdict it is."""
    if entry.accepted.origin is not Origin.CHOICE:
        return f"Set by {'theory' if entry.accepted.origin is Origin.THEORY else 'the paper'}:"
    if entry.turn is None:
        return "Our choice:"
    ends = "both ends" if entry.turn.end == "both" else f"the {entry.turn.end} end"
    way = "further out" if entry.turn.by > 0 else "further in"
    return f"Our choice (another verdict with {ends} {abs(entry.turn.by):.2g} {way}):"
