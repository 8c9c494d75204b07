"""Badges beside figures, the claim table of a chapter, and the scorecard: views of the ledger."""

from collections import Counter
from functools import lru_cache
from html import escape

from robot_perception.teaching.claims import Entry, Interval, Ledger, Verdict
from robot_perception.teaching.media import Shown
from robot_perception.teaching.records import records

EXPLAINED = {
    Verdict.REPRODUCED: "our number or shape lies inside the stated range",
    Verdict.CONDITIONAL: "holds only under the conditions named",
    Verdict.REFUTED: "the opposite holds, with evidence",
    Verdict.ILLUSTRATED: "the paper gives no number; ours stands beside its words",
    Verdict.UNTESTABLE: "needs what nobody has",
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
    text = "\n".join(f"{e.id}: {e.verdict} ({e.place}; ours {e.interval})" for e in entries)
    return Shown({"text/html": f'<p class="rp-badges">{html}</p>', "text/plain": text})


def _badge(entry: Entry) -> str:
    title = f"{entry.statement} {entry.note}".strip()
    return (
        f'<a class="rp-badge rp-badge--{entry.verdict}" href="scorecard.html#{entry.id}" '
        f'title="{escape(title)}"><span class="rp-badge-verdict">{entry.verdict}</span> '
        f'<span class="rp-badge-id">{escape(entry.id)}</span> '
        f'<span class="rp-badge-place">{escape(entry.place)}</span></a>'
    )


def score() -> Shown:
    """Return how many claims have which verdict, as one line of badges."""
    counts = Counter(entry.verdict for entry in recorded().entries)
    shown = [v for v in Verdict if counts[v]]
    html = " ".join(
        f'<span class="rp-badge rp-badge--{v}" title="{EXPLAINED[v]}">'
        f'<span class="rp-badge-verdict">{counts[v]}</span> {v}</span>'
        for v in shown
    )
    text = ", ".join(f"{counts[v]} {v}" for v in shown)
    return Shown({"text/html": f'<p class="rp-badges">{html}</p>', "text/plain": text})


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
    return Shown({"text/html": html, "text/plain": as_text(ledger)})


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
        f"<td>{escape(str(entry.interval))}<br><small>{escape(entry.interval.about)}</small></td>"
        f'<td><span class="rp-badge rp-badge--{entry.verdict}">{entry.verdict}</span>'
        f"{conditions}</td></tr>"
    )


def _details(entry: Entry) -> str:
    """Return how a claim was measured, what range counts as holding and why, and what else."""
    items = [("Measured", entry.method)]
    if entry.accepted is not None:
        items.append((f"Holds {_range(entry.accepted)}", entry.accepted_why))
    items += [(key, str(Interval(**value))) for key, value in entry.evidence.items()]
    if entry.note:
        items.append(("Note", entry.note))
    return "<dl>{}</dl>".format(
        "".join(f"<dt>{escape(key)}</dt><dd>{escape(text)}</dd>" for key, text in items)
    )


def _range(ends: list[float | None]) -> str:
    low, high = ends
    if low is None or high is None:
        return f"up to {high:.4g}" if low is None else f"from {low:.4g}"
    return f"at {low:.4g}" if low == high else f"from {low:.4g} to {high:.4g}"


def as_text(ledger: Ledger) -> str:
    """Return the ledger as a table for a terminal."""
    rows = [("claim", "verdict", "paper", "ours", "conditions")]
    for entry in ledger.entries:
        conditions = "; ".join(entry.conditions) or "–"
        rows.append(
            (entry.id, entry.verdict, entry.paper_value or "–", str(entry.interval), conditions)
        )
    widths = [max(len(row[i]) for row in rows) for i in range(4)]
    lines = [
        "  ".join([*(c.ljust(w) for c, w in zip(row[:4], widths, strict=True)), row[4]])
        for row in rows
    ]
    lines.insert(1, "  ".join("-" * width for width in [*widths, 10]))
    return "\n".join(line.rstrip() for line in lines)
