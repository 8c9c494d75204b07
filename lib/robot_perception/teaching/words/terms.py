"""The words of the book: what each means, how papers and library call it, and where it is used."""

import ast
import inspect
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from docutils.nodes import make_id

from explorables.media import Shown, with_mathematics
from explorables.outputs import output
from robot_perception.teaching import FRONT_END
from robot_perception.teaching.pages.contents import Contents, Page
from robot_perception.teaching.scores.papers import PAPERS
from studies.files import reading
from studies.records import records

TERMS = "terms.toml"
"""Name of the file in which they are written down."""
PAGE = "words"
"""Stem of the page that lists them."""
LIBRARY = "robot_perception"
OTHERS = ("explorables", "studies")
"""Packages beside it, by which names in them begin."""
OWN = "Use it yourself"
"""Part without chapters whose pages use words as chapters do."""

_NO_PROSE = re.compile(
    r"\A---\n.*?\n---\n|^(`{3,}).*?^\1|`[^`\n]*`|\$\$.*?\$\$|\$(?:[^$\n]|\n(?!\n))*\$|\]\([^)]*\)|<[^>]*>"
    r"|^:::+.*?$|^:\w+:.*?$|^\([\w-]+\)=$",
    re.M | re.S,
)
_FENCE = re.compile(r"^(`{3,}).*?^\1", re.M | re.S)
_HEADING = re.compile(r"^#{1,6} (.+)$|^\(([\w-]+)\)=$|<a id=\"([\w-]+)\"", re.M)
_NAME = re.compile(r"(?P<path>[\w.]+)(?:\((?P<argument>\w+)\))?")
_STRONG = re.compile(r"\*([^*]+)\*")


@dataclass(frozen=True)
class Term:
    r"""A word of the book.

    Parameters
    ----------
    name
        As it is listed.
    says
        What it means, in a sentence or two; ``*…*`` emphasises.
    places
        Where it is explained, as ``stem#place``.
    forms
        Other words for it; a plural in -s or -es need not be among them.
    hover
        Those of its forms by which it is found in prose, if not all, where a form has a second
        meaning.
    pages
        Stems of the pages on which it has this meaning, if not all; on others it is not marked.
    unlike
        Phrases that hold it and mean something else.
    ours
        Our symbol, with mathematics between dollars.
    papers
        The symbol of each paper that has one, by key.
    library
        Its names below ``robot_perception``; an argument stands in brackets.
    """

    name: str
    says: str
    places: tuple[str, ...]
    forms: tuple[str, ...] = ()
    hover: tuple[str, ...] | None = None
    pages: tuple[str, ...] | None = None
    unlike: tuple[str, ...] = ()
    ours: str = ""
    papers: Mapping[str, str] = field(default_factory=dict)
    library: tuple[str, ...] = ()

    @property
    def id(self) -> str:
        """Name of its place on the page of the words."""
        return f"word-{make_id(self.name)}"

    @property
    def plain(self) -> str:
        """Meaning, without emphasis."""
        return _STRONG.sub(r"\1", self.says)

    @property
    def marked(self) -> tuple[str, ...]:
        """Forms by which it is found in prose."""
        return (self.name, *self.forms) if self.hover is None else self.hover

    @cached_property
    def used(self) -> re.Pattern[str]:
        """Matches each of its forms."""
        return _matching((self.name, *self.forms))

    @cached_property
    def _other(self) -> re.Pattern[str]:
        return _matching(self.unlike)

    def meant(self, page: str) -> bool:
        """Return whether it has this meaning on a page, named by its stem."""
        return self.pages is None or page in self.pages

    def means(self, text: str, start: int, end: int) -> bool:
        """Return whether it has this meaning at a place of a text, in no phrase of another one."""
        phrases = self._other.finditer(text) if self.unlike else ()
        return not any(phrase.start() < end and start < phrase.end() for phrase in phrases)

    def on(self, page: str, text: str) -> bool:
        """Return whether the text of a page uses it with this meaning."""
        found = self.used.finditer(text) if self.meant(page) else ()
        return any(self.means(text, *word.span()) for word in found)


class Finder:
    """Finds words in the prose of a page, the longest of those that begin at a place."""

    def __init__(self, terms: Iterable[Term], page: str) -> None:
        meant = [term for term in terms if term.meant(page)]
        self._terms = {form.casefold(): term for term in meant for form in term.marked}
        self._pattern = _matching(self._terms)

    def __call__(self, text: str) -> Iterator[tuple[int, int, Term]]:
        """Yield the words of a text in order: where each begins and ends, and which it is."""
        for match in self._pattern.finditer(text):
            term = self._terms[" ".join(match[1].casefold().split())]
            if term.means(text, *match.span()):
                yield match.start(), match.end(), term


def _matching(forms: Iterable[str]) -> re.Pattern[str]:
    longest = sorted(forms, key=len, reverse=True)
    said = "|".join(re.escape(form).replace(r"\ ", r"\s+") for form in longest)
    return re.compile(rf"(?<![\w-])({said or '(?!)'})(?:e?s)?(?![\w-])", re.I)


def read(file: Path | None = None) -> tuple[Term, ...]:
    """Read the words, in the order of their file.

    Raises
    ------
    ValueError
        If an entry has a key that a term does not have, or lacks one that it must have.
    """
    file = file or records() / TERMS
    found = []
    with reading(file, "is no list of words"):
        for entry in tomllib.loads(file.read_text("utf-8"))["term"]:
            lists = {k: tuple(v) if isinstance(v, list) else v for k, v in entry.items()}
            found.append(Term(**lists))
    return tuple(found)


def prose(page: Page) -> str:
    """Return what a page says: its Markdown without code and formulas, and texts of its cells."""
    texts = (
        node.value
        for node in ast.walk(ast.parse(page.source[1]))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value
    )
    return _NO_PROSE.sub(" ", page.source[0]) + "\n" + "\n".join(texts)


def uses(terms: Sequence[Term], pages: Iterable[Page]) -> dict[str, tuple[Page, ...]]:
    """Return the pages that use each term, by its name, in the order in which pages are given."""
    said = [(page, prose(page)) for page in pages]
    return {
        term.name: tuple(page for page, text in said if term.on(page.stem, text)) for term in terms
    }


def heading(contents: Contents, place: str) -> str:
    """Return the heading that stands at a place of a page, or above it.

    Raises
    ------
    ValueError
        If the page has no such place.
    """
    stem, _, name = place.partition("#")
    page = contents.pages.get(stem)
    text = _FENCE.sub("", page.source[0]) if page else ""
    above, below = "", False
    for match in _HEADING.finditer(text):
        if match[1]:
            above = match[1].strip()
        if below or (match[1] and make_id(above) == name) or match[3] == name:
            return above
        below = match[2] == name  # it names the heading that follows
    raise ValueError(f"no place {place!r}: a heading of that page, or what names a paragraph")


def called(name: str) -> object:
    """Return what stands in the library by a name; of an argument, the function that has it.

    Raises
    ------
    ValueError
        If there is nothing of that name.
    """
    match = _NAME.fullmatch(name)
    if not match:
        raise ValueError(f"no name of the library: {name!r}")
    top, *parts = match["path"].split(".")
    path = top if top in OTHERS else LIBRARY
    found: object = import_module(path)
    for part in parts if top in OTHERS else (top, *parts):
        path = f"{path}.{part}"
        fields = getattr(found, "__dataclass_fields__", {})
        if not hasattr(found, part) and part in fields:
            found = fields[part]
        elif hasattr(found, part):
            found = getattr(found, part)
        elif hasattr(found, "__path__") and find_spec(path):
            found = import_module(path)
        else:
            raise ValueError(f"{name}: nothing is called {path}")
    if match["argument"] and match["argument"] not in inspect.signature(found).parameters:
        raise ValueError(f"{name}: it has no argument {match['argument']!r}")
    return found


def readable(contents: Contents) -> tuple[Page, ...]:
    """Return the pages whose use of words is listed: chapters, what is below, your own data."""
    parts = {OWN, *(page.part for page in contents.chapters if page.number)}
    pages = contents.pages.values()
    return tuple(page for page in pages if page in contents.chapters or page.part in parts)


def words(contents: Contents, terms: Sequence[Term] | None = None) -> Shown:
    """Return all words with what is known of them, in the order of the alphabet.

    Parameters
    ----------
    contents
        The pages to which the words lead.
    terms
        The words; those of the book if not given.
    """
    terms = read() if terms is None else terms
    used = uses(terms, readable(contents))
    first = {term.name[0].upper(): term.id for term in reversed(terms)}
    letters = " ".join(f'<a href="#{first[a]}">{a}</a>' for a in sorted(first))
    html = f'<nav class="rp-letters" aria-label="First letters">{letters}</nav>'
    html += "".join(_entry(term, contents, used[term.name]) for term in terms)
    text = "\n".join(f"{term.name}: {term.plain}" for term in terms)
    return output(f'<div class="rp-glossary">{html}</div>', text, FRONT_END / "words.css")


def _entry(term: Term, contents: Contents, used: Iterable[Page]) -> str:
    facts = [("Our symbol", with_mathematics(term.ours))] if term.ours else []
    facts += [
        (escape(paper.citation), with_mathematics(term.papers[key]))
        for key, paper in PAPERS.items()
        if key in term.papers
    ]
    if term.library:
        names = (f"<code>{escape(name).replace('.', '.<wbr>')}</code>" for name in term.library)
        facts.append(("In the library", ", ".join(names)))
    places = (
        f'<a href="{place.replace("#", ".html#")}">{_numbered(contents.pages[stem])}</a>, '
        f"<i>{escape(heading(contents, place))}</i>"
        for place, stem in ((place, place.partition("#")[0]) for place in term.places)
    )
    facts.append(("Explained in", "; ".join(places)))
    links = (
        f'<a href="{page.stem}.html" title="{escape(page.title)}">{page.number or page.title}</a>'
        for page in used
    )
    if listed := ", ".join(links):
        facts.append(("Used in", listed))
    rows = "".join(f"<dt>{label}</dt><dd>{text}</dd>" for label, text in facts)
    says = _STRONG.sub(r"<em>\1</em>", escape(term.says, quote=False))
    return (
        f'<article class="rp-word" id="{term.id}"><h2>{escape(term.name)}</h2>'
        f"<p>{says}</p><dl>{rows}</dl></article>"
    )


def _numbered(page: Page) -> str:
    return escape(f"{page.number}. {page.title}" if page.number else page.title)
