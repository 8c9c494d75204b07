"""``robot-perception course`` and ``grade``: notebooks for a class, and what came of them."""

import csv
import sys
from pathlib import Path

import click


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
    from robot_perception.files import written
    from robot_perception.teaching.cells import folder
    from robot_perception.teaching.copies import asked, copied

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
@click.option("--limit", default=60.0, show_default=True, help="Seconds that one answer may take.")
@click.option("--write", "file", type=click.Path(path_type=Path), help="Write the table there.")
def grade(
    folders: tuple[Path, ...], stems: tuple[str, ...], limit: float, file: Path | None
) -> None:
    """Run the answers in notebooks of students, a folder DIR each, and write a table as CSV.

    Without --chapter, all chapters are graded of which some student has a notebook. Every exercise
    has a line for every student: what was not handed in is said to be missing, and counts nothing.
    Answers run with your rights: whom you do not trust, grade in a container.
    """
    from dataclasses import asdict, fields

    from robot_perception import chapters
    from robot_perception.files import written
    from robot_perception.teaching.grading import Mark, notebooks
    from robot_perception.teaching.grading import grade as marks

    if not stems:
        every = (*chapters.PRIMER, *chapters.CHAPTERS)
        stems = tuple(stem for stem in every if any(notebooks(d, stem) for d in folders))
    if not stems:
        raise click.ClickException("none of these folders has a notebook of a chapter")
    try:
        found = list(marks(folders, stems, limit))
    except (ValueError, RuntimeError, OSError) as error:
        raise click.ClickException(str(error)) from error
    names = [one.name for one in fields(Mark)]

    def table(target: object) -> None:
        lines = csv.DictWriter(target, names, lineterminator="\n")
        lines.writeheader()
        lines.writerows(map(asdict, found))

    if file is None:
        table(sys.stdout)
    else:
        with written(file) as beside, beside.open("w", encoding="utf-8", newline="") as target:
            table(target)
    for student in dict.fromkeys(one.student for one in found):
        own = [one for one in found if one.student == student]
        bad = [one.outcome for one in own if one.outcome not in ("right", "wrong")]
        left = ", ".join(f"{bad.count(kind)} {kind}" for kind in dict.fromkeys(bad))
        got, most = sum(one.points for one in own), sum(one.of for one in own)
        click.echo(f"{student}: {got} of {most} points{f'; {left}' if left else ''}", err=True)
