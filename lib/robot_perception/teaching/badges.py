"""Badges beside figures, the claim table of a chapter, and the scorecard: views of the ledger."""

import math
from functools import lru_cache
from html import escape

from robot_perception.evaluation.intervals import Interval
from robot_perception.teaching.ledger import Entry, Ledger, verdicts
from robot_perception.teaching.media import Shown
from robot_perception.teaching.outputs import output
from robot_perception.teaching.records import records
from robot_perception.teaching.verdicts import Accepted, Basis, Origin, Verdict

SHEETS = ("badge.css", "table.css")
"""What badges and tables look like. Tables of results bring no sheet: tests compare their HTML."""

EXPLAINED = {
    Verdict.REPRODUCED: "the whole interval of our number lies inside the stated range",
    Verdict.CONDITIONAL: "holds in the part of the domain that is named, and was seen to fail "
    "outside it",
    Verdict.REFUTED: "our number lies outside, by mathematics or on the paper's own terms",
    Verdict.NOT_REPRODUCED: "our number lies outside the range, but something stands in for the "
    "paper's own",
    Verdict.INCONCLUSIVE: "our interval lies partly inside the range and partly outside",
    Verdict.ILLUSTRATED: "the paper gives no number; ours stands beside its words",
    Verdict.UNTESTABLE: "needs what nobody has",
}
"""What each verdict means, for a reader."""

STANDS_ON = {
    Basis.MATHEMATICS: "mathematics",
    Basis.PAPER: "the paper's own terms",
    Basis.SUBSTITUTE: "a substitute for the paper's world",
}


@lru_cache(maxsize=1)
def recorded() -> Ledger:
    """Return the recorded ledger of the book."""
    return Ledger.read(records() / "claims.json")


def badges(*claim_ids: str) -> Shown:
    """Return the badges of claims: verdict, name, place in the paper and our value.

    Raises
    ------
    KeyError
        If the ledger has no such claim.
    """
    entries = [recorded()[claim_id] for claim_id in claim_ids]
    html = "\n".join(_badge(entry) for entry in entries)
    text = "\n".join(f"{e.id}: {e.verdict} ({e.place}; ours {_value(e)})" for e in entries)
    return output(f'<p class="rp-badges">{html}</p>', text, *SHEETS)


def _badge(entry: Entry) -> str:
    title = f"{entry.statement} {entry.note}".strip()
    return (
        f'<a class="{_style(entry.verdict)}" href="scorecard.html#{entry.id}" '
        f'title="{escape(title)}"><span class="rp-badge-verdict">{entry.verdict}</span> '
        f'<span class="rp-badge-id">{escape(entry.id)}</span> '
        f'<span class="rp-badge-place">{escape(entry.place)}</span></a>'
    )


def score() -> Shown:
    """Return how many claims have which verdict, as one line of badges."""
    counts = verdicts(recorded())
    html = " ".join(
        f'<span class="{_style(v)}" title="{EXPLAINED[v]}">'
        f'<span class="rp-badge-verdict">{count}</span> {v}</span>'
        for v, count in counts.items()
    )
    text = ", ".join(f"{count} {v}" for v, count in counts.items())
    return output(f'<p class="rp-badges">{html}</p>', text, *SHEETS)


def claim_table(chapter: str | None = None) -> Shown:
    """Return the ledger of one chapter, or of the whole book, as a table.

    Raises
    ------
    ValueError
        If the ledger has no claim of that chapter.
    """
    ledger = recorded() if chapter is None else recorded().chapter(chapter)
    if not ledger.entries:
        raise ValueError(f"the ledger has no claim of chapter {chapter!r}")
    rows = "\n".join(_row(entry, anchor=chapter is None) for entry in ledger.entries)
    head = "".join(f'<th scope="col">{name}</th>' for name in ("Claim", "Ours", "Verdict"))
    html = (
        '<div class="rp-table" role="region" tabindex="0" aria-label="Claims and verdicts">'
        f'<table class="rp-claims"><thead><tr>{head}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )
    return output(html, as_text(ledger), *SHEETS)


def _row(entry: Entry, *, anchor: bool) -> str:
    name = f' id="{entry.id}"' if anchor else ""
    page = f"{entry.chapter}.html" if anchor else f"scorecard.html#{entry.id}"
    paper = f"<br><small>Paper: {escape(entry.paper_value)}</small>" if entry.paper_value else ""
    conditions = "".join(f"<p>Only if {escape(text)}.</p>" for text in entry.conditions)
    return (
        f'<tr{name}><th scope="row"><a href="{page}">{escape(entry.id)}</a> '
        f"<small>{escape(entry.paper)}, {escape(entry.place)}</small>"
        f"<p>{escape(entry.statement)}{paper}</p>"
        f"<details><summary>How we know<span class='rp-hidden'>: {escape(entry.id)}</span>"
        f"</summary>{_details(entry)}</details></th>"
        f"<td>{escape(_value(entry))}<br><small>{escape(_about(entry))}</small></td>"
        f'<td><span class="{_style(entry.verdict)}">{entry.verdict}</span>'
        f"{conditions}</td></tr>"
    )


def _details(entry: Entry) -> str:
    """Return how a claim was measured, what range counts as holding and why, and what else."""
    items = [("Stands on", STANDS_ON[Basis(entry.basis)]), ("Measured", entry.method)]
    if entry.accepted is not None:
        items += [(f"Holds {_range(entry.accepted)}", f"{_origin(entry)} {entry.accepted.why}")]
    items += [(key, str(value)) for key, value in entry.evidence.items()]
    if entry.note:
        items.append(("Note", entry.note))
    items += [
        ("Sabotage", f"The same with {found.text}: {_number(found.value)}, {found.verdict}")
        for found in entry.sabotages
    ]
    listed = "".join(f"<dt>{escape(key)}</dt><dd>{escape(text)}</dd>" for key, text in items)
    tables = "".join(
        f"<p>{escape(name[:1].upper() + name[1:])}</p>{table.show().bundle['text/html']}"
        for name, table in entry.tables.items()
    )
    return f"<dl>{listed}</dl>{tables}"


def _style(verdict: str) -> str:
    return f"rp-badge rp-badge--{verdict.replace(' ', '-')}"


def _value(entry: Entry) -> str:
    return _number(entry.value)


def _number(value: Interval | None) -> str:
    return "–" if value is None else str(value)


def _about(entry: Entry) -> str:
    return "" if entry.value is None else entry.value.about


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


def as_text(ledger: Ledger) -> str:
    """Return the ledger as a table for a terminal."""
    rows = [("claim", "verdict", "paper", "ours", "conditions")]
    for entry in ledger.entries:
        conditions = "; ".join(entry.conditions) or "–"
        rows.append((entry.id, entry.verdict, entry.paper_value or "–", _value(entry), conditions))
    widths = [max(len(row[i]) for row in rows) for i in range(4)]
    lines = [
        "  ".join([*(c.ljust(w) for c, w in zip(row[:4], widths, strict=True)), row[4]])
        for row in rows
    ]
    lines.insert(1, "  ".join("-" * width for width in [*widths, 10]))
    return "\n".join(line.rstrip() for line in lines)
