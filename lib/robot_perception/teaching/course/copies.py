"""Copies of the notebooks for a course: a student's without solutions, an instructor's with them.

Both are made of the book's notebook. Cells to answer in, and cells that count the points, carry the
metadata that nbgrader reads.
"""

import ast
import copy
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from studies.keys.cells import Source, study_cells

BY_HAND, BY_CODE, PROSE = 1, 2, 2
"""Points of an exercise that asks for a number, a function, or some sentences."""

Cell = dict[str, Any]

_CHECK = re.compile(r"^check\(\s*\"([\w-]+)\",\s*(\w+)\s*\)", re.M)
_TITLE = re.compile(r"^### (.+)$", re.M)
_CODE = re.compile(r"\((?:by )?code\)$")
_SHEET = re.compile(r"\b(?:Exercise|Sheet)\(")
_UNSEEN = {"remove-input", "study"}
_SOLUTION = re.compile(
    r"\n*^(?P<fence>:{3,})\{dropdown\} (?P<kind>Solution|What a good answer mentions)\n"
    r".*?^(?P=fence)$",
    re.M | re.S,
)
_SENTENCES = "What a good answer mentions"
_YOURS = "*Your answer, in place of this line.*"


@dataclass(frozen=True)
class Asked:
    """An exercise that checks itself.

    Parameters
    ----------
    key
        Its key in the sheet.
    title
        The heading above it.
    name
        Of the variable that is checked.
    """

    key: str
    title: str
    name: str

    @property
    def points(self) -> int:
        """Points of a right answer."""
        return BY_CODE if _CODE.search(self.title) else BY_HAND


def text(cell: Mapping[str, Any]) -> str:
    """Return what stands in a cell: a notebook may hold a text or its lines."""
    return "".join(cell["source"])


def asked(notebook: Mapping[str, Any]) -> tuple[Asked, ...]:
    """Return the exercises of a notebook that check themselves, in their order."""
    found, title = [], ""
    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            title = [title, *_TITLE.findall(text(cell))][-1]
        elif match := _CHECK.search(text(cell)):
            found.append(Asked(match[1], title, match[2]))
    return tuple(found)


def copied(notebook: Mapping[str, Any], stem: str, *, solutions: bool) -> dict[str, Any]:
    """Return a copy of a chapter's notebook for a course.

    Parameters
    ----------
    notebook
        The book's own, as its file holds it.
    stem
        The chapter.
    solutions
        Whether it is the instructor's. A student's has neither solutions nor what a good answer
        mentions, and takes the sheet that checks answers from the package.
    """
    made = copy.deepcopy(dict(notebook))
    exercises = {one.key: one for one in asked(notebook)}
    made["cells"] = list(_cells(made["cells"], exercises, stem, solutions))
    return made


def _cells(
    cells: list[Cell], exercises: Mapping[str, Asked], stem: str, solutions: bool
) -> Iterator[Cell]:
    prose, secret = 0, _secret(cells)
    for place, cell in enumerate(cells):
        said = text(cell)
        match = _CHECK.search(said) if cell["cell_type"] == "code" else None
        if match:
            cell["metadata"]["nbgrader"] = _graded(match[1], solution=True)
            yield cell
            yield _counts(cell, exercises[match[1]])
        elif cell["cell_type"] == "code":
            if not solutions and cell["id"] in secret:
                cell["source"] = _taken(said, stem)
            yield cell
        else:
            key = _next_check(cells[place + 1 :])
            *answered, last = _parts(said)
            for part in answered:
                prose += 1
                yield _told(cell, part, f"-{prose}", solutions)
                yield _to_answer(f"{stem}-prose-{prose}")
            if key:
                points = counted(exercises[key].points)
                last = f"{last}\n\n*Exercise `{key}`, {points}.*"
            made = _told(cell, last, "", solutions)
            if made["source"]:
                yield made


def without_sheet(page: Path) -> list[Source]:
    """Return the study cells of a notebook without its sheet: what answers may stand on.

    Of the cells that a student's copy takes from the package there are the names that its text
    speaks of, such as data to use, and what these are made of.

    Raises
    ------
    DamagedFile
        If the file is no notebook.
    OSError
        If it cannot be read.
    """
    cells = json.loads(page.read_text("utf-8"))["cells"]
    secret = _secret(cells)
    told = " ".join(
        code
        for cell in cells
        if cell["cell_type"] == "markdown"
        for code in re.findall(r"`([^`]+)`", _SOLUTION.sub("", text(cell)))
    )
    wanted = set(re.findall(r"[^\W\d]\w*", told))
    kept = []
    for name, source in reversed(study_cells(page)):
        if name.rpartition("[")[2].removesuffix("]") in secret:
            source = _only(source, wanted)
        kept.append((name, source))
    return kept[::-1]


def _only(source: str, wanted: set[str]) -> str:
    """Return the statements that make wanted names; what they read is wanted from then on."""
    lines = []
    for node in reversed(ast.parse(source).body):
        alone = ast.Module([node], [])
        if wanted & {*_made(alone)} and not _SHEET.search(ast.unparse(node)):
            wanted |= {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
            lines.append(ast.unparse(node))
    return "\n".join(lines[::-1])


def _parts(said: str) -> list[str]:
    """Return the parts of a text; each but the last ends with what an answer mentions."""
    found = _SOLUTION.finditer(said)
    ends = [match.end() for match in found if match["kind"] == _SENTENCES]
    return [said[a:b] for a, b in zip([0, *ends], [*ends, None], strict=True)]


def _told(cell: Cell, said: str, number: str, solutions: bool) -> Cell:
    """Return a cell of text, without solutions if it is a student's."""
    said = said if solutions else _SOLUTION.sub("", said)
    return cell | {"id": f"{cell['id']}{number}", "source": said.strip("\n")}


def _next_check(cells: list[Cell]) -> str:
    """Return the key of the exercise whose answer stands in the very next cell, if it does."""
    match = _CHECK.search(text(cells[0])) if cells and cells[0]["cell_type"] == "code" else None
    return match[1] if match else ""


def counted(points: int) -> str:
    """Return a number of points in words."""
    return f"{points} point{'' if points == 1 else 's'}"


def _graded(name: str, *, solution: bool, points: int = 0) -> dict[str, Any]:
    """Return what nbgrader wants to know of a cell."""
    about = {
        "grade": points > 0,
        "grade_id": name.replace("_", "-"),
        "locked": not solution,
        "schema_version": 3,
        "solution": solution,
        "task": False,
    }
    return about | ({"points": points} if points else {})


def _counts(cell: Cell, one: Asked) -> Cell:
    """Return the locked cell that fails unless an answer is right."""
    about = _graded(f"{one.key}-points", solution=False, points=one.points)
    return {
        "cell_type": "code",
        "execution_count": None,
        "id": f"{cell['id']}-points",
        "metadata": {
            "jupyter": {"source_hidden": True},
            "nbgrader": about,
            "tags": ["raises-exception"],  # all cells can be run before all is answered
        },
        "outputs": [],
        "source": f'assert ": right." in repr(check("{one.key}", {one.name}))  # its points',
    }


def _to_answer(name: str) -> Cell:
    """Return the cell for an answer in sentences, which somebody reads."""
    return {
        "cell_type": "markdown",
        "id": f"{name}-answer",
        "metadata": {"nbgrader": _graded(name, solution=True, points=PROSE)},
        "source": f"{_YOURS} ({counted(PROSE)}, read by your instructor.)",
    }


def _secret(cells: list[Cell]) -> set[str]:
    """Return the cells that hold a sheet, and unseen ones with what a sheet reaches: by id."""
    unseen = {
        cell["id"]: ast.parse(text(cell))
        for cell in cells
        if cell["cell_type"] == "code" and set(cell["metadata"].get("tags", ())) >= _UNSEEN
    }
    found = {cell["id"] for cell in cells if cell["id"] in unseen and _SHEET.search(text(cell))}
    while True:
        trees = (unseen[name] for name in found)
        read = {n.id for tree in trees for n in ast.walk(tree) if isinstance(n, ast.Name)}
        more = {name for name, tree in unseen.items() if read & {*_made(tree)}} - found
        if not more:
            return found
        found |= more


def _made(tree: ast.Module) -> list[str]:
    """Return the names that the statements of a cell make."""
    names = []
    for node in tree.body:
        match node:
            case ast.FunctionDef() | ast.ClassDef():
                names.append(node.name)
            case ast.Import() | ast.ImportFrom():
                names += [alias.asname or alias.name for alias in node.names]
            case ast.Assign() | ast.AugAssign() | ast.AnnAssign():
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names += [
                    part.id for t in targets for part in ast.walk(t) if isinstance(part, ast.Name)
                ]
    return list(dict.fromkeys(names))


def _taken(source: str, stem: str) -> str:
    """Return what takes the names of a cell from the package instead: a sheet has the answers."""
    listed = "".join(f"    {name},\n" for name in _made(ast.parse(source)))
    return f"from robot_perception.book.{stem} import (\n{listed})"
