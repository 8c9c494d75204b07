"""Answers of students in batch: their own cells, run apart from each other, with a limit of time.

An answer is the cell that hands it to ``check``. It is run with the names of the book's own study
cells, not of the student's, in a process of its own for each notebook
(`teaching.course.answering`), where no sheet is. What it hands over comes here as JSON and is
judged here; of a function the judge's arguments go there, and what it returns comes back. What an
answer does there it does with the rights of whoever grades: whom you do not trust, grade in a
container.
"""

import contextlib
import json
import multiprocessing
import os
import re
import socket
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from robot_perception.project import BOOK
from robot_perception.teaching.course import answering
from robot_perception.teaching.course.copies import Asked, asked, text
from robot_perception.teaching.course.exercises import Exercise, Sheet
from robot_perception.teaching.course.messages import NO_VALUE, BrokenLine, Line, told
from studies.files import DamagedFile, reading
from studies.keys.cells import folder

RIGHT, WRONG, MISSING, ERROR, TOO_LONG = "right", "wrong", "missing", "error", "too long"
START_S = 300.0
"""Seconds in which a chapter's study cells must be ready."""
LONGEST = 160
"""Characters of what is said of an answer."""

LARGEST = 100_000_000
"""Bytes of a notebook that is read: with all its films a chapter has a quarter of that."""
MEMORY = 4 * 2**30
"""Bytes that answers may take beside the study cells of their chapter."""
ENDING_S = 2 * answering.CLEARING_S
APART = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
PRELOADED = [
    "robot_perception.teaching.course.answering",
    "studies.trials",
    "matplotlib.pyplot",
    "scipy.ndimage",
    "scipy.stats",
    "numba",
    "cv2",
]
"""Packages that take seconds to import, imported once for all notebooks where the system forks."""
_STARTED_WITH = {"MPLBACKEND": "Agg", "PYTHONSAFEPATH": "1"}  # no module of the current folder

Outcome = tuple[str, str]
"""Result of an answer, and the reply to it."""


@dataclass(frozen=True)
class Mark:
    """Mark of one exercise of one student.

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


def sheet_of(stem: str) -> Sheet:
    """Return the sheet of a chapter.

    Raises
    ------
    RuntimeError
        If the study cells cannot be run on this computer.
    """
    try:
        names = vars(import_module(f"{BOOK}{stem}"))
    except Exception as error:  # whatever is missing here
        why = f"the study cells of {stem} cannot be run here ({told(error)})"
        raise RuntimeError(why) from error
    (sheet,) = {id(v): v for v in names.values() if isinstance(v, Sheet)}.values()
    return sheet


def grade(
    students: Sequence[Path], stems: Sequence[str], limit: float, memory: int = MEMORY
) -> Iterator[Mark]:
    """Yield the marks of students: of each for all exercises of some chapters.

    Whatever a notebook makes fail is said in its own marks.

    Parameters
    ----------
    students
        A folder each; the notebooks may lie deeper in it.
    stems
        The chapters.
    limit
        Seconds that one answer may take, with its judgement.
    memory
        Bytes that answers may take beside the study cells, where the system bounds them.

    Raises
    ------
    ValueError
        If two students have one name, or the book has no such chapter.
    RuntimeError
        If the study cells of a chapter cannot be run on this computer.
    """
    names = [place.resolve().name for place in students]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"two folders are called {twice[0]}: whose marks are whose?")
    wanted = {stem: exercises(stem) for stem in stems}
    sheets = {stem: sheet_of(stem) for stem in stems}
    for name, place in zip(names, students, strict=True):
        for stem, ones in wanted.items():
            try:
                outcomes = _of_notebook(place, stem, ones, Rules(sheets[stem], limit, memory))
            except Exception as error:  # the notebooks after it are graded all the same
                outcomes = {one.key: (ERROR, told(error)) for one in ones}
            for one in ones:
                outcome, said = outcomes[one.key]
                points = one.points if outcome == RIGHT else 0
                short = said if len(said) <= LONGEST else f"{said[: LONGEST - 1]}…"
                yield Mark(name, stem, one.key, outcome, points, one.points, short)


def notebooks(place: Path, stem: str) -> list[Path]:
    """Return a student's notebooks of a chapter, without those that Jupyter keeps for itself."""
    found = sorted(place.rglob(f"{stem}.ipynb"))
    return [path for path in found if ".ipynb_checkpoints" not in path.parts]


@dataclass(frozen=True)
class Rules:
    """Rules by which the answers of a chapter are judged.

    Parameters
    ----------
    sheet
        The right answers.
    limit
        Seconds that one answer may take.
    memory
        Bytes that answers may take beside the study cells.
    """

    sheet: Sheet
    limit: float
    memory: int = MEMORY


def _of_notebook(place: Path, stem: str, ones: Sequence[Asked], rules: Rules) -> dict[str, Outcome]:
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
    return missing | run(stem, given, rules)


def answers(notebook: Path) -> dict[str, str]:
    """Return the cells that hand answers to ``check``, by the exercise; of several the last.

    Raises
    ------
    DamagedFile
        If it is no notebook.
    """
    found = {}
    with reading(notebook, "no notebook"):
        if not notebook.is_file():
            raise ValueError("no file")  # a pipe would never end
        if notebook.stat().st_size > LARGEST:
            raise ValueError(f"larger than {LARGEST} bytes")
        for cell in json.loads(notebook.read_text("utf-8"))["cells"]:
            about = cell["metadata"].get("nbgrader", {})
            if cell["cell_type"] != "code" or about.get("locked"):
                continue
            for key in re.findall(r"\bcheck\(\s*[\"']([\w-]+)[\"']", text(cell)):
                found[key] = text(cell)
    return found


def run(stem: str, cells: Sequence[tuple[str, str]], rules: Rules) -> dict[str, Outcome]:
    """Run answers in a process of their own, which ends with the first that takes too long.

    Those after it get another process; so does what follows an answer that ends its own.
    """
    found: dict[str, Outcome] = {}
    left = list(cells)
    while left:
        with apart(stem, rules.memory) as line:
            for key, source in left:
                try:
                    found[key] = judged(line, rules.sheet[key], key, source, rules.limit)
                except BrokenLine as broken:
                    late = TOO_LONG, f"no end after {rules.limit:g} s"
                    found[key] = late if broken.late else (ERROR, str(broken))
                    break
        left = [cell for cell in left if cell[0] not in found]
    return found


@contextlib.contextmanager
def apart(stem: str, memory: int = MEMORY) -> Iterator[Line]:
    """Give the line to a process of its own in which a chapter's study cells have run.

    Raises
    ------
    RuntimeError
        If they do not.
    """
    ours, theirs = socket.socketpair()
    with ours, theirs:
        worker = _started(theirs, stem, memory)
        theirs.close()
        line = Line(ours, answering.LONGEST)
        line.wait(START_S)
        try:
            try:
                line.receive()
            except BrokenLine as broken:
                raise RuntimeError(f"the study cells of {stem} did not run ({broken})") from broken
            yield line
        finally:
            ours.close()  # which tells the worker to end what was started there
            worker.join(ENDING_S if hasattr(os, "fork") else 0)
            worker.kill()
            worker.join()


def _started(end: socket.socket, stem: str, memory: int) -> multiprocessing.Process:
    """Start the process, whose environment is that of this one but for some variables."""
    context = multiprocessing.get_context(APART)
    context.set_forkserver_preload(PRELOADED)
    before = {name: os.environ.get(name) for name in _STARTED_WITH}
    os.environ.update(_STARTED_WITH)
    try:
        worker = context.Process(target=answering.work, args=(end, stem, memory), daemon=True)
        worker.start()
        return worker
    finally:
        for name, value in before.items():
            del os.environ[name]
            if value is not None:
                os.environ[name] = value


def judged(line: Line, exercise: Exercise, key: str, source: str, limit: float) -> Outcome:
    """Let an answer's cell be run, and judge what it hands to ``check``.

    Raises
    ------
    BrokenLine
        If it takes too long, ends its process, or sends what is no value.
    """
    line.wait(limit)
    match line.ask({"run": source, "key": key}):
        case {"value": data}:
            answer = line.decoded(data)
            with warnings.catch_warnings(action="ignore"):
                return exercise.judge(answer)
        case {"missing": True}:
            return MISSING, "its cell ran and handed nothing to check"
        case {"unsent": str(what)}:
            return WRONG, f"This answer cannot be checked ({what}). {exercise.hint}"
        case {"error": str(said)}:
            return ERROR, said
    raise BrokenLine(NO_VALUE)
