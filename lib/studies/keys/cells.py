"""Study cells: the code of a chapter that is in its notebook, read as a module reads a file.

A cell of ``<stem>.ipynb`` with the tag ``study`` is a part of a module of that name
(:mod:`studies.notebooks`). What one of its functions computes
depends on its own source and on the definitions that this reaches, in the cells and in the modules
that they import: `code_of` hashes that and nothing else. In a notebook the same functions live in
``__main__``, where a reader edits them; there the cells that were run are what counts, so that the
hash is that of the module's function as long as the two say the same.
"""

import ast
import json
import linecache
import symtable
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from studies.files import reading
from studies.keys import dependencies
from studies.keys.definitions import asked_of, meaning
from studies.project import project

STUDY = "study"
"""The tag of a cell that is a part of the chapter's module."""
CLAIM, SAYS = "claim", "says"
"""Methods of a study that declare a claim, and say its measures."""
LIVE = "__main__"

Source = tuple[str, str]
"""Name and text of a cell."""


def folder() -> Path:
    """Return the folder of the notebooks.

    Raises
    ------
    FileNotFoundError
        If the project says that there is none.
    """
    return project().notebooks()


def in_cells(module: str) -> bool:
    """Tell whether a module is made of study cells: those of a notebook, or of this process."""
    return module == LIVE or module.startswith(project().modules)


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
    return None if texts is None else definitions(texts).digest(function.__qualname__)


def tried_on(function: Callable[..., Any]) -> str | None:
    """Hash a trial of study cells and the world it stands in; ``None`` if its source is not known.

    The rooms of the library do not count (`Definitions.tried`).
    """
    found = sources(function.__module__)
    return None if found is None else definitions(found).tried(function.__qualname__)


def declared_in(module: str, claim: str) -> tuple[str, str]:
    """Return the name of a claim in the module of a notebook, and the cell that declares it.

    Both are empty where there is none.
    """
    for cell, text in study_cells(folder() / f"{module.removeprefix(project().modules)}.ipynb"):
        if name := definitions((text,)).declares(claim)[0]:
            return name, Path(cell).name
    return "", ""


def sources(module: str) -> tuple[str, ...] | None:
    """Return the texts of the cells of a module, or of those that were run in this notebook."""
    above = project().modules
    if module.startswith(above):
        return _of_page(module.removeprefix(above))
    if module == LIVE:
        notebook = shell()
        return None if notebook is None else _run_in(notebook)
    spec = find_spec(module)
    if spec is None or not spec.origin or not spec.origin.endswith(".py"):
        return None
    return (Path(spec.origin).read_text("utf-8"),)


def shell() -> Any:
    """Return the shell of the notebook that is run in this process, ``None`` if it runs none."""
    try:
        from IPython import get_ipython
    except ModuleNotFoundError:
        return None
    return get_ipython()


def _run_in(notebook: Any) -> tuple[str, ...]:
    """Return the texts of the cells that were run; where no history is kept, as compiled."""
    history = tuple(notebook.user_ns.get("In", ()))
    if any(history):
        return history
    compiled = getattr(getattr(notebook, "compile", None), "_filename_map", ())  # nbval keeps none
    return tuple("".join(linecache.getlines(name)) for name in compiled)


@cache
def _of_page(stem: str) -> tuple[str, ...]:
    return tuple(text for _, text in study_cells(folder() / f"{stem}.ipynb"))


class Definitions:
    """Names that the statements of cells define, and those that each of them reads.

    Parameters
    ----------
    texts
        Of the cells, in the order in which they were run; what is no Python is passed over,
        as magics of a notebook are. Of two definitions of a name the last one counts, and what
        adds to it since: ``RULES |= …``, ``RULES[…] = …``.
    """

    def __init__(self, texts: Sequence[str]) -> None:
        self._statements: dict[str, list[ast.stmt]] = {}
        for text in texts:
            for statement, bound, added in _stated(text):
                for name in bound:
                    self._statements[name] = [statement]
                if added is not None:
                    self._statements.setdefault(added, []).append(statement)

    def reached(self, name: str) -> tuple[dict[str, list[ast.stmt]], set[str], set[str]]:
        """Return what a definition depends on: statements by name, what they import, modules.

        Of modules those that are ours, with the name that is taken from one: ``module:name``. One
        that a function itself imports is taken whole: ``module:``.
        """
        statements: dict[str, list[ast.stmt]] = {}
        imports: set[str] = set()
        modules: set[str] = set()
        todo = {name}
        while todo:
            one = todo.pop()
            if one not in self._statements or one in statements:
                continue
            statements[one] = []
            for statement in self._statements[one]:
                if isinstance(statement, ast.Import | ast.ImportFrom):
                    alias = next(alias for alias in statement.names if _as(alias) == one)
                    imports.add(f"{getattr(statement, 'module', None)} {alias.name} {one}")
                    modules |= _ours(statement, alias)
                    continue
                statements[one].append(statement)
                todo |= _read(statement, decorated=one != name)
                modules |= _inside(statement)
        return {one: parts for one, parts in statements.items() if parts}, imports, modules

    def each(self, known: frozenset[str]) -> dict[str, tuple[str, set[str], set[str]]]:
        """Return each definition's own hash, the names it reads, and modules of some, by name.

        Decorators count; modules are named as in `reached`.
        """
        found = {}
        for name, statements in self._statements.items():
            own: list[str] = []
            read: set[str] = set()
            modules: set[str] = set()
            for statement in statements:
                if isinstance(statement, ast.Import | ast.ImportFrom):
                    alias = next(alias for alias in statement.names if _as(alias) == name)
                    own.append(f"{getattr(statement, 'module', None)} {alias.name}")
                    modules |= _ours(statement, alias, known)
                    continue
                own.append(meaning(statement))
                read |= _read(statement, decorated=True)
                modules |= _inside(statement, known)
            names = read & self._statements.keys()
            found[name] = dependencies.hashed(" ".join(own)), names, modules
        return found

    def said(self, name: str) -> str | None:
        """Hash a definition and those that it reaches in the cells, whatever these import."""
        return dependencies.hashed("\n".join(self._lines(name))) if self._has(name) else None

    def keyword(self, claim: str, word: str) -> str | None:
        """Hash a keyword of the call that declares a claim, and what it reaches in the cells."""
        call = self.declares(claim)[1]
        found = [one.value for one in call.keywords if one.arg == word] if call else []
        return self._expression(found[0]) if found else None

    def declares(self, claim: str) -> tuple[str, ast.Call | None]:
        """Return the name that a claim has in the cells, and the call that declares it."""
        for name, statements in self._statements.items():
            for call in (call for one in statements for call in _calls(one)):
                if call.args and _constant(call.args[0]) == claim:
                    return name, call
        return "", None

    def _expression(self, node: ast.AST) -> str:
        """Hash an expression and what it reaches; of measures that a study says, these alone."""
        nodes = [*ast.walk(node)]
        names = {one.id for one in nodes if isinstance(one, ast.Name)}
        reached = [self.said(one) for one in sorted(names) if not self._measures(one)]
        measures = [
            self._expression(say)
            for call in nodes
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)
            for name, say in self._measures(call.func.id).items()
            if name in map(_constant, call.args)
        ]
        return dependencies.hashed(repr((meaning(node), reached, *measures)))

    def _measures(self, name: str) -> dict[str, ast.AST]:
        """Return the measures of a study for which a name stands: expressions without words."""
        for one in self._statements.get(name, ()):
            call = getattr(one, "value", None)
            if isinstance(call, ast.Call) and getattr(call.func, "attr", "") == SAYS:
                tuples = {f"{say.arg}": getattr(say.value, "elts", ()) for say in call.keywords}
                return {say: ast.List([*parts[:-1]], ast.Load()) for say, parts in tuples.items()}
        return {}

    def digest(self, name: str) -> str | None:
        """Hash a definition and what it depends on; ``None`` if there is no such definition.

        Of a notebook that is imported whole only those names count that are asked of it.
        """
        if not self._has(name):
            return None
        statements, imports, modules = self.reached(name)
        modules = _asked_of_books(statements, imports, modules)
        lines = self._lines(name)
        lines += sorted(imports)
        lines += (f"{cell} {code}" for cell, code in self._of_books(modules, Definitions.digest))
        library = sorted(_refined(statements, imports, modules))
        named = dependencies.texts(*(node for parts in statements.values() for node in parts))
        lines.append(dependencies.code_digest(*library, named=named) if library else "")
        return dependencies.hashed("\n".join(sorted(lines)))

    def tried(self, name: str) -> str | None:
        """Hash a definition, those it reaches in cells, and the worlds: no algorithm of a room.

        What is tried may be mended, and what it is tried on may not: see `registration`.
        """
        if not self._has(name):
            return None
        statements, imports, modules = self.reached(name)
        modules, book = _asked_of_books(statements, imports, modules), project().modules
        own = (book, *(f"{package}." for package in project().worlds))
        lines = self._lines(name)
        lines += (
            line for line in imports if any(f"{w}.".startswith(own) for w in line.split()[:2])
        )
        lines += (f"{cell} {code}" for cell, code in self._of_books(modules, Definitions.tried))
        library = {module.partition(":")[0] for module in modules if not module.startswith(book)}
        lines.append(dependencies.worlds_digest(*sorted(library)))
        return dependencies.hashed("\n".join(sorted(lines)))

    def _has(self, name: str) -> bool:
        return name in self._statements

    def _lines(self, name: str) -> list[str]:
        statements, _, _ = self.reached(name)
        lines = [
            f"{one} {_meaning(node, decorated=one != name)}"
            for one, parts in statements.items()
            for node in parts
        ]
        return sorted(lines)

    @staticmethod
    def _of_books(
        modules: Iterable[str], digest: Callable[["Definitions", str], str | None]
    ) -> Iterator[tuple[str, str | None]]:
        """Yield a digest of other notebooks' definitions, given as ``module:name``.

        Without a name, of all of its definitions.
        """
        book = project().modules
        for module in modules:
            if module.startswith(book):
                stem, _, name = module.removeprefix(book).partition(":")
                cells = definitions(_of_page(stem))
                names = [name] if name else sorted(cells._statements)
                yield module, " ".join(f"{one} {digest(cells, one)}" for one in names)


@lru_cache(maxsize=32)
def definitions(texts: tuple[str, ...]) -> Definitions:
    """Return the definitions of cells, which are read once."""
    return Definitions(texts)


@lru_cache(maxsize=2048)  # with every cell that is run a notebook has one text more
def _stated(text: str) -> tuple[tuple[ast.stmt, frozenset[str], str | None], ...]:
    """Return the statements of a cell, the names that each binds, and the one it adds to."""
    try:
        statements = ast.parse(text).body
    except SyntaxError:
        return ()
    added = [_added_to(statement) for statement in statements]
    bound = [frozenset(_bound(one) - {name}) for one, name in zip(statements, added, strict=True)]
    return tuple(zip(statements, bound, added, strict=True))


def _tables(node: ast.stmt) -> Iterator[symtable.SymbolTable]:
    """Yield what Python knows of the names of a statement: of itself, and of functions in it."""
    todo = [symtable.symtable(ast.unparse(node), "", "exec")]
    while todo:
        yield (table := todo.pop())
        todo += table.get_children()


def _bound(statement: ast.stmt) -> set[str]:
    """Return the names that a statement of a module binds."""
    own = next(_tables(statement)).get_symbols()
    return {name.get_name() for name in own if name.is_assigned() or name.is_imported()}


def _calls(statement: ast.stmt) -> Iterator[ast.Call]:
    """Yield the calls that declare the claim of a statement: a decorator, or what is assigned."""
    for node in (*getattr(statement, "decorator_list", ()), getattr(statement, "value", None)):
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == CLAIM:
            yield node


def _constant(node: ast.AST) -> Any:
    """Return the constant that an expression is, ``None`` if it is none."""
    return getattr(node, "value", None)


def _added_to(statement: ast.stmt) -> str | None:
    """Return the name to whose value a statement adds, or of which it sets a part."""
    if isinstance(statement, ast.AugAssign):
        target = statement.target
    elif isinstance(statement, ast.Assign) and not isinstance(statement.targets[0], ast.Name):
        target = statement.targets[0]
    else:
        return None
    while isinstance(target, ast.Subscript | ast.Attribute):
        target = target.value
    return target.id if isinstance(target, ast.Name) else None


@lru_cache(maxsize=8192)
def _meaning(statement: ast.stmt, *, decorated: bool) -> str:
    """Hash a statement."""
    return meaning(statement if decorated else _undecorated(statement))


@lru_cache(maxsize=8192)
def _read(statement: ast.stmt, *, decorated: bool) -> frozenset[str]:
    """Return the names of the module that a statement reads, functions inside it, too."""
    return frozenset(
        name.get_name()
        for table in _tables(statement if decorated else _undecorated(statement))
        for name in table.get_symbols()
        if name.is_referenced() and (name.is_global() or table.get_type() == "module")
    )


def _refined(
    statements: Mapping[str, Iterable[ast.stmt]], imports: Iterable[str], modules: set[str]
) -> set[str]:
    """Return modules of the library with the names that statements ask of them, where known."""
    asked: dict[str, set[str] | None] = {}
    nodes = _nodes(statements)
    for module, imported, alias in map(str.split, imports):
        whole = imported if module == "None" else f"{module}.{imported}"
        if whole in modules:
            by_path = module == "None" and alias != imported and alias == imported.split(".")[0]
            names = None if by_path else asked_of(alias, nodes)
            before = asked.get(whole, set())
            asked[whole] = before | names if names and before is not None else None
    found = (one for one in modules if not one.startswith(project().modules))
    return {f"{one}:{name}" if name else one for one in found for name in asked.get(one) or ("",)}


def _asked_of_books(
    statements: Mapping[str, Iterable[ast.stmt]], imports: Iterable[str], modules: set[str]
) -> set[str]:
    """Return modules with the names that are asked of other notebooks, where these are known.

    A notebook that is handed on whole, or that a function itself imports, stays whole.
    """
    found, nodes, book = set(modules), _nodes(statements), project().modules
    for module, imported, alias in map(str.split, imports):
        asked = asked_of(alias, nodes) if f"{module}." == book else None
        if asked is not None:
            whole = f"{book}{imported}:"
            found = found - {whole} | {f"{whole}{one}" for one in asked}
    return found


def _nodes(statements: Mapping[str, Iterable[ast.stmt]]) -> list[ast.AST]:
    return [node for parts in statements.values() for one in parts for node in ast.walk(one)]


def _inside(statement: ast.stmt, known: frozenset[str] | None = None) -> set[str]:
    """Return the modules of ours that a statement imports inside, or takes names from."""
    nodes = (n for n in ast.walk(statement) if isinstance(n, ast.Import | ast.ImportFrom))
    found = {one for node in nodes for alias in node.names for one in _ours(node, alias, known)}
    return {one if ":" in one else f"{one}:" for one in found}


def _undecorated(statement: ast.stmt) -> ast.stmt:
    """Return a definition without its decorators, which do not say what it does."""
    if not isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return statement
    fields = dict(ast.iter_fields(statement)) | {"decorator_list": []}
    return ast.copy_location(type(statement)(**fields), statement)


def _as(alias: ast.alias) -> str:
    """Return the name that an import binds."""
    return (alias.asname or alias.name).partition(".")[0]


def _ours(
    statement: ast.Import | ast.ImportFrom, alias: ast.alias, known: frozenset[str] | None = None
) -> set[str]:
    """Return the module of ours that an import takes, or takes a name from: ``module:name``."""
    known = dependencies.modules() if known is None else known
    module = getattr(statement, "module", None)
    if module is None:
        return {alias.name} & known
    book = project().modules
    if f"{module}.".startswith(book):
        return {f"{module}.{alias.name}:" if f"{module}." == book else f"{module}:{alias.name}"}
    whole = f"{module}.{alias.name}"
    if whole in known:
        return {whole}
    return {f"{module}:{alias.name}"} if module in known else set()
