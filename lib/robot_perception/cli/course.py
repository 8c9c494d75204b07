"""``robot-perception course`` and ``grade``: notebooks for a class, and what came of them."""

import csv
import io
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import astuple, fields
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from robot_perception.teaching.course.grading import Mark

FORMULA = "=", "+", "-", "@", "\t", "\r"
"""Beginnings of cells that a spreadsheet would compute."""


@click.command()
@click.option("--student", type=click.Path(path_type=Path), help="Write copies without solutions.")
@click.option("--instructor", type=click.Path(path_type=Path), help="Write copies with solutions.")
@click.option("--chapter", "stems", multiple=True, help="Only this chapter; may be repeated.")
def course(student: Path | None, instructor: Path | None, stems: tuple[str, ...]) -> None:
    """Write copies of the notebooks for a class, with the metadata that nbgrader reads.

    A student's copy has the exercises, their points and cells to answer in; an instructor's has the
    solutions as well. A file that is there already is never written over.
    """
    import json

    from robot_perception import chapters
    from robot_perception.teaching.course.copies import asked, copied
    from studies.files import written
    from studies.keys.cells import folder

    if student is None and instructor is None:
        raise click.UsageError("say where to: --student DIR, --instructor DIR, or both")
    every = (*chapters.PRIMER, *chapters.CHAPTERS)
    unknown = sorted(set(stems) - set(every))
    if unknown:
        raise click.ClickException(f"no chapter {unknown[0]!r}; there are {', '.join(every)}")
    places = {False: student, True: instructor}
    try:
        made = {
            place / f"{stem}.ipynb": (stem, solutions)
            for solutions, place in places.items()
            if place is not None
            for stem in stems or every
        }
        there = [path for path in made if path.exists()]
        if there:
            raise FileExistsError(f"{there[0]} is there already; nothing was written")
        for path, (stem, solutions) in made.items():
            page = json.loads((folder() / path.name).read_text("utf-8"))
            path.parent.mkdir(parents=True, exist_ok=True)
            with written(path) as beside:
                text = json.dumps(copied(page, stem, solutions=solutions), indent=1)
                beside.write_text(f"{text}\n", "utf-8")
            points = sum(one.points for one in asked(page))
            click.echo(f"{path}: {points} points by check{', solutions' if solutions else ''}")
    except OSError as error:
        raise click.ClickException(str(error)) from error


@click.command()
@click.argument("folders", nargs=-1, required=True, metavar="DIR...",
                type=click.Path(exists=True, file_okay=False, path_type=Path))  # fmt: skip
@click.option("--chapter", "stems", multiple=True, help="This chapter; may be repeated.")
@click.option(
    "--limit",
    default=60.0,
    show_default=True,
    type=click.FloatRange(0, 86_400, min_open=True),
    help="Seconds that one answer may take.",
)
@click.option(
    "--memory",
    default=4.0,
    show_default=True,
    type=click.FloatRange(0, 1e6, min_open=True),
    help="Gigabytes that answers may take, where the system can bound them.",
)
@click.option("--write", "file", type=click.Path(path_type=Path), help="Write the table there.")
def grade(
    folders: tuple[Path, ...],
    stems: tuple[str, ...],
    limit: float,
    memory: float,
    file: Path | None,
) -> None:
    """Run the answers in notebooks of students, a folder DIR each, and write a table as CSV.

    Without --chapter, all chapters are graded of which some student has a notebook. Every exercise
    has a line for every student: what was not handed in is said to be missing, and counts nothing.
    The table grows by a line at a time, so that what is graded stays where a run is interrupted.
    Answers run with your rights: whom you do not trust, grade in a container.
    """
    from robot_perception import chapters
    from robot_perception.teaching.course.grading import grade as marks

    if not stems:
        every = (*chapters.PRIMER, *chapters.CHAPTERS)
        stems = tuple(stem for stem in every if any(_has(d, stem) for d in folders))
    if not stems:
        raise click.ClickException("none of these folders has a notebook of a chapter")
    found: dict[str, list[Mark]] = {}
    try:
        with ExitStack() as stack:
            for mark in marks(folders, stems, limit, int(memory * 1e9)):
                if not found:
                    table = None if file is None else stack.enter_context(file.open("wb"))
                    click.echo(_line(one.name for one in fields(mark)), table, nl=False)
                click.echo(_line(astuple(mark)), table, nl=False)
                found.setdefault(mark.student, []).append(mark)
    except (ValueError, RuntimeError, OSError) as error:
        raise click.ClickException(str(error)) from error
    for student, own in found.items():
        bad = [one.outcome for one in own if one.outcome not in ("right", "wrong")]
        left = ", ".join(f"{bad.count(kind)} {kind}" for kind in dict.fromkeys(bad))
        got, most = sum(one.points for one in own), sum(one.of for one in own)
        said = f"{_plain(student)}: {got} of {most} points{f'; {left}' if left else ''}"
        click.echo(said, err=True)


def _has(folder: Path, stem: str) -> bool:
    """Tell whether a student has a notebook of a chapter."""
    from robot_perception.teaching.course.grading import notebooks

    try:
        return bool(notebooks(folder, stem))
    except OSError:  # a folder that cannot be searched, which its lines will say
        return False


def _line(cells: Iterable[object]) -> bytes:
    """Return a line of a table: no cell is a formula, and every one is a text."""
    line = io.StringIO()
    texts = (f"'{cell}" if cell.startswith(FORMULA) else cell for cell in map(str, cells))
    csv.writer(line, lineterminator="\n").writerow(map(_plain, texts))
    return line.getvalue().encode("utf-8")


def _plain(text: str) -> str:
    """Return a text whose control characters and lone surrogates are written out."""
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text
    )
