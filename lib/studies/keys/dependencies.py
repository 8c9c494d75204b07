"""Dependencies of results: those on a page of the book, and those of a single module.

A page reaches the modules that its cells import, and what those import. It reads the recorded
results, tables of the package and data sets whose names stand as strings in those modules or in its
cells. What no module names could be anybody's, and counts for every page.

What a definition computes depends on less: on what it and the definitions that it reaches do, not
on their comments, nor on how a page shows it.
"""

import ast
import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.util import find_spec
from pathlib import Path

import grimp

from studies.files import reading
from studies.keys.definitions import WHOLE, Definition, Module, meaning
from studies.project import project
from studies.records import records

ROWS = "rows"
"""Folder of the recorded rows, named by chapter and study."""
OWN = ("explorables", "studies")
"""Packages that pages depend on beside those of the project."""
LEDGER = "claims.json"
REGISTRATIONS = "registrations.tsv"
BY_NAME = frozenset({"importlib", "pkgutil"})
"""Modules whose importers may import by name each of their submodules that they name as a string.

A package on the way there may name them too. If none is named, it may be any.
"""
NOT_BY_NAME = ("importlib.metadata", "importlib.resources", "importlib.util")
"""Parts of it that import nothing."""

IRRELEVANT = frozenset({"__pycache__", "front_end", "README.md"})
"""Bytecode; scripts that pages load themselves; what is read by people."""
COMPUTING = ("studies.checks", "studies.files", "studies.intervals", "studies.sweep")
"""Modules of this package on which results depend; the others show, judge or store."""
RECORDS = "studies.records"
"""Names the folder of what is recorded: results depend on what is read there."""
EFFECTS = "(effects)"
"""Name of the effects of a module when it is imported, beside binding names."""


def known_packages() -> tuple[str, ...]:
    """Return the packages that are looked into: those of the project, and our own."""
    return (*project().packages, *OWN)


class Imports:
    """The import graph of packages; at those that only show, the way of a result ends."""

    def __init__(
        self,
        packages: tuple[str, ...] | None = None,
        showing: tuple[str, ...] | None = None,
        folder: Path | None = None,
    ) -> None:
        packages = known_packages() if packages is None else packages
        kept = None if folder is None else str(folder)
        self._graph = grimp.build_graph(*packages, include_external_packages=True, cache_dir=kept)
        self._showing = (*(project().showing if showing is None else showing), *OWN)
        self._steps: dict[tuple[str, bool], tuple[tuple[str, bool], ...]] = {}
        self._meanings: dict[str, str] = {}
        self._defined: dict[str, Module] = {}
        self._words: dict[str, frozenset[str]] = {}
        self.files = {
            name: _file(name) for name in self._graph.modules if name.split(".")[0] in packages
        }

    def reached(self, modules: Iterable[str], *, results: bool = False) -> set[str]:
        """Return the modules that run when some are imported: these, and what they import.

        For `results`, without what none depends on: what shows them, and packages that were not
        themselves imported but stand above a module that was.
        """
        todo = {(name, True) for name in modules}
        seen: set[tuple[str, bool]] = set()
        while todo:
            if results:
                todo = {(name, meant) for name, meant in todo if meant and not self._shows(name)}
            seen |= todo
            for step in todo - self._steps.keys():
                self._steps[step] = tuple(self._next(*step))
            todo = {step for one in todo for step in self._steps[one]} - seen
        return {name for name, _ in seen}

    def digest(self, *asked: str, named: frozenset[str] = frozenset()) -> str:
        """Hash what the results of definitions depend on: `code_digest` of these packages."""
        pairs = [(module, name) for module, _, name in (one.partition(":") for one in asked)]
        found = self.definitions(pairs)
        digest = hashlib.sha256()
        for module, name in sorted(found):
            digest.update(f"{module}:{name} {found[module, name].meaning}\n".encode())
        modules = {module for module, _ in (*pairs, *found)}
        for file in self.read(modules, named):
            digest.update(f"{file.name} {_content(file, file.stat().st_mtime_ns)}\n".encode())
        return digest.hexdigest()[:16]

    def modules_digest(self, *modules: str, within: tuple[str, ...]) -> str:
        """Hash whole modules of some packages: those that are reached when others are imported."""
        self._check(modules)
        digest = hashlib.sha256()
        for name in sorted(self.reached(modules, results=True)):
            if any(f"{name}.".startswith(f"{package}.") for package in within):
                if name not in self._meanings:
                    self._meanings[name] = meaning(ast.parse(self.files[name].read_bytes()))
                digest.update(f"{name} {self._meanings[name]}\n".encode())
        return digest.hexdigest()[:16]

    def _check(self, modules: Iterable[str]) -> None:
        for name in modules:
            if name not in self.files:
                tops = sorted({known.partition(".")[0] for known in self.files})
                raise ValueError(f"no module {name!r} in {', '.join(tops)}")

    def definitions(self, asked: Iterable[tuple[str, str]]) -> dict[tuple[str, str], Definition]:
        """Return the definitions that the results of some depend on, by module and name.

        With them comes what the modules do when they are imported, under no name. Those that only
        show are left out.
        """
        todo = {*asked}
        self._check({module for module, _ in todo})
        imported = self.reached({module for module, _ in todo}, results=True)
        todo |= {(name, EFFECTS) for name in imported}
        seen: set[tuple[str, str]] = set()
        found: dict[tuple[str, str], Definition] = {}
        while todo:
            seen |= todo
            todo = {step for one in todo for step in self._follow(*one, found)} - seen
        return found

    def _follow(
        self, module: str, name: str, found: dict[tuple[str, str], Definition]
    ) -> Iterator[tuple[str, str]]:
        """Put a definition among those found, and yield what it reads."""
        if module not in self.files or self._shows(module):
            return
        own = self._definitions_in(module)
        whole = f"{module}.{name}"
        if name == EFFECTS:
            definition = own.effects()
        elif name in own.names:
            definition = own.definition(name)
        elif whole in self.files:
            yield whole, WHOLE
            return
        elif name in own.offered:
            yield f"{module}.{own.offered[name]}", name
            return
        else:  # all of it, or a name that it makes when it is asked for
            yield from ((module, one) for one in own.names)
            yield from ((other, WHOLE) for other in self._named_below(module))
            return
        if definition is not None:
            found[module, name] = definition
            yield from ((module, one) for one in definition.names)
            yield from definition.taken

    def _definitions_in(self, module: str) -> Module:
        if module not in self._defined:
            self._defined[module] = self.parsed(module, self.files[module].read_bytes())
        return self._defined[module]

    def parsed(self, module: str, text: bytes) -> Module:
        """Return what a module of these packages defines, or would with another text."""
        is_package = self.files[module].name == "__init__.py"
        package = module if is_package else module.rpartition(".")[0]
        return Module(ast.parse(text), package, self.files)

    def read(self, modules: Iterable[str], named: frozenset[str] = frozenset()) -> list[Path]:
        """Return the recorded files that modules read and name, or whose names are given to them.

        Results are none of them, which have keys of their own, nor what is said of results.
        """
        asked = {*modules}
        ours = {name for name in asked if not self._shows(name)}
        asked |= {m for name in ours for m in self._graph.find_modules_directly_imported_by(name)}
        readers = {name for name in asked if self._reads(name)}
        if not readers:
            return []
        named = named.union(*map(self._said, ours | readers))
        return [
            file
            for file in sorted(records().iterdir())
            if {file.name, file.stem} & named
            and file.is_file()
            and file.name not in (LEDGER, REGISTRATIONS)
            and not file.with_suffix(".npz").exists()
        ]

    def _reads(self, name: str) -> bool:
        """Tell whether a module that shows says where records are, or asks the one that does."""
        return name == RECORDS or (
            self._shows(name) and RECORDS in self._graph.find_modules_directly_imported_by(name)
        )

    def _shows(self, name: str) -> bool:
        shows = any(f"{name}.".startswith(f"{package}.") for package in self._showing)
        return shows and name not in COMPUTING

    def _next(self, name: str, meant: bool) -> Iterator[tuple[str, bool]]:
        """Yield what a module imports, whether it was meant or only stands above another one."""
        imported = self._graph.find_modules_directly_imported_by(name)
        yield from ((other, True) for other in imported & self.files.keys())
        if meant:
            yield from ((other, True) for other in self._named_below(name))
        if "." in name:
            yield name.rpartition(".")[0], False

    def _named_below(self, name: str) -> set[str]:
        """Return the modules below a package that it may import by name."""
        imported = self._graph.find_modules_directly_imported_by(name)
        if not any(self._is_by_name(name, top) for top in imported & BY_NAME):
            return set()
        below = self._graph.find_descendants(name)
        return {other for other in below if self._is_named(other, name)} or below

    def _is_by_name(self, importer: str, imported: str) -> bool:
        """Tell whether one of the lines that import such a package takes what imports by name."""
        found = self._graph.get_import_details(importer=importer, imported=imported)
        return not all(any(part in line["line_contents"] for part in NOT_BY_NAME) for line in found)

    def _is_named(self, module: str, top: str) -> bool:
        """Tell whether a package, or those between, name each step of the way to a module."""
        while module != top:
            above, _, step = module.rpartition(".")
            if not any(step in self._said(name) for name in (above, top)):
                return False
            module = above
        return True

    def _said(self, module: str) -> frozenset[str]:
        if module not in self._words:
            tree = ast.parse(self.files[module].read_bytes())
            self._words[module] = frozenset(text.strip(".") for text in texts(tree))
        return self._words[module]


def code_digest(*asked: str, named: frozenset[str] = frozenset()) -> str:
    """Hash the code on which the results of some definitions depend.

    That is what these definitions and all those that they read do: a comment, a docstring or a line
    that is broken elsewhere changes nothing, nor does what they do not reach of a module, nor what
    only shows. Where a module lies, and which Python reads it, makes no
    difference. What they read of the records counts, too, but for results.

    Parameters
    ----------
    *asked
        Modules of the packages, or definitions in them: ``"robots.kalman:predict"``.
    named
        Texts of who asks, which may name a file of the records.

    Raises
    ------
    ValueError
        If there is no such module.
    """
    return _imports().digest(*asked, named=named)


def worlds_digest(*modules: str) -> str:
    """Hash the modules of the worlds that others reach, each whole.

    Raises
    ------
    ValueError
        If there is no such module.
    """
    return _imports().modules_digest(*modules, within=project().worlds)


def modules() -> frozenset[str]:
    """Return the names of all modules of these packages."""
    return frozenset(_imports().files)


def hashed(text: str) -> str:
    """Return the short hash by which results are told apart."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


@lru_cache(maxsize=64)
def _content(file: Path, changed: int) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()[:16]


@cache
def _imports() -> Imports:
    return Imports()


@dataclass(frozen=True)
class Said:
    """References of code to other code.

    Parameters
    ----------
    imported
        Pairs of a module and a name that is taken from it, which is empty for the module alone.
    texts
        That stand in the code.
    """

    imported: frozenset[tuple[str, str]]
    texts: frozenset[str]


def said(*trees: ast.AST) -> Said:
    """Return what code says of other code."""
    imported: set[tuple[str, str]] = set()
    for node in (node for tree in trees for node in ast.walk(tree)):
        if isinstance(node, ast.Import):
            imported |= {(alias.name, "") for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            imported |= {(node.module, alias.name) for alias in node.names}
    return Said(frozenset(imported), texts(*trees))


def said_in(file: Path) -> Said | None:
    """Return what a module says, or a page in its cells; ``None`` if a page has no code."""
    if file.suffix == ".py":
        return said(ast.parse(file.read_bytes()))
    cells = code(file)
    return said(*cells) if cells else None


class Dependencies:
    """The import graph of a repository's packages, and what their modules name.

    Parameters
    ----------
    root
        The repository.
    packages
        Its packages; those of the project by default.
    reads
        Returns what a file says, as `said_in` does.
    folder
        Where the graph of imports is kept for another process, if anywhere.
    """

    def __init__(
        self,
        root: Path,
        packages: tuple[str, ...] | None = None,
        reads: Callable[[Path], Said | None] = said_in,
        folder: Path | None = None,
    ) -> None:
        self._root = root
        self._reads = cache(reads)
        packages = known_packages() if packages is None else packages
        self.imports = Imports(packages, folder=folder)
        self._names = {name: self._reads(file).texts for name, file in self.imports.files.items()}
        pages = filter(None, map(self._reads, (root / "book").glob("*.ipynb")))
        self._named = frozenset().union(*self._names.values(), *(page.texts for page in pages))
        folders = (root / "book" / "_data", *(_file(name).parent for name in packages))
        self.stored = {
            file: _calls(file.relative_to(folder))
            for folder in folders
            for file in sorted(folder.rglob("*"))
            if file.is_file()
            and file.suffix != ".py"
            and not any(map(_is_irrelevant, file.relative_to(folder).parts))
        }

    def key(self, page: Path) -> str | None:
        """Hash all that the results on a page depend on, or return ``None`` if it has no code."""
        own = self._reads(page)
        if own is None:
            return None
        cells = (own,)
        modules = self.modules(cells)
        named = self.named(cells, modules)
        digest = hashlib.sha256((self._root / "constraints.txt").read_bytes())
        for name in sorted(modules):
            digest.update(name.encode() + self.imports.files[name].read_bytes())
        for notebook in self._read_by(cells):
            if notebook != page:  # one that asks its own module is the cells that stand here
                digest.update(notebook.read_bytes())
        for file in self.data(named):
            digest.update(file.name.encode())
            text = file.read_bytes()
            with reading(file, "is not what is recorded there"):
                if file.name == LEDGER:
                    text = claims_of(page.stem, named, text)
                elif file.name == REGISTRATIONS:
                    text = registrations_of(named, text)
            digest.update(text)
        data = project().data
        for name in data.names():  # a page differs with its recording there or not
            if name in named or name not in self._named:
                digest.update(f"{name} {data.find(name) is not None}".encode())
        return digest.hexdigest()[:16]

    def modules(self, cells: Iterable[Said]) -> set[str]:
        """Return the modules that run when cells do: those they import, and what those import."""
        return self.imports.reached(self.imported(cells))

    def imported(self, cells: Iterable[Said]) -> Iterator[str]:
        """Yield the modules that cells import, those of other notebooks' cells too."""
        files, cells = self.imports.files, list(cells)
        for page in self._below(cells):
            cells += filter(None, [self._reads(page)])
        for module, name in {pair for cell in cells for pair in cell.imported}:
            if f"{module}.{name}" in files:
                yield f"{module}.{name}"
            elif module in files:
                yield module

    def notebooks(self, cells: Iterable[Said]) -> Iterator[Path]:
        """Yield the notebooks whose modules cells import."""
        pairs = {pair for cell in cells for pair in cell.imported}
        called = {name for module, taken in pairs for name in (module, f"{module}.{taken}")}
        above = project().modules
        stems = (name.removeprefix(above) for name in called if name.startswith(above))
        pages = (self._root / "book" / f"{stem}.ipynb" for stem in stems)
        yield from (page for page in pages if page.exists())

    def _below(self, cells: Iterable[Said]) -> set[Path]:
        """Return the notebooks whose modules cells import, and those that these import."""
        todo, seen = {*self.notebooks(cells)}, set()
        while todo:
            seen |= todo
            read = filter(None, map(self._reads, todo))
            todo = {*self.notebooks(read)} - seen
        return seen

    def _read_by(self, cells: Iterable[Said]) -> list[Path]:
        """Return the notebooks whose cells a page runs; one that asks all chapters reads all.

        Who reads the book's contents reads its other pages, too.
        """
        book, imported = self._root / "book", set(self.imported(cells))
        if project().reading_pages in imported:
            return sorted(
                file for kind in ("*.ipynb", "*.md", "_toc.yml") for file in book.glob(kind)
            )
        if project().reading_notebooks in imported:
            return sorted(book.glob("*.ipynb"))
        return sorted(self._below(cells))

    def named(self, cells: Iterable[Said], modules: Iterable[str]) -> frozenset[str]:
        """Return the texts that stand in cells, and in modules and notebooks that run with them.

        Of these notebooks also their modules' names, by which the rows of their studies are called.
        """
        cells = list(cells)
        read = (self._reads(page) for page in self._read_by(cells) if page.suffix == ".ipynb")
        own = frozenset().union(*(cell.texts for cell in (*cells, *filter(None, read))))
        rows = {f"{project().modules}{text}" for text in own}
        return own.union(rows, *(self._names[name] for name in modules))

    def data(self, named: frozenset[str]) -> list[Path]:
        """Return the files that are named, and those that no module names."""
        return [
            file
            for file, calls in self.stored.items()
            if calls & named or (calls.isdisjoint(self._named) and file.parent.name != ROWS)
        ]


def code(page: Path) -> list[ast.Module]:
    """Return the code cells of a notebook, stored as such or as Markdown."""
    return list(_cells(page, page.read_text("utf-8")))


@lru_cache(maxsize=64)  # a page is asked for by all that import it
def _cells(page: Path, text: str) -> tuple[ast.Module, ...]:
    if page.suffix == ".ipynb":
        stored = json.loads(text)["cells"]
        sources = ("".join(cell["source"]) for cell in stored if cell["cell_type"] == "code")
        return tuple(ast.parse(source, str(page)) for source in sources)
    # half a second, which who only asks for a digest need not wait
    from myst_nb.core.config import NbParserConfig
    from myst_nb.core.read import create_nb_reader
    from myst_parser.config.main import MdParserConfig

    reader = create_nb_reader(str(page), MdParserConfig(), NbParserConfig(), text)
    cells = reader.read(text).cells if reader else []
    return tuple(ast.parse(cell.source, str(page)) for cell in cells if cell.cell_type == "code")


def claims_of(chapter: str, named: frozenset[str], ledger: bytes) -> bytes:
    """Return what a page reads of the ledger.

    That is a chapter's own claims and those it names; all of it for a page that is no chapter.
    """
    claims = json.loads(ledger)["claims"]
    if chapter not in {claim["chapter"] for claim in claims}:
        return ledger
    read = [claim for claim in claims if claim["chapter"] == chapter or claim["id"] in named]
    return json.dumps(read).encode()


def registrations_of(named: frozenset[str], text: bytes) -> bytes:
    """Return the registrations of the claims that a page names; all of them if it names none."""
    lines = text.splitlines()
    read = [line for line in lines if line.partition(b"\t")[0].decode() in named]
    return b"\n".join(read or lines)


def _file(module: str) -> Path:
    """Return the file of a module without importing it."""
    top, *rest = module.split(".")
    path = Path(find_spec(top).origin).parent.joinpath(*rest)
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def _is_irrelevant(part: str) -> bool:
    """Tell whether nothing depends on what lies there: what is hidden may be unfinished, too."""
    return part in IRRELEVANT or part.startswith(".")


def _calls(file: Path) -> frozenset[str]:
    """Return what code may call a file: its name, or that of a folder, less the suffix.

    Rows are those of one chapter, whose name stands before the study's.
    """
    if file.parent.name == ROWS:
        return frozenset({f"{project().modules}{file.name.partition('.')[0]}"})
    return frozenset({file.name, *(part.partition(".")[0] for part in file.parts)})


def texts(*trees: ast.AST) -> frozenset[str]:
    """Return the texts that stand in code."""
    nodes = (node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Constant))
    return frozenset(node.value for node in nodes if isinstance(node.value, str))
