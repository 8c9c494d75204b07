"""Study cells: the code of a chapter that is in its notebook, read as a module reads a file.

A cell of ``book/<stem>.ipynb`` with the tag ``study`` is a part of the module
``robot_perception.book.<stem>`` (:mod:`robot_perception.book`). What one of its functions computes
depends on its own source and on the definitions that this reaches, in the cells and in the modules
that they import: `code_of` hashes that and nothing else. In a notebook the same functions live in
``__main__``, where a reader edits them; there the cells that were run are what counts, so that the
hash is that of the module's function as long as the two say the same.
"""

import ast
import json
import linecache
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from robot_perception.files import reading
from robot_perception.teaching import dependencies

STUDY = "study"
"""The tag of a cell that is a part of the chapter's module."""
BOOK = dependencies.NOTEBOOKS
LIVE = "__main__"

Source = tuple[str, str]
"""Name and text of a cell."""


def folder() -> Path:
    """Return the folder of the notebooks: of the checkout, or shipped inside the package.

    Raises
    ------
    FileNotFoundError
        If neither exists.
    """
    package = Path(__file__).parents[1]
    for place in (package.parents[1] / "book", package / "_book"):
        if (place / "intro.md").exists() or (place.name == "_book" and place.is_dir()):
            return place
    raise FileNotFoundError("the notebooks are missing: they lie beside `lib`, or in the package")


def study_cells(page: Path) -> list[Source]:
    """Return the study cells of a notebook in their order; their names say which cell it is.

    Raises
    ------
    DamagedFile
        If the file is no notebook.
    OSError
        If it cannot be read.
    """
    with reading(page, "no notebook"):
        cells = json.loads(page.read_text("utf-8"))["cells"]
        return [
            (f"{page}[{cell['id']}]", "".join(cell["source"]))
            for cell in cells
            if cell["cell_type"] == "code" and STUDY in cell["metadata"].get("tags", ())
        ]


def run(cells: Iterable[Source], namespace: dict[str, Any]) -> None:
    """Run cells in a namespace; tracebacks and `inspect` find their lines by the cells' names."""
    for name, text in cells:
        linecache.cache[name] = len(text), None, text.splitlines(keepends=True), name
        exec(compile(text, name, "exec"), namespace)


def code_of(function: Callable[..., Any]) -> str | None:
    """Hash what a function of study cells computes with; ``None`` if its source is not known.

    That is the function without its decorators, the definitions that it reaches, and the modules
    that these import (`dependencies.code_digest`).
    """
    texts = sources(function.__module__)
    return None if texts is None else Definitions(texts).digest(function.__name__)


def sources(module: str) -> tuple[str, ...] | None:
    """Return the texts of the cells of a module, or of those that were run in this notebook."""
    if module.startswith(BOOK):
        return _of_page(module.removeprefix(BOOK))
    if module == LIVE:
        try:
            from IPython import get_ipython
        except ModuleNotFoundError:
            return None
        shell = get_ipython()
        return None if shell is None else tuple(shell.user_ns.get("In", ()))
    spec = find_spec(module)
    if spec is None or not spec.origin or not spec.origin.endswith(".py"):
        return None
    return (Path(spec.origin).read_text("utf-8"),)


@cache
def _of_page(stem: str) -> tuple[str, ...]:
    return tuple(text for _, text in study_cells(folder() / f"{stem}.ipynb"))


class Definitions:
    """What the statements of cells define, and what each of them reads.

    Parameters
    ----------
    texts
        Of the cells, in the order in which they were run; what is no Python is passed over,
        as magics of a notebook are. Of two definitions of a name the last one counts.
    """

    def __init__(self, texts: Sequence[str]) -> None:
        self._statements: dict[str, ast.stmt] = {}
        for text in texts:
            try:
                tree = ast.parse(text)
            except SyntaxError:
                continue
            for statement in tree.body:
                self._statements |= dict.fromkeys(_bound(statement), statement)

    def reached(self, name: str) -> tuple[dict[str, ast.stmt], set[str]]:
        """Return the statements on which a definition depends, by name, and modules they import."""
        statements: dict[str, ast.stmt] = {}
        modules: set[str] = set()
        todo = {name}
        while todo:
            one = todo.pop()
            statement = self._statements.get(one)
            if statement is None or one in statements:
                continue
            if isinstance(statement, ast.Import | ast.ImportFrom):
                modules |= set(_imported(statement, one))
                continue
            statements[one] = statement
            todo |= _read(statement, decorated=one != name)
        return statements, modules

    def said(self, name: str) -> str | None:
        """Hash a definition and those that it reaches in the cells, whatever these import."""
        return dependencies.hashed("\n".join(self._lines(name))) if self._has(name) else None

    def keyword(self, name: str, word: str) -> str | None:
        """Hash a keyword of a definition's decorator, and what it reaches in the cells."""
        decorators = getattr(self._statements.get(name), "decorator_list", ())
        for node in (node for one in decorators for node in ast.walk(one)):
            if isinstance(node, ast.keyword) and node.arg == word:
                reached = [self.said(one) for one in sorted(_read(ast.Expr(node.value)))]
                return dependencies.hashed(repr((dependencies.meaning(node.value), reached)))
        return None

    def digest(self, name: str) -> str | None:
        """Hash a definition and what it depends on; ``None`` if there is no such definition."""
        if not self._has(name):
            return None
        _, modules = self.reached(name)
        lines = self._lines(name)
        lines += (f"{cell} {code}" for cell, code in self._of_books(modules))
        library = sorted(module for module in modules if not module.startswith(BOOK))
        lines.append(dependencies.code_digest(*library) if library else "")
        return dependencies.hashed("\n".join(sorted(lines)))

    def _has(self, name: str) -> bool:
        return name in self._statements

    def _lines(self, name: str) -> list[str]:
        statements, _ = self.reached(name)
        lines = [
            f"{one} {dependencies.meaning(_undecorated(node) if one == name else node)}"
            for one, node in statements.items()
        ]
        return sorted(lines)

    @staticmethod
    def _of_books(modules: Iterable[str]) -> Iterator[tuple[str, str | None]]:
        """Yield what other notebooks' definitions depend on, given as ``module:name``."""
        for module in modules:
            if module.startswith(BOOK):
                stem, _, name = module.removeprefix(BOOK).partition(":")
                yield module, Definitions(_of_page(stem)).digest(name)


def _bound(statement: ast.stmt) -> set[str]:
    """Return the names that a statement of a module binds."""
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return {statement.name}
    if isinstance(statement, ast.Import | ast.ImportFrom):
        return {(alias.asname or alias.name).partition(".")[0] for alias in statement.names}
    return {
        node.id
        for node in ast.walk(statement)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    }


def _read(statement: ast.stmt, *, decorated: bool = True) -> set[str]:
    """Return the names that a statement reads, but for those that it binds itself inside."""
    node = statement if decorated else _undecorated(statement)
    names = [one for one in ast.walk(node) if isinstance(one, ast.Name)]
    own: set[str] = set()
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        own = {one.arg for one in ast.walk(node) if isinstance(one, ast.arg)}
        own |= {one.id for one in names if isinstance(one.ctx, ast.Store)}
    return {one.id for one in names if isinstance(one.ctx, ast.Load)} - own


def _undecorated(statement: ast.stmt) -> ast.stmt:
    """Return a definition without its decorators, which do not say what it does."""
    if not isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return statement
    fields = dict(ast.iter_fields(statement)) | {"decorator_list": []}
    return type(statement)(**fields)


def _imported(statement: ast.Import | ast.ImportFrom, name: str) -> Iterator[str]:
    """Yield the module of ours from which an import takes a name."""
    known = dependencies.modules()
    for alias in statement.names:
        if (alias.asname or alias.name).partition(".")[0] != name:
            continue
        if isinstance(statement, ast.Import):
            yield from {alias.name} & known
        elif statement.module and statement.module.startswith(BOOK):
            yield f"{statement.module}:{alias.name}"
        elif f"{statement.module}.{alias.name}" in known:
            yield f"{statement.module}.{alias.name}"
        else:
            yield from {statement.module} & known
