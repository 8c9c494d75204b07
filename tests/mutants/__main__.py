"""Plant one error after the other in a copy of the code, and see whether the tests notice.

``python -m tests.mutants [ROOM or ROOM:LINE …] [-n JOBS]`` prints a line for each, then a table.
"""

import argparse
import os
import queue
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import grimp
from joblib import Parallel, delayed
from tqdm import tqdm

from tests.mutants import ROOT, Mutant, read, rooms

SHARE = 0.95
"""Of the errors that are not equivalent to the code, so many must be caught."""

CAUGHT = ("caught", "did not import", "did not collect", "crashed", "hung")
UNUSED = ("cacheprovider", "nbval", "anyio")  # to import nbval takes longer than most tests
PYTEST = ["-m", "pytest", "-xq", "--tb=line", "-rfE", "--hypothesis-seed=0", "-m", "not slow"]
PYTEST += [f"-pno:{name}" for name in UNUSED]


class Copies:
    """Copies of the repository, one for each worker, with the code compiled by a green run.

    numba compiles a kernel again if its own file changes, but not if that of a function changes
    which is inlined into it: compiled code of all that imports a changed module is laid aside.
    """

    def __init__(self, folder: Path, jobs: int, every: list[Mutant]) -> None:
        first, *others = self.trees = [folder / f"copy{i}" for i in range(jobs)]
        for file in _listed():
            (first / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / file, first / file)
        self.imports = grimp.build_graph("robot_perception", "data_synth", cache_dir=None)
        self.seconds = {}
        for tests in tqdm(dict.fromkeys(m.tests for m in every), desc="unchanged"):
            code, self.seconds[tests], output = run(first, tests, None)
            if code:
                raise SystemExit(f"{output}\nred without a planted error: {' '.join(tests)}")
        for other in others:
            shutil.copytree(first, other)
        self.free = queue.SimpleQueue()
        for tree in self.trees:
            self.free.put(tree)

    def try_out(self, number: int, mutant: Mutant) -> tuple[Mutant, str, float, str]:
        """Return what became of a planted error, how long it took, and what failed."""
        tree = self.free.get()
        file, compiled = tree / mutant.file, self._compiled(tree, mutant)
        text, stat = file.read_bytes(), file.stat()
        for path in compiled:
            path.rename(f"{path}.aside")
        try:
            file.write_text(mutant.applied(tree), "utf-8")
            os.utime(file, (2e9 + number, 2e9 + number))  # bytecode is told apart by whole seconds
            limit = 120 + 5 * self.seconds[mutant.tests]  # there may be kernels to compile
            code, seconds, output = run(tree, mutant.tests, limit)
            stopped = code is not None and code > 1
            words = "-c", f"import {_module(file, tree)}"
            imports = not (stopped and python(tree, *words, limit=limit)[0])
        finally:
            file.write_bytes(text)
            os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))
            for path in self._compiled(tree, mutant):
                path.unlink()
            for path in compiled:
                Path(f"{path}.aside").rename(path)
            self.free.put(tree)
        failed = [line for line in output.splitlines() if line.startswith(("FAILED", "ERROR"))]
        return mutant, verdict(code, imports), seconds, failed[0] if failed else output[-300:]

    def _compiled(self, tree: Path, mutant: Mutant) -> list[Path]:
        """Return the compiled code of a module and of all that import it."""
        module = _module(tree / mutant.file, tree)
        if module not in self.imports.modules:
            return []
        stale = {module} | self.imports.find_downstream_modules(module)
        return [path for path in tree.rglob("__pycache__/*.nb[ic]") if _module(path, tree) in stale]


def _listed() -> list[str]:
    """Return the files of the repository that git does not ignore."""
    words = ["git", "ls-files", "-coz", "--exclude-standard"]
    listed = subprocess.run(words, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [file for file in listed.split("\0") if (ROOT / file).is_file()]


def _module(path: Path, tree: Path) -> str:
    """Return the module of a file, or of its cache ``__pycache__/module.function-line….nbi``."""
    folders = (part for part in path.parent.relative_to(tree).parts if part != "__pycache__")
    return (
        ".".join([*folders, path.name.split(".")[0]]).removeprefix("lib.").removesuffix(".__init__")
    )


def python(tree: Path, *words: str, limit: float | None = None) -> tuple[int | None, str]:
    """Run Python in a copy; return its exit code, ``None`` if it had to be ended, and output."""
    with tempfile.TemporaryDirectory() as examples:  # nothing is kept from one error to the next
        changed = {
            "PYTHONPATH": f"{tree / 'lib'}{os.pathsep}{tree}",
            "HYPOTHESIS_STORAGE_DIRECTORY": examples,
            "NUMBA_CACHE_DIR": "",  # compiled code belongs to its copy
        }
        process = subprocess.Popen(
            [sys.executable, *words],
            cwd=tree,
            env=os.environ | changed,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        try:
            output, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            return None, ""
    return process.returncode, output


def run(tree: Path, tests: tuple[str, ...], limit: float | None) -> tuple[int | None, float, str]:
    """Return pytest's exit code, how long it took, and its output."""
    start = time.monotonic()
    code, output = python(tree, *PYTEST, *tests, limit=limit)
    return code, time.monotonic() - start, output


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
    for mutant in every:
        if mutant.reason:
            lines.append(f"equivalent  {mutant} = {mutant.reason}")
        elif (said := verdicts[mutant.name]) not in CAUGHT:
            lines.append(f"{said:11s} {mutant}")
    return "\n".join(lines), share


def main() -> bool:
    """Try out the errors of the rooms named, or of all rooms; tell whether too many escaped."""
    words = argparse.ArgumentParser(prog="tests.mutants", description=__doc__)
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
    tried = [mutant for mutant in every if not mutant.reason]
    verdicts = {}
    with tempfile.TemporaryDirectory() as folder:
        copies = Copies(Path(folder), asked.jobs, tried)
        work = (delayed(copies.try_out)(*item) for item in enumerate(tried))
        results = Parallel(asked.jobs, "threading", return_as="generator_unordered")(work)
        for mutant, said, seconds, failed in tqdm(results, total=len(tried), desc="planted"):
            verdicts[mutant.name] = said
            tqdm.write(f"{said:14s} {seconds:4.0f} s  {mutant}  {failed}")
    text, share = table(every, verdicts)
    print(text)
    return share < SHARE


if __name__ == "__main__":
    sys.exit(main())
