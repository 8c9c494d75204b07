"""The rules that every notebook of the book keeps."""

import ast
from pathlib import Path

import nbformat
import pytest

BOOK = Path(__file__).parents[1] / "book"
NOTEBOOKS = sorted(BOOK.glob("*.ipynb"))
CHECKED = "# NBVAL_CHECK_OUTPUT"
LONGEST_CELL = 10
LONGEST_FUNCTION = 5


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def notebook(request):
    return nbformat.read(request.param, as_version=4)


def code_cells(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def code_lines(source):
    return [line for line in source.splitlines() if line.strip() and line.strip() != CHECKED]


def test_the_book_has_notebooks():
    assert {"walls", "monobot", "scorecard"} <= {path.stem for path in NOTEBOOKS}


def test_cells_are_short(notebook):
    long = [c.id for c in code_cells(notebook) if len(code_lines(c.source)) > LONGEST_CELL]
    assert not long


def test_functions_are_short(notebook):
    for cell in code_cells(notebook):
        for node in ast.walk(ast.parse(cell.source)):
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                length = node.end_lineno - node.lineno + 1
                assert length <= LONGEST_FUNCTION, f"{node.name} belongs in the library"


def test_only_compared_cells_keep_their_output(notebook):
    for cell in code_cells(notebook):
        compared = cell.source.startswith(CHECKED)
        assert bool(cell.metadata.get("keep_output")) == compared, cell.id
        assert bool(cell.outputs) == compared, cell.id


def test_cell_ids_are_unique_and_notebook_is_valid(notebook):
    nbformat.validate(notebook)
    ids = [cell.id for cell in notebook.cells]
    assert len(ids) == len(set(ids))


def test_no_numbers_are_drawn_from_global_state(notebook):
    for cell in code_cells(notebook):
        for node in ast.walk(ast.parse(cell.source)):
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "np.random":
                assert node.attr in {"default_rng", "Generator", "SeedSequence"}, cell.id
