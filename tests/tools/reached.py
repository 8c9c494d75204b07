"""What a change reaches is tested: ``make check``.

What has changed is git's answer: against ``HEAD`` with what is not yet committed, or against the
commit where the branch left ``--base``. What a change reaches says the import graph by which pages
expire (`robot_perception.teaching.dependencies`): pages whose cells reach a changed module, and
tests that do, or that name what they read. A chapter's tests ask `robot_perception.chapters` for
their own chapter. Pages that are built anew are opened in the browser and run in JupyterLab, no
others.

What lies under everything, the versions of packages for instance, is not traced: then the command
that tests everything is named, and nothing passes.
"""

import argparse
import ast
import fnmatch
import os
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from robot_perception.teaching.cells import study_cells
from robot_perception.teaching.dependencies import (
    LEDGER,
    PACKAGES,
    Dependencies,
    claims_of,
    code,
)
from tests.site.lab import LAB_PAGES

ROOT = Path(__file__).parents[2]
SITE = "build/_build/html"
BROWSER = "tests/site/"
CHAPTERS = "robot_perception.chapters"
EVERYTHING = "make test"
WORDS = (".md", ".cff", "LICENSE", ".gitignore")
"""Files at the root that run nothing; tests that read them name them."""
LIES_UNDER = ("conftest.py", "__init__.py", "reached.py")
"""Files of tests that others do not import and that matter to them."""


@dataclass(frozen=True)
class Reached:
    """What is to be run.

    Parameters
    ----------
    tests
        Files of tests, but for those of the site.
    site
        Files of the site's tests that are run whole.
    pages
        Pages of the book that are built anew and opened, by name.
    """

    tests: frozenset[str] = frozenset()
    site: frozenset[str] = frozenset()
    pages: frozenset[str] = frozenset()

    def __or__(self, other: "Reached") -> "Reached":
        """Return what either reaches."""
        return Reached(self.tests | other.tests, self.site | other.site, self.pages | other.pages)


class Reach:
    """What files of a repository are reached by changes.

    Parameters
    ----------
    root
        The repository.
    dependencies
        Its import graph.
    """

    def __init__(self, root: Path, dependencies: Dependencies) -> None:
        self._root = root
        self._graph = dependencies
        self._modules = {
            file.relative_to(root).as_posix(): name
            for name, file in dependencies.imports.files.items()
        }
        self._stored = {file.relative_to(root).as_posix() for file in dependencies.stored}
        sources = sorted((root / "tests").rglob("*.py"))
        self._trees = {self._path(file): ast.parse(file.read_bytes()) for file in sources}
        book = root / "book"
        files = (file for file in sorted(book.rglob("*")) if file.suffix in (".ipynb", ".md"))
        self._pages = {
            self._path(file): file.relative_to(book).with_suffix("").as_posix()
            for file in files
            if not file.relative_to(book).parts[0].startswith(("_", "."))
        }

    def of(self, name: str, ledger: bytes = b"") -> Reached | None:
        """Return what a changed file reaches, or ``None`` if that cannot be told.

        Parameters
        ----------
        name
            Path below the root.
        ledger
            If it is the ledger: what it was.
        """
        if not self._is_traced(name):
            return None
        tests = [t for t in self._trees if Path(t).name.startswith("test_")]
        tests = [test for test in tests if self._is_run(test, name)]
        return Reached(
            frozenset(test for test in tests if not test.startswith(BROWSER)),
            frozenset(test for test in tests if test.startswith(BROWSER)),
            frozenset(p for file, p in self._pages.items() if self._is_shown(file, name, ledger)),
        )

    def _path(self, file: Path) -> str:
        return file.relative_to(self._root).as_posix()

    def _is_traced(self, name: str) -> bool:
        file, top = self._root / name, name.partition("/")[0]
        if not file.exists():  # who used it cannot be found in what there is
            return False
        if top in ("lib", *PACKAGES):
            return name in self._modules
        if top == "tests":
            return file.name not in LIES_UNDER
        if top == "book":
            return name in self._pages or name in self._stored or file.suffix == ".py"
        return file.parent == self._root and name.endswith(WORDS)

    def _is_run(self, test: str, name: str) -> bool:
        """Tell whether a file of tests reaches a changed file, or reads it."""
        helpers, modules, said, stored = self._test(test)
        if name in helpers or self._modules.get(name) in modules:
            return True
        if test.startswith(BROWSER):  # what these read is the site
            return False
        lists = (text for text in self._lists if name in self._lists[text])
        folders = {word for text in said for word in text.split("/")}
        beside = {Path(helper).parent for helper in helpers}
        return name in stored or any(
            _is_read(file, said, folders, Path(file).parent in beside and not file.endswith(".py"))
            for file in (name, *lists)
        )

    @cached_property
    def _lists(self) -> dict[str, str]:
        """Lists beside the tests, which may name files: planted errors for instance."""
        files = (self._root / "tests").rglob("*.txt")
        return {self._path(file): file.read_text("utf-8") for file in files}

    @cache  # noqa: B019 - there is one in a process
    def _test(self, test: str) -> tuple[set[str], set[str], frozenset[str], set[str]]:
        """Return the files of a test, the modules that run, its texts, and what it may read."""
        files: set[str] = set()
        todo = {test}
        while todo:
            files |= todo
            todo = {name for file in todo for name in self._file(file)[0]} - files
        said = frozenset().union(*(self._file(file)[1] for file in files))
        asked = {name for file in files for name in self._file(file)[2]}
        notebooks = self._notebooks(test, files, asked)
        cells = [ast.parse(text) for page in notebooks for _, text in study_cells(page)]
        modules = self._run(test, asked) | self._graph.modules(cells)
        stored = self._graph.data(said | self._graph.named(cells, modules))
        return files, modules, said, set(map(self._path, (*stored, *notebooks)))

    def _notebooks(self, test: str, files: set[str], modules: set[str]) -> set[Path]:
        """Return the notebooks whose cells run with a test, of chapters as `_run` has them."""
        found = set(self._graph.notebooks(self._trees[file] for file in files))
        if CHAPTERS in modules:
            own = self._root / "book" / f"{Path(test).parent.name}.ipynb"
            every = {self._root / page for page in self._pages if page.endswith(".ipynb")}
            found |= {own} if own in every else every
        return {page for page in found if study_cells(page)}

    @cache  # noqa: B019
    def _file(self, name: str) -> tuple[set[str], frozenset[str], set[str]]:
        """Return the files below ``tests`` that one imports, its texts, and the modules."""
        tree = self._trees[name]
        said = self._graph.named((tree,), ())
        imported = {f"{text}*" for text in said if text.startswith("tests.")}  # an f-string's start
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                imported |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
            elif isinstance(node, ast.Import):
                imported |= {alias.name for alias in node.names}
        paths = (text.replace(".", "/") for text in imported if text.startswith("tests"))
        patterns = [f"{path}{end}" for path in paths for end in (".py", "/__init__.py")]
        files = {file for pattern in patterns for file in fnmatch.filter(self._trees, pattern)}
        return files, said, set(self._graph.imported((tree,)))

    def _run(self, test: str, modules: set[str]) -> set[str]:
        """Return the modules that run with a test; of chapters asked for by name only its own."""
        imports = self._graph.imports
        own = f"{CHAPTERS}.{Path(test).parent.name}"
        if own not in imports.files or CHAPTERS not in modules:
            return imports.reached(modules)
        below = {n for n in imports.reached([CHAPTERS]) if f"{n}.".startswith(f"{own}.")}
        return imports.reached((modules | below) - {CHAPTERS})

    def _is_shown(self, page: str, name: str, ledger: bytes) -> bool:
        """Tell whether a page shows what follows from a changed file."""
        file = self._root / page
        included = name.startswith("book/") and name.removeprefix("book/")
        if page == name or (included and name.endswith(".py") and included in file.read_text()):
            return True
        modules, named, stored = self._page(page)
        if name in stored and Path(name).name == LEDGER:
            before, now = (self._root / name).read_bytes(), ledger
            return claims_of(file.stem, named, before) != claims_of(file.stem, named, now)
        return name in stored or self._modules.get(name) in modules

    @cache  # noqa: B019
    def _page(self, page: str) -> tuple[set[str], frozenset[str], set[str]]:
        """Return the modules that run with a page, the texts it names, and the data it may read."""
        cells = code(self._root / page)
        if not cells:
            return set(), frozenset(), set()
        modules = self._graph.modules(cells)
        named = self._graph.named(cells, modules)
        return modules, named, set(map(self._path, self._graph.data(named)))


def _is_read(name: str, said: Iterable[str], folders: set[str], beside: bool) -> bool:
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
    """Return the ledger as it was at the base; of other files nothing is needed."""
    if Path(name).name != LEDGER:
        return b""
    left = _git(root, "merge-base", base, "HEAD")[0]
    return "\n".join(_git(root, "show", f"{left}:{name}")).encode()


def _git(root: Path, *words: str) -> list[str]:
    run = ["git", "-C", str(root), "-c", "core.quotePath=false", *words]
    return subprocess.run(run, check=True, capture_output=True, text=True).stdout.splitlines()


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
    pytest += ["-m", "not slow"]
    notebooks = [f"book/{page}.ipynb" for page in sorted(reached.pages)]
    if notebooks := [name for name in notebooks if (ROOT / name).exists()]:
        notebooks = ["--nbval-lax", *notebooks]  # one of them on one core, the tests on another
    if notebooks or reached.tests:
        yield iter([("tests and notebooks", [*pytest, *notebooks, *sorted(reached.tests)])])
    if reached.pages or reached.site:
        yield _of_the_site(reached, jobs, pytest)


def _of_the_site(reached: Reached, jobs: int, pytest: list[str]) -> Iterator[tuple[str, list[str]]]:
    yield "book", ["make", "--no-print-directory", "book", f"JOBS={jobs}"]
    in_lab = ["env", f"{LAB_PAGES}={','.join(sorted(reached.pages))}"]
    ask = [sys.executable, "-m", "pytest", "-q", "--collect-only", "-m", "not slow", BROWSER]
    ask = [*in_lab, *ask]
    found = subprocess.run(ask, cwd=ROOT, capture_output=True, text=True).stdout.splitlines()
    tests = page_tests(reached.pages, (line for line in found if "::" in line))
    whole = sorted(reached.site)
    alone = (test for test in tests if test.partition("::")[0] not in whole)
    yield "pages", [*in_lab, *pytest, *whole, *alone]


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
    ask = argparse.ArgumentParser(prog="make check", description=__doc__.partition(":")[0])
    ask.add_argument("--base", default="HEAD", help="commit to compare with")
    ask.add_argument("--jobs", type=int, default=2, help="processes")
    told = ask.parse_args()
    changed = changes(ROOT, told.base)
    if not changed:
        print(f"Nothing has changed since {told.base}, so nothing was tested.")
        return 0
    reach, total, unknown = Reach(ROOT, Dependencies(ROOT)), Reached(), []
    for name in changed:
        found = reach.of(name, before(ROOT, told.base, name))
        unknown += [name] if found is None else []
        total |= found or Reached()
        print(f"{name}: {_told(found)}")
    if unknown:
        print(f"What {', '.join(unknown)} reaches cannot be told: run `{EVERYTHING}`.")
        return 2
    with ThreadPoolExecutor() as pool:
        failed = [name for name in pool.map(follow, lanes(total, told.jobs)) if name]
    print(f"Failed: {', '.join(failed)}" if failed else "What the change reaches is green.")
    return bool(failed)


def _told(found: Reached | None) -> str:
    if found is None:
        return "?"
    tests, pages = len(found.tests) + len(found.site), ", ".join(sorted(found.pages))
    return f"{tests} files of tests, pages: {pages or 'none'}"


if __name__ == "__main__":
    sys.exit(main())
