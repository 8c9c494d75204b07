"""The prose of the book as a proof-reader gets it: passages, each with its place."""

import ast
import base64
import gzip
import json
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import nbformat

ROOT = Path(__file__).parents[2]
BOOK = ROOT / "book"
CHAPTERS = ROOT / "lib" / "robot_perception" / "chapters"
NOTEBOOKS = tuple(sorted(BOOK.glob("*.ipynb")))
PLAIN = tuple(sorted([*BOOK.glob("*.md"), *BOOK.glob("library/*.md")]))
DRAWN = ("figures.py", "explorers.py", "films.py", "bets.py")
"""Modules of a chapter whose texts stand beside pictures."""
_STATES = re.compile(r'explorables\.register\("explorer-\w+", "([^"]*)"')


@dataclass(frozen=True, slots=True)
class Passage:
    """A text of the book and where it stands.

    Parameters
    ----------
    page
        Stem of the notebook, page or chapter.
    place
        Identifier of a cell, name of a module, or key of a claim.
    text
        What it says.
    """

    page: str
    place: str
    text: str

    def __str__(self) -> str:
        return f"{self.page}, {self.place}"


@cache
def notebook(path: Path) -> nbformat.NotebookNode:
    """Return a notebook of the book."""
    return nbformat.read(path, as_version=4)


def cells(kind: str) -> Iterator[tuple[str, nbformat.NotebookNode]]:
    """Yield the cells of a kind with the stem of their notebook."""
    for path in NOTEBOOKS:
        yield from ((path.stem, c) for c in notebook(path).cells if c.cell_type == kind)


@cache
def prose() -> tuple[Passage, ...]:
    """Return what is written in Markdown."""
    found = [Passage(stem, f"cell {cell.id}", cell.source) for stem, cell in cells("markdown")]
    pages = [Passage(path.stem, path.name, path.read_text("utf-8")) for path in PLAIN]
    return (*found, *pages)


@cache
def words() -> tuple[Passage, ...]:
    """Return the sentences that stand in code: of notebooks, and of modules of chapters."""
    found = []
    for stem, cell in cells("code"):
        found += [Passage(stem, f"cell {cell.id}", text) for text in said(cell.source)]
    for path in sorted(CHAPTERS.glob("*/*.py")):
        place = path.relative_to(CHAPTERS.parent).as_posix()
        found += [Passage(path.parent.name, place, text) for text in said(path.read_text("utf-8"))]
    return tuple(found)


@cache
def printed() -> tuple[Passage, ...]:
    """Return what cells of notebooks have printed and keep."""
    return tuple(
        Passage(stem, f"output of {cell.id}", str(text))
        for stem, cell in cells("code")
        for output in cell.outputs
        for text in (output.get("text", ""), output.get("data", {}).get("text/plain", ""))
    )


@cache
def claims() -> tuple[dict, ...]:
    """Return the recorded claims, as they are stored."""
    return tuple(json.loads((BOOK / "_data" / "claims.json").read_text("utf-8"))["claims"])


def said(source: str) -> list[str]:
    """Return the texts with a space in Python code, but for what documents it."""
    tree = ast.parse(source)
    documented = {
        id(node.value)
        for body in (getattr(node, "body", None) for node in ast.walk(tree))
        if isinstance(body, list)
        for node in body
        if isinstance(node, ast.Expr)
    }
    return [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and id(node) not in documented
        and " " in node.value
    ]


def site() -> dict[str, str]:
    """Return the pages of the site that ROBOT_PERCEPTION_SITE names, by name, or none."""
    given = os.environ.get("ROBOT_PERCEPTION_SITE")
    if not given:
        return {}
    return {path.stem: path.read_text("utf-8") for path in sorted((ROOT / given).glob("*.html"))}


def states() -> dict[str, str]:
    """Return what explorers of the built site say and draw in all their states, by file."""
    given = os.environ.get("ROBOT_PERCEPTION_SITE", "")
    found = {}
    for path in sorted((ROOT / given / "_static" / "explorers").glob("*.js")):
        told = _STATES.match(path.read_text("utf-8"))
        if told:
            packed = json.loads(gzip.decompress(base64.b64decode(told[1])))
            found[path.name] = "\n".join(packed["lines"])
    return found


@cache
def papers() -> dict[str, str]:
    """Return the papers' texts by name, or none where the papers are not beside the checkout."""
    given = os.environ.get("ROBOT_PERCEPTION_PAPERS")
    folder = Path(given) if given else ROOT.parent / "shared" / "papers"
    return {path.stem: path.read_text("utf-8") for path in sorted(folder.glob("*.txt"))}
