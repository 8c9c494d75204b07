"""The rules that every notebook of the book keeps.

Cells and functions are short where the library computes; notebooks with study cells, which compute
themselves, have the rules of ``tests/book/test_study_cells.py``.
"""

import ast
import re
import tomllib
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook, new_output

from tests.book.computing import CHECKED, is_study

STRIP = ".venv/bin/nbstripout --keep-id --keep-count"
BOOK = Path(__file__).parents[1] / "book"
NOTEBOOKS = sorted(BOOK.glob("*.ipynb"))
LONGEST_CELL = 10
LONGEST_FUNCTION = 5


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def path(request):
    return request.param


@pytest.fixture
def notebook(path):
    return nbformat.read(path, as_version=4)


def too_long(notebook, name):
    """Return a line for each cell that is too long, folded or not."""
    found = [(cell, code_lines(cell.source)) for cell in code_cells(notebook)]
    return [
        f"{name}, cell {cell.id} ({lines[0]}): {len(lines)} lines of code, at most {LONGEST_CELL}"
        for cell, lines in found
        if len(lines) > LONGEST_CELL
    ]


def wrong_outputs(notebook, name):
    """Return a line for each cell whose output is there and should not be, or the other way."""
    found = []
    for cell in code_cells(notebook):
        compared, where = cell.source.startswith(CHECKED), f"{name}, cell {cell.id}"
        if bool(cell.metadata.get("keep_output")) != compared:
            found.append(f'{where}: "{CHECKED}" and "keep_output": true go together')
        elif cell.outputs and not compared:
            found.append(f"{where} has outputs: clear them with `{STRIP} book/{name}`")
        elif compared and not (cell.outputs and cell.execution_count):  # nbval wants a count
            found.append(f"{where} has no output to compare: run the notebook and save it")
    return found


def code_cells(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def code_lines(source):
    return [line for line in source.splitlines() if line.strip() and line.strip() != CHECKED]


def test_the_book_has_notebooks():
    assert {"walls", "monobot", "scorecard"} <= {path.stem for path in NOTEBOOKS}


def test_notebooks_that_compute_are_modules_of_the_wheel():
    project = tomllib.loads((BOOK.parent / "pyproject.toml").read_text("utf-8"))
    listed = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    compute = {
        path.stem for path in NOTEBOOKS
        if any(map(is_study, code_cells(nbformat.read(path, as_version=4))))
    }  # fmt: skip
    assert {f"book/{stem}.ipynb" for stem in compute} == {*listed} - {"book/_data"}
    for stem in compute:
        assert listed[f"book/{stem}.ipynb"] == f"robot_perception/_book/{stem}.ipynb"


def test_cells_are_short(notebook, path):
    if any(map(is_study, code_cells(notebook))):
        return
    long = too_long(notebook, path.name)
    assert not long, "\n".join(long)


def test_functions_are_short(notebook):
    if any(map(is_study, code_cells(notebook))):
        return
    for cell in code_cells(notebook):
        for node in ast.walk(ast.parse(cell.source)):
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                length = node.end_lineno - node.lineno + 1
                assert length <= LONGEST_FUNCTION, f"{node.name} belongs in the library"


def test_only_compared_cells_keep_their_output(notebook, path):
    wrong = wrong_outputs(notebook, path.name)
    assert not wrong, "\n".join(wrong)


def test_what_is_wrong_with_a_cell_is_said_in_words():
    cells = [
        new_code_cell(source, id=name)
        for name, source in (
            ("long", "a = 1\n" * 11),
            ("kept", CHECKED),
            ("unrun", CHECKED),
            ("hero-show", "show(fig)"),
        )
    ]
    cells[1].metadata["keep_output"] = cells[2].metadata["keep_output"] = True
    cells[2].outputs = cells[3].outputs = [new_output("stream", text="old")]
    made = new_notebook(cells=cells)
    assert too_long(made, "a.ipynb") == ["a.ipynb, cell long (a = 1): 11 lines of code, at most 10"]
    assert wrong_outputs(made, "a.ipynb") == [
        "a.ipynb, cell kept has no output to compare: run the notebook and save it",
        "a.ipynb, cell unrun has no output to compare: run the notebook and save it",
        f"a.ipynb, cell hero-show has outputs: clear them with `{STRIP} book/a.ipynb`",
    ]


def test_cell_ids_are_unique_and_notebook_is_valid(notebook):
    nbformat.validate(notebook)
    ids = [cell.id for cell in notebook.cells]
    assert len(ids) == len(set(ids))


def test_the_first_cell_is_the_title(notebook):
    """What stands before it for one reader, front matter for instance, is text to another."""
    assert notebook.cells[0].source.startswith("# ")


def test_no_formula_gets_a_number_that_is_not_the_papers(notebook):
    """JupyterLab with the MyST extension numbers every formula between two dollars."""
    for cell in notebook.cells:
        assert cell.cell_type != "markdown" or "$$" not in cell.source, cell.id


FENCED = re.compile(r"^(`{3,}|:{3,}).*?^\1", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"^(\w+ = \w+[.\[(]|\w+\.\w+\(|(tell|bet|badges)\()", re.MULTILINE)


def test_no_code_stands_in_prose(notebook):
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            found = CODE.search(FENCED.sub("", cell.source))
            assert found is None, f"{cell.id}: {found[0]}"


def test_code_in_prose_is_found():
    for text in ('error = jacobians.evidence["turned"]', "# A\n\ntell(1)", "draw.hero(NOW)"):
        assert CODE.search(FENCED.sub("", text))
    assert not CODE.search(
        FENCED.sub("", "```python\nw = np.zeros(3)\n```\n\na = b is an equation.")
    )


def test_no_numbers_are_drawn_from_global_state(notebook):
    for cell in code_cells(notebook):
        for node in ast.walk(ast.parse(cell.source)):
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "np.random":
                assert node.attr in {"default_rng", "Generator", "SeedSequence"}, cell.id
