"""What a change reaches is tested: ``make check``.

What has changed is git's answer: against ``HEAD`` with what is not yet committed, or against the
commit where the branch left ``--base``; of a notebook, which kinds of cells. What a change reaches
says the import graph by which pages expire (`studies.keys.dependencies`), and within
notebooks what each definition reads: so a study's trials and a claim are tested where their own
code or records have changed. What files say is kept between runs.

A word of prose reaches the tests that read prose, and its page. A study cell reaches its stem's
rows, claims, explorers, tests and page, and what other notebooks make of it. A function of a room
reaches the tests of that room and those that import it, the wrong arguments of that room, and the
studies whose code it is. What is reached farther away is counted, and left to ``make test``; so is
JupyterLab.

What lies under everything, the versions of packages for instance, is not traced: then the command
that tests everything is named, and nothing passes.
"""

import argparse
import ast
import fnmatch
import hashlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from robot_perception.project import BOOK, CHAPTERS, CONTENTS
from studies.keys import cells, definitions, dependencies
from studies.keys.dependencies import (
    EFFECTS,
    LEDGER,
    OWN,
    ROWS,
    Dependencies,
    Said,
    claims_of,
    said,
    said_in,
)
from studies.project import project
from tests.book import registry
from tests.tools.chosen import CHOSEN

ROOT = Path(__file__).parents[2]
SITE = "build/_build/html"
KEPT = "build/reached"
"""Folder of what is kept between runs."""
BROWSER = "tests/site/"
WORLDS = "data_synth"
EVERYTHING = "make test"
WORDS = (".md", ".cff", "LICENSE", ".gitignore")
"""Files at the root that run nothing; tests that read them name them."""
LIES_UNDER = ("conftest.py", "__init__.py", "reached.py", "chosen.py")
"""Files of tests that others do not import and that matter to them."""
MOST_PAGES = 2
"""More pages than so many are not built and opened here."""

MARKDOWN, CODE, STUDY = "Markdown", "code", "study"
"""Kinds of cells. Tags and kept outputs count as code."""
BY_STEM = (
    *("tests/book/test_bets.py", "tests/book/test_claims.py", "tests/book/test_exercises.py"),
    *("tests/book/test_explorers.py", "tests/book/test_finds.py", "tests/book/test_rows.py"),
    *("tests/book/test_stored.py", "tests/book/test_study_cells.py"),
)
"""Files whose tests are of what chapters declare: those are run whose stem or name is reached."""
NOTEBOOK = "tests/test_notebooks.py"
MUTANTS = "tests/test_mutants.py"
BY_ROOM = ("tests/hostile/test_hostile.py", "tests/test_bounds.py", MUTANTS)
"""Files whose tests are of rooms: those of the changed one are run."""
NO_PROSE = (
    *BY_STEM,
    *BY_ROOM,
    "tests/book/test_registry.py",
    "tests/chapters/",
    "tests/explorables/",
    "tests/studies/",
    "tests/teaching/",
    "tests/test_cli.py",
    "tests/test_names.py",
    "tests/test_reached.py",
    "tests/test_trackers.py",
)
"""Files of tests, or folders, that read code of notebooks and no Markdown, but for the contents."""


@dataclass(frozen=True)
class Reached:
    """What is to be run.

    Parameters
    ----------
    tests
        Files of tests, but for those of the site.
    parts
        Files of tests of which some are run, with the words that choose them.
    site
        Files of the site's tests that are run whole.
    pages
        Pages of the book that are built anew and opened, by name.
    notebooks
        Pages whose cells are run and compared.
    left
        Files of tests that are reached from farther away.
    """

    tests: frozenset[str] = frozenset()
    parts: Mapping[str, frozenset[str]] = field(default_factory=dict)
    site: frozenset[str] = frozenset()
    pages: frozenset[str] = frozenset()
    notebooks: frozenset[str] = frozenset()
    left: frozenset[str] = frozenset()

    def __or__(self, other: "Reached") -> "Reached":
        """Return what either reaches."""
        tests = self.tests | other.tests
        parts = {
            file: self.parts.get(file, frozenset()) | other.parts.get(file, frozenset())
            for file in (*self.parts, *other.parts)
            if file not in tests
        }
        return Reached(
            tests,
            parts,
            self.site | other.site,
            self.pages | other.pages,
            self.notebooks | other.notebooks,
            (self.left | other.left) - tests - parts.keys(),
        )


class Kept:
    """What files say, kept between runs by their contents.

    Parameters
    ----------
    folder
        Where; nothing is kept without one.
    """

    modules: frozenset[str] = frozenset()
    """Those that are told from others in notebooks' cells."""

    def __init__(self, folder: Path | None = None) -> None:
        sources = (Path(module.__file__) for module in (cells, definitions, dependencies, registry))
        code = b"".join(source.read_bytes() for source in (*sources, Path(__file__)))
        self._file = folder and folder / f"{hashlib.sha256(code).hexdigest()[:16]}.json"
        known = self._file and self._file.exists()
        self._known: dict[str, Any] = json.loads(self._file.read_text("utf-8")) if known else {}
        self._asked: dict[str, Any] = {}

    def get(self, kind: str, text: bytes, make: Any) -> Any:
        """Return what `make` gives of a file's bytes, in the types of JSON."""
        key = f"{kind} {hashlib.sha256(text).hexdigest()}"
        if key not in self._asked:
            self._asked[key] = self._known[key] if key in self._known else make()
        return self._asked[key]

    def said(self, file: Path) -> Said | None:
        """Return what a file says (`dependencies.said_in`)."""
        found = self.get(f"said {file.suffix}", file.read_bytes(), lambda: _plain(said_in(file)))
        return _said(found)

    def notebook(self, text: bytes) -> dict[str, Any]:
        """Return what a notebook's cells are and define; nothing of an empty text."""
        return self.get("notebook", text, lambda: _read(text, self.modules))

    def write(self) -> None:
        """Keep what was asked for, and nothing else."""
        if self._file and self._asked.keys() != self._known.keys():
            self._file.parent.mkdir(parents=True, exist_ok=True)
            for old in self._file.parent.glob("*.json"):
                old.unlink()
            self._file.write_text(json.dumps(self._asked), "utf-8")


def _plain(found: Said | None) -> list | None:
    return found and [sorted(found.imported), sorted(found.texts)]


def _said(found: list | None) -> Said | None:
    return found and Said(frozenset(map(tuple, found[0])), frozenset(found[1]))


def _read(text: bytes, modules: frozenset[str]) -> dict[str, Any]:
    """Return hashes of kinds of cells, what study cells say, define and declare."""
    if not text:
        return {"kinds": {}, "said": None, "defined": {}, "declared": []}
    kinds: dict[str, list] = {MARKDOWN: [], CODE: [], STUDY: []}
    for cell in json.loads(text)["cells"]:
        source, tags = "".join(cell["source"]), cell["metadata"].get("tags", [])
        kind = MARKDOWN if cell["cell_type"] != "code" else STUDY if STUDY in tags else CODE
        kinds[kind].append(source)
        kinds[CODE] += [tags, cell.get("outputs", [])] if cell["cell_type"] == "code" else []
    trees = [ast.parse(source) for source in kinds[STUDY]]
    each = cells.Definitions(kinds[STUDY]).each(modules)
    return {
        "kinds": {
            kind: hashlib.sha256(repr(texts).encode()).hexdigest() for kind, texts in kinds.items()
        },
        "said": _plain(said(*trees)) if trees else None,
        "defined": {
            name: [own, sorted(read), sorted(modules)]
            for name, (own, read, modules) in each.items()
        },
        "declared": list(registry.declared_in(kinds[STUDY])),
    }


class Reach:
    """What files of a repository are reached by changes.

    Parameters
    ----------
    root
        The repository.
    dependencies
        Its import graph.
    kept
        What files say.
    """

    def __init__(self, root: Path, dependencies: Dependencies, kept: Kept | None = None) -> None:
        self._root = root
        self._graph = dependencies
        self._kept = kept or Kept()
        self._kept.modules = frozenset(dependencies.imports.files)
        self._modules = {
            file.relative_to(root).as_posix(): name
            for name, file in dependencies.imports.files.items()
        }
        self._stored = {file.relative_to(root).as_posix() for file in dependencies.stored}
        sources = sorted((root / "tests").rglob("*.py"))
        self._tests = {self._path(file): self._kept.said(file) for file in sources}
        book = root / "book"
        files = (file for file in sorted(book.rglob("*")) if file.suffix in (".ipynb", ".md"))
        self._pages = {
            self._path(file): file.relative_to(book).with_suffix("").as_posix()
            for file in files
            if not file.relative_to(book).parts[0].startswith(("_", "."))
        }

    def of(self, name: str, was: bytes = b"") -> Reached | None:
        """Return what a changed file reaches, or ``None`` if that cannot be told.

        Parameters
        ----------
        name
            Path below the root.
        was
            What it was; nothing of a file that is new.
        """
        if not self._is_traced(name):
            return None
        kinds = self._kinds(name, was)
        changed = self._changed(name, was, kinds)
        tests: set[str] = set()
        parts: dict[str, frozenset[str]] = {}
        left: set[str] = set()
        for test in (t for t in self._tests if Path(t).name.startswith("test_")):
            asks = name in self._pages and CONTENTS in self._taken(test)
            prose = kinds == {MARKDOWN}
            if not asks and (
                not self._is_run(test, name, runs=not prose) or (prose and _is_in(test, NO_PROSE))
            ):
                continue
            if test in BY_ROOM and (rooms := self._rooms(test, name)):
                parts[test] = rooms
            elif name in self._files(test) or asks:
                tests.add(test)
            elif test in BY_STEM:
                parts[test] = changed
            elif not self._is_near(test, name):
                left.add(test)
            else:
                tests.add(test)
        pages = {p for file, p in self._pages.items() if self._is_shown(file, name, was)}
        own = {self._pages[name]} if name in self._pages else set()
        if STUDY in kinds:
            pages |= {p for file, p in self._pages.items() if name in self._page(file)[3]}
        compared = own if name.endswith(".ipynb") and kinds != {MARKDOWN} else set()
        return Reached(
            frozenset(test for test in tests if not test.startswith(BROWSER)),
            {test: words for test, words in parts.items() if words},
            frozenset(test for test in tests if test.startswith(BROWSER)),
            frozenset(pages),
            frozenset(compared),
            frozenset(left),
        )

    def _path(self, file: Path) -> str:
        return file.relative_to(self._root).as_posix()

    def _is_traced(self, name: str) -> bool:
        file, top = self._root / name, name.partition("/")[0]
        if not file.exists():  # who used it cannot be found in what there is
            return False
        if top in ("lib", *project().packages):
            return name in self._modules
        if top == "tests":
            return file.name not in LIES_UNDER
        if top == "book":
            return name in self._pages or name in self._stored or file.suffix == ".py"
        return file.parent == self._root and name.endswith(WORDS)

    def _is_run(self, test: str, name: str, *, runs: bool = True) -> bool:
        """Tell whether a file of tests reaches a changed file, or reads it; or reads it alone."""
        helpers, modules, texts, stored = self._test(test)
        if name in helpers or self._modules.get(name) in modules:
            return True
        if test.startswith(BROWSER):  # what these read is the site
            return False
        lists = (text for text in self._lists if name in self._lists[text])
        folders = {word for text in texts for word in text.split("/")}
        beside = {Path(helper).parent for helper in helpers}
        return (runs and name in stored) or any(
            _is_named(file, texts, folders, _is_data(file) and Path(file).parent in beside)
            for file in (name, *lists)
        )

    @cached_property
    def _lists(self) -> dict[str, str]:
        """Lists beside the tests, which may name files: planted errors for instance."""
        files = (self._root / "tests").rglob("*.txt")
        return {self._path(file): file.read_text("utf-8") for file in files}

    @cache  # noqa: B019 - there is one in a process
    def _files(self, test: str) -> frozenset[str]:
        """Return a file of tests, and those below ``tests`` that it imports."""
        files: set[str] = set()
        todo = {test}
        while todo:
            files |= todo
            todo = {name for file in todo for name in self._imported(file)} - files
        return frozenset(files)

    @cache  # noqa: B019
    def _test(self, test: str) -> tuple[frozenset[str], set[str], frozenset[str], set[str]]:
        """Return the files of a test, the modules that run, its texts, and what it may read."""
        files = self._files(test)
        read = [self._tests[file] for file in files]
        texts = frozenset().union(*(one.texts for one in read))
        asked = set(self._graph.imported(read))
        notebooks = self._notebooks(test, read, asked)
        found = [_said(self._kept.notebook(page.read_bytes())["said"]) for page in notebooks]
        modules = self._run(test, asked) | self._graph.modules(found)
        stored = self._graph.data(texts | self._graph.named(found, modules))
        return files, modules, texts, set(map(self._path, (*stored, *notebooks)))

    def _notebooks(self, test: str, read: list[Said], modules: set[str]) -> set[Path]:
        """Return the notebooks whose cells run with a test, of chapters as `_run` has them."""
        found = set(self._graph.notebooks(read))
        if CHAPTERS in modules:
            own = self._root / "book" / f"{Path(test).parent.name}.ipynb"
            every = {self._root / page for page in self._pages if page.endswith(".ipynb")}
            found |= {own} if own in every else every
        return {page for page in found if self._kept.notebook(page.read_bytes())["said"]}

    @cache  # noqa: B019
    def _imported(self, name: str) -> frozenset[str]:
        """Return the files below ``tests`` that one imports."""
        read = self._tests[name]
        begun = (text for text in read.texts if text.startswith("tests."))  # as f-strings begin
        imported = {f"{text}*" for text in begun if text != "tests."}
        imported |= {name for pair in read.imported for name in (pair[0], ".".join(pair))}
        paths = (text.replace(".", "/") for text in imported if text.startswith("tests"))
        patterns = [f"{path}{end}" for path in paths for end in (".py", "/__init__.py")]
        plain = {pattern for pattern in patterns if "*" not in pattern}
        wild = [pattern for pattern in patterns if "*" in pattern]
        return frozenset(plain & self._tests.keys()).union(
            *(fnmatch.filter(self._tests, pattern) for pattern in wild)
        )

    def _run(self, test: str, modules: set[str]) -> set[str]:
        """Return the modules that run with a test; of chapters asked for by name only its own."""
        imports = self._graph.imports
        own = f"{CHAPTERS}.{Path(test).parent.name}"
        if own not in imports.files or CHAPTERS not in modules:
            return imports.reached(modules)
        below = {n for n in imports.reached([CHAPTERS]) if f"{n}.".startswith(f"{own}.")}
        return imports.reached((modules | below) - {CHAPTERS})

    def _is_shown(self, page: str, name: str, was: bytes) -> bool:
        """Tell whether a page shows what follows from a changed file."""
        file = self._root / page
        included = name.startswith("book/") and name.removeprefix("book/")
        if page == name or (included and name.endswith(".py") and included in file.read_text()):
            return True
        modules, named, stored, _ = self._page(page)
        if name in stored and Path(name).name == LEDGER and was:
            now = (self._root / name).read_bytes()
            return claims_of(file.stem, named, was) != claims_of(file.stem, named, now)
        return name in stored or self._modules.get(name) in modules

    @cache  # noqa: B019
    def _page(self, page: str) -> tuple[set[str], frozenset[str], set[str], set[str]]:
        """Return the modules that run with a page, the texts it names, its data and notebooks."""
        own = self._kept.said(self._root / page)
        if own is None:
            return set(), frozenset(), set(), set()
        modules = self._graph.modules([own])
        named = self._graph.named([own], modules)
        data = set(map(self._path, self._graph.data(named)))
        return modules, named, data, set(map(self._path, self._graph.notebooks([own])))

    # What is chosen of files that are not run whole

    def _kinds(self, name: str, was: bytes) -> set[str]:
        """Return the kinds of a page's cells that have changed; none of what is no page."""
        if not name.endswith(".ipynb"):
            return {MARKDOWN} if name in self._pages else set()
        now = self._kept.notebook((self._root / name).read_bytes())["kinds"]
        before = self._kept.notebook(was)["kinds"]
        return {kind for kind in now if now[kind] != before.get(kind)} or {CODE}

    def _changed(self, name: str, was: bytes, kinds: set[str]) -> frozenset[str]:
        """Return the words that choose what a change reaches among what chapters declare."""
        file, stem = self._root / name, Path(name).stem
        if Path(name).name == LEDGER and was:
            before, now = (
                {claim["id"]: claim for claim in json.loads(text)["claims"]}
                for text in (was, file.read_bytes())
            )
            return frozenset(i for i in before.keys() | now.keys() if before.get(i) != now.get(i))
        first: dict[str, set[str]] = {}
        words: set[str] = set()
        if STUDY in kinds:
            before = self._kept.notebook(was)["defined"]
            now = self._defined.get(stem, {})
            first[stem] = {n for n in now if now[n][0] != before.get(n, [None])[0]}
        if {STUDY, CODE} & kinds:
            words.add(f"{stem}.")
        elif name in self._modules:
            changed = self._edited(self._modules[name], was)
            if not changed:
                return frozenset()
            for other, defined in self._defined.items():
                first[other] = {
                    n for n, (_, _, own) in defined.items() if self._rests(own, changed)
                }
        elif Path(name).parent.name == ROWS:
            stem, _, study = stem.partition(".")
            first[stem] = {study}
        elif name in self._stored:
            for other in self._defined:
                found = (one for one in self._declared(other) if one.name == stem)
                first[other] = {one.variable for one in found}
        elif stem in self._defined:  # what is recorded of it beside the tests
            words.add(stem)
        for other, names in self._spread(first).items():
            words |= {one.id for one in self._declared(other) if one.variable in names}
        return frozenset(words)

    @cached_property
    def _cells(self) -> dict[str, dict[str, Any]]:
        """What is kept of the study cells of each notebook that has some."""
        pages = (self._root / page for page in self._pages if page.endswith(".ipynb"))
        found = {page.stem: self._kept.notebook(page.read_bytes()) for page in pages}
        return {stem: one for stem, one in found.items() if one["said"]}

    @cached_property
    def _defined(self) -> dict[str, dict[str, list]]:
        """What study cells define, by notebook: own hash, names that are read, modules."""
        return {stem: one["defined"] for stem, one in self._cells.items()}

    def _declared(self, stem: str) -> list[registry.Declared]:
        declared = self._cells[stem]["declared"]
        return [registry.Declared(kind, stem, *names) for kind, *names in declared]

    def _edited(self, module: str, was: bytes) -> set[tuple[str, str]]:
        """Return the definitions of a module that are new or do something else than before.

        Where one is gone those that are left count as well: who read it now reads something else.
        """
        imports = self._graph.imports
        now = imports.parsed(module, imports.files[module].read_bytes())
        before = imports.parsed(module, was)
        found = {
            (module, name)
            for name in now.names
            if not now.names >= before.names
            or name not in before.names
            or now.definition(name) != before.definition(name)
        }
        return found | ({(module, EFFECTS)} if now.effects() != before.effects() else set())

    def _rests(self, modules: Iterable[str], changed: set[tuple[str, str]]) -> bool:
        """Tell whether what comes of definitions, ``module:name``, rests on a changed one."""
        return any(
            not changed.isdisjoint(self._results(one))
            for one in modules
            if not one.startswith(BOOK)
        )

    @cache  # noqa: B019
    def _results(self, asked: str) -> frozenset[tuple[str, str]]:
        module, _, name = asked.partition(":")
        return frozenset(self._graph.imports.definitions([(module, name)]))

    def _spread(self, first: dict[str, set[str]]) -> dict[str, set[str]]:
        """Return all definitions that rest on some, by notebook, in other notebooks too."""
        found = {stem: set(first.get(stem, ())) for stem in self._defined}
        grows = True
        while grows:
            grows = False
            changed = {f"{BOOK}{s}:{n}" for s in found for n in (*found[s], "") if found[s]}
            for stem, defined in self._defined.items():
                rest = {
                    name
                    for name, (_, read, modules) in defined.items()
                    if not found[stem].isdisjoint(read) or not changed.isdisjoint(modules)
                }
                if not rest <= found[stem]:
                    found[stem] |= rest
                    grows = True
        return {stem: names for stem, names in found.items() if names}

    def _rooms(self, test: str, name: str) -> frozenset[str]:
        """Return the rooms of which a file has tests; of planted errors the lists that name it."""
        if test == MUTANTS:
            lists = {name, *(text for text in self._lists if name in self._lists[text])}
            return frozenset(Path(text).stem for text in lists if text.endswith(".txt"))
        if Path(name).parent.name == "calls" and not Path(name).stem.startswith("_"):
            return frozenset({Path(name).stem})
        return frozenset({_room(self._modules[name])} if name in self._modules else ())

    def _is_near(self, test: str, name: str) -> bool:
        """Tell whether a test is of a module's own room, imports it, or reads its text.

        Of a notebook with other cells it is whose chapter it is, or who imports its module.
        """
        if name.endswith(".ipynb"):
            read = [self._tests[file] for file in self._files(test)]
            own = test.startswith(("tests/book/", f"tests/chapters/{Path(name).stem}/", NOTEBOOK))
            return own or self._root / name in set(self._graph.notebooks(read))
        if name not in self._modules:
            return True
        module = self._modules[name]
        room = _room(module)
        if room == "chapters":
            return True
        if test.startswith("tests/chapters/"):
            return False
        if test.startswith((f"tests/{room}/", f"tests/test_{room}.py")):
            return True
        return module in self._taken(test) or module not in self._test(test)[1]

    @cache  # noqa: B019
    def _taken(self, test: str) -> frozenset[str]:
        """Return what a test and its helpers import, by name."""
        pairs = (pair for file in self._files(test) for pair in self._tests[file].imported)
        return frozenset(name for pair in pairs for name in (pair[0], ".".join(pair)))


def _room(module: str) -> str:
    """Return the room of a module: the first word below the package; the worlds are one."""
    top, *below = module.split(".")
    return top if top in (WORLDS, *OWN) or not below else below[0]


def _is_data(file: str) -> bool:
    return not file.endswith(".py")


def _is_in(test: str, places: Iterable[str]) -> bool:
    """Tell whether a file is one of some, or lies in a folder that is."""
    return any(test == one or (one.endswith("/") and test.startswith(one)) for one in places)


def _is_named(name: str, said: Iterable[str], folders: set[str], beside: bool) -> bool:
    """Tell whether a text is a file's name, or an ending or pattern that fits it in a folder."""
    *above, last = name.split("/")
    named = folders - {"robot_perception"}  # which stands for its name, too
    below = beside or not named.isdisjoint(above)
    return any(
        text in (name, last)
        or (below and text.startswith(".") and last.endswith(text))
        or (below and "*." in text and fnmatch.fnmatchcase(last, text))
        for text in said
    )


def changes(root: Path, base: str) -> list[str]:
    """Return the paths that differ from a commit, or from where a branch was left, and new ones.

    Raises
    ------
    subprocess.CalledProcessError
        If git cannot tell.
    """
    left = _git(root, "merge-base", base, "HEAD")[0]
    new = _git(root, "ls-files", "--others", "--exclude-standard")
    return sorted({*_git(root, "diff", "--name-only", "--no-renames", left), *new})


def before(root: Path, base: str, name: str) -> bytes:
    """Return what a file was at the base; nothing of one that was not there."""
    left = _git(root, "merge-base", base, "HEAD")[0]
    run = ["git", "-C", str(root), "show", f"{left}:{name}"]
    return subprocess.run(run, capture_output=True).stdout


def _git(root: Path, *words: str) -> list[str]:
    run = ["git", "-C", str(root), "-c", "core.quotePath=false", *words]
    return subprocess.run(run, check=True, capture_output=True, text=True).stdout.splitlines()


def reach_of(root: Path, kept: Kept) -> Reach:
    """Return what files of a repository are reached by changes; what is not kept is read."""
    graph = Dependencies(root, reads=kept.said, folder=root / KEPT / "imports")
    return Reach(root, graph, kept)


def page_tests(pages: Iterable[str], collected: Iterable[str]) -> list[str]:
    """Return which of the site's tests are of some pages: those with its name among their values.

    Raises
    ------
    LookupError
        If a page has none.
    """
    chosen = [
        (test, page)
        for test in collected
        for page in pages
        if page in test.partition("[")[2].removesuffix("]").split("-")
    ]
    untested = sorted(set(pages) - {page for _, page in chosen})
    if untested:
        raise LookupError(f"no test of the site names {', '.join(untested)}: run `{EVERYTHING}`")
    return list(dict.fromkeys(test for test, _ in chosen))


def lanes(reached: Reached, jobs: int) -> Iterator[Iterator[tuple[str, list[str]]]]:
    """Yield what may run side by side: names and commands of steps, each after the one before."""
    pytest = [sys.executable, "-m", "pytest", "-q", "-n", str(jobs), "--dist", "loadfile"]
    fast = ["-m", "not slow"]
    notebooks = [f"book/{page}.ipynb" for page in sorted(reached.notebooks)]
    if notebooks := [name for name in notebooks if (ROOT / name).exists()]:
        notebooks = ["--nbval-lax", *notebooks]  # one of them on one core, the tests on another
    tests = sorted({*reached.tests, *reached.parts})
    if notebooks or tests:
        words = {file: sorted(chosen) for file, chosen in reached.parts.items()}
        chosen = ["env", f"{CHOSEN}={json.dumps(words)}"] if words else []
        command = [*chosen, *pytest, *(["-p", "tests.tools.chosen"] if words else fast)]
        yield iter([("tests and notebooks", [*command, *notebooks, *tests])])
    if reached.site or 0 < len(reached.pages) <= MOST_PAGES:
        yield _of_the_site(reached, jobs, [*pytest, *fast])


def _of_the_site(reached: Reached, jobs: int, pytest: list[str]) -> Iterator[tuple[str, list[str]]]:
    yield "book", ["make", "--no-print-directory", "book", f"JOBS={jobs}"]
    pages = reached.pages if len(reached.pages) <= MOST_PAGES else ()
    ask = [sys.executable, "-m", "pytest", "-q", "--collect-only", "-m", "not slow", BROWSER]
    found = subprocess.run(ask, cwd=ROOT, capture_output=True, text=True).stdout.splitlines()
    tests = page_tests(pages, (line for line in found if "::" in line))
    whole = sorted(reached.site)
    alone = (test for test in tests if test.partition("::")[0] not in whole)
    yield "pages", [*pytest, *whole, *alone]


def follow(lane: Iterator[tuple[str, list[str]]]) -> str:
    """Run steps until one fails; return its name. What each has said is printed when it ends."""
    environment = os.environ | {"ROBOT_PERCEPTION_SITE": SITE}
    for name, command in lane:
        start = time.monotonic()
        words = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        ended = subprocess.run(command, cwd=ROOT, env=environment, **words)
        took = f"{name}: {time.monotonic() - start:.0f} s"
        print(f"{ended.stdout}{took}\n", end="", flush=True)
        if ended.returncode:
            return name
    return ""


def main() -> int:
    """Say what has changed and what that reaches, run it, and say how long each step took."""
    start = time.monotonic()
    ask = argparse.ArgumentParser(prog="make check", description=__doc__.partition(":")[0])
    ask.add_argument("--base", default="HEAD", help="commit to compare with")
    ask.add_argument("--jobs", type=int, default=2, help="processes")
    ask.add_argument("--dry", action="store_true", help="say what is reached, and run nothing")
    told = ask.parse_args()
    changed = changes(ROOT, told.base)
    if not changed:
        print(f"Nothing has changed since {told.base}, so nothing was tested.")
        return 0
    kept = Kept(ROOT / KEPT)
    reach = reach_of(ROOT, kept)
    total, unknown = Reached(), []
    for name in changed:
        found = reach.of(name, before(ROOT, told.base, name))
        unknown += [name] if found is None else []
        total |= found or Reached()
        print(f"{name}: {_told(found)}")
    kept.write()
    if unknown:
        print(f"What {', '.join(unknown)} reaches cannot be told: run `{EVERYTHING}`.")
        return 2
    print(f"{time.monotonic() - start:.0f} s to find out. {_left(total)}", flush=True)
    if told.dry:
        print(*(f"  {line}" for line in _lines(total)), sep="\n")
        return 0
    with ThreadPoolExecutor() as pool:
        failed = [name for name in pool.map(follow, lanes(total, told.jobs)) if name]
    print(f"Failed: {', '.join(failed)}" if failed else "What the change reaches is green.")
    return bool(failed)


def _told(found: Reached | None) -> str:
    if found is None:
        return "?"
    tests, pages = len(found.tests) + len(found.site), ", ".join(sorted(found.pages))
    parts = f" and parts of {len(found.parts)}" if found.parts else ""
    return f"{tests} files of tests{parts}, pages: {pages or 'none'}"


def _left(total: Reached) -> str:
    """Say what is reached and left to the command that tests everything."""
    left = [f"{len(total.left)} files of tests farther away"] if total.left else []
    if len(total.pages) > MOST_PAGES:
        left.append(f"{len(total.pages)} pages")
    if total.pages:
        left.append("JupyterLab")
    return f"Left to `{EVERYTHING}`: {', '.join(left)}." if left else ""


def _lines(total: Reached) -> Iterator[str]:
    yield from sorted({*total.tests, *total.site})
    for file, words in sorted(total.parts.items()):
        yield f"{file}: {', '.join(sorted(words))}"


if __name__ == "__main__":
    sys.exit(main())
