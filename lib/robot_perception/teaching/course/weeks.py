"""A course made of the book's pages: what a class reads, bets on, changes and hands in, by week."""

import ast
import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from html import escape, unescape
from itertools import zip_longest
from pathlib import Path

from docutils.nodes import make_id

from explorables.media import Shown, html_table, with_mathematics
from explorables.outputs import output
from robot_perception.teaching import FRONT_END
from robot_perception.teaching.course.copies import PROSE, Asked, asked, counted
from robot_perception.teaching.pages.contents import EXERCISE, Contents, Page, read
from robot_perception.teaching.pages.paths import linked, named
from studies.files import reading
from studies.keys.cells import folder
from studies.records import records

COURSE = "course.toml"
"""Name of the file in which it is written down."""
CLASS_MINUTES = 90
MOST = 240
"""Minutes that a week may ask for at home, before the class and after it."""
SENTENCES = 10
"""Minutes of an answer in sentences."""

_TRY = re.compile(r"^\*Try it\.\* (.+(?:\n(?!\n).+)*)", re.M)
_LINK = re.compile(r"\[([^]]*)\]\([^)]*\)")
_TAG = re.compile(r"<[^>]+>")
_HEADING = re.compile(r"^#{2,4} (.+)$", re.M)
_SCEPTIC = re.compile(
    r"^### (.+ \(prose\))$(?=(?:(?!^###? ).*\n?)*?:::\{dropdown\} What a good)", re.M
)


@dataclass(frozen=True)
class Week:
    """A week of the course.

    Parameters
    ----------
    read
        Stems of the pages to read before the class.
    after
        Stems of those that nobody opens before; that of the bet is one.
    bet
        The bet that opens the class, as ``stem.NAME``; empty in a week of the project.
    study
        The study that is changed in class, as ``stem.name``.
    hand_in
        Keys of the exercises to hand in.
    sceptic
        The question that is answered in sentences: the stem of the page that asks it, or itself.
    minutes
        What the class does, and for how long; the course's usual plan if empty.
    """

    read: tuple[str, ...]
    after: tuple[str, ...] = ()
    bet: str = ""
    study: str = ""
    hand_in: tuple[str, ...] = ()
    sceptic: str = ""
    minutes: Mapping[str, int] = field(default_factory=dict)

    def before(self, contents: Contents) -> float:
        """Return the minutes of what is read before the class."""
        return sum(contents.pages[stem].minutes(exercises=False) for stem in self.read)

    def later(self, contents: Contents) -> float:
        """Return the minutes of what is read after the class, with what is handed in."""
        reading = sum(contents.pages[stem].minutes(exercises=False) for stem in self.after)
        return reading + EXERCISE * len(self.hand_in) + SENTENCES * bool(self.sceptic)

    def points(self, contents: Contents) -> int:
        """Return the points of all that is handed in."""
        asked = sum(exercise(contents, key)[1].points for key in self.hand_in)
        return asked + PROSE * bool(self.sceptic)


@cache
def weeks(file: Path | None = None) -> tuple[Week, ...]:
    """Read the weeks of the course.

    Raises
    ------
    ValueError
        If the file is no plan of a course.
    """
    file = file or records() / COURSE
    with reading(file, "is no plan of a course"):
        plan = tomllib.loads(file.read_text("utf-8"))
        found = []
        for entry in plan["week"]:
            values = {k: tuple(v) if isinstance(v, list) else v for k, v in entry.items()}
            found.append(Week(**{"minutes": plan["class"]} | values))
    return tuple(found)


def question(page: Page, name: str) -> str:
    """Return what a bet of a page asks.

    Raises
    ------
    ValueError
        If the page has no bet of that name.
    """
    for node in ast.walk(ast.parse(page.source[1])):
        if isinstance(node, ast.Assign) and [getattr(t, "id", "") for t in node.targets] == [name]:
            asks = node.value.args[0] if isinstance(node.value, ast.Call) else None
            if name in page.bets and isinstance(asks, ast.Constant):
                return asks.value
    raise ValueError(f"{page.stem} has no bet {name!r}; it has {', '.join(page.bets) or 'none'}")


def tried(page: Page, study: str) -> tuple[str, str]:
    """Return the heading above the line "Try it" of a study, and what that line says.

    Raises
    ------
    ValueError
        If the page has no such study, or no such line.
    """
    if study not in page.studies:
        raise ValueError(f"{page.stem} has no study {study!r}; it has {', '.join(page.studies)}")
    for match in _TRY.finditer(page.source[0]):
        if re.search(rf"\b{study}\.(?:run|but)\(", match[1]):
            above = _HEADING.findall(page.source[0][: match.start()])
            return above[-1].strip(), match[1]
    raise ValueError(f'{page.stem}: no "Try it" changes the study {study!r}')


def exercise(contents: Contents, key: str) -> tuple[Page, Asked]:
    """Return an exercise by its key, and the page that asks it.

    Raises
    ------
    ValueError
        If no page asks it.
    """
    for page in contents.chapters:
        if key in page.exercises:
            return page, next(one for one in asked(_cells(page)) if one.key == key)
    raise ValueError(f"no exercise {key!r} in the book")


def doubted(contents: Contents, one: Week) -> str:
    """Return the sceptic's question of a week, as HTML: a link to it, or itself.

    Raises
    ------
    ValueError
        If the page that is named asks for no sentences.
    """
    if one.sceptic not in contents.pages:
        return inline(one.sceptic)
    page = contents.pages[one.sceptic]
    if not (found := _SCEPTIC.findall(page.source[0])):
        raise ValueError(f"{page.stem} asks for no answer in sentences")
    return f"{_place(page.stem, found[-1])} of {linked(contents, page.stem)}"


def _cells(page: Page) -> Mapping[str, object]:
    return json.loads((folder() / f"{page.stem}.ipynb").read_text("utf-8"))


def week(number: int, contents: Contents | None = None) -> Shown:
    """Return what a week asks for, as a list: before, to open, to change, after, to hand in.

    Raises
    ------
    ValueError
        If a bet, study or exercise of it is not in the book.
    """
    contents = contents or read()
    one, pages = weeks()[number - 1], contents.pages
    facts = [(f"Before, {one.before(contents):.0f} min", _listed(contents, one.read))]
    if one.bet:
        stem, _, name = one.bet.partition(".")
        asks = inline(question(pages[stem], name))
        facts.append(("The bet that opens", f"{asks} ({linked(contents, stem)})"))
    if one.study:
        stem, _, name = one.study.partition(".")
        heading, line = tried(pages[stem], name)
        place = _place(stem, heading)
        facts.append(("To change in class", f"<code>{name}</code> in {place}. {inline(line)}"))
    if one.after:
        label = f"After, {one.later(contents):.0f} min with what is handed in"
        facts.append((label, _listed(contents, one.after)))
    if one.hand_in:
        found = [exercise(contents, key) for key in one.hand_in]
        asks = [
            f"<code>{ask.key}</code>, {_place(page.stem, ask.title)}, {counted(ask.points)}"
            for page, ask in found
        ]
        sceptic = f"in sentences, {doubted(contents, one)}, {counted(PROSE)}"
        facts.append(("To hand in", "; ".join([*asks, sceptic])))
    spent = (f"{escape(what)} ({count} min)" for what, count in one.minutes.items())
    facts.append((f"{sum(one.minutes.values())} minutes", "; ".join(spent)))
    html = "".join(f"<dt>{label}</dt><dd>{text}</dd>" for label, text in facts)
    plain = "\n".join(f"{label}: {unescape(_TAG.sub('', text))}" for label, text in facts)
    return output(f'<dl class="rp-week">{html}</dl>', plain, FRONT_END / "words.css")


def inline(text: str) -> str:
    """Return a line of Markdown as HTML: code, emphasis, formulas; of links their words."""
    parts = re.split(r"`([^`]+)`", " ".join(_LINK.sub(r"\1", text).split()))
    said = (re.sub(r"\*([^*]+)\*", r"<em>\1</em>", with_mathematics(p)) for p in parts[::2])
    codes = [f"<code>{escape(code)}</code>" for code in parts[1::2]]
    return "".join(a + b for a, b in zip_longest(said, codes, fillvalue=""))


def overview(contents: Contents | None = None) -> Shown:
    """Return the weeks as a table: what is read before and after, how long, what is handed in."""
    contents = contents or read()
    rows, lines = [], []
    for number, one in enumerate(weeks(), 1):
        before = f"{one.before(contents):.0f}′"
        later = f"{one.later(contents):.0f}′" if one.after else "–"
        points = one.points(contents)
        counts = counted(points) if points else "the project"
        cells = (_stacked(contents, one.read), before, _stacked(contents, one.after), later, counts)
        texts = "".join(f'<td class="rp-text">{text}</td>' for text in cells)
        rows.append(f'<tr><th scope="row">{number}</th>{texts}</tr>')
        titles = (
            ", ".join(named(contents, stem) for stem in part) for part in (one.read, one.after)
        )
        lines.append(
            f"{number}: {'; then '.join(filter(None, titles))}; {before}, {later}; {counts}"
        )
    names = "Week", "Read before", "Takes", "After the class", "Takes, with exercises", "Hand in"
    head = "".join(f'<th scope="col">{name}</th>' for name in names)
    html = html_table("Weeks of the course", "rp-paths", head, "".join(rows))
    return output(html, "\n".join(lines), "table.css")


def _listed(contents: Contents, stems: tuple[str, ...]) -> str:
    pages = contents.pages
    times = (f"{linked(contents, s)} ({pages[s].minutes(exercises=False):.0f} min)" for s in stems)
    return ", ".join(times)


def _stacked(contents: Contents, stems: tuple[str, ...]) -> str:
    return "<br>".join(linked(contents, stem) for stem in stems) or "–"


def _place(stem: str, heading: str) -> str:
    return f'<a href="{stem}.html#{make_id(heading)}">{inline(heading)}</a>'
