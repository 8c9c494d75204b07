"""Plant one error after the other in a copy of the code, and see whether the tests notice.

``python -m tests.tools.mutants [ROOM or ROOM:LINE …] [-n JOBS]`` prints a line for each, then a
table.
"""

import argparse
import json
import os
import queue
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import grimp
from joblib import Parallel, delayed
from tqdm import tqdm

from robot_perception.project import BOOK
from tests.book.changed import CHANGED
from tests.tools.mutants import NOTEBOOK, ROOT, Mutant, read, rooms

SHARE = 0.95
"""Of the errors that are not equivalent to the code, so many must be caught."""

BY_BOOK, BY_DRAWS = "caught by book", "caught by draws"
CAUGHT = ("caught", "did not import", "did not collect", "crashed", "hung", BY_BOOK, BY_DRAWS)
FURTHER = 600
"""Seconds of the processor that the book's own tests of a chapter may take."""
Result = tuple[Mutant, str, float, str]


def further(mutant: Mutant) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield what else notices an error in a notebook, and what it is called.

    First what the book's own tests compute anew: claims, states of explorers, cheap trials, and
    the outputs that the notebook keeps. Not that a key is another one, for it is so after every
    change. Then trials of studies whose key
    is another one, dear ones, too: as ``store --keys`` draws them before such a change is kept.
    """
    if (file := Path(mutant.file)).suffix == NOTEBOOK:
        own = f"({file.stem} and (give_what or states_say))"
        tests = (f"tests/book/test_{name}.py" for name in ("rows", "claims", "explorers"))
        yield BY_BOOK, (*tests, "-k", f"{own} or record_says or each_sabotage")
        yield BY_BOOK, ("--nbval-lax", mutant.file)
        yield BY_DRAWS, ("tests/book/test_rows.py", "-m", "", "-k", f"{file.stem} and give_what")


class Copy:
    """A copy of the repository, with the code compiled by green runs, and its server.

    numba compiles a kernel again if its own file changes, but not if that of a function changes
    which is inlined into it: then compiled code of all that imports the file is laid aside.
    """

    def __init__(self, tree: Path) -> None:
        for file in _listed():
            (tree / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / file, tree / file)
        self.tree, self.changes = tree, 0
        self.imports = grimp.build_graph("robot_perception", "data_synth", cache_dir=None)
        changed = {
            "PYTHONPATH": f"{tree / 'lib'}{os.pathsep}{tree}",
            "PYTHONDONTWRITEBYTECODE": "",
            "NUMBA_CACHE_DIR": "",  # compiled code belongs to its copy
            CHANGED: "only",
        }
        self.server = subprocess.Popen(
            [sys.executable, "-P", str(Path(__file__).with_name("server.py"))],
            cwd=tree,
            env=os.environ | changed,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def run(self, tests: Sequence[str], first: Sequence[str] = (), **words: Any) -> dict[str, Any]:
        """Run tests, some of them first; return what `tests.tools.mutants.server` answers."""
        asked = {"tests": tests, "first": first, "limit": 0, "module": ""} | words
        print(json.dumps(asked), file=self.server.stdin, flush=True)
        return json.loads(self.server.stdout.readline())

    def try_out(self, tests: Sequence[str], mutants: list[Mutant]) -> Iterator[Result]:
        """Yield what became of errors that the same tests should notice.

        Tests that noticed the last ones run first, then the fast before the slow.
        """
        green = self.run(tests)
        if green["code"]:
            print(green["output"], "red without a planted error:", *tests, file=sys.stderr)
        limit = 60 + round(5 * green["time"])  # there may be kernels to compile
        first = sorted(green.get("seconds", ()), key=lambda test: green["seconds"][test])
        for mutant in mutants:
            if green["code"]:
                yield mutant, "red unchanged", 0.0, ""
                continue
            with self._planted(mutant):
                module = _module(self.tree / mutant.file, self.tree)
                found = self.run(tests, first, limit=limit, module=module)
                said = verdict(found["code"], found.get("imports", True))
                for name, others in further(mutant) if said == "escaped" else ():
                    found = self.run(others, limit=FURTHER, module=module)
                    if verdict(found["code"], found.get("imports", True)) in CAUGHT:
                        said = name
                        break
            failed = found.get("failed", [])
            if said not in (BY_BOOK, BY_DRAWS):
                first = [*failed, *(test for test in first if test not in failed)]
            why = found["output"][-300:] if said != "escaped" else ""
            yield mutant, said, found["time"], failed[0] if failed else why

    @contextmanager
    def _planted(self, mutant: Mutant) -> Iterator[None]:
        file, compiled = self.tree / mutant.file, self._compiled(mutant)
        text, stat = file.read_bytes(), file.stat()
        self.changes += 1
        for path in compiled:
            path.rename(f"{path}.aside")
        try:
            file.write_text(mutant.applied(self.tree), "utf-8")
            os.utime(file, (2e9 + self.changes,) * 2)  # bytecode is told apart by whole seconds
            yield
        finally:
            file.write_bytes(text)
            os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))
            for path in self._compiled(mutant):
                path.unlink()
            for path in compiled:
                Path(f"{path}.aside").rename(path)

    def _compiled(self, mutant: Mutant) -> list[Path]:
        """Return the compiled code that a planted error may reach."""
        module = _module(self.tree / mutant.file, self.tree)
        if module not in self.imports.modules:
            return []
        stale = {module}
        if mutant.is_inlined(self.tree):
            stale |= self.imports.find_downstream_modules(module)
        found = self.tree.rglob("__pycache__/*.nb[ic]")
        return [path for path in found if _module(path, self.tree) in stale]


def _listed() -> list[str]:
    """Return the files of the repository that git does not ignore."""
    words = ["git", "ls-files", "-coz", "--exclude-standard"]
    listed = subprocess.run(words, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [file for file in listed.split("\0") if (ROOT / file).is_file()]


def _module(path: Path, tree: Path) -> str:
    """Return the module of a file, or of its cache ``__pycache__/module.function-line….nbi``."""
    if path.suffix == NOTEBOOK:
        return f"{BOOK}{path.stem}"
    folders = (part for part in path.parent.relative_to(tree).parts if part != "__pycache__")
    return (
        ".".join([*folders, path.name.split(".")[0]]).removeprefix("lib.").removesuffix(".__init__")
    )


def verdict(code: int | None, imports: bool) -> str:
    """Say what became of an error: by pytest's exit code, and whether its module still imports.

    Without it all tests are collected and green; so it is the error that stops the collection.
    """
    if code is None or code < 0:
        return "hung" if code is None else "crashed"
    if code > 1 and not imports:
        return "did not import"
    return {0: "escaped", 1: "caught", 2: "did not collect"}.get(code, f"exit code {code}")


def table(every: list[Mutant], verdicts: dict[str, str]) -> tuple[str, float]:
    """Return a table of the rooms, what is equivalent and what escaped; and the share caught."""
    lines = [f"{'room':16s} planted   caught  escaped  equivalent    share"]
    for room in [*dict.fromkeys(mutant.room for mutant in every), "all"]:
        own = [mutant for mutant in every if room in (mutant.room, "all")]
        tried = [verdicts[mutant.name] for mutant in own if not mutant.reason]
        caught = sum(said in CAUGHT for said in tried)
        share = caught / len(tried) if tried else 1.0
        counts = (
            f"{len(own):7d}  {caught:7d}  {len(tried) - caught:7d}  {len(own) - len(tried):10d}"
        )
        lines.append(f"{room:16s} {counts}  {share:7.1%}")
    for way in (BY_BOOK, BY_DRAWS):
        if number := sum(said == way for said in verdicts.values()):
            lines.append(f"{way:16s} {number:7d}")
    for mutant in every:
        if mutant.reason:
            lines.append(f"equivalent  {mutant} = {mutant.reason}")
        elif (said := verdicts[mutant.name]) not in CAUGHT:
            lines.append(f"{said:11s} {mutant}")
    return "\n".join(lines), share


def main() -> bool:
    """Try out the errors of the rooms named, or of all rooms; tell whether too many escaped."""
    words = argparse.ArgumentParser(prog="tests.tools.mutants", description=__doc__)
    words.add_argument("rooms", nargs="*", help="room or room:line; all of them if none is named")
    words.add_argument("-n", dest="jobs", type=int, default=1, help="so many at a time")
    asked = words.parse_args()
    every = [mutant for file in rooms().values() for mutant in read(file)]
    known = {name for mutant in every for name in (mutant.room, mutant.name)}
    if unknown := set(asked.rooms) - known:
        words.error(f"nothing is planted at {sorted(unknown)}; there are {', '.join(rooms())}")
    if asked.rooms:
        every = [mutant for mutant in every if {mutant.room, mutant.name} & set(asked.rooms)]
    for mutant in every:
        mutant.applied()
    groups: dict[tuple[str, ...], list[Mutant]] = {}
    for mutant in every:
        if not mutant.reason:
            groups.setdefault(mutant.tests, []).append(mutant)
    verdicts, copies = {}, queue.SimpleQueue()
    progress = tqdm(total=sum(map(len, groups.values())), desc="planted")

    def work(tests: tuple[str, ...], mutants: list[Mutant]) -> None:
        copy = copies.get()
        for mutant, said, seconds, failed in copy.try_out(tests, mutants):
            verdicts[mutant.name] = said
            progress.write(f"{said:14s} {seconds:4.0f} s  {mutant}  {failed}")
            progress.update()
        copies.put(copy)

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        for i in range(asked.jobs):
            copies.put(Copy(Path(folder) / f"copy{i}"))
        Parallel(asked.jobs, "threading")(delayed(work)(*group) for group in groups.items())
    text, share = table(every, verdicts)
    print(text)
    return share < SHARE


if __name__ == "__main__":
    sys.exit(main())
