"""Answers of students in batch: their own cells, run apart from each other, with a limit of time.

An answer is the cell that hands it to ``check``. It is run with the names of the book's own study
cells, not of the student's, in a process of its own for each notebook. What it does there it does
with the rights of whoever grades: whom you do not trust, grade in a container.
"""

import json
import multiprocessing
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from robot_perception.files import DamagedFile, reading
from robot_perception.teaching.cells import BOOK, folder
from robot_perception.teaching.copies import Asked, asked, text
from robot_perception.teaching.exercises import Sheet

RIGHT, MISSING, ERROR, TOO_LONG = "right", "missing", "error", "too long"
START_S = 300.0
"""Seconds in which a chapter's study cells must be ready."""
LONGEST = 160
"""Characters of what is said of an answer."""

Outcome = tuple[str, str]
"""What came of an answer, and what is said of it."""
READY: Outcome = ("ready", "")
ENDED: Outcome = (ERROR, "the answer ended the interpreter")


@dataclass(frozen=True)
class Mark:
    """What came of one exercise of one student.

    Parameters
    ----------
    student
        Name of the folder.
    chapter
        Stem of the notebook.
    exercise
        Its key.
    outcome
        ``right``, ``wrong``, ``not yet``, ``missing``, ``error`` or ``too long``.
    points
        What it counts.
    of
        What a right answer counts.
    said
        What a reader of the page would be told, or what went wrong.
    """

    student: str
    chapter: str
    exercise: str
    outcome: str
    points: int
    of: int
    said: str


def exercises(stem: str) -> tuple[Asked, ...]:
    """Return the exercises of a chapter of the book.

    Raises
    ------
    ValueError
        If the book has no such chapter, or it asks nothing.
    """
    page = folder() / f"{stem}.ipynb"
    found = asked(json.loads(page.read_text("utf-8"))) if page.exists() else ()
    if not found:
        raise ValueError(f"no chapter {stem!r} with exercises")
    return found


def grade(students: Sequence[Path], stems: Sequence[str], limit: float) -> Iterator[Mark]:
    """Yield the marks of students: of each for all exercises of some chapters.

    Parameters
    ----------
    students
        A folder each; the notebooks may lie deeper in it.
    stems
        The chapters.
    limit
        Seconds that one answer may take.

    Raises
    ------
    ValueError
        If two students have one name, or the book has no such chapter.
    """
    names = [place.resolve().name for place in students]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"two folders are called {twice[0]}: whose marks are whose?")
    wanted = {stem: exercises(stem) for stem in stems}
    for name, place in zip(names, students, strict=True):
        for stem, ones in wanted.items():
            outcomes = _of_notebook(place, stem, ones, limit)
            for one in ones:
                outcome, said = outcomes[one.key]
                points = one.points if outcome == RIGHT else 0
                short = said if len(said) <= LONGEST else f"{said[: LONGEST - 1]}…"
                yield Mark(name, stem, one.key, outcome, points, one.points, short)


def notebooks(place: Path, stem: str) -> list[Path]:
    """Return a student's notebooks of a chapter, without those that Jupyter keeps for itself."""
    found = sorted(place.rglob(f"{stem}.ipynb"))
    return [path for path in found if ".ipynb_checkpoints" not in path.parts]


def _of_notebook(place: Path, stem: str, ones: Sequence[Asked], limit: float) -> dict[str, Outcome]:
    """Return what came of each exercise in a student's notebook, whatever is in the folder."""
    found = notebooks(place, stem)
    if len(found) != 1:
        why = f"{len(found)} notebooks of that name" if found else "no notebook"
        return {one.key: (ERROR if found else MISSING, why) for one in ones}
    try:
        cells = answers(found[0])
    except DamagedFile as error:
        return {one.key: (ERROR, str(error)) for one in ones}
    missing = {one.key: (MISSING, "no cell hands it to check") for one in ones}
    given = [(one.key, cells[one.key]) for one in ones if one.key in cells]
    return missing | run(stem, given, limit)


def answers(notebook: Path) -> dict[str, str]:
    """Return the cells that hand answers to ``check``, by the exercise; of several the last.

    Raises
    ------
    DamagedFile
        If it is no notebook.
    """
    found = {}
    with reading(notebook, "no notebook"):
        for cell in json.loads(notebook.read_text("utf-8"))["cells"]:
            about = cell["metadata"].get("nbgrader", {})
            if cell["cell_type"] != "code" or about.get("locked"):
                continue
            for key in re.findall(r"\bcheck\(\s*[\"']([\w-]+)[\"']", text(cell)):
                found[key] = text(cell)
    return found


def run(stem: str, cells: Sequence[tuple[str, str]], limit: float) -> dict[str, Outcome]:
    """Run answers in a process of their own, which ends with the first that takes too long.

    Those after it get another process; so does what follows an answer that ends its own.
    """
    found: dict[str, Outcome] = {}
    left = list(cells)
    while left:
        for key, outcome in _ran(stem, left, limit):
            found[key] = outcome
        left = [cell for cell in left if cell[0] not in found]
    return found


def _ran(
    stem: str, cells: Sequence[tuple[str, str]], limit: float
) -> Iterator[tuple[str, Outcome]]:
    """Yield outcomes until the cells end, or one of them ends the process."""
    apart = multiprocessing.get_context("spawn")
    here, there = apart.Pipe()
    worker = apart.Process(target=_work, args=(there, stem, list(cells)), daemon=True)
    worker.start()
    there.close()
    try:
        if _received(here, START_S) != READY:
            raise RuntimeError(f"the study cells of {stem} cannot be run here")
        for key, _ in cells:
            outcome = _received(here, limit)
            yield key, outcome
            if outcome == ENDED or outcome[0] == TOO_LONG:
                return
    finally:
        worker.kill()
        worker.join()
        here.close()


def _received(here: Connection, limit: float) -> Outcome:
    """Return what another process sends, or why it sends nothing."""
    try:
        return here.recv() if here.poll(limit) else (TOO_LONG, f"no end after {limit:g} s")
    except (EOFError, ConnectionError):
        return ENDED


def _work(there: Connection, stem: str, cells: Sequence[tuple[str, str]]) -> None:
    """Judge answers and send what comes of each; nothing that they print is shown."""
    os.environ["MPLBACKEND"] = "Agg"
    sys.stdout = sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - to the end
    names = vars(import_module(f"{BOOK}{stem}"))
    (sheet,) = {id(v): v for v in names.values() if isinstance(v, Sheet)}.values()
    there.send(READY)
    for key, source in cells:
        there.send(judged(names, sheet, key, source))


def judged(names: Mapping[str, Any], sheet: Sheet, key: str, source: str) -> Outcome:
    """Run an answer's cell and judge what it hands to ``check``."""
    given: dict[str, Any] = {}
    inside = {**names, "check": given.__setitem__, "__name__": "__main__"}
    try:
        exec(compile(source, f"answer of {key}", "exec"), inside)
        if key not in given:
            return MISSING, "its cell ran and handed nothing to check"
        return sheet[key].judge(given[key])
    except BaseException as error:  # whatever a student writes, the next one is graded
        return ERROR, f"{type(error).__name__}: {' '.join(str(error).split())}"
