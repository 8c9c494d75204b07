"""The book's contents, read from its pages: what chapters need, and how long they take."""

import ast
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import yaml

from studies.keys.cells import folder

WORDS, LINES, EXPLORER, EXERCISE = 200, 12, 3, 6
"""Words and lines of code that are read in a minute; minutes of an explorer and an exercise."""
HIDDEN = ("hide-input", "remove-input", "hide-cell", "remove-cell")
"""Tags of cells whose code a page does not show."""
FIGURES = Path(__file__).parents[1] / "chapters"
"""Packages of the chapters, where captions of figures stand."""

_BOX = re.compile(r":::\{admonition\} Before you start\n(.*?)\n:::", re.S)
_LINK = re.compile(r"\]\((\w+)\.(?:ipynb|md)(?:#[\w-]*)?\)")
_CLAUSE = re.compile(r"[;.] |\.\n|, (?=and nothing)")
_ASIDE = re.compile(r"\b(?:appears?|helps?|nothing about|matter of)\b")
_CODE = re.compile(r"^(`{3,}).*?^\1", re.M | re.S)
_FRONT = re.compile(r"\A---\n.*?\n---\n", re.S)
_TITLE = re.compile(r"^# (.+)$", re.M)
_BET = re.compile(r"^(\w+) = Bet\(", re.M)
_STUDY = re.compile(r"^@chapter\.study\b[^\n]*(?:\n(?!def )[^\n]*)*\ndef (\w+)\(", re.M)
_EXPLORER = re.compile(r"\bExploration\(")
_CHECK = re.compile(r"\bcheck\(\s*\"([\w-]+)\"")
_QUESTION = re.compile(r"(?<![^.?!:\s])\s*[A-Z][^.?!]*\?")


@dataclass(frozen=True)
class Page:
    """A page of the book.

    Parameters
    ----------
    stem
        Name of its file, without suffix.
    number
        Of the chapter; ``None`` if the page has none.
    part
        Caption of the part in which it stands.
    source
        Its Markdown, and the code of its cells.
    told
        Words that its code says: sentences with numbers, captions, bets.
    lines
        Lines of code that it shows.
    """

    stem: str
    number: int | None
    part: str
    source: tuple[str, str]
    told: int = 0
    lines: int = 0

    @cached_property
    def title(self) -> str:
        """The first heading."""
        found = _TITLE.search(self.source[0])
        return found[1].strip() if found else self.stem

    @cached_property
    def box(self) -> str | None:
        """Text of the box "Before you start"; ``None`` if there is none."""
        found = _BOX.search(self.source[0])
        return found and found[1]

    @cached_property
    def links(self) -> tuple[str, ...]:
        """Stems of the pages that the box says a reader needs, in its order.

        A clause that says where something merely *appears* or *helps*, what is the *matter of*
        another page, or *nothing about* what is needed, names no need.
        """
        clauses = _CLAUSE.split(self.box or "")
        needed = [name for c in clauses if not _ASIDE.search(c) for name in _LINK.findall(c)]
        return tuple(dict.fromkeys(needed))

    @cached_property
    def question(self) -> str:
        """The first question of its text, of four words at least; empty if it asks none."""
        text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", self.source[0]).replace("*", "")
        asked = _QUESTION.finditer(re.sub(r"^#.*$", "", text, flags=re.M))
        return next((" ".join(q[0].split()) for q in asked if len(q[0].split()) >= 4), "")

    @cached_property
    def bets(self) -> tuple[str, ...]:
        """Names of the bets."""
        return tuple(_BET.findall(self.source[1]))

    @cached_property
    def studies(self) -> tuple[str, ...]:
        """Names of the studies."""
        return tuple(_STUDY.findall(self.source[1]))

    @cached_property
    def exercises(self) -> tuple[str, ...]:
        """Keys of the exercises that check themselves."""
        return tuple(dict.fromkeys(_CHECK.findall(self.source[1])))

    @cached_property
    def words(self) -> int:
        """Words of the text, and of what the code says."""
        return self.told + len(_CODE.sub("", _FRONT.sub("", self.source[0])).split())

    def minutes(self, *, exercises: bool = True) -> float:
        """Return how long the page takes, with its explorers, and its exercises or without."""
        playing = EXPLORER * len(_EXPLORER.findall(self.source[1]))
        reading = self.words / WORDS + self.lines / LINES
        return reading + playing + exercises * EXERCISE * len(self.exercises)


class Contents:
    """The pages of the book in their order.

    Parameters
    ----------
    pages
        In the order of the table of contents.

    Raises
    ------
    ValueError
        If a chapter needs a later one.
    """

    def __init__(self, pages: Iterable[Page]) -> None:
        self.pages: Mapping[str, Page] = {page.stem: page for page in pages}
        self.chapters = tuple(p for p in self.pages.values() if p.number or p.box or p.exercises)
        """Pages with a number, with a box of what to know before, or with exercises."""
        place = {page.stem: k for k, page in enumerate(self.chapters)}
        for page in self.chapters:
            late = [name for name in self.needs(page.stem) if place[name] >= place[page.stem]]
            if late:
                raise ValueError(f"{page.stem} needs {late[0]}, which does not stand before it")

    def needs(self, stem: str) -> tuple[str, ...]:
        """Return the chapters that a chapter's box names as needed."""
        known = {page.stem for page in self.chapters}
        return tuple(name for name in self.pages[stem].links if name in known and name != stem)

    def before(self, stems: Iterable[str]) -> tuple[str, ...]:
        """Return chapters and all that they need, directly or not, in the order of the book."""
        todo, found = list(stems), set()
        while todo:
            stem = todo.pop()
            if stem not in found:
                found.add(stem)
                todo += self.needs(stem)
        return tuple(page.stem for page in self.chapters if page.stem in found)

    def direct(self, stem: str) -> tuple[str, ...]:
        """Return what a chapter needs without what follows from its other needs."""
        needs = self.needs(stem)
        implied = {far for name in needs for far in self.before([name]) if far != name}
        return tuple(name for name in needs if name not in implied)


def read(book: Path | None = None) -> Contents:
    """Read the contents of the book: `_toc.yml` and the pages that it names.

    Raises
    ------
    FileNotFoundError
        If the book is not there, as in an installed package.
    """
    book = book or folder()
    listed = yaml.safe_load((book / "_toc.yml").read_text("utf-8"))
    pages, number = [_page(book, listed["root"])], 0
    for part in listed["parts"]:
        for entry in part["chapters"]:
            number += bool(part.get("numbered"))
            own = number if part.get("numbered") else None
            pages.append(_page(book, entry["file"], own, part["caption"]))
            pages += [
                _page(book, below["file"], None, part["caption"])
                for below in entry.get("sections", ())
            ]
    return Contents(pages)


def _page(book: Path, stem: str, number: int | None = None, part: str = "") -> Page:
    if (plain := book / f"{stem}.md").exists():
        return Page(stem, number, part, (plain.read_text("utf-8"), ""))
    cells = json.loads((book / f"{stem}.ipynb").read_text("utf-8"))["cells"]
    texts: dict[str, list[str]] = {"markdown": [], "code": []}
    lines = 0
    for cell in cells:
        text = "".join(cell["source"])
        texts.setdefault(cell["cell_type"], []).append(text)
        if cell["cell_type"] == "code" and not {*HIDDEN} & {*cell["metadata"].get("tags", ())}:
            lines += len(text.splitlines())
    code = "\n\n".join(texts["code"])
    return Page(stem, number, part, ("\n\n".join(texts["markdown"]), code), told(stem, code), lines)


def told(stem: str, code: str) -> int:
    """Return how many words the code of a page says: sentences with numbers, captions, bets."""
    tree = ast.parse(code)
    drawn = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    for file in sorted((FIGURES / stem).glob("*.py")):
        functions = ast.walk(ast.parse(file.read_bytes()))
        tree.body += [f for f in functions if isinstance(f, ast.FunctionDef) and f.name in drawn]
    said: list[ast.expr] = []
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        said += [word.value for word in call.keywords if word.arg == "caption"]
        name = getattr(call.func, "id", "")
        said += call.args if name in ("tell", "Bet") else ()
        said += [word.value for word in call.keywords if name == "Bet" and word.arg != "because"]
    constants = (
        node.value for one in said for node in ast.walk(one) if isinstance(node, ast.Constant)
    )
    return sum(len(text.split()) for text in constants if isinstance(text, str))
