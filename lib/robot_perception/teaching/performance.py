"""The recorded benchmark table."""

import json
from html import escape

from robot_perception.teaching.media import Shown
from robot_perception.teaching.records import records


def performance_table() -> Shown:
    """Return the recorded benchmarks as a table, with machine, date and versions above it.

    Raises
    ------
    FileNotFoundError
        If no benchmark was recorded; `make bench` records one.
    """
    record = json.loads((records() / "performance.json").read_text(encoding="utf-8"))
    versions = ", ".join(f"{name} {number}" for name, number in record["versions"].items())
    head = "".join(
        f'<th scope="col">{name}</th>'
        for name in ("Work", "Ours", "Peer", "Ratio", "Must reach", "Reached")
    )
    html = (
        f"<p>Measured {record['date']} on {escape(record['machine'])}, one thread; "
        f"{escape(versions)}.</p>"
        '<div class="rp-table" role="region" tabindex="0" aria-label="Benchmarks">'
        f'<table class="rp-performance"><thead><tr>{head}</tr></thead><tbody>'
        f"{''.join(_row(row) for row in record['rows'])}</tbody></table></div>"
    )
    reached = sum(row["reached"] for row in record["rows"])
    text = f"{reached} of {len(record['rows'])} targets reached on {record['date']}"
    return Shown({"text/html": html, "text/plain": text})


def _row(row: dict) -> str:
    peer = "–" if row["peer_s"] is None else f"{escape(row['peer'])}, {duration(row['peer_s'])}"
    ratio = "–" if row["ratio"] is None else times(row["ratio"])
    reached = "yes" if row["reached"] else "<strong>no</strong>"
    return (
        f'<tr><th scope="row">{escape(row["work"])}</th><td>{duration(row["ours_s"])}</td>'
        f"<td>{peer}</td><td>{ratio}</td><td>{escape(row['target'])}</td><td>{reached}</td></tr>"
    )


def duration(seconds: float) -> str:
    """Return a duration in the unit that suits it, three digits.

    Examples
    --------
    >>> duration(3.7e-6)
    '3.7 µs'
    """
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("µs", 1e6)):
        if seconds * factor >= 1:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def times(ratio: float) -> str:
    """Return a ratio with at least three digits, never as a power of ten.

    Examples
    --------
    >>> times(1114.2), times(9.968)
    ('1114×', '9.97×')
    """
    return f"{ratio:.0f}×" if ratio >= 100 else f"{ratio:.3g}×"
