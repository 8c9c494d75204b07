"""A small book for a test: notebooks of study cells, with records and kept results of its own."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import IPython
import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

import robot_perception.book as modules
from robot_perception.datasets.store import CACHE_VARIABLE
from robot_perception.project import BOOK
from studies.keys import cells
from studies.keys.cells import LIVE
from studies.project import project


@dataclass(frozen=True)
class Book:
    """A folder of notebooks; ``_data`` has its records."""

    folder: Path

    def write(self, stem: str, *texts: str) -> Path:
        """Write a notebook whose study cells, ``c0`` and so on, stand between other cells."""
        made = [new_markdown_cell("# A chapter"), new_code_cell("print('no study')", id="other")]
        for k, text in enumerate(texts):
            cell = new_code_cell(text, id=f"c{k}")
            cell.metadata["tags"] = ["hide-input", "study"]
            made += [cell, new_markdown_cell("LEVEL = 'is no code'")]
        page = self.folder / f"{stem}.ipynb"
        nbformat.write(new_notebook(cells=made), page)
        self.forget(stem)
        return page

    def module(self, stem: str) -> ModuleType:
        """Import the module of a notebook anew."""
        self.forget(stem)
        return import_module(f"{BOOK}{stem}")

    def made(self, *texts: str, stem: str = "small") -> ModuleType:
        """Write a notebook and import its module."""
        self.write(stem, *texts)
        return self.module(stem)

    @staticmethod
    def forget(stem: str) -> None:
        """Forget a notebook as it was."""
        cells._of_page.cache_clear()
        sys.modules.pop(f"{BOOK}{stem}", None)
        vars(modules).pop(stem, None)


@pytest.fixture
def book(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Book]:
    """An empty book."""
    made = Book(tmp_path / "book")
    (made.folder / "_data").mkdir(parents=True)
    own = replace(project(), notebooks=lambda: made.folder, records=lambda: made.folder / "_data")
    monkeypatch.setattr("studies.project._used", [own])
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    yield made
    for page in made.folder.glob("*.ipynb"):
        made.forget(page.stem)


@pytest.fixture
def live(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Run texts as cells of a notebook; the history has what IPython makes of them."""
    namespace: dict[str, Any] = {"__name__": LIVE, "In": [""]}
    shell = SimpleNamespace(user_ns=namespace)
    monkeypatch.setattr(IPython, "get_ipython", lambda: shell)

    def run(*texts: str) -> SimpleNamespace:
        for text in texts:
            namespace["In"].append(text)
            if not text.startswith("%"):
                exec(compile(text, f"<cell {len(namespace['In'])}>", "exec"), namespace)
        return SimpleNamespace(**namespace)

    return run
