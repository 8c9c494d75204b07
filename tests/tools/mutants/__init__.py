"""Planted errors, a line each, and how they are put into the code; ``__main__`` tries them out.

::

    # comment
    tests: tests/test_kalman.py tests/slam -k 'not x'      arguments of pytest for the lines below
    lib/robot_perception/kalman.py: `P @ H.mT` -> `P @ H`
    lib/robot_perception/kalman.py#2: `+ Q` -> ``          the second place where the text stands
    lib/robot_perception/kalman.py: `a < b` -> `a <= b` = reason why nothing observable changes
    book/monobot.ipynb: `F @ P` -> `P @ F`                 a line of its study cells
"""

import ast
import itertools
import json
import re
import shlex
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from studies.keys.cells import STUDY

NOTEBOOK = ".ipynb"
ROOT = Path(__file__).parents[3]
LINE = re.compile(
    r"(?P<file>[^\s:#`]+)(#(?P<place>[1-9]\d*))?: `(?P<old>[^`]+)` -> `(?P<new>[^`]*)`"
    r"( = (?P<reason>\S.*))?"
)


@dataclass(frozen=True)
class Mutant:
    """One planted error: a line of a room, what it changes, and the tests that should notice."""

    room: str
    line: int
    file: str
    place: int | None  # of several places of the old text, from 1; None if there is but one
    old: str
    new: str
    reason: str  # why nothing observable changes; empty for an error
    tests: tuple[str, ...]

    @property
    def name(self) -> str:
        """Room and line."""
        return f"{self.room}:{self.line}"

    def __str__(self) -> str:
        return f"{self.name:16s} {Path(self.file).name}: {self.old.strip()} -> {self.new.strip()}"

    def applied(self, root: Path = ROOT) -> str:
        """Return the text of the file with the error in it.

        Raises
        ------
        ValueError
            If the line does not fit the code below ``root``; the message names the line.
        """
        if not (root / self.file).is_file():
            raise ValueError(f"{self.name}: there is no file {self.file}")
        text = (root / self.file).read_text("utf-8")
        old, new = self._written(self.old), self._written(self.new)
        parts, first = text.split(old), self.place or 1
        if len(parts) <= first or (len(parts) > 2 and self.place is None):
            count = len(parts) - 1
            raise ValueError(f"{self.name}: {self.old!r} stands {count} times in {self.file}")
        changed = old.join(parts[:first]) + new + old.join(parts[first:])
        try:
            python = self.file.endswith((".py", NOTEBOOK))
            same = text == changed or (
                python and _means_the_same(self._code(text), self._code(changed))
            )
        except SyntaxError as error:
            raise ValueError(f"{self.name}: {self.file} no longer parses: {error}") from error
        if same:
            raise ValueError(f"{self.name}: {self.new!r} for {self.old!r} changes nothing")
        return changed

    def _written(self, text: str) -> str:
        """Return how a part of a line of code stands in the file."""
        if not self.file.endswith(NOTEBOOK):
            return text
        return json.dumps(text, ensure_ascii=False)[1:-1]

    def _code(self, text: str) -> str:
        """Return the code of a module, that of a notebook's study cells."""
        if not self.file.endswith(NOTEBOOK):
            return text
        return "\n".join(
            "".join(cell["source"])
            for cell in json.loads(text)["cells"]
            if STUDY in cell["metadata"].get("tags", ())
        )

    def is_inlined(self, root: Path = ROOT) -> bool:
        """Tell whether other files' compiled code may have the change in it.

        It has compiled functions and the constants of a module, not a plain function or a class.
        """
        text = (root / self.file).read_text("utf-8")
        before = self.old.join(text.split(self.old)[: self.place or 1])
        first, last = before.count("\n") + 1, (before + self.old).count("\n") + 1
        return not any(
            isinstance(node, ast.FunctionDef | ast.ClassDef)
            and min(part.lineno for part in (node, *node.decorator_list)) <= first
            and last <= node.end_lineno
            and "jit" not in "".join(map(ast.unparse, node.decorator_list))
            for node in ast.parse(text).body
        )


def _means_the_same(before: str, after: str) -> bool:
    """Tell whether two texts of a module mean the same.

    Where a change lies within one statement, no other is read again: a module has many mutants.
    """
    parts, lines, changed = _parts(before), before.split("\n"), after.split("\n")
    pairs = zip(lines, changed, strict=False)
    first = next((i for i, (one, other) in enumerate(pairs) if one != other), len(lines) - 1)
    start = 0
    for text, node in parts:
        end = start + text.count("\n") + 1
        if start <= first < end:
            rest = len(lines) - end
            stop = len(changed) - rest
            if stop > start and changed[stop:] == lines[end:]:
                try:
                    (replaced,) = ast.parse("\n".join(changed[start:stop])).body
                except (SyntaxError, ValueError):
                    break  # it may join or part statements
                return ast.dump(replaced) == ast.dump(node)
            break
        start = end
    return _is_same(parts, _parts(after))


@lru_cache(maxsize=2)
def _parts(text: str) -> list[tuple[str, ast.stmt]]:
    """Return the statements of a module with their text."""
    lines, tree = text.split("\n"), ast.parse(text)
    ends = [0, *(node.end_lineno for node in tree.body)]
    texts = ("\n".join(lines[a:b]) for a, b in itertools.pairwise(ends))
    return [*zip(texts, tree.body, strict=True)]


def _is_same(before: list[tuple[str, ast.stmt]], after: list[tuple[str, ast.stmt]]) -> bool:
    """Tell whether two modules mean the same: statements with the same text do."""
    return len(before) == len(after) and all(
        text == other or ast.dump(node) == ast.dump(replaced)
        for (text, node), (other, replaced) in zip(before, after, strict=True)
    )


def rooms(folder: Path = Path(__file__).parent) -> dict[str, Path]:
    """Return the files of planted errors by room."""
    return {file.stem: file for file in sorted(folder.glob("*.txt"))}


def read(file: Path) -> list[Mutant]:
    """Read the planted errors of a room.

    Raises
    ------
    ValueError
        For a line that is none, or has no tests above it; the message names the line.
    """
    mutants, tests = [], ()
    for number, line in enumerate(file.read_text("utf-8").splitlines(), 1):
        line = line.strip()
        if line.startswith("tests:"):
            tests = tuple(shlex.split(line.removeprefix("tests:")))
        elif line and not line.startswith("#"):
            found = LINE.fullmatch(line)
            if found is None or not tests:
                what = "has no line `tests: …` above it" if found else "is no planted error"
                raise ValueError(f"{file.stem}:{number}: {what}: {line}")
            place = int(found["place"]) if found["place"] else None
            texts = found["old"], found["new"], found["reason"] or ""
            mutants.append(Mutant(file.stem, number, found["file"], place, *texts, tests))
    return mutants
