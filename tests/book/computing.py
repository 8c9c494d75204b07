"""The chapters whose notebooks compute: their modules, cells and studies."""

import re
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

import nbformat

from robot_perception.chapters import CHAPTERS
from robot_perception.project import BOOK
from studies.keys.cells import STUDY
from tests.book import pages
from tests.book.registry import COMPUTING

PACKAGES = {stem: import_module(f"robot_perception.chapters.{stem}") for stem in CHAPTERS}
FURTHER = tuple(page for package in PACKAGES.values() for page in getattr(package, "PAGES", ()))
"""Notebooks beside those of the chapters that compute on recordings, by the same rules."""
HIDDEN = frozenset({"hide-input", "remove-input", "hide-cell", "remove-cell"})
CHECKED = "# NBVAL_CHECK_OUTPUT"
EXERCISE = re.compile(r"^check\(", re.MULTILINE)


@cache
def module(stem: str) -> ModuleType:
    """Return the module of a chapter's study cells."""
    return import_module(f"{BOOK}{stem}")


def found(kind: type) -> list[tuple[str, Any]]:
    """Return what is of a kind in the modules of the chapters, each thing once, with its stem."""
    every = {id(v): (stem, v) for stem in COMPUTING for v in vars(module(stem)).values()
             if isinstance(v, kind)}  # fmt: skip
    return list(every.values())


def code_cells(stem: str) -> list[nbformat.NotebookNode]:
    """Return the code cells of a chapter."""
    cells = pages.notebook(pages.BOOK / f"{stem}.ipynb").cells
    return [cell for cell in cells if cell.cell_type == "code"]


def tags(cell: nbformat.NotebookNode) -> set[str]:
    """Return the tags of a cell."""
    return set(cell.metadata.get("tags", ()))


def is_study(cell: nbformat.NotebookNode) -> bool:
    """Tell whether a cell is a part of the chapter's module."""
    return STUDY in tags(cell)


def is_visible(cell: nbformat.NotebookNode) -> bool:
    """Tell whether a cell shows its code."""
    return not tags(cell) & HIDDEN


def lines(cell: nbformat.NotebookNode) -> list[str]:
    """Return the lines of code of a cell."""
    every = cell.source.splitlines()
    return [line for line in every if line.strip() and line.strip() != CHECKED]
