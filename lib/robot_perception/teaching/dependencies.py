"""What the results on a page of the book depend on besides its own cells.

A page reaches the modules that its cells import, and what those import. It reads the recorded
results, tables of the package and data sets whose names stand as strings in those modules or in its
cells. What no module names could be anybody's, and counts for every page.
"""

import ast
import hashlib
import json
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

import grimp
import nbformat
from myst_nb.core.read import is_myst_markdown_notebook, read_myst_markdown_notebook

from robot_perception.datasets import find, registry

ROOT = Path(__file__).parents[3]  # whatever book is built, its code and records are these
PACKAGES = ("robot_perception", "data_synth")
LEDGER = "claims.json"
BY_NAME = frozenset({"importlib", "pkgutil"})
"""Who imports one of these may import each of its submodules by name."""

IRRELEVANT = frozenset({"__pycache__", "front_end"})  # bytecode; scripts that pages load themselves


class Dependencies:
    """The import graph of the library, and what its modules name.

    Parameters
    ----------
    root
        The root of the repository.
    packages
        The packages whose code a page may reach.
    """

    def __init__(self, root: Path, packages: tuple[str, ...] = PACKAGES) -> None:
        self._root = root
        self._graph = grimp.build_graph(*packages, include_external_packages=True, cache_dir=None)
        self._files = {
            name: _file(name) for name in self._graph.modules if name.split(".")[0] in packages
        }
        self._names = {
            name: _strings(ast.parse(file.read_bytes())) for name, file in self._files.items()
        }
        self._named = frozenset().union(*self._names.values())
        folders = (root / "book" / "_data", *(_file(name).parent for name in packages))
        self._data = {
            file: _calls(file.relative_to(folder))
            for folder in folders
            for file in sorted(folder.rglob("*"))
            if file.is_file() and file.suffix != ".py" and IRRELEVANT.isdisjoint(file.parts)
        }

    def key(self, page: Path) -> str | None:
        """Hash all that the results on a page depend on, or return ``None`` if it has no code."""
        cells = code(page)
        if not cells:
            return None
        modules = self.modules(cells)
        named = _strings(*cells).union(*(self._names[name] for name in modules))
        digest = hashlib.sha256((self._root / "constraints.txt").read_bytes())
        for name in sorted(modules):
            digest.update(name.encode() + self._files[name].read_bytes())
        for file in self.data(named):
            ledger = file.name == LEDGER
            digest.update(file.name.encode())
            digest.update(claims_of(page.stem, named, file) if ledger else file.read_bytes())
        for name in registry():  # a page differs with its recording there or not
            if name in named or name not in self._named:
                digest.update(f"{name} {find(name) is not None}".encode())
        return digest.hexdigest()[:16]

    def modules(self, cells: Iterable[ast.Module]) -> set[str]:
        """Return the modules that run when cells do: those they import, and what those import."""
        todo = {(name, True) for name in self._imported(cells)}
        seen: set[tuple[str, bool]] = set()
        while todo:
            seen |= todo
            found = {step for name, meant in todo for step in self._next(name, meant)}
            todo = found - seen
        return {name for name, _ in seen}

    def _next(self, name: str, meant: bool) -> Iterable[tuple[str, bool]]:
        """Yield what a module imports, whether it was meant or only stands above another one."""
        imported = self._graph.find_modules_directly_imported_by(name)
        yield from ((other, True) for other in imported & self._files.keys())
        if meant and imported & BY_NAME:
            yield from ((other, True) for other in self._graph.find_descendants(name))
        if "." in name:
            yield name.rpartition(".")[0], False

    def _imported(self, cells: Iterable[ast.Module]) -> Iterable[str]:
        for node in (node for cell in cells for node in ast.walk(cell)):
            if isinstance(node, ast.Import):
                yield from (alias.name for alias in node.names if alias.name in self._files)
            elif isinstance(node, ast.ImportFrom) and node.module in self._files:
                names = (f"{node.module}.{alias.name}" for alias in node.names)
                yield from (name if name in self._files else node.module for name in names)

    def data(self, named: frozenset[str]) -> list[Path]:
        """Return the files that are named, and those that no module names."""
        return [
            file
            for file, calls in self._data.items()
            if calls & named or calls.isdisjoint(self._named)
        ]


def code(page: Path) -> list[ast.Module]:
    """Return the code cells of a notebook, stored as such or as Markdown."""
    text = page.read_text("utf-8")
    if page.suffix == ".ipynb":
        notebook = nbformat.reads(text, as_version=4)
    elif is_myst_markdown_notebook(text):
        notebook = read_myst_markdown_notebook(text)
    else:
        return []
    return [
        ast.parse(cell.source, str(page)) for cell in notebook.cells if cell.cell_type == "code"
    ]


def claims_of(chapter: str, named: frozenset[str], ledger: Path) -> bytes:
    """Return what a page reads of the ledger.

    That is a chapter's own claims and those it names; all of it for a page that is no chapter.
    """
    text = ledger.read_bytes()
    claims = json.loads(text)["claims"]
    if chapter not in {claim["chapter"] for claim in claims}:
        return text
    read = [claim for claim in claims if claim["chapter"] == chapter or claim["id"] in named]
    return json.dumps(read).encode()


def _file(module: str) -> Path:
    """Return the file of a module without importing it."""
    top, *rest = module.split(".")
    path = Path(find_spec(top).origin).parent.joinpath(*rest)
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def _calls(file: Path) -> frozenset[str]:
    """Return what code may call a file: its name, or that of a folder, less the suffix."""
    return frozenset({file.name, *(part.partition(".")[0] for part in file.parts)})


def _strings(*trees: ast.Module) -> frozenset[str]:
    nodes = (node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Constant))
    return frozenset(node.value for node in nodes if isinstance(node.value, str))
