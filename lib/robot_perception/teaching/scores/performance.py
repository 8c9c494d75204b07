"""The recorded benchmarks: one picture of the ratios, one of the explorers, tables by theme."""

import json
import re
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from explorables.figures.style import BLUE, FAINT, INK, MUTED, ORANGE, RED, figure
from explorables.media import Shown, html_table
from robot_perception.checks import one_of
from studies.files import reading, written
from studies.keys.dependencies import hashed
from studies.records import records
from studies.tables import Table

THEMES = {
    "monobot": "The robot on a line",
    "planar": "Planar EKF-SLAM",
    "simplify": "Simplifying a line",
    "path": "Simplifying a line",
    "landmarks": "Pictures",
    "Rao-Blackwellised": "Particles",
    "resampling": "Particles",
    "covariance": "Fusion and people",
    "people": "Fusion and people",
    "colour": "Pictures",
    "scores": "Pictures",
    "head": "Pictures",
    "affine": "Pictures",
    "segmentation": "Pictures",
    "blob": "Pictures",
    "pattern": "Patterns on a ceiling",
    "ceiling": "Patterns on a ceiling",
    "tutor": "The tutor",
    "arms": "Two arms",
}
"""Themes by the first word of the work that belongs to them, in the order of the page."""
ORDER = tuple(dict.fromkeys(THEMES.values()))

MEDIA = {"in JupyterLab": ("In Jupyter", ORANGE), "built page": ("On the page", BLUE)}
"""Media in which a control is moved, as recorded, with words and colour."""

MOVES = re.compile(
    rf"(?P<page>\w+), (?P<control>.+), (?P<medium>{'|'.join(MEDIA)}) "
    r"\((?P<moves>\d+) moves, longest (?P<longest>\d+) ms\)"
)
LEAST = re.compile(r"≥ (?P<ratio>[\d.]+)×")
MOST = re.compile(r"median ≤ (?P<median>[\d.]+) ms")
OWN = frozenset({
    "as written", "full count, compiled", "line by line", "names that all particles share", "NumPy",
    "NumPy gather", "ours, Euclidean", "the same in NumPy", "the textbook version in Python",
    "whole images",
})  # fmt: skip
"""Peers that are plain versions of our own, and no package of others."""
FILE = "performance.json"
"""Name of the record."""
LINE = 46
"""Characters of a line in the pictures, so that it can be read on a telephone."""
INCHES = 0.19
"""Height of a line in the pictures."""


@dataclass(frozen=True, slots=True)
class Work:
    """A row of the benchmark: a piece of work, and a peer that does the same, with medians in s."""

    work: str
    ours_s: float
    peer_s: float | None
    peer: str  # empty if there is none
    target: str  # what must be reached, in words, a dash for nothing
    reached: bool

    @property
    def theme(self) -> str:
        """The theme that the work belongs to; a new one needs a name in `THEMES`."""
        return THEMES[one_of("first word of the work", self.work.split()[0], THEMES)]

    @property
    def ratio(self) -> float | None:
        """Time of the peer over ours."""
        return None if self.peer_s is None else self.peer_s / self.ours_s

    @property
    def least(self) -> float | None:
        """The ratio that must be reached, ``None`` if there is none."""
        found = LEAST.match(self.target)
        return found and float(found["ratio"])


@dataclass(frozen=True, slots=True)
class Latency:
    """Time that a control of an explorer takes to move its picture in a medium, one of `MEDIA`."""

    page: str
    control: str
    medium: str
    median_ms: float
    longest_ms: float
    target_ms: float  # of the median
    target: str  # in words, as recorded
    reached: bool


@dataclass(frozen=True, slots=True)
class Record:
    """The recorded benchmarks: when and where, and what."""

    date: str
    machine: str
    versions: str
    work: tuple[Work, ...]
    latencies: tuple[Latency, ...]
    reached: int

    @classmethod
    def read(cls) -> "Record":
        """Return what `make bench` has recorded.

        Raises
        ------
        DamagedFile
            If it is not what was recorded there.
        """
        file = records() / FILE
        with reading(file, "no record of benchmarks"):
            return cls._of(_recorded(file))

    @classmethod
    def _of(cls, plain: dict[str, Any]) -> "Record":
        rows = [{k: v for k, v in row.items() if k != "ratio"} for row in plain["rows"]]
        matched = [(row, MOVES.fullmatch(row["work"])) for row in rows]
        return cls(
            date=plain["date"],
            machine=plain["machine"],
            versions=", ".join(f"{name} {number}" for name, number in plain["versions"].items()),
            work=tuple(Work(**row) for row, moves in matched if moves is None),
            latencies=tuple(_latency(row, moves) for row, moves in matched if moves),
            reached=sum(row["reached"] for row in rows),
        )

    def find(self, start: str) -> Work:
        """Return the piece of work whose name begins so.

        Raises
        ------
        LookupError
            If there is none.
        """
        for work in self.work:
            if work.work.startswith(start):
                return work
        raise LookupError(f"performance.json has no row {start!r}; `make bench` records one")

    def about(self) -> Shown:
        """Return where and when was measured, and how many targets were reached."""
        rows = len(self.work) + len(self.latencies)
        text = f"{self.reached} of {rows} targets reached on {self.date}"
        where = f"{text}, on {self.machine}, one thread; {self.versions}."
        html = f"<p>{escape(where)}</p>"
        return Shown({"text/html": html, "text/plain": text})

    @property
    def peers(self) -> tuple[int, int]:
        """Numbers of comparisons with packages of others, and with plain versions of ours."""
        own = [work.peer in OWN for work in self.work if work.ratio is not None]
        return own.count(False), own.count(True)

    def missed(self) -> Shown:
        """Return a table of all targets that were missed: work first, then explorers by page."""
        rows = [
            (work.work, work.theme, _measured(work), _goal(work))
            for work in self.work
            if not work.reached
        ]
        rows += [
            (
                latency.control,
                f"{latency.page.replace('_', ' ')}, {MEDIA[latency.medium][0]}",
                f"median {latency.median_ms:.0f} ms, longest {latency.longest_ms:.0f} ms",
                latency.target,
            )
            for latency in sorted(self.latencies, key=lambda x: x.page)
            if not latency.reached
        ]
        names = ("Where", "Measured", "Target")
        head = "".join(f'<th scope="col">{name}</th>' for name in ("Missed", *names))
        body = "".join(
            f'<tr><th scope="row">{escape(what)}</th>'
            + "".join(
                f'<td data-name="{name}">{escape(text)}</td>'
                for name, text in zip(names, texts, strict=True)
            )
            + "</tr>"
            for what, *texts in rows
        )
        text = "\n".join(
            f"{what} ({where}): {got}; wanted {goal}" for what, where, got, goal in rows
        )
        html = html_table("targets that were missed", "rp-performance rp-missed", head, body)
        return Shown({"text/html": html, "text/plain": text})

    def themes(self) -> Table:
        """Return how many pieces of work each theme has, and how many of them have a peer."""
        by_theme = {theme: [w for w in self.work if w.theme == theme] for theme in ORDER}
        rows = {
            theme: (len(work), sum(w.ratio is not None for w in work))
            for theme, work in by_theme.items()
        }
        columns = {"work": "pieces that are timed", "with a peer": "that does the same"}
        return Table(rows, columns, corner="theme")

    def tables(self) -> Shown:
        """Return the work as tables, one a theme."""
        html = "".join(
            f"<h3>{escape(theme)}</h3>{_table(theme, [w for w in self.work if w.theme == theme])}"
            for theme in ORDER
        )
        text = "\n".join(f"{work.work}: {_told(work)}" for work in self.work)
        return Shown({"text/html": html, "text/plain": text})


def rows() -> list[dict[str, Any]]:
    """Return the recorded rows as they stand in the file.

    Raises
    ------
    DamagedFile
        If they are not what was recorded there.
    """
    file = records() / FILE
    with reading(file, "no record of benchmarks"):
        return _recorded(file)["rows"]


def write(plain: Mapping[str, Any], file: Path) -> None:
    """Record benchmarks, with the hash that says later that nobody has changed a number."""
    text = json.dumps({"content": _content(plain), **plain}, indent=1, ensure_ascii=False)
    with written(file) as beside:
        beside.write_text(f"{text}\n", encoding="utf-8")


def _recorded(file: Path) -> dict[str, Any]:
    plain = json.loads(file.read_text(encoding="utf-8"))
    said = plain.pop("content")
    if said != _content(plain):
        raise ValueError(
            "its numbers are not those that were measured: get the file of the release back (`git "
            "checkout`, or install the package anew), or measure them with `make bench`"
        )
    return plain


def _content(plain: Mapping[str, Any]) -> str:
    return hashed(json.dumps(plain, sort_keys=True))


def _latency(row: dict, moves: re.Match[str]) -> Latency:
    return Latency(
        page=moves["page"],
        control=moves["control"],
        medium=moves["medium"],
        median_ms=row["ours_s"] * 1e3,
        longest_ms=float(moves["longest"]),
        target_ms=float(MOST.match(row["target"])["median"]),
        target=row["target"],
        reached=row["reached"],
    )


def _measured(work: Work) -> str:
    ratio = "" if work.ratio is None else f", {times(work.ratio)}"
    return f"{duration(work.ours_s)}{ratio}"


def _goal(work: Work) -> str:
    if work.least is None:
        return _short(work.target)
    return f"≥ {times(work.least)} {work.peer}"


def _short(target: str) -> str:
    """Return a target with no more than three digits of a broken number."""
    return re.sub(r"\d+\.\d+", lambda number: f"{float(number[0]):.3g}", target)


def _told(work: Work) -> str:
    against = "" if work.ratio is None else f", {times(work.ratio)} against {work.peer}"
    return f"{duration(work.ours_s)}{against}"


def _table(theme: str, rows: list[Work]) -> str:
    head = "".join(
        f'<th scope="col">{name}</th>' for name in ("Work", "Ours", "Peer", "Ratio", "Target")
    )
    return html_table(theme, "rp-performance", head, "".join(map(_row, rows)))


def _row(work: Work) -> str:
    peer = "–" if work.peer_s is None else f"{escape(work.peer)}, {duration(work.peer_s)}"
    ratio = "–" if work.ratio is None else times(work.ratio)
    target = _short(work.target) if work.least is None else f"≥ {times(work.least)}"
    missed = "" if work.reached else " <strong>missed</strong>"
    cells = ("Ours", duration(work.ours_s)), ("Peer", peer), ("Ratio", f"<strong>{ratio}</strong>")
    shown = "".join(f'<td data-name="{name}">{text}</td>' for name, text in cells)
    return (
        f'<tr><th scope="row">{escape(work.work)}</th>{shown}'
        f'<td data-name="Target">{escape(target)}{missed}</td></tr>'
    )


def draw_ratios(record: Record) -> Figure:
    """Return the picture of all ratios to peers, by theme, with the targets."""
    compared = [work for work in record.work if work.ratio is not None]
    strips = _Strips(
        {
            theme: [(f"{w.work}, against {w.peer}", w) for w in compared if w.theme == theme]
            for theme in ORDER
        }
    )
    fig, ax = strips.axes("time of the peer over ours")
    for height, work in strips.rows:
        colour = BLUE if work.reached else RED
        ax.plot([1, work.ratio], [height, height], color=colour, linewidth=1.6)
        ax.plot([work.ratio], [height], "o", color=colour, markersize=6)
        if work.least is not None:
            ax.plot([work.least], [height], "|", color=ORANGE, markersize=12, markeredgewidth=2.4)
        end = max(work.ratio, work.least or 1, 1)
        beside = {"textcoords": "offset points", "va": "center", "fontweight": "bold"}
        ax.annotate(times(work.ratio), (end, height), xytext=(8, 0), color=colour, **beside)
    _decades(ax, [value for w in compared for value in (w.ratio, w.least or w.ratio, 1)], 0.5, 8)
    ax.xaxis.set_major_formatter(lambda value, _: f"{value:g}×")
    return fig


def draw_latencies(record: Record) -> Figure:
    """Return the picture of how fast each explorer follows its first control, in both media."""
    groups: dict[str, dict[str, list[Latency]]] = {}
    for latency in record.latencies:
        rows = groups.setdefault(latency.page.replace("_", " "), {})
        rows.setdefault(latency.control, []).append(latency)
    strips = _Strips({page: list(rows.items()) for page, rows in groups.items()})
    fig, ax = strips.axes("from the move to the new picture (ms)")
    for height, latencies in strips.rows:
        for latency in latencies:
            _, colour = MEDIA[latency.medium]
            ends = latency.median_ms, max(latency.longest_ms, latency.median_ms)
            ax.plot(ends, [height, height], color=colour, linewidth=1.6)
            ax.plot(ends[:1], [height], "o", color=colour, markersize=6)
            if not latency.reached:
                ring = {"markersize": 11, "markeredgewidth": 1.8, "fillstyle": "none"}
                ax.plot(ends[:1], [height], "o", color=RED, **ring)
    for medium, (words, colour) in MEDIA.items():
        target = max(x.target_ms for x in record.latencies if x.medium == medium)
        ax.axvline(target, color=colour, linewidth=1, linestyle=(0, (4, 3)))
        ax.plot([], [], "o-", color=colour, label=f"{words}, ≤ {target:g} ms")
    ends = [value for x in record.latencies for value in (x.median_ms, x.longest_ms, x.target_ms)]
    _decades(ax, ends, 0.8, 1.3)
    ax.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    return fig


class _Strips:
    """Rows of a picture, each with its words above it, by heading: so they fit a telephone."""

    def __init__(self, groups: dict[str, list[tuple[str, Any]]]) -> None:
        self.words: list[tuple[float, str, bool]] = []
        self.rows: list[tuple[float, Any]] = []
        height = 0.0
        for heading, rows in groups.items():
            self.words.append((height := height + 1.2, heading, True))
            for text, content in rows:
                for line in textwrap.wrap(text, LINE):
                    self.words.append((height := height + 1.0, line, False))
                self.rows.append((height := height + 1.0, content))
                height += 0.3
        self.end = height + 0.6

    def axes(self, name: str) -> tuple[Figure, Axes]:
        """Return a figure as high as the rows, with their words and a logarithmic axis."""
        height = INCHES * self.end + 1.0
        fig, ax = figure(width=4.6, height=height, gridspec_kw={"left": 0.03, "right": 0.97})
        ax.set_xscale("log")
        ax.set_ylim(self.end, 0)
        ax.set_yticks([])
        ax.spines["left"].set_visible(False)
        ax.grid(axis="x", color=FAINT)
        ax.set_xlabel(name)
        across = ax.get_yaxis_transform()
        for place, text, heading in self.words:
            colour, weight = (INK, "bold") if heading else (MUTED, "normal")
            style = {"color": colour, "fontsize": 9.5, "fontweight": weight, "va": "center"}
            ax.text(0, place, text, transform=across, **style)
        return fig, ax


def _decades(ax: Axes, values: list[float], below: float, above: float) -> None:
    """Let a logarithmic axis reach from below the least value to above the largest."""
    ax.set_xlim(min(values) * below, max(values) * above)


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
