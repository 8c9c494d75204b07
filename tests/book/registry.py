"""What the chapters declare, by name: read in the notebooks' cells, without running them.

Tests are parametrised by these names and import a chapter's module when they run, so that
collecting them is cheap, and `make check` chooses those of a stem. ``test_registry.py`` compares
with the modules.
"""

import ast
import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from robot_perception.chapters import CHAPTERS, PRIMER
from robot_perception.project import BOOK
from studies.keys.cells import study_cells

FOLDER = Path(__file__).parents[2] / "book"
COMPUTING = (*PRIMER, *CHAPTERS)
"""The primer and the chapters, whose study cells are modules."""
STUDY, CLAIM, STORED = "study", "claim", "recorded"
EXPLORER, BET, SHEET = "Exploration", "Bet", "Sheet"
DECORATORS = (STUDY, CLAIM, STORED)
CALLS = (EXPLORER, BET, SHEET)


@dataclass(frozen=True, slots=True)
class Declared:
    """One thing that a chapter declares.

    Parameters
    ----------
    kind
        The decorator or class by which it is declared.
    stem
        The chapter.
    variable
        Its name in the chapter's module.
    name
        What it is called: a claim's identifier, an explorer's or a stored result's name.
    """

    kind: str
    stem: str
    variable: str
    name: str

    @property
    def id(self) -> str:
        """What tests of it are called; it says the stem, but for claims and stored results."""
        return self.name if self.kind in (CLAIM, STORED) else f"{self.stem}.{self.name}"

    def value(self) -> Any:
        """Import the module of the chapter, and return the thing."""
        return getattr(import_module(f"{BOOK}{self.stem}"), self.variable)


@cache
def declared(stem: str) -> tuple[Declared, ...]:
    """Return what the study cells of a chapter declare, in their order."""
    texts = (text for _, text in study_cells(FOLDER / f"{stem}.ipynb"))
    return tuple(Declared(kind, stem, *names) for kind, *names in declared_in(texts))


def every(kind: str) -> tuple[Declared, ...]:
    """Return what is of a kind in all chapters, in the order of the book."""
    return tuple(one for stem in COMPUTING for one in declared(stem) if one.kind == kind)


def declared_in(texts: Iterable[str]) -> Iterator[tuple[str, str, str]]:
    """Yield what cells declare: its kind, its variable, and what it is called."""
    declaring = [t for t in texts if any(f"{word}(" in t for word in (*DECORATORS, *CALLS))]
    for node in (node for text in declaring for node in ast.parse(text).body):
        if isinstance(node, ast.FunctionDef):
            calls = [call for call in node.decorator_list if isinstance(call, ast.Call)]
            for call in calls:
                kind = _last(call.func)
                if kind in DECORATORS:
                    yield kind, node.name, _said(call, "") or node.name
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Call):
            kind, variable = _last(node.value.func), _last(node.targets[0])
            if kind in (*CALLS, CLAIM) and variable:
                name = _said(node.value, {EXPLORER: "name", CLAIM: ""}.get(kind, "none"))
                yield kind, variable, name or variable


def _last(node: ast.AST) -> str:
    """Return the last word of a dotted name."""
    return getattr(node, "attr", getattr(node, "id", ""))


def _said(call: ast.Call, keyword: str) -> str:
    """Return the text that is given to a call by a keyword, or first if that is empty."""
    values = [k.value for k in call.keywords if k.arg == keyword] if keyword else call.args[:1]
    texts = [value.value for value in values if isinstance(value, ast.Constant)]
    return texts[0] if texts and isinstance(texts[0], str) else ""


# Whose a test is


@cache
def _claims() -> dict[str, str]:
    """Return the chapters of the recorded claims, by identifier."""
    claims = json.loads((FOLDER / "_data" / "claims.json").read_text("utf-8"))["claims"]
    return {claim["id"]: claim["chapter"] for claim in claims}


@cache
def _names() -> dict[str, str]:
    """Return the stems of explorers and stored results that are declared in cells, by name."""
    return {one.name: one.stem for kind in (EXPLORER, STORED) for one in every(kind)}


def owners(test: str) -> frozenset[str]:
    """Return the words by which a test can be chosen: from its stem to its whole name.

    Parameters
    ----------
    test
        The values of a test, as its name has them between brackets: ``monobot.joseph``,
        ``walls-knob``, a claim.

    Returns
    -------
    words
        None if the test is of no stem. With a dot behind it, the stem is the chapter as a whole and
        none of the things that it declares.
    """
    named = _claims().get(test) or _names().get(test)
    if named:
        return frozenset({named, test, f"{named}.{test}"})
    for stem in COMPUTING:
        if test == stem or test.startswith((f"{stem}.", f"{stem}-")):
            rest = test[len(stem) + 1 :]
            return frozenset({stem, *(f"{stem}.{part}" for part in (rest, rest.partition("-")[0]))})
    return frozenset()
