"""Badges beside figures, and the claim table of a chapter: views of the ledger."""

from functools import lru_cache
from html import escape

from explorables.media import Shown, html_table
from explorables.outputs import output
from robot_perception.teaching import FRONT_END
from robot_perception.teaching.scores.papers import paper
from studies.intervals import Interval
from studies.ledger import Entry, Ledger, verdicts
from studies.records import records
from studies.verdicts import Basis, Verdict

SHEETS = (FRONT_END / "badge.css", "table.css")
"""Style sheets of badges and tables. Tables of results bring no sheet: tests compare their HTML."""

EXPLAINED = {
    Verdict.REPRODUCED: "the whole interval of our number lies inside the stated range",
    Verdict.CONDITIONAL: "the claim holds under a condition that is named, and was seen to fail "
    "without it",
    Verdict.REFUTED: "our number lies outside the range, by mathematics or on the paper's own "
    "terms",
    Verdict.NOT_REPRODUCED: "our number lies outside the range, but a substitute stands in for "
    "the paper's own world",
    Verdict.INCONCLUSIVE: "our interval lies partly inside the range and partly outside",
    Verdict.ILLUSTRATED: "the paper gives no number; ours stands beside its words",
    Verdict.UNTESTABLE: "nothing could be measured",
}
"""Meaning of each verdict, for a reader."""

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
    """Return the badges of claims, each with its result: verdict, name, place, and a sentence.

    Raises
    ------
    KeyError
        If the ledger has no such claim.
    """
    entries = [recorded()[claim_id] for claim_id in claim_ids]
    html = "\n".join(f"<li>{_badge(entry)} {_result(entry)}</li>" for entry in entries)
    text = "\n".join(f"{e.id} ({e.place}): {e.result()}" for e in entries)
    return output(f'<ul class="rp-badges rp-said">{html}</ul>', text, *SHEETS)


def _result(entry: Entry) -> str:
    words = escape(entry.result(verdict=False))
    return f'<span class="rp-badge-result">{words}</span>{conditions(entry)}'


def _badge(entry: Entry) -> str:
    title, name = f"{entry.statement} {entry.note}".strip(), escape(entry.id)
    return (
        f'<a class="{style(entry.verdict)}" id="claim-{name}" href="scorecard.html#{name}" '
        f'title="{escape(title)}"><span class="rp-badge-verdict">{escape(entry.verdict)}</span> '
        f'<span class="rp-badge-id">{name}</span> '
        f'<span class="rp-badge-place">{escape(entry.place)}</span></a>'
    )


def score() -> Shown:
    """Return how many claims have which verdict, as one line of badges."""
    counts = verdicts(recorded())
    html = " ".join(
        f'<span class="{style(v)}" title="{EXPLAINED[v]}">'
        f'<span class="rp-badge-verdict">{count}</span> {v}</span>'
        for v, count in counts.items()
    )
    text = ", ".join(f"{count} {v}" for v, count in counts.items())
    return output(f'<p class="rp-badges">{html}</p>', text, *SHEETS)


def claim_table(chapter: str) -> Shown:
    """Return the claims of a chapter as a table; each leads to its card on the scorecard.

    Raises
    ------
    ValueError
        If the ledger has no claim of that chapter.
    """
    ledger = recorded().chapter(chapter)
    if not ledger.entries:
        raise ValueError(f"the ledger has no claim of chapter {chapter!r}")
    rows = "\n".join(map(_row, ledger.entries))
    head = "".join(f'<th scope="col">{name}</th>' for name in ("Claim", "Result", "Verdict"))
    html = html_table("Claims and verdicts", "rp-claims", head, rows)
    return output(html, as_text(ledger), *SHEETS)


def _row(entry: Entry) -> str:
    name, about = escape(entry.id), "" if entry.value is None else entry.value.about
    return (
        f'<tr><th scope="row"><a href="scorecard.html#{name}">{name}</a> '
        f"<small>{escape(paper(entry.paper).citation)}, {escape(entry.place)}</small>"
        f"<p>{escape(entry.statement)}</p>{conditions(entry)}</th>"
        f'<td class="rp-text">{escape(entry.result(verdict=False))}'
        f"<br><small>{escape(about)}</small></td>"
        f'<td><span class="{style(entry.verdict)}">{escape(entry.verdict)}</span></td></tr>'
    )


def conditions(entry: Entry) -> str:
    """Return the lines that say on what a claim depends."""
    return "".join(
        f'<p class="rp-condition">Only if {escape(text)}.</p>' for text in entry.conditions
    )


def style(verdict: str, kind: str = "rp-badge") -> str:
    """Return the classes of something that is coloured by a verdict."""
    return f"{kind} rp-badge--{escape(verdict.replace(' ', '-'))}"


def in_words(value: Interval | None) -> str:
    """Return a value with its interval and unit, a dash if there is none."""
    return "–" if value is None else str(value)


def as_text(ledger: Ledger) -> str:
    """Return the ledger as a table for a terminal."""
    rows = [("claim", "verdict", "paper", "ours", "conditions")]
    for entry in ledger.entries:
        told = (entry.paper_value or "–", in_words(entry.value), "; ".join(entry.conditions) or "–")
        rows.append((entry.id, entry.verdict, *told))
    widths = [max(len(row[i]) for row in rows) for i in range(4)]
    lines = [
        "  ".join([*(c.ljust(w) for c, w in zip(row[:4], widths, strict=True)), row[4]])
        for row in rows
    ]
    lines.insert(1, "  ".join("-" * width for width in [*widths, 10]))
    return "\n".join(line.rstrip() for line in lines)
