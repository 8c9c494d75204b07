"""What a page asks its reader to try is there: names, studies, factors; and it computes.

*Try it* lines name code between backticks. Each piece is read as Python: its names are those of the
page, its studies take the keywords that they are given. The first trial that a reader would see is
computed where trials of the study take little, in the whole proof elsewhere, too.
"""

import ast
import builtins
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import Any

import pytest

from studies.stored import recorded_rows
from studies.trials import Trials
from tests.book import pages
from tests.book.computing import COMPUTING, FURTHER, code_cells, module
from tests.unchecked import unchecked

CODE = re.compile(r"`([^`]+)`")
BEGINS = "*Try it.*"
SHORT, LONG = 0.5, 120.0
"""What a trial may take that is computed in `make test`, and in `make test-all`, s."""
FEWEST = 120
"""Fewest pieces of code that are read; the book has more."""


@dataclass(frozen=True, slots=True)
class Piece:
    """Code that a *Try it* line names.

    Parameters
    ----------
    stem
        The page.
    cell
        Identifier of the cell of the line.
    code
        What stands between the backticks.
    """

    stem: str
    cell: str
    code: str

    @property
    def id(self) -> str:
        """What tests of it are called."""
        return f"{self.stem}-{self.cell}"

    def tree(self) -> ast.Module | None:
        """Parse it; ``None`` if it is a word, a value or a part of a line."""
        try:
            tree = ast.parse(self.code)
        except SyntaxError:
            return None
        line = tree.body[0] if len(tree.body) == 1 else None
        return None if isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant) else tree


@cache
def pieces() -> tuple[Piece, ...]:
    """Return what the pages ask their readers to try."""
    return tuple(
        Piece(stem, cell.id, code)
        for stem, cell in pages.cells("markdown")
        for line in cell.source.splitlines()
        if BEGINS in line
        for code in CODE.findall(line.partition(BEGINS)[2])
    )


@cache
def names(stem: str) -> frozenset[str]:
    """Return what the code of a page names, and its keywords."""
    found: set[str] = set()
    for cell in code_cells(stem):
        for node in ast.walk(ast.parse(cell.source)):
            named = ("id", "arg", "asname", "name", "attr", "value")
            found |= {word for n in named if isinstance(word := getattr(node, n, None), str)}
    return frozenset(found)


def missing(piece: Piece) -> set[str]:
    """Return the names of a piece that its page does not have."""
    tree = piece.tree()
    if tree is None:
        return set()
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    used -= {name for name in used if f"{name}=" in piece.code}  # a keyword that is to be added
    return used - names(piece.stem) - vars(builtins).keys()


def variants(piece: Piece) -> Iterator[Trials]:
    """Yield the studies that a piece runs, as it changes them.

    Raises
    ------
    Exception
        Whatever its reader would see: a keyword that the study has not, a name that is nowhere.
    """
    tree = piece.tree()
    space = vars(module(piece.stem)) if tree and piece.stem in COMPUTING else {}
    for node in ast.walk(tree) if tree else ():
        match node:
            case ast.Call(func=ast.Attribute(value=owner, attr="run"), keywords=keywords):
                study = _value(owner, space)
                if isinstance(study, Trials):
                    levels = {word.arg: _value(word.value, space) for word in keywords}
                    yield study.but(**levels) if levels else study


def _value(node: ast.expr, space: dict[str, Any]) -> Any:
    """Return the value of an expression in a namespace."""
    return eval(compile(ast.Expression(node), "Try it", "eval"), dict(space))


def entries(stem: str, cell: str) -> Iterator[tuple[str, ast.expr, ast.expr]]:
    """Yield what a line lets its reader add to tables of the page: a name, a key, a value."""
    codes = [piece.code for piece in pieces() if (piece.stem, piece.cell) == (stem, cell)]
    for code, name in zip(codes, [*codes[1:], ""], strict=True):
        for said in (code, f"{name}[{code}".replace(": ", "] = ", 1) if ": " in code else ""):
            with suppress(SyntaxError):
                match ast.parse(said).body:
                    case [ast.Assign([ast.Subscript(ast.Name(table), key)], value)]:
                        if isinstance(vars(module(stem)).get(table), dict):
                            yield table, key, value


def seconds(study: Trials) -> float:
    """Return how long a trial of a study takes at most, as it is recorded, s."""
    return max(most for _, most in recorded_rows.seconds(study.stem, study.name).values())


def tried() -> Iterator[Any]:
    """Yield the studies that pieces run, marked as slow where a trial takes a while."""
    for piece in pieces():
        for study in variants(piece):
            if (most := seconds(study)) < LONG:
                marks = [pytest.mark.slow] if most > SHORT else []
                yield pytest.param(piece, study, id=f"{piece.id}-{study.name}", marks=marks)


@pytest.mark.parametrize("stem", [*COMPUTING, *FURTHER])
def test_names_of_what_is_tried_are_those_of_the_page(stem: str):
    of_page = [piece for piece in pieces() if piece.stem == stem]
    wrong = {piece.code: missing(piece) for piece in of_page if missing(piece)}
    assert not wrong


@pytest.mark.parametrize("stem", COMPUTING)
def test_studies_take_what_is_tried(stem: str):
    for piece in (piece for piece in pieces() if piece.stem == stem):
        for study in variants(piece):
            assert next(study.trials()), piece


@pytest.mark.parametrize(("piece", "study"), [*tried()])
def test_first_trial_of_what_is_tried_computes(
    piece: Piece, study: Trials, monkeypatch: pytest.MonkeyPatch
):
    space = vars(module(piece.stem))
    for table, key, value in entries(piece.stem, piece.cell):
        monkeypatch.setitem(space[table], _value(key, space), _value(value, space))
    with unchecked():
        assert study.trial(**next(study.trials()))


def test_an_entry_that_is_to_be_added_is_found():
    found = [
        (piece.stem, table)
        for piece in dict.fromkeys(Piece(one.stem, one.cell, "") for one in pieces())
        for table, _, _ in entries(piece.stem, piece.cell)
    ]
    assert ("head_tracking", "TRACKERS") in found
    assert ("people_fusion", "ROOMS") in found


def test_most_pieces_are_code():
    assert sum(piece.tree() is not None for piece in pieces()) >= FEWEST
