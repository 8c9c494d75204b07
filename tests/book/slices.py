"""Slices of notebooks: the cells that a cell needs, by the names that they define and read."""

import ast
import builtins
import re
from collections.abc import Sequence
from dataclasses import dataclass

from nbformat import NotebookNode

BUILT_IN = frozenset(dir(builtins))
IMPORTS = ast.Import | ast.ImportFrom
SHOWS = re.compile(
    r"^(draw\.|films?\.|(opening\.)?now\(|tell\()|\.show\(|^[a-z_]\w*$|^(?!Bet$)[A-Z_]+$"
)
"""Last lines of cells that show a picture, a film, an explorer, a table or a sentence."""


def bound(statement: ast.stmt) -> set[str]:
    """Return the names that a statement of a cell defines."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return {statement.name}
    if isinstance(statement, IMPORTS):
        return {(one.asname or one.name).split(".")[0] for one in statement.names}
    nodes = ast.walk(statement)
    return {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


def read(statement: ast.stmt) -> set[str]:
    """Return the names that a statement of a cell reads."""
    nodes = ast.walk(statement)
    names = {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
    return names - BUILT_IN


def defines(cell: NotebookNode) -> set[str]:
    """Return the names that a cell defines by what is no import."""
    body = ast.parse(cell.source).body
    return {name for one in body if not isinstance(one, IMPORTS) for name in bound(one)}


def shows(cell: NotebookNode) -> bool:
    """Tell whether a cell ends in something that a reader sees and that was computed."""
    body = ast.parse(cell.source).body
    return bool(body and isinstance(body[-1], ast.Expr) and SHOWS.search(ast.unparse(body[-1])))


@dataclass(frozen=True)
class Names:
    """The names that the statements of a cell define and read."""

    bound: frozenset[str]
    read: frozenset[str]

    @classmethod
    def of(cls, source: str) -> "Names":
        """Return those of a cell."""
        body = ast.parse(source).body
        return cls(frozenset().union(*map(bound, body)), frozenset().union(*map(read, body)))


def slice_of(cells: Sequence[Names], shown: int) -> list[int]:
    """Return the numbers of the cells that a code cell needs to run, itself the last of them."""
    kept, known, todo = {shown}, set[str](), {*cells[shown].read}
    while todo:
        name = todo.pop()
        known.add(name)
        more = {number for number in range(shown) if name in cells[number].bound} - kept
        kept |= more
        todo |= {one for number in more for one in cells[number].read} - known
    return sorted(kept)
